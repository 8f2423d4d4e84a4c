"""Texels with weights of their own: alpha, and NaN that counts for nothing."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm

LINEAR = (
    "bilinear", "catmull-rom", "mitchell", "lanczos3", "trilinear", "ewa", "area",
)  # fmt: skip
# Means in float32, by different sums of the same terms: some of its 6e-8.
SINGLE = 1e-6
each_filter = pytest.mark.parametrize("filter", LINEAR)


def sprite(dtype="float32") -> np.ndarray:
    """A green disk on transparent red."""
    full = 255 if dtype == "uint8" else 1
    image = np.zeros((32, 64, 4), dtype)
    image[..., 0] = full
    rows, columns = np.mgrid[:32, :64]
    disk = np.hypot(rows - 15, columns - 30) < 9
    image[disk] = (0, full, 0, full)
    return image


@each_filter
@pytest.mark.parametrize("size", [8, 40])
@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_transparent_colors_do_not_bleed(filter, size, dtype):
    got = sm.convert(sprite(dtype), "latlong", "cube", size=size, filter=filter, alpha=-1)
    assert got.dtype == dtype
    full = 255 if dtype == "uint8" else 1
    seen = got[..., 3] > 0.02 * full
    assert seen.any() and not seen.all()
    # Where something is seen it is green, as bright as it was.
    assert np.abs(got[seen][:, 0]).max() < 0.02 * full
    assert np.abs(got[seen][:, 1] - full).max() < 0.02 * full
    # Without, red comes in at the rim.
    bare = sm.convert(sprite(dtype), "latlong", "cube", size=size, filter=filter)
    assert bare[(bare[..., 3] > 0.3 * full) & (bare[..., 3] < 0.7 * full)][:, 0].max() > 0.2 * full


def test_alpha_itself_is_what_it_is_without():
    image = np.random.default_rng(1).random((32, 64, 4), np.float32)
    with_it = sm.convert(image, "latlong", "cube", size=12, alpha=3)
    without = sm.convert(image, "latlong", "cube", size=12)
    assert np.allclose(with_it[..., 3], without[..., 3], atol=SINGLE)
    # Premultiplied, the colors are the plain mean of premultiplied colors.
    image[..., :3] *= image[..., 3:]
    premultiplied = sm.convert(image, "latlong", "cube", size=12)
    image[..., :3] /= image[..., 3:]
    # Products, means and a quotient in float32: some of its 6e-8 each.
    assert np.allclose(with_it[..., :3] * with_it[..., 3:], premultiplied[..., :3], atol=1e-5)


def test_alpha_may_be_any_channel():
    image = np.random.default_rng(2).random((16, 32, 3), np.float32)
    a = sm.convert(image, "latlong", "cube", size=8, alpha=0)
    b = sm.convert(image[..., ::-1], "latlong", "cube", size=8, alpha=-1)
    assert np.allclose(a, b[..., ::-1], atol=SINGLE)


@each_filter
def test_nan_has_no_weight(filter):
    image = np.ones((32, 64, 2))
    image[..., 1] = np.linspace(0, 1, 64)
    holes = np.random.default_rng(3).random((32, 64)) < 0.1
    holed = image.copy()
    holed[holes] = np.nan
    plain = sm.convert(holed, "latlong", "cube", size=10, filter=filter)
    got = sm.convert(holed, "latlong", "cube", size=10, filter=filter, skipna=True)
    assert np.isnan(plain).any()
    assert np.isnan(got).mean() < 0.02
    # `area` has shares of texels to 5e-7, the other filters to rounding.
    assert np.allclose(got[..., 0][np.isfinite(got[..., 0])], 1, atol=1e-6)
    # Where no hole is near, it is what it was.
    same = np.isfinite(plain)
    # `area` has shares of texels to 5e-7, the other filters to rounding.
    assert np.allclose(got[same], plain[same], atol=1e-6)


def test_a_channel_of_its_own_hole():
    image = np.ones((16, 32, 2))
    image[5, 5, 0] = np.nan
    got = sm.sample(image, sm.directions("latlong", 16), "latlong", skipna=True)
    assert np.isnan(got[..., 1]).sum() == 0
    # Nothing but the hole is near its center.
    assert np.isnan(got[..., 0]).sum() <= 1


def test_all_nan_is_nan_and_outside_is_fill():
    image = np.full((8, 8), np.nan)
    d = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    got = sm.sample(image, d, "hemioctahedral", skipna=True, fill=-2)
    assert np.isnan(got[0]) and got[1] == -2


def test_sample_takes_alpha():
    image = sprite()
    d = sm.directions("latlong", 64)
    got = sm.sample(image, d, "latlong", alpha=-1)
    seen = got[..., 3] > 0.01
    # A quotient of float32 lookups by 0.01 and more: a hundred of its 6e-8.
    assert np.allclose(got[seen][:, :2], [0, 1], atol=1e-5)
    nearest = sm.sample(image, d, "latlong", alpha=-1, filter="nearest")
    assert np.array_equal(nearest, sm.sample(image, d, "latlong", filter="nearest"))


def test_out_and_the_given_image():
    image = sprite()
    image.flags.writeable = False
    out = np.empty((6, 8, 8, 4), np.float32)
    got = sm.convert(image, "latlong", "cube", size=8, alpha=3, out=out)
    assert got is out
    assert np.array_equal(out, sm.convert(image, "latlong", "cube", size=8, alpha=3))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"alpha": 4}, "Expected `alpha` to be the number of one of at least 2 channels, got 4"),
        ({"alpha": -5}, "Expected `alpha`"),
        ({"alpha": 1, "filter": "mode"}, "filter 'mode' is for labels"),
        ({"alpha": 3, "out": np.empty((2, 2), np.float32)}, "Expected `out` to have shape"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(ValueError, match=message):
        sm.convert(sprite(), "latlong", "cube", size=8, **options)
    with pytest.raises(ValueError, match="Expected `alpha`"):
        sm.convert(np.ones((4, 8)), "latlong", "cube", alpha=0)
