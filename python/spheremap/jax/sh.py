"""Spherical harmonics of arrays of JAX, with derivatives.

Coefficients are along the last axis, (..., (order + 1)²), and channels and batches before it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from .. import sh
from ..map.spec import spec_of
from ..resample import linear
from . import _harmonics, _sums
from ._given import in_float, one_rotation, split_rotation, turned_back, vectors
from .images import channels_last
from .maps import directions as directions_of

if TYPE_CHECKING:
    from ..map.named import ProjectionLike

__all__ = ["convolve", "evaluate", "project", "rotate"]


def project(
    image: Any,
    /,
    projection: ProjectionLike,
    *,
    order: int,
    texels: str = "means",
    axes: str | None = None,
    rotation: Any | None = None,
    any_aspect: bool = False,
) -> jax.Array:
    """Return the spherical harmonic coefficients of an image.

    Parameters
    ----------
    image : Array
        As for `spheremap.jax.sample`.
    projection, order, texels, axes, any_aspect
        As for `spheremap.sh.project`.
    rotation : Array, array_like or an object with ``.as_matrix()``, optional
        As for `spheremap.sh.project`, of shape (3, 3). Gradients flow to an array of JAX.

    Returns
    -------
    coefficients : Array, shape ((order + 1)²,), (C, (order + 1)²) or (N, C, (order + 1)²)
        As of `spheremap.sh.project`, of the image's dtype.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.project`.

    Notes
    -----
    The gradient is the exact adjoint of the least squares fit.

    Examples
    --------
    >>> import jax, spheremap.jax as smj
    >>> up = smj.directions("cube", 16)[..., 1]
    >>> along_y = jax.value_and_grad(lambda up: smj.sh.project(up, "cube", order=1)[1])
    >>> value, slope = along_y(up)
    >>> round(float(value), 4), slope.shape
    (2.0467, (6, 16, 16))
    """
    turn, fixed = split_rotation(rotation)
    data = in_float(image, "image")
    spec = spec_of(projection, axes, fixed)
    last, back = channels_last(data, linear.image_axes(spec, data.shape, any_aspect))
    rule = _harmonics.Projected.of(spec, tuple(last.shape[:-1]), order, texels)
    made = back(_sums.apply(rule, last).T)
    return (made if turn is None else rotate(made, turn)).astype(jnp.asarray(image).dtype)


def evaluate(coefficients: Any, directions: Any, /) -> jax.Array:
    """Return the functions that coefficients describe, in given directions.

    Parameters
    ----------
    coefficients : Array, shape (..., (order + 1)²)
        As `project` returns.
    directions : Array, shape (..., 3)
        World directions of any length; the same for each function.

    Returns
    -------
    values : Array
        The leading axes of the coefficients and those of the directions, as `sample` returns them.
        NaN for a direction that is zero or not finite.

    Raises
    ------
    ValueError, TypeError
        For a wrong shape, or what is not of floats.
    NotImplementedError
        For a gradient of directions above order 8, when it is asked for.

    Notes
    -----
    Up to order 8 it is printed code (`spheremap.sh.code`), with all derivatives; above it the
    kernels are called from the program.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax as smj
    >>> along_x = jnp.array([0.0, 0.0, 0.0, 1.0])
    >>> values = smj.sh.evaluate(along_x, jnp.array([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    >>> [round(x, 4) for x in values.tolist()]
    [0.4886, 0.0]
    """
    c, d = in_float(coefficients, "coefficients"), vectors(directions, 3, "directions")
    wide = jnp.promote_types(c.dtype, d.dtype)
    basis = _harmonics.basis(d.astype(wide), _harmonics.order_of(c))
    # What is no direction has no harmonics, and would spoil the gradient of all coefficients.
    known = jnp.all(jnp.isfinite(basis), axis=-1, keepdims=True)
    rows = jnp.where(known, basis, 0.0)
    found = jnp.tensordot(c.astype(wide), rows, axes=(-1, -1), precision="highest")
    return jnp.where(known[..., 0], found, jnp.nan).astype(jnp.asarray(coefficients).dtype)


def rotate(coefficients: Any, /, rotation: Any) -> jax.Array:
    """Turn the functions that coefficients describe: f'(R d) = f(d).

    Parameters
    ----------
    coefficients : Array, shape (..., (order + 1)²)
        As `project` returns.
    rotation : Array, array_like or an object with ``.as_matrix()``
        Of shape (3, 3). Gradients flow to an array of JAX, up to order 8.

    Returns
    -------
    coefficients : Array, of the same shape

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.rotate`.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap as sm, spheremap.jax as smj
    >>> turned = smj.sh.rotate(jnp.array([0.0, 0.0, 1.0, 0.0]), sm.rotation(90, 0, 0))
    >>> (turned.round(4) + 0.0).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    c = in_float(coefficients, "coefficients")
    order = _harmonics.order_of(c)
    turn, fixed = split_rotation(rotation)
    if turn is None:
        matrix = jnp.asarray(sh.rotate(np.eye((order + 1) ** 2), fixed), c.dtype)
        found = jnp.matmul(c, matrix.T, precision="highest")
        return found.astype(jnp.asarray(coefficients).dtype)
    turn = one_rotation(turn)
    # A grid that determines the function: its values, turned, are those of the result.
    grid = directions_of("latlong", 2 * order + 2, dtype=c.dtype)
    values = evaluate(c, turned_back(turn, grid))
    flat = values.reshape(-1, *grid.shape[:-1])
    found = project(flat, "latlong", order=order, texels="points")
    return found.reshape(c.shape).astype(jnp.asarray(coefficients).dtype)


def convolve(coefficients: Any, /, *, lobe: Any, **parameters: float) -> jax.Array:
    """Convolve with a lobe that is round about its axis, degree by degree.

    Parameters
    ----------
    coefficients : Array, shape (..., (order + 1)²)
        As `project` returns.
    lobe : str or array_like, shape (order + 1,)
        A name for `spheremap.sh.lobe`, or the factors themselves, to which gradients flow.
    **parameters : float
        Of the named lobe.

    Returns
    -------
    coefficients : Array, of the same shape

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.convolve`.

    Examples
    --------
    Irradiance over π:

    >>> import jax.numpy as jnp, spheremap.jax as smj
    >>> c = jnp.array([1.0, 0.0, 3.0, 0.0])
    >>> (smj.sh.convolve(c, lobe="cosine") / jnp.pi).round(4).tolist()
    [1.0, 0.0, 2.0, 0.0]
    """
    c = in_float(coefficients, "coefficients")
    order = _harmonics.order_of(c)
    if isinstance(lobe, str):
        kind: Any = lobe
        lobe, parameters = sh.lobe(kind, order=order, **parameters), {}
    factors = jnp.asarray(lobe, c.dtype)
    sh.expect_factors(factors.shape, order, parameters)
    degrees = np.repeat(np.arange(order + 1), 2 * np.arange(order + 1) + 1)
    return (c * factors[degrees]).astype(jnp.asarray(coefficients).dtype)
