"""Other ways to do the same work, written as their users would write them: numpy, numba, DrJit.

Each peer is a function from one float32 array to a new one, for the five maps of the speed table
and both ways, in the default axes. `map.py` checks every one against spheremap first.
"""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable

import numpy as np

Peer = Callable[[np.ndarray], np.ndarray]
MAPS = ("octahedral", "sphere", "cube", "angular", "latlong")
F = np.float32
PI = F(math.pi)
HALF_OVER_PI = F(0.5 / math.pi)
# In the order of the faces: the signed world axes (1-based) across the face, down it and into it.
CUBE = np.array([[-3, -2, 1], [3, -2, -1], [1, 3, 2], [1, -3, -2], [1, -2, 3], [-1, -2, -3]])


# --- numpy


def _numpy_octahedral_encode(d):
    p = d[..., :2] / np.abs(d).sum(axis=-1, keepdims=True)
    fold = (1 - np.abs(p[..., ::-1])) * np.where(p >= 0, F(1), F(-1))
    return np.where(d[..., 2:] < 0, fold, p) * F(0.5) + F(0.5)


def _numpy_octahedral_decode(uv):
    p = uv * 2 - 1
    z = 1 - np.abs(p).sum(axis=-1)
    t = np.maximum(-z, 0)[..., None]
    d = np.concatenate([p - np.where(p >= 0, t, -t), z[..., None]], axis=-1)
    return d / np.sqrt((d * d).sum(axis=-1, keepdims=True))


def _numpy_sphere_encode(r):
    x, y, z = r[..., 0], r[..., 1], r[..., 2]
    m = 2 * np.sqrt(x * x + y * y + (z + 1) ** 2)
    return np.stack([x / m + F(0.5), F(0.5) - y / m], axis=-1)


def _numpy_sphere_decode(uv):
    p, q = 2 * uv[..., 0] - 1, 2 * uv[..., 1] - 1
    c = np.maximum(1 - p * p - q * q, 0)
    s = 2 * np.sqrt(c)
    return np.stack([p * s, -q * s, 2 * c - 1], axis=-1)


def _numpy_cube_encode(d):
    a = np.abs(d)
    axis = np.argmax(a, axis=-1)
    face = 2 * axis + (np.take_along_axis(d, axis[..., None], -1)[..., 0] < 0)
    table = CUBE[face]
    across = np.take_along_axis(d, np.abs(table[..., :1]) - 1, -1)[..., 0] * np.sign(table[..., 0])
    down = np.take_along_axis(d, np.abs(table[..., 1:2]) - 1, -1)[..., 0] * np.sign(table[..., 1])
    m = a.max(axis=-1)
    return np.stack([across / m / 2 + 0.5, down / m / 2 + 0.5, face], axis=-1).astype(np.float32)


def _numpy_cube_decode(uv):
    p, q, face = 2 * uv[..., 0] - 1, 2 * uv[..., 1] - 1, uv[..., 2].astype(np.intp)
    table = CUBE[face]
    d = np.empty((*uv.shape[:-1], 3), np.float32)
    for column, value in enumerate((p, q, F(1))):
        which = np.abs(table[..., column : column + 1]) - 1
        np.put_along_axis(d, which, (value * np.sign(table[..., column]))[..., None], -1)
    return d / np.sqrt((d * d).sum(axis=-1, keepdims=True))


def _numpy_angular_encode(d):
    h = np.hypot(d[..., 0], d[..., 1])
    r = np.arctan2(h, -d[..., 2]) * HALF_OVER_PI / np.maximum(h, F(1e-30))
    return np.stack([d[..., 0] * r + F(0.5), F(0.5) - d[..., 1] * r], axis=-1)


def _numpy_angular_decode(uv):
    p, q = 2 * uv[..., 0] - 1, 2 * uv[..., 1] - 1
    r = np.hypot(p, q)
    s = np.sin(PI * r) / np.maximum(r, F(1e-30))
    return np.stack([p * s, -q * s, -np.cos(PI * r)], axis=-1)


def _numpy_latlong_encode(d):
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    u = np.arctan2(x, -z) * HALF_OVER_PI + F(0.5)
    v = np.arctan2(np.hypot(x, z), y) / PI
    return np.stack([u, v], axis=-1)


def _numpy_latlong_decode(uv):
    phi, theta = PI * (2 * uv[..., 0] - 1), PI * uv[..., 1]
    s = np.sin(theta)
    return np.stack([s * np.sin(phi), np.cos(theta), -s * np.cos(phi)], axis=-1)


def numpy_peers() -> dict[tuple[str, str], Peer]:
    """Return numpy one-liners by (map, way)."""
    return {(m, w): globals()[f"_numpy_{m}_{w}"] for m in MAPS for w in ("encode", "decode")}


# --- numba


def numba_peers(threads: int) -> dict[tuple[str, str], Peer]:
    """Return numba loops (parallel, fastmath off) by (map, way)."""
    import numba
    from numba import njit, prange

    numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
    half, one, two = F(0.5), F(1), F(2)
    zero, tiny = F(0), F(1e-30)

    @njit
    def octahedral_encode(x, y, z):
        s = abs(x) + abs(y) + abs(z)
        p, q = x / s, y / s
        if z < zero:
            sign_p = one if p >= zero else -one
            sign_q = one if q >= zero else -one
            p, q = (one - abs(q)) * sign_p, (one - abs(p)) * sign_q
        return p * half + half, q * half + half

    @njit
    def octahedral_decode(u, v):
        x, y = two * u - one, two * v - one
        z = one - abs(x) - abs(y)
        t = max(-z, zero)
        x -= t if x >= zero else -t
        y -= t if y >= zero else -t
        s = one / math.sqrt(x * x + y * y + z * z)
        return x * s, y * s, z * s

    @njit
    def sphere_encode(x, y, z):
        m = two * math.sqrt(x * x + y * y + (z + one) * (z + one))
        return x / m + half, half - y / m

    @njit
    def sphere_decode(u, v):
        p, q = two * u - one, two * v - one
        c = max(one - p * p - q * q, zero)
        s = two * math.sqrt(c)
        return p * s, -q * s, two * c - one

    @njit
    def cube_encode(x, y, z):
        ax, ay, az = abs(x), abs(y), abs(z)
        if ax >= ay and ax >= az:
            face, p, q, m = (zero, -z, -y, ax) if x >= zero else (one, z, -y, ax)
        elif ay >= az:
            face, p, q, m = (two, x, z, ay) if y >= zero else (F(3), x, -z, ay)
        else:
            face, p, q, m = (F(4), x, -y, az) if z >= zero else (F(5), -x, -y, az)
        return half * (p / m) + half, half * (q / m) + half, face

    @njit
    def cube_decode(u, v, face):
        p, q = two * u - one, two * v - one
        s = one / math.sqrt(one + p * p + q * q)
        if face == F(0):
            return s, -q * s, -p * s
        if face == F(1):
            return -s, -q * s, p * s
        if face == F(2):
            return p * s, s, q * s
        if face == F(3):
            return p * s, -s, -q * s
        if face == F(4):
            return p * s, -q * s, s
        return -p * s, -q * s, -s

    @njit
    def angular_encode(x, y, z):
        h = math.sqrt(x * x + y * y)
        r = math.atan2(h, -z) * HALF_OVER_PI / max(h, tiny)
        return x * r + half, half - y * r

    @njit
    def angular_decode(u, v):
        p, q = two * u - one, two * v - one
        r = math.sqrt(p * p + q * q)
        s = math.sin(PI * r) / max(r, tiny)
        return p * s, -q * s, -math.cos(PI * r)

    @njit
    def latlong_encode(x, y, z):
        u = math.atan2(x, -z) * HALF_OVER_PI + half
        return u, math.atan2(math.sqrt(x * x + z * z), y) / PI

    @njit
    def latlong_decode(u, v):
        phi, theta = PI * (two * u - one), PI * v
        s = math.sin(theta)
        return s * math.sin(phi), math.cos(theta), -s * math.cos(phi)

    def loop(formula, inputs, outputs):
        if inputs == 3 and outputs == 2:

            @njit(parallel=True)
            def run(a):
                out = np.empty((a.shape[0], 2), a.dtype)
                for i in prange(a.shape[0]):
                    out[i, 0], out[i, 1] = formula(a[i, 0], a[i, 1], a[i, 2])
                return out

        elif inputs == 2:

            @njit(parallel=True)
            def run(a):
                out = np.empty((a.shape[0], 3), a.dtype)
                for i in prange(a.shape[0]):
                    out[i, 0], out[i, 1], out[i, 2] = formula(a[i, 0], a[i, 1])
                return out

        else:

            @njit(parallel=True)
            def run(a):
                out = np.empty((a.shape[0], 3), a.dtype)
                for i in prange(a.shape[0]):
                    out[i, 0], out[i, 1], out[i, 2] = formula(a[i, 0], a[i, 1], a[i, 2])
                return out

        return run

    return {
        ("octahedral", "encode"): loop(octahedral_encode, 3, 2),
        ("octahedral", "decode"): loop(octahedral_decode, 2, 3),
        ("sphere", "encode"): loop(sphere_encode, 3, 2),
        ("sphere", "decode"): loop(sphere_decode, 2, 3),
        ("cube", "encode"): loop(cube_encode, 3, 3),
        ("cube", "decode"): loop(cube_decode, 3, 3),
        ("angular", "encode"): loop(angular_encode, 3, 2),
        ("angular", "decode"): loop(angular_decode, 2, 3),
        ("latlong", "encode"): loop(latlong_encode, 3, 2),
        ("latlong", "decode"): loop(latlong_decode, 2, 3),
    }


# --- DrJit


def drjit_peers(threads: int) -> dict[tuple[str, str], Peer]:
    """Return DrJit kernels (from numpy and back) by (map, way); raise where there is no LLVM."""
    import drjit as dr
    from drjit.llvm import Array2f, Array3f, Float

    dr.set_thread_count(threads)
    dr.eval(dr.arange(Float, 4) + 1)  # fails here when there is no LLVM library

    def largest(value, low):  # dr.maximum stops the process on LLVM 15 and earlier
        return dr.select(value > low, value, low)

    def octahedral_encode(d):
        s = dr.abs(d.x) + dr.abs(d.y) + dr.abs(d.z)
        p, q = d.x / s, d.y / s
        below = d.z < 0
        fold_p = dr.select(p >= 0, 1, -1) * (1 - dr.abs(q))
        fold_q = dr.select(q >= 0, 1, -1) * (1 - dr.abs(p))
        return Array2f(dr.select(below, fold_p, p), dr.select(below, fold_q, q)) * 0.5 + 0.5

    def octahedral_decode(uv):
        x, y = 2 * uv.x - 1, 2 * uv.y - 1
        z = 1 - dr.abs(x) - dr.abs(y)
        t = largest(-z, 0)
        return dr.normalize(Array3f(x - dr.select(x >= 0, t, -t), y - dr.select(y >= 0, t, -t), z))

    def sphere_encode(d):
        m = 2 * dr.sqrt(d.x * d.x + d.y * d.y + (d.z + 1) * (d.z + 1))
        return Array2f(d.x / m + 0.5, 0.5 - d.y / m)

    def sphere_decode(uv):
        p, q = 2 * uv.x - 1, 2 * uv.y - 1
        c = largest(1 - p * p - q * q, 0)
        s = 2 * dr.sqrt(c)
        return Array3f(p * s, -q * s, 2 * c - 1)

    def cube_encode(d):
        ax, ay, az = dr.abs(d.x), dr.abs(d.y), dr.abs(d.z)
        on_x, on_y = (ax >= ay) & (ax >= az), ay >= az
        m = dr.select(on_x, ax, dr.select(on_y, ay, az))
        p_x, p_z = dr.select(d.x >= 0, -d.z, d.z), dr.select(d.z >= 0, d.x, -d.x)
        p = dr.select(on_x, p_x, dr.select(on_y, d.x, p_z))
        q = dr.select(on_x | ~on_y, -d.y, dr.select(d.y >= 0, d.z, -d.z))
        back = dr.select(on_x, d.x < 0, dr.select(on_y, d.y < 0, d.z < 0))
        face = dr.select(on_x, 0.0, dr.select(on_y, 2.0, 4.0)) + dr.select(back, 1.0, 0.0)
        return Array3f(p / m * 0.5 + 0.5, q / m * 0.5 + 0.5, face)

    def cube_decode(uv):
        p, q, face = 2 * uv.x - 1, 2 * uv.y - 1, uv.z
        x = dr.select(face == 0, 1, dr.select(face == 1, -1, dr.select(face == 5, -p, p)))
        y = dr.select(face == 2, 1, dr.select(face == 3, -1, -q))
        z = dr.select(face == 4, 1, dr.select(face == 5, -1, q))
        z = dr.select(face == 0, -p, dr.select(face == 1, p, dr.select(face == 3, -q, z)))
        return dr.normalize(Array3f(x, y, z))

    def angular_encode(d):
        h = dr.sqrt(d.x * d.x + d.y * d.y)
        r = dr.atan2(h, -d.z) * float(HALF_OVER_PI) / largest(h, 1e-30)
        return Array2f(d.x * r + 0.5, 0.5 - d.y * r)

    def angular_decode(uv):
        p, q = 2 * uv.x - 1, 2 * uv.y - 1
        r = dr.sqrt(p * p + q * q)
        sin, cos = dr.sincos(math.pi * r)
        s = sin / largest(r, 1e-30)
        return Array3f(p * s, -q * s, -cos)

    def latlong_encode(d):
        u = dr.atan2(d.x, -d.z) * float(HALF_OVER_PI) + 0.5
        return Array2f(u, dr.atan2(dr.sqrt(d.x * d.x + d.z * d.z), d.y) * (1 / math.pi))

    def latlong_decode(uv):
        sin_phi, cos_phi = dr.sincos(math.pi * (2 * uv.x - 1))
        sin_theta, cos_theta = dr.sincos(math.pi * uv.y)
        return Array3f(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)

    def call(formula):
        def run(a):
            vector = Array3f if a.shape[-1] == 3 else Array2f
            result = formula(dr.unravel(vector, Float(a.reshape(-1))))
            return dr.ravel(result).numpy().reshape(-1, len(result))

        return run

    local = locals()
    return {(m, w): call(local[f"{m}_{w}"]) for m in MAPS for w in ("encode", "decode")}


def drjit_maps(threads: int) -> tuple[str, ...]:
    """Return the maps that DrJit can run here.

    Each is tried in a process of its own: an LLVM library that lacks an instruction ends the
    process (version 15 and earlier lack the one under `dr.atan2`).
    """
    command = [sys.executable, __file__, str(threads)]

    def works(name: str) -> bool:
        return subprocess.run([*command, name], capture_output=True, check=False).returncode == 0

    return tuple(filter(works, MAPS))


if __name__ == "__main__":
    kernels = drjit_peers(int(sys.argv[1]))
    there = kernels[sys.argv[2], "encode"](np.eye(3, dtype=np.float32))
    kernels[sys.argv[2], "decode"](there)
