"""Generators of directions that break textbook formulas."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np

Array = np.ndarray

# The centers of faces, the middles of edges and the corners of a cube: every pole, blind spot,
# fold line end, face corner and tie of every projection under every axes lies at one of these.
SPECIAL = np.array([d for d in product((-1.0, 0.0, 1.0), repeat=3) if any(d)])
DISTANCES = 10.0 ** -np.arange(1, 31)


def signed_zeros(dtype: type) -> Array:
    """Every combination of +0, -0, +1 and -1 that is not all zero: 56 of them."""
    d = np.array(list(product((0.0, -0.0, 1.0, -1.0), repeat=3)), dtype)
    return d[np.any(d != 0, axis=-1)]


def near_special_points(dtype: type, azimuths: int = 8) -> Array:
    """Around each special point at distances 1e-1 ... 1e-30, in several directions."""
    out = []
    angles = np.arange(azimuths) * (2 * np.pi / azimuths) + 0.1
    for s in SPECIAL:
        axis = np.eye(3)[np.argmin(np.abs(s))]
        a = np.cross(s, axis)
        a /= np.linalg.norm(a)
        b = np.cross(s, a)
        b /= np.linalg.norm(b)
        around = np.cos(angles)[:, None] * a + np.sin(angles)[:, None] * b
        out.append((s + DISTANCES[:, None, None] * around).reshape(-1, 3))
        # Along single components, exactly: these stay on seams and fold lines.
        steps = np.concatenate([np.eye(3), -np.eye(3)])
        out.append((s + DISTANCES[:, None, None] * steps).reshape(-1, 3))
    return np.concatenate(out).astype(dtype)


def near_planes(dtype: type, per_plane: int = 12, seed: int = 5) -> Array:
    """Near the planes x = 0, |x| = |y| and |x| = |y| + |z| (seams, ties, creases, the fold)."""
    rng = np.random.default_rng(seed)
    normals = [np.eye(3)[i] for i in range(3)]
    normals += [np.array(n, float) for n in product((-1, 0, 1), repeat=3) if np.abs(n).sum() > 1]
    out = []
    for n in normals:
        n = n / np.linalg.norm(n)
        d = rng.normal(size=(per_plane, 3))
        d -= (d @ n)[:, None] * n
        d /= np.linalg.norm(d, axis=-1, keepdims=True)
        for sign in (1, -1):
            out.append((d[:, None] + sign * DISTANCES[None, :, None] * n).reshape(-1, 3))
        out.append(d)
    return np.concatenate(out).astype(dtype)


def neighbors_of_ties(dtype: type) -> Array:
    """One, two and three ulp off every tie of components, in each combination."""
    one = dtype(1)
    values = [one]
    for way in (0, 2):
        x = one
        for _ in range(3):
            x = np.nextafter(x, dtype(way))
            values.append(x)
    magnitudes = np.array(list(product(values, repeat=3)), dtype)
    signs = np.array(list(product((1, -1), repeat=3)), dtype)
    return (magnitudes[:, None] * signs).reshape(-1, 3).astype(dtype)


def mixed_magnitudes(dtype: type, n: int = 3000, seed: int = 7) -> Array:
    """Components of wildly different size, signs at random."""
    rng = np.random.default_rng(seed)
    low, high = (-37, 37) if dtype == np.float32 else (-300, 300)
    d = 10.0 ** rng.uniform(low, high, (n, 3)) * rng.choice([-1, 1], (n, 3))
    near = 10.0 ** rng.uniform(-10, 0, (n, 3)) * rng.choice([-1, 1], (n, 3))
    return np.concatenate([d, near]).astype(dtype)


def extreme_lengths(dtype: type) -> Array:
    """Plain directions at lengths from the smallest subnormal to the largest number."""
    info = np.finfo(dtype)
    rng = np.random.default_rng(11)
    d = np.concatenate([SPECIAL, rng.normal(size=(40, 3))]).astype(dtype)
    d = d / np.max(np.abs(d), axis=-1, keepdims=True)
    lengths = [
        info.smallest_subnormal,
        info.tiny,
        info.tiny * 4,
        1e-30,
        1e-20,
        1e20,
        1e30,
        info.max,
    ]
    if dtype == np.float64:
        lengths += [1e-300, 1e-160, 1e-150, 1e150, 1e160, 1e300]
    else:
        lengths += [info.smallest_subnormal * 1000]
    out = np.concatenate([d * dtype(length) for length in lengths])
    return out[np.any(out != 0, axis=-1)]


def subnormal(dtype: type) -> Array:
    """Small integers times the smallest subnormal: exact, and a power of two from a plain one."""
    values = (-3, -2, -1, 0, 1, 2, 3)
    d = np.array([x for x in product(values, repeat=3) if any(x)], dtype)
    return d * np.finfo(dtype).smallest_subnormal


def uniform(dtype: type, n: int = 4000, seed: int = 13) -> Array:
    return np.random.default_rng(seed).normal(size=(n, 3)).astype(dtype)


@cache
def hard(dtype: type) -> Array:
    """All of them, to be read alone; none is zero, NaN or infinite."""
    d = np.concatenate(
        [
            signed_zeros(dtype),
            near_special_points(dtype),
            near_planes(dtype),
            neighbors_of_ties(dtype),
            mixed_magnitudes(dtype),
            extreme_lengths(dtype),
            subnormal(dtype),
            uniform(dtype),
        ]
    )
    assert d.dtype == dtype and np.all(np.isfinite(d)) and np.all(np.any(d != 0, axis=-1))
    d.flags.writeable = False
    return d


@cache
def bad(dtype: type) -> Array:
    """Zero in every sign, and every vector with a NaN or an infinity in it."""
    values = np.array([0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf], dtype)
    d = np.array(list(product(values, repeat=3)), dtype)
    d = d[~np.all(np.isfinite(d), axis=-1) | np.all(d == 0, axis=-1)]
    d.flags.writeable = False
    return d
