"""`info` on images of any size: the numbers of the library, in little more memory than the file."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from other_files import put_panorama
from spheremap import io
from spheremap.cli import files, radiance
from test_cli import bad, good, run

resource = pytest.importorskip("resource", reason="needs the peak of a process's memory")


def sky(projection: sm.Projection, height: int) -> np.ndarray:
    """Return a smooth sky with a sun of 3 degrees and a texel below 0."""
    d = np.nan_to_num(projection.directions(files.size_of_height(projection, height)))
    sun = np.array([0.48, 0.6, -0.64])
    disk = np.clip((d @ sun - np.cos(np.radians(1.5))) * 1e5, 0, 1)[..., None]
    image = 1 + 0.5 * d + disk * [900, 800, 700]
    image[height // 2, 5 * height // 8] = -3
    return image.astype(np.float32)


@pytest.mark.parametrize(
    ("name", "layout"), [("latlong", None), ("angular", None), ("cube", "cross")]
)
def test_a_large_image_has_the_light_that_the_library_finds(name: str, layout: str | None) -> None:
    p = sm.projection(name, layout=layout)
    image = sky(p, 768)
    image[300, 200] = np.nan
    exact, found = sm.light.energy(image, p, skipna=True), radiance.energy(image, p)
    assert str(found) == str(exact) and found.negative == 1
    np.testing.assert_array_equal(found.integral, exact.integral)
    assert found.sun is not None and exact.sun is not None
    np.testing.assert_array_equal(found.sun.direction, exact.sun.direction)
    little = radiance.energy_of(lambda part: image[part.index], p, image.shape, memory=1 << 22)
    np.testing.assert_array_equal(little.integral, exact.integral)
    assert little.peak == exact.peak and little.sun is not None
    # Blocks of 4 texels, some 1.5 degrees: half a block, and its edge beside a sun of 3 degrees.
    assert np.degrees(np.arccos(little.sun.direction @ exact.sun.direction)) < 0.75
    assert little.sun.irradiance == pytest.approx(exact.sun.irradiance, rel=0.15)


def test_the_light_is_that_of_the_map_that_a_file_names(tmp_path: Path) -> None:
    image = np.full((64, 128, 3), 99, np.uint8)
    put_panorama(tmp_path / "a.png", image, ProjectionType="cylindrical")
    assert "light     as cylindrical" in good("info", tmp_path / "a.png")
    assert "light     as latlong" in good("info", tmp_path / "a.png", "--from", "latlong")
    # As an editor leaves a part of a panorama, and beyond what a cylinder may be.
    put_panorama(tmp_path / "b.png", image[:, :64])
    put_panorama(tmp_path / "c.png", image[:4], ProjectionType="cylindrical")
    for name, said in (("b", "latlong"), ("c", "cylindrical(aspect=32)")):
        text = good("info", tmp_path / f"{name}.png")
        assert f"light     unknown: the size is not that of {said}; give --from" in text
        assert json.loads(good("info", tmp_path / f"{name}.png", "--json"))["light"] is None
    cut, out = tmp_path / "b.png", tmp_path / "out"
    for command in (("identify", cut, cut), ("tiles", cut, out, "--format", "deepzoom")):
        bad(*command, code=1, says="128 x 64 (latlong)")


def test_a_tilted_panorama_says_what_makes_it_level(tmp_path: Path) -> None:
    pitch, roll = np.radians((10, 25))
    # The middle looks up by the pitch, and the horizon there is turned left by the roll.
    up = np.cos(pitch) * np.array([-np.sin(roll), np.cos(roll), 0]) - [0, 0, np.sin(pitch)]
    height = sm.directions("latlong", 128) @ up
    image = np.rint(127.5 + 127.5 * height[..., None]).astype(np.uint8)
    path, out = tmp_path / "a.png", tmp_path / "b.png"
    put_panorama(path, image, PosePitchDegrees=10, PoseRollDegrees=25, PoseHeadingDegrees=40)
    words = "the camera was tilted, pitch 10°, roll 25°: convert --rotation 0 10 -25 makes it level"
    assert f"tilted    {words}" in good("info", path)
    tilt = json.loads(good("info", path, "--json"))["tilt"]
    assert tilt == {"pitch": 10, "roll": 25}
    for options in ([], ["--memory", "64M"], ["--from", "latlong"]):
        assert words in run("convert", path, out, "--to", "latlong", *options).stderr
    assert words in run("tiles", path, tmp_path / "tiles", "--format", "deepzoom").stderr
    good("convert", path, out, "--to", "latlong", "--rotation", 0, 10, -25)
    level = 127.5 + 127.5 * sm.directions("latlong", 128)[..., 1]
    # Rounded twice, and linear between texels of 1.4 degrees.
    assert np.abs(io.read(out)[..., 0] - level).max() < 1.1
    assert "camera" not in good("info", out)


def test_memory_changes_nothing(tmp_path: Path) -> None:
    p = sm.projection("cube", layout="cross")
    io.write(tmp_path / "sky.exr", np.abs(sky(p, 900)))
    encoded = io.from_linear(np.clip(sky(sm.projection("latlong"), 700) / 100, 0, 1))
    io.write(tmp_path / "sky.png", (255 * encoded).astype(np.uint8))
    for name, options in ("sky.exr", ["--from", "cube"]), ("sky.png", []):
        whole = good("info", tmp_path / name, *options)
        assert "sun " in whole
        assert good("info", tmp_path / name, *options, "--memory", "128M") == whole
    bad("info", tmp_path / "sky.exr", "--memory", "1M", code=1, says="at least 134217728 bytes")


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is Linux's")
def test_info_takes_less_than_three_times_the_texels(tmp_path: Path) -> None:
    image = np.ones((2048, 4096, 3), np.float16)
    image[700:704, 100:104] = 20000
    io.write(tmp_path / "sky.exr", image)
    script = (
        "import pathlib, sys, OpenImageIO, spheremap.light\n"
        "from spheremap.cli import app\n"
        "status = pathlib.Path('/proc/self/status')\n"
        "peak = lambda: int(status.read_text().split('VmHWM:')[1].split()[0])\n"
        "app.parser_of(['info'])\n"
        "before = peak()\n"
        "code = app.run(['info', sys.argv[1]])\n"
        "print('peak', code, peak() - before)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "sky.exr")],
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    _, code, grown = done.stdout.splitlines()[-1].split()
    assert code == "0" and "sun       toward" in done.stdout
    assert int(grown) * 1024 < 3 * image.nbytes


def test_the_table_is_that_of_the_numbers(tmp_path: Path) -> None:
    image = np.arange(40 * 80 * 2, dtype=np.float32).reshape(40, 80, 2) - 7
    io.write(tmp_path / "a.exr", image, channels=("U", "V"))
    rows = {
        row[0]: row[1:] for row in map(str.split, good("info", tmp_path / "a.exr").splitlines())
    }
    for k, name in enumerate("UV"):
        values = image[..., k]
        numbers = f"{values.min():g} {values.max():g} {values.mean(dtype=float):.6g}".split()
        assert rows[name] == [*numbers, "0", "0", str((values < 0).sum())]
