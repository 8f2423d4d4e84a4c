"""Sums of texels by the kernels, as one primitive of JAX that is linear in the image.

A primitive has the rules that `custom_jvp` and `custom_vjp` have one of: its forward derivative is
itself, and what transposes it is the exact adjoint. So `jit`, `grad`, `jvp`, `vmap` and `pmap` go
through. On the CPU it is a call of the library; where a rule has sums of JAX's own, these run
elsewhere.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir


class Rule(Protocol):
    """What a call does; equal rules do the same."""

    @property
    def adjoint(self) -> Rule:
        """The transposed one."""

    @property
    def plain(self) -> Rule:
        """The same without what is not linear."""

    def shape(self, *given: Any) -> tuple[int, ...]:
        """Return the shape of the result without channels."""

    def tangent(self, image: jax.Array, *given: Any) -> jax.Array:
        """Return how the result changes with what else is given: these, and how they change."""

    def run(self, image: Any, *given: Any) -> Any:
        """Do it by the kernels, on arrays of NumPy."""

    def traced(self, image: jax.Array, *given: jax.Array) -> jax.Array:
        """Do it by operations of JAX, or by a call of the kernels from the device."""


_primitive = Primitive("spheremap_sums")


def apply(rule: Rule, image: jax.Array, *given: jax.Array) -> jax.Array:
    """Return sums of an image's texels (..., channels), chosen by what else is given."""
    found: jax.Array = _primitive.bind(image, *given, rule=rule)
    return found


def called(rule: Rule, image: jax.Array, *given: jax.Array) -> jax.Array:
    """Return what the kernels make of arrays, as a call from a compiled program."""
    result = jax.ShapeDtypeStruct((*rule.shape(*given), image.shape[-1]), image.dtype)

    def call(*arrays: Any) -> Any:
        found = rule.run(*(np.asarray(array) for array in arrays))
        return np.asarray(found, result.dtype)

    found: jax.Array = jax.pure_callback(call, result, image, *given)
    return found


@lru_cache(64)
def _compiled(rule: Rule) -> Any:
    return jax.jit(partial(apply, rule))


def _batched(given: tuple[Any, ...], axes: tuple[Any, ...], *, rule: Rule) -> tuple[jax.Array, int]:
    """More images are more channels; other arrays that have the axis are done one by one."""
    image, *others = given
    if not any(isinstance(axis, int) for axis in axes[1:]):
        last = jnp.moveaxis(image, axes[0], -1)
        found = apply(rule, last.reshape(*last.shape[:-2], -1), *others)
        return found.reshape(*found.shape[:-1], *last.shape[-2:]), found.ndim
    count = next(x.shape[k] for x, k in zip(given, axes, strict=True) if isinstance(k, int))
    whole = [
        jnp.moveaxis(x, k, 0) if isinstance(k, int) else jnp.broadcast_to(x, (count, *x.shape))
        for x, k in zip(given, axes, strict=True)
    ]
    return jax.lax.map(lambda one: apply(rule, *one), tuple(whole)), 0


def _forward(primals: tuple[Any, ...], tangents: tuple[Any, ...], *, rule: Rule) -> tuple[Any, Any]:
    result = apply(rule, *primals)
    terms = []
    if not isinstance(tangents[0], ad.Zero):
        terms.append(apply(rule.plain, tangents[0], *primals[1:]))
    if any(not isinstance(tangent, ad.Zero) for tangent in tangents[1:]):
        along = [ad.instantiate_zeros(tangent) for tangent in tangents[1:]]
        terms.append(rule.tangent(*primals, *along))
    return result, sum(terms[1:], terms[0]) if terms else ad.Zero.from_primal_value(result)


def _transposed(gradient: Any, *given: Any, rule: Rule) -> list[Any]:
    if isinstance(gradient, ad.Zero):
        return [None] * len(given)
    back = apply(rule.adjoint, gradient, *given[1:])
    return [back, *(None for _ in given[1:])]


def _shaped(image: Any, *given: Any, rule: Rule) -> Any:
    return jax.core.ShapedArray((*rule.shape(*given), image.shape[-1]), image.dtype)


def _on_cpu(image: jax.Array, *given: jax.Array, rule: Rule) -> jax.Array:
    return called(rule, image, *given)


def _elsewhere(image: jax.Array, *given: jax.Array, rule: Rule) -> jax.Array:
    return rule.traced(image, *given)


_primitive.def_impl(lambda *given, rule: _compiled(rule)(*given))
_primitive.def_abstract_eval(_shaped)
ad.primitive_jvps[_primitive] = _forward
ad.primitive_transposes[_primitive] = _transposed
batching.primitive_batchers[_primitive] = _batched
mlir.register_lowering(_primitive, mlir.lower_fun(_on_cpu, multiple_results=False), platform="cpu")
mlir.register_lowering(_primitive, mlir.lower_fun(_elsewhere, multiple_results=False))
