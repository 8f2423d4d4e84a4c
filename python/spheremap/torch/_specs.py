"""Maps as text: operators of torch take tensors and plain values, which graphs and workers keep."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import _core
from .._threads import on_all_threads
from ..map.named import resolve

if TYPE_CHECKING:
    from .._projection import Projection
    from ..map.named import ProjectionLike

# What is computed on a block stays in a core's cache.
_BLOCK = 1 << 15

# So many maps, or operators on images of a shape, are held at a time.
HELD = 128


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def spec_of(
    projection: ProjectionLike, axes: str | None = None, rotation: Any | None = None
) -> str:
    """Return the text that stands for a map; a name stands for itself."""
    p = resolve(projection, axes, rotation)
    if isinstance(projection, str) and axes is None and rotation is None:
        return projection
    _, (_, name, options) = p.__reduce__()
    return json.dumps([name, options])


@lru_cache(HELD)
def map_of(spec: str) -> Projection:
    """Return the map that a text stands for."""
    if not spec.startswith("["):
        return resolve(spec)
    name, options = json.loads(spec)
    made: Projection = _core._rebuild(type(resolve("latlong")), name, options)
    return made


def split_rotation(rotation: Any | None) -> tuple[torch.Tensor | None, Any | None]:
    """Return a rotation that gradients may flow to, or one that the map is turned by."""
    if rotation is None or not isinstance(rotation, torch.Tensor):
        return None, None if rotation is None else _as_array(rotation)
    if rotation.shape[-2:] != (3, 3):
        raise ValueError(f"Expected `rotation` to be (..., 3, 3), got {tuple(rotation.shape)}.")
    return rotation, None


def turned_back(directions: torch.Tensor, rotation: torch.Tensor) -> torch.Tensor:
    """Return Rᵀ d, where directions were before a rotation took what is at d to R d."""
    return (directions.unsqueeze(-2) @ rotation.to(directions.dtype)).squeeze(-2)


def _as_array(rotation: Any) -> Any:
    return rotation if hasattr(rotation, "as_matrix") else np.asarray(rotation)


def on_blocks(work: Callable[[slice], None], count: int) -> None:
    """Do the work on blocks of so many rows, by all threads."""

    def alone(block: slice) -> None:
        # Another thread knows nothing of being within an operator, where nothing is recorded.
        with torch.no_grad():
            work(block)

    on_all_threads(alone, [slice(k, k + _BLOCK) for k in range(0, count, _BLOCK)])
