"""A level in tiles of equal size, those at the right and the bottom edge perhaps smaller."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from .._progress import part as share
from .._threads import on_all_threads
from ..resample.seen import Rectangle

if TYPE_CHECKING:
    from .job import Job
    from .level import Level

__all__ = ["Tile", "each", "tiles", "whole", "write_tiles"]

T = TypeVar("T")

# Tiles that are thought of at a time.
_BATCH = 4096
# Bytes that a number of a tile takes on its way into a file, and what any tile takes.
_NUMBER, _ANY = 8, 8 << 20


class Tile(NamedTuple):
    """A part of an image, and its place: the face, the column and the row of tiles."""

    face: int | None
    column: int
    row: int
    part: Rectangle


def tiles(shape: tuple[int, ...], size: int, overlap: int = 0) -> Iterator[Tile]:
    """Yield the tiles of an image (H, W, C), or of faces (F, H, W, C).

    Each has so many texels of its neighbors around it.
    """
    *faces, height, width, _ = shape
    for face in range(faces[0]) if faces else [None]:
        for row in range(-(-height // size)):
            top, bottom = max(row * size - overlap, 0), min((row + 1) * size + overlap, height)
            for column in range(-(-width // size)):
                left, right = max(column * size - overlap, 0), (column + 1) * size + overlap
                part = Rectangle(top, bottom, left, min(right, width), face)
                yield Tile(face, column, row, part)


def whole(shape: tuple[int, ...]) -> list[Rectangle]:
    """Return all of an image, a part for each face."""
    return [tile.part for tile in tiles(shape, max(shape[-3:-1]))]


def write_tiles(job: Job, level: Level, found: Iterable[tuple[str, Rectangle]], size: int) -> int:
    """Write the tiles of a level, of this size, under their names; return how many there are."""
    return each(level, partial(_write, job, level), found, size)


def each(level: Level, work: Callable[[T], None], found: Iterable[T], size: int) -> int:
    """Do the work on each tile of a level, of this size, on all threads that there is room for.

    Returns how many there are.
    """
    most = None
    if level.memory is not None:
        most = max(1, level.memory // 2 // (_NUMBER * size**2 * level.shape[-1] + _ANY))
    *faces, height, width, _ = level.shape
    expected = math.prod(faces) * -(-height // size) * -(-width // size)
    count, left = 0, iter(found)
    while batch := list(islice(left, _BATCH)):
        with share(count / expected, (count + len(batch)) / expected):
            on_all_threads(work, batch, most)
        count += len(batch)
    return count


def _write(job: Job, level: Level, found: tuple[str, Rectangle]) -> None:
    name, part = found
    job.folder.picture(f"{name}.{job.extension}", job.look.picture(level.read(part)))
