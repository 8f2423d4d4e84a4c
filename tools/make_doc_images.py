"""Draw the pictures of docs/images: one sky in every projection, shading right and wrong, mips.

python tools/make_doc_images.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import spheremap as sm
from spheremap import io
from spheremap.cli import files
from spheremap.cli.sky import radiance
from spheremap.map.flat import flat

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"


def save(name: str, image: np.ndarray) -> None:
    """Write an image with values in [0, 1]."""
    io.write(IMAGES / name, np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8))


def shrink(image: np.ndarray, factor: int) -> np.ndarray:
    """Average blocks of factor × factor pixels; transparent ones count for their share only."""
    if image.shape[-1] == 4:
        color = shrink(image[..., :3] * image[..., 3:], factor)
        alpha = shrink(image[..., 3:], factor)
        return np.concatenate([color / np.maximum(alpha, 1e-9), alpha], axis=-1)
    h, w, channels = image.shape
    return image.reshape(h // factor, factor, w // factor, factor, channels).mean(axis=(1, 3))


def sky(d: np.ndarray) -> np.ndarray:
    """Return the demo's sky as a screen shows it."""
    return io.tonemap(radiance(d), exposure=0.7) / np.float32(255)


# --- One picture for each projection


def picture(name: str, height: int, detail: int = 4) -> np.ndarray:
    """Return the sky in a projection as an RGBA image; what is not valid is transparent."""
    p = flat(name)
    rows, columns = p.shape(files.size_of_height(p, height))
    d = p.directions((rows * detail, columns * detail))
    valid = ~np.isnan(d[..., 0])
    color = sky(np.where(valid[..., None], d, 1.0))
    return shrink(np.concatenate([color, valid[..., None]], axis=-1), detail)


def projections() -> None:
    names = sm.projections()
    for name in names:
        save(f"projection-{name}.png", picture(name, 192))


# What a newcomer knows, in the words that they know it by.
KNOWN = {
    "latlong": "360° photos, HDRIs",
    "cube": "skyboxes, reflections",
    "perspective": "views, crops",
    "angular": "light probes",
    "sphere": "mirror balls",
    "dual_fisheye": "360 cameras",
    "stereographic": "little planets",
    "octahedral": "normals, probes",
    "dual_paraboloid": "reflections",
    "matcap": "sculpting",
    "mollweide": "whole skies, world maps",
    "healpix": "cosmology, sky surveys",
}


def known() -> None:
    """Draw the maps that most people have met, each with its name and what it is for."""
    columns, (width, height) = 4, (4.0, 2.25)
    rows = -(-len(KNOWN) // columns)
    figure, places = plt.subplots(
        rows, columns, figsize=(columns * width / 1.6, rows * height / 1.6), dpi=110
    )
    for place, (name, use) in zip(places.flat, KNOWN.items(), strict=True):
        place.imshow(picture(name, 288))
        place.set_title(name, fontsize=11, family="monospace", pad=4)
        place.text(0.5, -0.04, use, transform=place.transAxes, ha="center", va="top", fontsize=9)
        place.set_axis_off()
    figure.tight_layout(pad=0.4, h_pad=1.1, w_pad=0.4)
    figure.savefig(IMAGES / "projections.png", facecolor="white")
    plt.close(figure)


# --- A small rasterizer: which triangle a pixel shows, and where in it


def grid(columns: int, rows: int) -> np.ndarray:
    """Return the triangles of a (rows + 1) × (columns + 1) net of vertices."""
    i = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    j = i + columns + 1
    return np.concatenate(
        [np.stack([i, j, i + 1], axis=1), np.stack([i + 1, j, j + 1], axis=1)], axis=0
    )


def ball(center: np.ndarray, columns: int):
    rows = columns // 2
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij"
    )
    n = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1)
    n = n.reshape(-1, 3)
    return center + n, n, grid(columns, rows)


def torus(center: np.ndarray, columns: int):
    columns, rows = columns * 3 // 2, columns * 3 // 4
    a, b = np.meshgrid(
        np.linspace(0, 2 * np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij"
    )
    ring = np.stack([np.sin(b), np.cos(b), np.zeros_like(b)], axis=-1)
    n = ring * np.cos(a)[..., None] + np.array([0, 0, 1.0]) * np.sin(a)[..., None]
    n, ring = n.reshape(-1, 3), ring.reshape(-1, 3)
    turn = sm.rotation(25, -35, 0)
    return center + (0.72 * ring + 0.36 * n) @ turn.T, n @ turn.T, grid(columns, rows)


class View:
    """Two objects seen from `eye`: for every pixel a triangle and the weights of its corners."""

    def __init__(self, eye: np.ndarray, height: int = 260, net: int = 20, detail: int = 3) -> None:
        self.detail, self.eye = detail, eye
        forward = -eye / np.linalg.norm(eye)
        right = np.cross(forward, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        self.frame = np.stack(
            [right, np.cross(right, forward), -forward]
        )  # rows: x, y, z of the eye
        meshes = (ball(-1.15 * right, net), torus(1.15 * right, net))
        offsets = np.cumsum([0] + [len(m[0]) for m in meshes])
        self.position = np.concatenate([m[0] for m in meshes])
        self.normal = np.concatenate([m[1] for m in meshes])
        self.triangles = np.concatenate([m[2] + o for m, o in zip(meshes, offsets, strict=False)])

        h, w = height * detail, 2 * height * detail
        seen = (self.position - eye) @ self.frame.T
        depth = -seen[:, 2]
        zoom = h / 2 * np.linalg.norm(eye) / 1.3
        sx, sy = w / 2 + zoom * seen[:, 0] / depth, h / 2 - zoom * seen[:, 1] / depth
        nearest = np.full((h, w), np.inf)
        self.which = np.full((h, w), -1)
        self.weights = np.zeros((h, w, 3))
        for index, corners in enumerate(self.triangles):
            x, y, d = sx[corners], sy[corners], depth[corners]
            area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
            if abs(area) < 1e-9:
                continue
            left, top = max(int(x.min()), 0), max(int(y.min()), 0)
            px, py = np.meshgrid(
                np.arange(left, min(int(x.max()) + 2, w)) + 0.5,
                np.arange(top, min(int(y.max()) + 2, h)) + 0.5,
            )
            b1 = ((px - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (py - y[0])) / area
            b2 = ((x[1] - x[0]) * (py - y[0]) - (px - x[0]) * (y[1] - y[0])) / area
            b = np.stack([1 - b1 - b2, b1, b2], axis=-1) / d  # linear in the picture
            at = 1 / b.sum(axis=-1)
            here = (slice(top, top + px.shape[0]), slice(left, left + px.shape[1]))
            front = (b >= -1e-12).all(axis=-1) & (at < nearest[here])
            nearest[here][front] = at[front]
            self.which[here][front] = index
            self.weights[here][front] = (b * at[..., None])[front]
        self.hit = self.which >= 0

    def interpolate(self, values: np.ndarray) -> np.ndarray:
        """Return what a value at each vertex is in the pixels that show an object."""
        corners = values[self.triangles[self.which[self.hit]]]
        return (corners * self.weights[self.hit][..., None]).sum(axis=1)

    def finish(self, color: np.ndarray) -> np.ndarray:
        image = np.ones((*self.hit.shape, 3))
        image[self.hit] = color
        return shrink(image, self.detail)


def reflected(eye: np.ndarray, position: np.ndarray, normal: np.ndarray) -> np.ndarray:
    view = eye - position
    view /= np.linalg.norm(view, axis=-1, keepdims=True)
    return sm.reflect(view, normal)


def pair(view: View, image: np.ndarray, name: str, at_vertices: np.ndarray, at_pixels: np.ndarray):
    """Return the right picture (a look-up per pixel) beside the wrong one (uv across triangles)."""
    right = sm.sample(image, at_pixels, name)
    uv = view.interpolate(sm.encode(at_vertices, name))
    wrong = sm.sample(image, sm.decode(uv, name), name)
    gap = np.ones((view.finish(right).shape[0], 8, 3))
    return np.concatenate([view.finish(right), gap, view.finish(wrong)], axis=1)


def tinted_sky(d: np.ndarray) -> np.ndarray:
    """Return the sky, redder to the east and bluer to the south, so that places tell apart."""
    x, _, z = np.moveaxis(d, -1, 0)
    return sky(d) * (1 + 0.6 * np.stack([x, 0 * x, z], axis=-1)) / 1.3


def ball_material(n: np.ndarray) -> np.ndarray:
    """Return the colors of a made-up lit material as seen on a ball, for its matcap."""
    light = np.array([-0.5, 0.65, 0.57])
    lit = np.clip(n @ light, 0, 1)[..., None]
    half = light + np.array([0, 0, 1.0])
    shine = np.clip(n @ (half / np.linalg.norm(half)), 0, 1)[..., None] ** 60
    rim = (1 - np.clip(n[..., 2:], 0, 1)) ** 3
    color = np.array([0.16, 0.06, 0.05]) + lit * np.array([0.75, 0.3, 0.2]) + shine * 0.8
    return np.clip(color + rim * np.array([0.1, 0.2, 0.4]), 0, 1)


def shading() -> None:
    def material(name: str, size: int, color) -> np.ndarray:
        d = sm.directions(name, size)
        return color(np.nan_to_num(d, nan=0.5))

    front = View(np.array([0.6, 0.9, 6.0]))
    behind = View(np.array([1.6, 0.7, -5.8]))

    for view, name, size, file in (
        (front, "latlong", 512, "shading-latlong.png"),
        (behind, "sphere", 1024, "shading-sphere.png"),
    ):
        at_vertices = reflected(view.eye, view.position, view.normal)
        at_pixels = reflected(
            view.eye, view.interpolate(view.position), view.interpolate(view.normal)
        )
        environment = material(name, size, tinted_sky)
        save(file, pair(view, environment, name, at_vertices, at_pixels))

    front = View(front.eye, net=10)
    at_vertices = front.normal @ front.frame.T
    at_pixels = front.interpolate(front.normal) @ front.frame.T
    for n in (at_vertices, at_pixels):  # in perspective a normal may point just away from the eye
        n[..., 2] = np.maximum(n[..., 2], 0)
    image = material("matcap", 512, ball_material)
    save("shading-matcap.png", pair(front, image, "matcap", at_vertices, at_pixels))


def checkered_sky(d: np.ndarray) -> np.ndarray:
    """Return the tinted sky with squares of 3.75 degrees, finer than a pixel of a mirror sees."""
    lon, lat = np.arctan2(d[..., 0], -d[..., 2]), np.arcsin(np.clip(d[..., 1], -1, 1))
    squares = np.floor(lon * 48 / np.pi) + np.floor(lat * 48 / np.pi)
    return tinted_sky(d) * (0.35 + 0.65 * (squares % 2))[..., None]


def mips() -> None:
    # One ray a pixel: nothing but the lookups takes the mean of anything.
    view = View(np.array([0.6, 0.9, 6.0]), net=64, detail=1)
    environment = checkered_sky(sm.directions("latlong", 1024))
    places = []
    for values in (view.position, view.normal):
        whole = np.full((*view.hit.shape, 3), np.nan)
        whole[view.hit] = view.interpolate(values)
        places.append(whole)
    color = [
        sm.light.shade_environment(*places, view.eye, environment, mipmaps=mipmaps)[view.hit]
        for mipmaps in (False, True)
    ]
    without, with_mips = (view.finish(each) for each in color)
    gap = np.ones((without.shape[0], 8, 3))
    save("shading-mips.png", np.concatenate([without, gap, with_mips], axis=1))


# --- What a viewer shows


def stills() -> None:
    """Draw a perspective, a little planet in stops of luminance, and a flat map."""
    environment = radiance(sm.directions("latlong", 1024)).astype(np.float32)
    viewer = sm.view(environment, "latlong", direction=[0.5, 0.1, -0.8], fov=80, exposure=0.7)
    height, gap = 180, 8
    shown = [viewer.snapshot((height, 320))]
    viewer.direction, viewer.fov, viewer.false_color = (0, -1, 0), 280, True
    shown.append(viewer.snapshot((height, height)))
    viewer.direction, viewer.false_color, viewer.screen = (0, 0, -1), False, "mollweide"
    shown.append(viewer.snapshot((height, 2 * height)))
    between = np.full((height, gap, 3), 255, np.uint8)
    rows = [each for picture in shown for each in (picture, between)]
    io.write(IMAGES / "view.png", np.concatenate(rows[:-1], axis=1))


# --- What sm.plot draws


def figures() -> None:
    environment = radiance(sm.directions("latlong", 512)).astype(np.float32)
    figure = plt.figure(figsize=(11, 6.4), layout="constrained")
    upper, lower = figure.subfigures(2, 1)
    left, right = upper.subplots(1, 2, width_ratios=(2, 1.5))
    sm.plot.lights(environment, "latlong", count=32, ax=left, labels=False)
    left.set_title("lights", fontsize=9)
    sm.plot.sh(sm.sh.project(environment, "latlong", order=3), ax=right)
    right.set_title("sh", fontsize=9)
    left, right = lower.subplots(1, 2, width_ratios=(1.2, 1))
    sm.plot.packing_error("oct10", "latlong", ax=left, labels=False)
    sm.plot.footprints("latlong", "cube", image=environment, ax=right, labels=False)
    right.set_title("footprints", fontsize=9)
    figure.savefig(IMAGES / "plot.png", dpi=90, facecolor="white")
    plt.close(figure)

    blender = sm.convert(environment, "latlong", "latlong:blender")
    axes = sm.plot.compare("latlong:blender", "cube:opengl", image=blender, exposure=0.7)
    drawn = axes[0].get_figure(root=True)
    drawn.savefig(IMAGES / "plot-compare.png", dpi=80, facecolor="white")
    plt.close(drawn)


if __name__ == "__main__":
    IMAGES.mkdir(parents=True, exist_ok=True)
    projections()
    known()
    shading()
    mips()
    stills()
    figures()
