"""A conversion of an image of which only parts are there at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import spatial_axes
from .._scalars import as_text
from .verbs import convert

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Conversion", "needs_chain"]

# A size that every projection has.
_SMALL = 16


def needs_chain(filter: object) -> bool:
    """Tell whether texels are looked up in a mip chain, which is made of all of an image."""
    return as_text(filter, "filter") in ("trilinear", "ewa")


@dataclass(frozen=True, slots=True, eq=False)
class Conversion:
    """A conversion that is made window by window: what all windows have in common."""

    src: Projection
    dst: Projection
    # Of the whole source, with channels, and of the whole result, without.
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    size: tuple[int, ...]
    options: dict[str, Any]

    def window(self, source: NDArray[Any], window: Any, options: dict[str, Any]) -> NDArray[Any]:
        """Return a part of the result."""
        found: NDArray[Any] = convert(
            source, self.src, self.dst, size=self.size, window=window, **options
        )
        return found

    def nothing(self) -> NDArray[Any]:
        """Return a part without texels: of the dtype, the axes and the errors of the whole."""
        faces = len(self.size) == 3
        empty = (slice(0, 0), slice(0, 0), *([0] if faces else []))
        # A small image does, where options would have a large one read.
        small = np.zeros((*self.src.shape(_SMALL), *self.channels), self.dtype)
        found = self.window(small, empty, self.options)
        return found[None] if faces else found

    @property
    def channels(self) -> tuple[int, ...]:
        """How many channels there are, if there is an axis of them."""
        return self.shape[spatial_axes(self.src) :]
