"""Options of `convert`: many files, standard output, types, channels, sizes, the sun."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from spheremap.cli import files
from spheremap.map.flat import flat
from test_cli import bad, good, process, run, smooth

TURN = ("--from", "latlong", "--to", "octahedral")


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    d = sm.directions("latlong", 48)
    alpha = np.full((48, 96, 1), 0.5, np.float32)
    io.write(path, np.concatenate([np.abs(smooth(d)), alpha], -1), channels=("R", "G", "B", "A"))
    return path


def test_many_images_in_one_process_and_a_summary(sky: Path, tmp_path: Path) -> None:
    other, broken = tmp_path / "other.exr", tmp_path / "broken.exr"
    other.write_bytes(sky.read_bytes())
    broken.write_bytes(b"no image")
    pattern = str(tmp_path / "{stem}_oct.exr")
    done = process("convert", sky, broken, other, *TURN, "-o", pattern, "--size", 8)
    assert done.returncode == 1
    failed, summary = done.stderr.splitlines()
    assert failed.startswith(f"error: {broken}: ") and summary == "2 of 3 images converted"
    assert len(done.stdout.splitlines()) == 2
    for name in ("sky", "other"):
        assert io.read(tmp_path / f"{name}_oct.exr").shape == (8, 8, 4)
    assert not (tmp_path / "broken_oct.exr").exists()
    assert "2 of 2" in good("convert", sky, other, *TURN, "-o", pattern, "--size", 8)


def test_output_names_that_cannot_be(sky: Path, tmp_path: Path) -> None:
    many = ("convert", sky, tmp_path / "b.exr", *TURN)
    bad(*many, "-o", "out.exr", code=2, says="{stem}")
    bad(*many, "-o", "{frame}.exr", code=2, says="{frame}")
    bad(*many, "-o", "{stem.exr", code=2, says="--output")
    bad("convert", sky, *TURN, code=2, says="IN and OUT")
    copies = ("convert", tmp_path / "a.hdr", tmp_path / "a.exr", *TURN)
    bad(*copies, "-o", f"{tmp_path}/{{stem}}.exr", code=2, says="an input")
    nowhere = tmp_path / "no" / "a.dds"
    bad("convert", sky, nowhere, *TURN, code=1, says="no folder")


def test_standard_output_is_the_file_alone(sky: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "spheremap", "convert", str(sky), "-", *TURN, "--size", "8"]
    done = subprocess.run([*command, "--format", "exr"], capture_output=True, check=True)
    (tmp_path / "piped.exr").write_bytes(done.stdout)
    expected = sm.convert(io.read(sky), "latlong", "octahedral", size=8)
    assert np.array_equal(io.read(tmp_path / "piped.exr"), expected)
    assert b"octahedral, 8 x 8" in done.stderr
    bad("convert", sky, "-", *TURN, code=2, says="--format")
    bad("convert", sky, "-", *TURN, "--format", "gif", code=2, says="gif")
    bad("convert", sky, tmp_path / "a.exr", *TURN, "--format", "exr", code=2, says="--format")


def test_no_clobber_keeps_what_is_there(sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    out.write_bytes(b"precious")
    bad("convert", sky, out, *TURN, "--no-clobber", code=1, says="--no-clobber keeps it")
    assert out.read_bytes() == b"precious"
    before = sky.read_bytes()
    bad("convert", sky, sky, *TURN, "--no-clobber", code=1, says="--no-clobber")
    assert sky.read_bytes() == before


@pytest.mark.parametrize(
    ("suffix", "option", "dtype"),
    [
        ("exr", ["--half"], "float16"),
        ("exr", ["--float"], "float32"),
        ("tif", ["--bits", 16], "uint16"),
        ("tif", ["--bits", 8], "uint8"),
        ("png", ["--bits", 16], "uint16"),
        ("png", [], "uint8"),
        ("tif", [], "float32"),
    ],
)
def test_the_type_that_is_asked_for(
    suffix: str, option: list[object], dtype: str, sky: Path, tmp_path: Path
) -> None:
    out = tmp_path / f"out.{suffix}"
    good("convert", sky, out, *TURN, "--size", 8, *option)
    assert io.read(out).dtype == dtype


def test_suns_that_half_floats_do_not_hold_are_clipped(tmp_path: Path) -> None:
    light = np.ones((8, 16, 3), np.float32)
    light[2, 3] = 1e6, -1e5, 65519
    io.write(tmp_path / "sun.exr", light)
    same = ("--from", "latlong", "--to", "latlong", "--half")
    done = run("convert", tmp_path / "sun.exr", tmp_path / "out.exr", *same)
    assert done.stderr.count("warning: values above 65504 are clipped") == 1
    assert np.array_equal(io.read(tmp_path / "out.exr"), np.clip(light, -65504, 65504))


def test_types_that_a_format_has_not(sky: Path, tmp_path: Path) -> None:
    bad("convert", sky, tmp_path / "a.png", *TURN, "--half", code=2, says="--half is none of .png")
    bad("convert", sky, tmp_path / "a.exr", *TURN, "--bits", 8, code=2, says="--bits 8")
    bad("convert", sky, tmp_path / "a.exr", *TURN, "--bits", 12, code=2, says="8 or 16")
    bad("convert", sky, tmp_path / "a.exr", *TURN, "--half", "--float", code=2, says="not both")
    bad("convert", sky, tmp_path / "a.hdr", *TURN, code=1, says="--drop-alpha")
    bad("convert", sky, tmp_path / "a.exr", *TURN, "--exposure", 1, code=2, says="does nothing")


def test_channels_are_chosen_and_alpha_dropped(sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    good("convert", sky, out, *TURN, "--size", 8, "--channels", "B,R")
    whole = sm.convert(io.read(sky), "latlong", "octahedral", size=8)
    assert io.channel_names(out) in (("B", "R"), ("R", "B"))
    columns = ["RGBA".index(name) for name in io.channel_names(out)]
    assert np.array_equal(io.read(out), whole[..., columns])
    good("convert", sky, tmp_path / "out.hdr", *TURN, "--size", 8, "--drop-alpha")
    assert io.channel_names(tmp_path / "out.hdr") == ("R", "G", "B")
    bad("convert", sky, out, *TURN, "--channels", "R,Z", code=2, says="no channel 'Z'")
    bad("convert", sky, out, *TURN, "--channels", "", code=2, says="no channel ''")
    bad("convert", sky, out, *TURN, "--channels", "R,R", code=2, says="'R' is named twice")


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("perspective(fov=75, aspect=16/9)", (720, 1280)),
        ("perspective(fov=75, aspect=4/3)", (48, 64)),
        ("perspective(fov=75, aspect=9/16)", (1280, 720)),
        ("perspective(fov=75, aspect=1179/2556)", (2556, 1179)),
        ("perspective(fov=20, aspect=0.05)", (2000, 100)),
        ("perspective(fov=75, aspect=20)", (62, 1240)),
        ("tetrahedral", (97, 224)),
        ("lambert_cylindrical", (70, 220)),
        ("miller", (110, 150)),
        ("cube", (750, 1000)),
    ],
)
def test_a_width_is_that_of_the_nearest_height(name: str, shape: tuple[int, int]) -> None:
    p = flat(name, None)
    assert p.shape(files.size_of_width(p, shape[1])) == shape
    assert p.shape(files.size_of_height(p, shape[0]))[0] == shape[0]


@pytest.mark.parametrize(
    ("option", "shape"),
    [(("--width", "96"), (48, 96)), (("--height", "1k"), (1024, 2048)), (("--size", 24), (24, 48))],
)
def test_sizes(option: tuple[str, str], shape: tuple[int, int], sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    good("convert", sky, out, "--from", "latlong", "--to", "latlong", *option)
    assert io.read(out).shape[:2] == shape
    bad("convert", sky, out, *TURN, "--width", "4kk", code=2, says="--width")
    bad(
        "convert",
        sky,
        out,
        "--from",
        "latlong",
        "--to",
        "latlong",
        "--width",
        97,
        code=2,
        says="a width that latlong can have, as 96 or 98, got 97",
    )


def test_the_sun_is_found_named_and_faced(tmp_path: Path) -> None:
    image = np.full((128, 256, 3), 0.5, np.float32)
    image[30, 200] = 3000
    source, out = tmp_path / "sky.exr", tmp_path / "out.exr"
    io.write(source, image)
    said = json.loads(good("info", source, "--json"))
    sun = said["light"]["sun"]
    toward = sm.directions("latlong", 128)[30, 200]
    # One texel: its center, to the rounding of a few sines.
    assert sun["direction"] == pytest.approx(toward, abs=1e-12)
    assert sun["azimuth"] == pytest.approx(200.5 / 256 * 360 - 180, abs=1e-9)
    assert sun["elevation"] == pytest.approx(90 - 30.5 / 128 * 180, abs=1e-9)
    assert sun["pixel"] == pytest.approx([200.5, 30.5], abs=1e-9)
    assert sm.rotation(*sun["rotate"]) @ toward == pytest.approx([0, 0, -1], abs=1e-12)
    good(
        "convert", source, out, "--from", "latlong", "--to", "latlong", "--face-sun", "--width", 256
    )
    row, column = np.unravel_index(io.read(out)[..., 0].argmax(), (128, 256))
    # The center lies where four texels meet.
    assert row in (63, 64) and column in (127, 128)
    flat = tmp_path / "flat.exr"
    io.write(flat, np.ones((8, 16, 3), np.float32))
    bad("convert", flat, out, *TURN, "--face-sun", code=1, says="no sun")


def test_json_has_no_nan(tmp_path: Path) -> None:
    io.write(tmp_path / "a.exr", np.full((8, 16, 3), np.nan, np.float32))
    said = json.loads(good("info", tmp_path / "a.exr", "--json"), parse_constant=pytest.fail)
    assert said["channels"][0]["mean"] is None and said["channels"][0]["nan"] == 128


def test_verbose_times_each_step(sky: Path, tmp_path: Path) -> None:
    said = good("convert", sky, tmp_path / "a.exr", *TURN, "--size", 8, "-v")
    assert all(word in said for word in ("read in", "converted in", "written in"))
    assert "read in" not in run("convert", sky, tmp_path / "a.exr", *TURN, "--size", 8).stdout
