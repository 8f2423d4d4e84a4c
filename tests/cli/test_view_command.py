"""Pages, by the command."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from test_cli import bad, good, process


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    io.write(path, sm.directions("latlong", 16).astype(np.float32))
    return path


def test_it_writes_the_page_of_the_function(sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "look.html"
    assert good("view", sky, "-o", out, "--fov", 60, "--exposure", 1, "--screen", "mollweide") == ""
    wanted = sm.view(
        io.read(sky), "latlong", name="sky.exr", fov=60, exposure=1, screen="mollweide"
    )
    assert out.read_text(encoding="utf-8") == wanted.html()


def test_several_images_are_compared(sky: Path, tmp_path: Path) -> None:
    probe = tmp_path / "probe.png"
    io.write(probe, np.full((8, 8, 3), 128, np.uint8))
    out = tmp_path / "both.html"
    good("view", sky, probe, "-o", out)
    wanted = sm.view(io.read(sky), "latlong", name="sky.exr")
    wanted.add(io.read(probe), "angular", name="probe.png")
    assert out.read_text(encoding="utf-8") == wanted.html()


def test_overlays_are_those_of_the_function(sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "look.html"
    good("view", sky, "-o", out, "--overlay", "graticule, seams,lights,sun", "--false-color")
    light = io.read(sky)
    wanted = sm.view(light, "latlong", name="sky.exr", graticule=30, seams=True, false_color=True)
    wanted.lights(sm.light.lights(light, "latlong", count=32, negative="clip", skipna=True))
    sun = sm.light.sun(light, "latlong")
    if sun is not None:
        wanted.lights(sun)
    assert len(wanted._overlays.lights) > 4
    assert out.read_text(encoding="utf-8") == wanted.html()
    picture = tmp_path / "sky.png"
    io.write(picture, np.tile(np.arange(0, 256, 8, dtype=np.uint8), (16, 1)))
    good("view", picture, "-o", out, "--overlay", "lights,axes")
    assert '"axes":true' in out.read_text(encoding="utf-8")


@pytest.mark.skipif(os.name == "nt", reason="a script stands for a browser")
def test_it_opens_what_it_writes(
    sky: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {tmp_path}/asked\n')
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    done = process("view", sky)
    (page,) = tmp_path.glob("spheremap-*/sky.html")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{page}\n", "")
    assert (tmp_path / "asked").read_text().strip() == page.as_uri()
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_what_does_not_go_together_is_one_line(sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "look.html"
    bad("view", sky, "-o", out, "--from", "nothing", code=2, says="unknown projection")
    bad("view", sky, "-o", out, "--fov", 400, code=2, says="--fov")
    bad("view", sky, "-o", out, "--max-size", 0, code=2, says="--max-size")
    bad("view", sky, "-o", out, "--overlay", "graticule,light", code=2, says="did you mean")
    bad("view", sky, "-o", out, "--from", "perspective", code=1, says="expected for example")
    bad("view", tmp_path / "none.exr", "-o", out, code=1, says="none.exr")
    assert not out.exists()
