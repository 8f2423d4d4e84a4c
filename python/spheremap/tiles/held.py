"""Images and levels in memory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .colors import light

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ..resample.conversion import Conversion
    from ..resample.seen import Rectangle

__all__ = ["HeldImage", "HeldLevel"]


class HeldImage:
    """An image in memory."""

    def __init__(self, texels: NDArray[Any]) -> None:
        self._texels = texels
        self.shape, self.dtype = texels.shape, texels.dtype

    def converted(self, conversion: Conversion, folder: Path) -> HeldLevel:
        """Return it in another projection."""
        return HeldLevel(conversion.window(self._texels, None, conversion.options))


class HeldLevel:
    """A level in memory."""

    memory = None

    def __init__(self, texels: NDArray[Any]) -> None:
        self._texels = texels
        self.shape, self.dtype = texels.shape, texels.dtype

    @property
    def is_finite(self) -> bool:
        """Whether all of its light is."""
        return bool(np.isfinite(light(self._texels)).all())

    @property
    def has_nan(self) -> bool:
        """Whether any of it is."""
        return self.dtype.kind == "f" and bool(np.isnan(self._texels).any())

    def read(self, part: Rectangle) -> NDArray[Any]:
        """Return the texels of a part."""
        texels: NDArray[Any] = self._texels[part.index]
        return texels

    def put(self, part: Rectangle, texels: NDArray[Any]) -> None:
        """Store those of a part."""
        self._texels[part.index] = texels

    def empty(self, shape: tuple[int, ...]) -> HeldLevel:
        """Return a level of light in which nothing is yet."""
        return HeldLevel(np.empty(shape, np.float32))

    def light_converted(self, conversion: Conversion) -> HeldLevel:
        """Return its light in another projection."""
        return HeldLevel(conversion.window(light(self._texels), None, conversion.options))
