"""Copies of image files in tiles.

Of a file in strips, or one that is read from its top alone, a part costs all that lies beside or
above it: a cube made of a panorama in little memory decoded each strip many times. Such a file is
decoded once, into one of tiles that are not compressed.
"""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._progress import counted, done
from .header import KINDS
from .opened import expect_complete, library, one_line, opened, said_by

if TYPE_CHECKING:
    from .reading import Source

__all__ = ["has_tiles", "in_tiles", "removed"]

# Rows and columns of a tile; fewer rows, a multiple of 16, where a strip would be too large.
_TILE = 128


def has_tiles(source: Source) -> bool:
    """Return whether all files of an image are in tiles."""

    def is_tiled(file: str) -> bool:
        with opened(file, source.part) as handle:
            return bool(handle.spec().tile_width)

    return all(map(is_tiled, source.files))


def in_tiles(source: Source, folder: Path, memory: int) -> Source:
    """Return the image of copies of its files, with the same bits.

    Parameters
    ----------
    source : Source
    folder : Path
        For the copies, which take the room of the texels. Those that a call before left there whole
        are taken as they are.
    memory : int
        What a strip may take, in bytes.

    Raises
    ------
    OSError
        For a file that cannot be read, and where there is no room.
    """
    folder.mkdir(exist_ok=True)
    places = [folder / f"{k}.tif" for k in range(len(source.files))]
    for file, place in counted(list(zip(source.files, places, strict=True))):
        if not place.exists():
            _copy(file, source, place, memory)
    return replace(source, files=[str(place) for place in places], part=0)


def removed(folder: Path) -> None:
    """Remove copies, if there are any."""
    with suppress(OSError):
        shutil.rmtree(folder)


def _copy(file: str, source: Source, place: Path, memory: int) -> None:
    beside = place.with_suffix(".part.tif")
    out = library().ImageOutput.create(str(beside))
    with opened(file, source.part) as handle:
        spec = handle.spec()
        rows = _TILE
        while rows > 16 and rows * spec.width * source.channels * source.dtype.itemsize > memory:
            rows //= 2
        tiled = _described(spec.width, spec.height, rows, source)
        if not out.open(str(beside), tiled):
            raise _unwritten(place, out)
        for top in range(spec.y, spec.y + spec.height, rows):
            end = min(top + rows, spec.y + spec.height)
            texels = handle.read_scanlines(top, end, 0, 0, source.channels, tiled.format)
            if texels is None:
                out.close()
                raise OSError(f"cannot read {file!r}: {said_by(handle)}")
            band = 0, spec.width, top - spec.y, end - spec.y, 0, 1
            if not out.write_tiles(*band, texels):
                raise _unwritten(place, out)
            done((end - spec.y) / spec.height)
        expect_complete(handle, file)
    if not out.close():
        raise _unwritten(place, out)
    # What a power cut leaves under this name is whole.
    with open(beside, "rb+") as written:
        os.fsync(written.fileno())
    os.replace(beside, place)


def _described(width: int, height: int, rows: int, source: Source) -> Any:
    """Return what is written: bare numbers, none of which is alpha."""
    oiio = library()
    kind = oiio.TypeDesc(KINDS[source.dtype.name])
    spec = oiio.ImageSpec(width, height, source.channels, kind)
    spec.channelnames = tuple(f"channel{k}" for k in range(source.channels))
    spec.alpha_channel = spec.z_channel = -1
    spec.tile_width, spec.tile_height = _TILE, rows
    for word, value in (("compression", "none"), ("tiff:bigtiff", 1), ("tiff:half", 1)):
        spec.attribute(word, value)
    return spec


def _unwritten(place: Path, out: Any) -> OSError:
    why = one_line(out.geterror())
    return OSError(f"cannot write {str(place)!r}, tiles of a file that has none: {why}")
