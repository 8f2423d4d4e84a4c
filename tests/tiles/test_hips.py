"""HiPS, read back by astropy and healpy: a place of the sky has what the image has there."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import healpy
import numpy as np
import pytest
import spheremap as sm
from astropy.io import fits
from astropy.wcs import WCS
from scenes import scene
from spheremap import healpix, io

SKY = "latlong:openimageio-z-up"


@pytest.fixture(autouse=True)
def _disks_are_patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hundreds of files need not be on the disk for these tests."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def light(size: int = 64, p: Any = SKY) -> np.ndarray:
    """Return one channel, in the frame of the sky: +z north, +x longitude 0."""
    return scene(sm.directions(p, size))[..., 1]


def said(folder: Path) -> dict[str, str]:
    lines = (folder / "properties").read_text().splitlines()
    return {name.strip(): value.strip() for name, value in (line.split("=", 1) for line in lines)}


def tiles(folder: Path, order: int, extension: str) -> dict[int, Path]:
    found = folder.glob(f"Norder{order}/Dir*/Npix*.{extension}")
    return {int(path.stem.removeprefix("Npix")): path for path in found}


def nested(number: int, width: int) -> np.ndarray:
    """Return the nested numbers of a tile's pixels as figure 9 of the standard has them.

    As a picture: rows from the top go north-east, columns north-west.
    """
    side = np.arange(width)
    spread = sum(((side >> bit) & 1) << 2 * bit for bit in range(width.bit_length()))
    return number * width**2 + spread[:, None] + 2 * spread


@pytest.mark.parametrize("width", [32, 64])
def test_fits_tiles_hold_the_values_of_their_places(width: int, tmp_path: Path) -> None:
    image = light(128)
    made = sm.tiles.write(
        image, SKY, tmp_path, format="hips", tile_size=width, extension="fits", size=100
    )
    order = made.levels - 1
    assert width << order == 128 and made.shape == (12, 128, 128)
    top = sm.convert(image, SKY, "healpix:healpy", size=128)
    values = healpix.from_image(top, True)
    for k in range(order, -1, -1):
        found = tiles(tmp_path, k, "fits")
        assert sorted(found) == list(range(12 * 4**k))
        nside = width << k
        # Four floats and their mean are rounded.
        wanted = healpix.ud_grade(values, nside, True)
        for number, path in found.items():
            data, header = fits.getdata(path, header=True)
            assert data.dtype == np.dtype(">f4") and data.shape == (width, width)
            assert (header["ORDER"], header["NPIX"]) == (k, number)
            pixels = nested(number, width)[::-1]
            # Means of means in float32, by each program in its own order.
            assert np.allclose(data, wanted[pixels], rtol=1e-6)
            if k == order:
                assert np.array_equal(data, values[pixels])
            # The header says the same of where a pixel is as healpy.
            rows, columns = np.mgrid[0:width:7, 0:width:9].reshape(2, -1)
            lon, lat = WCS(header).wcs_pix2world(columns, rows, 0)
            theirs = healpy.pix2vec(nside, pixels[rows, columns], nest=True)
            # Degrees in doubles, through sines and cosines.
            assert np.allclose(
                healpy.ang2vec(lon, lat, lonlat=True), np.stack(theirs, -1), atol=1e-9
            )
    assert made.tiles == sum(12 * 4**k for k in range(order + 1))


def test_a_place_of_the_sky_has_its_light(tmp_path: Path) -> None:
    """From a direction to tile and pixel by healpy alone."""
    image = light(256)
    made = sm.tiles.write(image, SKY, tmp_path, format="hips", tile_size=64, extension="fits")
    order = made.levels - 1
    rng = np.random.default_rng(3)
    d = rng.normal(size=(200, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    pixels = healpy.vec2pix(64 << order, *d.T, nest=True)
    centers = np.stack(healpy.pix2vec(64 << order, pixels, nest=True), -1)
    wanted = sm.sample(image, centers, SKY)
    for pixel, value in zip(pixels.tolist(), wanted, strict=True):
        number, inner = divmod(pixel, 64**2)
        data = fits.getdata(tmp_path / f"Norder{order}/Dir0/Npix{number}.fits")
        (row,), (column,) = np.nonzero(nested(0, 64) == inner)
        # One lookup, of which `convert` has the place by a polynomial.
        assert data[63 - row, column] == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize("extension", ["png", "jpg"])
def test_pictures_are_turned_over_to_fits(extension: str, tmp_path: Path) -> None:
    image = io.tonemap(scene(sm.directions(SKY, 64)))
    made = sm.tiles.write(
        image, SKY, tmp_path, format="hips", tile_size=32, extension=extension, quality=100
    )
    top = healpix.from_image(sm.convert(image, SKY, "healpix:healpy", size=made.shape[1]), True)
    for number, path in tiles(tmp_path, made.levels - 1, extension).items():
        got, wanted = io.read(path).astype(int), top[nested(number, 32)]
        # .jpg halves the resolution of colors.
        assert np.abs(got - wanted).mean() <= (0 if extension == "png" else 6)
    lines = said(tmp_path)
    assert lines["hips_tile_format"] == {"jpg": "jpeg"}.get(extension, extension)
    assert lines["dataproduct_subtype"] == "color"


def test_allsky_is_order_three_side_by_side(tmp_path: Path) -> None:
    sm.tiles.write(light(), SKY, tmp_path, format="hips", tile_size=16, extension="fits", size=128)
    sky = fits.getdata(tmp_path / "Norder3/Allsky.fits")[::-1]
    assert sky.shape == (29 * 16, 27 * 16)
    for number, path in tiles(tmp_path, 3, "fits").items():
        y, x = (k * 16 for k in divmod(number, 27))
        assert np.array_equal(sky[y : y + 16, x : x + 16], fits.getdata(path)[::-1])
    assert np.isnan(sky[-16:, -9 * 16 :]).all()


@pytest.mark.slow
def test_large_tiles_are_made_smaller_for_allsky(tmp_path: Path) -> None:
    sm.tiles.write(
        light(), SKY, tmp_path, format="hips", tile_size=128, extension="fits", size=1024
    )
    sky = fits.getdata(tmp_path / "Norder3/Allsky.fits")[::-1]
    assert sky.shape == (29 * 64, 27 * 64)
    for number, path in tiles(tmp_path, 3, "fits").items():
        tile = fits.getdata(path)[::-1].reshape(64, 2, 64, 2)
        y, x = (k * 64 for k in divmod(number, 27))
        # Means of four floats are rounded.
        assert np.allclose(sky[y : y + 64, x : x + 64], tile.mean((1, 3)), rtol=1e-6)


def test_what_is_not_known_is_missing(tmp_path: Path) -> None:
    p = sm.projection("angular", fov=120, axes="+x +y +z")
    image = light(64, p)
    options: Any = {"format": "hips", "tile_size": 16, "size": 64, "world": "literal"}
    made = sm.tiles.write(image, p, tmp_path / "fits", extension="fits", **options)
    order = made.levels - 1
    found = tiles(tmp_path / "fits", order, "fits")
    seen = healpix.query_disc(64, [0, 0, 1], np.radians(60 + 1), nest=True) // 16**2
    assert 0 < len(found) < 12 * 4**order and set(found) <= set(seen.tolist())
    assert float(said(tmp_path / "fits")["moc_sky_fraction"]) == pytest.approx(
        # It is written with six digits.
        len(found) / (12 * 4**order),
        abs=1e-5,
    )
    # Cells of the coverage, each of an order of its own.
    cells = fits.getdata(tmp_path / "fits/Moc.fits")["UNIQ"]
    covered: set[int] = set()
    for cell in cells.tolist():
        k = (cell.bit_length() - 1) // 2 - 1
        first, count = (cell - 4 * 4**k) << 2 * (order - k), 4 ** (order - k)
        covered |= set(range(first, first + count))
    assert covered == set(found) and len(cells) < len(found)
    # Pictures have the coverage as well.
    sm.tiles.write(np.clip(image, 0, 1), p, tmp_path / "png", extension="png", **options)
    assert (tmp_path / "png/Moc.fits").read_bytes() == (tmp_path / "fits/Moc.fits").read_bytes()
    # NaN of numbers is alpha of pictures, of integers as well.
    for given in (image / 50, io.tonemap(image)):
        folder = tmp_path / given.dtype.name
        sm.tiles.write(given, p, folder, extension="png", **options)
        assert set(tiles(folder, order, "png")) == set(found)
        for number, path in tiles(folder, order, "png").items():
            known = np.isfinite(fits.getdata(found[number])[::-1])
            assert np.array_equal(io.read(path)[..., 1] > 0, known)
    # Of four pixels of which some are known, the mean of those.
    (first, *_) = (n for n, x in found.items() if np.isnan(fits.getdata(x)).any())
    quarter = fits.getdata(tmp_path / f"fits/Norder{order - 1}/Dir0/Npix{first // 4}.fits")
    assert np.isfinite(quarter).sum() >= np.isfinite(fits.getdata(found[first])).sum() / 4


def test_properties_say_what_there_is(tmp_path: Path) -> None:
    sm.tiles.write(
        light(), SKY, tmp_path, format="hips", tile_size=64, extension="fits", frame="galactic",
        title="The sky", properties={"creator_did": "ivo://me/P/sky", "obs_regime": "Radio"},
    )  # fmt: skip
    lines = said(tmp_path)
    # Those that HiPS 1.0 requires.
    required = {"creator_did", "obs_title", "dataproduct_type", "hips_version", "hips_release_date"}
    required |= {"hips_status", "hips_tile_format", "hips_order", "hips_frame", "hips_tile_width"}
    assert required <= set(lines)
    assert lines["creator_did"] == "ivo://me/P/sky" and lines["obs_regime"] == "Radio"
    assert (lines["obs_title"], lines["hips_frame"]) == ("The sky", "galactic")
    assert (lines["hips_tile_width"], lines["hips_tile_format"]) == ("64", "fits")
    # The center of the galaxy, as everybody's catalogs have it.
    assert lines["hips_initial_ra"] == "266.40499" and lines["hips_initial_dec"] == "-28.93618"
    header = fits.getheader(tmp_path / "Norder0/Dir0/Npix4.fits")
    assert (header["CTYPE1"], header["CTYPE2"]) == ("GLON-HPX", "GLAT-HPX")


def test_a_header_is_that_of_the_standard(tmp_path: Path) -> None:
    """Its example: order 0, index 7, 512² pixels."""
    sm.tiles.write(light(), SKY, tmp_path, format="hips", extension="fits")
    header = fits.getheader(tmp_path / "Norder0/Dir0/Npix7.fits")
    wanted = {
        "CTYPE1": "RA---HPX", "CTYPE2": "DEC--HPX", "CRPIX1": -255.5, "CRPIX2": -255.5, "CRVAL1": 0,
        "CRVAL2": 0, "CD1_1": -8.7890625e-2, "CD1_2": -8.7890625e-2, "CD2_1": 8.7890625e-2,
        "CD2_2": -8.7890625e-2, "PV2_1": 4, "PV2_2": 3,
    }  # fmt: skip
    assert {name: header[name] for name in wanted} == wanted


def test_numbers_stay_numbers(tmp_path: Path) -> None:
    """Integers too: in FITS they are no pictures."""
    image = np.arange(8 * 16, dtype=np.uint16).reshape(8, 16) * 500
    sm.tiles.write(image, SKY, tmp_path, format="hips", tile_size=16, extension="fits")
    top = sm.convert(image.astype(np.float32), SKY, "healpix:healpy", size=16)
    data = fits.getdata(tmp_path / "Norder0/Dir0/Npix5.fits")
    assert np.array_equal(data[::-1], top[5].T)


def test_without_astropy_it_says_what_to_install(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['astropy'] = None\n"
        "import numpy as np, spheremap as sm\n"
        f"sm.tiles.write(np.ones((8, 16)), 'latlong', {str(tmp_path / 'a')!r}, format='hips', "
        "extension='fits')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "pip install spheremap[hips]" in done.stderr
    assert not (tmp_path / "a").exists()
