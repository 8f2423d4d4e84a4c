"""How much each pixel of a view counts in a panorama of several.

A pixel counts by how finely its camera sees there, in pixels per steradian, times the square of its
angle to where the view ends: the edge of the picture, the rim of the lens, what a mask leaves out.
That is the square of its distance to the end in pixels. So of two views that overlap each begins
and ends with weight 0 and slope 0, and they cross where both are as good.

What is no distance to an edge is computed at nodes some pixels apart, and linear in between.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .borders import signed_distance

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

    Array = NDArray[np.float32]
    Mask = NDArray[np.bool_]

__all__ = ["ViewWeights", "axis", "view_weights"]

# Along the longer side.
NODES = 128
# What is seen, however near to the end, counts as a quarter of a pixel from it.
LEAST = np.float32(0.25)
# Of distances, in pixels: squares, and their products with light, stay in the range of float32.
UNIT = np.float32(1024)
# Rows whose coordinates are held at a time.
ROWS = 64


@dataclass(frozen=True, slots=True)
class ViewWeights:
    """The weights of a view's pixels, by blocks of rows.

    `ends` is at nodes, the distance to a rim in pixels, and `seen` of every pixel. `edges` says
    whether the picture ends above and below, and on both sides.
    """

    shape: tuple[int, int]
    ends: Array | None
    seen: Mask | None
    edges: tuple[bool, bool]
    longest: float

    def rows(self, first: int, last: int) -> Array:
        """Return the weights of some rows, shape (last - first, W)."""
        height, width = self.shape
        v = np.arange(first, last, dtype=np.float32) + np.float32(0.5)
        u = np.arange(width, dtype=np.float32) + np.float32(0.5)
        shape = (last - first, width)
        distance = np.full(shape, self.longest, np.float32)
        if self.edges[0]:
            np.minimum(distance, np.minimum(v, height - v)[:, None], out=distance)
        if self.edges[1]:
            np.minimum(distance, np.minimum(u, width - u), out=distance)
        if self.ends is not None:
            np.minimum(distance, between(self.ends, self.shape, first, last), out=distance)
        np.maximum(distance, LEAST, out=distance)
        distance /= UNIT
        distance *= distance
        if self.seen is not None:
            distance *= self.seen[first:last]
        return distance


def between(nodes: Array, shape: tuple[int, int], first: int, last: int) -> Array:
    """Return what nodes from corner to corner of a picture say of the pixels of some rows."""
    height, width = shape
    below, t = _place(np.arange(first, last), height, len(nodes))
    lines = nodes[below] + (nodes[below + 1] - nodes[below]) * t[:, None]
    left, s = _place(np.arange(width), width, nodes.shape[1])
    found: Array = np.take(np.diff(lines, axis=1), left, axis=1)
    found *= s
    found += np.take(lines, left, axis=1)
    return found


def view_weights(
    camera: Projection, shape: tuple[int, int], mask: Mask | None, fov: float | None
) -> ViewWeights:
    """Return the weights of the pixels of a camera's image of this height and width.

    The mask is True where a pixel counts; `fov` is the lens's, in radians across.
    """
    height, width = shape
    rows, columns = (max(2, math.ceil(NODES * n / max(shape)) + 1) for n in shape)
    seen = _valid(camera, shape)
    if fov is not None:
        seen &= _within(camera, shape, fov / 2, rows, columns)
    if mask is not None:
        seen &= mask
    everything = bool(seen.all())
    whole = camera.coverage == "sphere"
    return ViewWeights(
        shape,
        None if everything else signed_distance(seen, rows, columns).astype(np.float32),
        None if everything else seen,
        (not whole, not whole and camera.seam != "periodic"),
        # Of a sphere with as many pixels, half the way around; in a plane the diagonal is enough.
        math.sqrt(math.pi * height * width / 4) if whole else math.hypot(height, width),
    )


def axis(camera: Projection) -> NDArray[np.float64]:
    """Return the direction in which a camera looks: forward of its axes, turned by its pose."""
    forward = along(camera.axes, 2)
    return forward if camera.pose is None else np.asarray(camera.pose) @ forward


def along(axes: str, place: int) -> NDArray[np.float64]:
    """Return the direction in a place of axes or of a world, as -z in that of 2 of "+x +y -z"."""
    word = axes.split()[place]
    found = np.zeros(3)
    found["xyz".index(word[1])] = 1 if word[0] == "+" else -1
    return found


def _place(pixels: NDArray[Any], count: int, nodes: int) -> tuple[NDArray[np.intp], Array]:
    """Return the node before the center of each pixel, and how far it is to the next."""
    at = (pixels + 0.5) * ((nodes - 1) / count)
    before = np.minimum(at.astype(np.intp), nodes - 2)
    return before, (at - before).astype(np.float32)


def _valid(camera: Projection, shape: tuple[int, int]) -> Mask:
    """Return which pixels see anything."""
    height, width = shape
    found = np.empty(shape, bool)
    u = (np.arange(width, dtype=np.float32) + np.float32(0.5)) / np.float32(width)
    for first in range(0, height, ROWS):
        last = min(first + ROWS, height)
        uv = np.empty((last - first, width, 2), np.float32)
        uv[..., 0] = u
        uv[..., 1] = ((np.arange(first, last) + 0.5) / height)[:, None]
        found[first:last] = camera.valid(uv)
    return found


def _within(
    camera: Projection, shape: tuple[int, int], angle: float, rows: int, columns: int
) -> Mask:
    """Return which pixels are no farther from the camera's axis than an angle in radians."""
    # Past the last bit nothing is seen.
    v, u = (np.clip(np.linspace(0, 1, n), 1e-9, 1 - 1e-9) for n in (rows, columns))
    d = np.asarray(camera.decode(np.stack(np.meshgrid(u, v), axis=-1)))
    # Angles, and no cosines, are nearly linear between nodes. Where nothing is seen it is outside.
    beyond = np.nan_to_num(np.arccos(np.clip(d @ axis(camera), -1, 1)), nan=math.pi) - angle
    nodes = beyond.astype(np.float32)
    found = np.empty(shape, bool)
    for first in range(0, shape[0], ROWS):
        last = min(first + ROWS, shape[0])
        found[first:last] = between(nodes, shape, first, last) <= 0
    return found
