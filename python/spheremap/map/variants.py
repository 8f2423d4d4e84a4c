"""A projection with one thing changed, and axes as a matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import _core

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._core import Projection


def changed(
    p: Projection, *, axes: str | None = None, grid: str | None = None, layout: str | None = None
) -> Projection:
    """Return the same map with other axes, grid or layout."""
    return _core.projection(
        p.name,
        convention=p.convention,
        axes=axes or p.axes,
        grid=grid or p.grid,
        layout=layout or p.layout,
        parameters=p.parameters,
    )


def axes_matrix(axes: str) -> NDArray[np.float64]:
    """Return the signed permutation from the world to the view frame."""
    matrix = np.zeros((3, 3))
    for k, word in enumerate(axes.split()):
        matrix[k, "xyz".index(word[1])] = -1.0 if word[0] == "-" else 1.0
    return matrix
