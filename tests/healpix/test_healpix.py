"""HEALPix pixel numbers against healpy and cdshealpix, and maps as images."""

from __future__ import annotations

import astropy.units as u
import cdshealpix.nested
import cdshealpix.ring
import healpy
import numpy as np
import pytest
import reference
import spheremap as sm
from astropy.coordinates import Latitude, Longitude
from conftest import assert_same_bits, random_directions
from hypothesis import given
from hypothesis import strategies as st
from spheremap import _core, healpix

ALL = [1, 2, 3, 4, 5, 7, 8, 13, 16, 32, 33, 64]
FINEST = 1 << 29
# Vectors: healpy's sine and cosine err by some units of 2e-16, and so do ours.
VECTORS = 4e-15


def is_power(n: int) -> bool:
    return n & (n - 1) == 0


def orders(n: int) -> list[bool]:
    return [False, True] if is_power(n) else [False]


def near_a_border(n: int, d: np.ndarray, within: float) -> np.ndarray:
    """Tell directions so near, in radians, to a border between pixels of nside n.

    A pixel is a square in the face's u and v, whose unit is at most 2 rad, by the reference.
    """
    uv = reference.make("healpix").encode(d)[..., :2] * n
    return np.any(np.abs(uv - np.round(uv)) < 2 * n * within, axis=-1)


@pytest.mark.parametrize("n", ALL)
def test_every_pixel_equals_healpy(n):
    pixels = np.arange(healpix.nside2npix(n))
    for nest in orders(n):
        d = np.stack(healpy.pix2vec(n, pixels, nest=nest), -1)
        ours = healpix.pix2vec(n, pixels, nest=nest)
        np.testing.assert_allclose(ours, d, rtol=0, atol=VECTORS)
        for directions in (d, ours, 1e-200 * ours, 7e150 * ours):
            assert np.array_equal(healpix.vec2pix(n, directions, nest=nest), pixels)
        if n > 1:
            # In float32 a center moves by 1e-7, far less than half a pixel.
            assert np.array_equal(healpix.vec2pix(n, d.astype(np.float32), nest=nest), pixels)
        theta, phi = healpy.pix2ang(n, pixels, nest=nest)
        assert np.array_equal(healpix.ang2pix(n, theta, phi, nest=nest), pixels)
        # Angles up to 2π have units of 9e-16: healpy's and ours err by some of them.
        np.testing.assert_allclose(
            healpix.pix2ang(n, pixels, nest=nest), (theta, phi), rtol=0, atol=4e-15
        )
        lonlat = healpy.pix2ang(n, pixels, nest=nest, lonlat=True)
        assert np.array_equal(healpix.ang2pix(n, *lonlat, nest=nest, lonlat=True), pixels)
        got = healpix.pix2ang(n, pixels, nest=nest, lonlat=True)
        # Degrees up to 360 have units of 6e-14: three of them.
        np.testing.assert_allclose(got, lonlat, rtol=0, atol=2e-13)
    if is_power(n):
        assert np.array_equal(healpix.nest2ring(n, pixels), healpy.nest2ring(n, pixels))
        assert np.array_equal(healpix.ring2nest(n, pixels), healpy.ring2nest(n, pixels))


@pytest.mark.parametrize("n", [n for n in ALL if is_power(n)])
def test_every_pixel_equals_cdshealpix(n):
    depth = n.bit_length() - 1
    pixels = np.arange(healpix.nside2npix(n))
    lon, lat = cdshealpix.nested.healpix_to_lonlat(pixels, depth)
    ours = healpix.pix2ang(n, pixels, nest=True, lonlat=True)
    # Degrees up to 360 have units of 6e-14: three of ours and as many of cdshealpix'.
    np.testing.assert_allclose(ours, (lon.deg, lat.deg), rtol=0, atol=4e-13)
    got = healpix.ang2pix(n, lon.deg, lat.deg, nest=True, lonlat=True)
    assert np.array_equal(got, pixels)
    ring = cdshealpix.to_ring(pixels, depth).astype(np.int64)
    assert np.array_equal(healpix.nest2ring(n, pixels), ring)


def compare_random(n: int, count: int, seed: int) -> None:
    d = random_directions(count, seed)
    pixels = np.random.default_rng(seed).integers(0, 12 * n * n, count)
    for nest in orders(n):
        got = healpix.vec2pix(n, d, nest=nest)
        differs = got != healpy.vec2pix(n, *d.T, nest=nest)
        # Both round: only beside a border may they disagree.
        assert near_a_border(n, d[differs], 8e-15).all(), np.count_nonzero(differs)
        assert np.count_nonzero(differs) <= 1e-5 * count + 1
        centers = healpix.pix2vec(n, pixels, nest=nest)
        theirs = np.stack(healpy.pix2vec(n, pixels, nest=nest), -1)
        np.testing.assert_allclose(centers, theirs, rtol=0, atol=VECTORS)
        assert np.array_equal(healpix.vec2pix(n, centers, nest=nest), pixels)
    if is_power(n):
        assert np.array_equal(healpix.nest2ring(n, pixels), healpy.nest2ring(n, pixels))
        assert np.array_equal(healpix.ring2nest(n, pixels), healpy.ring2nest(n, pixels))
        depth = n.bit_length() - 1
        ring = cdshealpix.to_ring(pixels, depth).astype(np.int64)
        assert np.array_equal(healpix.nest2ring(n, pixels), ring)
        lon, lat = np.degrees(np.arctan2(d[:, 1], d[:, 0])), np.degrees(np.arcsin(d[:, 2]))
        got = healpix.ang2pix(n, lon, lat, nest=True, lonlat=True)
        theirs = cdshealpix.nested.lonlat_to_healpix(
            Longitude(lon, u.deg), Latitude(lat, u.deg), depth
        ).astype(np.int64)
        differs = got != theirs
        # cdshealpix takes sines of the latitude: near a pole its last bits are some units wider.
        assert np.count_nonzero(differs) <= 1e-5 * count + 1
        assert near_a_border(n, d[differs], 1e-14).all()


@pytest.mark.parametrize("n", [3, 1000, 1 << 14, 12_345_677, FINEST])
def test_random_directions_and_pixels(n):
    compare_random(n, 50_000, n % 1000)


@pytest.mark.slow
@pytest.mark.parametrize("n", [1024, 1 << 20, FINEST])
def test_ten_million_directions_and_pixels(n):
    for part in range(10):
        compare_random(n, 1_000_000, part)


@given(st.integers(1, FINEST), st.lists(st.floats(0, 1), min_size=1, max_size=40))
def test_rings_of_any_nside_come_back(n, shares):
    last = 12 * n * n - 1
    cap = 2 * n * (n - 1)
    pixels = [round(x * last) for x in shares]
    # The ends of the rings where the formulas change.
    pixels += [
        0,
        last,
        max(cap - 1, 0),
        cap,
        cap + 4 * n - 1,
        last - cap,
        min(last - cap + 1, last),
    ]
    pixels = np.array(pixels).clip(0, last)
    assert np.array_equal(healpix.vec2pix(n, healpix.pix2vec(n, pixels)), pixels)


@given(st.integers(0, 29), st.lists(st.floats(0, 1), min_size=1, max_size=40))
def test_orders_are_inverse(order, shares):
    n = 1 << order
    last = 12 * n * n - 1
    # Beyond 2⁵³ the product of floats may round up to one pixel too many.
    pixels = np.array([min(round(x * last), last) for x in shares])
    assert np.array_equal(healpix.ring2nest(n, healpix.nest2ring(n, pixels)), pixels)
    assert np.array_equal(healpix.nest2ring(n, healpix.ring2nest(n, pixels)), pixels)


def test_what_has_no_pixel():
    bad = [[0, 0, 0], [np.nan, 0, 1], [0, np.inf, 0], [-0.0, 0, -0.0]]
    assert healpix.vec2pix(8, bad).tolist() == [-1] * 4
    for nest in (False, True):
        assert np.isnan(healpix.pix2vec(4, [-1, 192, 1 << 62, -(1 << 62)], nest=nest)).all()
    assert healpix.nest2ring(4, [-1, 192]).tolist() == [-1, -1]
    assert healpix.ring2nest(4, np.array([1 << 63, 5], np.uint64)).tolist()[0] == -1
    assert healpix.ang2pix(4, [np.inf, np.nan, 1], [0, 0, np.inf]).tolist() == [-1] * 3


def test_polar_angles_have_a_range():
    for theta in (-0.1, 3.2, 90.0, -2e-5):
        with pytest.raises(ValueError, match="`theta` must be from 0 to π, got "):
            healpix.ang2pix(4, [1.0, theta], 0.0)
        with pytest.raises(ValueError, match="THETA is out of range"):
            healpy.ang2pix(4, theta, 0.0)
    for latitude in (90.1, -90.1):
        with pytest.raises(ValueError, match="`latitude` must be from -90 to 90 degrees, got "):
            healpix.ang2pix(4, 0.0, latitude, lonlat=True)
    # What float32 makes of π lies beyond it.
    assert healpix.ang2pix(4, np.float32(np.pi), 0.1) == healpy.ang2pix(4, np.pi, 0.1)
    assert healpix.ang2pix(4, -1e-9, 0.1) == 0
    assert healpix.ang2pix(4, [np.nan, -1e-9], 0.1).tolist() == [-1, 0]


def test_arrays_of_nside_equal_healpy():
    rng = np.random.default_rng(11)
    sides = 2 ** rng.integers(0, 30, (5, 1))
    theta, phi = np.arccos(rng.uniform(-1, 1, 40)), rng.uniform(0, 7, 40)
    d = healpy.ang2vec(theta, phi)
    for nest in (False, True):
        pixels = healpix.ang2pix(sides, theta, phi, nest)
        assert np.array_equal(pixels, healpy.ang2pix(sides, theta, phi, nest))
        assert np.array_equal(pixels, healpix.vec2pix(sides, d, nest))
        want = np.stack(healpy.pix2vec(sides, pixels, nest), -1)
        np.testing.assert_allclose(healpix.pix2vec(sides, pixels, nest), want, rtol=0, atol=VECTORS)
        got, want = healpix.pix2ang(sides, pixels, nest), healpy.pix2ang(sides, pixels, nest)
        # Angles up to 2π have units of 9e-16: some of them.
        np.testing.assert_allclose(got, want, rtol=0, atol=4e-15)
    assert np.array_equal(healpix.nest2ring(sides, pixels), healpy.nest2ring(sides, pixels))
    assert np.array_equal(healpix.ring2nest(sides, pixels), healpy.ring2nest(sides, pixels))
    sides = sides.ravel()
    assert np.array_equal(healpix.nside2npix(sides), healpy.nside2npix(sides))
    assert np.array_equal(healpix.npix2nside(healpix.nside2npix(sides)), sides)
    for degrees in (False, True):
        want = healpy.nside2pixarea(sides, degrees)
        # Some products: one rounding each.
        np.testing.assert_allclose(healpix.nside2pixarea(sides, degrees), want, rtol=1e-15)
        want = healpy.nside2resol(sides, degrees)
        # And a root.
        np.testing.assert_allclose(healpix.nside2resol(sides, degrees), want, rtol=1e-15)
    with pytest.raises(TypeError, match="Expected `nside` to be integers, got dtype float64"):
        healpix.ang2pix([1.5, 2], 0.0, 0.0)
    with pytest.raises(ValueError, match="`nside` must be from 1 to 536870912, got 0"):
        healpix.nside2npix([4, 0])
    with pytest.raises(ValueError, match="`out` needs one `nside`"):
        healpix.pix2vec([1, 2], [0, 0], out=np.empty((2, 3)))
    with pytest.raises(TypeError, match="Expected `nest` to be a bool, got float"):
        healpix.ang2pix(64, 0.1, 0.2, 1.0)


def test_signs_of_zeros_do_not_count():
    for nest in (False, True):
        for n in (1, 4, 64):
            for d in ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]):
                signed = [[c if c else s * 0.0 for c in d] for s in (1.0, -1.0)]
                a, b = healpix.vec2pix(n, signed, nest=nest)
                assert a == b == healpy.vec2pix(n, *d, nest=nest)


def test_same_bits_on_every_level_and_thread_count():
    d = random_directions(1 << 18, 3)
    want = {}
    for level in _core.simd_levels():
        _core.set_simd_level(level)
        for threads in (1, 2):
            sm.set_num_threads(threads)
            for nest in (False, True):
                pixels = healpix.vec2pix(1 << 12, d, nest=nest)
                results = [
                    pixels,
                    healpix.vec2pix(1 << 12, d.astype(np.float32), nest=nest),
                    healpix.pix2vec(1 << 12, pixels, nest=nest),
                    *healpix.pix2ang(1 << 12, pixels, nest=nest),
                    healpix.ang2pix(1 << 12, d[:, 0] ** 2, d[:, 1], nest=nest),
                    _core.healpix_reorder(1 << 12, pixels, nest=nest),
                    healpix.neighbors(1 << 12, pixels, nest=nest),
                    *healpix.interpolation_weights(1 << 12, d[:, 0] ** 2, d[:, 1], nest=nest),
                ]
                for k, result in enumerate(results):
                    assert_same_bits(result, want.setdefault((nest, k), result), level)


def test_shapes_types_and_out():
    d = random_directions(24, 5).reshape(2, 3, 4, 3)
    pixels = healpix.vec2pix(16, d)
    assert pixels.shape == (2, 3, 4) and pixels.dtype == np.int64
    assert np.array_equal(healpix.vec2pix(16, d[::-1, :, ::2]), pixels[::-1, :, ::2])
    assert healpix.pix2vec(16, pixels).shape == d.shape
    assert np.array_equal(
        healpix.pix2vec(16, pixels[::-1, :, ::2].astype(np.int16)),
        healpix.pix2vec(16, pixels)[::-1, :, ::2],
    )
    assert healpix.vec2pix(16, np.empty((0, 3))).shape == (0,)
    assert healpix.pix2vec(16, []).shape == (0, 3)
    out = np.empty((2, 3, 4), np.int64)
    assert healpix.vec2pix(16, d, out=out) is out and np.array_equal(out, pixels)
    assert healpix.ang2pix(4, np.ones((3, 1)), np.zeros(5)).shape == (3, 5)
    with pytest.raises(ValueError, match="overlaps"):
        healpix.nest2ring(16, out, out=out)
    with pytest.raises(ValueError, match=r"shape \(2,\), got \(2, 3, 4\)"):
        healpix.nest2ring(16, [0, 1], out=out)


def test_errors_read():
    with pytest.raises(ValueError, match="`nside` must be from 1 to 536870912, got 0"):
        healpix.vec2pix(0, [1, 0, 0])
    with pytest.raises(ValueError, match="power of two in nested order, got 3"):
        healpix.vec2pix(3, [1, 0, 0], nest=True)
    with pytest.raises(ValueError, match="power of two"):
        healpix.ring2nest(3, 0)
    with pytest.raises(TypeError, match="`nside` must be an integer, got float"):
        healpix.vec2pix(2.0, [1, 0, 0])
    with pytest.raises(ValueError, match=r"shape \(..., 3\), got \(2,\)"):
        healpix.vec2pix(2, [1, 0])
    with pytest.raises(TypeError, match="Expected `pixels` to be integers, got dtype float64"):
        healpix.pix2vec(2, [1.5])
    with pytest.raises(TypeError, match="real numbers"):
        healpix.vec2pix(2, [1j, 0, 0])
    with pytest.raises(ValueError, match="12 nside² pixels, got 13"):
        healpix.npix2nside(13)
    with pytest.raises(ValueError, match=r"\(12, nside, nside\).*got \(6, 4, 4\)"):
        healpix.from_image(np.zeros((6, 4, 4)))
    with pytest.raises(ValueError, match="`step` must be from 1 to 536870912, got 0"):
        healpix.boundaries(1, 0, step=0)


@pytest.mark.parametrize("n", [1, 2, 3, 8])
def test_texels_of_the_projection_are_pixels(n):
    d = sm.directions("healpix", n)
    assert d.shape == (12, n, n, 3)
    for nest in orders(n):
        values = np.arange(12 * n * n)
        image = healpix.to_image(values, nest=nest)
        assert np.array_equal(image, healpix.vec2pix(n, d, nest=nest))
        assert np.array_equal(healpix.from_image(image, nest=nest), values)
        if nest:
            assert np.array_equal(healpix.from_image(image), healpy.reorder(values, n2r=True))
            assert np.array_equal(
                healpix.reorder(values, nest=True), healpy.reorder(values, n2r=True)
            )
    # A constant density times a texel's area: some ε.
    np.testing.assert_allclose(sm.solid_angle("healpix", n), healpix.nside2pixarea(n), rtol=1e-13)


@pytest.mark.parametrize("step", [1, 3])
def test_boundaries_equal_healpy(step):
    for n in (1, 4, 5):
        for nest in orders(n):
            pixels = np.arange(12 * n * n)
            want = healpy.boundaries(n, pixels, step=step, nest=nest)
            got = healpix.boundaries(n, pixels, step=step, nest=nest)
            np.testing.assert_allclose(got, np.moveaxis(want, 1, 2), rtol=0, atol=VECTORS)
    assert np.isnan(healpix.boundaries(4, -1)).all()


def test_areas():
    for n in (1, 3, 64):
        assert healpix.nside2npix(n) == healpy.nside2npix(n)
        # 4π over a whole number, and its root: one rounding or two.
        assert np.isclose(healpix.nside2pixarea(n), healpy.nside2pixarea(n), rtol=1e-15)
        assert np.isclose(healpix.nside2resol(n), healpy.nside2resol(n), rtol=1e-15)
        assert healpix.npix2nside(12 * n * n) == n


@pytest.mark.parametrize("interpolation", ["bilinear", "bicubic"])
def test_lookups_are_smooth_across_every_edge_and_vertex(interpolation):
    """A smooth function comes back from its texels, beside edges as elsewhere."""
    errors = []
    rng = np.random.default_rng(0)
    edge = rng.random((4000, 2))
    edge[:, 0] = np.where(rng.random(4000) < 0.5, 0.0, 1.0)
    edge = np.where(rng.random((4000, 1)) < 0.5, edge, edge[:, ::-1])
    face = rng.integers(0, 12, (4000, 1))
    d = sm.decode(np.concatenate([edge, face], -1), "healpix")
    d = d + rng.normal(size=d.shape) * 1e-3
    for n in (16, 32, 64):
        image = reference.smooth_function(sm.directions("healpix", n))
        got = sm.sample(image, d, "healpix", filter=interpolation)
        errors.append(
            np.abs(
                got - reference.smooth_function(d / np.linalg.norm(d, axis=-1, keepdims=True))
            ).max()
        )
    # It is worst at vertices of three faces; twice the texels are at least 1.8 times nearer there.
    assert errors[1] < errors[0] / 1.8 and errors[2] < errors[1] / 1.8
    assert errors[2] < 0.02


def test_bilinear_lookups_are_continuous_across_edges():
    rng = np.random.default_rng(1)
    image = rng.random((12, 7, 7))
    count = 3000
    along = rng.random(count)
    for axis, end in ((0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)):
        uv = np.empty((count, 3))
        uv[:, axis], uv[:, 1 - axis] = end, along
        uv[:, 2] = rng.integers(0, 12, count)
        d = sm.decode(uv, "healpix")
        step = rng.normal(size=d.shape) * 1e-10
        a, b = (sm.sample(image, x, "healpix", filter="bilinear") for x in (d + step, d - step))
        # Values within 1 of each other over a texel of 0.15 rad: 2e-10 changes them by 4e-9.
        assert np.abs(a - b).max() < 1e-8


def test_a_map_becomes_a_latlong_as_healpy_shows_it():
    n = 64
    values = np.arange(12.0 * n * n) % 1009
    projector = healpy.projector.CartesianProj(xsize=80, ysize=40, flipconv="astro")
    want = projector.projmap(values, lambda x, y, z: healpy.vec2pix(n, x, y, z))
    # Its grid is of corners, row 0 at the bottom: directions of its own places are compared.
    x, y = projector.ij2xy()
    theirs = np.stack(projector.xy2vec(x, y), -1)
    sky = sm.projection("latlong", axes="-y -z +x")
    # Its x runs with the columns: to the right, westward.
    uv = np.ma.filled(np.ma.stack([(180 + x) / 360, (90 - y) / 180], -1), np.nan)
    # Degrees up to 360 round by 6e-14, which are 1e-15 rad: some of them, here and there.
    np.testing.assert_allclose(sm.decode(uv, sky), theirs, atol=1e-12)
    got = sm.sample(healpix.to_image(values), theirs, "healpix", filter="nearest")
    same = np.asarray(got) == np.asarray(want)
    # Places on borders between pixels may go to either.
    assert same[~near_a_border(n, theirs, 1e-12)].all()
