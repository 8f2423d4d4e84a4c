"""py360convert against the rows of its name."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import random_directions

from oracles import py360convert_oracle as oracle


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    record_property("oracle", oracle.version())
    print(f"ran against {oracle.version()}")


def test_panorama_coordinates():
    d = random_directions(12_000, 410)
    uv = sm.encode(d, "latlong:py360convert")
    want = oracle.coordinates(d, 256, 512)
    # ε of 512 columns is 1e-13, a few operations each; another grid is off by half a texel.
    assert np.abs(uv * [512, 256] - 0.5 - want).max() < 1e-10


@pytest.mark.parametrize("layout", ["horizon", "dice", "list"])
def test_faces(layout):
    panorama = reference.smooth_function(sm.directions("latlong:py360convert", 128))[..., 0]
    n, name = 65, f"cube:py360convert-{layout}"
    got = oracle.equirect_to_cube(panorama, n, layout)
    want = sm.convert(panorama, "latlong:py360convert", name, size=n, fill=0.0, antialias=False)
    assert got.shape == want.shape
    # Its coordinates are float32: 256 columns · 2^-24, times a slope of 3 · 2π/256 a texel.
    assert np.abs(got - want).max() < 5e-6


def test_it_would_notice_another_grid():
    panorama = reference.smooth_function(sm.directions("latlong:py360convert", 128))[..., 0]
    got = oracle.equirect_to_cube(panorama, 65, "dice")
    for change in ({"grid": "centers"}, {"axes": "-x -y +z"}):
        other = sm.projection("cube", convention="py360convert-dice", **change)
        made = sm.convert(panorama, "latlong:py360convert", other, size=65, antialias=False)
        assert np.abs(made - got).max() > 1e-3  # 200 times the tolerance above
