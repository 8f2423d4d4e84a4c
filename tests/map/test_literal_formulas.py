"""Each formula in the letters of its source, beside the form that the code uses.

A literal formula is only evaluated where it is well conditioned; the other tests have the rest.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

# 4000 random directions stay away from blind spots by 1e-2 or so, where the textbook forms lose
# about two digits of float64.
TOLERANCE = 1e-13
R = random_directions(4000, 100)
R = R[np.min(np.abs(R), axis=-1) > 1e-3]
RX, RY, RZ = R.T


def disk_uv(seed: int, radius: float = 0.99) -> np.ndarray:
    rng = np.random.default_rng(seed)
    uv = rng.random((4000, 2))
    return uv[np.sum((2 * uv - 1) ** 2, axis=-1) < radius**2]


def check(uv: np.ndarray, u: np.ndarray, v: np.ndarray) -> None:
    assert np.abs(uv[..., 0] - u).max() < TOLERANCE
    assert np.abs(uv[..., 1] - v).max() < TOLERANCE


def test_sphere_map_of_opengl():
    m = 2 * np.sqrt(RX**2 + RY**2 + (RZ + 1) ** 2)
    s = RX / m + 1 / 2
    t = RY / m + 1 / 2  # from the bottom row
    check(sm.encode(R, "sphere"), s, 1 - t)
    # In memory order, where the first row is t = 0, no flip is needed.
    check(sm.encode(R, "sphere", axes="+x +y +z"), s, t)


def test_inverse_sphere_map():
    uv = disk_uv(101)
    u, v = uv.T
    rz = -8 * u**2 + 8 * u - 8 * v**2 + 8 * v - 3
    root = np.sqrt(-4 * u**2 + 4 * u - 4 * v**2 + 4 * v - 1)
    rx = 2 * root * (2 * u - 1)
    ry = 2 * root * (2 * v - 1)
    d = sm.decode(uv, "sphere", axes="+x +y +z")
    assert np.abs(d - np.stack([rx, ry, rz], -1)).max() < TOLERANCE
    d = sm.decode(uv, "sphere")  # displayed: y up
    assert np.abs(d - np.stack([rx, -ry, rz], -1)).max() < TOLERANCE


def test_sphere_map_is_a_photo_of_a_mirror_ball():
    # The ball at n reflects the viewer's direction (0, 0, 1) into r.
    uv = disk_uv(102)
    n = np.stack([2 * uv[:, 0] - 1, 1 - 2 * uv[:, 1]], -1)
    n = np.concatenate([n, np.sqrt(1 - np.sum(n * n, -1, keepdims=True))], -1)
    r = sm.reflect(np.array([0.0, 0.0, 1.0]), n)
    assert np.abs(sm.decode(uv, "sphere") - r).max() < TOLERANCE


def test_the_whole_rim_shows_the_blind_spot():
    a = np.linspace(0, 2 * np.pi, 33)
    uv = np.stack([np.cos(a), np.sin(a)], -1) / 2 + 0.5
    d = sm.decode(uv, "sphere")
    d = d[~np.isnan(d[:, 0])]  # some of these round to outside the disk
    assert len(d) > 8
    # √(8 eps) and some: the rim of this map is where an ulp of uv is 6e-8 rad.
    assert np.abs(d - [0, 0, -1]).max() < 1e-7


def test_direct3d_twin():
    n = R + np.array([0, 0, -1])
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    nx, ny, _ = n.T
    check(sm.encode(R, "sphere:d3d"), nx / 2 + 1 / 2, -ny / 2 + 1 / 2)
    p = sm.projection("sphere", convention="d3d")
    assert p.axes == "+x -y -z"


def test_matcap():
    n = R[RZ > 0]
    nx, ny, _ = n.T
    check(sm.encode(n, "matcap"), nx / 2 + 1 / 2, 1 - (ny / 2 + 1 / 2))
    check(sm.encode(n, "matcap", axes="+x +y +z"), nx / 2 + 1 / 2, ny / 2 + 1 / 2)


def test_dual_paraboloid():
    x, y, z = R.T
    m = 2 * (1 + np.abs(z))
    uv = sm.encode(R, "dual_paraboloid", axes="+x +y +z")
    check(uv, x / m + 1 / 2, y / m + 1 / 2)
    assert np.array_equal(uv[..., 2], np.where(z >= 0, 0, 1))
    displayed = sm.encode(R, "dual_paraboloid")
    check(displayed, x / m + 1 / 2, 1 - (y / m + 1 / 2))


def test_cube_face_table_of_opengl():
    # major axis: (sc, tc, ma); s = (sc/|ma| + 1)/2, t = (tc/|ma| + 1)/2.
    table = [
        (RX, -RZ, -RY, RX),
        (-RX, RZ, -RY, RX),
        (RY, RX, RZ, RY),
        (-RY, RX, -RZ, RY),
        (RZ, RX, -RY, RZ),
        (-RZ, -RX, -RY, RZ),
    ]
    uv = sm.encode(R, "cube")
    largest = np.max(np.abs(R), axis=-1)
    seen = 0
    for face, (major, sc, tc, ma) in enumerate(table):
        here = major == largest
        assert here.sum() > 100
        s = (sc / np.abs(ma) + 1) / 2
        t = (tc / np.abs(ma) + 1) / 2
        assert np.array_equal(uv[here, 2], np.full(here.sum(), face))
        check(uv[here], s[here], t[here])
        seen += here.sum()
    assert seen == len(R)


def test_angular_map_of_debevec():
    # Center -z; r = acos(-Dz)/(2π √(Dx² + Dy²)).
    r = np.arccos(-RZ) / (2 * np.pi * np.sqrt(RX**2 + RY**2))
    check(sm.encode(R, "angular"), 1 / 2 + RX * r, 1 / 2 - RY * r)
    # In its own frame, center +z, with the arctangent.
    h = np.hypot(RX, RY)
    r = np.arctan2(h, RZ) / (2 * np.pi * h)
    check(sm.encode(R, "angular", axes="+x +y +z"), 1 / 2 + RX * r, 1 / 2 + RY * r)


@pytest.mark.parametrize("fov", [30.0, 90.0, 180.0, 300.0])
def test_angular_with_fov_is_the_equidistant_fisheye(fov):
    p = sm.projection("angular", axes="+x +y +z", fov=fov)
    theta = np.arccos(RZ)
    inside = theta < math.radians(fov) / 2 * 0.999
    f = 1 / math.radians(fov)
    phi = np.arctan2(RY, RX)
    uv = p.encode(R)
    check(
        uv[inside],
        1 / 2 + f * theta[inside] * np.cos(phi[inside]),
        1 / 2 + f * theta[inside] * np.sin(phi[inside]),
    )
    assert np.isnan(uv[theta > math.radians(fov) / 2 * 1.001]).all()


def test_octahedral():
    n = R / np.sum(np.abs(R), axis=-1, keepdims=True)
    z = n[:, 2]
    folded = (1 - np.abs(n[:, [1, 0]])) * np.sign(n[:, :2])
    xy = np.where((z <= 0)[:, None], folded, n[:, :2])
    check(sm.encode(R, "octahedral"), xy[:, 0] / 2 + 1 / 2, xy[:, 1] / 2 + 1 / 2)


def test_octahedral_sign_of_zero_is_plus_one():
    for x in (0.0, -0.0):
        for y in (0.0, -0.0):
            for dtype in (np.float32, np.float64):
                uv = sm.encode(np.array([x, y, -1.0], dtype), "octahedral")
                assert uv.tolist() == [1.0, 1.0]


def test_hemioctahedral():
    n = R[RZ > 0]
    n = n / np.sum(np.abs(n), axis=-1, keepdims=True)
    x, y, _ = n.T
    check(sm.encode(n, "hemioctahedral"), (x + y) / 2 + 1 / 2, (x - y) / 2 + 1 / 2)


def test_latlong():
    # In the view frame, and with the standard axes: the center is -z, the top is +y.
    u = np.arctan2(RX, RZ) / (2 * np.pi) + 1 / 2
    v = np.arccos(-RY) / np.pi
    check(sm.encode(R, "latlong", axes="+x +y +z"), u, v)
    u = np.arctan2(RX, -RZ) / (2 * np.pi) + 1 / 2
    v = np.arccos(RY) / np.pi
    check(sm.encode(R, "latlong"), u, v)


def test_densities_of_the_table():
    uv = disk_uv(103, 0.95)
    p, q = (2 * uv - 1).T
    one = np.array([0.0])
    r2 = p * p + q * q
    with_face = np.concatenate([uv, np.broadcast_to(one, (len(uv), 1))], -1)
    octant = np.stack([p, q, 1 - np.abs(p) - np.abs(q)], -1)
    fold = np.stack([1 - np.abs(q), 1 - np.abs(p), octant[:, 2]], -1)
    big_p = np.linalg.norm(np.where(octant[:, 2:] < 0, fold, octant), axis=-1)
    r = np.sqrt(r2)
    cases = {
        "sphere": 16 + 0 * p,
        "matcap": 4 / np.sqrt(1 - r2),
        "angular": 4 * np.pi**2 * np.sin(np.pi * r) / (np.pi * r),
        "latlong": 2 * np.pi**2 * np.sin(np.pi * uv[:, 1]),
        "octahedral": 4 / big_p**3,
    }
    for name, want in cases.items():
        assert np.allclose(sm.density(uv, name), want, rtol=1e-12, atol=0), name
    faces = {"dual_paraboloid": 16 / (1 + r2) ** 2, "cube": 4 / (1 + r2) ** 1.5}
    for name, want in faces.items():
        assert np.allclose(sm.density(with_face, name), want, rtol=1e-12, atol=0), name
    hemi = np.stack([(p + q) / 2, (p - q) / 2, 1 - np.maximum(np.abs(p), np.abs(q))], -1)
    want = 2 / np.linalg.norm(hemi, axis=-1) ** 3
    assert np.allclose(sm.density(uv, "hemioctahedral"), want, rtol=1e-12, atol=0)


@pytest.mark.parametrize("name", ["octahedral", "cube"])
def test_density_ratio_is_sqrt_27(name):
    lo, hi = sm.projection(name).density_range
    assert hi / lo == pytest.approx(math.sqrt(27), rel=1e-12)


def test_texel_closed_forms_in_float64():
    # latlong: 2π/W (cos θ₀ - cos θ₁), exact enough in longdouble.
    h, w = 16, 32
    edges = np.arange(h + 1, dtype=np.longdouble) / h * np.longdouble(np.pi)
    rows = 2 * np.pi / w * -np.diff(np.cos(edges))
    got = sm.solid_angle("latlong", (h, w))
    assert np.allclose(
        got, np.broadcast_to(rows[:, None].astype(float), (h, w)), rtol=1e-14, atol=0
    )
    # cube: the arctangent form of the corner sums.
    n = 8
    e = 2 * np.arange(n + 1) / n - 1
    x, y = np.meshgrid(e, e)
    area = np.arctan2(x * y, np.sqrt(x * x + y * y + 1))
    want = area[1:, 1:] - area[:-1, 1:] - area[1:, :-1] + area[:-1, :-1]
    assert np.allclose(sm.solid_angle("cube", n), want[None], rtol=1e-12, atol=0)
    # sphere: density 16, so a whole texel is 16/n².
    got = sm.solid_angle("sphere", 64)
    assert got[32, 32] == pytest.approx(16 / 64**2, rel=1e-13)
