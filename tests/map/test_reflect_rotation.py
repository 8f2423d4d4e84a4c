"""reflect(view, normal) and rotation(yaw, pitch, roll), and shading with them."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from hypothesis import given
from hypothesis import strategies as st

angles = st.floats(-720, 720)


def test_reflect_is_the_formula():
    v, n = random_directions(1000, 160), random_directions(1000, 161)
    dot = np.sum(v * n, axis=-1, keepdims=True)
    assert np.abs(sm.reflect(v, n) - (2 * dot * n - v)).max() < 1e-15 * 4


def test_reflect_does_not_care_for_the_length_or_sign_of_the_normal():
    v, n = random_directions(1000, 162), random_directions(1000, 163)
    want = sm.reflect(v, n)
    for scale in (-1.0, 3.0, 1e-3, 1e100, 1e-100):
        assert np.abs(sm.reflect(v, n * scale) - want).max() < 1e-14
    for scale in (1e15, 1e-15, 1e30, 1e-30):
        got = sm.reflect(v.astype(np.float32), (n * scale).astype(np.float32))
        assert np.abs(got - want).max() < 4e-6
    assert np.abs(sm.reflect(v * 5, n) - 5 * want).max() < 1e-14


def test_reflect_twice_is_nothing():
    v, n = random_directions(1000, 164), random_directions(1000, 165)
    assert np.abs(sm.reflect(sm.reflect(v, n), n) - v).max() < 1e-14


def test_reflect_keeps_length_and_angle():
    v, n = random_directions(1000, 166), random_directions(1000, 167)
    r = sm.reflect(v, n)
    assert np.abs(np.linalg.norm(r, axis=-1) - 1).max() < 1e-14
    assert np.abs(np.sum(r * n, -1) - np.sum(v * n, -1)).max() < 1e-14


def test_reflect_broadcasts():
    v, n = random_directions(5, 168), random_directions(7, 169)
    got = sm.reflect(v[:, None], n[None])
    assert got.shape == (5, 7, 3)
    for i in range(5):
        for j in range(7):
            assert np.array_equal(got[i, j], sm.reflect(v[i], n[j]))
    assert sm.reflect(v[0], n).shape == (7, 3)
    assert sm.reflect(v, n[0]).shape == (5, 3)
    assert sm.reflect([0, 0, 1.0], [0, 0, 1.0]).tolist() == [0, 0, 1]
    assert sm.reflect(np.empty((0, 3)), n[0]).shape == (0, 3)
    with pytest.raises(ValueError, match=r"broadcast|shape"):
        sm.reflect(np.ones((4, 3)), np.ones((5, 3)))
    with pytest.raises(ValueError, match="shape"):
        sm.reflect(np.ones((4, 2)), np.ones((4, 3)))


def test_reflect_dtypes_and_out():
    v, n = random_directions(50, 170), random_directions(50, 171)
    v32, n32 = v.astype(np.float32), n.astype(np.float32)
    assert sm.reflect(v32, n32).dtype == np.float32
    assert sm.reflect(v, n32).dtype == np.float64
    assert sm.reflect(v32.astype(np.float16), n32).dtype == np.float32
    out = np.empty((50, 3))
    assert sm.reflect(v, n, out=out) is out and np.array_equal(out, sm.reflect(v, n))
    with pytest.raises(ValueError, match="out"):
        sm.reflect(v, n, out=np.empty((49, 3)))
    with pytest.raises(TypeError, match="out"):
        sm.reflect(v, n, out=np.empty((50, 3), np.float32))
    for same in (v, n):
        with pytest.raises(ValueError, match="overlap"):
            sm.reflect(v, n, out=same)
    with pytest.raises(TypeError):
        sm.reflect(v.astype(complex), n)


def test_reflect_of_a_zero_normal_is_nan():
    v = np.array([0.0, 0, 1])
    for n in ([0.0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0]):
        assert np.isnan(sm.reflect(v, np.array(n))).all()


@given(angles, angles, angles)
def test_rotation_is_yaw_pitch_roll(yaw, pitch, roll):
    y, p, r = np.radians([yaw, pitch, roll])
    ry = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    rx = np.array([[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]])
    rz = np.array([[np.cos(r), -np.sin(r), 0], [np.sin(r), np.cos(r), 0], [0, 0, 1]])
    got = sm.rotation(yaw, pitch, roll)
    assert got.shape == (3, 3) and got.dtype == np.float64
    # np.radians of 720 degrees is off by 2e-15.
    assert np.abs(got - ry @ rx @ rz).max() < 1e-14
    assert np.abs(got @ got.T - np.eye(3)).max() < 1e-15 * 4
    assert np.linalg.det(got) == pytest.approx(1, abs=1e-15 * 8)


def test_quarter_turns_are_right_handed_and_exact():
    assert np.array_equal(sm.rotation(0, 0, 0), np.eye(3))
    x, y, z = np.eye(3)
    assert np.abs(sm.rotation(90, 0, 0) @ z - x).max() < 1e-16 * 2
    assert np.abs(sm.rotation(0, 90, 0) @ y - z).max() < 1e-16 * 2
    assert np.abs(sm.rotation(0, 0, 90) @ x - y).max() < 1e-16 * 2


def test_rotation_against_scipy():
    scipy_rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    want = scipy_rotation.from_euler("YXZ", [31, -47, 101], degrees=True)
    assert np.abs(sm.rotation(31, -47, 101) - want.as_matrix()).max() < 1e-15
    d = random_directions(100, 172)
    a = sm.encode(d, "octahedral", rotation=want)
    assert np.array_equal(a, sm.encode(d, "octahedral", rotation=want.as_matrix()))
    b = sm.encode(want.inv().apply(d), "octahedral")
    assert np.abs(a - b).max() < 1e-14


@pytest.mark.parametrize(
    "wrong",
    [
        np.diag([1.0, 1, -1]),
        2 * np.eye(3),
        np.eye(3) + np.eye(3, k=1) * 1e-3,
        np.full((3, 3), np.nan),
        np.zeros((3, 3)),
        np.eye(4),
        np.eye(2),
        np.ones(3),
    ],
    ids=["mirror", "scaled", "sheared", "nan", "zero", "4x4", "2x2", "vector"],
)
def test_what_is_no_rotation_is_refused(wrong):
    with pytest.raises(ValueError, match="rotation"):
        sm.encode(np.ones(3), "octahedral", rotation=wrong)
    with pytest.raises(ValueError, match="rotation"):
        sm.convert(np.zeros((4, 8, 1)), "latlong", "latlong", rotation=wrong)


def test_rotation_in_float32_and_lists_are_accepted():
    turn = sm.rotation(10, 20, 30)
    d = random_directions(20, 173)
    want = sm.encode(d, "latlong", rotation=turn)
    assert np.abs(sm.encode(d, "latlong", rotation=turn.astype(np.float32)) - want).max() < 1e-6
    assert np.array_equal(sm.encode(d, "latlong", rotation=turn.tolist()), want)
    assert np.array_equal(sm.encode(d, "latlong", rotation=np.asfortranarray(turn)), want)
    assert np.array_equal(sm.encode(d, "latlong", rotation=np.eye(3)), sm.encode(d, "latlong"))


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_rotation_of_no_angle(bad):
    with pytest.raises(ValueError, match=r"yaw|pitch|roll|finite"):
        sm.rotation(bad, 0, 0)


def test_environment_shading_of_a_sphere():
    # The classic effect, per pixel: eye, positions, normals -> reflection -> lookup. A mirror
    # ball seen from far away along -z shows the sphere map itself.
    n = 64
    p = sm.projection("sphere")
    normals = sm.projection("matcap").directions(n)
    ok = ~np.isnan(normals[..., 0])
    view = np.array([0.0, 0.0, 1.0])  # toward an eye at infinity
    r = sm.reflect(view, normals[ok])
    rng = np.random.default_rng(174)
    image = rng.random((n, n, 3))
    got = p.sample(image, r)
    assert np.abs(got - image[ok]).max() < 1e-10
    # With an eye near by, directions fan out, and still every pixel is some texels' mean.
    positions = normals[ok]
    eye = np.array([0.0, 0.0, 4.0])
    got = p.sample(image, sm.reflect(eye - positions, normals[ok]))
    assert not np.isnan(got).any() and got.min() >= 0 and got.max() <= 1
