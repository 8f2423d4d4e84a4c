"""The levels of a pyramid, from the largest down.

The largest is what `convert` makes of the image. Each of the others has the mean light of the one
before: pictures of sRGB are averaged as light, and as what each texel sees, so that nothing turns
darker toward the small levels, and no seam shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..resample.verbs import convert
from .colors import Look, light

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["levels"]


def levels(
    look: Look, pixels: NDArray[Any], p: Projection, shapes: Sequence[tuple[int, ...]]
) -> Iterator[NDArray[np.uint8]]:
    """Yield the picture of an image, then smaller ones of these shapes, each of the one before."""
    yield look.picture(pixels)
    here: NDArray[Any] | None = None
    for shape in shapes:
        if here is None:
            here = light(pixels)
        known = bool(np.isfinite(here).all())
        here = convert(here, p, p, size=shape, filter="area", skipna=not known, any_aspect=True)
        yield look.picture(here)
