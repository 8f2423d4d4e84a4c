"""Files that are more or less than an image, as the command meets them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from other_files import put, put_parts
from spheremap import io
from spheremap.io.images import write_copy
from test_cli import bad, good, process

SAME = ("--from", "latlong", "--to", "latlong", "--filter", "nearest")


def test_a_window_is_placed_and_the_rest_filled(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "b.exr"
    image = np.arange(3 * 4 * 3, dtype=np.float32).reshape(3, 4, 3)
    put(source, image, x=2, y=1, full_x=0, full_y=0, full_width=16, full_height=8)
    done = process("convert", source, out, *SAME, "--fill", -5)
    assert done.returncode == 0, done.stderr
    read = io.read(out)
    assert np.array_equal(read[1:4, 2:6], image)
    assert np.count_nonzero(read == -5) == 3 * (8 * 16 - 3 * 4)
    assert "rows 1 to 4 and columns 2 to 6" in good("info", source)


def test_a_part_is_asked_for(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "b.exr"
    put_parts(source, {"left": 0, "right": 1})
    bad("convert", source, out, *SAME, code=1, says="0 (left), 1 (right)")
    bad("info", source, code=1, says="2 parts")
    done = process("convert", source, out, *SAME, "--part", "right")
    assert done.returncode == 0, done.stderr
    assert np.all(io.read(out) == 1)
    assert "mean      0 0 0, luminance 0" in good("info", source, "--part", 0)


def test_a_claim_that_does_not_fit_keeps_info_from_nothing(tmp_path: Path) -> None:
    for name in ("latlong", "no projection"):
        image = np.ones((8, 8, 3), np.float32)
        write_copy(tmp_path / "a.exr", image, compression=None, projection=name)
        assert f"says      {name}" in good("info", tmp_path / "a.exr")


@pytest.mark.parametrize("content", [b"", b"hello\n", b"%PDF-1.4", b"\x89PNG\r\n\x1a\n", b"GIF89a"])
@pytest.mark.parametrize("suffix", ["exr", "png", "txt", "mp4"])
def test_what_is_no_image_is_one_line(content: bytes, suffix: str, tmp_path: Path) -> None:
    source = tmp_path / f"a.{suffix}"
    source.write_bytes(content)
    bad("info", source, code=1, says="cannot read")
    bad("convert", source, tmp_path / "b.exr", *SAME, code=1, says="cannot read")


def test_bake_takes_an_encoded_image_for_light(tmp_path: Path) -> None:
    png, exr = tmp_path / "a.png", tmp_path / "a.exr"
    image = np.full((16, 32, 3), 188, np.uint8)
    io.write(png, image)
    io.write(exr, io.to_linear(image))
    for source in (png, exr):
        good("bake", source, tmp_path / source.suffix[1:], "--diffuse", "--diffuse-size", 4)
    a, b = ((tmp_path / name / "diffuse.dds").read_bytes() for name in ("png", "exr"))
    assert a == b
