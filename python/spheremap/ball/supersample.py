"""Means over texels, from as many lookups in each as its content asks for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..map.grid import cells, centers, on_corners

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._core import Projection

    Array = NDArray[np.float64]

# Lookups along one side of a texel.
_MOST = 32
_COUNTS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32])
# Lookups that are in memory at a time.
BLOCK = 1 << 17


def counts(wanted: Array) -> NDArray[np.intp]:
    """Round numbers of lookups along a side up to one of a few, from 1 to 32."""
    # Powers of 2 alone would be up to four times as many lookups as are wanted.
    least = np.clip(np.nan_to_num(wanted, nan=1.0), 1, _MOST) * 0.93
    return _COUNTS[np.searchsorted(_COUNTS, least)]


def means(
    number: NDArray[np.intp], channels: int, look: Callable[[NDArray[np.intp], Array], Array]
) -> Array:
    """Return the mean of each texel over its lookups, shape (N, channels).

    Parameters
    ----------
    number : (N,)
        How many lookups along each side of a texel.
    channels : int
        How many numbers a lookup returns.
    look : callable
        From indices of texels, (n,), and offsets from their centers in texels, (n, 2), to values,
        (n, channels). What is NaN does not count.
    """
    out = np.full((len(number), channels), np.nan)
    for n in np.unique(number):
        which = np.flatnonzero(number == n)
        steps = (np.arange(n) + 0.5) / n - 0.5
        offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        each = max(1, BLOCK // len(offsets))
        for first in range(0, len(which), each):
            part = which[first : first + each]
            values = look(np.repeat(part, len(offsets)), np.tile(offsets, (len(part), 1)))
            values = values.reshape(len(part), len(offsets), channels)
            known = ~np.isnan(values)
            total = np.where(known, values, 0).sum(axis=1)
            with np.errstate(invalid="ignore", divide="ignore"):
                out[part] = total / known.sum(axis=1)
    return out


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

    def directions(self, index: NDArray[np.intp], offset: Array | None = None) -> Array:
        """Return the directions of texels, moved likewise."""
        return np.asarray(self.projection.decode(self.uv(index, offset)))

    def extent(self, index: NDArray[np.intp]) -> Array:
        """Return the longer side of each texel, in radians."""
        slopes = np.asarray(self.projection.jacobian(self.uv(index)))
        sides = np.sqrt(np.sum(slopes * slopes, axis=-2)) * self.step
        return np.asarray(sides.max(axis=-1))
