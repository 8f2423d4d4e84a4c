"""Filters that look a mip chain up, of an image in chunks: tasks for its levels and for lookups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import dask.array as da
import numpy as np
from dask.base import tokenize
from dask.highlevelgraph import HighLevelGraph

from .._arrays import as_array, spatial_axes
from ..resample.chained import Chained
from ..resample.seen import REACH, Rectangle
from ..resample.sparse import sparse_zeros
from .pieces import Chunks, Lengths, Piece, chunk_ranges, keys_of, rectangles, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["chain_converted"]

# Texels of a level around a lookup that have a part in it: an ellipse is up to two wide in its
# level, 16 times as long, and one texel larger for the rest of the filter.
_ELLIPSE = 34

# The least side of a chunk of a level.
_LEAST = 64

# Tiles that nobody asks for are large.
_TILE = (1 << 20, 1 << 20)


@dataclass(frozen=True, slots=True, eq=False)
class _Halved:
    """A task: a window of a level, of pieces of what it needs."""

    chained: Chained
    level: int
    window: Rectangle
    needed: Rectangle
    # Where in what is needed they lie.
    pieces: tuple[Piece, ...]

    def __call__(self, chunks: Sequence[Any]) -> NDArray[Any]:
        chained, needed = self.chained, self.needed
        shape = (needed.bottom - needed.top, needed.right - needed.left, chained.shape[-1])
        texels = np.empty(shape, chained.floats if self.level else chained.dtype)
        for piece, chunk in zip(self.pieces, chunks, strict=True):
            part = as_array(chunk, "image")[piece.inner].reshape(*_sides(piece.place), -1)
            texels[piece.place] = part if self.level else chained.weighed(part)
        found = chained.halved(self.level, self.window, needed, texels)
        return found if self.window.face is None else found[None]


@dataclass(frozen=True, slots=True, eq=False)
class _LookedUp:
    """A task: a chunk of the result, of pieces of the image and of each level."""

    chained: Chained
    windows: tuple[Rectangle, ...]
    pieces: tuple[tuple[Piece, ...], ...]

    @property
    def chunks(self) -> list[list[int]]:
        """The numbers of the chunks that it wants of each."""
        return [sorted({piece.chunk for piece in some}) for some in self.pieces]

    def __call__(self, chunks: Sequence[Sequence[Any]]) -> NDArray[Any]:
        chained, held = self.chained, []
        shapes = [chained.shape, *chained.shapes]
        for level, (shape, some) in enumerate(zip(shapes, self.pieces, strict=True)):
            numbered = zip(self.chunks[level], chunks[level], strict=True)
            given = {number: as_array(chunk, "image") for number, chunk in numbered}
            texels = sparse_zeros(shape, chained.floats if level else chained.dtype)
            for piece in some:
                part = given[piece.chunk][piece.inner]
                texels[piece.place] = part if level else chained.weighed(part)
            held.append(texels)
        windows = [chained.window(held[0], held[1:], window, _TILE)[0] for window in self.windows]
        return windows[0] if self.windows[0].face is None else np.stack(windows)


def chain_converted(
    image: da.Array, chained: Chained, target: Projection, divided: Lengths, meta: Any
) -> da.Array:
    """Return the result of a conversion that looks a mip chain up, in chunks."""
    conversion = chained.conversion
    axes = spatial_axes(conversion.src)
    source = image if image.ndim > axes else image[..., None]
    if source.dtype != conversion.dtype:
        source = source.astype(conversion.dtype)
    arrays = [source]
    for level in range(len(chained.shapes)):
        arrays.append(
            _level(arrays[-1], chained, level, max(map(max, source.chunks[axes - 2 : axes])))
        )

    blocks, held = list(np.ndindex(*map(len, divided))), windows_of(divided)
    ellipses = conversion.options["filter"] == "ewa"
    seen = []
    for number, array in enumerate(arrays):
        ranges = chunk_ranges(array.chunks)
        reach = _ELLIPSE if ellipses else REACH
        chunks = Chunks(conversion.src, array.shape, ranges, len(blocks), reach)
        # What is far larger than the image sees all of the last level, whatever its size; on small
        # ones the way around an edge is not known so well.
        rows, columns = conversion.src.shape(2)[-2:]
        face = min(2 * array.shape[axes - 2] // rows, 2 * array.shape[axes - 1] // columns)
        if number == len(arrays) - 1 or face <= 4 * reach:
            seen.append([chunks.all()] * len(blocks))
        else:
            seen.append(chunks.seen_by_each(target, conversion.size, held))

    name = f"spheremap-convert-{tokenize(image.name, conversion, divided)}"
    end, keys = (0,) * len(conversion.channels), [keys_of(array) for array in arrays]
    tasks = {}
    for index, faces, *some in zip(blocks, held, *seen, strict=True):
        part = _LookedUp(chained, tuple(faces), tuple(some))
        wanted = [[of[k] for k in few] for of, few in zip(keys, part.chunks, strict=True)]
        tasks[(name, *index, *end)] = (part, wanted)
    graph = HighLevelGraph.from_collections(name, tasks, dependencies=arrays)
    whole = (*divided, *((length,) for length in conversion.channels))
    return da.Array(graph, name, whole, meta=meta)


def _level(before: da.Array, chained: Chained, level: int, side: int) -> da.Array:
    """Return a level in chunks of about so many texels a side, made of the one before."""
    shape, side = chained.shapes[level], max(side, _LEAST)
    faces = (1,) * (len(shape) - 3)
    divided: Lengths = da.core.normalize_chunks(
        (*faces, side, side, -1), shape, dtype=chained.floats
    )
    keys, ranges = keys_of(before), chunk_ranges(before.chunks)
    held = [(k, part) for k, chunk in enumerate(ranges) for part in rectangles(chunk[:-1])]
    ends = np.array([[p.face or 0, p.top, p.bottom, p.left, p.right] for _, p in held])
    name = f"spheremap-level-{tokenize(before.name, chained.conversion, level, side)}"
    tasks = {}
    for index, (window,) in zip(
        np.ndindex(*map(len, divided)), windows_of(divided[:-1]), strict=True
    ):
        needed = chained.needed(level, window)
        meets = (ends[:, 0] == (needed.face or 0)) & (ends[:, 1] < needed.bottom)
        meets &= (ends[:, 2] > needed.top) & (ends[:, 3] < needed.right)
        meets &= ends[:, 4] > needed.left
        pieces = [_piece(*held[k], ranges[held[k][0]], needed) for k in np.flatnonzero(meets)]
        task = _Halved(chained, level, window, needed, tuple(pieces))
        tasks[(name, *index)] = (task, [keys[piece.chunk] for piece in pieces])
    graph = HighLevelGraph.from_collections(name, tasks, dependencies=[before])
    return da.Array(graph, name, divided, dtype=chained.floats)


def _piece(
    chunk: int, part: Rectangle, ranges: Sequence[tuple[int, int]], needed: Rectangle
) -> Piece:
    """Return what a chunk has of what is needed."""
    *faces, (above, _), (before, _), _ = ranges
    top, bottom = max(part.top, needed.top), min(part.bottom, needed.bottom)
    left, right = max(part.left, needed.left), min(part.right, needed.right)
    face = [slice((part.face or 0) - start, (part.face or 0) - start + 1) for start, _ in faces]
    inner = (*face, slice(top - above, bottom - above), slice(left - before, right - before))
    place = (
        slice(top - needed.top, bottom - needed.top),
        slice(left - needed.left, right - needed.left),
    )
    return Piece(chunk, inner, place)


def _sides(place: tuple[slice, ...]) -> list[int]:
    """Return how long a place is along each axis."""
    return [part.stop - part.start for part in place]
