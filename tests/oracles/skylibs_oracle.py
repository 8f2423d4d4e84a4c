"""skylibs' six maps: directions to image coordinates and back."""

from __future__ import annotations

from importlib.metadata import version as installed
from typing import Any

import numpy as np

from . import need


def version() -> str:
    need("envmap")
    return f"skylibs {installed('skylibs')}"


def environment(kind: str) -> Any:
    """Give an empty environment of 16 rows; its coordinates do not depend on the size."""
    envmap: Any = need("envmap")
    return envmap.EnvironmentMap(16, kind)


def world2image(kind: str, d: np.ndarray) -> np.ndarray:
    """Image coordinates of directions (N, 3)."""
    with np.errstate(all="ignore"):
        u, v = environment(kind).world2image(*d.T)
    return np.stack([u, v], -1)


def image2world(kind: str, uv: np.ndarray) -> np.ndarray:
    """Directions at image coordinates (N, 2), NaN where it says that there are none."""
    with np.errstate(all="ignore"):
        x, y, z, valid = environment(kind).image2world(*uv.T)
    d = np.stack([x, y, z], -1)
    d[~np.asarray(valid, bool)] = np.nan
    return d
