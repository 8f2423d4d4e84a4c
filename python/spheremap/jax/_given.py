"""What callers give: arrays of floats, and rotations that are arrays of JAX or are not."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np


def in_float(given: Any, name: str) -> jax.Array:
    """Return an array in the width that it is computed in: half floats in float32."""
    array = jnp.asarray(given)
    if array.dtype in (jnp.float16, jnp.bfloat16):
        return array.astype(jnp.float32)
    if array.dtype not in (jnp.float32, jnp.float64):
        raise TypeError(f"Expected `{name}` to be of floats, got {array.dtype}.")
    return array


def is_known(array: jax.Array) -> bool:
    """Tell whether an array has numbers, and does not stand for those of a program."""
    return not isinstance(array, jax.core.Tracer)


def vectors(given: Any, length: int, name: str) -> jax.Array:
    """Return an array whose last axis has so many numbers."""
    array = in_float(given, name)
    if array.ndim == 0 or array.shape[-1] != length:
        raise ValueError(f"Expected `{name}` to be (..., {length}), got {array.shape}.")
    return array


def unit_vectors(directions: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Return directions of length 1, as printed code takes them, and which there are (..., 1).

    Others are along z, so that what is left out spoils no gradient.
    """
    known = jnp.all(jnp.isfinite(directions), axis=-1, keepdims=True)
    known &= jnp.any(directions != 0, axis=-1, keepdims=True)
    safe = jnp.where(known, directions, jnp.array([0.0, 0.0, 1.0], directions.dtype))
    # Squares of the largest and the smallest have no width.
    largest = jax.lax.stop_gradient(jnp.max(jnp.abs(safe), axis=-1, keepdims=True))
    scaled = safe / largest
    return scaled / jnp.linalg.norm(scaled, axis=-1, keepdims=True), known


def split_rotation(rotation: Any | None) -> tuple[jax.Array | None, Any | None]:
    """Return a rotation that gradients may flow to, or one that the map is turned by."""
    if rotation is None or hasattr(rotation, "as_matrix"):
        return None, rotation
    if not isinstance(rotation, jax.Array):
        return None, np.asarray(rotation)
    if rotation.shape[-2:] != (3, 3):
        raise ValueError(f"Expected `rotation` to be (..., 3, 3), got {rotation.shape}.")
    return rotation, None


def power_of_two(vectors: jax.Array) -> jax.Array:
    """Return what brings the largest number of each vector near 1, (..., 1), by a division.

    A power of two rounds nothing; it is a constant to derivatives.
    """
    largest = jax.lax.stop_gradient(jnp.max(jnp.abs(vectors), axis=-1, keepdims=True))
    known = jnp.where(jnp.isfinite(largest) & (largest > 0), largest, 1.0)
    return known / (2 * jnp.frexp(known)[0])


def length(directions: jax.Array) -> jax.Array:
    """Return lengths (...), of the largest and the smallest too, whose squares have no width."""
    largest = jax.lax.stop_gradient(jnp.max(jnp.abs(directions), axis=-1))
    return largest * jnp.linalg.norm(directions / largest[..., None], axis=-1)


def one_rotation(rotation: jax.Array) -> jax.Array:
    """Return a rotation that there may be one of."""
    if rotation.ndim != 2:
        raise ValueError(f"Expected `rotation` to have shape (3, 3), got {rotation.shape}.")
    return rotation


def turned(matrix: jax.Array, directions: jax.Array) -> jax.Array:
    """Return R d, in the width of the directions."""
    return (matrix.astype(directions.dtype) @ directions[..., None])[..., 0]


def turned_back(matrix: jax.Array, directions: jax.Array) -> jax.Array:
    """Return Rᵀ d, where directions were before a rotation took what is at d to R d."""
    return turned(jnp.swapaxes(matrix, -1, -2), directions)
