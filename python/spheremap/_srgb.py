"""The curve of sRGB by its formula, for what is made without files and their library.

IEC 61966-2-1. Colors of files go through OpenImageIO (`color`), which knows their spaces by name
and is within 2.5e-4 of the formula.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["decoded", "encoded"]


def encoded(light: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """Return the values from 0 to 1 that a screen shows as this light."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def decoded(values: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """Return the light of values from 0 to 1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
