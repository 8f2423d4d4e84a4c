"""Lens models against OpenCV and against their papers, and the parameters that they refuse."""

from __future__ import annotations

import math
import re

import cv2
import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

D = random_directions(4000, 310)
LENSES = [
    {"fov": 180.0, "k1": 0.1, "k2": -0.02, "k3": 0.01, "k4": -0.001},
    {"fov": 220.0, "k1": -0.04, "k2": 0.004},
    {"fov": 100.0, "k1": -0.2, "k2": 0.1},
]


def theta_d(theta, k):
    a, b, c, d = (k.get(name, 0.0) for name in ("k1", "k2", "k3", "k4"))
    return theta * (1 + a * theta**2 + b * theta**4 + c * theta**6 + d * theta**8)


@pytest.mark.parametrize("lens", LENSES)
def test_kannala_brandt_is_opencvs_fisheye(lens):
    p = sm.projection("kannala_brandt", axes="+x +y +z", **lens)
    width = 1000.0
    focal = width / 2 / theta_d(math.radians(lens["fov"]) / 2, lens)
    k = np.array([[focal, 0, width / 2], [0, focal, width / 2], [0, 0, 1.0]])
    distortion = np.array([lens.get(name, 0.0) for name in ("k1", "k2", "k3", "k4")])
    # OpenCV takes the angle from x/z, and sees nothing behind.
    d = D[p.covers(D) & (D[:, 2] > 0.02)]
    theirs, _ = cv2.fisheye.projectPoints(d[:, None], np.zeros(3), np.zeros(3), k, distortion)
    # Pixels: ε of 1000 is 2e-13, over the 0.02 of OpenCV's x/z 1e-11; then a polynomial.
    assert np.abs(p.encode(d) * width - theirs[:, 0]).max() < 1e-9
    uv = p.encode(d[d[:, 2] > 0.3])
    back = p.decode(uv)
    plane = cv2.fisheye.undistortPoints(uv[:, None] * width, k, distortion)
    # It stops at a step of 1e-8.
    assert np.abs(back[:, :2] / back[:, 2:] - plane[:, 0]).max() < 1e-6


def test_double_sphere_as_the_paper_prints_it():
    xi, alpha, fov = -0.2, 0.6, 200.0
    p = sm.projection("double_sphere", xi=xi, alpha=alpha, fov=fov, axes="+x +y +z")

    def project(x, y, z):
        d1 = np.sqrt(x**2 + y**2 + z**2)
        d2 = np.sqrt(x**2 + y**2 + (xi * d1 + z) ** 2)
        n = alpha * d2 + (1 - alpha) * (xi * d1 + z)
        return np.stack([x / n, y / n], -1)

    rim = math.radians(fov) / 2
    radius = project(math.sin(rim), 0.0, math.cos(rim))[0]
    d = D[p.covers(D)]
    # A dozen operations on numbers up to 2, over an n that falls to 0.48: 50 ε, ten times over.
    assert np.abs((2 * p.encode(d) - 1) * radius - project(*d.T)).max() < 1e-13

    mx, my = ((2 * p.encode(d) - 1) * radius).T
    r2 = mx**2 + my**2
    mz = (1 - alpha**2 * r2) / (alpha * np.sqrt(1 - (2 * alpha - 1) * r2) + 1 - alpha)
    scale = (mz * xi + np.sqrt(mz**2 + (1 - xi**2) * r2)) / (mz**2 + r2)
    want = scale[:, None] * np.stack([mx, my, mz], -1) - [0, 0, xi]
    # Back through a root and a quotient as well: 100 ε, four times over.
    assert np.abs(p.decode(p.encode(d)) - want).max() < 1e-13


@pytest.mark.parametrize("xi", [0.5, 0.9, 1.0, 2.0])
def test_unified_as_the_paper_prints_it(xi):
    p = sm.projection("unified", xi=xi, fov=170, axes="+x +y +z")
    rim = math.radians(85)
    radius = math.sin(rim) / (math.cos(rim) + xi)
    d = D[p.covers(D)]
    want = d[:, :2] / (d[:, 2:] + xi)
    # The divisor is 0.59 or more: less is lost than in the double sphere, whose limit it keeps.
    assert np.abs((2 * p.encode(d) - 1) * radius - want).max() < 1e-13


def test_special_lenses_are_other_maps():
    def same(a, b):
        # Two formulas of one uv, at most 1: each is good to 2 ε.
        assert np.allclose(a.encode(D), b.encode(D), rtol=0, atol=1e-15, equal_nan=True)

    for fov in (100, 200):
        same(sm.projection("kannala_brandt", fov=fov), sm.projection("angular", fov=fov))
        same(sm.projection("unified", xi=1, fov=fov), sm.projection("stereographic", fov=fov))


def test_a_double_sphere_is_the_equisolid_lens_beyond_the_papers_limit():
    # Equation 43 of the paper ends this lens 135 degrees from the axis.
    a = sm.projection("double_sphere", xi=1, alpha=1, fov=300)
    b = sm.projection("equisolid", fov=300)
    # 150 degrees from the axis 1 + z is 0.13, off by ε/2: by 4 ε of itself, and the root by half.
    assert np.allclose(a.encode(D), b.encode(D), rtol=0, atol=1e-14, equal_nan=True)
    uv = b.encode(D[b.covers(D)])
    # Back as far from the axis, dθ/dr is 2/cos(75°) = 8: eight times as much.
    assert np.abs(a.decode(uv) - b.decode(uv)).max() < 1e-13


@pytest.mark.parametrize(("xi", "alpha"), [(-0.9, 0.3), (-0.2, 0.6), (0.5, 0.2), (0.7, 0.9)])
def test_a_double_sphere_reaches_as_far_as_its_radius_grows(xi, alpha):
    theta = np.linspace(0, math.pi, 1_000_001)
    far = np.hypot(np.sin(theta), xi + np.cos(theta))
    depth = alpha * far + (1 - alpha) * (xi + np.cos(theta))
    with np.errstate(divide="ignore"):
        radius = np.where(depth > 0, np.sin(theta) / depth, -1)
    end = math.degrees(theta[np.argmax(np.diff(radius) <= 0)])
    # Far enough from the end that the slope is 1 % of the chord's.
    p = sm.projection("double_sphere", xi=xi, alpha=alpha, fov=2 * (end - 3))
    d = D[p.covers(D)]
    # Where the slope is least, 7 % of the chord's, a dozen errors of ε become 200.
    assert np.abs(p.decode(p.encode(d)) - d).max() < 1e-13
    assert not p.covers(D[-D[:, 2] < math.cos(math.radians(end))]).any()
    with pytest.raises(ValueError, match="stops growing at") as caught:
        sm.projection("double_sphere", xi=xi, alpha=alpha, fov=2 * end + 10)
    # Steps of 2e-4 degrees, and four decimals.
    assert float(re.search(r"at (\d+\.\d+)", str(caught.value))[1]) == pytest.approx(end, abs=5e-4)


@pytest.mark.parametrize(
    ("name", "parameters", "end"),
    [
        ("unified", {"xi": 0.5, "fov": 270}, 120),
        ("unified", {"xi": 0.5, "fov": 240}, 120),
        ("unified", {"xi": 0.5, "fov": 239.9}, 120),
        ("unified", {"fov": 359}, math.degrees(math.acos(-0.9))),
        ("unified", {"xi": 3, "fov": 300}, math.degrees(math.acos(-1 / 3))),
        ("double_sphere", {"xi": 0, "alpha": 1, "fov": 180}, 90),
        ("double_sphere", {"xi": 0, "alpha": 1, "fov": 179.5}, 90),
        ("double_sphere", {"xi": 0, "alpha": 1, "fov": 270}, 90),
        ("kannala_brandt", {"k1": -0.2}, math.degrees(math.sqrt(1 / 0.6))),
        ("kannala_brandt", {"k1": -0.4, "fov": 360}, math.degrees(math.sqrt(1 / 1.2))),
    ],
)
def test_the_message_says_where_a_lens_ends(name, parameters, end):
    with pytest.raises(ValueError, match="stops growing at") as caught:
        sm.projection(name, **parameters)
    # Four decimals, and a slope of 1e-9 of that on the axis for 0: 6e-8 degrees.
    assert float(re.search(r"at (\d+\.\d+)", str(caught.value))[1]) == pytest.approx(end, abs=1e-4)


@pytest.mark.parametrize(
    ("name", "parameters", "text"),
    [
        ("kannala_brandt", {"k1": -0.2}, "stops growing at 73"),
        ("kannala_brandt", {"k4": 1.5}, "inverse is not found|stops growing"),
        ("unified", {"xi": 0.5, "fov": 260}, "`xi`"),
        ("unified", {"xi": 3, "fov": 300}, "`xi`"),
        ("double_sphere", {"fov": 300}, "`alpha`"),
        ("pannini", {"fov": 200, "s": 0.5}, "`s`"),
        ("pannini", {"fov": 300, "d": 0.5}, "`d`"),
    ],
)
def test_lenses_that_turn_back_are_refused(name, parameters, text):
    with pytest.raises(ValueError, match=text):
        sm.projection(name, **parameters)
