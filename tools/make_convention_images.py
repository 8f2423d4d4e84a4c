"""Draw the pictures of docs/conventions.md: one lettered sphere as each program stores it.

python tools/make_convention_images.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import spheremap as sm
from PIL import Image, ImageDraw, ImageFont

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images" / "conventions"
WIDTH, DETAIL = 160, 4
HUES = {"x": (205, 75, 65), "y": (75, 150, 70), "z": (70, 105, 200)}
LETTERS = 64  # texels a side of a painted label


def label(text: str) -> np.ndarray:
    """Return how much of each texel of a square the text covers."""
    image = Image.new("L", (LETTERS, LETTERS))
    font = ImageFont.load_default(size=LETTERS * 0.62)
    ImageDraw.Draw(image).text((LETTERS / 2, LETTERS / 2), text, 255, font, anchor="mm")
    return np.asarray(image, float) / 255


def sphere(d: np.ndarray, up: str) -> np.ndarray:
    """Return the color of directions: a hue for each axis, lines, and letters."""
    major = np.abs(d).argmax(-1)
    negative = np.take_along_axis(d, major[..., None], -1)[..., 0] < 0
    color = np.array([HUES[k] for k in "xyz"], float)[major]
    color = np.where(negative[..., None], color * 0.45 + 125, color)
    # Lines where faces of a cube meet, so that their shape shows.
    second = np.sort(np.abs(d), axis=-1)[..., 1]
    line = np.abs(d).max(-1) - second < 0.03
    color[line] = 250
    vertical = np.eye(3)["xyz".index(up[1])] * (1 if up[0] == "+" else -1)
    for k, axis in enumerate("xyz"):
        for sign in "+-":
            forward = np.eye(3)[k] * (1 if sign == "+" else -1)
            # Seen from inside with this up; for the poles, with a side axis as up.
            top = vertical if abs(forward @ vertical) < 0.5 else np.roll(np.abs(vertical), 1)
            right = np.cross(forward, top)
            depth = d @ forward
            with np.errstate(all="ignore"):
                x, y = d @ right / depth, d @ top / depth
            near = (depth > 0.3) & (np.abs(x) < 0.7) & (np.abs(y) < 0.7)
            i = np.minimum((x[near] / 1.4 + 0.5) * LETTERS, LETTERS - 1).astype(int)
            j = np.minimum((0.5 - y[near] / 1.4) * LETTERS, LETTERS - 1).astype(int)
            ink = label(sign + axis)[j, i][:, None]
            color[near] = color[near] * (1 - ink) + 255 * ink
    return color


def flat(row: dict) -> sm.Projection:
    """Return the convention as one image: a stack of faces side by side, or twelve in a block."""
    p = sm.projection(row["kind"], convention=row["name"])
    if p.faces == 1:
        return p
    layout = "4x3" if p.name == "healpix" else "strip"
    return sm.projection(p.name, convention=row["name"], layout=layout)


def picture(row: dict) -> Image.Image:
    p = flat(row)
    rows, columns = p.shape(2)
    width = 240 if columns > 2 * rows else 120 if columns == rows else WIDTH
    unit = max(1, round(width * 2 / columns if columns >= rows else 200 * 2 / rows))
    p = sm.projection(p.name, convention=p.convention, layout=p.layout, grid="centers")
    d = p.directions(tuple(n - n % DETAIL for n in p.shape(unit * DETAIL)))
    valid = ~np.isnan(d[..., 0])
    color = sphere(np.where(valid[..., None], d, 1.0), row["up"])
    color = np.where(valid[..., None], color, 255)
    h, w = color.shape[:2]
    small = color.reshape(h // DETAIL, DETAIL, w // DETAIL, DETAIL, 3).mean(axis=(1, 3))
    return Image.fromarray(np.rint(small).astype(np.uint8)).quantize(24, dither=Image.Dither.NONE)


def main() -> None:
    IMAGES.mkdir(parents=True, exist_ok=True)
    rows = sm.conventions()
    wanted = {f"{row['kind']}-{row['name']}.png": row for row in rows}
    for old in set(IMAGES.glob("*.png")) - {IMAGES / name for name in wanted}:
        old.unlink()
    for name, row in wanted.items():
        picture(row).save(IMAGES / name, optimize=True)


if __name__ == "__main__":
    main()
