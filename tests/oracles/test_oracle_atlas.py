"""S2's cells, PROJ's maps and ffmpeg's equi-angular video against the library's maps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import random_directions

from oracles import ffmpeg_oracle, need
from oracles.test_oracle_ffmpeg import QUANTIZATION, scene


def test_s2_cells_are_cube_quadratic_s2():
    s2: Any = need("s2sphere")
    sphere = s2.sphere if hasattr(s2, "sphere") else s2
    d = random_directions(2000, 300)
    uv = sm.encode(d, "cube_quadratic:s2")
    for direction, (u, v, face) in zip(d, uv, strict=True):
        cell = sphere.CellId.from_point(sphere.Point(*direction))
        number, i, j, _ = cell.to_face_ij_orientation()
        # Leaf cells have 2^30 steps a side; s and t may round to the next one.
        assert number == face
        assert abs(i - u * 2**30) < 2 and abs(j - v * 2**30) < 2


def lonlat(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.degrees(np.arctan2(d[:, 1], d[:, 0])), np.degrees(
        np.arctan2(d[:, 2], np.hypot(d[:, 0], d[:, 1]))
    )


def test_proj_laea_is_the_sphere_map():
    pyproj: Any = need("pyproj")
    d = random_directions(5000, 301)
    d = d[d[:, 0] > -0.999]  # at the rim an error of an angle moves the point by its root
    x, y = pyproj.Proj("+proj=laea +lat_0=0 +lon_0=0 +R=1")(*lonlat(d))
    uv = sm.encode(d, "sphere", axes="+y -z +x")
    # PROJ's 1 + cos c is 1e-3 or more: its root is known to 1e-13, and uv to a quarter of that.
    assert np.abs(uv - np.stack([0.5 + x / 4, 0.5 - y / 4], -1)).max() < 1e-12


def test_proj_cea_is_lambert_cylindrical():
    pyproj: Any = need("pyproj")
    d = random_directions(5000, 302)
    x, y = pyproj.Proj("+proj=cea +lon_0=0 +R=1")(*lonlat(d))
    uv = sm.encode(d, "lambert_cylindrical", axes="+y -z +x")
    # Degrees and PROJ's sines round u and v by a few ε; held to the limit of the sphere map.
    assert np.abs(uv - np.stack([0.5 + x / (2 * np.pi), 0.5 - y / 2], -1)).max() < 1e-12


def test_proj_qsc_is_cube_equal_area():
    # One face of PROJ's, about latitude 0 and longitude 0, is the front of ours.
    pyproj: Any = need("pyproj")
    d = random_directions(20_000, 303)
    uv = sm.encode(d, "cube_equal_area", axes="+y -z +x")
    front = uv[:, 2] == 4
    x, y = pyproj.Proj("+proj=qsc +lat_0=0 +lon_0=0 +a=1 +b=1 +units=m")(*lonlat(d[front]))
    got = uv[front, :2]
    # PROJ's arccosine of the angle from a face's middle is good to 1e-8 there and to 1e-14 here.
    assert np.abs(got - np.stack([0.5 + np.array(x) / 2, 0.5 - np.array(y) / 2], -1)).max() < 1e-9


def test_ffmpeg_eac_is_cube_equiangular():
    # v360 keeps two texels at the ends of each row for padding: its own formula for the rest.
    height, width = 256, 384
    source = scene(sm.directions("latlong:ffmpeg", 512))
    got = ffmpeg_oracle.v360(source, "e", "eac", (height, width))
    j, i = np.mgrid[0:height, 0:width]
    pad_u, pad_v = 2 / width, 2 / height
    u = 3 * ((i + 0.5) / width - pad_u) / (1 - 2 * pad_u)
    v = (j + 0.5) / height
    row = np.floor(2 * v)
    v = (v - pad_v - 0.5 * row) / (0.5 - 2 * pad_v)
    inside = (u > 0) & (u < 3) & (v > 0) & (v < 1)
    uv = np.stack([u / 3, (v + row) / 2], -1)[inside]
    want = scene(sm.decode(uv, "cube_equiangular:ffmpeg-eac"))
    # Its pad is not exactly what its formula says near the ends: the difference stays below a
    # hundredth of a texel's step.
    assert np.abs(got[inside] - want).max() < 2 * QUANTIZATION + 2


@pytest.mark.parametrize("name", ["cube_quadratic:s2", "cube_equiangular:s2-tangent"])
def test_literal_formula_of_s2(name):
    # S2's XYZtoFaceUV and UVtoST, written from s2coords.h.
    d = random_directions(5000, 304)
    x, y, z = d.T
    axis = np.argmax(np.abs(d), axis=-1)
    face = axis + 3 * (np.take_along_axis(d, axis[:, None], -1)[:, 0] < 0)
    with np.errstate(all="ignore"):
        u = np.select(
            [face == k for k in range(6)], [y / x, -x / y, -x / z, z / x, z / y, -y / z], np.nan
        )
        v = np.select(
            [face == k for k in range(6)], [z / x, z / y, -y / z, y / x, -x / y, -x / z], np.nan
        )

    def st(w: np.ndarray) -> np.ndarray:
        if name.startswith("cube_equiangular"):
            return (2 / np.pi) * (np.arctan(w) + np.pi / 4)
        with np.errstate(invalid="ignore"):
            return np.where(w >= 0, 0.5 * np.sqrt(1 + 3 * w), 1 - 0.5 * np.sqrt(1 - 3 * w))

    want = np.stack([st(u), st(v), face], -1)
    # 45 ε: a quotient, and a root or an arctangent of it, of numbers up to 2.
    assert np.abs(sm.encode(d, name) - want).max() < 1e-14
    # 9 ε: uv off by ε moves a direction by 3 at most, and its length is a root and a quotient.
    assert np.abs(reference.angle(sm.decode(want, name), d)).max() < 2e-15
