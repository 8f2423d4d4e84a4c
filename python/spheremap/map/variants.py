"""A projection with one thing changed, and axes as a matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .named import resolve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection


def changed(
    p: Projection,
    *,
    axes: str | None = None,
    grid: str | None = None,
    layout: str | None = None,
    world: str | None = None,
) -> Projection:
    """Return the same map with other axes, grid, layout, or said to be of another world."""
    return p._changed(axes=axes, grid=grid, layout=layout, world=world)


def pose_matrix(pose: Any | None) -> NDArray[np.float64]:
    """Return the pose of a camera as a matrix that was checked; the identity for None."""
    matrix = None if pose is None else resolve("latlong").turned(pose).pose
    return np.eye(3) if matrix is None else matrix


def axes_matrix(axes: str) -> NDArray[np.float64]:
    """Return the signed permutation from the world to the view frame."""
    matrix = np.zeros((3, 3))
    for k, word in enumerate(axes.split()):
        matrix[k, "xyz".index(word[1])] = -1.0 if word[0] == "-" else 1.0
    return matrix


def axes_text(matrix: NDArray[np.float64]) -> str:
    """Return the axes of which a signed permutation is the matrix."""
    words = []
    for row in matrix:
        k = int(np.flatnonzero(np.rint(row))[0])
        words.append(("-" if row[k] < 0 else "+") + "xyz"[k])
    return " ".join(words)
