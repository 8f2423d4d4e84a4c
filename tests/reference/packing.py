"""Packing schemes in plain float64 NumPy, written from the papers and from other programs' sources.

Nothing of the library is imported here. Codes are arrays of their fields, (..., k) int64.
"""

from __future__ import annotations

import itertools

import numpy as np

GRIDS = ("snorm", "unorm", "centers")


def unit(d: np.ndarray) -> np.ndarray:
    d = np.asarray(d, np.float64)
    # Two steps: the squares of tiny and huge components are none.
    d = d / np.abs(d).max(axis=-1, keepdims=True)
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle between unit vectors, exact for small ones too."""
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


def sign_not_zero(x: np.ndarray) -> np.ndarray:
    return np.where(x < 0, -1.0, 1.0)


# --- Cigolle et al. 2014


def oct_place(d: np.ndarray) -> np.ndarray:
    """Place on the octahedral square, (..., 2) in [-1, 1]."""
    d = np.asarray(d, np.float64)
    d = d / np.abs(d).sum(-1, keepdims=True)
    p = d[..., :2]
    folded = (1 - np.abs(p[..., ::-1])) * sign_not_zero(p)
    return np.where(d[..., 2:] < 0, folded, p)


def oct_direction(p: np.ndarray) -> np.ndarray:
    z = 1 - np.abs(p).sum(-1, keepdims=True)
    xy = np.where(z < 0, (1 - np.abs(p[..., ::-1])) * sign_not_zero(p), p)
    return unit(np.concatenate([xy, z], -1))


def hemioct_place(d: np.ndarray) -> np.ndarray:
    p = d[..., :2] / np.abs(d).sum(-1, keepdims=True)
    return np.stack([p[..., 0] + p[..., 1], p[..., 0] - p[..., 1]], -1)


def hemioct_direction(p: np.ndarray) -> np.ndarray:
    x, y = (p[..., 0] + p[..., 1]) / 2, (p[..., 0] - p[..., 1]) / 2
    return unit(np.stack([x, y, 1 - np.abs(x) - np.abs(y)], -1))


# --- our warped octahedron: f(t) = t (1 + k (1 - t)) of the barycentrics


WARP = 11 / 16


def woct_direction(p: np.ndarray) -> np.ndarray:
    z = 1 - np.abs(p).sum(-1, keepdims=True)
    xy = np.where(z < 0, (1 - np.abs(p[..., ::-1])) * sign_not_zero(p), p)
    b = np.concatenate([xy, z], -1)
    return unit(b * (1 + WARP * (1 - np.abs(b))))


def woct_place(d: np.ndarray) -> np.ndarray:
    """By bisection for the factor λ with Σ f⁻¹(λ|d|) = 1; no Newton steps as in the library."""
    a = np.abs(np.asarray(d, np.float64))
    a = a / a.sum(-1, keepdims=True)

    def inverse(w: np.ndarray) -> np.ndarray:
        # The smaller root of k t² - (1 + k) t + w.
        root = np.sqrt(np.maximum((1 + WARP) ** 2 - 4 * WARP * w, 0))
        return 2 * w / (1 + WARP + root)

    low, high = np.ones(a.shape[:-1]), np.full(a.shape[:-1], 1.5)
    high = np.minimum(high, 1 / a.max(-1))
    low = np.minimum(low, high)
    for _ in range(60):
        middle = (low + high) / 2
        above = inverse(middle[..., None] * a).sum(-1) > 1
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    b = inverse(((low + high) / 2)[..., None] * a)
    signed = np.where(np.asarray(d) < 0, -b, b)
    return oct_place(signed)


# --- Clarberg 2008, as pbrt-v4 has it


def equal_area_direction(p: np.ndarray) -> np.ndarray:
    u, v = np.abs(p[..., 0]), np.abs(p[..., 1])
    signed = 1 - (u + v)
    r = 1 - np.abs(signed)
    phi = np.where(r == 0, 1, (v - u) / np.where(r == 0, 1, r) + 1) * np.pi / 4
    z = np.copysign(1 - r * r, signed)
    h = r * np.sqrt(2 - r * r)
    x = np.copysign(np.cos(phi), p[..., 0]) * h
    y = np.copysign(np.sin(phi), p[..., 1]) * h
    return np.stack([x, y, z], -1)


def equal_area_place(d: np.ndarray) -> np.ndarray:
    d = unit(d)
    x, y, z = np.abs(d[..., 0]), np.abs(d[..., 1]), np.abs(d[..., 2])
    r = np.hypot(x, y) / np.sqrt(1 + z)
    phi = np.arctan2(y, x) * 2 / np.pi
    v = phi * r
    u = r - v
    below = d[..., 2] < 0
    u, v = np.where(below, 1 - v, u), np.where(below, 1 - u, v)
    return np.stack([u, v], -1) * sign_not_zero(d[..., :2])


MAPS = {
    "oct": (oct_place, oct_direction),
    "hemioct": (hemioct_place, hemioct_direction),
    "woct": (woct_place, woct_direction),
    "equal_area": (equal_area_place, equal_area_direction),
}


# --- grids


def steps(grid: str, bits: int) -> tuple[float, float, float]:
    """Give the scale s and shift t of field = s p + t, and the largest field; p in [-1, 1]."""
    if grid == "snorm":
        return 2.0 ** (bits - 1) - 1, 0.0, 2.0 ** (bits - 1) - 1
    if grid == "unorm":
        n = 2.0**bits - 1
        return n / 2, n / 2, n
    n = 2.0**bits
    return n / 2, n / 2 - 0.5, n - 1


def fields_to_place(fields: np.ndarray, grid: str, bits: int) -> np.ndarray:
    scale, shift, _ = steps(grid, bits)
    return np.maximum((fields - shift) / scale, -1)


def candidates(place: np.ndarray, grid: str, bits: int) -> np.ndarray:
    """Give the four corners of the cell around a place, as fields: (4, ..., 2)."""
    scale, shift, last = steps(grid, bits)
    first = -last if grid == "snorm" else 0
    low = np.floor(place * scale + shift)
    corners = [low + np.array(c) for c in itertools.product((0, 1), repeat=2)]
    return np.clip(np.stack(corners), first, last)


def best_error(d: np.ndarray, name: str, grid: str, bits: int) -> np.ndarray:
    """Angle to the best of the four corners, by brute force."""
    to_place, to_direction = MAPS[name]
    fields = candidates(to_place(d), grid, bits)
    q = to_direction(fields_to_place(fields, grid, bits))
    return angle(q, unit(d)).min(0)


def unpack_word(words: np.ndarray, bits: int, signed: bool) -> np.ndarray:
    """Give the two fields of words, the first in the lowest bits."""
    words = words.astype(np.uint64)
    mask = np.uint64((1 << bits) - 1)
    fields = np.stack([words & mask, (words >> np.uint64(bits)) & mask], -1).astype(np.int64)
    if signed:
        fields = np.where(fields >= 1 << (bits - 1), fields - (1 << bits), fields)
    return fields


# --- Keinert et al. 2015


def fibonacci_point(i: np.ndarray, n: int) -> np.ndarray:
    """Spherical Fibonacci points; i/Φ is taken modulo 1 in two halves, exact enough to i = 2³²."""
    golden = (np.sqrt(5) - 1) / 2
    high, low = np.divmod(np.asarray(i, np.float64), 2.0**16)
    turn = (high * ((golden * 2.0**16) % 1) + low * golden) % 1
    z = 1 - (2 * np.asarray(i, np.float64) + 1) / n
    h = np.sqrt(1 - z * z)
    return np.stack([np.cos(2 * np.pi * turn) * h, np.sin(2 * np.pi * turn) * h, z], -1)


# --- programs, read from their sources and written down literally


def pbrt_encode(d: np.ndarray) -> np.ndarray:
    """Give pbrt-v4's OctahedralVector: float, copysign, unorm16."""
    v = np.asarray(d, np.float32)
    v = v / ((np.abs(v[..., 0]) + np.abs(v[..., 1])) + np.abs(v[..., 2]))[..., None]
    one = np.float32(1)
    sign = np.copysign(one, v)
    folded = (one - np.abs(v[..., 1::-1])) * sign[..., :2]
    f = np.where(v[..., 2:] >= 0, v[..., :2], folded)
    x = np.clip((f + one) / np.float32(2), 0, 1) * np.float32(65535)
    return np.floor(x.astype(np.float64) + 0.5).astype(np.int64)


def pbrt_decode(fields: np.ndarray) -> np.ndarray:
    one, two = np.float32(1), np.float32(2)
    p = -one + two * (fields.astype(np.float32) / np.float32(65535))
    z = one - (np.abs(p[..., :1]) + np.abs(p[..., 1:]))
    folded = (one - np.abs(p[..., ::-1])) * np.copysign(one, p)
    v = np.concatenate([np.where(z < 0, folded, p), z], -1)
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    return v / np.sqrt((x * x + y * y) + z * z)[..., None]


def unreal_encode(d: np.ndarray, bits: int) -> np.ndarray:
    """Give Nanite's OctahedronEncode without its search: float, int(x scale + bias)."""
    v = np.asarray(d, np.float32)
    v = v / ((np.abs(v[..., 0]) + np.abs(v[..., 1])) + np.abs(v[..., 2]))[..., None]
    one = np.float32(1)
    other = np.abs(v[..., 1::-1])
    folded = np.where(v[..., :2] >= 0, one - other, other - one)
    f = np.where(v[..., 2:] < 0, folded, v[..., :2])
    largest = np.float32((1 << bits) - 1)
    half = np.float32(0.5)
    x = f * (half * largest) + (half * largest + half)
    return np.clip(x.astype(np.int64), 0, (1 << bits) - 1)


def cesium_encode(d: np.ndarray, bits: int) -> np.ndarray:
    """Give Cesium's octEncodeInRange: double, Math.round."""
    d = np.asarray(d, np.float64)
    p = d[..., :2] / ((np.abs(d[..., 0]) + np.abs(d[..., 1])) + np.abs(d[..., 2]))[..., None]
    folded = (1 - np.abs(p[..., ::-1])) * sign_not_zero(p)
    f = np.where(d[..., 2:] < 0, folded, p)
    return np.floor((np.clip(f, -1, 1) * 0.5 + 0.5) * ((1 << bits) - 1) + 0.5).astype(np.int64)


def cesium_decode(fields: np.ndarray, bits: int) -> np.ndarray:
    p = fields / ((1 << bits) - 1) * 2 - 1
    z = 1 - (np.abs(p[..., :1]) + np.abs(p[..., 1:]))
    folded = (1 - np.abs(p[..., ::-1])) * sign_not_zero(p)
    v = np.concatenate([np.where(z < 0, folded, p), z], -1)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def meshoptimizer_encode(d: np.ndarray, bits: int) -> np.ndarray:
    """Give meshopt_encodeFilterOct with w = 0: float, halves away from zero."""
    n = np.asarray(d, np.float32)
    one = np.float32(1)
    scale = one / ((np.abs(n[..., 0]) + np.abs(n[..., 1])) + np.abs(n[..., 2]))
    p = n[..., :2] * scale[..., None]
    folded = (one - np.abs(p[..., ::-1])) * np.where(p >= 0, one, -one)
    f = np.where(n[..., 2:] >= 0, p, folded)
    largest = np.float32((1 << (bits - 1)) - 1)
    half = np.where(f >= 0, np.float32(0.5), np.float32(-0.5))
    fields = np.trunc(np.clip(f, -1, 1) * largest + half).astype(np.int64)
    last = np.broadcast_to([int(largest), 0], (*fields.shape[:-1], 2))
    return np.concatenate([fields, last], -1)
