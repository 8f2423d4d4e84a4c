"""Panoramas into views and back, by the commands `views` and `stitch`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from test_cli import bad, good

SIZE = (64, 128)


def scene(d: np.ndarray) -> np.ndarray:
    waves = np.sin(np.asarray(d) @ np.array([[2, 1, 0], [0, 3, 1], [-1, 0, 2.0]]))
    return np.asarray(np.nan_to_num(0.5 + 0.4 * waves), np.float32)


def eight_bits(image: np.ndarray) -> np.ndarray:
    return np.rint(255 * image).astype(np.uint8)


@pytest.fixture
def panorama(tmp_path: Path) -> Path:
    path = tmp_path / "pano.png"
    io.write(path, eight_bits(scene(sm.directions("latlong", SIZE))))
    return path


def test_views_are_those_of_the_rig(panorama: Path, tmp_path: Path) -> None:
    out = tmp_path / "scene"
    said = good("views", panorama, "-o", out, "--n", 8, "--size", "48x32", "--photographer", 30)
    rig = sm.cameras.rig((32, 48), n=8)
    assert f"{len(rig)} views of 48 x 32" in said and "of 1 panorama in" in said
    names = {path.name for path in out.iterdir()}
    assert names == {
        "cameras.txt", "images", "images.txt", "masks", "points3D.txt", "rig_config.json",
    }  # fmt: skip
    want = rig.convert(io.read(panorama), "latlong")
    masks = sm.cameras.masks(rig, nearest=False, photographer=30)
    for view, pixels, mask in zip(rig, want, masks, strict=True):
        assert np.array_equal(io.read(out / "images" / view.name / "pano.png"), pixels)
        written = io.read(out / "masks" / view.name / "pano.png.png")[..., 0]
        assert np.array_equal(written > 0, mask)
    back = sm.cameras.read(out)
    assert [view.name for view in back] == [f"{view.name}/pano.png" for view in rig]


def test_without_a_size_no_detail_is_lost(panorama: Path, tmp_path: Path) -> None:
    good("views", panorama, "-o", tmp_path / "scene", "--fov", 90, "--overlap", 0)
    pixels = io.read(tmp_path / "scene/images/view00/pano.png")
    # A pixel of the panorama is 2.8 degrees: 90 degrees are 32 of them, and 41 in the middle.
    assert 28 <= pixels.shape[0] == pixels.shape[1] <= 44


def test_a_folder_at_once(panorama: Path, tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    for k in range(3):
        io.write(folder / f"{k}.jpg", np.roll(io.read(panorama), 10 * k, axis=1))
    (folder / "notes.txt").write_text("nothing")
    out = tmp_path / "scene"
    options = ["--n", 6, "--size", 16]
    assert "of 3 panoramas in" in good("views", folder, "-o", out, "--masks", *options)
    # Where the others stood is what COLMAP finds.
    assert {path.name for path in out.iterdir()} == {"images", "masks", "rig_config.json"}
    config = json.loads((out / "rig_config.json").read_text())
    prefixes = [camera["image_prefix"] for camera in config[0]["cameras"]]
    for prefix in prefixes:
        assert {path.name for path in (out / "images" / prefix).iterdir()} == {
            "0.jpg", "1.jpg", "2.jpg",
        }  # fmt: skip
        assert len(list((out / "masks" / prefix).iterdir())) == 3
    bad("views", folder, "-o", out, "--format", "nerfstudio", code=2, says="of one panorama, got 3")
    bad("views", folder, "-o", out, *options, "--no-clobber", code=1, says="is there")


def test_splats_get_their_file(panorama: Path, tmp_path: Path) -> None:
    out = tmp_path / "splats"
    options = ["--n", 6, "--size", 16, "--format", "nerfstudio", "--masks"]
    good("views", panorama, "-o", out, *options)
    for frame in json.loads((out / "transforms.json").read_text())["frames"]:
        assert (out / frame["file_path"]).is_file() and (out / frame["mask_path"]).is_file()


def test_light_is_cut_or_kept(tmp_path: Path) -> None:
    path = tmp_path / "sky.exr"
    io.write(path, 3 * scene(sm.directions("latlong", SIZE)))
    options = ["--n", 6, "--size", 16]
    good("views", path, "-o", tmp_path / "a", *options, "--tonemap", "reinhard", "--exposure", -1)
    assert io.read(tmp_path / "a/images/view00/sky.png").dtype == np.uint8
    good("views", path, "-o", tmp_path / "b", *options, "--extension", "exr")
    light = io.read(tmp_path / "b/images/view00/sky.exr")
    assert light.dtype.kind == "f" and light.max() > 1


def test_there_and_back(panorama: Path, tmp_path: Path) -> None:
    out, back = tmp_path / "scene", tmp_path / "back.png"
    good("views", panorama, "-o", out, "--n", 10, "--size", 64)
    said = good("stitch", out / "images", "-o", back, "--cameras", out, "--size", 64)
    assert "latlong, 128 x 64, covers 100.0%; " in said
    # Twice through texels of 2.8 degrees: (h k)²/8 · 0.4 with k up to 4, and two roundings.
    assert np.abs(io.read(back).astype(int) - io.read(panorama)).max() <= 4
    files = sorted((out / "images").rglob("*.png"), reverse=True)
    again = tmp_path / "again.png"
    good("stitch", *files, "-o", again, "--cameras", out / "cameras.txt", "--size", 64)
    assert np.array_equal(io.read(again), io.read(back))


def test_splats_go_back(panorama: Path, tmp_path: Path) -> None:
    out, back = tmp_path / "ns", tmp_path / "back.png"
    good("views", panorama, "-o", out, "--n", 6, "--size", 16, "--format", "nerfstudio")
    files = sorted((out / "images").rglob("*.png"), reverse=True)
    cameras = ["--cameras", out / "transforms.json", "--size", 32]
    good("stitch", out, "-o", back, *cameras)
    want = io.read(back)
    moved = tmp_path / "elsewhere"
    (out / "images").rename(moved)
    for sources in ([moved], [moved / path.relative_to(out / "images") for path in files]):
        good("stitch", *sources, "-o", back, *cameras)
        assert np.array_equal(io.read(back), want)
    # Of the file's own name alone there are six.
    (moved / "view03").rename(moved / "other")
    bad("stitch", moved, "-o", back, *cameras, code=1, says="view03")


@pytest.fixture
def two(tmp_path: Path) -> Path:
    """COLMAP's cameras of two pictures; the name of one ends with that of the other."""
    folder = tmp_path / "sw"
    folder.mkdir()
    (folder / "cameras.txt").write_text("1 PINHOLE 16 16 8 8 8 8\n")
    (folder / "images.txt").write_text("1 1 0 0 0 0 0 0 1 1.png\n\n2 0 0 1 0 0 0 0 1 11.png\n\n")
    for name, value in (("1.png", 50), ("11.png", 200)):
        io.write(folder / name, np.full((16, 16), value, np.uint8))
    return folder


def test_pictures_are_matched_by_whole_names(two: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.png"
    names = ["11.png", "1.png"]
    cameras = ["-o", out, "--cameras", two, "--size", 32]
    for some in (names, names[::-1]):
        good("stitch", *[two / name for name in some], *cameras)
        pixels = io.read(out)
        # Ahead and behind.
        assert (pixels[16, 32].flat[0], pixels[16, 0].flat[0]) == (50, 200)
    other = tmp_path / "x1.png"
    io.write(other, np.zeros((16, 16), np.uint8))
    bad("stitch", two / "11.png", other, *cameras, code=2, says="none that of '1.png'")
    io.write(tmp_path / "1.png", np.zeros((16, 16), np.uint8))
    both = [two / "1.png", tmp_path / "1.png", two / "11.png"]
    bad("stitch", *both, *cameras, code=2, says="'1.png' is the name of 2 pictures")
    # No name is that of a view: by order, as many as there are.
    last = tmp_path / "x2.png"
    io.write(last, np.full((16, 16), 90, np.uint8))
    good("stitch", last, other, *cameras)
    assert io.read(out)[16, 32].flat[0] == 90
    bad("stitch", last, *cameras, code=2, says="2 cameras and 1 pictures")


@pytest.fixture
def raw(tmp_path: Path) -> Path:
    path = tmp_path / "raw.png"
    lenses = sm.projection("dual_fisheye", fov=200, layout="strip")
    picture = scene(lenses.in_world_of("latlong").directions((128, 256)))
    picture[:, 128:] *= np.float32(0.7)
    io.write(path, eight_bits(picture))
    return path


def test_a_raw_picture_of_both_lenses(raw: Path, tmp_path: Path) -> None:
    out = tmp_path / "pano.png"
    lens = "dual_fisheye(fov=200)"
    options = ["--size", 64, "--match-exposure", "--blend", "bands", "--rotation", 20, 10, 0]
    good("stitch", raw, "-o", out, "--cameras", lens, *options)
    want = sm.cameras.stitch(
        io.read(raw), lens, "latlong", size=64, exposure="match", blend="bands",
        rotation=sm.rotation(20, 10, 0),
    )  # fmt: skip
    assert np.array_equal(io.read(out), want)
    front, rear = tmp_path / "front.png", tmp_path / "rear.png"
    io.write(front, io.read(raw)[:, :128])
    io.write(rear, io.read(raw)[:, 128:])
    good("stitch", front, rear, "-o", out, "--cameras", "angular(fov=200)", "--size", 64)
    want = sm.cameras.stitch(
        [io.read(front), io.read(rear)], sm.cameras.back_to_back("angular(fov=200)"), "latlong",
        size=64,
    )  # fmt: skip
    assert np.array_equal(io.read(out), want)


def test_calibrations_and_masks(raw: Path, tmp_path: Path) -> None:
    pictures = [tmp_path / "front.png", tmp_path / "rear.png"]
    for path, part in zip(pictures, np.hsplit(io.read(raw), 2), strict=True):
        io.write(path, part)
    focal = 128 / np.radians(200)
    (tmp_path / "cameras.txt").write_text(
        f"1 OPENCV_FISHEYE 128 128 {focal} {focal} 64 64 0 0 0 0\n"
    )
    out = tmp_path / "pano.exr"
    cameras = ["--cameras", tmp_path / "cameras.txt"]
    said = good("stitch", *pictures, "-o", out, *cameras, "--fov", 198, "--size", 32)
    assert "covers 100.0%" in said
    assert io.read(out).dtype.kind == "f" and np.isfinite(io.read(out)).all()
    black = tmp_path / "black.png"
    io.write(black, np.zeros((128, 128), np.uint8))
    white = tmp_path / "white.png"
    io.write(white, np.full((128, 128), 255, np.uint8))
    masks = ["--mask", white, "--mask", black]
    said = good("stitch", *pictures, "-o", out, *cameras, *masks, "--fov", 180, "--size", 32)
    assert "covers 5" in said or "covers 4" in said


def test_what_does_not_go_together_is_told(panorama: Path, raw: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    bad("views", panorama, "-o", out, "--n", 6, "--fov", 90, code=2, says="--n or --fov")
    bad("views", panorama, "-o", out, "--n", 3, code=2, says="[4, 500]")
    bad("views", panorama, panorama, "-o", out, code=2, says="names of their own")
    bad("views", tmp_path / "none.png", "-o", out, code=1, says="none.png")
    bad("views", panorama, "-o", out, "--size", "big", code=2, says="--size")
    bad("views", panorama, "-o", out, "--size", 16, "--exposure", 1, code=2, says="integers")
    bad("views", panorama, "-o", out, "--from", "latlog", code=2, says="latlong")
    assert not out.exists()
    empty = tmp_path / "empty"
    empty.mkdir()
    bad("views", empty, "-o", out, code=1, says="no image is in")
    lens = ["--cameras", "dual_fisheye(fov=200)"]
    target = ["-o", tmp_path / "pano.png"]
    bad("stitch", raw, "-o", raw, *lens, code=2, says="would replace")
    bad("stitch", raw, raw, *target, *lens, code=2, says="of one picture, got 2")
    bad("stitch", raw, *target, "--cameras", "calib.yaml", code=1, says="no such file")
    bad("stitch", raw, *target, "--cameras", "fisheye", code=2, says="angular")
    bad("stitch", raw, *target, *lens, "--mask", raw, "--mask", raw, code=2, says="each of 1")
    bad("stitch", raw, *target, *lens, "--exposure", 1, code=2, says="integers")
    good("views", panorama, "-o", out, "--n", 6, "--size", 16)
    bad("stitch", raw, *target, "--cameras", out, code=2, says="6 cameras and 1 pictures")
    bad("stitch", empty, *target, "--cameras", out, code=1, says="a view of the cameras")
