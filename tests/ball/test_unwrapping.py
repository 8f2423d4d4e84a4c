"""How a photo is looked up: places from tables, and as many lookups as there are pixels."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from spheremap.ball import photo as photo_module
from spheremap.ball.aiming import Aim
from spheremap.ball.camera import Outline, view

VIEWS = {
    "ideal": view((480, 640), Outline((300, 250), 100, 100)),
    "ideal ellipse": view((480, 640), Outline((300, 250), 120, 100, 0.4)),
    "off the axis": view((480, 640), Outline((500, 300), 100, 100), fov=40),
    "near": view((480, 640), None, center=(650, 120), fov=90, distance=1.4),
    "far": view((480, 640), Outline((300, 250), 100, 100), distance=1e6),
}


@pytest.mark.parametrize("name", VIEWS)
def test_tables_are_the_camera(name):
    v, d = VIEWS[name], random_directions(20_000, 1)
    turn = sm.rotation(20, 30, 40)
    aim = Aim(v, turn, inset=0.0)
    rays, spot = aim.places(d)
    x, y = aim.pixels(rays)
    want = v.pixels(d @ turn)
    # NaN in the blind cone alone. 4096 steps leave 1e-8 of a radius of 100, and 1e-5 pixels where
    # the ball is so near that it fills 90°.
    np.testing.assert_allclose(np.stack([x, y], axis=-1), want, atol=1e-5)
    for found, exact in zip(
        aim.pixels_per_radian(rays, x, y, spot), v.pixels_per_radian(d @ turn), strict=True
    ):
        # Steps are straight lines: 1e-5 of a slope, and of the few pixels where it ends at the rim.
        np.testing.assert_allclose(found, exact, rtol=1e-4, atol=1e-3)


def test_places_keep_off_the_rim():
    v, d = VIEWS["near"], random_directions(20_000, 2)
    aim = Aim(v, np.eye(3), inset=2.0)
    x, y = aim.pixels(aim.places(d)[0])
    seen = np.isfinite(x)
    place = v.outline.relative(np.stack([x, y], axis=-1)[seen])
    short = min(v.outline.along, v.outline.across)
    # Two pixels, but for what bends over that little.
    assert np.hypot(*place.T).max() < 1 - 1.99 / short


def test_each_pixel_is_looked_up_about_once(monkeypatch):
    looked_up = []

    def counted(image, d, *args, **options):
        looked_up.append(np.size(d) // 3)
        return sm.sample(image, d, *args, **options)

    monkeypatch.setattr(photo_module, "sample", counted)
    photo = np.ones((256, 256, 3), np.float32)
    ball = dict(center=(128, 128), radius=127, fov=30)
    found = sm.ball.unwrap(photo, **ball)
    texels, pixels = found.spacing.size, np.pi * 127**2
    # Texels once. Sides of 1.29 pixels are the first that are divided in two: (2/1.29)²
    # lookups for a pixel, and some texels are seen by pixels of a longer shape.
    assert sum(looked_up) < texels + 3 * pixels
    looked_up.clear()
    sm.ball.unwrap(photo, size=16, **ball)
    # Sides are divided into 1, 2, 3, 4, 6, ...: up to 1.5 times as many as wanted, each way.
    assert sum(looked_up) < 3 * pixels


def test_the_filling_is_one_that_the_photo_holds():
    def unwrap(fill):
        photo = np.ones((50, 50, 3), np.uint8)
        options = {"center": (25, 25), "radius": 20, "distance": 3.0, "size": 16}
        return sm.ball.unwrap(photo, fill=fill, **options)

    for fill, said in ((np.nan, "NaN"), (300, "300"), (-5, "-5")):
        with pytest.raises(ValueError, match=f"`fill` {said} is no value of uint8"):
            unwrap(fill)
    with pytest.raises(ValueError, match="`fill` to have one number for each of 3 channels, got 2"):
        unwrap([1, 2])
    found = unwrap([1, 2, 255])
    assert not found.seen.all() and (found.image[~found.seen] == [1, 2, 255]).all()
