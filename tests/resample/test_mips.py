"""Mip chains, and conversion through them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import (
    DEFAULTS,
    MIPMAPPED,
    assert_same_bits_everywhere,
    each,
    random_directions,
)

each_mipmapped = pytest.mark.parametrize("filter", MIPMAPPED)


def light(image: np.ndarray, p: sm.Projection) -> float:
    """Integrate over the texels that hold a value."""
    return float(sm.light.integrate(image, p))


@each(DEFAULTS)
@pytest.mark.parametrize("size", [16, 24, 21])
def test_every_level_keeps_the_light(case, size):
    p = case.make()
    image = np.random.default_rng(size).random(p.shape(size))
    levels = sm.mipmaps(image, p)
    assert levels[0] is image
    assert min(levels[-1].shape[-2:]) < 4
    for before, level in pairwise(levels):
        assert level.dtype == image.dtype
        # What is cut by a rim is numerical for some maps.
        assert light(level, p) == pytest.approx(light(before, p), rel=1e-6)


@each(DEFAULTS)
@pytest.mark.parametrize("dtype", ["uint8", "float32"])
def test_a_constant_stays_constant(case, dtype):
    p = case.make()
    image = np.full((*p.shape(24), 3), 0.1 if dtype == "float32" else 137, dtype)
    dark = np.isnan(p.directions(24)[..., 0])
    constant = image[~dark][0, 0]
    image[dark] = 200
    for level in sm.mipmaps(image, p)[1:]:
        held = np.isfinite(p.directions(level.shape[:-1])[..., 0])
        assert np.all(level[held] == constant)
    for filter in MIPMAPPED:
        got = sm.convert(image, p, "latlong", size=6, filter=filter)
        assert np.all((got == constant) | (got == 0))


@pytest.mark.parametrize("grid", ["centers", "corners", "corners-v"])
def test_grids_and_layouts(grid):
    p = sm.projection("latlong", grid=grid)
    image = reference.smooth_function(p.directions((33, 64)))
    d = random_directions(500, 8)
    truth = reference.smooth_function(d)
    for k, level in enumerate(sm.mipmaps(image, p)[1:4], 1):
        error = np.abs(p.sample(level, d) - truth).max()
        assert error < 0.2 * 4.0 ** (k - 2) * np.ptp(truth), (k, error)
    cross = sm.projection("cube", layout="cross")
    faces = np.random.default_rng(9).random(sm.projection("cube").shape(16))
    laid = sm.convert(faces, "cube", cross, size=16, filter="nearest")
    half = sm.convert(sm.mipmaps(faces, "cube")[1], "cube", cross, size=8, filter="nearest")
    held = np.isfinite(cross.directions(8)[..., 0])
    assert np.array_equal(sm.mipmaps(laid, cross)[1][held], half[held])


@each_mipmapped
def test_a_halved_image_is_its_own_level(filter):
    # The footprint of a texel of a quarter of the size is one texel of level 2.
    image = np.random.default_rng(10).random((64, 128, 3))
    got = sm.convert(image, "latlong", "latlong", size=16, filter=filter)
    level = sm.mipmaps(image, "latlong")[2]
    if filter == "trilinear":
        # A place on a texel's center, level 2 alone: rounding of doubles.
        assert np.allclose(got, level, atol=1e-12)
    else:
        # The ellipse is a circle of radius √2, the texel and one more for reconstruction: its
        # four neighbors have (e⁻¹ - e⁻²)/(1 - e⁻²) of a texel's weight.
        neighbor = (np.exp(-1) - np.exp(-2)) / (1 - np.exp(-2))
        want = 1 / np.sqrt(1 + 4 * neighbor**2)
        # Five deviations: (1 - want²)/√1536 is 0.006.
        assert np.corrcoef(got.ravel(), level.ravel())[0, 1] == pytest.approx(want, abs=0.03)


# Conversions of them by area take longest.
HEAVY = (
    *("healpix", "mollweide", "icosahedral", "camera_rad_tan_thin_prism_fisheye"),
    *("cube_equal_area", "cube_equiangular", "cube_quadratic", "lambert_cylindrical"),
)


@each(DEFAULTS, slow=[c for c in DEFAULTS if c.name in HEAVY])
def test_seams_do_not_show(case):
    p = case.make()
    image = np.nan_to_num(reference.smooth_function(p.directions(64)))
    turn = sm.rotation(31, 17, 49)
    want = sm.convert(image, p, "cube", size=12, rotation=turn, filter="area", fill=np.nan)
    for filter in MIPMAPPED:
        got = sm.convert(image, p, "cube", size=12, rotation=turn, filter=filter, fill=np.nan)
        both = np.isfinite(got) & np.isfinite(want)
        error = np.abs(got - want)[both]
        assert both.sum() > 50
        # Blurred alike everywhere but at poles and rims, where the longer side of a footprint says
        # more than it sees, and filters blur.
        assert np.quantile(error, 0.95) < 0.15 * np.ptp(want[both])
        assert error.max() < 0.6 * np.ptp(want[both])
        assert np.median(error) < 0.03 * np.ptp(want[both])


@each_mipmapped
def test_a_finer_target_is_interpolated(filter):
    image = np.random.default_rng(11).random((32, 64))
    far = np.abs(sm.directions("cube", 64)[..., 1]) < 0.7
    got = sm.convert(image, "latlong", "cube", size=64, filter=filter)[far]
    want = sm.convert(image, "latlong", "cube", size=64)[far]
    if filter == "trilinear":
        # Level 0 alone, by the same lookups: rounding of doubles.
        assert np.allclose(got, want, atol=1e-12)
    else:
        assert 0.9 < np.corrcoef(got, want)[0, 1] < 1


@each_mipmapped
def test_threads_and_levels_give_the_same_bits(filter):
    image = np.random.default_rng(12).random((128, 256, 3), np.float32)
    assert_same_bits_everywhere(
        lambda: [sm.convert(image, "latlong", "cube", size=32, filter=filter)]
    )


def test_what_cannot_be_halved_is_one_level():
    assert len(sm.mipmaps(np.zeros((6, 1, 1)), "cube")) == 1
    assert len(sm.mipmaps(np.zeros((1, 2, 3)), "latlong")) == 1
    assert sm.convert(np.ones((1, 2, 3)), "latlong", "cube", size=2, filter="ewa").min() == 1


def test_bad_input():
    with pytest.raises(ValueError, match="unknown filter 'trilinaer'; did you mean 'trilinear'"):
        sm.convert(np.zeros((4, 8)), "latlong", "cube", filter="trilinaer")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="to have shape"):
        sm.mipmaps(np.zeros((4, 8)), "cube")
    with pytest.raises(TypeError):
        sm.mipmaps(np.zeros((4, 8), complex), "latlong")


@each_mipmapped
@pytest.mark.parametrize(
    "p",
    [
        # A disk seven texels wide, which becomes less than one.
        sm.projection("camera_thin_prism_fisheye", cx=0.0264, k1=-53.2, k4=2.9, s1=0.0072),
        # The four corners of a disk's square.
        sm.projection("angular", grid="corners"),
        sm.projection("orthographic", grid="corners-v"),
    ],
    ids=lambda p: p.name,
)
def test_levels_end_before_no_texel_is_held(p, filter):
    image = np.full((*p.shape(130), 1), 3.0)
    levels = sm.mipmaps(image, p)
    assert len(levels) > 2
    for level in levels:
        assert np.isfinite(p.directions(level.shape[:2])).any()
    made = [
        sm.convert(image, p, "equisolid", size=size, filter=filter, fill=np.nan).ravel()
        for size in (1, 2, 3, 33)
    ]
    held = np.concatenate(made)
    # A constant stays constant to the bit.
    assert set(held[np.isfinite(held)]) == {3}
    forward = np.array([[0.0, 0.0, -1.0]])
    assert p.sample(image, forward, filter="trilinear", lod=np.full(1, 9.0)) == 3
