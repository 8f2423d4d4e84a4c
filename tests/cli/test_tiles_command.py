"""Pyramids of tiles, by the command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from other_files import put
from spheremap import io
from test_cli import bad, good, process, run


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    io.write(path, np.abs(sm.directions("latlong", 64)).astype(np.float32) * 3)
    return path


def files(folder: Path) -> dict[str, bytes]:
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def test_it_writes_what_the_function_does(sky: Path, tmp_path: Path) -> None:
    options = ["--format", "pannellum", "--tile-size", 16, "--size", 32, "--tonemap", "reinhard"]
    said = good("tiles", sky, tmp_path / "a", *options, "--exposure", 1, "--no-page")
    assert "config.json: latlong as pannellum, 6 x 32 x 32, 2 levels, 30 tiles" in said
    sm.tiles.write(
        io.read(sky), "latlong", tmp_path / "b", format="pannellum", tile_size=16, size=32,
        curve="reinhard", exposure=1, title="sky", page=False,
    )  # fmt: skip
    assert files(tmp_path / "a") == files(tmp_path / "b")


@pytest.mark.parametrize("format", ["marzipano", "hips"])
@pytest.mark.parametrize("kind", ["light", "picture", "alpha"])
def test_little_memory_writes_the_same(format: str, kind: str, tmp_path: Path) -> None:
    light = np.abs(sm.directions("latlong", 64)).astype(np.float32) * 3
    source = tmp_path / ("sky.exr" if kind == "light" else "sky.png")
    pixels = light if kind == "light" else io.tonemap(light)
    if kind == "alpha":
        pixels = np.dstack([pixels, np.full((64, 128), 99, np.uint8)])
    io.write(source, pixels)
    options = ["--format", format, "--tile-size", 16, "--size", 32, "--rotation", 10, 20, 30]
    options += ["--world", "literal"]
    said = [
        good("tiles", source, tmp_path / name, *options, *more)
        for name, more in (("a", []), ("b", ["--memory", "256M"]))
    ]
    found, wanted = files(tmp_path / "b"), files(tmp_path / "a")
    for held in (found, wanted):
        held.pop("properties", None)
    assert found == wanted
    cut = [line for text in said for line in text.splitlines() if "is cut at 1" in line]
    assert len(cut) == 2 * (kind == "light") and len(set(cut)) <= 1


@pytest.mark.parametrize("suffix", [".exr", ".png"])
def test_the_largest_level_is_what_convert_writes(suffix: str, sky: Path, tmp_path: Path) -> None:
    source = tmp_path / f"in{suffix}"
    light = io.read(sky)
    io.write(source, light if suffix == ".exr" else io.tonemap(light))
    options = ["--format", "photo-sphere-viewer", "--size", 32, "--extension", "png"]
    good("tiles", source, tmp_path / "a", *options)
    good("convert", source, tmp_path / "out.png", "--from", "latlong", "--to", "latlong",
         "--size", 32)  # fmt: skip
    assert np.array_equal(io.read(tmp_path / "a/base.png"), io.read(tmp_path / "out.png"))


def test_it_says_what_is_cut(sky: Path, tmp_path: Path) -> None:
    said = good("tiles", sky, tmp_path / "a", "--format", "deepzoom", "--exposure", -1)
    assert "light up to 1.5 is cut at 1; --tonemap reinhard compresses it" in said
    for name, options in (("b", ["--exposure", -3]), ("c", ["--tonemap", "reinhard"])):
        assert "is cut" not in good("tiles", sky, tmp_path / name, "--format", "deepzoom", *options)


def test_a_survey_has_channels_and_properties(sky: Path, tmp_path: Path) -> None:
    done = run("tiles", sky, tmp_path / "a", "--format", "hips", "--extension", "fits",
               "--channels", "G", "--frame", "galactic", "--tile-size", 64,
               "--property", "obs_ack=us = all")  # fmt: skip
    assert done.returncode == 0 and "is cut" not in done.stdout
    # The world of the sky is another.
    assert "+z" in done.stderr
    lines = (tmp_path / "a/properties").read_text().splitlines()
    assert "obs_ack              = us = all" in lines
    assert "hips_frame           = galactic" in lines


def test_alpha_is_black(tmp_path: Path) -> None:
    picture = np.full((16, 32, 4), 200, np.uint8)
    picture[..., 3] = np.where(np.arange(32) < 16, 0, 255)
    io.write(tmp_path / "a.png", picture)
    good("tiles", tmp_path / "a.png", tmp_path / "a", "--format", "deepzoom", "--extension", "png")
    seen = io.read(tmp_path / "a/panorama_files/5/0_0.png")
    assert seen.shape == (16, 32, 3)
    assert (seen[:, :16] == 0).all() and (seen[:, 16:] == 200).all()


@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_alpha_is_black_in_every_way(dtype: type, count: int, tmp_path: Path) -> None:
    most = np.iinfo(dtype).max
    picture = np.random.default_rng(1).integers(0, most, (16, 32, count), dtype, endpoint=True)
    # What is seen of 200 of 255, by the formula of sRGB: opaque, half as much light, and none.
    picture[:, :18, :-1] = 200 * (most // 255)
    for k, cover in enumerate((255, 128, 0)):
        picture[:, 6 * k : 6 * k + 6, -1] = cover * (most // 255)
    half = ((200 / 255 + 0.055) / 1.055) ** 2.4 * 128 / 255
    seen = [200, round(255 * (1.055 * half ** (1 / 2.4) - 0.055)), 0]
    path = tmp_path / "a.png"
    io.write(path, picture)
    options = {"format": "deepzoom", "extension": "png"}
    sm.tiles.write(picture, "latlong", tmp_path / "a", **options, title="a")
    sm.tiles.write_file(path, "latlong", tmp_path / "b", **options, title="a")
    command = ("tiles", path, tmp_path / "c", "--format", "deepzoom", "--extension", "png")
    good(*command)
    found = io.read(tmp_path / "a/panorama_files/5/0_0.png")
    assert found[8, [3, 9, 15], 0].tolist() == seen
    assert files(tmp_path / "a") == files(tmp_path / "b") == files(tmp_path / "c")


def test_a_file_says_whether_alpha_is_straight(tmp_path: Path) -> None:
    light = np.full((16, 32, 4), 0.5, np.float32)
    options = {"format": "deepzoom", "extension": "png"}
    for alpha, cover in (("straight", 0.25), ("premultiplied", 0.5)):
        path, folder = tmp_path / f"{alpha}.tif", tmp_path / alpha
        put(path, light, **{"oiio:UnassociatedAlpha": int(alpha == "straight")})
        assert io.header(path).alpha == alpha
        sm.tiles.write_file(path, "latlong", folder / "a", **options, title=alpha)
        good("tiles", path, folder / "b", "--format", "deepzoom", "--extension", "png")
        seen = io.tonemap(np.full((1, 1, 3), cover, np.float32), curve="none")
        assert (io.read(folder / "a/panorama_files/5/0_0.png") == seen).all()
        assert files(folder / "a") == files(folder / "b")


def test_what_does_not_go_together_is_one_line(sky: Path, tmp_path: Path) -> None:
    out, full = tmp_path / "out", tmp_path / "full"
    full.mkdir()
    (full / "a.txt").write_text("a")
    pannellum = ("--format", "pannellum")
    bad("tiles", sky, out, code=2, says="--format")
    bad("tiles", sky, out, "--format", "krpano", code=2, says="'photo-sphere-viewer'")
    bad("tiles", sky, out, *pannellum, "--extension", "fits", code=2, says="is of hips alone")
    bad("tiles", sky, out, *pannellum, "--frame", "galactic", code=2, says="--frame does nothing")
    bad("tiles", sky, out, *pannellum, "--property", "a=b", code=2, says="--property does nothing")
    bad("tiles", sky, out, *pannellum, "--size", "x", code=2, says="--size is a number")
    bad("tiles", sky, out, *pannellum, "--from", "nothing", code=2, says="unknown projection")
    bad("tiles", sky, out, *pannellum, "--extension", "png", "--quality", 5, code=2, says="--qual")
    bad("tiles", sky, out, "--format", "hips", "--tile-size", 100, code=2, says="a power of two")
    bad("tiles", sky, out, "--format", "hips", "--property", "a", code=2, says="NAME=VALUE")
    bad("tiles", sky, out, "--format", "hips", "--extension", "fits", code=1, says="one channel")
    bad("tiles", sky, full, *pannellum, code=1, says="the folder is not empty")
    bad("tiles", sky, sky, *pannellum, code=1, says="it is no folder")
    bad("tiles", tmp_path / "none.exr", out, *pannellum, code=1, says="none.exr")
    (tmp_path / "text.png").write_text("no image")
    bad("tiles", sky, out, *pannellum, "--memory", "much", code=2, says="--memory is a number of")
    bad("tiles", sky, out, *pannellum, "--memory", 0, code=1, says="--memory to be at least 1342")
    bad("tiles", sky, out, *pannellum, "--memory", "1M", code=1, says="--memory to be at least 13")
    for name in ("none.exr", "text.png"):
        bad("tiles", tmp_path / name, out, *pannellum, "--memory", "1G", code=1, says=name)
    io.write(tmp_path / "a.png", np.zeros((16, 32, 3), np.uint8))
    bad("tiles", tmp_path / "a.png", out, *pannellum, "--exposure", 1, code=2, says="do nothing")
    assert not out.exists()


def test_a_process_does_the_same(sky: Path, tmp_path: Path) -> None:
    done = process("tiles", sky, tmp_path / "a", "--format", "marzipano")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads((tmp_path / "a/data.json").read_text())["name"] == "sky"
