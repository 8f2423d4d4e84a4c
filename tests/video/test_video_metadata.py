"""What files say of their map: written by us, read by PyAV and ffmpeg, and what others wrote."""

from __future__ import annotations

import subprocess
from pathlib import Path

import av
import filming
import numpy as np
import pytest
import spheremap as sm
from av.sidedata.sidedata import Type
from oracles import ffmpeg_oracle
from spheremap.video import boxes, metadata


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    frames = [filming.rendered("latlong", (32, 64), k, "yuv420p") for k in range(2)]
    return filming.film(tmp_path / "sky.mkv", frames)


def made(sky: Path, ending: str, notation: str | None, dst: str = "latlong") -> Path:
    target = sky.with_name(f"made.{ending}")
    sm.video.convert(sky, target, "latlong", dst, codec="libx264", metadata=notation)  # type: ignore[arg-type]
    return target


def words(path: Path) -> str:
    """Return what ffmpeg says of a file; it fails, having been told of no output."""
    command = [ffmpeg_oracle.program(), "-hide_banner", "-i", str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False).stderr


@pytest.mark.parametrize("ending", ["mp4", "mov"])
@pytest.mark.parametrize("notation", ["v1", "v2", "both", None])
def test_what_is_written_is_read_by_others(sky: Path, ending: str, notation: str | None) -> None:
    path = made(sky, ending, notation)
    said = words(path)
    assert "Spherical Mapping: equirectangular" in said and "Invalid" not in said
    assert ("Stereo 3D: 2D" in said) is (notation != "v1")
    assert (b"GSpherical:Spherical>true" in path.read_bytes()) is (notation != "v2")
    with av.open(str(path)) as file:
        frames = list(file.decode(video=0))
    assert all(f.side_data.get(Type.SPHERICAL) is not None for f in frames)
    assert len(frames) == 2
    assert sm.video.projection(path) == sm.projection("latlong")
    assert sm.video.convert(path, path, None, "cube", size=16).src == sm.projection("latlong")


def test_none_is_written_where_there_is_no_word(sky: Path) -> None:
    for dst in ("cube", "angular", "latlong"):
        path = made(sky, "mp4", "none" if dst == "latlong" else None, dst)
        assert "Spherical" not in words(path) and sm.video.projection(path) is None
    mirrored = sm.projection("latlong", axes="-x -y -z")
    done = sm.video.convert(sky, sky.with_name("m.mp4"), "latlong", mirrored, codec="libx264")
    assert done.metadata == "none"


def copied(path: Path, target: Path) -> Path:
    command = [ffmpeg_oracle.program(), "-loglevel", "error", "-i", str(path), "-c", "copy"]
    subprocess.run([*command, "-strict", "unofficial", str(target)], check=True)
    return target


def test_what_ffmpeg_writes_is_read(sky: Path) -> None:
    path = made(sky, "mp4", "v2")
    for ending in ("mkv", "mp4"):
        assert sm.video.projection(copied(path, sky.with_name(f"copy.{ending}"))) is not None


def patched(path: Path, old: bytes, new: bytes) -> Path:
    data = bytearray(path.read_bytes())
    at = data.index(old)
    data[at : at + len(new)] = new
    path.write_bytes(data)
    return path


def in_xml(path: Path, **words: object) -> Path:
    """Put words into the XML of the first version."""
    own = "".join(f"<GSpherical:{key}>{word}</GSpherical:{key}>" for key, word in words.items())
    xml = metadata._XML.replace("</rdf", f"{own}</rdf").encode()
    boxes.add(path, boxes.box(b"uuid", metadata._V1.bytes, xml), b"")
    return path


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (b"prhd" + bytes(4), b"prhd" + bytes(4) + b"\0\x1e\0\0", "turned by 30, 0, 0"),
        (b"equi" + bytes(4), b"equi" + bytes(4) + b"\x40\0\0\0", "a part of"),
    ],
)
def test_what_it_cannot_be_taken_for(sky: Path, old: bytes, new: bytes, says: str) -> None:
    path = patched(made(sky, "mp4", "v2"), old, new)
    with pytest.raises(ValueError, match=says):
        sm.video.projection(path)
    with pytest.raises(ValueError, match=says):
        sm.video.convert(path, path, None, "cube")
    # Whoever says what it is knows.
    sm.video.convert(path, path, "latlong", "cube", size=16)


@pytest.mark.parametrize(
    ("left", "full", "part"), [(64, 256, 128), (0, 256, 128), (8, 128, 128), (0, 64, 64)]
)
def test_parts_of_panoramas_in_xml(sky: Path, left: int, full: int, part: int) -> None:
    path = in_xml(
        made(sky, "mp4", "none"),
        FullPanoWidthPixels=full,
        FullPanoHeightPixels=full // 2,
        CroppedAreaImageWidthPixels=part,
        CroppedAreaImageHeightPixels=part // 2,
        CroppedAreaLeftPixels=left,
        CroppedAreaTopPixels=left // 2,
    )
    if left == 0 and full == part:
        assert sm.video.projection(path) == sm.projection("latlong")
        return
    with pytest.raises(ValueError, match="a part of"):
        sm.video.projection(path)
    with pytest.raises(ValueError, match="a part of"):
        sm.video.convert(path, path, None, "cube")


@pytest.mark.parametrize("version", [1, 2])
def test_two_eyes_are_refused_whatever_src_is(sky: Path, version: int) -> None:
    path = made(sky, "mp4", "v2" if version == 2 else "none")
    if version == 2:
        patched(path, b"st3d" + bytes(5), b"st3d" + bytes(4) + b"\1")
    else:
        in_xml(path, StereoMode="top-bottom")
    with pytest.raises(ValueError, match="two eyes, top and bottom, which is not supported"):
        sm.video.projection(path)
    for src in (None, "latlong"):
        with pytest.raises(ValueError, match="two eyes"):
            sm.video.convert(path, path, src, "latlong")


@pytest.mark.parametrize(
    ("dst", "says"),
    [
        ("cube", "no latlong"),
        ("latlong:ffmpeg", "grid is 'corners'"),
        (sm.projection("latlong", axes="-x -y -z"), "mirrored"),
    ],
)
def test_why_there_is_no_word(sky: Path, dst: sm.Projection | str, says: str) -> None:
    with pytest.raises(ValueError, match=f"`metadata` to be 'none' for .*{says}.*got 'v2'"):
        made(sky, "mp4", "v2", dst)  # type: ignore[arg-type]


def test_boxes_move_nothing_else(sky: Path) -> None:
    path = made(sky, "mp4", "none")
    before = path.read_bytes()
    frames = filming.read(path)
    boxes.add(path, boxes.box(b"free", b"track"), boxes.box(b"free", b"description"))
    after = path.read_bytes()
    index = before.index(b"moov") - 4
    assert after[:index] == before[:index]
    assert len(after) == len(before) + 8 + 5 + 8 + 11
    assert all((a == b).all() for x, y in zip(frames, filming.read(path), strict=True)
               for a, b in zip(x, y, strict=True))  # fmt: skip
    path.write_bytes(before[index:] + before[:index])
    with pytest.raises(ValueError, match="at the end"):
        boxes.add(path, b"", b"")


@pytest.mark.parametrize("name", ["a.tif", "a.png"])
def test_a_picture_says_nothing(tmp_path, name):
    """FFmpeg tells things of pictures that PyAV has no words for."""
    sm.io.write(tmp_path / name, np.zeros((8, 16, 3), np.uint8))
    assert sm.video.projection(tmp_path / name) is None
