"""Turns between frames of the sky against astropy."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import spheremap as sm
from astropy.coordinates import (
    ICRS,
    BarycentricMeanEcliptic,
    CartesianRepresentation,
    Galactic,
)
from conftest import random_directions
from spheremap import healpix

FRAMES = {"icrs": ICRS(), "galactic": Galactic(), "ecliptic": BarycentricMeanEcliptic()}


@pytest.mark.parametrize(("src", "dst"), list(itertools.product(FRAMES, repeat=2)))
def test_turns_equal_astropy(src, dst):
    d = random_directions(1000, 9)
    there = FRAMES[src].realize_frame(CartesianRepresentation(*d.T)).transform_to(FRAMES[dst])
    rotation = healpix.frame_rotation(src, dst)
    # Constants of 1e-13 rad, and for the ecliptic astropy's own bias, which is given to 1e-12.
    np.testing.assert_allclose(d @ rotation.T, there.cartesian.xyz.value.T, rtol=0, atol=2e-12)
    # A product of rotations: some ε.
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=1e-15)
    assert np.linalg.det(rotation) > 0


def test_a_map_is_turned_as_its_directions_are():
    faces = healpix.to_image(healpix.pix2vec(64, np.arange(12 * 64**2)))
    turned = sm.convert(
        faces,
        "healpix:healpy",
        "healpix:healpy",
        size=8,
        antialias=False,
        rotation=healpix.frame_rotation("galactic", "icrs"),
    )
    want = sm.directions("healpix:healpy", 8) @ healpix.frame_rotation("icrs", "galactic").T
    # Bilinear between centers 0.016 rad apart: off by a third beside vertices of three faces.
    np.testing.assert_allclose(turned, want, rtol=0, atol=5e-3)


def test_other_frames_are_errors():
    with pytest.raises(ValueError, match="`dst` must be 'icrs', 'galactic' or 'ecliptic', got 'C'"):
        healpix.frame_rotation("icrs", "C")
    with pytest.raises(TypeError, match="`src` to be a str, got int"):
        healpix.frame_rotation(3, "icrs")
