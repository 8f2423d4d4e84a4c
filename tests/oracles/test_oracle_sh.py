"""Spherical harmonics against ducc0 0.42, healpy 1.20 and pyshtools 4.14."""

from __future__ import annotations

import warnings

import numpy as np
import spheremap as sm

ORDER = 12


# As ducc0 and healpy lay rings: the azimuth runs from +x to +y, row 0 is at +z.
RINGS = sm.projection("latlong", axes="-y -z -x")


def test_ducc0_analyzes_the_same_grid() -> None:
    import ducc0

    d = RINGS.directions((64, 128))
    c = np.random.default_rng(0).normal(size=52**2)
    c[(ORDER + 1) ** 2 :] = 0
    image = sm.sh.evaluate(c, d)
    # NumPy's 1e-5 tells half a column from none and from a whole one.
    assert np.allclose(np.arctan2(d[0, 0, 1], d[0, 0, 0]) % (2 * np.pi), np.pi / 128)
    a = ducc0.sht.analysis_2d(
        map=image[np.newaxis], spin=0, lmax=ORDER, geometry="F1", phi0=np.pi / 128
    )[0]
    got = sm.sh.convert(sm.sh.project(image, RINGS, order=ORDER, texels="points"), dst="healpy")
    # 8192 random terms near 4 round by √8192 ε of it: 8e-14.
    assert np.abs(got - a).max() < 1e-12
    # Degrees up to 51 as well: 51 + 12 < 64, so Fejér's rule keeps them out of the first 12.
    c = np.random.default_rng(0).normal(size=52**2)
    image = sm.sh.evaluate(c, d)
    # Values are near 15 here, their recurrences of 51 degrees and not 12: ten times the limit
    # above.
    assert (
        np.abs(
            sm.sh.project(image, RINGS, order=ORDER, texels="points") - c[: (ORDER + 1) ** 2]
        ).max()
        < 1e-11
    )


def test_healpy_on_its_own_pixels() -> None:
    import healpy

    c = np.random.default_rng(1).normal(size=(ORDER + 1) ** 2)
    a = sm.sh.convert(c, dst="healpy")
    nside = 16
    d = np.stack(healpy.pix2vec(nside, np.arange(12 * nside**2)), -1)
    # 169 terms by recurrences of 12 degrees, an ε each: 169·12 ε, 4.5e-13.
    assert np.abs(healpy.alm2map(a, nside, lmax=ORDER) - sm.sh.evaluate(c, d)).max() < 1e-12


def test_pyshtools_expands_the_same_function() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import pyshtools

    c = np.random.default_rng(2).normal(size=(ORDER + 1) ** 2)
    both = sm.sh.convert(c, dst="pyshtools")
    d = np.random.default_rng(3).normal(size=(30, 3))
    lat = np.degrees(np.arctan2(d[:, 2], np.hypot(d[:, 0], d[:, 1])))
    lon = np.degrees(np.arctan2(d[:, 1], d[:, 0]))
    found = pyshtools.expand.MakeGridPoint
    want = [found(both, lat=a, lon=b, norm=1, csphase=1) for a, b in zip(lat, lon, strict=True)]
    # 169 terms by recurrences of 12 degrees, an ε each: 169·12 ε, 4.5e-13.
    assert np.abs(sm.sh.evaluate(c, d) - want).max() < 1e-12
