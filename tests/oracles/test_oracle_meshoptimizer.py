"""meshoptimizer's octahedral filter against `meshoptimizer8x4` and `meshoptimizer16x4`."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
import spheremap as sm
from conftest import assert_same_bits, random_directions
from reference import packing as reference

from oracles import need

BITS = pytest.mark.parametrize("bits", [8, 16])


def hard(n: int) -> np.ndarray:
    """Random directions, the axes, halves of steps, and directions on the crease; float32."""
    d = random_directions(n, 11)
    ties = reference.oct_direction(np.random.default_rng(1).integers(-254, 255, (n // 4, 2)) / 254)
    crease = d[: n // 4] * [1, 1, 0]
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    return np.concatenate([d, ties, crease, axes]).astype(np.float32)


def library() -> ctypes.CDLL:
    need("meshoptimizer")
    from meshoptimizer._loader import lib

    lib.meshopt_encodeFilterOct.restype = None
    return lib


def encode(d: np.ndarray, bits: int) -> np.ndarray:
    four = np.zeros((len(d), 4), np.float32)
    four[:, :3] = d
    out = np.zeros((len(d), 4), f"i{bits // 8}")
    library().meshopt_encodeFilterOct(
        ctypes.c_void_p(out.ctypes.data),
        ctypes.c_size_t(len(d)),
        ctypes.c_size_t(bits // 2),
        ctypes.c_int(bits),
        ctypes.c_void_p(four.ctypes.data),
    )
    return out


@BITS
def test_codes_are_the_same(bits):
    d = hard(200_000)
    codes = sm.packing.pack(d, f"meshoptimizer{bits}x4")
    assert_same_bits(codes, encode(d, bits))
    assert np.array_equal(codes, reference.meshoptimizer_encode(d, bits))


@BITS
def test_decoding(bits):
    meshoptimizer = need("meshoptimizer")
    largest = (1 << (bits - 1)) - 1
    if bits == 8:
        x, y = np.meshgrid(np.arange(-127, 128), np.arange(-127, 128), indexing="ij")
        xy = np.stack([x, y], -1).reshape(-1, 2)
    else:
        xy = np.random.default_rng(2).integers(-largest, largest + 1, (100_000, 2))
    codes = np.zeros((len(xy) // 4 * 4, 4), f"i{bits // 8}")
    codes[:, :2] = xy[: len(codes)]
    codes[:, 2] = largest
    want = meshoptimizer.decode_filter_oct(codes.copy(), len(codes), bits // 2)
    want = np.asarray(want).reshape(codes.shape)[:, :3].astype(int)
    got = sm.packing.unpack(codes, f"meshoptimizer{bits}x4").astype(float) * largest
    assert np.abs(got - np.round(got)).max() < 1e-2
    off = np.abs(np.round(got) - want)
    # Its SIMD code multiplies by an approximate reciprocal square root (12 bits), and rounds halves
    # to even: one of 127, or 2⁻¹² of 32767.
    assert off.max() <= (1 if bits == 8 else 16)
    assert bits == 16 or np.mean(off > 0) < 0.02


def test_a_filtered_normal_reads_as_our_own_octahedral_code():
    d = hard(20_000)
    filtered = sm.packing.pack(d, "meshoptimizer8x4")
    nearest = sm.packing.unpack(filtered[:, :2], "oct8x2", dtype=np.float64)
    bound = sm.packing.packing("oct8x2").bounds["nearest"]
    assert reference.angle(nearest, reference.unit(d)).max() <= bound + 5e-7
