"""`projection.turned(pose)`: one meaning of a rotation, in every verb."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

POSE = sm.rotation(40, 10, -25)
OTHER = sm.rotation(-70, 30, 5)
# A turn is three products a component: a few ε, before or after the formula or a sum of thousands.
ROUNDED = 1e-12
KINDS = ("latlong", "cube", "octahedral", "angular", "perspective", "latlong:mitsuba")


class Turn:
    """What scipy's rotations look like."""

    def as_matrix(self):
        return POSE


@pytest.mark.parametrize("kind", KINDS)
def test_a_turned_map_is_a_rotation_given_once(kind):
    p = sm.projection(kind)
    q = p.turned(POSE)
    d = random_directions(200, 3)
    uv = q.encode(d)
    assert np.array_equal(uv, p.encode(d, rotation=POSE), equal_nan=True)
    assert np.array_equal(uv, sm.encode(d, p, rotation=Turn()), equal_nan=True)
    # What was at d is at POSE @ d.
    there = p.encode(d)
    ok = np.isfinite(there).all(-1)
    assert np.allclose(q.encode(d @ POSE.T)[ok], there[ok], atol=ROUNDED)
    assert np.array_equal(q.decode(uv), p.decode(uv, rotation=POSE), equal_nan=True)
    assert np.array_equal(q.covers(d), p.covers(d, rotation=POSE))
    assert np.array_equal(q.directions(6), p.directions(6, rotation=POSE), equal_nan=True)
    assert np.array_equal(q.solid_angle(6), p.solid_angle(6))
    image = np.arange(np.prod(p.shape(8)), dtype=np.float64).reshape(p.shape(8))
    assert np.array_equal(q.sample(image, d), p.sample(image, d, rotation=POSE))


def test_rotations_of_a_turned_map_compose():
    p = sm.projection("latlong")
    twice = p.turned(POSE).turned(OTHER)
    # One product of two matrices, whose terms are summed in one order or another.
    assert np.abs(twice.pose - OTHER @ POSE).max() < 1e-15
    d = random_directions(50, 4)
    assert np.allclose(twice.encode(d), p.encode(d, rotation=OTHER @ POSE), atol=ROUNDED)
    assert np.allclose(twice.encode(d), p.turned(POSE).encode(d, rotation=OTHER), atol=ROUNDED)
    assert p.turned(np.eye(3)) == p and p.turned(np.eye(3)).pose is None


def test_a_camera_sees_what_the_turned_content_shows():
    panorama = sm.directions("latlong", 64).astype(np.float32)
    camera = sm.projection("perspective", fov=80, aspect=1.5)
    crop = sm.convert(panorama, "latlong", camera.turned(POSE), size=40, antialias=False)
    other = sm.convert(panorama, "latlong", camera, size=40, rotation=POSE.T, antialias=False)
    # The coordinates are those of two products of three matrices: float32 rounds them apart.
    assert np.abs(crop - other).max() < 1e-4
    edited = sm.embed(crop, camera.turned(POSE), panorama, "latlong")
    assert np.array_equal(edited, sm.embed(crop, camera, panorama, "latlong", rotation=POSE))
    plan = sm.remap_plan("latlong", camera.turned(POSE), size=40, antialias=False)
    assert np.array_equal(plan(panorama), crop)


def test_equal_hashed_pickled_and_written():
    p = sm.projection("perspective", fov=75, aspect=1.5).turned(POSE)
    again = sm.projection("perspective", fov=75, aspect=1.5).turned(POSE)
    plain = sm.projection("perspective", fov=75, aspect=1.5)
    assert p == again and hash(p) == hash(again) and p != plain
    assert len({p, again, plain}) == 2
    for q in (pickle.loads(pickle.dumps(p)), copy.deepcopy(p), eval(repr(p), vars(sm))):
        assert type(q) is sm.Projection and q == p and np.array_equal(q.pose, p.pose)
    assert "turned" in repr(p) and "turned" in p.explanation()
    assert type(p) is type(p.turned(OTHER)) is sm.Projection


def test_a_subclass_stays_one():
    class Camera(sm.Projection):
        __slots__ = ()

    camera = Camera("perspective", fov=60)
    assert type(camera.turned(POSE)) is Camera
    assert np.array_equal(sm.encode([0.1, 0.2, -1], camera), camera.encode([0.1, 0.2, -1]))


@pytest.mark.parametrize("kind", ["latlong", "cube", "octahedral", "sphere"])
def test_sums_with_a_direction_turn(kind):
    p = sm.projection(kind)
    q = p.turned(POSE)
    sky = np.maximum(p.directions(32)[..., 1], 0)
    sky[~np.isfinite(sky)] = 0
    toward = sm.light.average_direction(sky, p)
    # The moments are sums over the same texels.
    assert np.allclose(sm.light.average_direction(sky, q), POSE @ toward, atol=ROUNDED)
    assert np.allclose(q.average_direction(sky), p.average_direction(sky, rotation=POSE))
    c = sm.sh.project(sky, p, order=3)
    # Fits to other texels, each as exact as its system of equations.
    assert np.allclose(sm.sh.project(sky, q, order=3), sm.sh.rotate(c, POSE), atol=1e-6)
    n = random_directions(20, 5)
    want = sm.light.irradiance_at(sky, n, p)
    # Texels on the horizon count by their side of it, and rounding moves none by more than this.
    assert np.allclose(sm.light.irradiance_at(sky, n @ POSE.T, q), want, atol=1e-9)
    # The same sum in the same order.
    assert np.allclose(q.integrate(sky), p.integrate(sky), rtol=1e-14)
    a, b = sm.light.Distribution(sky, p), sm.light.Distribution(sky, q)
    # The density of the texel that holds the direction, in single precision the same number.
    assert np.allclose(a.pdf(n), b.pdf(n @ POSE.T), rtol=1e-9)
    xi = np.random.default_rng(0).random((50, 2))
    # Cells are inverted by roots whose last bits are 1e-10 of a cell.
    assert np.allclose(a.sample(xi)[0] @ POSE.T, b.sample(xi)[0], atol=1e-9)
    assert b.projection == q


def test_area_and_borders_turn():
    sky = np.zeros((64, 128))
    sky[20, 40] = 1000
    cube = sm.projection("cube").turned(POSE)
    got = sm.convert(sky, "latlong", cube, size=8, filter="area")
    # Light is kept to what `area` promises.
    assert np.isclose(cube.integrate(got), sm.light.integrate(sky, "latlong"), rtol=1e-6)
    faces = np.random.default_rng(1).random((6, 8, 8))
    plain = sm.pad(faces, "cube", 2)
    assert np.allclose(sm.pad(faces, cube, 2), plain, atol=ROUNDED)
    depth = np.full((4, 4), 2.0)
    camera = sm.projection("perspective")
    want = sm.convert_depth(depth, camera)
    assert np.allclose(sm.convert_depth(depth, camera.turned(POSE)), want, atol=ROUNDED)


@pytest.mark.parametrize("bad", [np.ones((3, 3)), np.diag([1, 1, -1]), np.eye(2), None, "up"])
def test_errors_say_what_was_given(bad):
    p = sm.projection("latlong")
    with pytest.raises((ValueError, TypeError), match="pose"):
        p.turned(bad)
    if bad is not None:
        with pytest.raises((ValueError, TypeError), match="rotation"):
            sm.encode([0, 0, 1], p, rotation=bad)


def test_one_default_of_fill():
    d = np.array([[0.0, 0, -1], [0, 0, 1]])
    for dtype in (np.uint8, np.float32):
        image = np.full((8, 8, 2), 7, dtype)
        assert sm.sample(image, d, "matcap").tolist() == [[0, 0], [7, 7]]
        assert sm.sample(image, d, "matcap", fill=[1, 2]).tolist() == [[1, 2], [7, 7]]
        weighted = sm.sample(image, d, "matcap", fill=[1, 2], alpha=-1)
        assert weighted.tolist() == [[1, 2], [7, 7]]
        assert sm.convert(image, "matcap", "latlong", size=4, alpha=-1).min() == 0
    marked = sm.sample(np.ones((8, 8)), d, "matcap", fill=np.nan)
    assert np.isnan(marked[0]) and marked[1] == 1
