"""How far places of a picture are from the border of a mask, exactly and at a few places only.

The squared distance to the nearest pixel of a set is a minimum over rows of a squared distance
within the row plus that to the row (Saito & Toriwaki 1994, New algorithms for Euclidean distance
transformation). It is computed at the nodes alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]

__all__ = ["signed_distance"]

# Rows looked at for the distance: of a larger picture every second, every third ...
ROWS = 512


def signed_distance(mask: Mask, rows: int, columns: int) -> Array:
    """Return the distance to the mask's border in pixels, negative outside.

    It is at `rows` × `columns` nodes from corner to corner of the picture, whose own edges are no
    border.
    """
    height, width = mask.shape
    every = max(1, height // ROWS)
    y = np.arange(height)[every // 2 :: every]
    y_nodes = np.linspace(0, height, rows)
    x_nodes = np.linspace(0, width, columns)
    found = np.zeros((rows, columns))
    for sign, of in ((1, ~mask[y]), (-1, mask[y])):
        within = _along(of, x_nodes) ** 2
        for k, at in enumerate(y_nodes):
            # Pixels are squares: half of one lies before the center.
            down = np.maximum(np.abs(y + 0.5 - at) - every / 2, 0) ** 2
            least = np.sqrt((within + down[:, None]).min(axis=0))
            found[k] += sign * np.minimum(least, height + width)
    return found


def _along(of: Mask, x: Array) -> Array:
    """Return, for each row, how far each place of it is from the nearest pixel of a set."""
    height, width = of.shape
    i = np.arange(width, dtype=np.int32)
    at = np.minimum(x.astype(np.intp), width - 1)
    # Between two places all that counts is the last pixel of the set there, and the first.
    parts, part = np.unique(at, return_inverse=True)
    # The edges of the last pixel of the set on the left, and of the first on the right.
    nowhere = 4 * (width + height)
    last = np.maximum.reduceat(np.where(of, i + 1, -nowhere), parts, axis=1)
    first = np.minimum.reduceat(np.where(of, i, nowhere + width), parts, axis=1)
    none = np.full((height, 1), -nowhere)
    left = np.hstack([none, np.maximum.accumulate(last[:, :-1], axis=1)])
    right = np.minimum.accumulate(first[:, ::-1], axis=1)[:, ::-1]
    # What begins left of a place may end right of it: its own pixel.
    gap = np.minimum(x - left[:, part], right[:, part] - x)
    return np.where(of[:, at], 0.0, np.clip(gap, 0.0, nowhere))
