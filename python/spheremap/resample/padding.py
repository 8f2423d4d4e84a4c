"""A border of the right texels around each face, for convolutions that know nothing of spheres."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._arrays import as_image, spatial_shape
from ..map.grid import cells, on_corners
from ..map.named import resolve
from .verbs import convert

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from .._core import Projection
    from .._names import Filter
    from ..map.named import ProjectionLike

    Index = NDArray[np.intp]

__all__ = ["pad"]


def pad(
    image: ArrayLike,
    n: int,
    projection: ProjectionLike,
    /,
    *,
    filter: Filter | str = "bilinear",
) -> NDArray[Any]:
    """Put a border of `n` texels around each face that continues the image over its seams.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Of dtype uint8, uint16, float16, float32 or float64. Faces that lie in one image (a strip, a
        cross) are taken apart first.
    n : int
        How wide the border is, in texels, at least 0. It may be wider than the image.
    projection : Projection or str
        The projection of the image.
    filter : str
        How texels between others are looked up, as for `sample`, where the border is no
        permutation of the image.

    Returns
    -------
    padded : ndarray, shape (H + 2n, W + 2n), (F, N + 2n, N + 2n), or either with channels
        Of the image's dtype; the texels inside the border are the image's own.

    Raises
    ------
    ValueError
        For a negative `n`, an unknown name, or an image of an unfit shape.
    TypeError
        For an `n` that is no integer, or an image of an unfit dtype.

    Notes
    -----
    What a border holds is the rule of the projection's `seam`:

    - ``latlong``: the other end of the row; beyond a pole the same row, half a turn around.
    - ``octahedral``: each edge continues at itself, mirrored about its middle.
    - ``periodic``: the other end of the row; the first and last row are repeated.
    - ``faces``, ``rim-other-face``: what lies in the direction that the face's own formula gives
      beyond its edge. A cube's border texel is what the face would show if its picture were
      larger; texels of neighbors do not lie there, so it is looked up.
    - ``rim-opposite``: across the rim of the disk, the other side of it.
    - ``ends``: nothing lies there, so the texels at the edge (or the rim of the disk) are repeated.

    The first three are exact permutations of texels (on a latlong with an odd number of columns,
    half a turn falls between two, and their mean is taken). Around a disk the whole border is
    filled, and the corners of the image itself stay what they are.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> image = np.arange(8.0).reshape(2, 4)
    >>> sm.pad(image, 1, "latlong")[1].tolist()
    [3.0, 0.0, 1.0, 2.0, 3.0, 0.0]
    >>> sm.pad(image, 1, "latlong")[0].tolist()
    [1.0, 2.0, 3.0, 0.0, 1.0, 2.0]
    >>> sm.pad(np.zeros((6, 16, 16, 3), np.uint8), 2, "cube").shape
    (6, 20, 20, 3)
    """
    p = resolve(projection)
    n = operator.index(n)
    if n < 0:
        raise ValueError(f"Expected a border of at least 0 texels, got {n}.")
    texels = as_image(image, None)
    shape = spatial_shape(texels, p, "image")
    channels = texels.shape[len(shape) :]
    if p.layout not in (None, "faces"):
        apart = _apart(p)
        face = shape[0] // cells(p)[0]
        texels = convert(texels, p, apart, size=face, filter="nearest")
        p, shape = apart, (apart.faces, face, face)
    flat = texels.reshape(-1, *shape[-2:], *channels)
    rule = _PERMUTATIONS.get(p.seam)
    if rule is not None:
        padded = rule(flat[0], n, p)[None]
    elif p.seam == "ends" and not _is_disk(p):
        padded = np.pad(flat, [(0, 0), (n, n), (n, n)] + [(0, 0)] * len(channels), mode="edge")
    else:
        padded = _looked_up(texels, flat, n, p, filter)
    return padded.reshape(*shape[:-2], *padded.shape[1:])


def _apart(p: Projection) -> Projection:
    return _core.projection(
        p.name,
        convention=p.convention,
        axes=p.axes,
        grid=p.grid,
        layout="faces",
        parameters=p.parameters,
    )


def _is_disk(p: Projection) -> bool:
    return not bool(np.all(p.valid([0.0, 0.0] if p.faces == 1 else [0.0, 0.0, 0.0])))


def _folded(i: Index, n: int, corners: bool) -> tuple[Index, NDArray[np.bool_]]:
    """Mirror texels beyond a side of `n` back into it; tell which took an odd number of mirrors."""
    # On a grid of corners the outer texel lies on the mirror, and is not repeated.
    period = 2 * (n - 1) if corners else 2 * n
    i = i % period
    odd = i > n - 1
    return np.where(odd, period - i if corners else period - 1 - i, i), odd


def _latlong(image: NDArray[Any], n: int, p: Projection) -> NDArray[Any]:
    height, width = image.shape[:2]
    corners_v, corners_u = on_corners(p)
    row, turned = _folded(np.arange(-n, height + n), height, corners_v)
    # With corners, the last column is the first one again.
    turn = width - 1 if corners_u else width
    column = np.arange(-n, width + n)
    within = (column >= 0) & (column < width)
    straight = np.where(within, column, column % turn)
    padded = image[row[:, None], straight]
    if not turned.any():
        return padded
    half = image[row[turned][:, None], (column + turn // 2) % turn]
    if turn % 2:
        other = image[row[turned][:, None], (column + turn // 2 + 1) % turn]
        mean = half.astype(np.float64) * 0.5 + other.astype(np.float64) * 0.5
        # Integers round half up, as everywhere.
        half = np.floor(mean + 0.5) if image.dtype.kind == "u" else mean
    padded[turned] = half
    return padded


def _periodic(image: NDArray[Any], n: int, p: Projection) -> NDArray[Any]:
    height, width = image.shape[:2]
    turn = width - 1 if on_corners(p)[1] else width
    column = np.arange(-n, width + n)
    column = np.where((column >= 0) & (column < width), column, column % turn)
    row = np.clip(np.arange(-n, height + n), 0, height - 1)
    padded: NDArray[Any] = image[row[:, None], column]
    return padded


def _octahedral(image: NDArray[Any], n: int, p: Projection) -> NDArray[Any]:
    height, width = image.shape[:2]
    corners_v, corners_u = on_corners(p)
    column, flips_rows = _folded(np.arange(-n, width + n), width, corners_u)
    row, flips_columns = _folded(np.arange(-n, height + n), height, corners_v)
    rows = np.where(flips_rows[None, :], height - 1 - row[:, None], row[:, None])
    columns = np.where(flips_columns[:, None], width - 1 - column[None, :], column[None, :])
    return image[rows, columns]


_PERMUTATIONS: dict[str, Callable[[NDArray[Any], int, Projection], NDArray[Any]]] = {
    "latlong": _latlong,
    "periodic": _periodic,
    "octahedral": _octahedral,
}


def _looked_up(
    texels: NDArray[Any], flat: NDArray[Any], n: int, p: Projection, filter: str
) -> NDArray[Any]:
    faces, height, width = flat.shape[:3]
    corners_v, corners_u = on_corners(p)
    whole = (height + 2 * n, width + 2 * n)
    inside = np.zeros(whole, bool)
    inside[n : n + height, n : n + width] = True
    row, column = np.nonzero(~inside)
    uv = np.stack([_beyond(column - n, width, corners_u), _beyond(row - n, height, corners_v)], -1)
    padded = np.empty((faces, *whole, *flat.shape[3:]), flat.dtype)
    for face in range(faces):
        d = _across(p, face, uv)
        padded[face][inside] = flat[face].reshape(-1, *flat.shape[3:])
        padded[face][~inside] = p.sample(texels, d, filter=filter)  # type: ignore[arg-type]
    return padded


def _beyond(i: Index, n: int, corners: bool) -> NDArray[np.float64]:
    offset, span = (0.0, n - 1) if corners else (0.5, n)
    places: NDArray[np.float64] = (i + offset) / span
    return places


def _across(p: Projection, face: int, uv: NDArray[np.float64]) -> NDArray[Any]:
    """Return the directions of places beyond the edges of a face."""
    if p.seam in ("rim-opposite", "ends"):
        pq = 2 * uv - 1
        radius = np.maximum(np.hypot(pq[..., 0], pq[..., 1]), 1)[..., None]
        # A hair inside the rim, where the answer would hang on a rounding.
        limit = 1 - 1e-9
        if p.seam == "ends":
            inside = pq / radius * limit
        else:
            # The radius goes on at the other side: 1 + x is -(1 - x).
            inside = pq / radius * np.clip((radius + 1) % 2 - 1, -limit, limit)
        return p.decode(0.5 + 0.5 * inside)
    return _canonical(p)._beyond(_turned(p, face, uv))


def _canonical(p: Projection) -> Projection:
    """Return the projection with its faces in the order and orientation of its own formula."""
    return _core.projection(p.name, axes=p.axes, parameters=p.parameters)


def _turned(p: Projection, face: int, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a program's coordinates of a face as those of the formula, beyond its edges, too."""
    if p.faces == 1:
        return np.concatenate([uv, np.zeros((len(uv), 1))], -1)
    # A program may number faces otherwise and turn or flip each: three points tell how.
    points = np.array([[0.5, 0.5, face], [0.75, 0.5, face], [0.5, 0.75, face]])
    middle, right, down = _canonical(p).encode(p.decode(points))
    columns = np.rint(4 * np.stack([right - middle, down - middle], -1)[:2])
    turned = np.empty((len(uv), 3))
    turned[:, :2] = 0.5 + (uv - 0.5) @ columns.T
    turned[:, 2] = middle[2]
    return turned
