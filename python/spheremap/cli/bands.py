"""An image a few rows at a time, where a whole one in another type would take too much memory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

# Numbers of a band: what is computed of them stays in a processor's cache.
_VALUES = 1 << 18


def bands(image: NDArray[Any], tell: Callable[[float], None] | None = None) -> Iterator[slice]:
    """Yield the rows of an image, as many at a time as hold a quarter million numbers.

    `tell` is called with the fraction of the rows that are done.
    """
    each = max(1, image[:1].size)
    step = max(1, _VALUES // each)
    for first in range(0, len(image), step):
        yield slice(first, min(first + step, len(image)))
        if tell is not None:
            tell(min(first + step, len(image)) / len(image))
