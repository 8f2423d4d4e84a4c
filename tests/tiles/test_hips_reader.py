"""HiPS, read back by reproject, which is affiliated with astropy: `pip install reproject`."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm

pytestmark = pytest.mark.filterwarnings("ignore")


def light(d: np.ndarray) -> np.ndarray:
    """Return smooth light that is another in every direction but a few."""
    x, y, z = np.moveaxis(d, -1, 0)
    return z + x * y / 2 + x / 3


def test_reproject_reads_the_sky_that_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hips = pytest.importorskip("reproject.hips")
    monkeypatch.setattr(os, "fsync", lambda handle: None)
    sky = "latlong:healpy"
    image = light(sm.directions(sky, 512)).astype(np.float32)
    sm.tiles.write(
        image, sky, tmp_path / "survey", format="hips", extension="fits", tile_size=64, size=128
    )
    pixels, wcs = hips.hips_as_dask_array(tmp_path / "survey", level=1)
    found = np.asarray(pixels)
    rows, columns = np.nonzero(np.isfinite(found))
    # Some squares of the plane stand for one tile twice.
    assert len(rows) >= 12 * 128**2
    lon, lat = np.radians(wcs.wcs_pix2world(columns, rows, 0))
    seen = np.isfinite(lon)
    lon, lat = lon[seen], lat[seen]
    d = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1)
    # A tenth of a pixel of 0.46 degrees: on the creases of HEALPix their means lie elsewhere.
    np.testing.assert_allclose(found[rows, columns][seen], light(d), atol=1e-3)
