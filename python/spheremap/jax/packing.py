"""Packing directions of arrays of JAX, with a gradient that passes straight through.

The kernels of the CPU do it, called from the program where there is one.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from .. import packing
from ._given import is_known, unit_vectors, vectors

if TYPE_CHECKING:
    from ..packing import Packing

__all__ = ["pack", "quantize", "unpack"]


def pack(
    directions: Any,
    name: str | Packing,
    /,
    rounding: str = "precise",
    *,
    invalid: str = "raise",
) -> jax.Array:
    """Pack directions into a few bits each.

    Parameters
    ----------
    directions : Array, shape (..., 3)
        Directions of any length.
    name, rounding, invalid
        As for `spheremap.packing.pack`.

    Returns
    -------
    codes : Array, shape (...) or (..., k)
        Of the integer dtype that `spheremap.packing.packing` says.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.pack`, and for codes of 64 bits without ``jax_enable_x64``. What
        is wrong with a direction is said when a program runs, as an error of JAX.

    Notes
    -----
    Integers have no gradient: `quantize` has one. The kernels are called from the program.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax as smj
    >>> hex(smj.packing.pack(jnp.array([1.0, 0.0, 0.0]), "oct16").item())
    '0x7f'
    """
    data = jax.lax.stop_gradient(vectors(directions, 3, "directions"))
    about = packing.packing(name)
    if jax.dtypes.canonicalize_dtype(about.dtype) != about.dtype:
        raise ValueError(f"Codes of '{about.name}' are {about.dtype}, which wants jax_enable_x64.")

    def call(directions: Any) -> Any:
        codes = packing.pack(np.asarray(directions), about.name, rounding, invalid=invalid)
        return np.asarray(codes)

    if is_known(data):
        return jnp.asarray(call(data))
    # What is wrong with a word is said now, and not by a running program.
    call(np.array([0.0, 0.0, 1.0]))
    result = jax.ShapeDtypeStruct((*data.shape[:-1], *about.shape), about.dtype)
    found: jax.Array = jax.pure_callback(call, result, data, vmap_method="expand_dims")
    return found


def unpack(codes: Any, name: str | Packing, /, *, dtype: Any = jnp.float32) -> jax.Array:
    """Unpack codes to unit vectors.

    Parameters
    ----------
    codes : Array of integers, shape (...) or (..., k)
        As `pack` returns them.
    name : Packing or str
        The scheme.
    dtype : dtype of floats
        Of the result; float64 wants ``jax_enable_x64``.

    Returns
    -------
    directions : Array, shape (..., 3)
        Unit vectors.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.unpack`. What is wrong with a code is said when a program runs, as
        an error of JAX.

    Notes
    -----
    The kernels are called from the program.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax as smj
    >>> smj.packing.unpack(jnp.array([0x7F7F, 0x7F], jnp.uint16), "oct16").tolist()
    [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]
    """
    data, about = jnp.asarray(codes), packing.packing(name)
    wide = jax.dtypes.canonicalize_dtype(dtype) == jnp.float64
    width: Any = np.float64 if wide else np.float32

    def call(codes: Any) -> Any:
        return np.asarray(packing.unpack(np.asarray(codes), about.name, dtype=width))

    if is_known(data):
        return jnp.asarray(call(data)).astype(dtype)
    fields = len(about.shape)
    call(np.zeros(data.shape[data.ndim - fields :], data.dtype))
    result = jax.ShapeDtypeStruct((*data.shape[: data.ndim - fields], 3), width)
    found: jax.Array = jax.pure_callback(call, result, data, vmap_method="expand_dims")
    return found.astype(dtype)


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
