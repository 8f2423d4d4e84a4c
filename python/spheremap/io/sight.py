"""What a part of a result sees of a source in files, and how it is made of that."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.named import resolve_pair
from ..resample.parts import convert_seen, weighs
from ..resample.seen import Rectangle, SourceTiles, tiles
from ..resample.sparse import sparse_zeros

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..resample.chained import Chained
    from ..resample.conversion import Conversion
    from .levels import LevelFile

__all__ = ["Sight", "chained", "plain", "quarters"]

# Rows and columns of what is read at once.
_TILE = (128, 512)

# What is kept of a tile of the source, in bytes.
_KEPT = 256


@dataclass(frozen=True)
class Sight:
    """What a part of a result sees of a source, and what it makes of that."""

    seen: Callable[[Rectangle], list[Rectangle]]
    # The memory that parts of the source take.
    length: Callable[[Iterable[Rectangle]], int]
    converted: Callable[[Rectangle, Sequence[Rectangle]], NDArray[Any]]


def plain(conversion: Conversion, read: Callable[[Rectangle], NDArray[Any]], memory: int) -> Sight:
    """Return how a conversion sees a source that is looked up as it is."""
    target = resolve_pair(conversion.src, conversion.dst, None, conversion.options["world"])[1]
    shape = conversion.shape[:-1]
    parts = tiles(shape, _tile(shape, memory), conversion.src)
    source = SourceTiles(conversion.src, shape, parts)
    length = partial(_length, _texel(conversion))
    kept = None
    if not weighs(conversion):
        kept = _Kept(conversion.shape, conversion.dtype, read, length, memory // 2)

    def seen(window: Rectangle) -> list[Rectangle]:
        return [parts[k] for k in source.seen_by(target, conversion.size, window)]

    def converted(window: Rectangle, seen: Sequence[Rectangle]) -> NDArray[Any]:
        held = [(part.index, partial(read, part)) for part in seen]
        # Nothing else may hold the source, which is let go of when it is full.
        (texels,) = convert_seen(
            conversion, held, [window], source=None if kept is None else kept.with_parts(seen)
        )
        return texels

    return Sight(seen, length, converted)


def chained(
    chain: Chained, read: Callable[[Rectangle], NDArray[Any]], file: LevelFile, memory: int
) -> Sight:
    """Return how a conversion sees a source, of which it looks levels up as well."""
    length = partial(_length, chain.shape[-1] * chain.dtype.itemsize)
    tile, room = _tile(chain.shape[:-1], memory), memory // 2
    kept = _Kept(chain.shape, chain.dtype, lambda part: chain.weighed(read(part)), length, room)
    way = _Chain(chain, file, kept, length, tile, room)
    return Sight(way.seen, length, way.converted)


@dataclass(frozen=True)
class _Chain:
    """Lookups in levels, and in what is kept of the source."""

    chain: Chained
    file: LevelFile
    kept: _Kept
    length: Callable[[Iterable[Rectangle]], int]
    tile: tuple[int, int]
    room: int

    def seen(self, window: Rectangle) -> list[Rectangle]:
        return self.chain.seen(window, self.tile)

    def converted(self, window: Rectangle, seen: Sequence[Rectangle]) -> NDArray[Any]:
        if self.length(seen) <= self.room:
            image, levels = self.kept.with_parts(seen), self.file.levels()
            texels, saw = self.chain.window(image, levels, window, self.tile)
            # Nothing else may hold the source, which is let go of when it is full.
            del image
            if self.kept.has(saw):
                return texels
            if self.length(saw) <= self.room:
                return self.converted(window, saw)
            seen = saw
        conversion = self.chain.conversion
        height, width = window.bottom - window.top, window.right - window.left
        made = np.empty((height, width, *conversion.channels), conversion.dtype)
        for part in quarters(window, self.length(seen)):
            rows = slice(part.top - window.top, part.bottom - window.top)
            columns = slice(part.left - window.left, part.right - window.left)
            made[rows, columns] = self.converted(part, self.seen(part))
        return made


def _tile(shape: tuple[int, ...], memory: int) -> tuple[int, int]:
    """Return rows and columns of tiles, of which there are not too many."""
    rows, columns = _TILE
    *faces, height, width = shape
    rest = math.prod(faces) * _KEPT
    while math.ceil(height / rows) * math.ceil(width / columns) * rest > memory // 16:
        rows, columns = 2 * rows, 2 * columns
    return rows, columns


class _Kept:
    """The source with what the last windows saw: neighbors see much of the same."""

    def __init__(
        self,
        shape: tuple[int, ...],
        dtype: np.dtype[Any],
        read: Callable[[Rectangle], NDArray[Any]],
        length: Callable[[Iterable[Rectangle]], int],
        room: int,
    ) -> None:
        self._shape, self._dtype, self._read = shape, dtype, read
        self._length, self._room = length, room
        self._forget()

    def with_parts(self, seen: Sequence[Rectangle]) -> NDArray[Any]:
        """Return the source, in which these parts are there."""
        if self._length(self._there.union(seen)) > self._room:
            self._forget()
        for part in seen:
            if part not in self._there:
                self._texels[part.index] = self._read(part)
                self._there.add(part)
        return self._texels

    def has(self, parts: Iterable[Rectangle]) -> bool:
        """Tell whether these parts are there."""
        return self._there.issuperset(parts)

    def _forget(self) -> None:
        self._texels = sparse_zeros(self._shape, self._dtype)
        self._there: set[Rectangle] = set()


def _texel(conversion: Conversion) -> int:
    """Return what a texel of the source takes, in bytes."""
    numbers, itemsize = conversion.shape[-1], conversion.dtype.itemsize
    if weighs(conversion):
        # Floats, and a weight for each where some may be not finite.
        numbers *= 2 if conversion.dtype.kind == "f" else 1
        itemsize = max(itemsize, 4)
    return numbers * itemsize


def _length(texel: int, parts: Iterable[Rectangle]) -> int:
    """Return the memory of tiles, in bytes: rows of neighbors follow each other in pages."""
    length, last = 0, None
    for part in sorted(parts, key=lambda part: (part.face or 0, part.top, part.left)):
        row = (part.right - part.left) * texel
        if last is None or (part.face, part.top, part.left) != (last.face, last.top, last.right):
            # Where a run of neighbors begins and ends, it has parts of pages.
            row += 4096
        length += (part.bottom - part.top) * row
        last = part
    return length


def quarters(window: Rectangle, length: int) -> list[Rectangle]:
    """Return the parts of a window, or raise where it has none."""
    height, width = window.bottom - window.top, window.right - window.left
    if height == width == 1:
        raise ValueError(
            f"Expected `memory` to be at least {2 * length} bytes, which a texel needs that sees "
            "so much of the source."
        )
    half = ((height + 1) // 2, (width + 1) // 2)
    return [
        Rectangle(
            window.top + p.top,
            window.top + p.bottom,
            window.left + p.left,
            window.left + p.right,
            window.face,
        )
        for p in tiles((height, width), half)
    ]
