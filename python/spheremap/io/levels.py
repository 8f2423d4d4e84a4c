"""The levels of a mip chain, but the first, in a file: no level has to fit into memory.

The levels are mapped where they are read. Pages of files are not counted, for the system takes
them back when it needs the room.
"""

from __future__ import annotations

import math
import mmap
import os
import tempfile
from contextlib import suppress
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from .._progress import done
from ..resample.seen import tiles
from .room import set_aside

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

    from ..resample.chained import Chained
    from ..resample.seen import Rectangle

__all__ = ["LevelFile"]

# A window of a level has at most so many rows and columns.
_MOST = 1024

# Bytes that a texel of a level takes while it is made, for the solid angles of what it covers; and
# each of its numbers, for the four that are read, in as many copies as change them.
_TEXEL, _NUMBER = 64, 96

# What stands behind the levels once all are there.
_WHOLE = b"complete"


class LevelFile:
    """Levels in a file, one after the other.

    Parameters
    ----------
    chained : Chained
    place : Path
        The file, if it is to outlive the process; else one without a name stands in its folder.
    keep : bool
        Whether it is.

    Raises
    ------
    OSError
        Where there is no room.
    """

    def __init__(self, chained: Chained, place: Path, keep: bool) -> None:
        self._chained, self._place, self._keep = chained, place, keep
        lengths = [math.prod(shape) * chained.floats.itemsize for shape in chained.shapes]
        self._begins = np.cumsum([0, *lengths]).tolist()
        self._file = self._opened()
        try:
            if not self._is_whole():
                self._file.truncate(0)
                set_aside(self._file, self._begins[-1] + len(_WHOLE))
        except OSError as error:
            self.leave(False)
            why = f"no room for the levels of its mip chain: {error.strerror}"
            raise OSError(f"cannot write in {str(place.parent)!r}: {why}") from None

    def _opened(self) -> IO[bytes]:
        if not self._keep:
            return tempfile.TemporaryFile(
                buffering=0, prefix=".spheremap-levels-", dir=self._place.parent
            )
        # One that is there is not emptied.
        handle = os.open(self._place, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
        return open(handle, "r+b", buffering=0)

    def _is_whole(self) -> bool:
        """Tell whether all levels are there, from a call before."""
        if os.fstat(self._file.fileno()).st_size != self._begins[-1] + len(_WHOLE):
            return False
        self._file.seek(self._begins[-1])
        return self._file.read(len(_WHOLE)) == _WHOLE

    def make(self, read: Callable[[Rectangle], NDArray[Any]], memory: int) -> None:
        """Make all levels that are not there, in so many bytes.

        `read` returns the texels of a part of the source.
        """
        if self._is_whole():
            return
        chained = self._chained
        numbers = max(chained.shape[-1], chained.conversion.shape[-1])
        side = max(1, min(_MOST, math.isqrt(memory // (_TEXEL + _NUMBER * numbers))))
        src = chained.conversion.src
        total = sum(math.prod(shape[:-1]) for shape in chained.shapes)
        there = 0
        for level in range(len(chained.shapes)):
            for window in tiles(chained.shapes[level][:-1], (side, side), src):
                needed = chained.needed(level, window)
                if level:
                    texels = np.array(self.levels()[level - 1][needed.index])
                else:
                    texels = chained.weighed(read(needed))
                made = chained.halved(level, window, needed, texels)
                self._mapped(mmap.ACCESS_WRITE)[level][window.index] = made
                there += math.prod(made.shape[:2])
                done(there / total)
        if self._keep:
            # A power cut may keep what is written last, and not what was before.
            os.fsync(self._file.fileno())
            self._file.seek(self._begins[-1])
            self._file.write(_WHOLE)

    def levels(self) -> list[NDArray[Any]]:
        """Return the levels, read from the file as they are needed."""
        return self._mapped(mmap.ACCESS_READ)

    def leave(self, keep: bool) -> None:
        """Close the file, and remove it unless it is to be left for another call."""
        self._file.close()
        if self._keep and not keep:
            with suppress(OSError):
                self._place.unlink()

    def _mapped(self, access: int) -> list[NDArray[Any]]:
        # Anew each time: pages of a map that stays count as memory of the process.
        pages = mmap.mmap(self._file.fileno(), 0, access=access)
        kind, shapes = self._chained.floats, self._chained.shapes
        return [
            np.frombuffer(pages, kind, math.prod(shape), begin).reshape(shape)
            for shape, begin in zip(shapes, self._begins, strict=False)
        ]
