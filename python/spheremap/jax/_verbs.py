"""Printed code of maps with derivatives of its own.

JAX derives a choice by what both of its sides make of no gradient: a side that is not taken and is
not finite spoils the gradient. So the first derivative of `encode` and `decode` is `jacobian`,
which is printed too, and that of `jacobian` and `density` is a forward one, of one side alone.
Where a map has no value its derivative is zero, so that what a choice leaves out spoils no sum.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp

from ..map.compiled import compiled
from ..map.spec import map_of
from ._given import length

Function = Callable[..., jax.Array]


def width(spec: str) -> int:
    """Return how many numbers a place of a map has: that of the face is the third."""
    return 3 if map_of(spec).layout == "faces" else 2


def _function(verb: str, data: jax.Array, spec: str) -> jax.Array:
    found: jax.Array = compiled(spec, "jax", data.dtype == jnp.float64)[verb](data)
    return found


def _of_place(verb: str, uv: jax.Array, spec: str) -> jax.Array:
    found = _function(verb, uv, spec)
    valid = _function("valid", uv, spec)
    return jnp.where(valid.reshape(valid.shape + (1,) * (found.ndim - valid.ndim)), found, jnp.nan)


def _known(slope: jax.Array) -> jax.Array:
    return jnp.where(jnp.isnan(slope), 0.0, slope)


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def encode(directions: jax.Array, spec: str) -> jax.Array:
    """Return places of directions of any length."""
    # What is printed takes unit vectors, and squares of the largest and the smallest have no width.
    largest = jnp.max(jnp.abs(directions), axis=-1, keepdims=True)
    scaled = directions / largest
    unit = scaled / jnp.linalg.norm(scaled, axis=-1, keepdims=True)
    known = jnp.all(jnp.isfinite(unit), axis=-1, keepdims=True)
    return jnp.where(known, _function("encode", unit, spec), jnp.nan)


def _encode_jvp(
    spec: str, primals: tuple[jax.Array], tangents: tuple[jax.Array]
) -> tuple[jax.Array, jax.Array]:
    """Return places, and how they change: by the inverse of `jacobian`, over the length.

    Of its two columns the products make a 2x2 matrix, whose inverse takes them to two rows that are
    tangent to the sphere.
    """
    (directions,), (tangent,) = primals, tangents
    uv = encode(directions, spec)
    columns = jacobian(uv, spec)
    by_u, by_v = columns[..., 0], columns[..., 1]
    a, b, c = (jnp.sum(p * q, -1) for p, q in ((by_u, by_u), (by_u, by_v), (by_v, by_v)))
    over = 1.0 / ((a * c - b * b) * length(directions))
    rows = [
        (c * over)[..., None] * by_u - (b * over)[..., None] * by_v,
        (a * over)[..., None] * by_v - (b * over)[..., None] * by_u,
    ]
    covered = ~jnp.isnan(uv[..., :1])
    along = [jnp.sum(jnp.where(covered, row, 0.0) * tangent, -1) for row in rows]
    # The number of a face does not change.
    along += [jnp.zeros_like(along[0])] * (uv.shape[-1] - 2)
    return uv, jnp.stack(along, axis=-1)


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def decode(uv: jax.Array, spec: str) -> jax.Array:
    """Return directions of places."""
    return _of_place("decode", uv, spec)


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def jacobian(uv: jax.Array, spec: str) -> jax.Array:
    """Return the derivatives of directions by u and v, in the last axis."""
    return _of_place("jacobian", uv, spec)


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def density(uv: jax.Array, spec: str) -> jax.Array:
    """Return steradians per unit of image area."""
    return _of_place("density", uv, spec)


def _slopes(verb: str, uv: jax.Array, spec: str) -> jax.Array:
    """Return the derivatives of a verb by u and v, in the last axis."""

    def column(k: int) -> jax.Array:
        along = jnp.zeros_like(uv).at[..., k].set(1.0)
        found: jax.Array = jax.jvp(lambda at: _function(verb, at, spec), (uv,), (along,))[1]
        return found

    return jnp.stack([column(0), column(1)], axis=-1)


def _by_place(verb: Function, slope: Function) -> Callable[..., tuple[jax.Array, jax.Array]]:
    def rule(
        spec: str, primals: tuple[jax.Array], tangents: tuple[jax.Array]
    ) -> tuple[jax.Array, jax.Array]:
        (uv,), (tangent,) = primals, tangents
        found = verb(uv, spec)
        along = tangent[..., :2].reshape(*uv.shape[:-1], *(1,) * (found.ndim - uv.ndim + 1), 2)
        return found, jnp.sum(_known(slope(uv, spec)) * along, axis=-1)

    return rule


encode.defjvp(_encode_jvp)
decode.defjvp(_by_place(decode, jacobian))
jacobian.defjvp(_by_place(jacobian, partial(_slopes, "jacobian")))
density.defjvp(_by_place(density, partial(_slopes, "density")))
