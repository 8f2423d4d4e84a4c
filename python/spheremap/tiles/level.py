"""What a pyramid is made of: an image that becomes its largest level, and the levels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from ..resample.conversion import Conversion
    from ..resample.seen import Rectangle

__all__ = ["Image", "Level"]


class Image(Protocol):
    """What becomes the largest level."""

    @property
    def shape(self) -> tuple[int, ...]:
        """With channels, which are the last axis."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """What its texels are."""

    def converted(self, conversion: Conversion, folder: Path) -> Level:
        """Return it in another projection; a folder takes what the memory does not."""


class Level(Protocol):
    """Texels that are read part by part."""

    @property
    def shape(self) -> tuple[int, ...]:
        """With channels, which are the last axis."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """What its texels are."""

    @property
    def is_finite(self) -> bool:
        """Whether all of its light is."""

    @property
    def has_nan(self) -> bool:
        """Whether any of it is."""

    @property
    def memory(self) -> int | None:
        """What may be taken beside it, in bytes, where that is bounded."""

    def read(self, part: Rectangle) -> NDArray[Any]:
        """Return the texels of a part."""

    def put(self, part: Rectangle, texels: NDArray[Any]) -> None:
        """Store those of a part."""

    def empty(self, shape: tuple[int, ...]) -> Level:
        """Return a level of light where this one is, in which nothing is yet."""

    def light_converted(self, conversion: Conversion) -> Level:
        """Return its light in another projection."""
