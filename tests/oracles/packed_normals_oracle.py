"""Octahedral normals of mesh compressors: meshoptimizer's filter and Draco's quantization."""

from __future__ import annotations

from importlib.metadata import version as installed
from typing import Any

import numpy as np

from . import need


def versions() -> tuple[str, str]:
    need("meshoptimizer")
    need("DracoPy")
    return (f"meshoptimizer {installed('meshoptimizer')}", f"DracoPy {installed('DracoPy')}")


def meshopt_decode(p: np.ndarray, bits: int) -> np.ndarray:
    """Unit vectors at integers (N, 2) of so many bits, as its filter stores them in 16."""
    meshoptimizer: Any = need("meshoptimizer")
    one = 2 ** (bits - 1) - 1
    stored = np.zeros((len(p), 4), np.int16)
    stored[:, :2], stored[:, 2] = p, one
    out = meshoptimizer.decode_filter_oct(stored, len(p), 8)
    return np.asarray(out[:, :3], np.float64) / 32767


def draco_round_trip(normals: np.ndarray, bits: int) -> np.ndarray:
    """Normals (3 N, 3) after one encoding and decoding, as the corners of triangles."""
    dracopy: Any = need("DracoPy")
    points = np.arange(3 * len(normals), dtype=np.float32).reshape(-1, 3)
    data = dracopy.encode(
        points,
        np.arange(len(normals), dtype=np.uint32).reshape(-1, 3),
        normals=normals.astype(np.float64),
        normal_quantization_bits=bits,
        preserve_order=True,
        quantization_bits=20,
    )
    return np.asarray(dracopy.decode(data).normals, np.float64).reshape(-1, 3)
