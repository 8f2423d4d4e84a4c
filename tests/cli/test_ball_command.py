"""`spheremap ball`: photos are light, whatever they are stored as, and nothing is lost by it."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from test_cli import bad, good, run, smooth

RIM = ("--rim", "32,32,24.4", "--fov", 30, "--distance", 5, "--size", 16)


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A photo as a camera keeps it: 8 bits, sRGB."""
    scene = np.abs(smooth(sm.directions("latlong", 64)))
    light = sm.ball.render(scene, size=64, fov=30, distance=5).astype(np.float32)
    path = tmp_path / "photo.png"
    bits = np.clip(io.from_linear(np.clip(light / 8, 0, 1)) * 255, 0, 255)
    io.write(path, np.rint(bits).astype(np.uint8))
    return path


def test_encoded_photos_are_decoded(photo: Path, tmp_path: Path) -> None:
    values = io.read(photo)
    io.write(tmp_path / "light.exr", io.to_linear(values))
    io.write(tmp_path / "values.exr", values / np.float32(255))
    for source in ("photo.png", "light.exr"):
        good("ball", tmp_path / source, "-o", tmp_path / f"{source[:5]}_o.exr", *RIM)
    assert np.array_equal(io.read(tmp_path / "photo_o.exr"), io.read(tmp_path / "light_o.exr"))
    assert io.header(tmp_path / "photo_o.exr").projection == "latlong"
    good("ball", photo, "-o", tmp_path / "a.exr", *RIM, "--colorspace", "linear")
    good("ball", tmp_path / "values.exr", "-o", tmp_path / "b.exr", *RIM)
    assert np.array_equal(io.read(tmp_path / "a.exr"), io.read(tmp_path / "b.exr"))


def test_a_picture_of_the_panorama_is_that_of_convert(photo: Path, tmp_path: Path) -> None:
    for name in ("a.exr", "a.png"):
        good("ball", photo, "-o", tmp_path / name, *RIM)
    same = ("--to", "latlong", "--filter", "nearest")
    done = run("convert", tmp_path / "a.exr", tmp_path / "b.png", *same)
    assert done.returncode == 0, done.stderr
    assert np.array_equal(io.read(tmp_path / "a.png"), io.read(tmp_path / "b.png"))


def test_alpha_of_a_mask_does_not_count(photo: Path, tmp_path: Path) -> None:
    gray = np.full((64, 64, 3), 255, np.uint8)
    gray[:30] = 0
    io.write(tmp_path / "gray.png", gray)
    io.write(tmp_path / "rgba.png", np.concatenate([gray, np.full((64, 64, 1), 255, np.uint8)], -1))
    for name in ("gray", "rgba"):
        mask = tmp_path / f"{name}.png"
        good("ball", photo, "-o", tmp_path / f"{name}.exr", *RIM, "--mask", mask)
    assert np.array_equal(io.read(tmp_path / "gray.exr"), io.read(tmp_path / "rgba.exr"))


def test_no_input_is_replaced_and_no_texture_promised(photo: Path, tmp_path: Path) -> None:
    before = photo.read_bytes()
    bad("ball", photo, "-o", photo, *RIM, code=2, says="would replace")
    bad(
        "ball", photo, "-o", tmp_path / "o.exr", *RIM, "--preview", photo,
        code=2, says="--preview would replace",
    )  # fmt: skip
    bad("ball", photo, "-o", tmp_path / "o.ktx2", *RIM, code=2, says="--output is an image")
    convert = ("convert", photo, tmp_path / "o.exr", "--from", "angular", "--to", "latlong")
    bad(*convert, "--preview", photo, code=2, says="--preview would replace")
    assert photo.read_bytes() == before
    assert os.listdir(tmp_path) == ["photo.png"]
