"""The light of image files larger than memory."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import checked_image
from .._progress import done
from .._scalars import as_whole
from ..io.header import header_of
from ..io.large import expect_plain
from ..io.opened import opened
from ..io.parts import expect_memory
from ..io.reading import Reader, Source
from ..io.tiling import has_tiles, in_tiles
from ..io.whole import as_path
from ..map.images import expect_aspect
from ..map.named import resolve
from ..resample.sparse import sparse_zeros
from .image import coefficients
from .sheets import SIDE, energy_of_sheets, rectangle, sheet_places, texels_around

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative
    from .._projection import Projection
    from ..map.named import ProjectionLike
    from ..resample.seen import Rectangle
    from .report import Energy

__all__ = ["energy_file", "energy_of_parts", "reader_of"]

# What a call takes whatever its image is: half of it lists the texels of a sheet.
_LEAST_MEMORY = 128 << 20


def energy_file(
    source: str | os.PathLike[str],
    /,
    projection: ProjectionLike,
    *,
    memory: int = 1 << 29,
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    part: int | str | None = None,
) -> Energy:
    """Report the light of an image file that may be larger than memory.

    Parameters
    ----------
    source : path-like
        As for `spheremap.io.read`; its values are linear radiance.
    projection, axes, rotation, luminance, skipna, negative, any_aspect
        As for `energy`. Faces lie in one image: a cube has a layout, or a convention that has.
    memory : int
        How many bytes the call may take beyond what is there: at least 128 MiB.
    part
        As for `spheremap.io.read`.

    Returns
    -------
    report : Energy
        That of ``energy(read(source), projection)``, to the bit. Only where the texels within 20
        degrees of the brightest are more than the memory holds, some 300 bytes each, its sun is
        found among means of blocks of them.

    Raises
    ------
    OSError, ValueError, TypeError, ImportError
        As for `spheremap.io.read` and `energy`, for a file that is turned or placed by its header,
        and for too little memory.

    Notes
    -----
    The file is read once, square by square of 512² texels, and once more around its brightest
    texel. One without tiles of which 512 rows do not fit into a quarter of the memory is decoded
    into tiles before, in the folder for temporary files, where there has to be room for its texels.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "sky.exr"
    >>> sm.io.write(place, np.ones((64, 128, 3), np.float32))
    >>> sm.light.energy_file(place, "latlong", memory=1 << 28).peak
    1.0
    """
    memory = as_whole(memory, "memory")
    p = resolve(resolve(projection, axes), rotation=rotation)
    if p.faces > 1:
        raise ValueError(
            f"A file holds one image, and '{p.name}' has faces apart: give it a layout, as "
            f'projection("{p.name}", layout="strip").'
        )
    with reader_of(source, part, memory) as (read, shape):
        expect_aspect(p, shape, any_aspect)
        p.shape(shape[:2])
        checks = {"skipna": skipna, "negative": negative}
        return energy_of_parts(read, p, shape, luminance, memory, **checks)


@contextmanager
def reader_of(
    source: str | os.PathLike[str], part: int | str | None, memory: int
) -> Iterator[tuple[Callable[[Rectangle], NDArray[Any]], tuple[int, int, int]]]:
    """Give what reads parts of an image file, (H, W, C), and its shape."""
    expect_memory(memory, _LEAST_MEMORY)
    with opened(source, part) as handle:
        head, number = header_of(handle), handle.current_subimage()
    expect_plain(head, source)
    shape = head.height, head.width, len(head.channels)
    files = Source([as_path(source)], number, np.dtype(head.dtype), shape[2], lambda x: x)
    cached = memory // 4
    row = shape[1] * shape[2] * files.dtype.itemsize
    if SIDE * row > cached and not has_tiles(files):
        # Strips would be decoded once for each sheet of a row.
        with tempfile.TemporaryDirectory(prefix="spheremap-tiles-") as folder:
            copies = in_tiles(files, Path(folder), memory // 8)
            yield Reader(copies, shape[1], cached).read, shape
    else:
        yield Reader(files, shape[1], cached).read, shape


def energy_of_parts(
    read: Callable[[Rectangle], NDArray[Any]],
    projection: Projection,
    shape: tuple[int, ...],
    luminance: ArrayLike | None,
    memory: int | None,
    **checks: Any,
) -> Energy:
    """Report the light of an image whose parts are read one by one.

    Parameters
    ----------
    read : callable
        Returns the texels of a part, (H, W, C).
    projection, luminance
        As for `energy`.
    shape : tuple of int
        Of the image, with channels.
    memory : int, optional
        In bytes; without it a sun is found among all texels around it.
    **checks
        What `checked_image` is told.
    """
    weights = coefficients(np.empty((0, shape[-1])), 1, luminance)
    places = sheet_places(projection, shape)

    def of_each(sum: Any, numbers: Sequence[int]) -> Iterator[NDArray[np.float64]]:
        for k, number in enumerate(numbers):
            place = places[number]
            texels = checked_image(
                read(rectangle(place[:-1])), origin=tuple(side.start for side in place), **checks
            )
            image = sparse_zeros(shape, texels.dtype)
            image[place] = texels
            yield sum.part(image, number)
            done((k + 1) / len(numbers))

    most = None if memory is None else texels_around(memory // 4, shape[-1])
    return energy_of_sheets(projection, shape, weights, of_each, most)
