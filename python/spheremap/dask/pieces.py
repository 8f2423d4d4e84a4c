"""What tasks see of the chunks of a source: less than all of them, which they would copy."""

from __future__ import annotations

from itertools import groupby, pairwise, product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._arrays import spatial_axes
from ..resample.seen import REACH, Rectangle, SourceTiles

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import dask.array as da
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Chunks", "Lengths", "Piece", "chunk_ranges", "keys_of", "rectangles", "windows_of"]

# Of chunks, along each axis.
Lengths = tuple[tuple[int, ...], ...]

# How many tiles chunks are divided into at most, and for how many tasks: to find which tiles each
# sees takes less than it saves, but comes before all else, on one thread.
_TILES, _TASKS = 1 << 15, 1 << 13

# Tiles along a side of a chunk, and their least side in texels.
_ALONG, _LEAST = 8, 64

# What indexes an array by a part of it.
Place = tuple[slice, ...]


class Piece(NamedTuple):
    """What is seen of a chunk: its number, where in it, and where in the source."""

    chunk: int
    inner: Place
    place: Place


class Chunks:
    """The chunks of a source, in tiles.

    Parameters
    ----------
    projection : Projection
        Of the source.
    shape : tuple of int
        Its shape.
    ranges : sequence
        Where each chunk begins and ends along each axis.
    tasks : int
        How many there will be.
    reach : int
        How far from a lookup texels have a part in it.
    """

    def __init__(
        self,
        projection: Projection,
        shape: tuple[int, ...],
        ranges: Sequence[Sequence[tuple[int, int]]],
        tasks: int,
        reach: int = REACH,
    ) -> None:
        axes = spatial_axes(projection)
        # A chunk is a rectangle on each of its faces.
        held = [(k, each) for k, chunk in enumerate(ranges) for each in rectangles(chunk[:axes])]
        along = _tiles_along([each for _, each in held]) if tasks <= _TASKS else 1
        self._starts = [[start for start, _ in chunk] for chunk in ranges]
        self._parts = [part for _, each in held for part in _divided(each, along)]
        self._owner = np.repeat([k for k, _ in held], along * along)
        # Of tiles, so many that follow each other lie side by side in a chunk.
        self._along = along
        self._known: dict[tuple[int, int], Piece] = {}
        self.tiles = SourceTiles(projection, shape[:axes], self._parts, reach)

    def seen_by_each(
        self, target: Projection, size: tuple[int, ...], blocks: Sequence[Sequence[Rectangle]]
    ) -> list[tuple[Piece, ...]]:
        """Return what blocks of a target see, each of windows of its own."""
        windows = [window for block in blocks for window in block]
        found = iter(self.tiles.seen_by_each(target, size, windows))
        return [self.pieces(np.concatenate([next(found) for _ in block])) for block in blocks]

    def all(self) -> tuple[Piece, ...]:
        """Return all there is."""
        return self.pieces(np.arange(len(self._parts)))

    def pieces(self, tiles: NDArray[np.intp]) -> tuple[Piece, ...]:
        """Return what holds these tiles, row by row of their chunks."""
        seen = sorted(set(tiles.tolist()))
        ends: Iterable[tuple[int, int]] = zip(seen, seen, strict=True)
        if self._along > 1:
            rows = [list(row) for _, row in groupby(seen, lambda tile: tile // self._along)]
            ends = [(row[0], row[-1]) for row in rows]
        return tuple(self._known.get(pair) or self._piece(*pair) for pair in ends)

    def _piece(self, first: int, last: int) -> Piece:
        """Return what holds the tiles of a row from one to another."""
        left, right, owner = self._parts[first], self._parts[last], int(self._owner[first])
        faces = [] if left.face is None else [(left.face, left.face + 1)]
        ranges = [*faces, (left.top, left.bottom), (left.left, right.right)]
        starts = self._starts[owner]
        inner = tuple(slice(a - s, b - s) for (a, b), s in zip(ranges, starts, strict=False))
        piece = Piece(owner, inner, tuple(slice(*ends) for ends in ranges))
        self._known[first, last] = piece
        return piece


def keys_of(array: da.Array) -> list[tuple[Any, ...]]:
    """Return the keys of the chunks of an array, in the order of their numbers."""
    return [(array.name, *index) for index in np.ndindex(*array.numblocks)]


def chunk_ranges(chunks: Lengths) -> list[tuple[tuple[int, int], ...]]:
    """Return where each chunk begins and ends along each axis, in the order of their numbers."""
    ends = [list(pairwise(np.cumsum([0, *lengths]).tolist())) for lengths in chunks]
    return list(product(*ends))


def windows_of(divided: Lengths) -> list[list[Rectangle]]:
    """Return the windows of each chunk of an image without channels, one for each face."""
    return [rectangles(ranges) for ranges in chunk_ranges(divided)]


def rectangles(ranges: Sequence[tuple[int, int]]) -> list[Rectangle]:
    """Return the rectangles of a chunk, one for each face."""
    *faces, rows, columns = ranges
    return [Rectangle(*rows, *columns, face) for face in (range(*faces[0]) if faces else [None])]


def _tiles_along(held: Sequence[Rectangle]) -> int:
    """Return into how many tiles along a side each is divided."""
    sides = [max(part.bottom - part.top, part.right - part.left) for part in held]
    most = min(_ALONG, max(sides, default=0) // _LEAST)
    return next((n for n in range(most, 1, -1) if len(sides) * n * n <= _TILES), 1)


def _divided(part: Rectangle, along: int) -> list[Rectangle]:
    """Return so many tiles along both sides of a rectangle; of a small one some are empty."""
    rows = [part.top + (part.bottom - part.top) * k // along for k in range(along + 1)]
    columns = [part.left + (part.right - part.left) * k // along for k in range(along + 1)]
    return [Rectangle(*y, *x, part.face) for y in pairwise(rows) for x in pairwise(columns)]
