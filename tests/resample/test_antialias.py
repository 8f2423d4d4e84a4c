"""Conversion to fewer texels: means where a texel sees much, one lookup where it sees little."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, MEANS, assert_same_bits_everywhere, each


def plain(image, src, dst, **options):
    return sm.convert(image, src, dst, antialias=False, **options)


# Conversions of them by area, which is what is compared with here, take up to a second.
HEAVY = (
    *("icosahedral", "mollweide", "healpix", "cube_quadratic", "cube_equiangular"),
    *("cube_equal_area", "tetrahedral", "cylindrical", "sinusoidal", "hemi_latlong"),
    *("pannini", "camera_rad_tan_thin_prism_fisheye"),
)


def grating(d: np.ndarray, waves: float) -> np.ndarray:
    """Ripples along three directions, of so many radians a radian at most."""
    return sum(np.cos(waves * (d @ axis)) for axis in np.linalg.qr(np.ones((3, 3)) + np.eye(3))[0])


@each(DEFAULTS, slow=[c for c in DEFAULTS if c.name in HEAVY])
def test_ripples_finer_than_the_target_fade(case):
    # A texel of the 24 rows spans π/24; ripples of 2π/60 average out, one lookup shows them whole.
    p = case.make()
    image = np.nan_to_num(grating(p.directions(192), 60))
    seen = sm.convert(np.ones(image.shape), p, "latlong", size=24, fill=np.nan, antialias=False)
    # Away from where the source ends, so that every texel is seen whole.
    whole = np.isfinite(seen) & (sm.convert(case_covered(p), p, "latlong", size=24) > 0.999)
    if case.name in reference.POLES & reference.ROOT_RIMS:
        # Rows beside its poles are as high as a texel of the target, and not finer than it.
        whole[[0, 1, -2, -1]] = False
    if whole.sum() < 20:
        pytest.skip("the coverage is smaller than a few texels")
    sharp = plain(image, p, "latlong", size=24)[whole]
    soft = sm.convert(image, p, "latlong", size=24)[whole]
    exact = sm.convert(image, p, "latlong", size=24, filter="area")[whole]
    assert np.sqrt(np.mean(sharp**2)) > 0.6
    assert np.sqrt(np.mean((soft - exact) ** 2)) < 0.06


def case_covered(p: sm.Projection) -> np.ndarray:
    """Return 1 inside the coverage, and 0 within two texels of where it ends."""
    held = np.isfinite(p.directions(192)[..., 0])
    if p.seam != "ends":
        return np.ones(held.shape)
    for _ in range(4):
        held[..., 1:, :] &= held[..., :-1, :].copy()
        held[..., :-1, :] &= held[..., 1:, :].copy()
        held[..., 1:] &= held[..., :-1].copy()
        held[..., :-1] &= held[..., 1:].copy()
        held[..., [0, -1], :] = held[..., :, [0, -1]] = False
    return held.astype(float)


@pytest.mark.parametrize("dst", ["cube", "latlong", "octahedral"])
def test_a_lone_sun_keeps_its_light(dst):
    rng = np.random.default_rng(3)
    before, after = sm.solid_angle("latlong", 128), sm.solid_angle(dst, 16)
    kept, lost = [], 0
    for _ in range(150):
        d = rng.normal(size=3)
        u, v = sm.encode(d, "latlong")
        sky = np.zeros((128, 256), np.float32)
        at = int(v * 128), int(u * 256)
        sky[at] = 1e4
        light = 1e4 * before[at]
        kept.append((sm.convert(sky, "latlong", dst, size=16) * after).sum() / light)
        lost += (plain(sky, "latlong", dst, size=16) * after).sum() < 0.01 * light
    # Single places and texels beat against each other: see src/resample/antialias.
    assert abs(np.mean(kept) - 1) < 0.02
    assert np.min(kept) > 0.75 and np.max(kept) < 1.3
    assert lost > 75


@pytest.mark.parametrize(
    ("shape", "dst", "size"),
    [
        ((256, 512), "latlong", 64),
        ((256, 512), "latlong", (90, 180)),
        ((256, 512), "latlong", 181),
        ((256, 512), "hemi_latlong", 64),
        ((256, 512), "lambert_cylindrical", 64),
        ((128, 512), "latlong", 80),
    ],
)
@pytest.mark.parametrize("yaw", [0, 33])
def test_panoramas_become_smaller_by_area(shape, dst, size, yaw):
    rng = np.random.default_rng(9)
    image = rng.random((*shape, 3), np.float32)
    options = {"size": size, "rotation": sm.rotation(yaw, 0, 0), "any_aspect": True}
    got = sm.convert(image, "latlong", dst, **options)
    np.testing.assert_array_equal(got, sm.convert(image, "latlong", dst, filter="area", **options))


@pytest.mark.parametrize(
    ("dst", "size", "options"),
    [
        # Texels of it that are less than 1.41 high are interpolated beside others.
        ("latlong", 182, {}),
        ("mercator", 64, {}),
        ("latlong", 60, {"rotation": sm.rotation(0, 1e-3, 0)}),
        ("latlong", 60, {"filter": "bicubic"}),
    ],
)
def test_others_are_looked_up(dst, size, options):
    image = np.random.default_rng(9).random((256, 512), np.float32)
    got = sm.convert(image, "latlong", dst, size=size, **options)
    options = {**options, "filter": "area"}
    area = sm.convert(image, "latlong", dst, size=size, **options)
    assert np.mean(got == area) < 0.1


def shares(source: int, target: int) -> np.ndarray:
    """Return how much of each source texel lies in each of the target, along one side."""
    ours, theirs = np.linspace(0, source, target + 1), np.arange(source + 1)
    begin = np.maximum(ours[:-1, None], theirs[None, :-1])
    end = np.minimum(ours[1:, None], theirs[None, 1:])
    return np.maximum(end - begin, 0) * target / source


@pytest.mark.parametrize(
    ("name", "source", "target"),
    [
        ("cube", 96, 48),
        ("cube", 100, 41),
        ("cube", 24, 8),
        ("cube:unreal", 96, 40),
        ("cube_equiangular", 96, 48),
        ("octahedral", 300, 128),
        ("perspective(fov=90)", 90, 60),
        ("cylindrical", 96, 40),
    ],
)
@pytest.mark.parametrize("channels", [1, 3, 5])
def test_smaller_images_of_one_map_are_means_of_rectangles(name, source, target, channels):
    p = sm.projection(name)
    image = np.random.default_rng(9).random((*p.shape(source), channels), np.float32)
    got = sm.convert(image, p, p, size=target)
    rows, columns = (shares(image.shape[k], got.shape[k]) for k in (-3, -2))
    want = np.einsum("ij,kl,...jlc->...ikc", rows, columns, image, optimize=True)
    # Sums in float64, rounded once to float32 below 1.
    np.testing.assert_allclose(got, want, atol=2**-24, rtol=0)


@pytest.mark.parametrize(
    ("name", "source", "target"),
    # The density at one side of a texel is twice that at the other, or there is a rim.
    [("cube", 12, 3), ("perspective(fov=150)", 48, 12), ("angular", 96, 24)],
)
def test_solid_angles_that_change_much_within_a_texel_count(name, source, target):
    image = np.random.default_rng(9).random(sm.projection(name).shape(source), np.float32)
    got = sm.convert(image, name, name, size=target)
    k = source // target
    boxes = image.reshape(*image.shape[:-2], target, k, target, k).mean((-3, -1))
    # Rounding makes a few equal.
    assert np.mean(np.isclose(got, boxes, rtol=1e-4)) < 0.2


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
def test_smaller_panoramas_have_their_constants_and_holes(dtype):
    image = np.full((96, 192, 2), 201 if np.dtype(dtype).kind == "u" else 0.1, dtype)
    for size in (7, 24, 48, 67):
        got = sm.convert(image, "latlong", "latlong", size=size)
        assert (got == image[0, 0, 0]).all()
    if np.dtype(dtype).kind == "f":
        image[40:42, 100:102, 1] = np.nan
        got = sm.convert(image, "latlong", "latlong", size=24)
        assert np.argwhere(np.isnan(got)).tolist() == [[10, 25, 1]]
        assert np.isfinite(sm.convert(image, "latlong", "latlong", size=24, skipna=True)).all()


@pytest.mark.parametrize(
    ("src", "shape", "dst", "size"),
    [
        ("cube", (6, 4, 4), "latlong", 4),
        ("cube", (6, 24, 24), "latlong", 8),
        ("latlong", (48, 96), "cube", 8),
    ],
)
def test_of_places_a_number_is_the_same_beside_any_others(src, shape, dst, size):
    image = np.random.default_rng(9).random((*shape, 6))
    six = sm.convert(image, src, dst, size=size)
    for channels in (1, 2, 3, 4, 5):
        few = sm.convert(np.ascontiguousarray(image[..., :channels]), src, dst, size=size)
        np.testing.assert_array_equal(few, six[..., :channels])


@pytest.mark.parametrize("filter", ["bilinear", "bicubic"])
@pytest.mark.parametrize("src", ["latlong", "cube"])
def test_a_sun_beside_the_poles_keeps_its_light(src, filter):
    p = sm.projection(src)
    shape = p.shape(256 if src == "latlong" else 128)
    solid_angles, after = p.solid_angle(shape), sm.solid_angle("latlong", 64)
    kept = []
    for number in range(24):
        sky = np.zeros(shape, np.float32)
        # Texels about the middle of the cube's face above, or of the first rows of a latlong.
        at = (number // 3, 20 * number) if src == "latlong" else (2, 64 + number // 3, 64)
        sky[at] = 1e4
        seen = sm.convert(sky, src, "latlong", size=64, filter=filter)
        kept.append((seen * after).sum() / (1e4 * solid_angles[at]))
    if src == "latlong" and filter == "bilinear":
        np.testing.assert_allclose(kept, 1, 1e-6)  # sums in float32
    else:
        # Places and texels beat against each other, as anywhere.
        assert np.min(kept) > 0.65 and np.max(kept) < 1.4


@pytest.mark.parametrize("filter", MEANS)
def test_a_finer_target_is_what_it_was(filter):
    image = np.random.default_rng(4).random((16, 32, 3), np.float32)
    for dst, size in (("cube", 32), ("octahedral", 64), ("latlong", 16)):
        options = {"size": size, "filter": filter}
        got = sm.convert(image, "latlong", dst, **options)
        want = plain(image, "latlong", dst, **options)
        # Beside the poles of the source texels are finer than any target's.
        far = np.abs(sm.directions(dst, size)[..., 1]) < 0.8
        assert np.array_equal(got[far], want[far])


@each(DEFAULTS)
@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_a_constant_stays_constant_to_the_bit(case, dtype):
    p = case.make()
    image = np.full((*p.shape(48), 2), 0.1 if dtype[0] == "f" else 137, dtype)
    dark = np.isnan(p.directions(48)[..., 0])
    constant = image[~dark][0, 0]
    image[dark] = 200  # what must never take part
    for dst in ("latlong", "cube", "sphere"):
        got = sm.convert(image, p, dst, size=6, fill=0)
        assert np.all((got == constant) | (got == 0))


def test_nearest_takes_texels_and_no_means():
    labels = np.random.default_rng(5).integers(0, 200, (128, 256), np.uint8)
    got = sm.convert(labels, "latlong", "cube", size=8, filter="nearest")
    assert np.array_equal(got, plain(labels, "latlong", "cube", size=8, filter="nearest"))


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16"])
def test_means_round_once(dtype):
    image = np.random.default_rng(6).integers(0, 255, (96, 192, 3)).astype(dtype)
    got = sm.convert(image, "latlong", "cube", size=8)
    exact = sm.convert(image.astype(np.float32), "latlong", "cube", size=8)
    want = np.rint(exact) if dtype[0] == "u" else exact
    assert np.array_equal(got, want.astype(dtype))


def test_means_are_the_same_bits_on_every_level_and_number_of_threads():
    image = np.random.default_rng(7).random((256, 512, 3), np.float32)
    turn = sm.rotation(20, 30, 40)
    assert_same_bits_everywhere(
        lambda: [sm.convert(image, "latlong", "cube", size=48, rotation=turn)]
    )


def test_poles_are_means_of_all_around_them():
    # Beside the pole of the source every column meets, and a texel of the target sees hundreds.
    image = np.zeros((256, 512))
    image[:, ::2] = 1
    cube = sm.convert(image, "latlong", "cube", size=16)
    top = cube[sm.directions("cube", 16)[..., 1] > 0.9]
    assert np.abs(top - 0.5).max() < 0.05


def test_nan_spreads_to_what_sees_it_and_no_further():
    image = np.ones((64, 128))
    image[20, 40] = np.nan
    got = sm.convert(image, "latlong", "latlong", size=8)
    assert np.isnan(got[2, 5]) and np.isnan(got).sum() <= 4


def test_what_the_source_does_not_hold_is_in_no_mean():
    p = sm.projection("perspective", fov=60)
    got = sm.convert(np.full((256, 256), 3.0), p, "latlong", size=32, fill=-1)
    assert set(np.unique(got)) == {-1.0, 3.0}


def test_of_a_smooth_function_means_are_the_truth():
    image = reference.smooth_function(sm.directions("latlong", 256))
    got = sm.convert(image, "latlong", "cube", size=16)
    exact = sm.convert(image, "latlong", "cube", size=16, filter="area")
    # Means of so many lookups, each off by the second derivative times h²/8.
    assert np.abs(got - exact).max() < 2e-3 * np.ptp(image)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("src", "shape", "dst", "size"),
    [
        ("latlong", (768, 1536), "cube", 200),
        ("latlong", (768, 1536), "angular", 450),
        ("latlong", (768, 1536), "perspective", 300),
        ("cube", (6, 400, 400), "latlong", 400),
        ("cube", (6, 400, 400), "angular", 500),
        ("angular", (700, 700), "latlong", 300),
        ("dual_paraboloid", (2, 512, 512), "cube", 240),
    ],
)
def test_parallelograms_are_as_good_as_places(src, shape, dst, size, turned):
    # In float32 small texels are parallelograms in the source, in float64 every place is computed.
    rng = np.random.default_rng(5)
    image = rng.random((*shape, 3), np.float32)
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation = q * np.sign(np.linalg.det(q)) if turned else None
    seen = sm.convert(image, src, dst, size=size, rotation=rotation)
    exact = sm.convert(image.astype(np.float64), src, dst, size=size, rotation=rotation)
    several = seen != plain(image, src, dst, size=size, rotation=rotation)
    assert np.mean(several) > 0.2
    off = np.abs(seen - exact)
    # Places are off by 1/350 source texel at most, and noise rises by less than 1 a texel. At a
    # length where a texel gets another place, rounding decides which of two means it has: for fewer
    # than one texel in a thousand. The others are off by a third of 1/350, rms.
    assert np.mean(off > 1 / 350) < 1e-3
    assert np.sqrt(np.mean(off**2)) < 1e-3


# A texel of these sees some twenty of the source, summed up by how much of each it covers.
MANY = ("latlong", (512, 1024), "cube", 64)


def of_many(image: np.ndarray) -> np.ndarray:
    src, _, dst, size = MANY
    return sm.convert(image, src, dst, size=size)


def noise(dtype: type = np.float32, channels: int = 6) -> np.ndarray:
    x = np.random.default_rng(8).random((*MANY[1], channels))
    return (x * 200).astype(dtype) if np.dtype(dtype).kind == "u" else x.astype(dtype)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
def test_sums_of_many_are_each_numbers_own(dtype):
    # Numbers of three and four are summed side by side, others one by one.
    x = noise(dtype)
    # Sums of twenty terms, and beside poles of a thousand, in two orders.
    rounding = 0 if np.dtype(dtype).kind == "u" else 1000 * np.finfo(dtype).eps
    got = of_many(x)
    for channels in (1, 2, 3, 4):
        part = of_many(np.ascontiguousarray(x[..., :channels]))
        np.testing.assert_allclose(part, got[..., :channels], rounding)
    np.testing.assert_allclose(of_many(np.ascontiguousarray(x[..., 5])), got[..., 5], rounding)


@pytest.mark.parametrize("channels", [1, 3, 4, 5])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_of_many_only_those_that_see_it_take_it(value, channels):
    x = noise(channels=channels)
    want = of_many(x)
    x[150:153, 700:703, 0] = value
    got = of_many(x)
    off = ~np.isfinite(got)
    # It covers 3 by 3 texels of the source, and those of the target are four across.
    assert 1 <= off.sum() <= 9
    assert not off[..., 1:].any()
    np.testing.assert_array_equal(got[~off], want[~off])


@pytest.mark.parametrize("channels", [1, 3, 4, 5])
@pytest.mark.parametrize("scale", [3e38, 1e-36])
def test_of_many_sums_stay_within_the_range_of_means(scale, channels):
    x = noise(channels=channels)
    got = of_many(x * np.float32(scale)) / np.float32(scale)
    # Terms are a twentieth of a mean and less: below 1e-38 they keep fewer digits.
    np.testing.assert_allclose(got, of_many(x), 5e-6)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
def test_of_many_a_constant_stays_constant_to_the_bit(dtype):
    for channels in (1, 3, 4):
        x = np.full((*MANY[1], channels), 201 if np.dtype(dtype).kind == "u" else 0.1, dtype)
        assert (of_many(x) == x[0, 0, 0]).all()


def test_of_many_means_are_nearly_areas():
    x = noise(channels=3)
    exact = sm.convert(x, MANY[0], MANY[2], size=MANY[3], filter="area").astype(np.float64)
    got = of_many(x)
    # Numbers from 0 to 1 differ by 0.29, and means of twenty by 0.07. A tenth of that, with texels
    # beside the edges of faces, which are looked up place by place.
    assert np.sqrt(np.mean((got - exact) ** 2)) < 0.007
