"""Image files larger than memory, converted part by part."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import spatial_axes
from .._scalars import as_flag, as_whole
from ..map.images import expect_aspect, target_shape
from ..map.named import resolve
from ..map.size import matching_size
from ..resample.conversion import Conversion
from .header import Header, header, header_of
from .images import as_stored, check_target, write_copy
from .noted import as_noted
from .opened import opened
from .parts import convert_parts
from .reading import Source
from .whole import as_path

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .._arrays import Size
    from .._names import ConvertFilter
    from ..map.named import ProjectionLike, Worlds

__all__ = ["convert_file", "expect_plain"]


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
    skipna: bool = False,
    antialias: bool = True,
    alpha: int | None = None,
    world: Worlds = "match",
    any_aspect: bool = False,
    part: int | str | None = None,
    compression: str | None = None,
    noted: ProjectionLike | None = None,
    resume: bool = False,
) -> Header:
    """Convert an image file that may be larger than memory into another.

    Parameters
    ----------
    source, target : path-like
        As for `read` and `write`. Beside the target there has to be room for its texels, once more
        and not compressed, while it is made; for those of a source without tiles; and, of
        ``"trilinear"`` and ``"ewa"``, for the levels of the source's mip chain.
    src, dst, size, rotation, filter, fill, skipna, antialias, alpha, world, any_aspect
        As for `spheremap.convert`. Faces lie in one image: a cube has a layout, as
        ``sm.projection("cube", layout="cross")``, or a convention that has.
    memory : int
        How many bytes the call may take beyond what is there: at least 64 MiB.
    part, compression
        As for `read` and `write`.
    noted : Projection or str, optional
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
        header; and for too little memory, which the message says.

    Notes
    -----
    The file holds the bits of ``write(target, convert(read(source), src, dst))``. Values stay as
    they are: no change of color space, and straight alpha is a channel as others, unless `alpha`
    says which one it is.

    Half of the memory is for what a part sees, most of the rest for the cache of the source. Pages
    of files are not counted, which the system holds as long as nobody else needs the room.

    ``"trilinear"`` and ``"ewa"`` look a mip chain up: it is made first, level by level, into a file
    beside the target, a third as large as the source is in floats. The source is read twice.

    Files in tiles are read where they are needed. Others, as most .exr and .tif and all .png, .jpg
    and .hdr, are decoded once, into a file of tiles beside the target.

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
    memory, keep = as_whole(memory, "memory"), as_flag(resume, "resume")
    here, there = resolve(src), resolve(dst)
    if noted is None and isinstance(dst, str):
        noted = dst
    said = None if noted is None else as_noted(noted)
    for p in (here, there):
        if spatial_axes(p) > 2:
            raise ValueError(
                f"A file holds one image, and '{p.name}' has faces apart: give it a layout, as "
                f'projection("{p.name}", layout="strip").'
            )
    check_target(target, compression=compression)
    with opened(source, part) as handle:
        head, number = header_of(handle), handle.current_subimage()
    expect_plain(head, source)
    shape = head.height, head.width, len(head.channels)
    expect_aspect(here, shape, any_aspect)
    here.shape(shape[:2])
    if size is None:
        size = matching_size(shape, here, there)
    options = {
        "filter": filter,
        "fill": fill,
        "antialias": antialias,
        "world": world,
        "skipna": skipna,
        "alpha": alpha,
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
    name = as_path(target)
    place = Path(os.path.realpath(name))
    dtype = np.dtype(head.dtype)
    files = Source([as_path(source)], number, dtype, shape[-1], lambda texels: texels)

    def stored(texels: NDArray[Any]) -> NDArray[Any]:
        return as_stored(texels, place.suffix.lower(), name)

    def put(texels: NDArray[Any]) -> None:
        write_copy(
            target,
            texels,
            compression=compression,
            channels=head.channels,
            color_space=head.color_space,
            projection=said,
            metadata=head.metadata,
        )

    convert_parts(files, place, conversion, stored, put, memory=memory, keep=keep)
    return header(target)


def expect_plain(head: Header, source: str | os.PathLike[str]) -> None:
    """Raise where an image does not lie in its file as it is to be seen."""
    if head.window != (0, 0, head.height, head.width) or head.orientation != 1:
        raise ValueError(
            f"{os.fspath(source)!r} is turned or placed by its header: "
            "`read` does as it says, and takes all of it."
        )
