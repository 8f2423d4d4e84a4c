"""meshoptimizer and Draco against the octahedral rows of their names."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import random_directions

from oracles import packed_normals_oracle as oracle


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    record_property("oracle", " and ".join(oracle.versions()))
    print("ran against", *oracle.versions())


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_meshoptimizer(bits):
    one = 2 ** (bits - 1) - 1
    p = np.random.default_rng(420).integers(-one, one + 1, (12_000, 2))
    got = sm.decode((p / one + 1) / 2, "octahedral:meshoptimizer")
    want = oracle.meshopt_decode(p, bits)
    # It answers in 16-bit integers, rounded after arithmetic in float32.
    assert np.abs(got - want).max() < 0.75 / 32767


@pytest.mark.parametrize("bits", [8, 12])
def test_draco_quantizes_on_the_grid_of_its_row(bits):
    # The lattice |x| + |y| + |z| = const is the same whichever axis is the pole, and what is
    # stored cannot be seen from outside: which axis it is, is read from source.
    d = random_directions(12_000, 421)
    got = oracle.draco_round_trip(d, bits)
    steps = 2**bits - 2
    place = sm.encode(got, "octahedral:draco") * steps
    # What comes out lies on its grid of 2^bits - 1 points a side, to float32 ...
    assert np.abs(place - np.rint(place)).max() < 4e-7 * steps
    # ... and beside what went in: a cell is at most 2 √27 /steps wide in radians.
    assert reference.angle(got, d).max() < 2 * np.sqrt(27) / steps
