"""Unit quaternions, w first, as files have them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["from_matrix", "to_matrix"]


def to_matrix(q: Sequence[float]) -> NDArray[np.float64]:
    """Return the rotation of w, x, y, z, of any length but zero."""
    length = float(np.linalg.norm(q))
    if not (np.isfinite(length) and length > 0):
        raise ValueError("Expected a rotation as a quaternion, got one of no length.")
    w, x, y, z = np.asarray(q) / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def from_matrix(m: NDArray[np.float64]) -> list[float]:
    """Return w, x, y, z of a rotation, w not negative.

    From the largest of the four, whose square is at least a quarter: 4w² = 1 + m00 + m11 + m22 and
    alike. All sixteen products are linear in the matrix.
    """
    t = np.trace(m)
    products = np.array(
        [
            [1 + t, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], 1 + 2 * m[0, 0] - t, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 + 2 * m[1, 1] - t, m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 + 2 * m[2, 2] - t],
        ]
    )
    row = products[int(np.argmax(np.diag(products)))]
    q = row / np.linalg.norm(row)
    return [float(x) for x in (-q if q[0] < 0 else q) + 0.0]
