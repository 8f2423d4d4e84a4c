"""Files made from files part by part: in little memory, and going on where they were cut off.

A part of the result is made of the tiles of the source that it sees, which OpenImageIO's cache
reads, and put into a file of bare texels beside the target. When all are there, the target is
written from it. What is there already outlives the process: a call that was cut off goes on.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._progress import done
from ..map.named import resolve_pair
from ..resample.conversion import Conversion
from ..resample.parts import convert_seen, weighs
from ..resample.seen import Rectangle, SourceTiles, tiles
from .header import KINDS
from .opened import library, one_line, opened

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Source", "convert_parts"]

# Rows and columns of what is read at once; of what the cache keeps of files without tiles.
_TILE, _CACHED = (128, 512), 128

# A part of the result has at most so many rows and columns.
_MOST = 1024

# What a call takes whatever its images are, and what is kept of a tile of the source.
_LEAST_MEMORY, _KEPT = 64 << 20, 256


@dataclass(frozen=True, slots=True)
class Source:
    """An image in a file, or one in as many files as it has faces; and its texels there."""

    files: Sequence[str]
    part: int
    dtype: np.dtype[Any]
    channels: int
    # What of a file's texels (H, W, C) is converted: each by itself, and of the conversion's dtype.
    taken: Callable[[NDArray[Any]], NDArray[Any]]


def convert_parts(
    source: Source,
    target: Path,
    conversion: Conversion,
    stored: Callable[[NDArray[Any]], NDArray[Any]],
    put: Callable[[NDArray[Any]], None],
    *,
    memory: int,
    keep: bool,
    said: str = "",
) -> None:
    """Convert an image part by part, and give all of it to `put`, as a map of a file.

    Parameters
    ----------
    source : Source
    target : Path
        Beside which the texels stand.
    conversion : Conversion
    stored : callable
        Returns what is kept of texels (H, W, C) of the result, each by itself.
    put : callable
        Writes the target.
    memory : int
        In bytes.
    keep : bool
        Whether to go on with what was left behind, and to leave that behind.
    said : str
        What tells this call from others that have the same files and the same conversion.
    """
    if memory < _LEAST_MEMORY:
        raise ValueError(f"Expected `memory` to be at least {_LEAST_MEMORY} bytes, got {memory}.")
    conversion.nothing()
    kind = stored(np.zeros((1, 1, conversion.shape[-1]), conversion.dtype))
    reader = _Reader(source, conversion, memory)
    name = _name(source, conversion, memory, f"{kind.dtype} {said}")
    made = _Made(target, (*conversion.size, kind.shape[-1]), kind.dtype, name, keep)
    there = resolve_pair(conversion.src, conversion.dst, None, conversion.options["world"])[1]
    try:
        _fill(made, conversion, reader, there, stored, memory)
        put(made.texels())
    except BaseException:
        made.leave(keep)
        raise
    made.leave(False)


def _name(source: Source, conversion: Conversion, memory: int, said: str) -> str:
    """Return what tells a conversion from all others."""
    found = [(os.path.realpath(file), os.stat(file)) for file in source.files]
    words = [[path, stat.st_size, stat.st_mtime_ns] for path, stat in found]
    maps = [repr(conversion.src), repr(conversion.dst), conversion.size]
    settings = [source.part, memory, repr(conversion.options), said]
    text = json.dumps([words, maps, settings], default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


class _Reader:
    """Tiles of an image file, of which the last ones are remembered."""

    def __init__(self, source: Source, conversion: Conversion, memory: int) -> None:
        oiio = library()
        self._source = source
        self._kind = oiio.TypeDesc(KINDS[source.dtype.name])
        # Of a file without tiles the cache reads strips; one of them has to stay.
        row = conversion.shape[-2] * source.channels * source.dtype.itemsize
        strip = _CACHED
        while strip > 16 and strip * row > memory // 6:
            strip //= 2
        cached = 3 * memory // 8
        for file in source.files:
            _expect_tiles(file, source.part, cached)
        self._cache = oiio.ImageCache(False)
        for word, value in (
            ("max_memory_MB", cached / (1 << 20)),
            ("autotile", strip),
            ("unassociatedalpha", 1),
        ):
            self._cache.attribute(word, value)

    def read(self, part: Rectangle) -> NDArray[Any]:
        """Return the texels of a part."""
        file = self._source.files[part.face or 0]
        found = self._cache.get_pixels(
            file,
            self._source.part,
            0,
            part.left,
            part.right,
            part.top,
            part.bottom,
            datatype=self._kind,
        )
        if found is None:
            raise OSError(f"cannot read {file!r}: {one_line(self._cache.geterror())}")
        return self._source.taken(np.asarray(found))


def _expect_tiles(file: str, part: int, cached: int) -> None:
    """Raise where the tiles of a file are too large for the cache: it reads whole ones."""
    with opened(file, part) as handle:
        spec = handle.spec()
        length = 4 * spec.tile_bytes(True)
    if spec.tile_width and length > cached:
        raise ValueError(
            f"Expected `memory` to be at least {math.ceil(length * 8 / 3)} bytes for {file!r}, "
            f"whose tiles have {spec.tile_width} x {spec.tile_height} texels."
        )


class _Made:
    """The texels of a result in a file beside its place, and how many parts are there.

    The number stands behind the texels and is written after them.
    """

    def __init__(
        self, target: Path, shape: tuple[int, ...], dtype: np.dtype[Any], said: str, keep: bool
    ) -> None:
        self._shape, self._dtype = shape, dtype
        self._path = target.with_name(f".{target.stem}.spheremap-texels-{said}")
        self._length = math.prod(self._shape) * dtype.itemsize
        whole = self._length + 8
        if not (keep and self._path.exists() and self._path.stat().st_size == whole):
            with open(self._path, "wb") as file:
                file.truncate(whole)
                # Without room set aside, a full disk would end the process at a store.
                if hasattr(os, "posix_fallocate"):
                    try:
                        os.posix_fallocate(file.fileno(), 0, whole)
                    except OSError as error:
                        self.leave(False)
                        why = f"no room for its texels beside it: {error.strerror}"
                        raise OSError(f"cannot write {str(target)!r}: {why}") from None

    @property
    def count(self) -> int:
        """How many parts are there."""
        with open(self._path, "rb") as file:
            file.seek(self._length)
            return int.from_bytes(file.read(8), "little")

    def put(self, window: Rectangle, texels: NDArray[Any]) -> None:
        """Store a window."""
        self._mapped("r+")[window.index] = texels

    def finished(self, count: int) -> None:
        """Say that so many parts are there, once the disk has them."""
        with open(self._path, "rb+") as file:
            os.fsync(file.fileno())
            file.seek(self._length)
            file.write(count.to_bytes(8, "little"))

    def texels(self) -> NDArray[Any]:
        """Return all, read from the file as they are needed."""
        return self._mapped("r")

    def leave(self, keep: bool) -> None:
        """Remove the file, or leave it for another call."""
        if not keep:
            with suppress(OSError):
                self._path.unlink()

    def _mapped(self, mode: Any) -> NDArray[Any]:
        return np.memmap(self._path, self._dtype, mode, shape=self._shape)


def _fill(
    made: _Made,
    conversion: Conversion,
    reader: _Reader,
    target: Projection,
    stored: Callable[[NDArray[Any]], NDArray[Any]],
    memory: int,
) -> None:
    """Make all parts of the result that are not there."""
    channels = conversion.shape[-1]
    shape = conversion.shape[:-1]
    parts = tiles(shape, _tile(shape, memory))
    source = SourceTiles(conversion.src, shape, parts)
    # A conversion may take some floats for each of the numbers that it makes.
    side = max(1, min(_MOST, math.isqrt(memory // 8 // (16 * channels))))
    windows = tiles(conversion.size, (side, side))

    def divided(window: Rectangle) -> Iterator[tuple[Rectangle, list[Rectangle]]]:
        """Yield parts of a window that see no more than there is memory for, and what they see."""
        seen = [parts[k] for k in source.seen_by(target, conversion.size, window)]
        length = sum(_length(part, conversion) for part in seen)
        if length <= memory // 2:
            yield window, seen
            return
        for quarter in _quarters(window, length):
            yield from divided(quarter)

    for k in range(made.count, len(windows)):
        for window, seen in divided(windows[k]):
            held = [(part.index, partial(reader.read, part)) for part in seen]
            (texels,) = convert_seen(conversion, held, [window])
            made.put(window, stored(texels))
        made.finished(k + 1)
        done((k + 1) / len(windows))


def _tile(shape: tuple[int, ...], memory: int) -> tuple[int, int]:
    """Return rows and columns of tiles, of which there are not too many."""
    rows, columns = _TILE
    *faces, height, width = shape
    rest = math.prod(faces) * _KEPT
    while math.ceil(height / rows) * math.ceil(width / columns) * rest > memory // 16:
        rows, columns = 2 * rows, 2 * columns
    return rows, columns


def _length(part: Rectangle, conversion: Conversion) -> int:
    """Return the memory of a tile, whose rows begin and end within pages, in bytes."""
    numbers, itemsize = conversion.shape[-1], conversion.dtype.itemsize
    if weighs(conversion):
        # Floats, and a weight for each where some may be not finite.
        numbers *= 2 if conversion.dtype.kind == "f" else 1
        itemsize = max(itemsize, 4)
    row = (part.right - part.left) * numbers * itemsize
    return (part.bottom - part.top) * (row + 4096)


def _quarters(window: Rectangle, length: int) -> list[Rectangle]:
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
