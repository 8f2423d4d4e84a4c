"""The verbs of images: gathers of bilinear lookups, and rules of what the kernels add up.

Here an image has its channels last, batches among them: (H, W, channels), (F, N, N, channels).
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .. import resample
from ..map.spec import map_of
from ..resample.linear import linear_of, without_fill
from ..resample.lookups import Lookups, between, lookups, number, shares, steps
from . import _sums, _verbs


def flat(image: jax.Array) -> jax.Array:
    """Return an image as (texels, channels)."""
    return image.reshape(math.prod(image.shape[:-1]), image.shape[-1])


# What is linear -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Conversion:
    """A conversion or a border, of images of one shape."""

    key: str
    is_adjoint: bool = False

    @property
    def adjoint(self) -> Conversion:
        """The transposed one."""
        self._expect_sums()
        return Conversion(without_fill(self.key), not self.is_adjoint)

    @property
    def plain(self) -> Conversion:
        """The same, of black images black."""
        self._expect_sums()
        return Conversion(without_fill(self.key), self.is_adjoint)

    def _expect_sums(self) -> None:
        if json.loads(self.key)["filter"] == "mode":
            raise NotImplementedError("`convert` with filter='mode' has no gradient.")

    def shape(self) -> tuple[int, ...]:
        """Return the shape of the result without channels."""
        made = linear_of(self.key)
        return made.source if self.is_adjoint else made.target

    def tangent(self, image: jax.Array, *given: Any) -> jax.Array:
        """Nothing else is given."""
        raise AssertionError

    def run(self, image: Any) -> Any:
        """Do it by the kernel, or by its matrix transposed."""
        made = linear_of(self.key)
        if not self.is_adjoint:
            return made.run(image)
        found = made.matrix.adjoint(image.reshape(-1, image.shape[-1]))
        return found.reshape(*made.source, -1)

    def traced(self, image: jax.Array) -> jax.Array:
        """Add up by the sparse matrix."""
        made = linear_of(self.key)
        weights = made.matrix.weights.T if self.is_adjoint else made.matrix.weights
        held = weights.tocoo()
        terms = flat(image)[held.col] * jnp.asarray(held.data, image.dtype)[:, None]
        found = jax.ops.segment_sum(terms, jnp.asarray(held.row), held.shape[0])
        if made.fill != 0.0 and not self.is_adjoint:
            found = jnp.where(made.empty[:, None], made.fill, found)
        return found.reshape(*self.shape(), -1)


# Lookups ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Seen:
    """Lookups by the kernels, in images of one map and shape."""

    spec: str
    image: tuple[int, ...]
    filter: str
    fill: float
    is_adjoint: bool = False

    @property
    def adjoint(self) -> Seen:
        """The transposed one."""
        return Seen(self.spec, self.image, self.filter, 0.0, not self.is_adjoint)

    @property
    def plain(self) -> Seen:
        """The same, of black images black."""
        return Seen(self.spec, self.image, self.filter, 0.0, self.is_adjoint)

    def shape(self, directions: Any) -> tuple[int, ...]:
        """Return the shape of the result without channels."""
        return self.image if self.is_adjoint else tuple(directions.shape[:-1])

    def tangent(self, image: jax.Array, directions: jax.Array, along: jax.Array) -> jax.Array:
        """Return how lookups change: by the slopes between texels."""
        if self.filter != "bilinear" or self.is_adjoint:
            raise NotImplementedError(
                "`sample` has a derivative by directions where it is bilinear, and no second one."
            )
        slopes = _sums.apply(Slopes(self.spec, self.image), image, directions)
        of_uv = jax.jvp(lambda d: _verbs.encode(d, self.spec), (directions,), (along,))[1]
        by_u, by_v = (of_uv[..., k : k + 1].astype(image.dtype) for k in range(2))
        return slopes[0] * by_u + slopes[1] * by_v

    def run(self, image: Any, directions: Any) -> Any:
        """Look up, or give back to the texels."""
        if not self.is_adjoint:
            options: dict[str, Any] = {"filter": self.filter, "fill": self.fill}
            return resample.sample(image, directions, map_of(self.spec), any_aspect=True, **options)
        made = lookups(self.spec, self.image)
        columns = image.reshape(-1, image.shape[-1])
        found = made.adjoint(columns, directions.reshape(-1, 3), self.filter)
        return found.reshape(*self.image, -1)

    def traced(self, image: jax.Array, directions: jax.Array) -> jax.Array:
        """Ask the kernels from the device."""
        return _sums.called(self, image, directions)


@dataclass(frozen=True)
class Slopes:
    """The derivatives of bilinear lookups by u and v, two for each direction."""

    spec: str
    image: tuple[int, ...]

    @property
    def adjoint(self) -> Slopes:
        """There is none: second derivatives are an error."""
        raise NotImplementedError("`sample` has no second derivative by directions.")

    @property
    def plain(self) -> Slopes:
        """The same."""
        return self

    def shape(self, directions: Any) -> tuple[int, ...]:
        """Return the shape of the result without channels."""
        return (2, *directions.shape[:-1])

    def tangent(self, image: jax.Array, *given: Any) -> jax.Array:
        """There is none."""
        raise NotImplementedError("`sample` has no second derivative by directions.")

    def run(self, image: Any, directions: Any) -> Any:
        """Return slopes of lookups by the kernels."""
        made = lookups(self.spec, self.image)
        columns = image.reshape(-1, image.shape[-1])
        found = made.slopes(columns, directions.reshape(-1, 3))
        return found.reshape(*self.shape(directions), -1)

    def traced(self, image: jax.Array, directions: jax.Array) -> jax.Array:
        """Ask the kernels from the device."""
        return _sums.called(self, image, directions)


def sample(
    image: jax.Array, directions: jax.Array, spec: str, filter: str, fill: float
) -> jax.Array:
    """Return values (..., channels) of an image in directions."""
    shape = tuple(image.shape[:-1])
    made = lookups(spec, shape)
    if filter == "bilinear" and made.is_whole:
        lead = directions.shape[:-1]
        looked = directions.reshape(math.prod(lead), 3)
        return _gathered(made, flat(image), looked, fill).reshape(*lead, image.shape[-1])
    rule = Seen(spec, shape, filter, fill)
    if filter != "bilinear":
        # What is wrong with a name is said now, and not by a running program.
        rule.run(*_nothing(shape))
    return _sums.apply(rule, image, directions)


def _nothing(shape: tuple[int, ...]) -> tuple[Any, Any]:
    return np.zeros((*shape, 1), np.float32), np.zeros((0, 3), np.float32)


def _gathered(made: Lookups, image: jax.Array, directions: jax.Array, fill: float) -> jax.Array:
    uv = _verbs.encode(directions, made.spec)
    covered = ~jnp.isnan(uv[:, :1])
    # A place that is NaN would spoil the gradient of what is looked up there and left out.
    column, row, x, y = between(jnp, jnp.where(covered, uv, 0.0), made.places, made.shape)
    own, mixed = made.padded
    first = number(made.shape, column.astype(int), row.astype(int))
    index = jnp.asarray(own)[first + jnp.asarray(steps(made.shape))[:, None]]
    whole = image
    if mixed is not None:
        rows, columns, weight = mixed
        terms = image[columns] * jnp.asarray(weight, image.dtype)[:, None]
        border = jax.ops.segment_sum(terms, jnp.asarray(rows), int(rows.max()) + 1)
        whole = jnp.concatenate([image, border])
    weights = shares(jnp, x, y).astype(image.dtype)
    found = jnp.sum(weights[..., None] * whole[index], axis=0)
    return jnp.where(covered, found, fill)
