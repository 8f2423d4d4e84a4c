"""The verbs of one map, of arrays of JAX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp

from ..map import verbs
from ..map.compiled import compiled
from ..map.grid import places
from ..map.images import target_shape
from ..map.spec import map_of, spec_of
from . import _moving, _verbs
from ._given import one_rotation, power_of_two, split_rotation, turned, turned_back, vectors
from ._moving import Moving

if TYPE_CHECKING:
    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["decode", "density", "directions", "encode", "jacobian", "projection", "reflect"]


def projection(name: ProjectionLike, /, **parameters: Any) -> Projection | Moving:
    """Return a projection whose parameters may be arrays of JAX, to which gradients flow.

    Parameters
    ----------
    name : str or Projection
        As for `spheremap.projection`. A Projection keeps its axes, grid and world.
    **parameters : float or Array
        The projection's own parameters, as ``fov`` (degrees) of ``"perspective"`` or ``k1`` of
        ``"camera_kannala_brandt"``: numbers, and arrays of JAX of one float without axes. With a
        name also ``axes`` and the other options of `spheremap.projection`.

    Returns
    -------
    projection
        What `encode`, `decode`, `directions`, `sample` and `convert` take where they take a
        projection; a plain Projection where no parameter is an array of JAX.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.projection`; ValueError for an array that is not one float. What is wrong
        with a number that a transform hides is an error of the program that runs.

    Notes
    -----
    The verbs are the kernels, called from the program. The derivatives by parameters are
    differences of the kernels in float64, of fourth order, within some 1e-9 of a derivative; there
    are no second ones. They cost four calls of `decode` for each parameter. Without
    ``jax_enable_x64`` a parameter is rounded to float32.

    Shapes of images are known when a program is traced, and its numbers are not: a `size` of one
    number stands for the shape of an image of `name` with the parameters that are no arrays.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, spheremap.jax as smj
    >>> d = jnp.array([0.5, 0.0, -1.0])
    >>> def u(fov):
    ...     return smj.encode(d, smj.projection("perspective", fov=fov))[0]
    >>> value, slope = jax.jit(jax.value_and_grad(u))(90.0)
    >>> round(float(value), 6), round(float(slope), 6)
    (0.75, -0.004363)
    """
    return _moving.projection(name, **parameters)


def encode(
    directions: Any,
    /,
    projection: ProjectionLike | Moving,
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
    if isinstance(projection, Moving):
        found = projection.seen(axes, fixed).encode(data)
    else:
        found = _verbs.encode(data, spec_of(projection, axes, fixed))
    return found.astype(jnp.asarray(directions).dtype)


def decode(
    uv: Any,
    /,
    projection: ProjectionLike | Moving,
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
    if isinstance(projection, Moving):
        moving = projection.seen(axes, fixed)
        found = moving.decode(_places(uv, moving.spec))
    else:
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
    _expect_still(projection)
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
    _expect_still(projection)
    spec = spec_of(projection)
    return _verbs.density(_places(uv, spec), spec).astype(jnp.asarray(uv).dtype)


def directions(
    projection: ProjectionLike | Moving,
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
        kernels, as a constant of what is compiled; of `projection` with parameters that are arrays
        when it runs.

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
    width = "float64" if jnp.dtype(dtype) == jnp.float64 else "float32"
    if isinstance(projection, Moving):
        moving = projection.seen(axes, fixed)
        p = map_of(moving.spec)
        uv = places(p, target_shape(p, size, any_aspect)).astype(width)
        found = moving.decode(jnp.asarray(uv))
    else:
        found = jnp.asarray(
            verbs.directions(
                projection, size, axes=axes, rotation=fixed, dtype=width, any_aspect=any_aspect
            )
        )
    return (found if turn is None else turned(one_rotation(turn), found)).astype(dtype)


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
    It is printed code (`spheremap.code`), with all derivatives. Where there is no normal, or a
    number is not finite, the result is NaN and no gradient flows.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> view, normal = jnp.array([[1.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
    >>> spheremap.jax.reflect(view, normal).tolist()
    [-1.0, 1.0, 0.0]
    """
    pair = vectors(view, 3, "view"), vectors(normal, 3, "normal")
    wide = jnp.promote_types(pair[0].dtype, pair[1].dtype)
    v, n = jnp.broadcast_arrays(*(one.astype(wide) for one in pair))
    known = jnp.all(jnp.isfinite(v) & jnp.isfinite(n), axis=-1, keepdims=True)
    known &= jnp.any(n != 0, axis=-1, keepdims=True)
    # What is left out below would spoil the gradient of the rest, and the length of a normal has no
    # say.
    v, n = jnp.where(known, v, 0.0), jnp.where(known, n, 1.0)
    size = power_of_two(v)
    mirror = compiled("latlong", "jax", wide == jnp.float64)["reflect"]
    found = jnp.where(known, mirror(v / size, n / power_of_two(n)) * size, jnp.nan)
    return found.astype(jnp.promote_types(jnp.asarray(view).dtype, jnp.asarray(normal).dtype))


def _expect_still(projection: object) -> None:
    if isinstance(projection, Moving):
        raise TypeError(
            "`jacobian` and `density` have no derivative by parameters: give the projection with "
            "numbers, as spheremap.projection makes it."
        )


def _places(uv: Any, spec: str) -> jax.Array:
    return vectors(uv, _verbs.width(spec), "uv")
