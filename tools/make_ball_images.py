"""Draw the pictures of docs/mirror-balls.md.

python tools/make_ball_images.py
"""

from __future__ import annotations

import numpy as np
import spheremap as sm
from make_doc_images import View, save, sky, tinted_sky
from spheremap import io

ROWS = 200
CAMERA = dict(size=400, fov=24, distance=5.6)


def scene() -> np.ndarray:
    """Return the sky with a grid of 30°, so that what is bent shows."""
    d = sm.directions("latlong", 512)
    u, v = np.moveaxis(sm.encode(d, "latlong"), -1, 0)
    lines = (np.abs((u * 12 + 0.5) % 1 - 0.5) < 0.02) | (np.abs((v * 6 + 0.5) % 1 - 0.5) < 0.012)
    return np.where(lines[..., None], 0.95, tinted_sky(d)).astype(np.float32)


def beside(*images: np.ndarray, gap: int = 8) -> np.ndarray:
    white = np.ones((images[0].shape[0], gap, 3))
    parts = [p for image in images for p in (np.nan_to_num(image)[..., :3], white)]
    return np.concatenate(parts[:-1], axis=1)


def below(*images: np.ndarray, gap: int = 8) -> np.ndarray:
    turned = [np.swapaxes(np.nan_to_num(i), 0, 1) for i in images]
    return np.swapaxes(beside(*turned, gap=gap), 0, 1)


def balls() -> None:
    environment, turn = scene(), sm.rotation(110, 8, 0)
    a = sm.ball.render(environment, **CAMERA)
    b = sm.ball.render(environment, pose=turn, **CAMERA) * np.float32(0.8)
    save("ball-photos.png", beside(a, b))
    rim = sm.ball.unwrap(a, center=(200, 200), fov=24, distance=5.6, size=4).ball
    exact = sm.ball.unwrap(a, center=rim.center, radius=rim.radius, fov=24, size=ROWS)
    ideal = sm.ball.unwrap(a, center=rim.center, radius=rim.radius, size=ROWS, distance=np.inf)
    save("ball-unwrapped.png", below(beside(exact.image, ideal.image)))
    merged = sm.ball.merge([a, b], balls=[rim, rim], fov=24, size=ROWS)
    share = np.repeat(merged.weights[0][..., None], 3, axis=-1)
    save("ball-merged.png", beside(merged.image, share))


def shading() -> None:
    """Two cameras: what a MatCap shows stays in the picture, an environment in the world."""
    light = sm.directions("latlong", 256)
    environment = sky(light).astype(np.float32) ** 2.2
    lamp = np.clip((light @ [0.55, 0.6, 0.58] - 0.985) / 0.005, 0, 1)
    environment += 6 * lamp[..., None].astype(np.float32)
    baked_for = View(np.array([0.6, 0.9, 6.0]))
    pose = baked_for.frame.T
    rows = []
    caps = [
        sm.light.bake_matcap(environment, material="mirror", size=256, pose=pose),
        sm.light.bake_matcap(environment, material="rough", size=64, roughness=0.5, pose=pose),
    ]
    for eye in (baked_for.eye, np.array([5.2, 1.8, 2.6])):
        view = View(eye)
        place, normal = view.interpolate(view.position), view.interpolate(view.normal)
        shaded = [
            sm.light.shade_matcap(normal, cap, positions=place, eye=eye, pose=view.frame.T)
            for cap in caps
        ]
        shaded.append(sm.light.shade_environment(place, normal, eye, environment))
        rows.append(
            beside(*(view.finish(io.tonemap(np.nan_to_num(c)[None])[0] / 255) for c in shaded))
        )
    save("ball-shading.png", below(*rows))


if __name__ == "__main__":
    balls()
    shading()
