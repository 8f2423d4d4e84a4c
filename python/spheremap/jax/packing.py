"""Packing directions of arrays of JAX, with a gradient that passes straight through."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from .. import packing
from ._given import unit_vectors, vectors

if TYPE_CHECKING:
    from ..packing import Packing

__all__ = ["quantize"]


def quantize(directions: Any, name: str | Packing, /, rounding: str = "precise") -> jax.Array:
    """Return directions as they come back from codes, with the gradient of no packing.

    Parameters
    ----------
    directions : Array, shape (..., 3)
        Directions of any length.
    name, rounding
        As for `spheremap.packing.pack`.

    Returns
    -------
    directions : Array, shape (..., 3)
        Unit vectors; NaN where there is no direction.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.pack`.

    Notes
    -----
    The gradient is straight through (Bengio, Léonard and Courville 2013, Estimating or Propagating
    Gradients Through Stochastic Neurons): that of ``d/|d|``, which is what is packed. The true one
    is zero almost everywhere. The kernels are called from the program.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, spheremap.jax as smj
    >>> d = jnp.array([3.0, 4.0, 0.0])
    >>> slope = jax.grad(lambda d: smj.packing.quantize(d, "oct16")[0])(d)
    >>> [round(x, 4) for x in smj.packing.quantize(d, "oct16").tolist()]
    [0.5947, 0.8039, 0.0]
    >>> [round(x, 4) for x in slope.tolist()]
    [0.128, -0.096, 0.0]
    """
    unit, known = unit_vectors(vectors(directions, 3, "directions"))
    scheme = packing.packing(name).name
    # What is wrong with a name is said now, and not by a running program.
    packing.pack(np.array([0.0, 0.0, 1.0]), scheme, rounding)
    found = jnp.where(known, _quantized(unit, scheme, rounding), jnp.nan)
    return found.astype(jnp.asarray(directions).dtype)


@partial(jax.custom_jvp, nondiff_argnums=(1, 2))
def _quantized(unit: jax.Array, name: str, rounding: str) -> jax.Array:
    def call(unit: Any) -> Any:
        given = np.asarray(unit)
        return packing.unpack(packing.pack(given, name, rounding), name, dtype=given.dtype)

    result = jax.ShapeDtypeStruct(unit.shape, unit.dtype)
    found: jax.Array = jax.pure_callback(call, result, unit, vmap_method="expand_dims")
    return found


def _straight(name: str, rounding: str, primals: Any, tangents: Any) -> Any:
    return _quantized(*primals, name, rounding), tangents[0]


_quantized.defjvp(_straight)
