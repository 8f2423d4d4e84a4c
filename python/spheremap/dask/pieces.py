"""What tasks see of the chunks of a source: less than all of them, which they would copy."""

from __future__ import annotations

from itertools import groupby, pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .._arrays import spatial_axes
from ..resample.seen import Rectangle, SourceTiles

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from ..resample.conversion import Conversion

__all__ = ["Chunks", "Piece", "rectangles"]

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
    conversion : Conversion
    ranges : sequence
        Where each chunk begins and ends along each axis.
    tasks : int
        How many there will be.
    """

    def __init__(
        self, conversion: Conversion, ranges: Sequence[Sequence[tuple[int, int]]], tasks: int
    ) -> None:
        axes = spatial_axes(conversion.src)
        # A chunk is a rectangle on each of its faces.
        held = [(k, each) for k, chunk in enumerate(ranges) for each in rectangles(chunk[:axes])]
        along = _tiles_along([each for _, each in held]) if tasks <= _TASKS else 1
        self._starts = [[start for start, _ in chunk] for chunk in ranges]
        self._parts = [part for _, each in held for part in _divided(each, along)]
        self._owner = np.repeat([k for k, _ in held], along * along)
        # Of tiles, so many that follow each other lie side by side in a chunk.
        self._along = along
        self._known: dict[tuple[int, int], Piece] = {}
        self.tiles = SourceTiles(conversion.src, conversion.shape[:axes], self._parts)

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
