"""Files made from files part by part: in little memory, and going on where they were cut off.

A part of the result is made of the tiles of the source that it sees, which OpenImageIO's cache
reads, and put into a file of bare texels beside the target. When all are there, the target is
written from it. What is there already outlives the process: a call that was cut off goes on.
Filters that look a mip chain up have its levels in one more file.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._progress import done
from .._progress import part as share
from ..map.named import resolve_pair
from ..resample.chained import Chained
from ..resample.conversion import Conversion, needs_chain
from ..resample.seen import Rectangle, tiles
from .levels import LevelFile
from .reading import Reader, Source
from .room import set_aside
from .sight import Sight, chained, plain, quarters
from .tiling import has_tiles, in_tiles, removed

if TYPE_CHECKING:
    from numpy.typing import NDArray


__all__ = ["LEAST_MEMORY", "cached", "convert_parts", "expect_memory", "fill"]

# A part of the result has at most so many rows and columns.
_MOST = 1024

# Seconds after which the disk is asked to have all: what a power cut would take of a call.
_SAY = 2.0

# How much of the time it takes to decode a file into tiles, as far as anybody can tell.
_TILING = 0.3

# How much longer a lookup takes than a texel of a chain, about.
_LOOKUP = 4.0

# What a call takes whatever its images are.
LEAST_MEMORY = 64 << 20


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
    expect_memory(memory, LEAST_MEMORY)
    conversion.nothing()
    kind = stored(np.zeros((1, 1, conversion.shape[-1]), conversion.dtype))
    columns, cache = conversion.shape[-2], cached(memory)
    reader = Reader(source, columns, cache) if has_tiles(source) else None
    name = _name(source, conversion, memory, f"{kind.dtype} {said}")
    made = _Made(target, (*conversion.size, kind.shape[-1]), kind.dtype, name, keep)
    folder = target.with_name(f".{target.stem}.spheremap-tiles-{name}")
    levels = target.with_name(f".{target.stem}.spheremap-levels-{name}")
    begins = 0.0 if reader else _TILING
    try:
        if reader is None:
            if not keep:
                removed(folder)
            with share(0.0, begins):
                reader = Reader(in_tiles(source, folder, memory // 8), columns, cache)
        with share(begins, 1.0):
            fill(
                conversion,
                reader.read,
                lambda window, texels: made.put(window, stored(texels)),
                memory,
                levels,
                keep=keep,
                first=made.count,
                finished=made.finished,
            )
        put(made.texels())
    except BaseException:
        made.leave(keep)
        if not keep:
            removed(folder)
            levels.unlink(missing_ok=True)
        raise
    made.leave(False)
    removed(folder)
    levels.unlink(missing_ok=True)


def expect_memory(memory: int, least: int) -> None:
    """Raise where there is less memory than a call takes whatever its images are."""
    if memory < least:
        raise ValueError(f"Expected `memory` to be at least {least} bytes, got {memory}.")


def cached(memory: int) -> int:
    """Return what the cache of a source may take of a call's memory."""
    return 3 * memory // 8


def _name(source: Source, conversion: Conversion, memory: int, said: str) -> str:
    """Return what tells a conversion from all others."""
    found = [(os.path.realpath(file), os.stat(file)) for file in source.files]
    words = [[path, stat.st_size, stat.st_mtime_ns] for path, stat in found]
    maps = [repr(conversion.src), repr(conversion.dst), conversion.size]
    settings = [source.part, memory, repr(conversion.options), said]
    text = json.dumps([words, maps, settings], default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


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
                try:
                    set_aside(file, whole)
                except OSError as error:
                    self.leave(False)
                    why = f"no room for its texels beside it: {error.strerror}"
                    raise OSError(f"cannot write {str(target)!r}: {why}") from None

        with open(self._path, "rb") as file:
            file.seek(self._length)
            self._finished = int.from_bytes(file.read(8), "little")
        self._said = time.monotonic()

    @property
    def count(self) -> int:
        """How many parts are there."""
        return self._finished

    def put(self, window: Rectangle, texels: NDArray[Any]) -> None:
        """Store a window."""
        self._mapped("r+")[window.index] = texels

    def finished(self, count: int) -> None:
        """Say that so many parts are there, once the disk has them: now and then."""
        self._finished = count
        if time.monotonic() - self._said > _SAY:
            self._say()

    def _say(self) -> None:
        with open(self._path, "rb+") as file:
            os.fsync(file.fileno())
            file.seek(self._length)
            file.write(self._finished.to_bytes(8, "little"))
        self._said = time.monotonic()

    def texels(self) -> NDArray[Any]:
        """Return all, read from the file as they are needed."""
        return self._mapped("r")

    def leave(self, keep: bool) -> None:
        """Remove the file, or leave it for another call."""
        with suppress(OSError):
            if keep:
                self._say()
            else:
                self._path.unlink()

    def _mapped(self, mode: Any) -> NDArray[Any]:
        return np.memmap(self._path, self._dtype, mode, shape=self._shape)


def fill(
    conversion: Conversion,
    read: Callable[[Rectangle], NDArray[Any]],
    put: Callable[[Rectangle, NDArray[Any]], None],
    memory: int,
    levels: Path,
    *,
    keep: bool = False,
    first: int = 0,
    finished: Callable[[int], None] | None = None,
) -> None:
    """Make the parts of a result, one by one.

    Parameters
    ----------
    conversion : Conversion
    read : callable
        Returns the texels of a part of the source.
    put : callable
        Is given each part of the result.
    memory : int
        In bytes; half of it is for what a part sees, and an eighth for a part.
    levels : Path
        The file for the levels of a mip chain, where the filter looks them up.
    keep : bool
        Whether that file outlives a call that is cut off.
    first : int
        How many windows are there already.
    finished : callable, optional
        Is told how many windows are there, after each.
    """
    if not needs_chain(conversion.options["filter"]):
        _fill(conversion, plain(conversion, read, memory), put, memory, first, finished)
        return
    chain = Chained(conversion)
    # A lookup takes longer than a mean does.
    averaged = math.prod(conversion.shape[:-1])
    begins = averaged / (averaged + _LOOKUP * math.prod(conversion.size))
    file = LevelFile(chain, levels, keep)
    try:
        with share(0.0, begins):
            file.make(read, memory // 2)
        sight = chained(chain, read, file, memory)
        with share(begins, 1.0):
            _fill(conversion, sight, put, memory, first, finished)
    finally:
        file.leave(keep)


def _fill(
    conversion: Conversion,
    sight: Sight,
    put: Callable[[Rectangle, NDArray[Any]], None],
    memory: int,
    first: int,
    finished: Callable[[int], None] | None,
) -> None:
    """Make the parts of a result, one by one, of what they see."""
    # A conversion may take some floats for each of the numbers that it makes.
    side = max(1, min(_MOST, math.isqrt(memory // 8 // (16 * conversion.shape[-1]))))
    target = resolve_pair(conversion.src, conversion.dst, None, conversion.options["world"])[1]
    windows = tiles(conversion.size, (side, side), target)

    for k in range(first, len(windows)):
        with share(k / len(windows), (k + 1) / len(windows)):
            for window, seen in _divided(windows[k], sight, memory // 2):
                put(window, sight.converted(window, seen))
        if finished is not None:
            finished(k + 1)
        done((k + 1) / len(windows))


# By itself: a function that calls itself from inside of another would hold the texels that were
# seen until Python looks for what holds itself.
def _divided(
    window: Rectangle, sight: Sight, room: int
) -> Iterator[tuple[Rectangle, list[Rectangle]]]:
    """Yield parts of a window that see no more than there is memory for, and what they see."""
    seen = sight.seen(window)
    length = sight.length(seen)
    if length <= room:
        yield window, seen
        return
    for quarter in quarters(window, length):
        yield from _divided(quarter, sight, room)
