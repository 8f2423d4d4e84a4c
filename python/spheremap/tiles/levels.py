"""The levels of a pyramid, from the largest down.

The largest is what `convert` makes of the image. Each of the others has the mean light of the one
before: pictures of sRGB are averaged as light, and as what each texel sees, so that nothing turns
darker toward the small levels, and no seam shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._progress import part
from ..resample.conversion import Conversion

if TYPE_CHECKING:
    from .._projection import Projection
    from .job import Job
    from .level import Level

__all__ = ["levels"]

# How much of the time that a level takes is for its tiles, and not for the next one.
_TILES = 0.75


def levels(
    job: Job,
    p: Projection,
    shapes: Sequence[tuple[int, ...]],
    *,
    fill: float = 0.0,
    smaller: Callable[[Level, Projection, tuple[int, ...]], Level] | None = None,
) -> Iterator[Level]:
    """Yield the image in a projection, and smaller ones of these shapes, each of the one before.

    Only two are held at a time. `smaller` makes one of another; else it has its mean light.
    """
    with part(0.0, 0.5):
        here = job.converted(p, shapes[0], fill=fill)
    first = 0.5
    for shape in shapes[1:]:
        # Each has a quarter of the texels of the one before.
        last = first + 0.75 * (1.0 - first)
        middle = first + _TILES * (last - first)
        with part(first, middle):
            yield here
        with part(middle, last):
            here = (smaller or _mean)(here, p, shape)
        first = last
    with part(first, 1.0):
        yield here


def _mean(level: Level, p: Projection, shape: tuple[int, ...]) -> Level:
    options = {
        "filter": "area",
        "skipna": not level.is_finite,
        "world": "match",
        "any_aspect": True,
    }
    light = np.dtype(np.float32)
    return level.light_converted(Conversion(p, p, level.shape, light, shape, options))
