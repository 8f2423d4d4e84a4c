"""Image files larger than memory, converted part by part.

A part of the result is made of the tiles of the source that it sees, which OpenImageIO's cache
reads, and put into a file of bare texels beside the target. When all are there, the target is
written from it. What is there already outlives the process: a call that was cut off goes on.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import spatial_axes
from .._progress import done
from .._scalars import as_flag, as_whole
from ..map.images import expect_aspect, target_shape
from ..map.named import resolve, resolve_pair
from ..map.size import matching_size
from ..resample.conversion import Conversion, needs_chain
from ..resample.seen import Rectangle, SourceTiles, tiles
from ..resample.sparse import sparse_zeros
from .header import KINDS, Header, header, header_of
from .images import as_stored, check_target, write
from .opened import library, one_line, opened
from .whole import as_path

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from .._arrays import Size
    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["convert_file"]

# Rows and columns of what is read at once; of what the cache keeps of files without tiles.
_TILE, _CACHED = (128, 512), 128

# A part of the result has at most so many rows and columns.
_MOST = 1024

# What a call takes whatever its images are, and what is kept of a tile of the source.
_LEAST_MEMORY, _KEPT = 64 << 20, 256


def convert_file(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    memory: int = 1 << 29,
    rotation: Any | None = None,
    filter: ConvertFilter | str = "bilinear",
    fill: float | Sequence[float] = 0.0,
    antialias: bool = True,
    world: Worlds = "match",
    any_aspect: bool = False,
    part: int | str | None = None,
    compression: str | None = None,
    noted: str | None = None,
    resume: bool = False,
) -> Header:
    """Convert an image file that may be larger than memory into another.

    Parameters
    ----------
    source, target : path-like
        As for `read` and `write`. Beside the target there has to be room for its texels, once more
        and not compressed, while it is made.
    src, dst, size, rotation, filter, fill, antialias, world, any_aspect
        As for `spheremap.convert`. Faces lie in one image: a cube has a layout, as
        ``sm.projection("cube", layout="cross")``, or a convention that has.
    memory : int
        How many bytes the call may take beyond what is there: at least 64 MiB.
    part, compression
        As for `read` and `write`.
    noted : str, optional
        The `projection` that `write` notes in the target; by default `dst`, where that is a name.
    resume : bool
        Whether to go on with what a call with the same arguments, which was cut off, left behind,
        and to leave that behind when this one is.

    Returns
    -------
    header : Header
        What the target says.

    Raises
    ------
    OSError, ValueError, TypeError, ImportError
        As for `read`, `spheremap.convert` and `write`; for a source that is turned or placed by its
        header; for ``"trilinear"`` and ``"ewa"``, whose mip chain is made of the whole image; and
        for too little memory, which the message says.

    Notes
    -----
    The file holds the bits of ``write(target, convert(read(source), src, dst))``. Values stay as
    they are: no change of color space, and straight alpha is a channel as others.

    Half of the memory is for what a part sees, most of the rest for the cache of the source. Pages
    of files are not counted, which the system holds as long as nobody else needs the room.

    Files in tiles are read where they are needed. Others are read in strips, again and again where
    memory is short: .exr and .tif in strips fast, .png from its top each time.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> sm.io.write(folder / "sky.exr", np.ones((64, 128, 3), np.float32))
    >>> cross = sm.projection("cube", layout="cross")
    >>> made = sm.io.convert_file(
    ...     folder / "sky.exr", folder / "cube.exr", "latlong", cross, size=32, memory=1 << 28
    ... )
    >>> made.height, made.width
    (96, 128)
    """
    if needs_chain(filter):
        raise ValueError(
            f"Expected another `filter` for files in parts, got {filter!r}, whose mip chain is "
            "made of the whole image: filter='area', or antialias=True, averages as well."
        )
    memory, keep = as_whole(memory, "memory"), as_flag(resume, "resume")
    if memory < _LEAST_MEMORY:
        raise ValueError(f"Expected `memory` to be at least {_LEAST_MEMORY} bytes, got {memory}.")
    here, there = resolve(src), resolve(dst)
    for p in (here, there):
        if spatial_axes(p) > 2:
            raise ValueError(
                f"A file holds one image, and '{p.name}' has faces apart: give it a layout, as "
                f'projection("{p.name}", layout="strip").'
            )
    check_target(target, compression=compression)
    with opened(source, part) as handle:
        head, number = header_of(handle), handle.current_subimage()
    shape = _plain(head, source)
    expect_aspect(here, shape, any_aspect)
    here.shape(shape[:2])
    if size is None:
        size = matching_size(shape, here, there)
    options = {
        "filter": filter,
        "fill": fill,
        "antialias": antialias,
        "world": world,
        "skipna": False,
        "any_aspect": True,
    }
    conversion = Conversion(
        resolve(here, rotation=rotation),
        there,
        shape,
        np.dtype(head.dtype),
        target_shape(there, size, any_aspect),
        options,
    )
    # What the format cannot hold is an error before the work.
    place = Path(os.path.realpath(as_path(target)))
    conversion.nothing()
    one = np.zeros((1, 1, shape[-1]), conversion.dtype)
    kind = as_stored(one, place.suffix.lower(), as_path(target)).dtype
    reader = _Reader(as_path(source), number, conversion, memory)
    made = _Made(place, conversion, kind, _said(source, number, conversion, memory), keep)
    try:
        _fill(made, conversion, reader, resolve_pair(conversion.src, there, None, world)[1], memory)
        write(
            target,
            made.texels(),
            compression=compression,
            channels=head.channels,
            color_space=head.color_space,
            projection=dst if noted is None and isinstance(dst, str) else noted,
            metadata=head.metadata,
        )
    except BaseException:
        made.leave(keep)
        raise
    made.leave(False)
    return header(target)


def _plain(head: Header, source: object) -> tuple[int, int, int]:
    """Return the shape of an image that lies in its file as it is to be seen."""
    if head.window != (0, 0, head.height, head.width) or head.orientation != 1:
        raise ValueError(
            f"{os.fspath(source)!r} is turned or placed by its header: "  # type: ignore[call-overload]
            "`read` does as it says, and takes all of it."
        )
    return head.height, head.width, len(head.channels)


def _said(source: Any, number: int, conversion: Conversion, memory: int) -> str:
    """Return what tells a conversion from all others."""
    found = os.stat(source)
    words = [os.path.realpath(source), found.st_size, found.st_mtime_ns, number, memory]
    maps = [repr(conversion.src), repr(conversion.dst), conversion.size]
    text = json.dumps([words, maps, repr(conversion.options)], default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


class _Reader:
    """Tiles of an image file, of which the last ones are remembered."""

    def __init__(self, name: str, number: int, conversion: Conversion, memory: int) -> None:
        oiio = library()
        self._name, self._number = name, number
        self._kind = oiio.TypeDesc(KINDS[conversion.dtype.name])
        # Of a file without tiles the cache reads strips; one of them has to stay.
        row = math.prod(conversion.shape[1:]) * conversion.dtype.itemsize
        strip = _CACHED
        while strip > 16 and strip * row > memory // 6:
            strip //= 2
        self._cache = oiio.ImageCache(False)
        for word, value in (
            ("max_memory_MB", 3 * memory / (8 << 20)),
            ("autotile", strip),
            ("unassociatedalpha", 1),
        ):
            self._cache.attribute(word, value)

    def read(self, part: Rectangle) -> NDArray[Any]:
        """Return the texels of a part."""
        found = self._cache.get_pixels(
            self._name,
            self._number,
            0,
            part.left,
            part.right,
            part.top,
            part.bottom,
            datatype=self._kind,
        )
        if found is None:
            raise OSError(f"cannot read {self._name!r}: {one_line(self._cache.geterror())}")
        return np.asarray(found)


class _Made:
    """The texels of a result in a file beside its place, and how many parts are there.

    The number stands behind the texels and is written after them.
    """

    def __init__(
        self, target: Path, conversion: Conversion, dtype: np.dtype[Any], said: str, keep: bool
    ) -> None:
        self._shape = (*conversion.size, conversion.shape[-1])
        self._dtype, self._extension = dtype, target.suffix.lower()
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
        self._mapped("r+")[window.index] = as_stored(texels, self._extension, self._path.name)

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
    made: _Made, conversion: Conversion, reader: _Reader, target: Projection, memory: int
) -> None:
    """Make all parts of the result that are not there."""
    channels = conversion.shape[-1]
    parts = tiles(conversion.shape[:2], _tile(conversion.shape, memory))
    source = SourceTiles(conversion.src, conversion.shape[:2], parts)
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
            image = sparse_zeros(conversion.shape, conversion.dtype)
            for part in seen:
                image[part.index] = reader.read(part)
            made.put(window, conversion.window(image, window.window, conversion.options))
        made.finished(k + 1)
        done((k + 1) / len(windows))


def _tile(shape: tuple[int, ...], memory: int) -> tuple[int, int]:
    """Return rows and columns of tiles, of which there are not too many."""
    rows, columns = _TILE
    while math.ceil(shape[0] / rows) * math.ceil(shape[1] / columns) * _KEPT > memory // 16:
        rows, columns = 2 * rows, 2 * columns
    return rows, columns


def _length(part: Rectangle, conversion: Conversion) -> int:
    """Return the memory of a tile, whose rows begin and end within pages, in bytes."""
    row = (part.right - part.left) * conversion.shape[-1] * conversion.dtype.itemsize
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
            window.top + p.top, window.top + p.bottom, window.left + p.left, window.left + p.right
        )
        for p in tiles((height, width), half)
    ]
