"""pbrt-v4, Unreal Engine and Cesium: their formulas read literally, and quantized-mesh's codes."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from reference import packing as reference

from oracles import need
from oracles.test_oracle_meshoptimizer import hard


def test_pbrt():
    d = np.concatenate([hard(50_000), [[-0.0, 0.6, -0.8], [0.0, 0.6, -0.8]]]).astype(np.float32)
    codes = sm.packing.pack(d, "pbrt16x2")
    assert np.array_equal(codes, reference.pbrt_encode(d))
    assert not np.array_equal(codes[-1], codes[-2]), "the sign of a zero counts"
    assert np.array_equal(sm.packing.unpack(codes, "pbrt16x2"), reference.pbrt_decode(codes))


@pytest.mark.parametrize("bits", [8, 9, 12, 16])
def test_unreal(bits):
    d = hard(50_000)
    codes = sm.packing.pack(d, f"unreal{bits}x2")
    assert np.array_equal(codes, reference.unreal_encode(d, bits))
    # The shader's own float32: a coordinate near 1 less 1 is off by two of its epsilons, on an
    # octahedron whose faces are 1/√3 away.
    place = reference.fields_to_place(codes.astype(float), "unorm", bits)
    want = reference.oct_direction(place)
    assert (
        reference.angle(sm.packing.unpack(codes, f"unreal{bits}x2").astype(float), want).max()
        < 8e-7
    )


@pytest.mark.parametrize("bits", [8, 16])
def test_cesium(bits):
    d = hard(50_000).astype(np.float64)
    codes = sm.packing.pack(d, f"cesium{bits}x2")
    assert np.array_equal(codes, reference.cesium_encode(d, bits))
    got = sm.packing.unpack(codes, f"cesium{bits}x2", dtype=np.float64)
    assert np.abs(got - reference.cesium_decode(codes, bits)).max() < 3e-16


def test_quantized_mesh_encoder_and_its_habit():
    """It multiplies by 256 and drops the fraction: half a step off on average, and 1 becomes 0."""
    encoder = need("quantized_mesh_encoder.normals").normals
    d = hard(20_000).astype(np.float64)
    d = d[np.abs(reference.oct_place(d)).max(-1) < 1]
    theirs = encoder.oct_encode(d).astype(int)
    ours = sm.packing.pack(d, "cesium8x2").astype(int)
    assert np.abs(theirs - ours).max() <= 1
    assert encoder.oct_encode(np.array([[1.0, 0, 0]]))[0, 0] == 0
    assert sm.packing.pack([1.0, 0, 0], "cesium8x2")[0] == 255
