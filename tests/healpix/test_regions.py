"""Discs, polygons, neighbors and weights, number for number against healpy."""

from __future__ import annotations

import healpy
import numpy as np
import pytest
from conftest import random_directions, some_fast
from spheremap import healpix


def orders(n: int) -> list[bool]:
    return [False, True] if n & (n - 1) == 0 else [False]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 16, 33])
def test_every_neighbor_equals_healpy(n):
    pixels = np.arange(12 * n * n)
    for nest in orders(n):
        want = healpy.get_all_neighbours(n, pixels, nest=nest)
        assert np.array_equal(healpix.neighbors(n, pixels, nest), want.T)


def test_neighbors_of_the_finest_pixels():
    n = 1 << 29
    pixels = np.random.default_rng(0).integers(0, 12 * n * n, 1000)
    for nest in (False, True):
        want = healpy.get_all_neighbours(n, pixels, nest=nest)
        assert np.array_equal(healpix.neighbors(n, pixels, nest), want.T)
    assert healpix.neighbors(4, [-1, 192]).tolist() == [[-1] * 8] * 2
    assert healpix.neighbors(4, np.zeros((2, 3), int)).shape == (2, 3, 8)


CENTERS = np.concatenate(
    [
        random_directions(12, 8),
        [[0, 0, 1], [0, 0, -1], [1e-9, 0, 1], [0.01, 0.02, -1], [-1, 1.5e-6, 0]],
    ]
)


@some_fast("n", [1, 2, 8, 31, 64], fast=(1, 2, 8, 31))
@pytest.mark.parametrize("radius", [0.0, 1e-6, 0.01, 0.07, 0.4, 1.3, 1.7, 3.0, np.pi])
@pytest.mark.parametrize("inclusive", [False, True])
def test_discs_equal_healpy(n, radius, inclusive):
    for nest in orders(n):
        for d in CENTERS:
            if inclusive and radius == 0 and abs(d[0]) < 1e-8:
                # Four pixels meet at a pole, whose base pixels' centers are just as far from it as
                # the farthest corner of any: healpy finds some of them or none, as rounding has it.
                found = healpix.query_disc(n, d, radius, True, 4, nest)
                assert healpix.vec2pix(n, d, nest) in found and len(found) <= 12
                assert d[0] or len(found) >= 4
                continue
            got = healpix.query_disc(n, d, radius, inclusive, 4, nest)
            want = healpy.query_disc(n, d, radius, inclusive=inclusive, fact=4, nest=nest)
            assert np.array_equal(got, want), (d, nest)


@pytest.mark.parametrize("fact", [1, 2, 8])
def test_discs_as_closely_as_asked(fact):
    for d in CENTERS:
        got = healpix.query_disc(16, d, 0.2, True, fact)
        assert np.array_equal(got, healpy.query_disc(16, d, 0.2, inclusive=True, fact=fact))


def test_small_discs_of_the_finest_pixels():
    n = 1 << 29
    for d in CENTERS[:8]:
        radius = 4 * healpix.nside2resol(n)
        got = healpix.query_disc(n, d, radius, nest=True)
        # healpy loses such a disc in rounding: by area it has 16 π pixels, give or take its rim.
        assert abs(len(got) - 50) < 20
        centers = healpix.pix2vec(n, got, True)
        # Vectors err by some 1e-16, pixels are 2e-9 wide.
        assert np.linalg.norm(centers - d, axis=-1).max() < radius + 1e-15
        around = np.setdiff1d(healpix.neighbors(n, got, True), got)
        others = np.linalg.norm(healpix.pix2vec(n, around, True) - d, axis=-1)
        # As above.
        assert others.min() > radius - 1e-15


def polygons():
    rng = np.random.default_rng(5)
    for d in random_directions(12, 6):
        for corners in (3, 4, 7):
            angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
            # On a circle around d, they make a convex polygon.
            across = np.cross(d, [0.3, 0.5, -0.8])
            across /= np.linalg.norm(across)
            third = np.cross(d, across)
            size = rng.uniform(0.05, 1.0)
            ring = np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * third
            yield np.cos(size) * d + np.sin(size) * ring


def met_by(n, vertices):
    """Return pixels that hold points of a polygon."""
    share = np.random.default_rng(6).dirichlet(np.ones(len(vertices)), 5000)
    return np.unique(healpix.vec2pix(n, np.concatenate([share @ vertices, vertices])))


@some_fast("n", [2, 4, 31, 64], fast=(2, 4, 31))
@pytest.mark.parametrize("inclusive", [False, True])
def test_polygons_equal_healpy(n, inclusive):
    for nest in orders(n):
        for k, vertices in enumerate(polygons()):
            want = healpy.query_polygon(n, vertices, inclusive=inclusive, nest=nest)
            for given in (vertices, vertices[::-1]):
                got = healpix.query_polygon(n, given, inclusive, nest=nest)
                if nest or not inclusive:
                    assert np.array_equal(got, np.sort(want)), (k, nest)
                    continue
                # In ring order healpy has more, far from the polygon, too.
                assert np.isin(got, want).all()
                assert np.isin(met_by(n, vertices), got).all()


def test_what_is_no_region():
    with pytest.raises(ValueError, match="convex polygon"):
        healpix.query_polygon(8, [[1, 0, 0], [1, 0.5, 0], [1, 0.1, 0.1], [1, 0, 0.5]])
    with pytest.raises(ValueError, match="neighboring `vertices` to differ"):
        healpix.query_polygon(8, [[1, 0, 0], [1, 0, 0], [0, 0, 1]])
    with pytest.raises(ValueError, match=r"\(V, 3\), V at least 3"):
        healpix.query_polygon(8, [[1, 0, 0], [0, 1, 0]])
    with pytest.raises(ValueError, match="`radius` must be from 0 to π, got 4"):
        healpix.query_disc(8, [1, 0, 0], 4)
    with pytest.raises(ValueError, match=r"shape \(3,\), got \(2, 3\)"):
        healpix.query_disc(8, np.ones((2, 3)), 1)
    with pytest.raises(ValueError, match="finite and not zero"):
        healpix.query_disc(8, [0, 0, 0], 1)
    with pytest.raises(ValueError, match="power of two in nested order, got 3"):
        healpix.query_disc(3, [1, 0, 0], 1, nest=True)
    with pytest.raises(ValueError, match="`fact` must be a power of two"):
        healpix.query_disc(4, [1, 0, 0], 1, True, 3, True)
    with pytest.raises(ValueError, match="`fact` must be from 1 to"):
        healpix.query_disc(4, [1, 0, 0], 1, True, 0)


@pytest.mark.parametrize("n", [1, 2, 3, 16, 64, 1 << 20])
def test_interpolation_weights_equal_healpy(n):
    rng = np.random.default_rng(7)
    theta = np.concatenate([np.arccos(rng.uniform(-1, 1, 2000)), [0, np.pi, 1e-7, 3.14, 0.01]])
    phi = rng.uniform(-7, 14, theta.size)
    for nest in orders(n):
        pixels, weights = healpix.interpolation_weights(n, theta, phi, nest)
        want, theirs = healpy.get_interp_weights(n, theta, phi, nest=nest)
        # A sum over pixels: pairs may be named in another order where a weight is 0. healpy's polar
        # angle rounds by some 1e-16, and rings are 1/n apart.
        near = 1e-14 * max(n, 100)
        order, other = np.argsort(pixels, -1), np.argsort(want.T, -1)
        a, b = np.take_along_axis(weights, order, -1), np.take_along_axis(theirs.T, other, -1)
        same = (np.sort(pixels, -1) == np.sort(want.T, -1)).all(-1)
        assert np.abs(a - b)[same].max() < near
        assert np.abs(weights[~same]).min(-1).max(initial=0) < near
        assert (~same).sum() <= 2
        # Sums of four: some ε.
        np.testing.assert_allclose(weights.sum(-1), 1, rtol=1e-15)
    lon, lat = np.degrees(phi), 90 - np.degrees(theta)
    again = healpix.interpolation_weights(n, lon, lat, lonlat=True)
    assert again[0].shape == (theta.size, 4)


def test_interpolation_where_there_is_no_place():
    pixels, weights = healpix.interpolation_weights(4, [np.nan, 1.0], 0.0)
    assert pixels[0].tolist() == [-1] * 4 and np.isnan(weights[0]).all() and pixels[1].min() >= 0
    for turn in (1e16, -1e300, np.inf):
        pixels, weights = healpix.interpolation_weights(4, 1.0, turn, nest=True)
        assert pixels.tolist() == [-1] * 4 and np.isnan(weights).all()
    # What float32 makes of π is the pole, also beside a place that is none.
    pixels, weights = healpix.interpolation_weights(4, np.float32([np.pi, 1, 2]), [0, np.nan, 1])
    assert sorted(pixels[0].tolist()) == [188, 189, 190, 191] and (weights[0] == 0.25).all()
    assert pixels[1].max() == -1 and pixels[2].min() >= 0
    with pytest.raises(ValueError, match=r"`theta` must be from 0 to π, got 3\.2"):
        healpix.interpolation_weights(4, 3.2, 0)
    with pytest.raises(ValueError, match="`latitude` must be from -90 to 90 degrees, got -91"):
        healpix.interpolation_weights(4, 0, -91, lonlat=True)
