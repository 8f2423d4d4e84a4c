"""Means over texels, from as many lookups in each as its content asks for."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.grid import cells, centers, on_corners

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

    Array = NDArray[np.float64]

# Lookups along one side of a texel.
_COUNTS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32], np.uint8)
# Lookups that are in memory at a time.
BLOCK = 1 << 17
# Texels whose centers are looked at together: what is computed of them fits a cache.
_BLOCK_OF_ROWS = 1 << 15


def counts(wanted: Array) -> NDArray[np.uint8]:
    """Round numbers of lookups along a side up to one of a few, from 1 to 32."""
    # Powers of 2 alone would be up to four times as many lookups as are wanted.
    least = np.clip(np.nan_to_num(wanted, nan=1.0), 1, _COUNTS[-1])
    return _COUNTS[np.searchsorted(_COUNTS, least)]


def spreads(sides: Array) -> Array:
    """Return the share of a side of so many pixels over which lookups are spread.

    None where the side is a pixel long, as one lookup is already that wide; all from √2 on. So
    nothing jumps where texels turn coarser than pixels: `convert` does the same.
    """
    with np.errstate(divide="ignore"):
        return np.sqrt(np.clip(2 - 2 / (sides * sides), 0, 1))


def means(
    number: NDArray[np.uint8],
    channels: int,
    look: Callable[[NDArray[np.intp], Array], NDArray[np.floating[Any]]],
) -> Array:
    """Return the mean of each texel over its lookups, shape (N, channels).

    Parameters
    ----------
    number : (N, 2)
        How many lookups along the sides of a texel, u and v; some of those that `counts` returns.
    channels : int
        How many numbers a lookup returns.
    look : callable
        From indices of texels, (n,), and offsets from their centers in texels, (n, 2), to values,
        (n, channels). What is NaN does not count.
    """
    out = np.full((len(number), channels), np.nan)
    # 32 is the most: both fit 16 bits.
    key = (number[:, 0].astype(np.uint16) << 8) | number[:, 1]
    order = np.argsort(key, kind="stable")
    ends = np.append(np.flatnonzero(np.diff(key[order])) + 1, len(key))
    first = 0
    for end in ends.tolist() if len(key) else ():
        across, down = (int(n) for n in number[order[first]])
        u, v = np.meshgrid(_evenly(across), _evenly(down))
        offsets = np.stack([u, v], axis=-1).reshape(-1, 2)
        each = max(1, BLOCK // len(offsets))
        for start in range(first, end, each):
            part = order[start : min(start + each, end)]
            values = look(np.tile(part, len(offsets)), np.repeat(offsets, len(part), axis=0))
            out[part] = _mean(values.reshape(len(offsets), len(part), channels))
        first = end
    return out


def _evenly(n: int) -> Array:
    return np.asarray((np.arange(n) + 0.5) / n - 0.5)


def _mean(values: NDArray[np.floating[Any]]) -> Array:
    """Return the mean over the first axis of what is not NaN."""
    mean: Array = values.sum(axis=0, dtype=np.float64) / len(values)
    holes = np.flatnonzero(np.isnan(mean).any(axis=-1))
    if holes.size:
        known = ~np.isnan(values[:, holes])
        total = np.where(known, values[:, holes], 0).sum(axis=0, dtype=np.float64)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean[holes] = total / known.sum(axis=0)
    return mean


class Texels:
    """The texels of an image in a row, as places that can be looked at beside their centers."""

    def __init__(self, p: Projection, shape: tuple[int, ...]) -> None:
        self.projection, self.shape = p, shape
        height, width = shape[-2:]
        rows, columns = cells(p)
        on_v, on_u = on_corners(p)
        self.u = centers(width, columns, on_u)
        self.v = centers(height, rows, on_v)
        self.step = np.array([1 / width, 1 / height])

    def uv(self, index: NDArray[np.intp], offset: Array | None = None) -> Array:
        """Return the coordinates of texels, moved from their centers by an offset in texels."""
        height, width = self.shape[-2:]
        place = np.empty((len(index), len(self.shape)))
        place[:, 0] = self.u[index % width]
        place[:, 1] = self.v[index // width % height]
        if offset is not None:
            place[:, :2] += offset * self.step
        if len(self.shape) == 3:
            place[:, 2] = index // (width * height)
        return place

    def row_blocks(self) -> Iterator[tuple[int, int, slice]]:
        """Yield blocks of whole rows, those of all faces in turn.

        Each is the first row, the one after the last, and those with a neighbor more at both ends
        where the face has one.
        """
        height, width = self.shape[-2:]
        step = max(1, _BLOCK_OF_ROWS // width)
        for start in range(0, math.prod(self.shape[:-1]), height):
            for first in range(start, start + height, step):
                last = min(first + step, start + height)
                yield first, last, slice(max(first - 1, start), min(last + 1, start + height))

    def directions_of_rows(self, rows: slice) -> Array:
        """Return the directions of the texels of whole rows, (N, 3)."""
        height, width = self.shape[-2:]
        row = np.arange(rows.start, rows.stop)
        place = np.empty((len(row), width, len(self.shape)))
        place[..., 0] = self.u
        place[..., 1] = self.v[row % height, None]
        if len(self.shape) == 3:
            place[..., 2] = (row // height)[:, None]
        return np.asarray(self.projection.decode(place)).reshape(-1, 3)

    def directions(self, index: NDArray[np.intp], offset: Array | None = None) -> Array:
        """Return the directions of texels, moved likewise."""
        return np.asarray(self.projection.decode(self.uv(index, offset)))
