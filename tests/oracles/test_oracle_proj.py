"""PROJ, through pyproj, against the maps that it has too: a sphere of radius 1."""

from __future__ import annotations

import math

import numpy as np
import pytest
import spheremap as sm

from . import need

# Our map, PROJ's name, and half the width and height of our image in its units.
MAPS = [
    ("mercator", {}, "merc", math.pi, math.pi),
    ("miller", {}, "mill", math.pi, 1.25 * math.asinh(math.tan(math.radians(72)))),
    ("mollweide", {}, "moll", 2 * math.sqrt(2), math.sqrt(2)),
    ("hammer", {}, "hammer", 2 * math.sqrt(2), math.sqrt(2)),
    ("sinusoidal", {}, "sinu", math.pi, math.pi / 2),
    ("latlong", {}, "eqc", math.pi, math.pi / 2),
    ("cylindrical", {"aspect": 2.0}, "cc", math.pi, math.pi / 2),
    ("perspective", {"fov": 120.0}, "gnom", math.sqrt(3), math.sqrt(3)),
    ("stereographic", {"fov": 240.0}, "stere", 2 * math.sqrt(3), 2 * math.sqrt(3)),
    ("orthographic", {}, "ortho", 1.0, 1.0),
    ("equisolid", {"fov": 300.0}, "laea", 2 * math.sin(1.25 * math.pi / 3), None),
    ("angular", {}, "aeqd", math.pi, math.pi),
]


@pytest.mark.parametrize(("name", "parameters", "proj", "width", "height"), MAPS)
def test_where_it_puts_a_place(name, parameters, proj, width, height):
    pyproj = need("pyproj")
    rng = np.random.default_rng(300)
    longitude, latitude = rng.uniform(-179, 179, 4000), rng.uniform(-84, 84, 4000)
    a, b = np.radians(longitude), np.radians(latitude)
    # North is up and the middle of the image looks along -z.
    d = np.stack([np.cos(b) * np.sin(a), np.sin(b), -np.cos(b) * np.cos(a)], -1)
    p = sm.projection(name, **parameters)
    uv = p.encode(d)
    seen = ~np.isnan(uv[:, 0])
    assert seen.sum() > 600
    theirs = pyproj.Proj(proj=proj, R=1, lat_0=0, lon_0=0)
    x, y = theirs(longitude[seen], latitude[seen])
    height = width if height is None else height
    error = np.hypot((2 * uv[seen, 0] - 1) * width - x, (1 - 2 * uv[seen, 1]) * height - y)
    # PROJ stops its iteration for moll at 1e-7 of θ, whose next step would be off by its square.
    assert error.max() < (1e-9 if proj == "moll" else 1e-12)
