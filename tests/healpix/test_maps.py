"""Whole maps against healpy: orders, images, other pixels, missing values."""

from __future__ import annotations

import healpy
import numpy as np
import pytest
import spheremap as sm
from spheremap import healpix


def orders(n: int) -> list[bool]:
    return [False, True] if n & (n - 1) == 0 else [False]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 16, 31, 32, 33, 40, 64, 97, 128])
@pytest.mark.parametrize("dtype", ["u1", "<f4", ">f8", "c16", "S5", "M8[s]"])
def test_every_arrangement_is_a_gather_by_numbers(n, dtype):
    count = 12 * n * n
    values = (np.arange(count) % 251).astype(np.int64).astype(dtype)
    pixels = {
        nest: healpix.vec2pix(n, sm.directions("healpix", n), nest=nest) for nest in orders(n)
    }
    for nest, number in pixels.items():
        image = healpix.to_image(values, nest)
        assert np.array_equal(image, values[number]) and image.shape == (12, n, n)
        assert np.array_equal(healpix.from_image(image, nest), values)
    if len(pixels) == 2:
        numbers = np.arange(count)
        got = healpix.reorder(values, nest=True)
        assert got.dtype == values.dtype
        assert np.array_equal(got, values[healpy.ring2nest(n, numbers)])
        got = healpix.reorder(values, nest=False)
        assert np.array_equal(got, values[healpy.nest2ring(n, numbers)])


@pytest.mark.parametrize("tail", [(1,), (3,), (5,), (2, 3), (0,)])
def test_pixels_of_several_numbers(tail):
    values = np.random.default_rng(0).random((12 * 8**2, *tail)).astype(np.float32)
    image = healpix.to_image(values)
    assert image.shape == (12, 8, 8, *tail)
    for k in np.ndindex(tail):
        assert np.array_equal(image[(..., *k)], healpix.to_image(values[(slice(None), *k)]))
    if len(tail) == 1:
        assert np.array_equal(healpix.from_image(image), values)
    assert np.array_equal(healpix.reorder(healpix.reorder(values, nest=True), nest=False), values)


def test_views_and_objects_are_arranged_as_copies_are():
    values = np.arange(2 * 12 * 16**2)[::-2]
    assert np.array_equal(healpix.to_image(values), healpix.to_image(values.copy()))
    things = np.array([str(x) for x in range(48)], object)
    assert healpix.reorder(things, nest=True).tolist() == [
        str(x) for x in healpix.reorder(np.arange(48), nest=True)
    ]


def test_any_number_of_threads_gives_the_same_map():
    values = np.random.default_rng(1).random(12 * 128**2)
    found = {}
    for threads in (1, 2):
        sm.set_num_threads(threads)
        for name, made in (
            ("image", healpix.to_image(values)),
            ("nested", healpix.reorder(values, nest=False)),
            ("ring", healpix.reorder(values, nest=True)),
        ):
            assert np.array_equal(made, found.setdefault(name, made))


@pytest.mark.parametrize("dtype", [np.float32, np.float64, ">f4"])
def test_what_healpy_marks_as_unseen_is_missing(dtype):
    values = np.arange(12 * 4**2).astype(dtype)
    values[[3, 50]] = healpy.UNSEEN
    values[7] = np.nan
    values[9] = -1.6e30
    image = healpix.to_image(values)
    missing = np.flatnonzero(np.isnan(healpix.from_image(image)))
    assert missing.tolist() == [3, 7, 50]
    # The mark went through float32 and came back, as in files.
    through = np.full(12, np.float32(healpy.UNSEEN)).astype(np.float64)
    assert np.isnan(healpix.to_image(through)).all()
    assert np.nanmin(healpix.reorder(values, nest=True)) == np.dtype(dtype).type(healpy.UNSEEN)


def test_masked_values_are_missing():
    values = np.ma.masked_array(np.arange(48.0), np.arange(48) % 5 == 0)
    image = healpix.to_image(values)
    assert not isinstance(image, np.ma.MaskedArray)
    assert np.array_equal(np.isnan(healpix.from_image(image)), values.mask)
    nested = healpix.reorder(values, nest=False)
    assert isinstance(nested, np.ma.MaskedArray)
    assert np.array_equal(nested.mask, healpix.reorder(values.mask, nest=False))
    with pytest.raises(TypeError, match=r"`values` has masked .* int64 has no NaN .*filled\(0\)"):
        healpix.to_image(np.ma.masked_array(np.arange(12), np.arange(12) == 3))
    assert healpix.to_image(np.ma.masked_array(np.arange(12))).dtype == np.int64


@pytest.mark.parametrize("call", [healpix.to_image, lambda m: healpix.ud_grade(m, 1)])
def test_channels_in_front_are_answered_by_what_to_write(call):
    maps = np.zeros((3, 48))
    with pytest.raises(ValueError, match=r"\(12 nside², C\), got \(3, 48\).*`values\.T`"):
        call(maps)
    assert call(maps.T).shape[-1] == 3
    with pytest.raises(ValueError, match="12 nside² pixels, got 3"):
        call(np.zeros((3, 47)))


@pytest.mark.parametrize("nest", [False, True])
@pytest.mark.parametrize("m", [1, 2, 8, 16, 64])
def test_other_pixels_equal_healpy(m, nest):
    rng = np.random.default_rng(2)
    order = "NEST" if nest else "RING"
    values = rng.normal(size=12 * 16**2)
    values[rng.random(values.size) < 0.3] = healpy.UNSEEN
    for pess in (False, True):
        want = healpy.ud_grade(values, m, pess=pess, order_in=order)
        got = healpix.ud_grade(values, m, nest, pess=pess)
        missing = want == healpy.UNSEEN
        assert np.array_equal(np.isnan(got), missing)
        # Means of up to 256 numbers near 1, added in another order.
        np.testing.assert_allclose(got[~missing], want[~missing], rtol=0, atol=1e-14)
    whole = rng.normal(size=12 * 16**2)
    want = healpy.ud_grade(whole, m, order_in=order, power=-2)
    got = healpix.ud_grade(whole, m, nest, statistic="sum")
    # Sums of as many.
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-12)
    # Light is kept: sums of 3072 numbers near 1.
    assert abs(got.sum() - whole.sum()) < 1e-10


@pytest.mark.parametrize("dtype", [np.uint8, np.int16, np.int64, np.uint64])
def test_integers_stay_exact(dtype):
    rng = np.random.default_rng(3)
    most = min(np.iinfo(dtype).max, 1 << 58)
    values = rng.integers(0, most, 12 * 8**2, dtype=dtype)
    nested = healpix.reorder(values, nest=False).reshape(-1, 16).astype(object)
    total = healpix.ud_grade(values, 2, statistic="sum")
    assert total.dtype == (np.uint64 if np.dtype(dtype).kind == "u" else np.int64)
    exact = nested.sum(-1)
    assert healpix.reorder(total, nest=False).tolist() == exact.tolist()
    mean = healpix.reorder(healpix.ud_grade(values, 2), nest=False)
    assert mean.dtype == dtype
    for got, sum_ in zip(mean.tolist(), exact.tolist(), strict=True):
        whole, rest = divmod(sum_, 16)
        assert got == whole + (rest > 8 or (rest == 8 and whole % 2 == 1))
    assert np.array_equal(
        healpix.ud_grade(values, 16),
        healpix.from_image(np.repeat(np.repeat(healpix.to_image(values), 2, 1), 2, 2)),
    )
    with pytest.raises(ValueError, match="Shares of integers"):
        healpix.ud_grade(values, 16, statistic="sum")


def test_divisors_that_are_no_powers_of_two():
    values = np.random.default_rng(4).random((12 * 15**2, 2))
    got = healpix.ud_grade(values, 5)
    pixels = np.arange(12 * 5**2)
    parts = healpix.to_image(values).reshape(12, 5, 3, 5, 3, 2).mean((2, 4))
    where = healpix.vec2pix(5, sm.directions("healpix", 5))
    # Nine numbers, added in another order.
    np.testing.assert_allclose(got[where], parts, rtol=1e-15, atol=1e-15)
    assert got.shape == (len(pixels), 2)
    with pytest.raises(ValueError, match="divisor or a multiple of 15, got 4"):
        healpix.ud_grade(values, 4)
    with pytest.raises(ValueError, match="`statistic` must be 'mean' or 'sum', got 'median'"):
        healpix.ud_grade(values, 5, statistic="median")


def test_masked_maps_stay_masked():
    values = np.ma.masked_array(np.arange(48.0), np.arange(48) < 6)
    got = healpix.ud_grade(values, 1, True)
    assert isinstance(got, np.ma.MaskedArray)
    assert got.mask.tolist() == [True] + [False] * 11
    assert got[1] == 6.5


@pytest.mark.parametrize("value", [1_760_000_000_000_000_000, 2**63 - 1, -(2**63), 2**63])
def test_means_do_not_overflow_and_sums_say_so(value):
    dtype = np.uint64 if value > 2**63 - 1 else np.int64
    for n in (3, 4):
        values = np.full(12 * n**2, value, dtype)
        assert (healpix.ud_grade(values, 1) == values[:12]).all()
        with pytest.raises(ValueError, match=f"Sums of `values` do not fit in {np.dtype(dtype)}"):
            healpix.ud_grade(values, 1, statistic="sum")
    # A large number may be part of a sum that fits.
    values = np.zeros(12 * 4**2, dtype)
    values[::16] = value
    assert (healpix.ud_grade(values, 1, True, statistic="sum") == values[::16]).all()
    # Halves go to the even number: 16 numbers of which one half are larger by 1.
    values = np.full(12 * 4**2, value, dtype) - np.arange(12 * 4**2, dtype=dtype) % 2
    if value != -(2**63):
        assert (healpix.ud_grade(values, 1, True) % 2 == 0).all()
