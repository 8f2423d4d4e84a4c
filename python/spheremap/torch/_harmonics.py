"""Spherical harmonics as operators: what is linear in an image, and the basis."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import _core, sh
from ..resample.linear import MATRICES
from ._images import by_channels, nothing
from ._operators import alike, define, has_kernel
from ._printed import forward_of_smooth, unit_vectors
from ._specs import HELD, map_of

if TYPE_CHECKING:
    from torch import Tensor

# What is printed, and so has derivatives by directions.
HIGHEST_PRINTED = 8


def order_of(coefficients: int) -> int:
    """Return the order that has so many coefficients."""
    order = math.isqrt(coefficients) - 1
    if coefficients == 0 or (order + 1) ** 2 != coefficients:
        raise ValueError(
            f"Expected (order + 1)² coefficients in the last axis, got {coefficients}."
        )
    return order


# Images: channels last ----------------------------------------------------------------------------


def _project(image: Tensor, spec: str, order: int, texels: str) -> Tensor:
    given = image.detach().cpu().numpy()
    kind: Any = texels
    found = sh.project(given, map_of(spec), order=order, texels=kind, any_aspect=True)
    return torch.from_numpy(found).to(image.device, image.dtype)


def _spread(gradient: Tensor, spec: str, shape: list[int], texels: str) -> Tensor:
    rows = np.ascontiguousarray(gradient.detach().cpu().numpy(), np.float64)
    finite = np.isfinite(rows)
    # Each coefficient flows back to all texels of its channel, and so does what is no number.
    found = _core.sh_project_adjoint(
        np.where(finite, rows, 0.0), map_of(spec), shape, texels == "points"
    ).reshape(*shape, rows.shape[-1])
    found[..., ~finite.all(axis=0)] = np.nan
    return torch.from_numpy(found).to(gradient.device, gradient.dtype)


spread: Callable[..., Tensor] = define(
    "sh_spread(Tensor gradient, str spec, SymInt[] shape, str texels) -> Tensor",
    kernel=nothing(_spread, lambda gradient, spec, shape, texels: tuple(shape)),
    fake=lambda g, spec, shape, texels: g.new_empty((*shape, g.shape[-1])),
    batched=by_channels("sh_spread"),
    reverse=lambda wanted, g, spec, shape, texels, result, again: (
        project(again, spec, order_of(g.shape[0]), texels),
    ),
    forward=lambda g, spec, shape, texels, result, tangent: spread(tangent, spec, shape, texels),
)
project: Callable[..., Tensor] = define(
    "sh_project(Tensor image, str spec, int order, str texels) -> Tensor",
    kernel=nothing(_project, lambda image, spec, order, texels: ((order + 1) ** 2,)),
    fake=lambda image, spec, order, texels: image.new_empty(((order + 1) ** 2, image.shape[-1])),
    batched=by_channels("sh_project"),
    reverse=lambda wanted, image, spec, order, texels, result, g: (
        spread(g, spec, list(image.shape[:-1]), texels),
    ),
    forward=lambda image, spec, order, texels, result, tangent: project(
        tangent, spec, order, texels
    ),
)


@lru_cache(MATRICES)
def _matrix(spec: str, shape: tuple[int, ...], order: int, texels: str, device: str) -> Tensor:
    rows = np.eye((order + 1) ** 2)
    found = _core.sh_project_adjoint(rows, map_of(spec), shape, texels == "points")
    return torch.from_numpy(found).to(device)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def matrix(spec: str, shape: tuple[int, ...], order: int, texels: str, device: str) -> Tensor:
    """Return what flat images are multiplied by where there are no kernels."""
    return _matrix(spec, shape, order, texels, device)


# The basis ----------------------------------------------------------------------------------------


@lru_cache(HELD)
def _compiled(order: int, double: bool) -> Any:
    names: dict[str, Any] = {}
    dtype = "float64" if double else "float32"
    exec(sh.code(np.eye((order + 1) ** 2), "torch", dtype=dtype), names)
    return names["sh_evaluate"]


def _printed(directions: Tensor, order: int) -> Tensor:
    if order > HIGHEST_PRINTED:
        raise NotImplementedError(
            f"Above order {HIGHEST_PRINTED} spherical harmonics have no derivative by directions."
        )
    found = _compiled(order, directions.dtype == torch.float64)(unit_vectors(directions))
    # One number is no vector.
    return found.reshape(*directions.shape[:-1], (order + 1) ** 2)


def _basis(directions: Tensor, order: int) -> Tensor:
    if not has_kernel(directions) and order <= HIGHEST_PRINTED:
        return _printed(directions, order)
    found = sh.evaluate(np.eye((order + 1) ** 2), directions.detach().cpu().numpy())
    return torch.from_numpy(found).to(directions.device, directions.dtype)


def _basis_batched(
    in_dims: tuple[int | None, ...], directions: Tensor, order: int
) -> tuple[Tensor, int]:
    axis = in_dims[0]
    assert axis is not None
    return basis(directions.movedim(axis, 0), order), 0


def _basis_reverse(
    wanted: Any, directions: Tensor, order: int, result: Tensor, gradient: Tensor
) -> tuple[Tensor]:
    _, pull = torch.func.vjp(lambda d: _printed(d, order), directions)
    (found,) = pull(gradient)
    return (torch.where((gradient == 0).all(-1, keepdim=True), 0.0, found),)


def _basis_forward(directions: Tensor, order: int, result: Tensor, tangent: Tensor) -> Tensor:
    return basis_tangent(directions, tangent, order)


def _basis_tangent(directions: Tensor, tangent: Tensor, order: int) -> Tensor:
    return forward_of_smooth(lambda d: _printed(d, order), directions, tangent)


def _tangent_batched(
    in_dims: tuple[int | None, ...], directions: Tensor, tangent: Tensor, order: int
) -> tuple[Tensor, int]:
    return basis_tangent(*alike(in_dims, directions, tangent), order), 0


basis_tangent = define(
    "sh_basis_tangent(Tensor directions, Tensor tangent, int order) -> Tensor",
    kernel=_basis_tangent,
    fake=lambda d, tangent, order: d.new_empty((*d.shape[:-1], (order + 1) ** 2)),
    batched=_tangent_batched,
    none="`sh.evaluate` has no derivative by directions of its forward one.",
)
basis = define(
    "sh_basis(Tensor directions, int order) -> Tensor",
    kernel=_basis,
    fake=lambda d, order: d.new_empty((*d.shape[:-1], (order + 1) ** 2)),
    batched=_basis_batched,
    written=_basis,
    reverse=_basis_reverse,
    forward=_basis_forward,
)
