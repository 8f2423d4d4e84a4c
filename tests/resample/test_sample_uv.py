"""Pictures looked up by (u, v), against the rules of graphics APIs."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import FILTERS, LOOKUPS, MIPMAPPED
from reference import sampler

MODES = ("clamp", "wrap", "mirror", "border")
# Both compute in float64, some dozens of roundings of values up to 1.
CLOSE = 1e-12


def picture(height: int, width: int, *channels: int) -> np.ndarray:
    return np.random.default_rng(height).random((height, width, *channels))


def places(n: int, seed: int) -> np.ndarray:
    """Two pictures beyond each edge, and on the edges of texels."""
    uv = np.random.default_rng(seed).uniform(-2, 3, (n, 2))
    uv[: n // 4] = np.round(uv[: n // 4] * 16) / 16
    return uv


def chain(image: np.ndarray) -> list[np.ndarray]:
    """The levels of a picture of even sides, by blocks of texels."""
    levels = [image]
    while max(image.shape[:2]) > 1:
        h, w = (max(n // 2, 1) for n in image.shape[:2])
        image = image.reshape(h, image.shape[0] // h, w, image.shape[1] // w, -1).mean(axis=(1, 3))
        levels.append(image)
    return levels


@pytest.mark.parametrize("u", MODES)
@pytest.mark.parametrize("v", MODES)
def test_lookups_are_those_of_the_specification(u, v):
    image = picture(5, 7, 3)
    uv = places(200, 1)
    bilinear = sm.sample_uv(image, uv, address=(u, v), fill=0.25)
    nearest = sm.sample_uv(image, uv, address=(u, v), fill=0.25, filter="nearest")
    border = np.full(3, 0.25)
    for k, place in enumerate(uv):
        want = sampler.bilinear(image, place, (u, v), border)
        assert np.allclose(bilinear[k], want, rtol=0, atol=CLOSE)
        assert np.array_equal(nearest[k], sampler.nearest(image, place, (u, v), border))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("size", [(32, 32), (8, 64), (16, 1)])
def test_levels_are_those_of_the_specification(mode, size):
    image = picture(*size, 2)
    levels = chain(image)
    uv = places(150, 2)
    lod = np.random.default_rng(3).uniform(-1, len(levels) + 1, len(uv))
    got = sm.sample_uv(image, uv, address=mode, lod=lod)
    for k, place in enumerate(uv):
        want = sampler.sample_2d(levels, place, (mode, mode), lod=lod[k])
        assert np.allclose(got[k], want, rtol=0, atol=CLOSE)


@pytest.mark.parametrize("mode", MODES)
def test_derivatives_are_those_of_the_specification(mode):
    image = picture(16, 64, 2)
    levels = chain(image)
    uv = places(150, 4)
    rng = np.random.default_rng(5)
    right, down = rng.normal(size=(2, 150, 2)) * 2.0 ** rng.uniform(-9, 1, (2, 150, 1))
    got = sm.sample_uv(image, uv, address=mode, derivatives=(right, down))
    for k, place in enumerate(uv):
        pair = right[k], down[k]
        want = sampler.sample_2d(levels, place, (mode, mode), derivatives=pair)
        assert np.allclose(got[k], want, rtol=0, atol=CLOSE)


def test_odd_sides_are_divided():
    image = np.array([[0.0, 1, 2, 3, 40]])
    got = sm.sample_uv(image, [[0.25, 0.5], [0.75, 0.5]], lod=1)
    # Two texels and a half each.
    assert np.allclose(got, [(0 + 1 + 2 / 2) / 2.5, (2 / 2 + 3 + 40) / 2.5], rtol=1e-15)
    assert np.isclose(sm.sample_uv(image, [0.1, 0.1], lod=9), image.mean(), rtol=1e-15)


@pytest.mark.parametrize("filter", LOOKUPS)
def test_every_filter_of_sample_is_one_of_pictures(filter):
    # A panorama goes on at its left and right edges as a wrapped picture does.
    image = picture(32, 64)
    d = sm.directions("latlong", (64, 128))[20:-20].reshape(-1, 3)
    got = sm.sample_uv(image, sm.encode(d, "latlong"), filter=filter, address=("wrap", "clamp"))
    want = sm.sample(image, d, "latlong", filter=filter)
    # Both in float64; a panorama's (u, v) goes through an arctangent, twice.
    same = np.isclose(got, want, rtol=0, atol=1e-6)
    # A place between two texels may be rounded to either by the nearest one.
    assert np.mean(same) > (0.9 if FILTERS[filter]["takes_labels"] else 0.9999)


def test_ewa_of_a_wide_footprint_is_the_mean_and_of_a_small_one_sharp():
    image = picture(64, 64)
    place = [0.3, 0.7]
    eye = np.eye(2)
    wide = sm.sample_uv(image, place, filter="ewa", derivatives=4 * eye, address="wrap")
    # Six levels of means of four; in the last one all texels of the ellipse are one.
    assert abs(wide - image.mean()) < 1e-12
    stripes = np.tile([0.0, 1.0], (64, 32))
    # 16 texels down a stripe, none across it: the stripe, where trilinear is gray.
    along = np.array([[1e-4, 0], [0, 16 / 64]])
    center = [(20 + 0.5) / 64, 0.5]
    sharp = sm.sample_uv(stripes, center, filter="ewa", derivatives=along)
    gray = sm.sample_uv(stripes, center, derivatives=along)
    # The ellipse x²/2 + y²/257 < 1, with e^(-2r²) - e⁻²: integrals over y of 0.92562 at x = 0 and
    # of 0.19716 on both sides; 33 rows are summed instead.
    assert sharp == pytest.approx(2 * 0.19716 / (0.92562 + 2 * 0.19716), abs=1e-3)
    assert gray == 0.5


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
@pytest.mark.parametrize("filter", [*LOOKUPS, *MIPMAPPED])
def test_a_constant_stays_constant_in_every_dtype(filter, dtype):
    image = np.full((9, 6, 3), 0.1 if dtype.startswith("f") else 201, dtype)
    uv = places(300, 6)
    detail = {"derivatives": (uv, uv[::-1])} if filter in MIPMAPPED else {}
    for mode in ("clamp", "wrap", "mirror"):
        got = sm.sample_uv(image, uv, filter=filter, address=mode, **detail)
        assert got.dtype == image.dtype and np.all(got == image[0, 0])


def test_what_is_no_number_is_fill():
    image = picture(8, 8, 2)
    uv = np.array([[0.5, 0.5], [np.nan, 0], [0, np.inf], [1e300, -1e300]])
    got = sm.sample_uv(image, uv, fill=(7, 8))
    assert got[1:3].tolist() == [[7, 8], [7, 8]]
    assert np.array_equal(got[3], image[0, -1])
    mean = image.mean(axis=(0, 1))
    got = sm.sample_uv(image, uv[0], lod=[np.nan, 0, np.inf], fill=7)
    # Sums of the same 64 numbers in two orders.
    assert np.all(got[0] == 7) and np.allclose(got[2], mean, rtol=1e-14)
    pair = (np.array([[np.nan, 0], [np.inf, 0]]), np.zeros(2))
    got = sm.sample_uv(image, uv[0], derivatives=pair, fill=7)
    # As above.
    assert np.all(got[0] == 7) and np.allclose(got[1], mean, rtol=1e-14)
    # A texel of infinite light is no reason to lose the others, nor itself.
    image[2, 2] = np.inf
    assert np.isfinite(sm.sample_uv(image, (np.array([5, 5]) + 0.5) / 8)).all()
    for filter in ("nearest", "bilinear"):
        assert np.all(sm.sample_uv(image, np.array([2.5, 2.5]) / 8, filter=filter) == np.inf)


def test_the_border_is_mixed_with_the_edge():
    image = np.ones((4, 4), np.float32)
    uv = [[0.0, 0.5], [-0.125, 0.5], [0.0, 0.0]]
    assert sm.sample_uv(image, uv, address="border").tolist() == [0.5, 0.0, 0.25]
    assert sm.sample_uv(image, uv, address=("border", "wrap"), fill=3).tolist() == [2.0, 3.0, 2.0]


def test_out_and_shapes():
    image = picture(4, 4, 3).astype(np.float32)
    out = np.empty((2, 5, 3), np.float32)
    assert sm.sample_uv(image, np.full((2, 5, 2), 0.4), out=out) is out
    assert sm.sample_uv(image[..., 0], [0.4, 0.4]).shape == ()
    assert sm.sample_uv(image, np.empty((0, 2))).shape == (0, 3)
    assert sm.sample_uv(image[:1, :1], [[0.1, 9]]).tolist() == [image[0, 0].tolist()]


def test_bad_input():
    image = np.zeros((4, 8))
    with pytest.raises(ValueError, match="unknown address 'warp'; did you mean 'wrap'"):
        sm.sample_uv(image, [0, 0], address="warp")  # type: ignore[arg-type]
    for pair in (("wrap",), ("wrap", "clamp", "wrap")):
        with pytest.raises(ValueError, match="one mode or a pair"):
            sm.sample_uv(image, [0, 0], address=pair)  # type: ignore[arg-type]
    for shape in ((4,), (2, 2, 4, 4, 3), (0, 4), (4, 4, 0)):
        with pytest.raises(ValueError, match="Expected"):
            sm.sample_uv(np.zeros(shape), [0, 0])
    with pytest.raises(ValueError, match=r"`uv` to have shape \(..., 2\), got \(3,\)"):
        sm.sample_uv(image, [0, 0, 0])
    with pytest.raises(TypeError, match="one picture: `sample_uv` makes its levels"):
        sm.sample_uv([np.zeros((4, 4)), np.zeros((2, 2))], [0, 0], lod=1.0)
    with pytest.raises(ValueError, match="filter 'area'"):
        sm.sample_uv(image, [0, 0], filter="area")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="dtype"):
        sm.sample_uv(np.zeros((4, 4), complex), [0, 0])
    with pytest.raises(ValueError, match="`fill`"):
        sm.sample_uv(image, [0, 0], fill=[1, 2])
