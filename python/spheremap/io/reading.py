"""Parts of image files, read as they are needed, the last ones from a cache."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..resample.seen import Rectangle
from .header import KINDS
from .opened import library, one_line, opened

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Reader", "Source"]

# Rows and columns of what the cache keeps of files without tiles.
_CACHED = 128


@dataclass(frozen=True, slots=True)
class Source:
    """An image in a file, or one in as many files as it has faces; and its texels there."""

    files: Sequence[str]
    part: int
    dtype: np.dtype[Any]
    channels: int
    # What of a file's texels (H, W, C) is converted: each by itself, and of the conversion's dtype.
    taken: Callable[[NDArray[Any]], NDArray[Any]]


class Reader:
    """Tiles of an image file, of which the last ones are remembered."""

    def __init__(self, source: Source, columns: int, memory: int) -> None:
        """`columns` are those of a file, and `memory` is what its cache may take, in bytes."""
        oiio = library()
        self._source = source
        self._kind = oiio.TypeDesc(KINDS[source.dtype.name])
        # Of a file without tiles the cache reads strips; one of them has to stay.
        row = columns * source.channels * source.dtype.itemsize
        strip = _CACHED
        while strip > 16 and strip * row > 4 * memory // 9:
            strip //= 2
        for file in source.files:
            _expect_tiles(file, source.part, memory)
        self._cache = oiio.ImageCache(False)
        for word, value in (
            ("max_memory_MB", memory / (1 << 20)),
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
