"""skylibs' maps against the rows of its name."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

from oracles import skylibs_oracle as oracle

MAPS = {
    "latlong": "latlong:skylibs",
    "angular": "angular:skylibs",
    "skyangular": "angular:skylibs-skyangular",
    "sphere": "sphere:skylibs",
    "cube": "cube:skylibs",
}


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    record_property("oracle", oracle.version())
    print(f"ran against {oracle.version()}")


@pytest.mark.parametrize("kind", MAPS)
def test_world_to_image(kind):
    d = random_directions(12_000, 400)
    got, want = sm.encode(d, MAPS[kind]), oracle.world2image(kind, d)
    inside = ~np.isnan(got[:, 0])
    # Below the horizon its sky map goes on beyond the rim; ours has nothing there.
    assert inside.mean() > (0.45 if kind == "skyangular" else 0.999)
    # Its acos loses half of the digits near its ends; random directions come within 1e-2 of them.
    assert np.abs(got - want)[inside].max() < 1e-12


@pytest.mark.parametrize("kind", MAPS)
def test_image_to_world(kind):
    uv = np.random.default_rng(401).random((12_000, 2))
    got, want = sm.decode(uv, MAPS[kind]), oracle.image2world(kind, uv)
    assert np.array_equal(np.isnan(got[:, 0]), np.isnan(want[:, 0]))
    ok = ~np.isnan(want[:, 0])
    assert ok.sum() > 5_000
    # Near a rim √(1 - r²) falls to 1e-2 among random points: ε over that, 2e-14.
    assert np.abs(got - want)[ok].max() < 1e-12


def test_skylatlong_is_no_row():
    # The upper half of a panorama over the whole height: a latlong has no parameter for that yet.
    d = random_directions(2_000, 402)
    d[:, 1] = np.abs(d[:, 1])
    uv = sm.encode(d, "latlong:skylibs")
    want = oracle.world2image("skylatlong", d)
    # Angles in turns: arctangents and an arccosine, as of the other maps (above).
    assert np.abs(uv * [1, 2] - want).max() < 1e-12
    assert "skylatlong" not in {row["name"] for row in sm.conventions("latlong")}
