"""Draw the pictures of docs/cameras.md.

python tools/make_camera_images.py
"""

from __future__ import annotations

import numpy as np
import spheremap as sm
from make_ball_images import below, beside, scene
from make_doc_images import save

ROWS = 160


def lenses() -> None:
    """A raw picture whose second lens is darker, cut, blended and matched."""
    lens = "dual_fisheye(fov=200)"
    sky = scene()
    raw = np.hstack(list(sm.convert(sky, "latlong", lens, size=(2, 320, 320))))
    raw[:, 320:] *= np.float32(0.72)
    cut, blended = (
        sm.cameras.stitch(raw, lens, "latlong", size=ROWS, blend=blend)
        for blend in ("nearest", "feather")
    )
    matched = sm.cameras.stitch(raw, lens, "latlong", size=ROWS, exposure="match")
    # Two by two, of the same size.
    save("stitch-lenses.png", below(beside(raw[::2, ::2], cut), beside(blended, matched)))


def masks() -> None:
    """Four views of a rig: dim where another view sees better, dark where the photographer is."""
    rig = sm.cameras.rig(200, fov=90)
    views = rig.convert(scene(), "latlong")
    best, without = (sm.cameras.masks(rig, photographer=angle) for angle in (None, 40.0))
    chosen = [0, *range(5, 8), len(rig) - 1]
    save(
        "rig-masks.png",
        beside(
            *[
                views[k] * np.where(without[k], 1, np.where(best[k], 0.1, 0.45))[..., None]
                for k in chosen
            ]
        ),
    )


if __name__ == "__main__":
    lenses()
    masks()
