"""Numbers that every processor is given."""

from __future__ import annotations

import hard_directions
import numpy as np

Arrays = dict[str, np.ndarray]


def make(stride: int = 6) -> Arrays:
    """Make the inputs; each `stride`-th of the hard directions is taken."""
    rng = np.random.default_rng(271)
    out: Arrays = {"words": rng.integers(0, 1 << 32, 1 << 16, dtype=np.uint32)}
    for dtype in (np.float32, np.float64):
        name = np.dtype(dtype).name
        out[f"directions {name}"] = np.concatenate(
            [
                hard_directions.hard(dtype)[::stride],
                hard_directions.bad(dtype),
                hard_directions.uniform(dtype, 1000),
            ]
        )
        out[f"uv {name}"] = hard_uv(dtype, rng)
    unit = rng.normal(size=(300, 3))
    out["unit"] = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
    # Orthogonal to rounding, and no entry is 0.
    a, b = np.cos(0.7), np.sin(0.7)
    c, d = np.cos(1.9), np.sin(1.9)
    out["turn"] = np.array([[a, b * c, b * d], [0, d, -c], [-b, a * c, a * d]])
    # From four texels a pixel to a sixteenth of one.
    spread = 2.0 ** rng.uniform(-12, 0, (2, 300, 1))
    out["derivatives"] = rng.normal(size=(2, 300, 3)) * spread
    out["lod"] = rng.uniform(-1, 4, 300)
    out["xi"] = rng.random((300, 2))
    out["angles"] = rng.uniform(-400, 400, (40, 3))
    return out


def hard_uv(dtype: type, rng: np.random.Generator) -> np.ndarray:
    """Corners, edges, middles, their neighbors, what lies outside, and a thousand others."""
    one, half = dtype(1), dtype(0.5)
    values = [0.0, -0.0, np.finfo(dtype).tiny, 0.25, half, one, 2, -1, np.nan, np.inf]
    values += [np.nextafter(x, way) for x in (half, one, dtype(0)) for way in (dtype(-9), dtype(9))]
    values += [dtype(k / 6) for k in range(1, 6)]
    u, v = np.meshgrid(np.array(values, dtype), np.array(values, dtype))
    grid = np.stack([u, v], -1).reshape(-1, 2)
    return np.concatenate([grid, rng.random((1000, 2)).astype(dtype)])


def image(words: np.ndarray, shape: tuple[int, ...], dtype: str) -> np.ndarray:
    """Return an image of numbers that are exact in its type, many orders of magnitude in floats."""
    found = np.resize(words, shape)
    if dtype[0] == "u":
        return (found >> 7).astype(dtype)
    # Eleven digits and one of sixteen binades: exact in half precision.
    return np.ldexp((found >> 21).astype(np.float64), (found & 15).astype(np.int32) - 14).astype(
        dtype
    )
