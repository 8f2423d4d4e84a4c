"""`write_file`: an image file that may be larger than memory as a pyramid."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .._scalars import as_whole
from ..io.header import Header, header_of
from ..io.large import expect_plain
from ..io.opened import opened
from ..io.parts import expect_memory
from ..io.reading import Source
from ..io.tonemap import Curve
from ..io.whole import as_path
from ..map.images import expect_aspect
from ..map.named import resolve
from .asked import Extension, Format, Frame, Kind, as_tile_size, written
from .colors import on_black
from .filed import FileImage
from .pyramid import Pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._names import ConvertFilter
    from ..map.named import ProjectionLike, Worlds

__all__ = ["file_image", "write_file"]

# What a call takes whatever its image is, and for a texel of a tile.
_LEAST_MEMORY, _TEXEL = 128 << 20, 64


def write_file(
    source: str | os.PathLike[str],
    /,
    projection: ProjectionLike,
    folder: str | os.PathLike[str],
    *,
    format: Format | str,
    size: int | None = None,
    tile_size: int = 512,
    memory: int = 1 << 29,
    extension: Extension | str | None = None,
    quality: int = 90,
    filter: ConvertFilter | str = "bilinear",
    rotation: Any | None = None,
    world: Worlds = "match",
    curve: Curve | str = "none",
    exposure: float = 0.0,
    title: str | None = None,
    frame: Frame | str = "equatorial",
    properties: Mapping[str, str] | None = None,
    page: bool = True,
    any_aspect: bool = False,
    part: int | str | None = None,
) -> Pyramid:
    """Write an image file that may be larger than memory as a pyramid of tiles.

    Parameters
    ----------
    source : path-like
        As for `spheremap.io.read`.
    projection, rotation, any_aspect
        As for `write`. Faces lie in one image: a cube has a layout, or a convention that has.
    folder : path
        As for `write`. While it is filled there has to be room for the texels of two levels, not
        compressed, for those of a source without tiles, and, of ``"trilinear"`` and ``"ewa"``, for
        the levels of the source's mip chain.
    format, size, tile_size, extension, quality, filter, world, curve, exposure, title, frame
        As for `write`.
    memory : int
        How many bytes the call may take beyond what is there: at least 128 MiB, and 64 for each
        texel of a tile.
    properties, page
        As for `write`.
    part
        As for `spheremap.io.read`.

    Returns
    -------
    Pyramid
        What was written.

    Raises
    ------
    OSError, ValueError, TypeError, ImportError
        As for `spheremap.io.read` and `write`; for a source that is turned or placed by its header;
        and for too little memory, which the message says.

    Notes
    -----
    Each file holds the bytes of those of ``write(read(source), projection, folder)``, but that the
    source says itself which channel is alpha, and whether it is straight. The levels are made
    window by window, as `spheremap.io.convert_file` does it, and stand in the folder, in files
    without a name, until their tiles and the next level are made of them.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp())
    >>> sm.io.write(place / "sky.exr", np.ones((64, 128, 3), np.float32))
    >>> made = sm.tiles.write_file(
    ...     place / "sky.exr", "latlong", place / "sky", format="marzipano", memory=1 << 28
    ... )
    >>> made.manifest.name, made.shape, made.tiles
    ('data.json', (6, 42, 42), 6)
    """
    kind = Kind.of(format, extension, curve, exposure, resolve(projection, rotation=rotation))
    with opened(source, part) as handle:
        head, number = header_of(handle), handle.current_subimage()
    expect_plain(head, source)
    count = len(head.channels)
    shape = head.height, head.width, count
    if kind.src.faces > 1:
        raise ValueError(
            f"A file holds one image, and '{kind.src.name}' has faces apart: give it a layout, as "
            f'projection("{kind.src.name}", layout="strip").'
        )
    expect_aspect(kind.src, shape, any_aspect)
    kind.src.shape(shape[:2])
    files = Source([as_path(source)], number, np.dtype(head.dtype), count, _shown(head))
    return written(
        file_image(files, shape[:2], kind, tile_size=tile_size, memory=memory),
        kind,
        folder,
        size=size,
        tile_size=tile_size,
        quality=quality,
        filter=filter,
        world=world,
        title=title,
        frame=frame,
        properties=properties,
        page=page,
    )


def _shown(head: Header) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """Return what is taken of a file's texels: light, where they have to be put on black."""
    if head.alpha == "straight" and head.alpha_channel is not None:
        return partial(on_black, alpha=head.alpha_channel)
    return lambda texels: texels


def file_image(
    source: Source, shape: tuple[int, ...], kind: Kind, *, tile_size: int, memory: int
) -> FileImage:
    """Return the image of files, of this shape without channels, of which a pyramid is made.

    Its texels are what is taken of those that the source takes of the files.
    """
    memory = as_whole(memory, "memory")
    expect_memory(memory, max(_LEAST_MEMORY, _TEXEL * as_tile_size(tile_size, kind.format) ** 2))
    files = replace(source, taken=lambda texels: kind.taken(source.taken(texels)))
    one = files.taken(np.zeros((1, 1, source.channels), source.dtype))
    return FileImage(files, (*shape, one.shape[-1]), one.dtype, memory)
