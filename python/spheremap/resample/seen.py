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

# Windows along a side of a group, whose tiles are looked for together.
_GROUP = 8

# Tiles whose caps are found at a time.
_PIECE = 1024

# From an edge of a face to the last place on it, in texels.
_WITHIN = 1e-6

# More than the cosine of any angle: there is none.
_NONE = 2.0

# What rounding of directions, of sums and of cosines near 1 may hide, in radians.
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


def tiles(
    shape: tuple[int, ...], tile: tuple[int, int], projection: Projection | None = None
) -> list[Rectangle]:
    """Return the tiles of at most so many rows and columns that an image of this shape is made of.

    The shape is without channels. Tiles go by faces, rows and columns. With a projection no tile
    has a part in two faces that lie in one image: what lies side by side there may look anywhere.
    """
    *faces, rows, columns = shape
    height, width = (rows, columns) if projection is None else _cell(projection, shape)
    return [
        Rectangle(top, min(top + tile[0], bottom), left, min(left + tile[1], right), face)
        for face in (range(faces[0]) if faces else [None])
        for above, bottom in _pieces(rows, height)
        for before, right in _pieces(columns, width)
        for top in range(above, bottom, tile[0])
        for left in range(before, right, tile[1])
    ]


def _pieces(length: int, piece: int) -> list[tuple[int, int]]:
    """Return where the pieces of a side begin and end."""
    return [(a, min(a + piece, length)) for a in range(0, length, max(piece, 1))]


def _cell(projection: Projection, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return rows and columns of a face of an image, of all of it where it is one."""
    *_, rows, columns = shape
    if projection.layout in (None, "faces"):
        return rows, columns
    # Faces of 2 texels a side: a grid of corners has none of 1.
    down, across = projection.shape(2)
    return -(-2 * rows // down), -(-2 * columns // across)


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
    reach : int
        How far from a lookup texels have a part in it.
    """

    def __init__(
        self,
        projection: Projection,
        shape: tuple[int, ...],
        parts: Sequence[Rectangle],
        reach: int = REACH,
    ) -> None:
        self.projection = projection
        self.parts = list(parts)
        # By pieces: what the lattices take is a hundred times as much as what is kept.
        pieces = [self.parts[k : k + _PIECE] for k in range(0, len(self.parts), _PIECE)]
        found = [_caps_with_reach(projection, shape, piece, reach) for piece in pieces]
        self._center = np.concatenate([np.empty((0, 3)), *(center for center, _ in found)])
        radius = np.concatenate([np.empty(0), *(radius for _, radius in found)])
        radius = np.minimum(radius + _ROUNDING, np.pi)
        self._cosine, self._sine = np.cos(radius), np.sin(radius)

    def seen_by(
        self, projection: Projection, shape: tuple[int, ...], window: Rectangle
    ) -> NDArray[np.intp]:
        """Return the numbers of the tiles that a window of an image of this shape sees.

        The projection is in the world of the source.
        """
        return self.seen_by_each(projection, shape, [window])[0]

    def within(self, direction: NDArray[np.float64], angle: float) -> NDArray[np.intp]:
        """Return the numbers of the tiles that may hold what lies so near to a direction."""
        found = self._meet(direction[None], np.array([angle]), slice(None))
        return np.flatnonzero(found[0])

    def seen_by_each(
        self, projection: Projection, shape: tuple[int, ...], windows: Sequence[Rectangle]
    ) -> list[NDArray[np.intp]]:
        """Return the same for many windows, in a tenth of the time for each."""
        found: list[NDArray[np.intp]] = [np.empty(0, np.intp)] * len(windows)
        for group in _neighbors(windows):
            places = _lattice(projection, shape, [windows[k] for k in group], 2 * _PARTS + 1, 1)
            steps = _steps(places)
            center, radius = _caps(places)
            radius = radius + steps.max(axis=(1, 2))
            middle, reach = _cap_of_caps(center, radius)
            near = np.flatnonzero(self._meet(middle, reach, slice(None))[0])
            if not near.size:
                continue
            met = self._meet(center, radius, near)
            center, radius = _caps_of_parts(places, steps)
            for k, number in enumerate(group):
                some = near[met[k]]
                if some.size:
                    found[number] = some[self._meet(center[k], radius[k], some).any(axis=0)]
        return found

    def _meet(self, center: Any, radius: Any, which: Any) -> NDArray[np.bool_]:
        """Tell which caps meet which tiles: whether both radii reach from center to center."""
        reach = np.minimum(radius, np.pi)[:, None]
        cosine, sine = np.cos(reach), np.sin(reach)
        # The cosine of the sum of the radii, below half a turn.
        least = cosine * self._cosine[which] - sine * self._sine[which]
        met: NDArray[np.bool_] = center @ self._center[which].T >= least
        met |= cosine + self._cosine[which] <= 0.0
        return met


def _lattice(
    projection: Projection,
    shape: tuple[int, ...],
    parts: Sequence[Rectangle],
    count: int,
    grow: int,
) -> NDArray[np.float64]:
    """Return directions at count × count places spread over each part, grown by some texels.

    A part does not grow into another face, where directions are of other places.
    """
    *_, rows, columns = shape
    height, width = _cell(projection, shape)
    share = np.linspace(0.0, 1.0, count)

    def along(low: Any, high: Any, side: int, cell: int) -> NDArray[np.float64]:
        least, most = low // cell * cell, np.minimum(-(-high // cell) * cell, side)
        # What lies on an edge between two faces is of the next one.
        most = np.where(most < side, most - _WITHIN, most)
        low, high = np.maximum(low - grow, least), np.minimum(high + grow, most)
        places: NDArray[np.float64] = low[:, None] + (high - low)[:, None] * share
        # Beyond the outermost centers a grid of corners has nothing.
        return np.clip(places, 0.5, side - 0.5) if projection.grid != "centers" else places

    ends = np.array([[p.top, p.bottom, p.left, p.right] for p in parts], np.float64).T
    y = along(ends[0], ends[1], rows, height)
    x = along(ends[2], ends[3], columns, width)
    pixels = np.empty((len(parts), count, count, len(shape)))
    pixels[..., 0], pixels[..., 1] = x[:, None, :], y[:, :, None]
    if len(shape) == 3:
        pixels[..., 2] = np.array([p.face for p in parts])[:, None, None]
    return pixels_to_directions(pixels, projection, shape, any_aspect=True).astype(
        np.float64, copy=False
    )


def _caps_with_reach(
    projection: Projection, shape: tuple[int, ...], parts: Sequence[Rectangle], reach: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return center and radius of what lookups see that have a part in each tile."""
    places = _lattice(projection, shape, parts, _PLACES, reach)
    center, radius = _caps(places)
    # Beyond an edge of a face a lookup goes on elsewhere: as far as so many texels of the tile.
    step = _steps(places).max(axis=(1, 2))
    sides = np.array([[p.bottom - p.top, p.right - p.left] for p in parts])
    texels = np.maximum((sides + 2 * reach).min(axis=1) / (_PLACES - 1), 0.25)
    return center, radius + step + 2.0 * reach * step / texels


def _neighbors(windows: Sequence[Rectangle]) -> list[NDArray[np.intp]]:
    """Return the numbers of windows in groups of those that lie side by side."""
    corners = np.array([[p.face or 0, p.top, p.left] for p in windows]).reshape(-1, 3)
    block = np.stack([np.unique(side, return_inverse=True)[1] for side in corners.T])
    block[1:] //= _GROUP
    _, first = np.unique(block, axis=1, return_inverse=True)
    first = first.reshape(-1)
    order = np.argsort(first, kind="stable")
    return [g for g in np.split(order, np.flatnonzero(np.diff(first[order])) + 1) if g.size]


def _caps(places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return center and radius of caps that hold the directions of each lattice; NaN of none."""
    flat = places.reshape(len(places), -1, 3)
    held: NDArray[np.bool_] = ~np.isnan(flat[..., 0])
    filled = flat if held.all() else np.where(held[..., None], flat, 0.0)
    center = _unit(filled.sum(axis=1))
    cosines = (filled @ center[:, :, None])[..., 0]
    return center, _radius(np.where(held, cosines, _NONE).min(axis=1))


def _cap_of_caps(
    center: NDArray[np.float64], radius: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return center and radius of one cap that holds all others, but those whose radius is NaN."""
    held = np.isfinite(radius)
    if not held.any():
        return center[:1], radius[:1]
    middle = _unit(center[held].sum(axis=0, keepdims=True))
    apart = np.arccos(np.clip(center[held] @ middle[0], -1.0, 1.0))
    return middle, (apart + radius[held]).max(keepdims=True)


def _caps_of_parts(
    places: NDArray[np.float64], steps: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return center and radius of the caps of all parts of each lattice, with a step around."""
    # Parts overlap by a place: a sliver beside a rim may hide between places.
    # Components lie apart, which is three times as fast.
    padded = np.pad(np.moveaxis(places, -1, 0), ((0, 0), (0, 0), (1, 1), (1, 1)), mode="edge")
    side = 2 * _PARTS
    held: NDArray[np.bool_] = ~np.isnan(padded[0])
    everywhere = bool(held.all())
    filled = padded if everywhere else np.where(held, padded, 0.0)
    offsets = [
        (slice(None), slice(i, i + side, 2), slice(j, j + side, 2))
        for i in range(5)
        for j in range(5)
    ]
    center = np.zeros((len(places), _PARTS, _PARTS, 3))
    for at in offsets:
        for c in range(3):
            center[..., c] += filled[c][at]
    center = _unit(center)
    x, y, z = np.ascontiguousarray(np.moveaxis(center, -1, 0))
    least = np.full(x.shape, _NONE)
    for at in offsets:
        cosines = filled[0][at] * x + filled[1][at] * y + filled[2][at] * z
        np.minimum(least, cosines if everywhere else np.where(held[at], cosines, _NONE), out=least)
    around = np.pad(steps, ((0, 0), (1, 1), (1, 1)))
    farthest = np.zeros_like(least)
    for at in offsets:
        if at[1].start < 4 and at[2].start < 4:
            np.maximum(farthest, around[at], out=farthest)
    radius = _radius(least) + farthest
    return center.reshape(len(places), -1, 3), radius.reshape(len(places), -1)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors with the length 1. Directions all around have no middle; any serves."""
    length = np.sqrt(np.einsum("...c,...c", vectors, vectors))[..., None]
    return np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), [0.0, 0.0, 1.0])


def _radius(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle of a cosine; NaN where there was none."""
    angle: NDArray[np.float64] = np.arccos(np.clip(cosine, -1.0, 1.0))
    angle[cosine == _NONE] = np.nan
    return angle


def _steps(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far neighbors lie apart, the larger of both ways; the last have none."""
    here = places[:, :-1, :-1]
    squared = np.fmax(_squared(places[:, 1:, :-1] - here), _squared(places[:, :-1, 1:] - here))
    steps: NDArray[np.float64] = 2.0 * np.arcsin(np.clip(np.sqrt(squared) / 2.0, 0.0, 1.0))
    return steps


def _squared(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the squared length of vectors, 0 of what is NaN."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.nan_to_num(x * x + y * y + z * z)
