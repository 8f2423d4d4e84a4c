"""Where the texels of an image lie, in its coordinates: what the core knows as its raster."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from .._projection import Projection

# About so many texels' directions are held at a time.
BLOCK = 1 << 17


def cells(p: Projection) -> tuple[int, int]:
    """Return how many rows and columns of faces an image has: (1, 1) where they are apart."""
    if p.layout in (None, "faces"):
        return 1, 1
    rows, columns = p.shape(2)
    return rows // 2, columns // 2


def on_corners(p: Projection) -> tuple[bool, bool]:
    """Tell whether texels lie on the edges, along v and along u."""
    return p.grid != "centers", p.grid == "corners"


def texel(u: NDArray[Any], n: int, cells: int, corners: bool) -> NDArray[Any]:
    """Return the place of a coordinate on a side of `n` texels: 0 at the first center."""
    places: NDArray[Any] = u * n - 0.5
    if corners:
        each = n // cells
        cell = np.clip(np.floor(u * cells), 0, cells - 1)
        places = cell * each + (u * cells - cell) * (each - 1)
    return places


def centers(n: int, cells: int, corners: bool) -> NDArray[np.float64]:
    """Return the coordinates of the `n` texels of a side: the inverse of `texel`."""
    i = np.arange(n)
    places: NDArray[np.float64] = (i + 0.5) / n
    if corners:
        each = n // cells
        places = (i // each + (i % each) / (each - 1)) / cells
    return places


def coordinate(places: NDArray[Any], n: int, cells: int, corners: bool) -> NDArray[Any]:
    """Return the coordinates of places on a side of `n` texels: the inverse of `texel`.

    A place in the outer half of a texel that lies on the edge of a face is none: NaN.
    """
    if not corners:
        u: NDArray[Any] = (places + 0.5) / n
        return u
    each = n // cells
    cell = np.clip(np.floor((places + 0.5) / each), 0, cells - 1)
    within = (places - cell * each) / (each - 1)
    if cells > 1:
        within = np.where((within >= 0) & (within <= 1), within, np.nan)
        # The far edge of a face is the near edge of the next one, which would take it for its own.
        within = np.minimum(within, 1 - 16 * np.finfo(within.dtype).eps)
    u = (cell + within) / cells
    return u


def places(p: Projection, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the coordinates of an image's texels, those outside the valid image among them."""
    height, width = shape[-2:]
    (cells_v, cells_u), (corners_v, corners_u) = cells(p), on_corners(p)
    if cells_u * cells_v > 1 and (corners_u or corners_v):
        # Texels on the edges of joined faces lie on two at once; only the core tells them apart.
        return p.encode(p.directions(shape)).astype(np.float64, copy=False)
    uv = np.empty((*shape, len(shape)))
    uv[..., 0] = centers(width, cells_u, corners_u)
    uv[..., 1] = centers(height, cells_v, corners_v)[:, None]
    if len(shape) == 3:
        uv[..., 2] = np.arange(shape[0])[:, None, None]
    return uv


def row_blocks(p: Projection, shape: tuple[int, ...]) -> Iterator[tuple[slice, NDArray[Any]]]:
    """Yield an image's texels by blocks of its rows, those of all faces in turn.

    Each is a slice of the rows, and the directions of its texels of shape (rows, columns, 3).
    """
    height, width = shape[-2:]
    (cells_v, cells_u), (corners_v, corners_u) = cells(p), on_corners(p)
    u, v = centers(width, cells_u, corners_u), centers(height, cells_v, corners_v)
    # Texels on the edges of joined faces lie on two at once; only the core tells them apart.
    shared = cells_u * cells_v > 1 and (corners_u or corners_v)
    whole = p.directions(shape).reshape(-1, width, 3) if shared else None
    rows = height * (1 if len(shape) == 2 else shape[0])
    step = max(1, BLOCK // width)
    for first in range(0, rows, step):
        stored = np.arange(first, min(first + step, rows))
        part = slice(first, first + len(stored))
        uv = np.empty((len(stored), width, len(shape)))
        uv[..., 0], uv[..., 1] = u, v[stored % height, None]
        if len(shape) == 3:
            uv[..., 2] = (stored // height)[:, None]
        yield part, p.decode(uv) if whole is None else whole[part]
