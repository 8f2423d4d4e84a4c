"""Directions that lie evenly on the sphere, for sums and shares over it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def points(count: int) -> NDArray[np.float64]:
    """Return so many of them, (count, 3), along a spiral of golden angles about +y."""
    k = np.arange(count) + 0.5
    y, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.sin(turn), y, r * np.cos(turn)], axis=-1)
