"""Parts of the sky against the files that healpy writes and reads of them."""

from __future__ import annotations

import healpy
import numpy as np
import pytest
from astropy.io import fits
from conftest import assert_same_bits, some_fast
from spheremap import healpix

NSIDE = 32
DISC = healpix.query_disc(NSIDE, [1, 2, -3], 0.7)


def part(dtype=np.float64, tail=(), nest=False):
    pixels = healpix.query_disc(NSIDE, [1, 2, -3], 0.7, nest=nest)
    rng = np.random.default_rng(0)
    rng.shuffle(pixels)
    return pixels, rng.normal(size=(len(pixels), *tail)).astype(dtype)


@pytest.mark.parametrize("nest", [False, True])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_healpy_reads_what_is_made_here_and_the_other_way_round(tmp_path, dtype, nest):
    pixels, values = part(dtype, nest=nest)
    whole = healpix.whole_map(NSIDE, pixels, values)
    assert whole.dtype == dtype and np.array_equal(whole == healpy.UNSEEN, whole < -1e30)
    file = tmp_path / "part.fits"
    healpy.write_map(file, whole, nest=nest, partial=True, dtype=dtype)
    # Numbers and values as they lie in the file: big-endian, of short integers.
    with fits.open(file) as opened:
        table = opened[1].data
        numbers, stored = np.array(table["PIXEL"]), np.array(table["T"])
        assert opened[1].header["INDXSCHM"] == "EXPLICIT"
    got, seen = healpix.seen_pixels(whole)
    assert np.array_equal(got, numbers) and np.array_equal(seen, stored)
    assert np.array_equal(got, np.sort(pixels)) and got.dtype == np.int64 and seen.dtype == dtype
    read = healpy.read_map(file, nest=nest, partial=True)
    assert_same_bits(healpix.whole_map(NSIDE, numbers, stored), read.astype(dtype))
    assert_same_bits(
        healpix.to_image(stored, nest, pixels=numbers, nside=NSIDE), healpix.to_image(whole, nest)
    )


@some_fast("nside", [1, 2, 16, 1024], fast=(1, 2, 16))
@pytest.mark.parametrize("nest", [False, True])
def test_an_image_of_a_part_is_that_of_its_whole_map(nside, nest):
    rng = np.random.default_rng(nside)
    pixels = rng.permutation(healpix.nside2npix(nside))[: min(5 * nside, 2000)]
    values = rng.random((len(pixels), 2))
    image = healpix.to_image(values, nest, pixels=pixels, nside=nside)
    whole = healpix.to_image(healpix.whole_map(nside, pixels, values), nest)
    assert np.array_equal(image, whole, equal_nan=True)
    assert_same_bits(healpix.from_image(image, nest, pixels=pixels), values)
    assert healpix.from_image(image, nest, pixels=[]).shape == (0, 2)


def test_numbers_of_any_nside_in_ring_order():
    pixels = np.arange(5, 12 * 33**2, 7)
    image = healpix.to_image(pixels.astype(float), pixels=pixels, nside=33)
    want = healpix.to_image(np.arange(12.0 * 33**2))
    assert np.array_equal(np.isnan(image), want % 7 != 5)
    assert np.array_equal(image[want % 7 == 5], want[want % 7 == 5])


def test_what_is_missing_in_a_part_stays_so():
    values = np.array([1.0, healpy.UNSEEN, np.nan, 4.0])
    image = healpix.to_image(values, pixels=[0, 1, 2, 3], nside=2)
    assert np.nansum(image) == 5 and np.isfinite(image).sum() == 2
    pixels, seen = healpix.seen_pixels(healpix.whole_map(2, [9, 1, 2, 3], values))
    assert pixels.tolist() == [3, 9] and seen.tolist() == [4, 1]
    # The mark went through float32 and came back.
    through = np.full(12, np.float32(healpy.UNSEEN)).astype(float)
    assert healpix.seen_pixels(through)[0].size == 0
    # A pixel of several numbers is seen if one is.
    several = np.full((12, 2), np.nan)
    several[3, 1] = 5
    assert healpix.seen_pixels(several)[0].tolist() == [3]


def test_masked_parts_are_masked_maps():
    values = np.ma.masked_array([1, 2, 3], [False, True, False])
    whole = healpix.whole_map(1, [3, 5, 7], values, unseen=0)
    assert isinstance(whole, np.ma.MaskedArray) and whole.dtype == values.dtype
    assert np.flatnonzero(~whole.mask).tolist() == [3, 7]
    pixels, seen = healpix.seen_pixels(whole)
    assert pixels.tolist() == [3, 7] and seen.tolist() == [1, 3]
    image = healpix.to_image(values.astype(float), pixels=[3, 5, 7], nside=1)
    assert np.isfinite(image).sum() == 2


def test_dtypes_hold_what_is_not_seen_or_say_so():
    assert healpix.whole_map(1, [2], [7], unseen=-1).tolist().count(-1) == 11
    assert np.isnan(healpix.whole_map(1, [2], np.ones(1, np.float16), unseen=np.nan)).sum() == 11
    assert healpix.whole_map(1, [2], [True], unseen=0).sum() == 1
    for values in (np.ones(1, int), np.ones(1, np.float16), np.array(["a"])):
        with pytest.raises(TypeError, match=r"do not hold -1\.6375e\+30, what is not seen"):
            healpix.whole_map(1, [2], values)
    for values, rest in ((np.ones(1, np.uint8), -1), (np.ones(1, int), np.nan)):
        with pytest.raises(TypeError, match="do not hold"):
            healpix.whole_map(1, [2], values, unseen=rest)
    with pytest.raises(TypeError, match="int64 have no NaN for what is not seen"):
        healpix.to_image([1], pixels=[2], nside=1)


def test_parts_that_are_none():
    calls = (
        lambda p, v: healpix.whole_map(1, p, v),
        lambda p, v: healpix.to_image(v, pixels=p, nside=1),
    )
    for call in calls:
        with pytest.raises(ValueError, match="nside 1 have numbers from 0 to 11, got 12"):
            call([3, 12], [0.0, 1.0])
        with pytest.raises(ValueError, match="got -1"):
            call([-1], [0.0])
        with pytest.raises(ValueError, match="each pixel once, got 3 twice"):
            call([3, 4, 3], [0.0, 1.0, 2.0])
        with pytest.raises(ValueError, match=r"shape \(2, \.\.\.\), one for each of `pixels`"):
            call([3, 4], [0.0])
        with pytest.raises(ValueError, match=r"`pixels` to have shape \(K,\), got \(1, 1\)"):
            call([[3]], [0.0])
        with pytest.raises(TypeError, match="`pixels` to be integers"):
            call([3.0], [0.0])
        assert np.isnan(np.where(call([], []) < -1e30, np.nan, call([], []))).all()
    with pytest.raises(TypeError, match="Expected the `nside` of `pixels`"):
        healpix.to_image([1.0], pixels=[2])
    with pytest.raises(TypeError, match="`nside` is that of `pixels`"):
        healpix.to_image(np.ones(12), nside=1)
    with pytest.raises(ValueError, match="numbers from 0 to 11, got 12"):
        healpix.from_image(np.zeros((12, 1, 1)), pixels=[12])
    with pytest.raises(ValueError, match="12 nside² pixels, got 13"):
        healpix.seen_pixels(np.zeros(13))
