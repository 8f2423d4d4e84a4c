"""Spherical harmonics: the fit as a rule of sums, and the basis as printed code."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .. import _core, sh
from ..map.spec import HELD, map_of
from ._given import unit_vectors

# Above this order code is longer than what it computes is worth.
HIGHEST_PRINTED = 8


def order_of(coefficients: jax.Array) -> int:
    """Return the order of coefficients (..., (order + 1)²)."""
    count = coefficients.shape[-1] if coefficients.ndim else 0
    order = math.isqrt(count) - 1
    if count == 0 or (order + 1) ** 2 != count:
        raise ValueError(
            "Expected `coefficients` to have (order + 1)² numbers in the last axis, got "
            f"{coefficients.shape}."
        )
    return order


# Images: channels last ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Projected:
    """The coefficients of images of one map and shape."""

    spec: str
    image: tuple[int, ...]
    order: int
    texels: str
    is_adjoint: bool = False

    @classmethod
    def of(cls, spec: str, image: tuple[int, ...], order: int, texels: str) -> Projected:
        """Return it; what is wrong with an order or a name is said now."""
        kind: Any = texels
        made = sh.project(
            np.zeros((*image, 1)), map_of(spec), order=order, texels=kind, any_aspect=True
        )
        return cls(spec, image, math.isqrt(len(made)) - 1, texels)

    @property
    def adjoint(self) -> Projected:
        """The transposed one."""
        return Projected(self.spec, self.image, self.order, self.texels, not self.is_adjoint)

    @property
    def plain(self) -> Projected:
        """The same."""
        return self

    def shape(self) -> tuple[int, ...]:
        """Return the shape of the result without channels."""
        return self.image if self.is_adjoint else ((self.order + 1) ** 2,)

    def tangent(self, image: jax.Array, *given: Any) -> jax.Array:
        """Nothing else is given."""
        raise AssertionError

    def run(self, image: Any) -> Any:
        """Do it by the kernel."""
        if self.is_adjoint:
            rows = np.ascontiguousarray(image, np.float64)
            finite = np.isfinite(rows)
            found = self._spread(np.where(finite, rows, 0.0))
            # Each coefficient flows back to all texels of its channel, and so does what is no
            # number.
            found[..., ~finite.all(axis=0)] = np.nan
            return found
        kind: Any = self.texels
        options: dict[str, Any] = {"order": self.order, "texels": kind, "any_aspect": True}
        return sh.project(image, map_of(self.spec), **options)

    def traced(self, image: jax.Array) -> jax.Array:
        """Multiply by the matrix."""
        matrix = self._spread(np.eye((self.order + 1) ** 2)).reshape(-1, (self.order + 1) ** 2)
        flat = image.reshape(-1, image.shape[-1])
        held = jnp.asarray(matrix if self.is_adjoint else matrix.T, image.dtype)
        return jnp.matmul(held, flat, precision="highest").reshape(*self.shape(), -1)

    def _spread(self, rows: Any) -> Any:
        found = _core.sh_project_adjoint(
            rows, map_of(self.spec), self.image, self.texels == "points"
        )
        return found.reshape(*self.image, -1)


# The basis ----------------------------------------------------------------------------------------


@lru_cache(HELD)
def _printed(order: int, double: bool) -> Any:
    names: dict[str, Any] = {}
    dtype = "float64" if double else "float32"
    exec(sh.code(np.eye((order + 1) ** 2), "jax", dtype=dtype), names)
    return names["sh_evaluate"]


def basis(directions: jax.Array, order: int) -> jax.Array:
    """Return all harmonics (..., (order + 1)²) in directions of any length."""
    unit, known = unit_vectors(directions)
    if order <= HIGHEST_PRINTED:
        found = _printed(order, directions.dtype == jnp.float64)(unit)
        # One number is no vector.
        found = found.reshape(*directions.shape[:-1], (order + 1) ** 2)
    else:
        found = _called(unit, order)
    return jnp.where(known, found, jnp.nan)


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def _called(unit: jax.Array, order: int) -> jax.Array:
    result = jax.ShapeDtypeStruct((*unit.shape[:-1], (order + 1) ** 2), unit.dtype)

    def call(unit: Any) -> Any:
        found = sh.evaluate(np.eye((order + 1) ** 2), np.asarray(unit))
        return np.asarray(found, result.dtype)

    found: jax.Array = jax.pure_callback(call, result, unit, vmap_method="expand_dims")
    return found


def _no_derivative(order: int, *_: Any) -> Any:
    raise NotImplementedError(
        f"Above order {HIGHEST_PRINTED} spherical harmonics have no derivative by directions."
    )


_called.defjvp(_no_derivative)
