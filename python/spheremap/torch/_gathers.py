"""Lookups by gathers, where there are no kernels: operations of torch, with all derivatives.

Here an image has its channels first and its texels flat, (channels, texels): nothing is copied
before a gather, and the compiler fuses what stands around it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import torch

from ..map.compiled import compiled
from ..resample.linear import MATRICES, linear_of
from ..resample.lookups import between, lookups, number, shares, steps
from ._printed import call, unit_vectors
from ._specs import HELD
from ._verbs import encode

if TYPE_CHECKING:
    from torch import Tensor

    from ..resample.lookups import Scales

    # Factors and offsets to texels, which texel each of the padded image is, and of those that are
    # none how many there are, and rows, columns and weights.
    Table = tuple[Scales, Tensor, int, tuple[Tensor, ...]]
    # Texels and weights (few, n), and which results see none.
    Gathers = tuple[Tensor, Tensor, Tensor | None]


def in_rectangle(
    image: Tensor,
    directions: Tensor,
    spec: str,
    shape: tuple[int, ...],
    table: Table,
    fill: float,
) -> Tensor:
    """Return bilinear lookups (channels, ...) in directions (..., 3), in a whole rectangle."""
    places, own, mixes, border = table
    uv = encode(directions.reshape(-1, 3), spec)
    covered = ~uv[:, 0].isnan()
    # A place that is NaN would spoil the gradient of what is looked up there and left out.
    known = torch.where(covered[:, None], uv, 0.0)
    column, row, x, y = between(torch, known, places, shape)
    first = number(shape, column.long(), row.long())
    index = torch.stack([own.index_select(0, first + step) for step in steps(shape)])
    whole = image
    if mixes:
        rows, columns, weights = border
        terms = image.index_select(1, columns) * weights.to(image.dtype)
        beyond = image.new_zeros((len(image), mixes)).index_add(1, rows, terms)
        whole = torch.cat([image, beyond], dim=1)
    found = mixed(whole, index, shares(torch, x, y))
    return torch.where(covered, found, fill).unflatten(1, directions.shape[:-1])


def by_taps(
    image: Tensor, directions: Tensor, spec: str, shape: tuple[int, ...], fill: float
) -> Tensor:
    """Return bilinear lookups (channels, ...) in directions (..., 3), by printed `taps`."""
    unit = unit_vectors(directions.reshape(-1, 3))
    covered = unit.isfinite().all(-1)
    ahead = torch.eye(3, dtype=unit.dtype, device=unit.device)[0]
    height, width = shape[-2:]
    size = torch.tensor([width, height], dtype=unit.dtype, device=unit.device)
    looked = torch.where(covered[:, None], unit, ahead)
    *places, weights = call("taps", spec, looked, size)
    column, row, *face = (place.detach().long() for place in places)
    index = (face[0] * height + row if face else row) * width + column
    found = mixed(image, index.movedim(-1, 0), weights.movedim(-1, 0))
    return torch.where(covered, found, fill).unflatten(1, directions.shape[:-1])


def mixed(image: Tensor, index: Tensor, weights: Tensor) -> Tensor:
    """Return sums of texels (channels, n), from their numbers and weights (few, n)."""
    pairs = zip(index.unbind(0), weights.to(image.dtype).unbind(0), strict=True)
    found, *rest = (image.index_select(1, texel) * weight for texel, weight in pairs)
    for term in rest:
        found = found + term
    return found


def gathered(image: Tensor, gathers: Gathers, fill: float) -> Tensor:
    """Return sums of texels (channels, n), and `fill` where there is nothing to add."""
    index, weights, empty = gathers
    found = mixed(image, index, weights)
    return found if empty is None else torch.where(empty, fill, found)


@lru_cache(HELD)
def _table(spec: str, shape: tuple[int, ...], device: str) -> Table:
    made = lookups(spec, shape)
    own, border = made.padded
    held = tuple(torch.from_numpy(part).to(device) for part in (own, *(border or ())))
    return made.places, held[0], made.mixes, held[1:]


@lru_cache(MATRICES)
def _gathers(key: str, device: str) -> Gathers | None:
    made = linear_of(key)
    if made.gathers is None:
        return None
    index, weights = (torch.from_numpy(part).to(device) for part in made.gathers)
    empty = torch.from_numpy(made.empty).to(device) if made.fill != 0.0 else None
    return index, weights, empty


# torch's compiler takes what these return as constants. It would look into a cache itself.


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def table(spec: str, shape: tuple[int, ...], device: str) -> Table:
    """Return what lookups in a whole rectangle need."""
    return _table(spec, shape, device)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def gathers_of(key: str, device: str) -> Gathers | None:
    """Return what a key adds up, or None where that is no few texels."""
    return _gathers(key, device)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def rule(spec: str, shape: tuple[int, ...]) -> str | None:
    """Return how bilinear lookups in an image are gathers, or None where they are not."""
    if lookups(spec, shape).is_whole:
        return "rectangle"
    try:
        compiled(spec, "torch", False, ("taps",))
    except ValueError:
        return None
    return "taps"
