"""Importance sampling: the density sums to 1, samples follow it, and bad input has an answer."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import (
    CASES,
    DEFAULTS,
    LAYOUTS,
    PARAMETERS,
    assert_same_bits,
    assert_same_bits_everywhere,
    each,
    random_directions,
    some_fast,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from spheremap import _core

REC709 = np.array([0.2126, 0.7152, 0.0722])
# Densities are kept in float32: off by 6e-8, and by as much again in what is divided by them.
SINGLE = 1e-6
# Axes only change the frame of directions: one case each for a cyclic and a mirrored frame will do.
SHAPES = [c for c in CASES if "axes" not in c.options]
# Their tables of densities take a third of a second and more, of whatever image.
HEAVY = (
    *("tetrahedral", "icosahedral", "camera_unified"),
    *("camera_thin_prism_fisheye", "camera_rad_tan_thin_prism_fisheye"),
)
each_light_map = each(DEFAULTS, slow=[c for c in DEFAULTS if c.name in HEAVY])


def image_of(p: sm.Projection, n: int, seed: int = 0, channels: int = 3) -> np.ndarray:
    """Light that varies over four decades, as a sky does."""
    rng = np.random.default_rng(seed)
    return 10.0 ** rng.uniform(-2, 2, (*p.shape(n), channels))


def numbers(n: int, seed: int, dtype=np.float64) -> np.ndarray:
    return np.random.default_rng(seed).random((n, 2), dtype)


def smallest(case) -> int:
    """Two texels a side, but for grids that put texels on the corners of tiny faces."""
    return 3 if case.make().grid != "centers" else 2


def inside_texels(p: sm.Projection, n: int) -> np.ndarray:
    """A direction in each texel: of its center, or beside it where that is on a pole or a seam."""
    if p.grid == "centers":
        return p.directions(n)
    rows, columns = p.shape(n)
    # Each cell of a layout is an image of its own, with texels on its corners.
    down, across = (1, 1) if p.layout is None else (rows // n, columns // n)
    height, width = rows // down, columns // across
    v = np.clip(np.linspace(0, 1, height), 1e-3, 1 - 1e-3)
    u = np.linspace(0, 1, width) if p.grid == "corners" else (np.arange(width) + 0.5) / width
    u = np.clip(u, 1e-3, 1 - 1e-3)
    v = (np.arange(down)[:, None] + v).ravel() / down
    u = (np.arange(across)[:, None] + u).ravel() / across
    return p.decode(np.stack(np.meshgrid(u, v), -1))


@each(SHAPES, slow=[c for c in SHAPES if c in PARAMETERS])
def test_the_density_integrates_to_one(case):
    p = case.make()
    n = smallest(case)
    dist = sm.light.Distribution(image_of(p, n), p)
    # It is constant within a texel, so its integral is a sum over texels.
    total = np.nansum(dist.pdf(inside_texels(p, n)) * _core.texel_weights(p, n))
    # Each texel's density is float32, off by 6e-8 at most, and so is their sum.
    assert total == pytest.approx(1, abs=1e-6)


@each(LAYOUTS, slow=[c for c in LAYOUTS if c.name in HEAVY])
def test_it_is_luminance_over_its_integral(case):
    p = case.make()
    image = image_of(p, 6)
    dist = sm.light.Distribution(image, p)
    luminance, weight = image @ REC709, _core.texel_weights(p, 6)
    integral = np.sum(luminance * weight)
    # The same solid angles, of parts of texels instead of whole ones, summed in other orders.
    assert dist.integral == pytest.approx(integral, rel=1e-12)
    held = weight > 0
    # float32 tables: half a unit in the last place.
    np.testing.assert_allclose(dist.pdf(p.directions(6))[held], luminance[held] / integral, 1e-7)


@each_light_map
@some_fast("n", [1, 2, 7, 40], fast=(7,))
def test_pdf_of_a_sample_is_the_pdf_there(case, n):
    p = case.make()
    dist = sm.light.Distribution(image_of(p, n), p)
    d, pdf = dist.sample(numbers(3000, 1))
    # Three squares of a unit vector round by some ε.
    assert np.abs((d * d).sum(-1) - 1).max() < 1e-14
    # The same float32 entry, by drawing and by lookup.
    np.testing.assert_allclose(dist.pdf(d), pdf, rtol=1e-5)
    single, pdf32 = dist.sample(numbers(3000, 1, np.float32))
    assert single.dtype == pdf32.dtype == np.float32
    # A float32 direction is off by 6e-8, which moves it across the edge of a texel of 1/40 (an
    # angle of 0.05 or so) in less than one case in 10⁵ of either side.
    assert np.mean(~np.isclose(dist.pdf(single), pdf32, rtol=1e-5)) < 2e-3


@each_light_map
def test_chi_square_within_texels(case):
    # Nine texels, and bins of a third of a texel: samples must be even inside texels too, across
    # rims, creases and poles.
    p = case.make()
    image = image_of(p, 3, channels=1)[..., 0]
    dist = sm.light.Distribution(image, p)
    d, _ = dist.sample(numbers(40_000, 2))
    axes = image.ndim - 2
    fine = np.repeat(np.repeat(image, 3, axes), 3, axes + 1)
    chi_square(p, fine, dist, d, None)


def chi_square(p, image, dist, d, rotation) -> None:
    weight = p.solid_angle(image.shape)
    uv = p.encode(d, rotation=rotation)
    size = np.array(image.shape[-2:][::-1])
    place = np.minimum((uv[..., :2] * size).astype(int), size - 1)
    index = place[:, 1] * size[0] + place[:, 0]
    if image.ndim == 3:
        index += uv[:, 2].astype(int) * image.shape[1] * image.shape[2]
    count = np.bincount(index, minlength=image.size).astype(float)
    held = np.zeros(image.size, bool)
    # The density of each bin from its middle, or from the nearest texel for a corner of the rim.
    expected = (expected_mass(p, image, weight) * len(d)).ravel()
    held = expected > 0
    assert count[~held].sum() == 0
    order = np.argsort(expected[held])
    # Bins of at least 8 expected samples.
    e, c = expected[held][order], count[held][order]
    edges = np.searchsorted(np.cumsum(e), np.arange(0, e.sum(), max(8.0, e.sum() / 400)))
    edges = np.unique(edges)
    e, c = np.add.reduceat(e, edges), np.add.reduceat(c, edges)
    e *= c.sum() / e.sum()
    # One chance in 10⁴ for each map, with fixed numbers.
    assert stats.chisquare(c, e).pvalue > 1e-4


def expected_mass(p, image, weight):
    """Luminance times solid angle; a bin across the rim has what its texel's holder has."""
    shape = tuple(n // 3 if i >= image.ndim - 2 else n for i, n in enumerate(image.shape))
    axes = image.ndim - 2
    coarse = np.take(
        np.take(image, np.arange(1, image.shape[-1], 3), -1), np.arange(1, image.shape[-2], 3), -2
    )
    outside = np.isnan(p.directions(shape)[..., 0])
    if outside.any():
        coarse = filled(coarse, outside)
    mass = np.repeat(np.repeat(coarse, 3, axes), 3, axes + 1) * weight
    return mass / mass.sum()


def filled(image, outside):
    """Give each texel outside the value of the nearest inside, first by row and column."""
    result = image.copy()
    for index in np.argwhere(outside):
        same = np.argwhere(~outside)
        if image.ndim == 3:
            same = same[same[:, 0] == index[0]]
        away = ((same[:, -2:] - index[-2:]) ** 2).sum(-1)
        result[tuple(index)] = image[tuple(same[np.argmin(away)])]
    return result


@each_light_map
@some_fast("n", [1, 5], fast=(5,))
def test_samples_are_as_dense_as_pdf_says(case, n):
    # The Jacobian of the sampling map itself: |∂d/∂ξ| is 1/pdf, to 1e-5, everywhere but across
    # the edges of cells, where it jumps.
    p = case.make()
    dist = sm.light.Distribution(image_of(p, n), p)
    xi, h = 0.001 + 0.998 * numbers(4000, 3), 1e-7
    steps = [np.array([h, 0]), np.array([0, h])]
    _, pdf = dist.sample(xi)
    ahead = [dist.sample(xi + s)[0] for s in steps]
    behind = [dist.sample(xi - s)[0] for s in steps]
    here, _ = dist.sample(xi)
    a, b = ((f - g) / (2 * h) for f, g in zip(ahead, behind, strict=True))
    area = np.linalg.norm(np.cross(a, b), axis=-1)
    one, two = ((f - here) / h for f in ahead)
    # Where forward and central differences agree to this, no edge of a cell is in the stencil.
    smooth = np.abs(np.linalg.norm(np.cross(one, two), axis=-1) * pdf - area * pdf) < 1e-4
    # Cells found by bisection are small, so more of the stencils cross their edges.
    assert smooth.mean() > 0.8
    error = np.abs(area[smooth] * pdf[smooth] - 1)
    # 1e-5, and what differences of step 1e-7 lose: the rounding of ξ over that of a cell.
    assert np.quantile(error, 0.97) < 1.2e-5


@each_light_map
def test_the_estimate_converges_on_the_integral(case):
    p = case.make()
    image = image_of(p, 12)
    dist = sm.light.Distribution(image, p)
    _, pdf, weight = dist.sample(numbers(20_000, 4), weights=True)
    assert weight.shape == (20_000, 3) and pdf.shape == (20_000,)
    want = np.tensordot(_core.texel_weights(p, 12), image, image.ndim - 1)
    spread = weight.std(0) / np.sqrt(20_000)
    assert np.all(np.abs(weight.mean(0) - want) < 5 * spread)
    # Luminance is what it samples by: every sample is the integral.
    np.testing.assert_allclose(weight @ REC709, dist.integral, rtol=SINGLE)


def test_weights_are_the_nearest_texel():
    image = image_of(sm.projection("cube"), 9)
    dist = sm.light.Distribution(image, "cube")
    d, pdf, weight = dist.sample(numbers(5000, 5), weights=True)
    texel = sm.sample(image, d, "cube", filter="nearest")
    np.testing.assert_allclose(weight * pdf[:, None], texel, rtol=SINGLE)


def test_a_low_discrepancy_set_stays_one():
    # Hammersley's points: an estimate of a smooth integral far better than that of random ones.
    n = 4096
    k = np.arange(n)
    reversed_bits = np.array([int(f"{i:012b}"[::-1], 2) for i in k]) / n
    xi = np.stack([(k + 0.5) / n, reversed_bits + 0.5 / n], axis=-1)
    p = sm.projection("latlong")
    image = 2 + reference.smooth_function(p.directions(64))[..., 0]
    dist = sm.light.Distribution(image, p)

    def error(numbers):
        d, pdf = dist.sample(numbers)
        return abs(np.mean(np.maximum(d[:, 1], 0) / pdf) - np.pi)

    random = np.mean([error(numbers(n, seed)) for seed in range(20)])
    assert error(xi) < random / 8


# --- extreme images


@each_light_map
def test_a_sun_in_one_texel(case):
    p = case.make()
    d = p.directions(20)
    held = np.argwhere(~np.isnan(d[..., 0]))
    at = tuple(held[len(held) // 3])
    image = np.zeros(p.shape(20), np.float32)
    image[at] = 3e9
    dist = sm.light.Distribution(image, p)
    got, pdf = dist.sample(numbers(500, 6))
    omega = _core.texel_weights(p, 20)[at]
    assert np.all(got @ d[at] > np.cos(4 * np.sqrt(omega)))
    np.testing.assert_allclose(pdf, 1 / omega, rtol=SINGLE)
    assert dist.pdf(-d[at]) == 0
    # On a dim sky it still gets nearly all.
    image[...] = 1
    image[at] = 3e9
    got, pdf = sm.light.Distribution(image, p).sample(numbers(500, 6))
    assert np.mean(got @ d[at] > np.cos(4 * np.sqrt(omega))) > 0.99


@each_light_map
def test_one_texel(case):
    p = case.make()
    dist = sm.light.Distribution(np.full(p.shape(1), 7.0), p)
    d, pdf = dist.sample(numbers(2000, 7))
    assert p.covers(d).all()
    np.testing.assert_allclose(pdf, 1 / p.covered_solid_angle, rtol=SINGLE)
    # Solid angles of lens maps have no closed form: good to 1e-10.
    assert dist.integral == pytest.approx(7 * p.covered_solid_angle, rel=1e-9)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@each_light_map  # one after the other, so that the second finds the tables of the first
def test_the_ends_of_the_unit_interval(case, dtype):
    p = case.make()
    image = image_of(p, 4)
    # Black first and last columns and rows: the ends belong to the cells that have light.
    image[..., 0, :, :] = 0
    image[..., -1, 0, :] = 0
    dist = sm.light.Distribution(image, p)
    one = dtype(1)
    ends = np.array([0, np.nextafter(dtype(0), one), np.nextafter(one, dtype(0)), 1], dtype)
    xi = np.stack(np.meshgrid(ends, ends), -1)
    d, pdf, weight = dist.sample(xi, weights=True)
    assert d.shape == (4, 4, 3) and d.dtype == dtype and weight.shape == (4, 4, 3)
    assert np.isfinite(d).all() and np.isfinite(weight).all() and (pdf > 0).all()
    assert p.covers(d).all()
    if dtype is np.float64:
        # The same float32 entry, by drawing and by lookup.
        np.testing.assert_allclose(dist.pdf(d), pdf, rtol=1e-5)


def test_numbers_outside_the_unit_interval_are_nan():
    dist = sm.light.Distribution(np.ones((4, 8, 3)), "latlong")
    bad = [[np.nan, 0.5], [0.5, np.nan], [-1e-9, 0.5], [0.5, 1.1], [np.inf, 0.5], [0.5, -np.inf]]
    d, pdf, weight = dist.sample([*bad, [0.5, 0.5]], weights=True)
    for result in (d[:-1], pdf[:-1], weight[:-1]):
        assert np.isnan(result).all()
    assert np.isfinite(d[-1]).all() and np.isfinite(pdf[-1])


# Not black, and far above where luminance over its integral underflows.
@given(st.lists(st.floats(0, 1e6), min_size=32, max_size=32).filter(lambda x: max(x) > 1e-3))
def test_any_image_has_a_density(values):
    image = np.reshape(values, (4, 8))
    dist = sm.light.Distribution(image, "latlong")
    d, pdf = dist.sample(numbers(200, 8))
    assert (pdf > 0).all()
    # The same float32 entry, by drawing and by lookup.
    np.testing.assert_allclose(dist.pdf(d), pdf, rtol=1e-5)
    assert (sm.sample(image, d, "latlong", filter="nearest") > 0).all()


def test_what_is_kept_of_a_map_serves_that_map_alone():
    # Faces of the same shape, with other densities; asked for in turn, and again.
    names = ("cube", "cube_equiangular", "cube:opengl", "cube_quadratic")
    image, draws = image_of(sm.projection("cube"), 4), numbers(300, 10)

    def drawn(name: str):
        return sm.light.Distribution(image, name).sample(draws)

    first = {name: drawn(name) for name in names}
    for name in reversed(names):
        for got, want in zip(drawn(name), first[name], strict=True):
            assert_same_bits(got, want)
    d = first["cube"][0]
    assert not np.array_equal(d, first["cube_equiangular"][0])


# --- frames, layouts, types


def test_rotation_and_axes_turn_the_density():
    p = sm.projection("octahedral", axes="+y +z +x")
    image = image_of(p, 8)
    turn = sm.rotation(20, 30, 40)
    dist = sm.light.Distribution(image, p, rotation=turn)
    plain = sm.light.Distribution(image, p)
    d = random_directions(500, 9)
    np.testing.assert_allclose(dist.pdf(d @ turn.T), plain.pdf(d), rtol=SINGLE)
    assert_same_bits(
        sm.light.Distribution(image, "octahedral", axes="+y +z +x").pdf(d), plain.pdf(d)
    )
    a, _ = dist.sample(numbers(100, 9))
    b, _ = plain.sample(numbers(100, 9))
    # Turned before or after: three products of numbers up to 1.
    np.testing.assert_allclose(a, b @ turn.T, atol=1e-14)
    assert dist.projection.axes == "+y +z +x" and dist.shape == (8, 8, 3)


@each([c for c in LAYOUTS if c.make().layout not in (None, "faces")])
def test_layouts_have_the_same_density(case):
    p = case.make()
    base = sm.projection(case.name)
    image = image_of(base, 5)
    flat = sm.convert(image, base, p, size=5, filter="nearest", fill=np.nan)
    d = random_directions(500, 10)
    a, b = sm.light.Distribution(flat, p), sm.light.Distribution(image, base)
    np.testing.assert_allclose(a.pdf(d), b.pdf(d), rtol=SINGLE)
    # Rows are those of faces, so that samples are the same, too.
    np.testing.assert_allclose(a.sample(numbers(99, 1))[0], b.sample(numbers(99, 1))[0], atol=1e-12)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64", ">f4"])
def test_image_types(dtype):
    values = np.random.default_rng(11).integers(1, 200, (6, 12, 3))
    dist = sm.light.Distribution(values.astype(dtype), "latlong")
    want = sm.light.Distribution(values.astype(np.float64), "latlong")
    # Whole numbers below 200 are exact in every type, and luminance is a double.
    assert dist.integral == pytest.approx(want.integral, rel=1e-7)
    view = np.repeat(values, 2, axis=1)[:, ::2][::-1].astype(np.float32)[::-1]
    # The same numbers by another stride.
    assert sm.light.Distribution(view, "latlong").integral == pytest.approx(want.integral, rel=1e-7)


def test_luminance():
    rng = np.random.default_rng(12)
    image = rng.random((6, 12, 4))
    d = random_directions(50, 12)
    rgb = sm.light.Distribution(image[..., :3], "latlong").pdf(d)
    assert_same_bits(sm.light.Distribution(image, "latlong").pdf(d), rgb)
    red = sm.light.Distribution(image, "latlong", luminance=[1, 0, 0, 0])
    assert_same_bits(red.pdf(d), sm.light.Distribution(image[..., 0], "latlong").pdf(d))
    with pytest.raises(ValueError, match=r"`luminance` must say how 2 channels"):
        sm.light.Distribution(image[..., :2], "latlong")
    with pytest.raises(ValueError, match=r"`luminance` to have shape \(4,\), got \(3,\)"):
        sm.light.Distribution(image, "latlong", luminance=[1, 1, 1])
    for bad in ([0, 0, 0, 0], [1, -1, 0, 0], [np.nan, 1, 0, 0]):
        with pytest.raises(ValueError, match="not negative"):
            sm.light.Distribution(image, "latlong", luminance=bad)


def test_mis_compensation():
    p = sm.projection("latlong")
    image = image_of(p, 16, channels=1)[..., 0]
    dist = sm.light.Distribution(image, p, compensate=True)
    weight = p.solid_angle(16)
    mean = np.sum(image * weight) / np.sum(weight)
    want = np.maximum(image - mean, 0)
    np.testing.assert_allclose(
        dist.pdf(p.directions(16)), want / np.sum(want * weight), rtol=SINGLE
    )
    _, pdf, w = dist.sample(numbers(1000, 13), weights=True)
    assert (pdf > 0).all() and np.isfinite(w).all()
    # With nothing above the mean the image itself is the density.
    flat = sm.light.Distribution(np.full((8, 16), 3.0), p, compensate=True)
    np.testing.assert_allclose(flat.pdf([0, 1, 0]), 1 / (4 * np.pi), rtol=SINGLE)


def test_outside_the_coverage():
    dist = sm.light.Distribution(np.ones((8, 8)), "hemioctahedral")
    nothing = [[0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0]]
    d = np.array([[0, 0, 1], [0, 0, -1], *nothing], float)
    for dtype in (np.float32, np.float64):
        got = dist.pdf(d.astype(dtype))
        assert got[0] > 0 and got[1] == 0 and np.isnan(got[2:]).all()


def test_length_of_a_direction_does_not_count():
    dist = sm.light.Distribution(image_of(sm.projection("latlong"), 8), "latlong")
    d = random_directions(50, 14)
    assert_same_bits(dist.pdf(d), dist.pdf(d * 2.0**60))


# --- the same bits, pickles


def test_same_bits_on_every_level_and_thread_count():
    image = image_of(sm.projection("octahedral"), 30)
    # Above the size from which calls are spread over threads.
    xi = numbers(140_000, 15, np.float32)

    def work():
        dist = sm.light.Distribution(image, "octahedral")
        drawn = dist.sample(xi, weights=True)
        return *drawn, dist.pdf(drawn[0])

    assert_same_bits_everywhere(work, threads=(1, 2, 5))


def test_pickle():
    turn = sm.rotation(1, 2, 3)
    image = image_of(sm.projection("cube"), 4).astype(np.float32)
    dist = sm.light.Distribution(
        image, "cube:vulkan", rotation=turn, luminance=[1, 2, 3], compensate=True
    )
    image[...] = 0  # it keeps a copy
    again = pickle.loads(pickle.dumps(dist))
    for a, b in zip(
        dist.sample(numbers(99, 1), weights=True),
        again.sample(numbers(99, 1), weights=True),
        strict=True,
    ):
        assert_same_bits(a, b)
    assert "cube" in repr(again)


# --- bad input


def test_black_negative_and_not_finite_images():
    image = np.ones((4, 8, 3))
    with pytest.raises(ValueError, match="the image is black"):
        sm.light.Distribution(image * 0, "latlong")
    image[1, 2, 0] = -3
    with pytest.raises(ValueError, match=r"1 negative value, at \(1, 2, 0\); `negative=\"clip\"`"):
        sm.light.Distribution(image, "latlong", negative="raise")
    with pytest.raises(ValueError, match="Expected `negative` to be 'clip' or 'raise'"):
        sm.light.Distribution(image, "latlong", negative="keep")
    clipped = sm.light.Distribution(image, "latlong")
    same = sm.light.Distribution(np.maximum(image, 0), "latlong", negative="raise")
    for a, b in zip(
        clipped.sample(numbers(50, 3), weights=True),
        same.sample(numbers(50, 3), weights=True),
        strict=True,
    ):
        assert np.array_equal(a, b)
    again = pickle.loads(pickle.dumps(clipped))
    assert again.integral == clipped.integral == same.integral
    assert image[1, 2, 0] == -3
    image[1, 2, 0], image[3, 7] = np.nan, np.inf
    with pytest.raises(ValueError, match=r"4 NaN or infinite values, at \(1, 2, 0\)"):
        sm.light.Distribution(image, "latlong")
    dist = sm.light.Distribution(image, "latlong", skipna=True)
    d = sm.directions("latlong", 4)
    assert dist.pdf(d[3, 7]) == 0 and dist.pdf(d[0, 0]) > 0
    with pytest.raises(ValueError, match="too bright"):
        sm.light.Distribution(np.full((4, 8), 1e308), "latlong")


def test_what_lies_outside_the_disk_does_not_count():
    p = sm.projection("angular")
    image = image_of(p, 10)
    outside = np.isnan(p.directions(10)[..., 0])
    d = random_directions(200, 16)
    want = sm.light.Distribution(image, p).pdf(d)
    for credit in (np.nan, np.inf, -5.0, 1e9):
        image[outside] = credit
        assert_same_bits(sm.light.Distribution(image, p).pdf(d), want)


def test_wrong_shapes_and_types():
    with pytest.raises(ValueError, match=r"shape \(6, N, N\), got \(8, 16\)"):
        sm.light.Distribution(np.ones((8, 16)), "cube")
    with pytest.raises(ValueError, match=r"shape \(H, W\) or \(H, W, C\), got \(5, 2, 4, 3, 1\)"):
        sm.light.Distribution(np.ones((5, 2, 4, 3, 1)), "latlong")
    with pytest.raises(ValueError, match="shape"):
        sm.light.Distribution(np.ones((2, 4, 0)), "latlong")
    for bad in (1.0, np.ones(3), np.ones((0, 4))):
        with pytest.raises(ValueError, match="shape"):
            sm.light.Distribution(bad, "latlong")
    with pytest.raises(TypeError, match="dtype"):
        sm.light.Distribution(np.ones((4, 8), complex), "latlong")
    with pytest.raises(TypeError, match="dtype"):
        sm.light.Distribution(np.ones((4, 8), object), "latlong")
    dist = sm.light.Distribution(np.ones((4, 8, 3)), "latlong")
    with pytest.raises(ValueError, match=r"`xi` to have shape \(..., 2\), got \(4, 3\)"):
        dist.sample(np.ones((4, 3)))
    with pytest.raises(ValueError, match=r"`xi` to have shape \(..., 2\), got \(\)"):
        dist.sample(0.5)
    with pytest.raises(TypeError, match="real numbers"):
        dist.sample(np.ones((4, 2), complex))
    with pytest.raises(ValueError, match=r"`directions` to have shape \(..., 3\)"):
        dist.pdf(np.ones((4, 2)))


def test_empty_and_scalar_and_strided_input():
    dist = sm.light.Distribution(np.ones((4, 8, 3)), "latlong")
    d, pdf, weight = dist.sample(np.empty((0, 2)), weights=True)
    assert d.shape == (0, 3) and pdf.shape == (0,) and weight.shape == (0, 3)
    assert dist.pdf(np.empty((0, 3), np.float32)).dtype == np.float32
    d, pdf = dist.sample([0.25, 0.75])
    assert d.shape == (3,) and np.ndim(pdf) == 0
    xi = numbers(60, 17).reshape(5, 12, 2)
    want = dist.sample(xi)[0]
    assert_same_bits(dist.sample(xi[::-1])[0], want[::-1])
    assert_same_bits(dist.sample(np.asfortranarray(xi))[0], want)
    frozen = xi.copy()
    frozen.flags.writeable = False
    assert_same_bits(dist.sample(frozen)[0], want)
    assert dist.sample(xi.astype(np.float16))[0].dtype == np.float32
    assert dist.sample([[0, 1]])[0].dtype == np.float64


def test_out():
    dist = sm.light.Distribution(np.ones((4, 8, 3)), "latlong")
    xi = numbers(10, 18)
    want = dist.sample(xi, weights=True)
    out = tuple(np.empty_like(x) for x in want)
    got = dist.sample(xi, weights=True, out=out)
    for a, b, c in zip(got, out, want, strict=True):
        assert a is b
        assert_same_bits(b, c)
    assert dist.sample(xi, out=(None, out[1]))[1] is out[1]
    with pytest.raises(TypeError, match="tuple of 2"):
        dist.sample(xi, out=out)
    with pytest.raises(ValueError, match=r"`out` to have shape \(10, 3\)"):
        dist.sample(xi, out=(np.empty((9, 3)), None))
    with pytest.raises(TypeError, match="array of float64"):
        dist.sample(xi, out=(np.empty((10, 3), np.float32), None))
    frozen = np.empty((10, 3))
    frozen.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        dist.sample(xi, out=(frozen, None))
    room = np.empty(60)
    with pytest.raises(ValueError, match="overlaps"):
        dist.sample(xi, out=(room[:30].reshape(10, 3), room[25:35]))
    room[:20] = xi.ravel()
    with pytest.raises(ValueError, match="overlaps"):
        dist.sample(room[:20].reshape(10, 2), out=(room[10:40].reshape(10, 3), None))


def test_real_images(data_folder):
    oiio = pytest.importorskip("OpenImageIO")
    probe = np.asarray(oiio.ImageBuf(str(data_folder / "grace_probe.hdr")).get_pixels("float"))
    dist = sm.light.Distribution(probe[..., :3], "angular")
    _, _, weight = dist.sample(numbers(20_000, 19), weights=True)
    want = np.tensordot(_core.texel_weights(sm.projection("angular"), 1000), probe[..., :3], 2)
    assert np.all(np.abs(weight.mean(0) - want) < 5 * weight.std(0) / np.sqrt(20_000))
    venice = np.asarray(oiio.ImageBuf(str(data_folder / "venice.exr")).get_pixels("float"))
    if (venice[..., :3] < 0).any():
        with pytest.raises(ValueError, match="negative"):
            sm.light.Distribution(venice[..., :3], "latlong", negative="raise")
    dist = sm.light.Distribution(venice[..., :3], "latlong")
    # Luminance sums three quotients of float32, each off by 6e-8 for texel and for density.
    np.testing.assert_allclose(
        dist.sample(numbers(9, 1), weights=True)[2] @ REC709, dist.integral, rtol=1e-5
    )
