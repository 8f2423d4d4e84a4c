"""Images and levels in files, of which only parts are in memory."""

from __future__ import annotations

import math
import mmap
import tempfile
import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._progress import part as share
from ..io.parts import cached, fill
from ..io.reading import Reader, Source
from ..io.room import set_aside
from ..io.tiling import has_tiles, in_tiles
from .colors import light

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..resample.conversion import Conversion
    from ..resample.seen import Rectangle

__all__ = ["FileImage", "FileLevel"]

# How much of the time it takes to decode a file into tiles, as far as anybody can tell.
_TILING = 0.3


@dataclass(frozen=True)
class FileImage:
    """An image in a file, and what may be taken beside it, in bytes."""

    source: Source
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    memory: int

    def converted(self, conversion: Conversion, folder: Path) -> FileLevel:
        """Return it in another projection."""
        conversion.nothing()
        made = FileLevel((*conversion.size, self.shape[-1]), self.dtype, self.memory, folder)
        source, columns, begins = self.source, self.shape[-2], 0.0
        with tempfile.TemporaryDirectory(prefix=".spheremap-tiles-", dir=folder) as copies:
            if not has_tiles(source):
                begins = _TILING
                with share(0.0, begins):
                    source = in_tiles(source, Path(copies), self.memory // 8)
            with share(begins, 1.0):
                reader = Reader(source, columns, cached(self.memory))
                fill(conversion, reader.read, made.put, self.memory, Path(copies) / "levels")
        return made


class FileLevel:
    """A level in a file without a name, which is gone with it, or with the process."""

    def __init__(
        self, shape: tuple[int, ...], dtype: np.dtype[Any], memory: int, folder: Path
    ) -> None:
        self.shape, self.dtype, self.memory = shape, dtype, memory
        self.is_finite, self.has_nan = True, False
        self._folder = folder
        # It is open for as long as the level is there.
        self._file = tempfile.TemporaryFile(prefix=".spheremap-level-", dir=folder)  # noqa: SIM115
        weakref.finalize(self, self._file.close)
        try:
            set_aside(self._file, math.prod(shape) * dtype.itemsize)
        except OSError as error:
            why = f"no room for its texels: {error.strerror}"
            raise OSError(f"cannot write {str(folder)!r}: {why}") from None

    def read(self, part: Rectangle) -> NDArray[Any]:
        """Return the texels of a part."""
        return np.array(self._mapped(mmap.ACCESS_READ)[part.index])

    def put(self, part: Rectangle, texels: NDArray[Any]) -> None:
        """Store those of a part."""
        self._mapped(mmap.ACCESS_WRITE)[part.index] = texels
        if self.dtype.kind == "f" and not np.isfinite(texels).all():
            self.is_finite = False
            self.has_nan = self.has_nan or bool(np.isnan(texels).any())

    def empty(self, shape: tuple[int, ...]) -> FileLevel:
        """Return a level of light beside this one, in which nothing is yet."""
        return FileLevel(shape, np.dtype(np.float32), self.memory, self._folder)

    def light_converted(self, conversion: Conversion) -> FileLevel:
        """Return its light in another projection."""
        made = self.empty((*conversion.size, self.shape[-1]))
        levels = self._folder / ".spheremap-levels"
        fill(conversion, lambda part: light(self.read(part)), made.put, self.memory, levels)
        return made

    def _mapped(self, access: int) -> NDArray[Any]:
        # Anew each time: pages of a map that stays count as memory of the process.
        pages = mmap.mmap(self._file.fileno(), 0, access=access)
        return np.frombuffer(pages, self.dtype).reshape(self.shape)
