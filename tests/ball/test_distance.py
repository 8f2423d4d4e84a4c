"""How far the camera was: from two photos, from Exif, or a warning."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import OpenImageIO
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import io
from spheremap.ball.camera import view
from spheremap.cli import exif

D = sm.directions("latlong", 64)
SCENE = (1.2 + np.sin(6 * D) * np.cos(5 * D[..., ::-1])).astype(np.float32)
POSE = sm.rotation(100, 7, -12)


def pair(distance, fov, pose=POSE, size=160):
    """Two photos and their rims."""
    camera = dict(size=size, fov=fov, distance=distance)
    v = view((size, size), None, center=(size / 2, size / 2), fov=fov, distance=distance)
    ball = sm.ball.Ball(v.outline.center, (v.outline.mean,) * 2, 0, 1)
    photos = [sm.ball.render(SCENE, pose=p, **camera) for p in (np.eye(3), pose)]
    return [photo.astype(np.float32) for photo in photos], [ball] * 2


@some_fast(("distance", "fov"), [(4, 45), (6, 30), (12, 15)], fast=[(12, 15)])
def test_two_photos_tell(distance, fov):
    photos, balls = pair(distance, fov)
    found = sm.ball.merge(photos, balls=balls, size=16)
    angle, want = (np.degrees(np.arcsin(1 / x)) for x in (found.distances[0], distance))
    print(f"{want:.2f}°, found {angle:.2f}°, doubt {found.doubt:.2f}°")
    # Taken as infinitely far they were off by all of it: 5° to 14°.
    assert abs(angle - want) < 0.5
    assert abs(angle - want) < 3 * found.doubt < 3
    turn = found.poses[1].T @ POSE
    assert np.degrees(np.arccos(min((np.trace(turn) - 1) / 2, 1))) < 0.3
    # With the camera known nothing is estimated.
    known = sm.ball.merge(photos, balls=balls, size=16, fov=fov)
    assert known.doubt == 0
    # The ball's circle was made from the same numbers, and bisection ends with the last bits.
    assert known.distances[0] == pytest.approx(distance, rel=1e-6)


def test_photos_from_one_place_do_not():
    photos, balls = pair(6, 30, np.eye(3))
    with pytest.warns(UserWarning, match="do not tell how far the camera was"):
        found = sm.ball.merge(photos, balls=balls, size=8)
    assert found.doubt > 3


def test_one_photo_does_not():
    photo = np.ones((64, 64), np.float32)
    ball = sm.ball.Ball((32, 32), (30, 30), 0, 1)
    # atan(30/32 tan 12°) and atan(30/32 tan 37°).
    words = "11° if the photo spans 24°, 35° if 74°"
    with pytest.warns(UserWarning, match=words):
        sm.ball.unwrap(photo, center=(32, 32), radius=30, size=8)
    with pytest.warns(UserWarning, match=words):
        sm.ball.merge([photo], balls=[ball], size=8)
    # Warnings are errors here: one that is meant has none.
    sm.ball.unwrap(photo, center=(32, 32), radius=30, size=8, distance=np.inf)
    sm.ball.merge([photo], balls=[ball], size=8, distance=np.inf)


def stored(path, size, **tags):
    """Write a photo with Exif tags."""
    spec = OpenImageIO.ImageSpec(*size, 3, "uint8")
    for name, value in tags.items():
        spec.attribute(f"Exif:{name}", value)
    file = OpenImageIO.ImageOutput.create(str(path))
    file.open(str(path), spec)
    file.write_image(np.full((size[1], size[0], 3), 128, np.uint8))
    file.close()
    return path


def test_angle_of_exif(tmp_path):
    place = tmp_path / "a.jpg"
    # 50 mm on 36 mm: 2 atan(18/50) = 39.6°, to the five digits of a rational number.
    assert exif.fov(stored(place, (90, 60), FocalLengthIn35mmFilm=50)) == pytest.approx(39.6, 1e-3)
    assert exif.fov(stored(place, (90, 60))) is None
    # 3000 pixels of 8 µm are 24 mm: 2 atan(12/30) = 43.6°.
    sensor = dict(FocalLength=30.0, FocalPlaneXResolution=1250.0, FocalPlaneResolutionUnit=3)
    whole = dict(PixelXDimension=3000, PixelYDimension=2000)
    # The same five digits.
    assert exif.fov(stored(place, (90, 60), **sensor, **whole)) == pytest.approx(43.6, 1e-3)
    assert exif.fov(stored(place, (60, 60), **sensor, **whole)) is None, "cropped"


@pytest.mark.slow
def test_the_command_tells(tmp_path):
    photos, balls = pair(6, 30)
    for name, photo in zip("ab", photos, strict=True):
        io.write(tmp_path / f"{name}.exr", photo)
    rim = "{},{},{}".format(*balls[0].center, balls[0].radius)

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [sys.executable, "-m", "spheremap.cli", "ball", *words, "-o", "o.exr", "--size", "16"],
            cwd=tmp_path, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done

    two = run("a.exr", "b.exr", "--rim", rim, "--rim", rim)
    assert "estimated, rims to " in two.stdout and "radii away" in two.stdout
    assert "residual" in two.stdout and two.stderr == ""
    one = run("a.exr", "--rim", rim)
    assert one.stderr.startswith("warning: the camera is taken to be infinitely far away")
    assert "residual" not in one.stdout
    assert run("a.exr", "--rim", rim, "--distance", "inf").stderr == ""
    stored(tmp_path / "c.tif", (160, 160), FocalLengthIn35mmFilm=50)
    assert "from Exif" in run("c.tif", "--rim", rim).stdout
