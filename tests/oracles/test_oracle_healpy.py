"""healpy's pictures: where its projectors put places, and what they show there."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from spheremap import healpix

from . import need

ROWS = [("mollweide:healpy", "MollweideProj"), ("latlong:healpy", "CartesianProj")]


def projector(name):
    classes = need("healpy").projector
    if name == "CartesianProj":
        return classes.CartesianProj(xsize=120, ysize=60, flipconv="astro")
    return getattr(classes, name)(xsize=120, flipconv="astro")


@pytest.mark.parametrize(("row", "name"), ROWS)
def test_its_texels_look_where_ours_do(row, name):
    theirs = projector(name)
    x, y = theirs.ij2xy()
    known = ~np.ma.getmaskarray(x)
    toward = np.moveaxis(np.array(theirs.xy2vec(np.ma.filled(x, 0), np.ma.filled(y, 0))), 0, -1)
    ours = sm.directions(row, (60, 120))[::-1]
    # A texel on the rim may count as inside or outside, as the sum of two squares rounds.
    if name == "MollweideProj":
        known &= np.asarray(np.ma.filled(x, 0)) ** 2 / 4 + np.ma.filled(y, 0) ** 2 < 1 - 1e-12
    assert known.mean() > 0.7
    assert np.isfinite(ours[known]).all()
    # It takes sines and their inverses: half the digits near a pole.
    np.testing.assert_allclose(ours[known], toward[known], rtol=0, atol=3e-8)


@pytest.mark.parametrize(("row", "name"), ROWS)
def test_it_shows_what_ours_shows(row, name):
    healpy = need("healpy")
    values = np.arange(12.0 * 8**2)
    want = projector(name).projmap(values, lambda x, y, z: healpy.vec2pix(8, x, y, z))
    known = np.isfinite(want) & ~np.ma.getmaskarray(want)
    got = sm.convert(
        healpix.to_image(values),
        "healpix:healpy",
        row,
        size=(60, 120),
        filter="nearest",
        antialias=False,
        fill=np.nan,
    )[::-1]
    # Places on borders between pixels, and on the rim, may go to either side.
    assert np.mean(np.asarray(want)[known] == got[known]) > 0.98


def test_longitude_grows_to_the_left():
    p = sm.projection("mollweide:healpy")
    u, v = p.encode([np.cos(0.3), np.sin(0.3), 0.5])
    assert u < 0.5 and v < 0.5
    # Places of the image's middle: exact.
    assert p.encode([1.0, 0, 0]).tolist() == [0.5, 0.5]
