"""py360convert: panorama to cube faces, and its own coordinates."""

from __future__ import annotations

from importlib.metadata import version as installed
from typing import Any
from unittest.mock import patch

import numpy as np

from . import need


def version() -> str:
    need("py360convert")
    return f"py360convert {installed('py360convert')}"


def coordinates(d: np.ndarray, height: int, width: int) -> np.ndarray:
    """Texel indices (column, row) of directions (N, 3) in its panorama."""
    need("py360convert")
    from py360convert import utils

    u, v = utils.xyz2uv(d)
    return np.concatenate(utils.uv2coor(u, v, height, width), axis=-1)


def equirect_to_cube(image: np.ndarray, size: int, layout: str) -> Any:
    """Turn a float64 (H, W) panorama into faces: horizon and dice as arrays, list as a stack."""
    py360convert: Any = need("py360convert")
    # Where OpenCV is installed it interpolates with that, in steps of 1/32 of a texel.
    with patch.object(py360convert.utils, "cv2", None):
        out = py360convert.e2c(image, face_w=size, mode="bilinear", cube_format=layout)
    return np.stack(out) if layout == "list" else out
