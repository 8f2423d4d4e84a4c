"""An image a few rows at a time, where a whole one in another type would take too much memory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

# Numbers of a band: what is computed of them stays in a processor's cache.
_VALUES = 1 << 18


def bands(image: NDArray[Any]) -> Iterator[slice]:
    """Yield the rows of an image, as many at a time as hold a quarter million numbers."""
    each = max(1, image[:1].size)
    step = max(1, _VALUES // each)
    for first in range(0, len(image), step):
        yield slice(first, min(first + step, len(image)))
