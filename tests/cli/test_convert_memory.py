"""`convert --memory`: files larger than memory, part by part."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from spheremap.cli.large import as_bytes
from spheremap.cli.terminal import UsageError
from test_cli import bad, good, smooth

MEMORY = ("--memory", "256M")


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    image = np.abs(smooth(sm.directions("latlong", 48)))
    io.write(path, image, projection="latlong", metadata={"Artist": "Ada"})
    return path


def test_the_file_is_that_of_the_whole(sky: Path, tmp_path: Path) -> None:
    whole, parts = tmp_path / "whole.exr", tmp_path / "parts.exr"
    turn = (
        "--to",
        "cube:openexr",
        "--world",
        "literal",
        "--size",
        16,
        "--rotation",
        10,
        20,
        30,
        "--filter",
        "lanczos3",
    )
    good("convert", sky, whole, *turn)
    said = good("convert", sky, parts, *turn, *MEMORY, "--resume")
    assert f"{parts}: cube" in said and "16 x 96" in said and "as it says" in said
    np.testing.assert_array_equal(io.read(parts), io.read(whole))
    assert io.header(parts).projection == io.header(whole).projection == "cube:openexr"
    assert io.header(parts).metadata["Artist"] == "Ada"
    assert len(list(tmp_path.iterdir())) == 3


def test_what_needs_the_whole_is_wrong_usage(sky: Path, tmp_path: Path) -> None:
    turn = ("convert", sky, tmp_path / "out.exr", "--to", "octahedral")
    bad(*turn, "--resume", code=2, says="--memory")
    bad(*turn, *MEMORY, "--half", code=2, says="--half")
    bad(*turn, *MEMORY, "--face-sun", code=2, says="--face-sun")
    bad(*turn, "--memory", "much", code=2, says="512M")
    bad(*turn, "--memory", "1M", code=1, says="--memory")
    bad(*turn, *MEMORY, "--filter", "ewa", code=2, says="--filter ewa")
    png = tmp_path / "out.png"
    bad("convert", sky, png, "--to", "octahedral", *MEMORY, code=2, says="keeps types")
    faces = tmp_path / "out_{face}.exr"
    one = ("convert", sky, faces, "--to", "cube", "--layout", "faces")
    bad(*one, *MEMORY, code=2, says="one file")
    straight = tmp_path / "straight.png"
    io.write(straight, np.zeros((8, 16, 4), np.uint8))
    named = ("convert", straight, png, "--from", "latlong", "--to", "octahedral")
    bad(*named, *MEMORY, code=2, says="premultiply")


@pytest.mark.parametrize(
    ("text", "number"), [("7", 7), ("512M", 1 << 29), ("4GiB", 1 << 32), ("1kb", 1024)]
)
def test_numbers_of_bytes(text: str, number: int) -> None:
    assert as_bytes(text) == number


@pytest.mark.parametrize("text", ["", "M", "1.5G", "-1", "4P"])
def test_what_is_no_number_of_bytes(text: str) -> None:
    with pytest.raises(UsageError, match="512M"):
        as_bytes(text)
