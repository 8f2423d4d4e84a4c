"""Depth images as points of space, and points as a depth image."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._arrays import as_array, as_doubles, expect_vectors, spatial_axes
from .._scalars import as_number
from ..map.images import images, target_shape
from ..map.named import resolve
from ..map.pixels import directions_to_pixels
from .depth import convert_depth, expect_kind

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Size
    from ..map.named import ProjectionLike

__all__ = ["depth_to_points", "points_to_depth"]

# Squares below have lost digits, or are 0.
_LEAST_SQUARE = 1e-290


def depth_to_points(
    depth: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    kind: Literal["distance", "z"] = "distance",
    axes: str | None = None,
    rotation: Any | None = None,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the point of space that each texel of a depth image sees, the eye at the origin.

    Parameters
    ----------
    depth : array_like, shape (H, W) or (F, N, N), or either with one channel (..., 1)
        Of real numbers. A batch, as for `convert`, has one channel.
    projection : Projection or str
        The projection of the image.
    kind : {"distance", "z"}
        What `depth` is, as `source` of `convert_depth`.
    axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`. A camera is turned
        by `Projection.turned`.
    any_aspect, channels_first : bool
        As for `convert`; the channels of the result are x, y and z.

    Returns
    -------
    points : ndarray, shape (H, W, 3) or (F, N, N, 3), and of a batch (N, H, W, 3)
        In the world and the units of `depth`. float32 for float16 and float32, else float64. NaN
        where the image holds no sphere, where the depth is not finite, and where it is 0 or below,
        as nothing was measured there.

    Raises
    ------
    ValueError
        For a kind of depth that is unknown, or a shape that the projection cannot have.
    TypeError
        For complex numbers and objects.

    Examples
    --------
    A wall at z = 2 before a camera that looks along -z:

    >>> import numpy as np, spheremap as sm
    >>> points = sm.depth_to_points(np.full((4, 4), 2.0), "perspective", kind="z")
    >>> points[..., 2].round(12).tolist()[0], points[0, 0].round(12).tolist()
    ([-2.0, -2.0, -2.0, -2.0], [-1.5, 1.5, -2.0])
    """
    p = resolve(projection, axes)
    several = images(
        depth,
        p,
        any_aspect=any_aspect,
        channels_first=channels_first,
        rotation=rotation,
        name="depth",
    )
    if several is not None:
        return several.each(depth_to_points, locals())
    p = resolve(p, rotation=rotation)
    given = as_array(depth, "depth")
    if given.ndim == spatial_axes(p) + 1 and given.shape[-1] == 1:
        given = given[..., 0]
    if given.ndim != spatial_axes(p):
        wanted = "(H, W)" if spatial_axes(p) == 2 else "(F, N, N)"
        raise ValueError(f"Expected `depth` to have shape {wanted}, got {given.shape}.")
    expect_kind(kind, "kind")
    distance = convert_depth(given, p, source=kind, target="distance", any_aspect=True)
    points = p.directions(given.shape, dtype=distance.dtype, any_aspect=True)
    known = np.isfinite(distance) & (distance > 0)
    points *= np.where(known, distance, np.nan)[..., None]
    return points


def _texels(places: NDArray[np.floating[Any]], shape: tuple[int, ...]) -> NDArray[np.intp]:
    """Return the numbers of the texels in which places lie; of NaN, that behind the last."""
    nowhere = np.isnan(places[:, 0])
    index = np.zeros(len(places), np.intp)
    with np.errstate(invalid="ignore"):
        for axis, length in enumerate(shape):
            at = places[:, len(shape) - 1 - axis].astype(np.intp)
            index *= length
            index += np.minimum(at, length - 1, out=at)
    index[nowhere] = math.prod(shape)
    return index


def _lengths(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the lengths of vectors, those whose squares no float holds among them."""
    squares = np.einsum("ni,ni->n", points, points)
    lengths = np.sqrt(squares)
    wild = (squares < _LEAST_SQUARE) | (squares == np.inf)
    if wild.any():
        vectors = points[wild]
        largest = np.abs(vectors).max(axis=-1)
        scaled = vectors / largest[:, None]
        lengths[wild] = largest * np.sqrt(np.einsum("ni,ni->n", scaled, scaled))
    return np.asarray(lengths)


def points_to_depth(
    points: ArrayLike,
    /,
    projection: ProjectionLike,
    size: Size,
    *,
    kind: Literal["distance", "z"] = "distance",
    axes: str | None = None,
    rotation: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    any_aspect: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return a depth image of points of space: in each texel the one nearest to the eye.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        In the world. Those that are the origin or not finite are not seen.
    projection : Projection or str
        The projection of the result.
    size : int or tuple of int
        Of the result, as for `solid_angle`.
    kind : {"distance", "z"}
        What is returned, as `target` of `convert_depth`: z is that of the ray through the middle of
        the texel.
    axes, rotation
        As for `encode`.
    fill : float, or a sequence of one
        What texels have in which no point lies.
    any_aspect : bool
        As for `convert`, of a size with all its sides.

    Returns
    -------
    depth : ndarray, shape (H, W) or (F, N, N)
        float32 for float16 and float32, else float64.

    Raises
    ------
    ValueError, TypeError
        As for `depth_to_points`, and for a size that the projection cannot have.

    Notes
    -----
    A point is in one texel alone: where points are fewer than texels, there are gaps. On grids of
    corners a texel at a seam has another one with the same direction, which then stays empty.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> depth = np.arange(1.0, 33).reshape(4, 8)
    >>> points = sm.depth_to_points(depth, "latlong")
    >>> bool(np.allclose(sm.points_to_depth(points, "latlong", 4), depth))
    True
    """
    p = resolve(projection, axes, rotation)
    shape = target_shape(p, size, any_aspect)
    expect_kind(kind, "kind")
    one = isinstance(fill, Sequence | np.ndarray) and np.ndim(fill) > 0 and len(fill) == 1
    filling = as_number(fill[0] if one else fill, "fill")  # type: ignore[index]
    given = as_doubles(points, "points")
    expect_vectors(given.shape, "points")
    places = directions_to_pixels(given, p, shape, any_aspect=True)
    dtype = np.asarray(points).dtype
    single = dtype.kind == "f" and dtype.itemsize <= 4
    index = _texels(places.reshape(-1, places.shape[-1]), shape)
    # What lies in no texel goes behind the last.
    nearest = np.full(math.prod(shape) + 1, np.inf)
    with np.errstate(all="ignore"):
        np.minimum.at(nearest, index, _lengths(given.reshape(-1, 3)))
    depth: NDArray[np.float64] = nearest[:-1].reshape(shape)
    empty = ~np.isfinite(depth)
    if kind == "z":
        depth = np.asarray(
            convert_depth(depth, p, source="distance", target="z", any_aspect=True), np.float64
        )
    depth[empty] = filling
    with np.errstate(over="ignore"):
        return depth.astype(np.float32 if single else np.float64)
