"""The subcommands about conventions: conventions, compare, identify."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import spheremap as sm
from scenes import scene
from spheremap import io
from test_cli import bad, good, run

SOURCE = scene(sm.directions("latlong", 120))


def test_conventions_lists_the_table() -> None:
    text = good("conventions")
    for row in sm.conventions():
        assert f"{row['kind']}:{row['name']}" in text
    angular = good("conventions", "angular")
    assert "angular:debevec" in angular and "cube:" not in angular
    bad("conventions", "latlon", code=2, says="did you mean 'latlong'")
    unity = good("conventions", "unity")
    assert "cube:unity" in unity and "latlong:unity" in unity and "unreal" not in unity
    bad("explain", "unity", code=2, says="latlong:unity")
    bad("explain", "cube:strip", code=2, says="it is a layout of 'cube'")
    assert "fov = 60" in good("explain", "perspective(fov=60)")


def test_compare_prints_what_the_library_says() -> None:
    a, b = "latlong:blender", "latlong:threejs"
    assert good("compare", a, b) == f"{sm.align.compare(a, b)}\n"
    bad("compare", a, "cube:ffmpeg", code=2, says="ffmpeg-c3x2")


def test_identify_finds_a_mirrored_image(tmp_path: Path) -> None:
    first, second = tmp_path / "a.exr", tmp_path / "b.exr"
    io.write(first, SOURCE)
    cross = sm.projection("cube", layout="cross")
    io.write(second, sm.convert(SOURCE[:, ::-1], "latlong", cross, size=64))
    text = good("identify", first, second)
    assert "A is taken as latlong, B as cube cross" in text and "one way fits" in text
    best = sm.projection("cube", layout="cross", axes="-x -y +z")
    assert f'axes "{best.axes}"' in text.splitlines()[2]


def test_identify_fails_where_it_cannot_tell(tmp_path: Path) -> None:
    flat = tmp_path / "flat.exr"
    io.write(flat, np.ones((32, 64, 3), np.float32))
    done = run("identify", flat, flat)
    assert done.returncode == 1 and "cannot tell" in done.stdout and done.stderr == ""
    odd = tmp_path / "odd.exr"
    io.write(odd, np.ones((30, 47, 3), np.float32))
    bad("identify", flat, odd, code=1, says="47 x 30")
    bad("identify", flat, flat, "--b", "latlon", code=2, says="did you mean 'latlong'")


def test_convert_says_what_it_did_about_worlds(tmp_path: Path) -> None:
    sky, out = tmp_path / "sky.exr", tmp_path / "cube.exr"
    io.write(sky, SOURCE)
    ways = ["--from", "latlong:blender", "--to", "cube:opengl", "--size", "16"]
    done = run("convert", sky, out, *ways)
    assert done.returncode == 0
    assert done.stderr == (
        "blender (+z up, +y ahead) → opengl (+y up, -z ahead): turned by 90° about -x\n"
    )
    cross = sm.projection("cube:opengl", layout="cross")
    assert np.array_equal(io.read(out), sm.convert(SOURCE, "latlong:blender", cross, size=16))
    good("convert", sky, out, *ways, "--world", "literal")
    want = sm.convert(SOURCE, "latlong:blender", cross, size=16, world="literal")
    assert np.array_equal(io.read(out), want)
    good("convert", sky, out, "--from", "latlong:threejs", "--to", "cube:opengl")
    bad("convert", sky, out, *ways, "--world", "same", code=2, says="literal")
