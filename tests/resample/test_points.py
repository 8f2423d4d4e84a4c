"""Depth to points of space and back, on every map; longitude and latitude in every world."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest
import spheremap as sm
from conftest import LAYOUTS, assert_same_bits, each, random_directions

TURN = sm.rotation(40, -25, 10)


@each(LAYOUTS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_points_lie_where_texels_look_and_come_back(case, dtype):
    p = case.make()
    shape = p.shape(9)
    held = np.isfinite(p.directions(shape)[..., 0])
    depth = np.random.default_rng(4).uniform(1, 9, shape).astype(dtype)
    points = sm.depth_to_points(depth, p, rotation=TURN)
    assert points.dtype == dtype and points.shape == (*shape, 3)
    assert np.array_equal(np.isfinite(points).all(axis=-1), held)
    # A unit vector and a product, each rounded: a few units of the last place.
    assert np.allclose(np.linalg.norm(points, axis=-1)[held], depth[held], rtol=1e-6)
    want = p.directions(shape, rotation=TURN)[held]
    assert np.allclose(points[held] / depth[held][:, None], want, atol=1e-6)  # as above
    back = sm.points_to_depth(points, p, shape, rotation=TURN, fill=-1)
    assert back.dtype == dtype
    # A texel whose center lies on a rim has another one with its direction.
    places = sm.directions_to_pixels(p.directions(shape)[held], p, shape).astype(int)[:, ::-1]
    landed = np.zeros(shape, int)
    np.add.at(landed, tuple(places.T), 1)
    own = (places == np.argwhere(held)).all(axis=-1) & (landed[held] == 1)
    assert np.count_nonzero(~own) <= 2 * shape[-2]
    assert np.allclose(back[held][own], depth[held][own], rtol=1e-6)  # as above, and a norm
    assert np.all(back[~held] == -1)


def test_z_of_a_camera_and_of_a_cube():
    camera = sm.projection("perspective", fov=70, aspect=4 / 3).turned(TURN)
    z = np.random.default_rng(6).uniform(1, 5, (30, 40))
    points = sm.depth_to_points(z, camera, kind="z")
    # In the camera's own frame, where it looks along -z.
    assert np.allclose((points @ TURN)[..., 2], -z, rtol=1e-12)  # some rounded products
    assert np.allclose(sm.points_to_depth(points, camera, z.shape, kind="z"), z, rtol=1e-12)
    box = sm.depth_to_points(np.full((6, 8, 8), 2.0), "cube", kind="z")
    assert np.allclose(np.abs(box).max(axis=-1), 2, rtol=1e-12)  # some rounded products


def test_the_nearest_point_is_seen_and_nothing_elsewhere():
    points = [[0, 0, -5], [0, 0, -3], [0, 0, -4], [0, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]]
    depth = sm.points_to_depth(np.array(points, np.float32), "perspective", 5, fill=np.nan)
    assert depth[2, 2] == 3 and np.isnan(depth).sum() == 24 and depth.dtype == np.float32
    assert sm.points_to_depth(np.empty((0, 3)), "cube", 2).tolist() == np.zeros((6, 2, 2)).tolist()
    behind = sm.points_to_depth([[0, 0, 7]], "perspective", 5)
    assert not behind.any()
    missing = np.array([[1, 0, -2, np.nan, np.inf, 3, 4, 5]] * 4)
    known = np.isfinite(sm.depth_to_points(missing, "latlong")).all(axis=-1)
    assert known[0].tolist() == [True, False, False, False, False, True, True, True]


def test_errors_of_points():
    for verb in (
        lambda **o: sm.depth_to_points(np.ones((4, 8)), "latlong", **o),
        lambda **o: sm.points_to_depth(np.ones((4, 3)), "latlong", 4, **o),
    ):
        with pytest.raises(ValueError, match="unknown kind 'depth'; there are distance, z"):
            verb(kind="depth")
    with pytest.raises(ValueError, match=r"`depth` to have shape \(H, W\), got \(4, 8, 3\)"):
        sm.depth_to_points(np.ones((4, 8, 3)), "latlong")
    with pytest.raises(ValueError, match="twice as wide as high"):
        sm.depth_to_points(np.ones((8, 8)), "latlong")
    with pytest.raises(ValueError, match=r"shape \(\.\.\., 3\), got \(4, 2\)"):
        sm.points_to_depth(np.ones((4, 2)), "latlong", 4)
    with pytest.raises(TypeError, match="complex128"):
        sm.points_to_depth(np.ones((4, 3), complex), "latlong", 4)


# --- longitude and latitude

EARTH = "+y +z +x"


@pytest.mark.parametrize("world", ["+x +y -z", EARTH, "-x +z +y"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_longitude_and_latitude_come_back(world, dtype):
    d = random_directions(200, 8, dtype)
    lonlat = sm.directions_to_lonlat(7 * d, world=world)
    assert lonlat.dtype == dtype and np.all(np.abs(lonlat) <= [180, 90])
    # Degrees of float32 are good to 1e-5 near 180: 2e-7 radians.
    assert np.allclose(sm.lonlat_to_directions(lonlat, world=world), d, atol=1e-6)
    radians = sm.directions_to_lonlat(d, world=world, degrees=False)
    assert np.allclose(np.degrees(radians), lonlat, atol=1e-4)  # as above
    turns = sm.lonlat_to_directions(lonlat.astype(np.float64) + np.array([720, 0]), world=world)
    assert np.allclose(turns, d, atol=1e-6)  # as above


def _person(world):
    """Return what lies to the right, up and ahead as rows."""
    rows = np.zeros((3, 3))
    for row, (sign, axis) in zip(rows, world.split(), strict=True):
        row["xyz".index(axis)] = 1 if sign == "+" else -1
    return rows


WORLDS = [
    " ".join(sign + axis for sign, axis in zip(signs, axes, strict=True))
    for axes in permutations("xyz")
    for signs in product("+-", repeat=3)
]


@pytest.mark.parametrize("world", WORLDS)
def test_longitude_and_latitude_are_arctangents_in_every_world(world):
    person = _person(world)
    d = random_directions(500, 9, np.float64)
    # Beside a pole, and beside the place ahead: there each component counts, however small.
    small = 10.0 ** -np.linspace(0, 300, 100)
    above = np.stack([small, np.ones(100), np.roll(small, 7)], axis=-1) @ person
    ahead = np.stack([small, np.roll(small, 7), np.ones(100)], axis=-1) @ person
    d = np.concatenate([d, above, -above, ahead])
    x, y, z = person @ d.T
    want = np.degrees([np.arctan2(x, z), np.arctan2(y, np.hypot(x, z))]).T
    found = sm.directions_to_lonlat(d, world=world)
    # An arctangent is off by 2.13 units, its degrees and the two of NumPy by half a unit and one.
    assert np.allclose(found, want, rtol=4 * np.finfo(float).eps, atol=0)
    single = d.astype(np.float32)
    rounded = sm.directions_to_lonlat(single.astype(np.float64), world=world).astype(np.float32)
    assert_same_bits(sm.directions_to_lonlat(single, world=world), rounded)
    angles = np.random.default_rng(3).uniform(-1000, 1000, (500, 2))
    (longitude, latitude) = np.radians(np.remainder(angles, 360)).T
    level = np.cos(latitude)
    seen = [np.sin(longitude) * level, np.sin(latitude), np.cos(longitude) * level]
    # Numbers near 1000 are 1e-13 apart, which is 2e-15 radians.
    assert np.allclose(
        sm.lonlat_to_directions(angles, world=world), np.transpose(seen) @ person, atol=4e-15
    )


def test_angles_of_any_size_are_directions():
    whole = sm.lonlat_to_directions([[360e9, 0], [-90 + 360e9, 0], [0, 360e9 + 90]])
    assert np.array_equal(whole, [[0, 0, -1], [-1, 0, 0], [0, 1, 0]])
    huge = sm.lonlat_to_directions(np.array([[1e16, 5], [-1e17, 1e18], [1e300, -1e308]]))
    assert np.allclose(np.linalg.norm(huge, axis=-1), 1, atol=1e-15)  # products of two, rounded


def test_they_are_those_of_the_latlong_image_and_of_healpix():
    shape = (6, 12)
    rows, columns = np.indices(shape)
    want = np.stack([(columns + 0.5) * 30 - 180, 90 - (rows + 0.5) * 30], axis=-1)
    lonlat = sm.directions_to_lonlat(sm.directions("latlong", shape))
    assert np.allclose(lonlat, want, rtol=1e-12)  # a few roundings
    nside = 4
    pixels = np.arange(sm.healpix.nside2npix(nside))
    lon, lat = sm.healpix.pix2ang(nside, pixels, lonlat=True)
    ours = sm.directions_to_lonlat(sm.healpix.pix2vec(nside, pixels), world=EARTH)
    assert np.allclose(ours[:, 0] % 360, lon, atol=1e-9)  # degrees, of some roundings
    assert np.allclose(ours[:, 1], lat, atol=1e-9)  # as above


def test_hard_directions_and_errors_of_longitude():
    assert sm.directions_to_lonlat([0, 9, 0]).tolist() == [0, 90]
    assert sm.directions_to_lonlat([-0.0, -0.0, -1e-300]).tolist() == [0, 0]
    huge = sm.directions_to_lonlat([1e308, 1e308, -1e308])
    assert np.allclose(huge, [45, np.degrees(np.arctan(np.sqrt(0.5)))])  # arctangents
    for bad in ([0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 1]):
        assert np.isnan(sm.directions_to_lonlat(bad)).all()
    for bad in ([np.nan, 0], [0, np.inf]):
        assert np.isnan(sm.lonlat_to_directions(bad)).all()
    assert_same_bits(sm.lonlat_to_directions(np.empty((0, 2))), np.empty((0, 3)))
    with pytest.raises(ValueError, match=r"shape \(\.\.\., 2\), got \(3,\)"):
        sm.lonlat_to_directions([1, 2, 3])
    with pytest.raises(ValueError, match=r"world|axes"):
        sm.directions_to_lonlat([0, 0, 1], world="north")
    with pytest.raises(TypeError, match="Expected `degrees` to be a bool"):
        sm.directions_to_lonlat([0, 0, 1], degrees=1)


def test_points_of_any_distance_are_seen():
    for distance in (5e-324, 1e-170, 1e-150, 1.0, 1e154, 1e160, 1e308):
        got = sm.points_to_depth([[0, 0, -distance]], "perspective", 1)
        # The length is the largest component, once more multiplied by 1.
        assert got.tolist() == [[distance]]
    two = np.array([[0, 3e-200, -4e-200], [0, 0, 0]])
    # A square root, a quotient and a product: some ε.
    assert sm.points_to_depth(two, "octahedral", 4).max() == pytest.approx(5e-200, rel=1e-15)
    for fill in ([5.0], np.array([5.0]), np.array(5)):
        assert sm.points_to_depth(two[1:], "latlong", 2, fill=fill).tolist() == [[5.0] * 4] * 2
    with pytest.raises(TypeError, match="`fill` to be a number, got an array"):
        sm.points_to_depth(two, "latlong", 2, fill=np.ones(2))
