"""`convert --memory`: files larger than memory, part by part."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import io
from spheremap.cli.lengths import as_bytes
from spheremap.cli.terminal import UsageError
from spheremap.io import parts, sight
from test_cli import bad, good, smooth

MEMORY = ("--memory", "256M")


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    image = np.abs(smooth(sm.directions("latlong", 48)))
    io.write(path, image, projection="latlong", metadata={"Artist": "Ada"})
    return path


def test_the_file_is_that_of_the_whole(sky: Path, tmp_path: Path) -> None:
    whole, made = tmp_path / "whole.exr", tmp_path / "parts.exr"
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
    said = good("convert", sky, made, *turn, *MEMORY, "--resume")
    assert f"{made}: cube" in said and "16 x 96" in said and "as it says" in said
    np.testing.assert_array_equal(io.read(made), io.read(whole))
    assert io.header(made).projection == io.header(whole).projection == "cube:openexr"
    assert io.header(made).metadata["Artist"] == "Ada"
    assert len(list(tmp_path.iterdir())) == 3


def expect_same(one: Path, other: Path) -> None:
    """Hold files to each other, but for the second in which each was written."""
    assert np.array_equal(io.read(one), io.read(other), equal_nan=True)
    heads = [io.header(path) for path in (one, other)]
    for head in heads:
        head.metadata.pop("DateTime", None)
    assert heads[0] == heads[1]


def colors(path: Path, dtype: str, channels: int) -> None:
    """Write an image of all values, with alpha where there are four channels."""
    image = np.random.default_rng(1).random((40, 80, channels))
    if dtype.startswith("float"):
        io.write(path, (image * 3).astype(dtype))
    else:
        io.write(path, (image * np.iinfo(dtype).max).astype(dtype))


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts that no block of any library is as long as."""
    monkeypatch.setattr(sight, "_TILE", (13, 21))
    monkeypatch.setattr(parts, "_MOST", 11)


@pytest.mark.parametrize(
    ("read", "dtype", "channels", "written", "options"),
    [
        (".png", "uint8", 3, ".exr", ()),
        (".png", "uint16", 4, ".exr", ("--half",)),
        (".png", "uint16", 3, ".png", ("--bits", 8)),
        (".png", "uint8", 4, ".png", ("--drop-alpha",)),
        (".png", "uint8", 4, ".png", ()),
        (".tif", "uint16", 4, ".png", ("--filter", "lanczos3", "--bits", 8)),
        (".png", "uint16", 2, ".png", ("--filter", "area")),
        (".exr", "float32", 4, ".exr", ("--alpha", 3, "--skipna")),
        (".png", "uint8", 1, ".hdr", ("--colorspace", "linear")),
        (".exr", "float32", 3, ".png", ("--tonemap", "reinhard", "--exposure", -1)),
        (".exr", "float32", 4, ".tif", ()),
        (".exr", "float16", 3, ".jpg", ("--compression", "jpeg:90")),
        (".exr", "float32", 4, ".exr", ("--channels", "B,G", "--half")),
    ],
)
def test_types_and_colors_change_as_those_of_the_whole(
    read: str,
    dtype: str,
    channels: int,
    written: str,
    options: tuple[object, ...],
    small_parts: None,
    tmp_path: Path,
) -> None:
    source = tmp_path / f"in{read}"
    colors(source, dtype, channels)
    whole, made = tmp_path / f"whole{written}", tmp_path / f"parts{written}"
    turn = ("--from", "latlong", "--to", "octahedral", "--size", 32, "--rotation", 9, 8, 7)
    good("convert", source, whole, *turn, *options)
    good("convert", source, made, *turn, *options, *MEMORY)
    expect_same(made, whole)


def test_faces_have_files_of_their_own(sky: Path, small_parts: None, tmp_path: Path) -> None:
    to_faces = ("--to", "cube", "--layout", "faces", "--size", 24)
    good("convert", sky, tmp_path / "whole_{face}.exr", *to_faces)
    said = good("convert", sky, tmp_path / "parts_{face}.exr", *to_faces, *MEMORY)
    assert "6 x 24 x 24" in said
    for face in ("px", "nx", "py", "ny", "pz", "nz"):
        one, other = (tmp_path / f"{name}_{face}.exr" for name in ("whole", "parts"))
        expect_same(one, other)
    back = ("convert", tmp_path / "whole_{face}.exr")
    to_sky = ("--from", "cube", "--to", "latlong", "--filter", "lanczos3")
    good(*back, tmp_path / "whole.exr", *to_sky)
    good(*back, tmp_path / "parts.exr", *to_sky, *MEMORY)
    expect_same(tmp_path / "whole.exr", tmp_path / "parts.exr")
    io.write(tmp_path / "whole_nz.exr", np.ones((8, 8, 3), np.float32))
    bad(*back, tmp_path / "parts.exr", *to_sky, *MEMORY, code=1, says="differ in size")


def test_what_needs_the_whole_is_wrong_usage(sky: Path, tmp_path: Path) -> None:
    turn = ("convert", sky, tmp_path / "out.exr", "--to", "octahedral")
    bad(*turn, "--resume", code=2, says="--memory")
    bad(*turn, *MEMORY, "--face-sun", code=2, says="--face-sun")
    bad(*turn, *MEMORY, "--preview", tmp_path / "small.png", code=2, says="--preview")
    bad(*turn, "--memory", "much", code=2, says="512M")
    bad(*turn, "--memory", "1M", code=1, says="--memory")
    texture = ("convert", sky, tmp_path / "out.ktx2", "--to", "cube")
    bad(*texture, *MEMORY, code=2, says="image files")
    whole, png = tmp_path / "whole.png", tmp_path / "out.png"
    io.write(whole, np.zeros((8, 16, 3), np.uint8))
    named = ("convert", whole, png, "--from", "latlong", "--to", "octahedral")
    bad(*named, *MEMORY, "--tonemap", "reinhard", code=2, says="integers stay")


@some_fast(
    "options",
    [(), ("--filter", "lanczos3"), ("--filter", "area"), ("--filter", "ewa")],
    ids=str,
    fast=[(), ("--filter", "lanczos3")],
)
def test_holes_weigh_nothing(
    options: tuple[object, ...], small_parts: None, tmp_path: Path
) -> None:
    image = np.random.default_rng(2).random((40, 80, 3)).astype(np.float32)
    image[3:9, 60:] = np.nan
    image[30, 7, 1] = np.inf
    source = tmp_path / "in.exr"
    io.write(source, image)
    whole, made = tmp_path / "whole.exr", tmp_path / "parts.exr"
    turn = ("--from", "latlong", "--to", "cube", "--size", 24, "--skipna", *options)
    good("convert", source, whole, *turn)
    good("convert", source, made, *turn, *MEMORY)
    expect_same(made, whole)


@pytest.mark.parametrize(
    ("text", "number"), [("7", 7), ("512M", 1 << 29), ("4GiB", 1 << 32), ("1kb", 1024)]
)
def test_numbers_of_bytes(text: str, number: int) -> None:
    assert as_bytes("--memory", text) == number


@pytest.mark.parametrize("text", ["", "M", "1.5G", "-1", "4P"])
def test_what_is_no_number_of_bytes(text: str) -> None:
    with pytest.raises(UsageError, match="512M"):
        as_bytes("--memory", text)
