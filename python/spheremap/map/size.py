"""How large an image must be to hold as much as another."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .._projection import Projection


def matching_size(image_shape: tuple[int, ...], src: Projection, dst: Projection) -> int:
    """Return the size at which `dst` has about as many texels a steradian as an image of `src`."""
    spatial = image_shape[: 2 if src.faces == 1 else 3]
    held = math.prod(src.shape(spatial)) * used_part(src) / src.covered_solid_angle
    unit = math.prod(dst.shape(_PROBE)) / _PROBE**2
    wanted = held * dst.covered_solid_angle / (unit * used_part(dst))
    return max(1, round(math.sqrt(wanted)))


_PROBE = 256


@lru_cache(maxsize=256)
def used_part(p: Projection) -> float:
    """Return which part of an image holds sphere: 1, π/4 for a disk, 1/2 for a cross."""
    return float(np.isfinite(p.directions(_PROBE, dtype=np.float32)[..., 0]).mean())
