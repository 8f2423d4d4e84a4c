"""Draco's quantized normals, by a round trip through DracoPy, against `draco{bits}x2`."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from reference import packing as reference

from oracles import need
from oracles.test_oracle_meshoptimizer import hard


def round_trip(d: np.ndarray, bits: int) -> np.ndarray:
    """Encode directions as the normals of a mesh of loose triangles and decode them again."""
    draco = need("DracoPy")
    points = np.arange(3 * len(d), dtype=np.float32).reshape(-1, 3)
    data = draco.encode(
        points,
        faces=np.arange(len(d), dtype=np.uint32).reshape(-1, 3),
        quantization_bits=14,
        normals=d.astype(np.float64),  # what it asks for; it makes them float32
        normal_quantization_bits=bits,
        preserve_order=True,
    )
    return np.asarray(draco.decode(data).normals)


# At 30 bits its entropy coder takes most of a minute whatever the number of normals.
MOST = pytest.param(30, marks=pytest.mark.slow)


@pytest.mark.parametrize("bits", [2, 3, 5, 8, 10, 13, 16, 20, 24, MOST])
def test_what_draco_decodes_is_what_we_decode_from_our_codes(bits):
    d = hard(20_000)[: 3 * (10_000 if bits < 30 else 500)]
    got = sm.packing.unpack(sm.packing.pack(d, f"draco{bits}x2"), f"draco{bits}x2")
    want = round_trip(d, bits)
    assert want.shape == got.shape
    assert np.array_equal(got, want)


def test_every_code_of_10_bits_is_canonical_as_draco_has_it():
    last = (1 << 5) - 2
    s, t = np.meshgrid(np.arange(last + 1), np.arange(last + 1), indexing="ij")
    codes = np.stack([s, t], -1).reshape(-1, 2).astype(np.uint8)
    d = sm.packing.unpack(codes, "draco5x2")
    written = sm.packing.pack(d, "draco5x2")
    assert np.array_equal(sm.packing.canonical(codes, "draco5x2"), written)
    # One code for each direction that the grid holds.
    distinct = np.unique(np.round(d, 5) + 0.0, axis=0)
    assert len(np.unique(written, axis=0)) == len(distinct)
    assert np.array_equal(sm.packing.pack([1, 0, 0], "draco5x2"), [last // 2] * 2), "x is the pole"


def test_bound():
    for bits in (4, 8, 12):
        name = f"draco{bits}x2"
        d = random_directions(50_000, bits).astype(np.float32)
        e = reference.angle(
            sm.packing.unpack(sm.packing.pack(d, name), name, dtype=float), reference.unit(d)
        )
        assert e.max() <= sm.packing.packing(name).bound
