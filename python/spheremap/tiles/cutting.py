"""A level in tiles of equal size, those at the right and the bottom edge perhaps smaller."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from .._threads import on_all_threads

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .job import Job

__all__ = ["Tile", "tiles", "write_tiles"]


class Tile(NamedTuple):
    """A part of an image, and its place: the column and the row of tiles."""

    column: int
    row: int
    pixels: NDArray[np.uint8]


def tiles(pixels: NDArray[np.uint8], size: int, overlap: int = 0) -> Iterator[Tile]:
    """Yield the tiles of an image (H, W, C); each has so many texels of its neighbors around it."""
    height, width = pixels.shape[:2]
    for row in range(-(-height // size)):
        top, bottom = max(row * size - overlap, 0), (row + 1) * size + overlap
        for column in range(-(-width // size)):
            left, right = max(column * size - overlap, 0), (column + 1) * size + overlap
            yield Tile(column, row, pixels[top:bottom, left:right])


def write_tiles(job: Job, found: Iterable[tuple[str, NDArray[np.uint8]]]) -> int:
    """Write pictures under their names, on all threads; return how many files there are."""
    named = list(found)
    on_all_threads(partial(_write, job), named)
    return len(named)


def _write(job: Job, named: tuple[str, NDArray[np.uint8]]) -> None:
    name, pixels = named
    job.folder.picture(f"{name}.{job.extension}", pixels)
