"""Maps as text: operators of torch take tensors and plain values, which graphs and workers keep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import index
from typing import Any

import numpy as np
import torch

from .._threads import on_all_threads
from ..map import spec
from ..map.spec import HELD, map_of
from ._operators import is_moving, product

__all__ = [
    "HELD",
    "as_fixed",
    "map_of",
    "on_blocks",
    "one_rotation",
    "spec_of",
    "split_rotation",
    "turned_back",
    "whole",
]

# What is computed on a block stays in a core's cache.
_BLOCK = 1 << 15


spec_of = torch.compiler.assume_constant_result(spec.spec_of)


def split_rotation(rotation: Any | None) -> tuple[torch.Tensor | None, Any | None]:
    """Return a rotation that gradients may flow to, or one that the map is turned by."""
    if rotation is None or not isinstance(rotation, torch.Tensor):
        return None, None if rotation is None else _as_array(rotation)
    if rotation.shape[-2:] != (3, 3):
        raise ValueError(f"Expected `rotation` to be (..., 3, 3), got {tuple(rotation.shape)}.")
    return rotation, None


def turned_back(directions: torch.Tensor, rotation: torch.Tensor) -> torch.Tensor:
    """Return Rᵀ d, where directions were before a rotation took what is at d to R d."""
    return product(directions.unsqueeze(-2), rotation.to(directions.dtype)).squeeze(-2)


def one_rotation(rotation: torch.Tensor) -> torch.Tensor:
    """Return a rotation that there may be one of."""
    if rotation.ndim != 2:
        raise ValueError(f"Expected `rotation` to have shape (3, 3), got {tuple(rotation.shape)}.")
    return rotation


def as_fixed(rotation: torch.Tensor) -> Any | None:
    """Return a rotation as an array that a map is turned by; None where it is multiplied.

    It is where what is made of it must follow it, and where it is one to rounding alone: a tensor
    is taken as it is, with a gradient and without.
    """
    if is_moving(rotation):
        return None
    array = rotation.detach().double().cpu().numpy()
    try:
        spec.spec_of("latlong", rotation=array)
    except ValueError:
        return None
    return array


def _as_array(rotation: Any) -> Any:
    return rotation if hasattr(rotation, "as_matrix") else np.asarray(rotation)


def whole(shape: Sequence[int]) -> tuple[int, ...]:
    """Return a shape as numbers: the compiler holds one that has changed as a symbol."""
    return tuple(index(n) for n in shape)


def on_blocks(work: Callable[[slice], None], count: int) -> None:
    """Do the work on blocks of so many rows, by all threads."""

    def alone(block: slice) -> None:
        # Another thread knows nothing of being within an operator, where nothing is recorded.
        with torch.no_grad():
            work(block)

    on_all_threads(alone, [slice(k, k + _BLOCK) for k in range(0, count, _BLOCK)])
