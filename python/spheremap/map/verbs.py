"""The verbs of one map: each resolves a name and calls one method of the core."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._scalars import as_number
from .images import target_shape
from .named import resolve
from .standard import is_foreign
from .standard import run as on_standard

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, DTypeLike, NDArray

    from .._arrays import Size
    from .._projection import Projection
    from .named import ProjectionLike

# Past the methods of the subclass, which would resolve once more.
_Core = _core.Projection

__all__ = [
    "covers",
    "decode",
    "density",
    "directions",
    "encode",
    "explain",
    "jacobian",
    "reflect",
    "rotation",
    "solid_angle",
    "valid",
]


def encode(
    directions: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Map directions to image coordinates.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection : Projection or str
        As for `projection`.
    axes : str, optional
        Replaces the axes of the projection.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the world: what is at d goes to ``rotation @ d``.
    out : ndarray, optional
        Where to put the result: C-contiguous, of the result's shape and dtype.

    Returns
    -------
    uv : ndarray, shape (..., 2), or (..., 3) for a projection of several faces
        u in [0, 1] runs right, v in [0, 1] runs down from row 0; the third is the face.
        float32 for float16 and float32 input, else float64. NaN for a direction outside the
        coverage, zero, or not finite.

    Raises
    ------
    ValueError
        For a wrong shape, an unknown name, a matrix that is no rotation, or an unfit `out`.
    TypeError
        For complex numbers and objects, or an `out` of another dtype.

    Notes
    -----
    The formula of each projection and where it comes from: ``Projection.source``.

    Arrays of other libraries that keep the array API standard, such as those of JAX and
    ndonnx, are computed by their own functions, where they are, by printed code (`code`): the
    result is an array of the same library, within twice the bound of the map's round trip. One of
    dask is computed when it is asked for, each chunk as what it is, of NumPy by the kernels. So in
    `decode` and `density`; the methods of `Projection` are for arrays of NumPy.

    Examples
    --------
    The default latlong looks along -z:

    >>> import spheremap as sm
    >>> sm.encode([[0, 0, -1], [1, 0, 0]], "latlong").tolist()
    [[0.5, 0.5], [0.75, 0.5]]
    """
    return _computed("encode", resolve(projection, axes, rotation), directions, "directions", out)


def decode(
    uv: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Map image coordinates to directions: the inverse of `encode`.

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        As `encode` returns.
    projection, axes, rotation, out
        As for `encode`.

    Returns
    -------
    directions : ndarray, shape (..., 3)
        World directions of unit length; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The formula of each projection and where it comes from: ``Projection.source``.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.decode([[0.0, 0.0], [0.5, 0.5]], "sphere").round(6).tolist()
    [[nan, nan, nan], [0.0, -0.0, 1.0]]
    """
    return _computed("decode", resolve(projection, axes, rotation), uv, "uv", out)


def jacobian(
    uv: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Return the derivative of the direction by the image coordinates.

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection, axes, rotation, out
        As for `encode`.

    Returns
    -------
    jacobian : ndarray, shape (..., 3, 2)
        Column 0 is the derivative of `decode` by u, column 1 by v (radians per unit of uv).
        NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    It is computed from the formula of `decode` itself by dual numbers.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.jacobian([0.5, 0.5], "latlong") + 0.0, 6).tolist()
    [[6.283185, 0.0], [0.0, -3.141593], [0.0, 0.0]]
    """
    return _Core.jacobian(resolve(projection, axes, rotation), uv, out)


def density(
    uv: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Return the solid angle per unit of image area, dω/(du dv).

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection, out
        As for `encode`.

    Returns
    -------
    density : ndarray, shape (...)
        Steradians per unit of uv area; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    It is the length of the cross product of the two columns of `jacobian`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.density([[0.5, 0.5], [0.3, 0.4]], "sphere"), 6).tolist()
    [16.0, 16.0]
    """
    return _computed("density", resolve(projection), uv, "uv", out)


def _computed(verb: str, p: Projection, data: Any, name: str, out: Any) -> NDArray[Any]:
    """Return what a verb makes of an array: by its kernel, or by printed code."""
    if type(data) is not np.ndarray and is_foreign(data):
        found: NDArray[Any] = on_standard(verb, p, data, name, out)
    else:
        found = getattr(_Core, verb)(p, data, out)
    return found


def valid(uv: ArrayLike, /, projection: ProjectionLike) -> NDArray[np.bool_]:
    """Tell which image coordinates hold a part of the sphere.

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection : Projection or str
        As for `projection`.

    Returns
    -------
    valid : ndarray of bool, shape (...)

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.valid([[0.5, 0.5], [0.0, 0.0]], "angular").tolist()
    [True, False]
    """
    return _Core.valid(resolve(projection), uv)


def covers(
    directions: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> NDArray[np.bool_]:
    """Tell which directions the image holds.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection, axes, rotation
        As for `encode`.

    Returns
    -------
    covered : ndarray of bool, shape (...)

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.covers([[0, 0, 1], [0, 0, -1]], "matcap").tolist()
    [True, False]
    """
    return _Core.covers(resolve(projection, axes, rotation), directions)


def solid_angle(
    projection: ProjectionLike, size: Size, *, any_aspect: bool = False
) -> NDArray[np.float64]:
    """Return the solid angle of each texel.

    Parameters
    ----------
    projection : Projection or str
        As for `projection`.
    size : int or tuple of int
        One number (the height of a latlong, the side of a square, the face of a cube) or the
        whole shape without channels.
    any_aspect : bool
        Whether a whole shape is taken as it is where it is wider or higher for the projection than
        it should be. By default each side has to be within a texel of its aspect.

    Returns
    -------
    solid_angle : ndarray of float64, shape (H, W), or (F, N, N) for an array of faces
        In steradians. A texel across the rim counts with its covered part; the sum is the
        covered solid angle, 4π for the whole sphere.

    Raises
    ------
    ValueError, TypeError
        For a size that the projection cannot have.

    Examples
    --------
    >>> import math, spheremap as sm
    >>> w = sm.solid_angle("latlong", (4, 8))
    >>> w.shape, math.isclose(w.sum(), 4 * math.pi, rel_tol=1e-12)
    ((4, 8), True)
    """
    p = resolve(projection)
    return _Core.solid_angle(p, target_shape(p, size, any_aspect))


def directions(
    projection: ProjectionLike,
    size: Size,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    dtype: DTypeLike = np.float64,
    any_aspect: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the direction of every texel.

    Parameters
    ----------
    projection, axes, rotation
        As for `encode`.
    size : int or tuple of int
        As for `solid_angle`.
    dtype : float32 or float64
        Of the result.
    any_aspect : bool
        As for `solid_angle`.

    Returns
    -------
    directions : ndarray, the image's shape + (3,)
        Unit length; NaN for texels whose center lies outside the valid image.

    Raises
    ------
    ValueError, TypeError
        For a size that the projection cannot have, or another dtype.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.directions("octahedral", 1).tolist()
    [[[0.0, 0.0, 1.0]]]
    >>> sm.directions("latlong", 256).shape
    (256, 512, 3)
    """
    p = resolve(projection, axes, rotation)
    return _Core.directions(p, target_shape(p, size, any_aspect), dtype=dtype)


def reflect(
    view: ArrayLike, normal: ArrayLike, /, *, out: NDArray[Any] | None = None
) -> NDArray[np.floating[Any]]:
    """Reflect view vectors about normals: r = 2(v·n)n/(n·n) - v.

    Parameters
    ----------
    view : array_like, shape (..., 3)
        From the surface toward the eye; the result keeps its length.
    normal : array_like, shape (..., 3)
        Of any length. The two broadcast.
    out : ndarray, optional
        Where to put the result.

    Returns
    -------
    reflected : ndarray, shape (..., 3)
        The direction to look up in an environment map.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The law of reflection: what GLSL calls ``reflect(-v, n)``, for a normal of any length.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.reflect([1.0, 1.0, 0.0], [0.0, 2.0, 0.0]).tolist()
    [-1.0, 1.0, 0.0]
    """
    return _core.reflect(view, normal, out=out)


def rotation(yaw: float = 0, pitch: float = 0, roll: float = 0) -> NDArray[np.float64]:
    """Return the matrix Ry(yaw) Rx(pitch) Rz(roll), for `rotation=`; right angles are exact.

    Parameters
    ----------
    yaw, pitch, roll : float, optional
        Right-handed turns about +y, +x and +z, in degrees. The roll comes first.

    Returns
    -------
    matrix : ndarray of float64, shape (3, 3)

    Raises
    ------
    ValueError
        For an angle that is not finite.

    Examples
    --------
    >>> import spheremap as sm
    >>> (sm.rotation(yaw=90) @ [0, 0, 1]).tolist()
    [1.0, 0.0, 0.0]
    """
    angles = ((yaw, "yaw"), (pitch, "pitch"), (roll, "roll"))
    return _core.rotation(*(as_number(value, name) for value, name in angles))


def explain(projection: ProjectionLike) -> None:
    """Print where ±x, ±y and ±z land, which way is up, the grid, the coverage and the density.

    Parameters
    ----------
    projection : Projection or str
        As for `projection`.

    Raises
    ------
    ValueError, TypeError
        For an unknown name.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.explain("latlong")  # doctest: +ELLIPSIS, +NORMALIZE_WHITESPACE
    projection latlong: ...
    """
    resolve(projection).explain()
