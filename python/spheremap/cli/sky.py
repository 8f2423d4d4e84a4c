"""An analytic HDR sky to try every projection on: a sun, a direction grid, readable labels.

It is a function of direction alone. Whatever is wrong in a picture of it (mirrored text, a sun
that is not round, a line that breaks at a seam) was done by the way to the picture.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import spheremap as sm
from spheremap._srgb import decoded

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SUN_AZIMUTH, _SUN_ELEVATION = np.radians(38.0), np.radians(38.0)
SUN = np.array(
    [
        np.sin(_SUN_AZIMUTH) * np.cos(_SUN_ELEVATION),
        np.sin(_SUN_ELEVATION),
        -np.cos(_SUN_AZIMUTH) * np.cos(_SUN_ELEVATION),
    ]
)
SUN_RADIUS = 2.0  # degrees; the true one, 0.27, would be lost on a contact sheet


class Label(NamedTuple):
    """A text on the sphere: where it stands, which way its top points, its color."""

    text: str
    forward: tuple[int, int, int]
    up: tuple[int, int, int]
    color: str


# Overhead and underfoot the top is what a head that tilts up or down from -z sees on top.
LABELS = (
    Label("+x", (1, 0, 0), (0, 1, 0), "#a02020"),
    Label("-x", (-1, 0, 0), (0, 1, 0), "#a02020"),
    Label("+y up", (0, 1, 0), (0, 0, 1), "#1c7a1c"),
    Label("-y down", (0, -1, 0), (0, 0, -1), "#1c7a1c"),
    Label("+z", (0, 0, 1), (0, 1, 0), "#2040b0"),
    Label("-z", (0, 0, -1), (0, 1, 0), "#2040b0"),
)
_TILE = (0.57, 0.19)  # half width and half height, as tangents
_TILE_PIXELS = (480, 160)


def radiance(directions: NDArray[Any]) -> NDArray[np.float32]:
    """Return the light from unit directions (..., 3) as linear RGB (..., 3)."""
    d = np.asarray(directions, dtype=np.float32)
    lonlat = sm.directions_to_lonlat(d)
    azimuth, latitude = lonlat[..., 0], lonlat[..., 1]

    light = _sky(d[..., 1])
    light += _sun(d)
    line = _lines(latitude, azimuth)[..., np.newaxis]
    light += line * (np.float32(0.02) + light * np.float32(0.35) - light)
    for label in LABELS:
        _paint(light, d, label)
    return light


def _sky(height: NDArray[np.float32]) -> NDArray[np.float32]:
    above = np.sqrt(np.clip(height, 0, 1))[..., np.newaxis]
    below = np.sqrt(np.clip(-height, 0, 1))[..., np.newaxis]
    sky = _mix(above, (0.80, 0.95, 1.10), (0.07, 0.19, 0.55))
    ground = _mix(below, (0.36, 0.30, 0.23), (0.10, 0.085, 0.07))
    horizon = np.clip(height / np.float32(0.02) + np.float32(0.5), 0, 1)[..., np.newaxis]
    return np.asarray(ground + (sky - ground) * horizon, dtype=np.float32)


def _sun(d: NDArray[np.float32]) -> NDArray[np.float32]:
    cosine = d @ SUN.astype(np.float32)
    # From the sine near the center: arccos of a float32 cosine is too coarse for a round disk.
    sine = np.linalg.norm(np.cross(d, SUN.astype(np.float32)), axis=-1)
    angle = np.degrees(np.arctan2(sine, cosine))[..., np.newaxis]
    disk = np.clip((SUN_RADIUS - angle) / 0.3 + 0.5, 0, 1)
    glow = np.exp(-angle / 9.0)
    return np.asarray(
        disk * np.array([600, 520, 400]) + glow * np.array([0.9, 0.7, 0.45]), dtype=np.float32
    )


def _lines(latitude: NDArray[np.float32], azimuth: NDArray[np.float32]) -> NDArray[np.float32]:
    strength = np.zeros_like(latitude)
    shrink = np.cos(np.radians(latitude))
    # (every, half width, up to which latitude the meridians go), in degrees
    for every, half, top in ((15, 0.15, 60), (30, 0.30, 75), (90, 0.45, 90)):
        parallel = np.abs(latitude - np.rint(latitude / every) * every)
        meridian = np.abs(azimuth - np.rint(azimuth / every) * every) * shrink
        meridian = np.where(np.abs(latitude) <= top, meridian, 90)
        distance = np.minimum(parallel, meridian)
        np.maximum(strength, np.clip((half - distance) / 0.2 + 0.5, 0, 1), out=strength)
    return np.asarray(strength, dtype=np.float32)


def _paint(light: NDArray[np.float32], d: NDArray[np.float32], label: Label) -> None:
    """Lay the tile of a label over the light, by the gnomonic projection about its middle."""
    forward, up = np.array(label.forward, np.float32), np.array(label.up, np.float32)
    right = np.cross(forward, up)  # seen from inside the sphere
    near = np.nonzero(d @ forward > 0.8)
    toward = d[near]
    depth = toward @ forward
    s, t = toward @ right / depth, toward @ up / depth

    tile = _tile(label.text, label.color)
    rows, columns = tile.shape[:2]
    column = (s / _TILE[0] + 1) * columns / 2 - 0.5
    row = (1 - t / _TILE[1]) * rows / 2 - 0.5
    on = (column >= 0) & (column <= columns - 1.001) & (row >= 0) & (row <= rows - 1.001)
    where = tuple(index[on] for index in near)
    texel = _bilinear(tile, row[on], column[on])
    alpha = texel[..., 3:]
    light[where] += alpha * (texel[..., :3] - light[where])


def _bilinear(
    tile: NDArray[np.float32], row: NDArray[np.float32], column: NDArray[np.float32]
) -> NDArray[np.float32]:
    i, j = row.astype(np.intp), column.astype(np.intp)
    a, b = (row - i)[:, np.newaxis], (column - j)[:, np.newaxis]
    upper = tile[i, j] * (1 - b) + tile[i, j + 1] * b
    lower = tile[i + 1, j] * (1 - b) + tile[i + 1, j + 1] * b
    return np.asarray(upper * (1 - a) + lower * a, dtype=np.float32)


@cache
def _tile(text: str, color: str) -> NDArray[np.float32]:
    """Return a label as linear RGBA: white letters on a plate."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import to_rgb
    from matplotlib.figure import Figure

    columns, rows = _TILE_PIXELS
    figure = Figure(figsize=(columns / 100, rows / 100), dpi=100, facecolor=(*to_rgb(color), 0.0))
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves it untyped
    figure.text(
        0.5,
        0.5,
        text,
        color="white",
        fontsize=64,
        fontweight="bold",
        horizontalalignment="center",
        verticalalignment="center",
        bbox={"boxstyle": "round,pad=0.12", "facecolor": color, "edgecolor": "none"},
    )
    canvas.draw()
    rgba = np.asarray(canvas.buffer_rgba(), dtype=np.float32) / 255
    light = decoded(rgba[..., :3])
    return np.concatenate([light, rgba[..., 3:]], axis=-1).astype(np.float32)


def _mix(
    t: NDArray[np.float32], start: tuple[float, ...], end: tuple[float, ...]
) -> NDArray[np.float32]:
    first, last = np.array(start, np.float32), np.array(end, np.float32)
    return np.asarray(first + (last - first) * t, dtype=np.float32)
