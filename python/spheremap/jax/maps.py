"""The verbs of one map, of arrays of JAX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp

from ..map import verbs
from ..map.compiled import compiled
from ..map.spec import spec_of
from . import _verbs
from ._given import split_rotation, turned, turned_back, vectors

if TYPE_CHECKING:
    from .._arrays import Size
    from ..map.named import ProjectionLike

__all__ = ["decode", "density", "directions", "encode", "jacobian", "reflect"]


def encode(
    directions: Any,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> jax.Array:
    """Map directions to image coordinates.

    Parameters
    ----------
    directions : Array, shape (..., 3)
        World directions of any length, of floats. float16 and bfloat16 are computed in float32.
    projection, axes
        As for `spheremap.encode`.
    rotation : Array, array_like or an object with ``.as_matrix()``, optional
        As for `spheremap.encode`. An array of JAX of shape (..., 3, 3), to which gradients flow, is
        multiplied as it is, unchecked; its leading axes broadcast against those of `directions`.

    Returns
    -------
    uv : Array, shape (..., 2), or (..., 3) for a projection of several faces
        As of `spheremap.encode`, of the dtype of `directions`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.encode`; TypeError for what is not of floats.

    Notes
    -----
    It is printed code (`spheremap.code`), within twice the map's bound of a round trip of the
    library's own.

    The derivative is the inverse of `jacobian`, over the length of the direction. At a pole it is
    not finite, on a crease it is that of the side that `encode` takes. Outside the coverage, where
    (u, v) are NaN, it is zero: what a `jnp.where` leaves out does not spoil the rest. The number of
    a face has none.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, spheremap.jax
    >>> d = jnp.array([0.0, 0.0, -2.0])
    >>> slope = jax.grad(lambda d: spheremap.jax.encode(d, "latlong")[0])(d)
    >>> (slope * 4 * jnp.pi + 0.0).round(5).tolist()
    [1.0, 0.0, 0.0]
    """
    turn, fixed = split_rotation(rotation)
    data = vectors(directions, 3, "directions")
    if turn is not None:
        data = turned_back(turn, data)
    found = _verbs.encode(data, spec_of(projection, axes, fixed))
    return found.astype(jnp.asarray(directions).dtype)


def decode(
    uv: Any,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> jax.Array:
    """Map image coordinates to directions: the inverse of `encode`.

    Parameters
    ----------
    uv : Array, shape (..., 2), or (..., 3) for a projection of several faces
        As `encode` returns.
    projection, axes, rotation
        As for `encode`.

    Returns
    -------
    directions : Array, shape (..., 3)
        World directions of unit length; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The derivative is `jacobian`, and zero outside the valid image.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> (spheremap.jax.decode(jnp.array([0.5, 0.5]), "octahedral") + 0.0).tolist()
    [0.0, 0.0, 1.0]
    """
    turn, fixed = split_rotation(rotation)
    spec = spec_of(projection, axes, fixed)
    found = _verbs.decode(_places(uv, spec), spec)
    if turn is not None:
        found = turned(turn, found)
    return found.astype(jnp.asarray(uv).dtype)


def jacobian(
    uv: Any,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> jax.Array:
    """Return the derivative of the direction by the image coordinates.

    Parameters
    ----------
    uv : Array, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection, axes, rotation
        As for `encode`.

    Returns
    -------
    jacobian : Array, shape (..., 3, 2)
        As of `spheremap.jacobian`.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> found = spheremap.jax.jacobian(jnp.array([0.5, 0.5]), "latlong")
    >>> (found + 0.0).round(4).tolist()  # doctest: +ELLIPSIS
    [[6.283..., 0.0], [0.0, -3.141...], [0.0, 0.0]]
    """
    turn, fixed = split_rotation(rotation)
    spec = spec_of(projection, axes, fixed)
    found = _verbs.jacobian(_places(uv, spec), spec)
    if turn is not None:
        found = turn.astype(found.dtype) @ found
    return found.astype(jnp.asarray(uv).dtype)


def density(uv: Any, /, projection: ProjectionLike) -> jax.Array:
    """Return the solid angle per unit of image area, dω/(du dv).

    Parameters
    ----------
    uv : Array, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection : Projection or str
        As for `encode`.

    Returns
    -------
    density : Array, shape (...)
        Steradians per unit of uv area; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> spheremap.jax.density(jnp.array([0.5, 0.5]), "sphere").round(4).item()
    16.0
    """
    spec = spec_of(projection)
    return _verbs.density(_places(uv, spec), spec).astype(jnp.asarray(uv).dtype)


def directions(
    projection: ProjectionLike,
    size: Size,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    dtype: Any = jnp.float32,
    any_aspect: bool = False,
) -> jax.Array:
    """Return the direction of every texel.

    Parameters
    ----------
    projection, axes, rotation
        As for `encode`; an array of rotations has shape (3, 3).
    size : int or tuple of int
        As for `spheremap.directions`.
    dtype : dtype of floats
        Of the result; float64 wants ``jax_enable_x64``.
    any_aspect : bool
        As for `spheremap.directions`.

    Returns
    -------
    directions : Array, the image's shape + (3,)
        Unit length; NaN for texels whose center lies outside the valid image. Computed by the
        kernels, as a constant of what is compiled.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.directions`.

    Examples
    --------
    >>> import spheremap.jax
    >>> spheremap.jax.directions("cube", 16).shape
    (6, 16, 16, 3)
    """
    turn, fixed = split_rotation(rotation)
    found = jnp.asarray(
        verbs.directions(
            projection,
            size,
            axes=axes,
            rotation=fixed,
            dtype="float64" if jnp.dtype(dtype) == jnp.float64 else "float32",
            any_aspect=any_aspect,
        )
    )
    return (found if turn is None else turned(turn, found)).astype(dtype)


def reflect(view: Any, normal: Any, /) -> jax.Array:
    """Reflect view vectors about normals: r = 2(v·n)n/(n·n) - v.

    Parameters
    ----------
    view : Array, shape (..., 3)
        From the surface toward the eye; the result keeps its length.
    normal : Array, shape (..., 3)
        Of any length. The two broadcast.

    Returns
    -------
    reflected : Array, shape (..., 3)
        The direction to look up in an environment map.

    Raises
    ------
    ValueError, TypeError
        For what is not (..., 3), or not of floats.

    Notes
    -----
    It is printed code (`spheremap.code`), with all derivatives.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> view, normal = jnp.array([[1.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
    >>> spheremap.jax.reflect(view, normal).tolist()
    [-1.0, 1.0, 0.0]
    """
    pair = vectors(view, 3, "view"), vectors(normal, 3, "normal")
    wide = any(one.dtype == jnp.float64 for one in pair)
    found = compiled("latlong", "jax", wide)["reflect"](*jnp.broadcast_arrays(*pair))
    return found.astype(jnp.promote_types(jnp.asarray(view).dtype, jnp.asarray(normal).dtype))


def _places(uv: Any, spec: str) -> jax.Array:
    return vectors(uv, _verbs.width(spec), "uv")
