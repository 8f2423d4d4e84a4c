"""pycolmap against the row of its name."""

from __future__ import annotations

import numpy as np
import pycolmap
import pytest
import spheremap as sm
from conftest import random_directions


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    version = f"pycolmap {pycolmap.__version__}"
    record_property("oracle", version)
    print(f"ran against {version}")


def panorama(height: int) -> pycolmap.Camera:
    size = {"width": 2 * height, "height": height}
    return pycolmap.Camera(model="EQUIRECTANGULAR", params=[2 * height, height], **size)


def test_panoramas_are_cameras():
    theirs = panorama(640)
    d = random_directions(12_000, 411)
    there = np.asarray(theirs.img_from_cam(d))
    xy = sm.directions_to_pixels(d, "latlong:colmap", (640, 1280))
    # A few roundings of numbers up to 1280; another grid is off by half a pixel.
    assert np.abs(xy - there).max() < 1e-11
    rays = np.asarray(theirs.cam_ray_from_img(there))
    ours = sm.pixels_to_directions(there, "latlong:colmap", (640, 1280))
    # A few roundings of numbers at most 1.
    assert np.abs(ours - rays).max() < 1e-14


def test_it_would_notice_other_axes():
    d = random_directions(1000, 412)
    there = np.asarray(panorama(640).img_from_cam(d))
    for axes in ("+x -y -z", "-x +y +z", "+x -y +z"):
        p = sm.projection("latlong", convention="colmap", axes=axes)
        assert np.nanmax(np.abs(sm.directions_to_pixels(d, p, (640, 1280)) - there)) > 1
