"""Which parts of a source a part of a target sees, before anything is converted.

Images larger than memory, and arrays in chunks, are converted window by window, and each window
wants a few tiles of the source. Maps have seams, poles and rims, where rectangles of one image are
none of the other; on the sphere they are regions, and a region lies in a cap. So caps are compared:
one for each tile, several for a window. What is found is never too little and a little too much.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.pixels import pixels_to_directions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Rectangle", "SourceTiles", "tiles"]

# Texels around a lookup that have a part in it, of the widest filter, and one for rims.
REACH = 4

# Places along a side at which a tile's directions are known; parts along a side of a window, each
# with a cap.
_PLACES, _PARTS = 9, 8

# What rounding of directions and of sums may hide, in radians.
_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Rectangle:
    """Texels of an image: rows and columns of a face, the first one and the one after the last."""

    top: int
    bottom: int
    left: int
    right: int
    face: int | None = None

    @property
    def index(self) -> tuple[int | slice, ...]:
        """What indexes an array by it."""
        part = (slice(self.top, self.bottom), slice(self.left, self.right))
        return part if self.face is None else (self.face, *part)

    @property
    def window(self) -> Any:
        """What `convert` calls a window."""
        part = (slice(self.top, self.bottom), slice(self.left, self.right))
        return part if self.face is None else (*part, self.face)


def tiles(shape: tuple[int, ...], tile: tuple[int, int]) -> list[Rectangle]:
    """Return the tiles of at most so many rows and columns that an image of this shape is made of.

    The shape is without channels. Tiles go by faces, rows and columns.
    """
    *faces, rows, columns = shape
    return [
        Rectangle(top, min(top + tile[0], rows), left, min(left + tile[1], columns), face)
        for face in (range(faces[0]) if faces else [None])
        for top in range(0, rows, tile[0])
        for left in range(0, columns, tile[1])
    ]


class SourceTiles:
    """Tiles of an image, and which of them windows of another see.

    Parameters
    ----------
    projection : Projection
        Of the image.
    shape : tuple of int
        Its shape without channels.
    parts : sequence of Rectangle
        The tiles.
    """

    def __init__(
        self, projection: Projection, shape: tuple[int, ...], parts: Sequence[Rectangle]
    ) -> None:
        self.projection = projection
        self.parts = list(parts)
        places = _lattice(projection, shape, self.parts, _PLACES, REACH)
        center, radius = _caps(places)
        # Beyond an edge of a face a lookup goes on elsewhere: as far as so many texels of the tile.
        step = _steps(places).max(axis=(1, 2))
        sides = np.array([[p.bottom - p.top, p.right - p.left] for p in self.parts])
        texels = np.maximum((sides + 2 * REACH).min(axis=1) / (_PLACES - 1), 0.25)
        radius = radius + step + 2.0 * REACH * step / texels
        self._center, self._radius = center, radius

    def seen_by(
        self, projection: Projection, shape: tuple[int, ...], window: Rectangle
    ) -> NDArray[np.intp]:
        """Return the numbers of the tiles that a window of an image of this shape sees.

        The projection is in the world of the source.
        """
        count = 2 * _PARTS + 1
        places = _lattice(projection, shape, [window], count, 1)
        center, radius = _caps(places)
        near = np.flatnonzero(self._meet(center, radius + _steps(places).max(), slice(None))[0])
        if not near.size:
            return near
        # Parts overlap by a place: a sliver beside a rim may hide between places.
        padded = np.pad(places[0], ((1, 1), (1, 1), (0, 0)), mode="edge")
        parts = np.stack(
            [
                padded[2 * i : 2 * i + 5, 2 * j : 2 * j + 5]
                for i in range(_PARTS)
                for j in range(_PARTS)
            ]
        )
        center, radius = _caps(parts)
        radius = radius + _steps(parts).max(axis=(1, 2))
        return near[self._meet(center, radius, near).any(axis=0)]

    def _meet(self, center: Any, radius: Any, which: Any) -> NDArray[np.bool_]:
        """Tell which caps meet which tiles: whether both radii reach from center to center."""
        radii = radius[:, None] + self._radius[None, which] + _ROUNDING
        cosines = center @ self._center[which].T
        met: NDArray[np.bool_] = cosines >= np.cos(np.minimum(radii, np.pi))
        met |= radii >= np.pi
        met &= np.isfinite(radii)
        return met


def _lattice(
    projection: Projection,
    shape: tuple[int, ...],
    parts: Sequence[Rectangle],
    count: int,
    grow: int,
) -> NDArray[np.float64]:
    """Return directions at count × count places spread over each part, grown by some texels."""
    *_, rows, columns = shape
    share = np.linspace(0.0, 1.0, count)

    def along(low: Any, high: Any, side: int) -> NDArray[np.float64]:
        low, high = np.maximum(low - grow, 0), np.minimum(high + grow, side)
        places: NDArray[np.float64] = low[:, None] + (high - low)[:, None] * share
        # Beyond the outermost centers a grid of corners has nothing.
        return np.clip(places, 0.5, side - 0.5) if projection.grid != "centers" else places

    ends = np.array([[p.top, p.bottom, p.left, p.right] for p in parts], np.float64).T
    y, x = along(ends[0], ends[1], rows), along(ends[2], ends[3], columns)
    pixels = np.empty((len(parts), count, count, len(shape)))
    pixels[..., 0], pixels[..., 1] = x[:, None, :], y[:, :, None]
    if len(shape) == 3:
        pixels[..., 2] = np.array([p.face for p in parts])[:, None, None]
    return pixels_to_directions(pixels, projection, shape, any_aspect=True).astype(
        np.float64, copy=False
    )


def _caps(places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return center and radius of caps that hold the directions of each lattice; NaN of none."""
    flat = places.reshape(len(places), -1, 3)
    held: NDArray[np.bool_] = ~np.isnan(flat[..., :1])
    center = np.where(held, flat, 0.0).sum(axis=1)
    length = np.linalg.norm(center, axis=-1, keepdims=True)
    # Directions all around have no middle; any serves.
    center = np.where(length > 0.0, center / np.where(length > 0.0, length, 1.0), [0.0, 0.0, 1.0])
    chord = np.linalg.norm(flat - center[:, None], axis=-1)
    farthest = np.where(held[..., 0], chord, -1.0).max(axis=1)
    radius = 2.0 * np.arcsin(np.clip(farthest / 2.0, -1.0, 1.0))
    return center, np.where(farthest < 0.0, np.nan, radius)


def _steps(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far neighbors lie apart, the larger of both ways; the last have none."""
    down = np.linalg.norm(np.diff(places, axis=1)[:, :, :-1], axis=-1)
    right = np.linalg.norm(np.diff(places, axis=2)[:, :-1], axis=-1)
    chord = np.fmax(np.nan_to_num(down), np.nan_to_num(right))
    steps: NDArray[np.float64] = 2.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0))
    return steps
