"""Videos, by the command."""

from __future__ import annotations

import re
from pathlib import Path

import filming
import numpy as np
import pytest
import spheremap as sm
from test_cli import bad, good


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    frames = [filming.rendered("latlong", (32, 64), k, "yuv420p") for k in range(3)]
    return filming.film(tmp_path / "sky.mkv", frames)


def test_it_writes_what_the_function_writes(sky: Path, tmp_path: Path) -> None:
    out, wanted = tmp_path / "out.mkv", tmp_path / "wanted.mkv"
    keys = tmp_path / "turn.csv"
    keys.write_text("time,yaw\n0,0\n0.1,50\n")
    options = ["--from", "latlong", "--size", 16, "--filter", "lanczos3", "--no-antialias"]
    said = good("video", sky, out, "--to", "cube", *options, "--keyframes", keys)
    assert re.fullmatch(
        r".*out\.mkv: cube cross, 64 x 48, ffv1, yuv420p; 3 frames in .* s \(.* a second\)\n", said
    )
    sm.video.convert(
        sky, wanted, "latlong", "cube", size=16, filter="lanczos3", antialias=False,
        rotation=sm.video.read_keyframes(keys),
    )  # fmt: skip
    for a, b in zip(filming.read(out), filming.read(wanted), strict=True):
        assert all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def test_it_takes_what_the_file_says(sky: Path, tmp_path: Path) -> None:
    panorama, out = tmp_path / "panorama.mp4", tmp_path / "out.mp4"
    encoder = ["--codec", "libx264", "--option", "crf=30", "--option", "preset=ultrafast"]
    good("video", sky, panorama, "--from", "latlong", "--to", "latlong", *encoder)
    said = good("video", panorama, out, "--to", "perspective", "--rotation", 10, 20, 0)
    assert said.endswith("panorama.mp4: taken as latlong, as it says\n")


def test_what_does_not_go_together_is_one_line(sky: Path, tmp_path: Path) -> None:
    out, to = tmp_path / "out.mkv", ("--from", "latlong", "--to", "latlong")
    bad("video", sky, out, "--to", "latlong", code=1, says="--from is needed")
    bad("video", sky, out, "--to", "latlang", code=2, says="unknown projection")
    bad("video", tmp_path / "none.mp4", out, *to, code=1, says="none.mp4")
    bad("video", sky, out, "--from", "latlong", "--to", "angular", "--size", "33", code=1,
        says="33 x 33")  # fmt: skip
    bad("video", sky, out, *to, "--option", "crf", code=2, says="NAME=VALUE")
    bad("video", sky, out, *to, "--codec", "none", code=1, says="unknown --codec 'none'")
    bad("video", sky, out, *to, "--keyframes", tmp_path / "no.csv", code=1, says="no.csv")
    bad("video", sky, out, *to, "--keyframes", sky, "--rotation", 1, 2, 3, code=2, says="not both")
    bad("video", sky, tmp_path / "out.foo", *to, code=1, says="ending")
    bad("video", sky, sky, *to, "--no-clobber", code=1, says="--no-clobber keeps it")
    assert not out.exists()
