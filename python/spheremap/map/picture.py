"""A map as a small picture with its axes named, for notebooks: SVG, by NumPy alone."""

from __future__ import annotations

import base64
import html
import math
import struct
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from .pixels import directions_to_pixels
from .variants import axes_matrix

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["colors", "describe", "figure"]

# Pixels of a picture, its longest side without gaps, and what lies between faces.
_AREA, _LONGEST, _GAP = 160 * 320, 540, 4
# Degrees between the lines of the graticule.
_STEP = 30
_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
# A place, the radius of its dot in pixels, and its color.
Dot = tuple["NDArray[np.float64]", float, str]


def figure(p: Projection, caption: Iterable[str], dots: Iterable[Dot] = ()) -> str:
    """Return HTML: the sphere as a map stores it, directions with a dot, and lines of text."""
    lines = "".join(f"<div>{html.escape(text)}</div>" for text in caption)
    shape = _shape(p)
    if shape is None:
        return f"<div>{lines}</div>"
    side = shape[-1] + _GAP
    height, width = shape[-2], (shape[0] * side - _GAP if len(shape) == 3 else shape[-1])
    data = base64.b64encode(_png(_side_by_side(colors(p, shape)))).decode("ascii")
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" role="img">',
        f"<title>{html.escape(repr(p))}</title>",
        f'<image width="{width}" height="{height}" href="data:image/png;base64,{data}"/>',
    ]

    def places(d: Any) -> NDArray[np.float64]:
        at = np.atleast_2d(directions_to_pixels(np.asarray(d, np.float64), p, shape))
        if at.shape[1] == 3:
            at[:, 0] += at[:, 2] * side
        return np.asarray(at[:, :2], np.float64)

    for d, radius, color in dots:
        for x, y in places(d):
            if math.isfinite(x) and math.isfinite(y):
                parts.append(
                    f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{color}" '
                    'stroke="#000" stroke-width="0.7"/>'
                )
    units = np.concatenate([(e, -e) for e in np.eye(3)]).reshape(6, 3)
    for name, (x, y) in zip(_AXES, places(units), strict=True):
        if math.isfinite(x) and math.isfinite(y):
            # What lies on an edge is named inside.
            x, y = min(max(x, 9), width - 9), min(max(y, 7), height - 7)
            parts.append(
                f'<text x="{x:.1f}" y="{y + 4:.1f}" font-family="sans-serif" font-size="12" '
                'text-anchor="middle" fill="#000" stroke="#fff" stroke-width="2.5" '
                f'paint-order="stroke">{name.replace("-", "−")}</text>'
            )
    parts.append("</svg>")
    return f"<div>{''.join(parts)}{lines}</div>"


def describe(p: Projection) -> str:
    """Return a map as HTML: its picture, what makes it again, and how it lies."""
    right, down, forward = p.axes.split()
    about = f"{p.title}: {right} right, {down} down, {forward} into the middle"
    about += ", mirrored as seen from inside" if p.mirrored else ""
    covered = p.covered_solid_angle / (4 * math.pi)
    return figure(p, [repr(p), f"{about}; {p.coverage}, {covered:.0%} of the directions"])


def _shape(p: Projection) -> tuple[int, ...] | None:
    """Return a shape that fits in the picture, or None for a map that is all but a line."""
    try:
        tried = p.shape(64)
    except ValueError:
        return None
    height, width = tried[-2], tried[-1] * (tried[0] if len(tried) == 3 else 1)
    scale = min(math.sqrt(_AREA / (height * width)), _LONGEST / max(height, width))
    # An image of a texel or two says nothing, however long it gets.
    shape = p.shape(max(8, int(64 * scale)))
    return shape if math.prod(shape) <= 16 * _AREA else None


def colors(p: Projection, shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return the sphere in colors of its directions, with a graticule, as RGBA."""
    d = p.directions(shape)
    seen = np.isfinite(d[..., 0])
    d = np.nan_to_num(d)
    rgba = np.zeros((*shape, 4), np.uint8)
    shade = 0.68 + 0.26 * d
    right, up, ahead = axes_matrix(p.world)
    latitude = np.degrees(np.arcsin(np.clip(d @ up, -1, 1)))
    longitude = np.degrees(np.arctan2(d @ right, d @ ahead))
    # The lines are where neighbors lie in different cells.
    line = np.zeros(shape, bool)
    for cell in (np.floor(latitude / _STEP), np.floor(longitude / _STEP)):
        line[..., :-1] |= cell[..., :-1] != cell[..., 1:]
        line[..., :-1, :] |= cell[..., :-1, :] != cell[..., 1:, :]
    shade[line] *= 0.75
    # In steps: a third of the bytes, and nobody sees them.
    rgba[..., :3] = 6 * np.rint(255 / 6 * shade)
    rgba[..., 3] = 255
    rgba[~seen] = 0
    return rgba


def _side_by_side(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an array of faces as one image, with gaps in which nothing is."""
    if image.ndim == 3:
        return image
    apart = np.pad(image, ((0, 0), (0, 0), (0, _GAP), (0, 0)))
    return np.concatenate(list(apart), axis=1)[:, :-_GAP]


def _png(rgba: NDArray[np.uint8]) -> bytes:
    """Return an image as a PNG file. W3C, Portable Network Graphics (Third Edition), 2025."""
    height, width = rgba.shape[:2]
    rows = np.zeros((height, 1 + 4 * width), np.uint8)
    # Filter 1 keeps differences to the left: smooth pictures get small.
    rows[:, 0] = 1
    rows[:, 1:5] = rgba[:, 0]
    rows[:, 5:] = (rgba[:, 1:] - rgba[:, :-1]).reshape(height, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    body = zlib.compress(rows.tobytes())
    parts = (chunk(b"IHDR", head), chunk(b"IDAT", body), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
