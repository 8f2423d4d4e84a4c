"""Pyramids of files larger than memory: the bytes of the whole, from its parts."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from full_disk import disk_full_after
from large_files import shrink
from scenes import scene
from spheremap import io
from spheremap._progress import told
from spheremap.io import levels
from spheremap.tiles import cutting, filed, hips, large

FORMATS = ("pannellum", "marzipano", "photo-sphere-viewer", "deepzoom", "hips")
MEMORY = 4 << 20


@pytest.fixture(autouse=True)
def little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Images of a test are small: so are tiles, windows and what there is; disks are patient."""
    shrink(monkeypatch)
    monkeypatch.setattr(hips, "_HALVED", 8)
    monkeypatch.setattr(cutting, "_BATCH", 5)
    monkeypatch.setattr(large, "_LEAST_MEMORY", 0)
    monkeypatch.setattr(large, "_TEXEL", 0)
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def stored(folder: Path, image: np.ndarray) -> Path:
    """Return an image file, of what it holds a name."""
    place = folder / ("in.exr" if image.dtype.kind == "f" else "in.png")
    io.write(place, image)
    return place


def light(height: int = 96, p: Any = "latlong") -> np.ndarray:
    return scene(sm.directions(p, height)).astype(np.float32)


def files(folder: Path) -> dict[str, bytes]:
    """Return all files but for the time that one of them says."""
    found = {x.relative_to(folder).as_posix(): x for x in folder.rglob("*") if x.is_file()}
    return {name: re.sub(rb"\d+-\d+-\d+T.*", b"", x.read_bytes()) for name, x in found.items()}


def expect_same(tmp_path: Path, image: np.ndarray, p: Any, **options: Any) -> None:
    """Both ways write the same bytes."""
    options = {"title": "A sky", **options}
    whole = sm.tiles.write(image, p, tmp_path / "whole", **options)
    source = stored(tmp_path, image)
    made = sm.tiles.write_file(source, p, tmp_path / "parts", memory=MEMORY, **options)
    assert (made.shape, made.levels, made.tiles) == (whole.shape, whole.levels, whole.tiles)
    assert made.manifest == tmp_path / "parts" / whole.manifest.name
    found, wanted = files(tmp_path / "parts"), files(tmp_path / "whole")
    assert sorted(found) == sorted(wanted)
    assert [name for name in wanted if found[name] != wanted[name]] == []
    assert sorted(x.name for x in tmp_path.iterdir()) == sorted([source.name, "parts", "whole"])


@some_fast("dtype", [np.uint8, np.uint16, np.float16, np.float32], fast=(np.uint8,))
@pytest.mark.parametrize("format", FORMATS)
def test_files_have_the_bytes_of_the_whole(format: str, dtype: type, tmp_path: Path) -> None:
    image = light()
    if dtype in (np.uint8, np.uint16):
        image = io.tonemap(image).astype(dtype) * dtype(np.iinfo(dtype).max // 255)
    extension = "jpg" if dtype is np.uint8 else "png"
    options = {"format": format, "extension": extension, "tile_size": 16, "size": 64}
    expect_same(tmp_path, image.astype(dtype), "latlong", **options)


@some_fast("format", FORMATS, fast=("hips", "deepzoom"))
def test_what_is_not_finite_and_turned(format: str, tmp_path: Path) -> None:
    image = light(64)
    image[3:9, 5:30] = np.nan
    image[50, 60] = np.inf
    expect_same(
        tmp_path, image, "latlong", format=format, tile_size=16, extension="png", filter="area",
        exposure=-3, rotation=sm.rotation(20, 30, 40), size=32,
    )  # fmt: skip


@pytest.mark.parametrize("format", ["marzipano", "hips"])
def test_a_part_of_the_sphere(format: str, tmp_path: Path) -> None:
    p = sm.projection("angular", fov=120)
    image = (np.clip(light(64, p) / 9, 0, 1) * 60_000).astype(np.uint16)
    options = {"format": format, "extension": "png", "tile_size": 16, "size": 64}
    expect_same(tmp_path, image, p, **options)


@pytest.mark.slow
def test_numbers_of_a_survey(tmp_path: Path) -> None:
    pytest.importorskip("astropy")
    image = light()[..., 1:2].copy()
    image[3:9, 5:30] = np.nan
    # With an Allsky, and with levels below order 0.
    options = {"format": "hips", "extension": "fits", "tile_size": 16, "size": 128}
    expect_same(tmp_path, image, "latlong", **options)


def test_odd_sides_and_alpha(tmp_path: Path) -> None:
    image = np.dstack([light()[:51, :103], np.ones((51, 103), np.float32)])
    expect_same(
        tmp_path, image, "latlong", format="deepzoom", extension="png", tile_size=30,
        any_aspect=True,
    )  # fmt: skip


@pytest.mark.parametrize("filter", ["trilinear", "ewa"])
@pytest.mark.parametrize("format", ["marzipano", "deepzoom", "hips"])
def test_filters_that_look_a_mip_chain_up(
    format: str, filter: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(levels, "_MOST", 13)
    image = light(64)
    image[3:9, 5:30] = np.nan
    expect_same(
        tmp_path, image, "latlong", format=format, tile_size=16, extension="png", filter=filter,
        rotation=sm.rotation(20, 30, 40), size=32,
    )  # fmt: skip


def test_levels_are_made_of_several_windows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is held to the whole above is no whole itself."""
    seen: dict[tuple[int, ...], int] = {}
    put = filed.FileLevel.put

    def counted(self: filed.FileLevel, part: Any, texels: np.ndarray) -> None:
        seen[self.shape] = seen.get(self.shape, 0) + 1
        put(self, part, texels)

    monkeypatch.setattr(filed.FileLevel, "put", counted)
    source = stored(tmp_path, light())
    sm.tiles.write_file(
        source, "latlong", tmp_path / "a", format="marzipano", tile_size=16, size=128, memory=MEMORY
    )
    assert [shape[1] for shape in seen] == [128, 64, 32, 16, 8]
    assert seen[6, 128, 128, 3] >= 6 * 16 and seen[6, 64, 64, 3] >= 6 * 4


@pytest.mark.parametrize("format", FORMATS)
def test_the_manifest_comes_last(
    format: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where writing ends early, nothing says that a pyramid is there, and no texels are left."""
    source, options = stored(tmp_path, light(32)), {"format": format, "tile_size": 16}
    name = sm.tiles.write_file(source, "latlong", tmp_path / "a", memory=MEMORY, **options).manifest
    disk_full_after(7, monkeypatch)
    with pytest.raises(OSError, match="no room"):
        sm.tiles.write_file(source, "latlong", tmp_path / "b", memory=MEMORY, **options)
    left = {path.name for path in (tmp_path / "b").rglob("*") if path.is_file()}
    assert left and name.name not in left
    assert all(path.endswith(".jpg") for path in left)


KILLED = """
import os, signal, sys
import spheremap as sm
from spheremap.io import parts
from spheremap.tiles import filed, large

count, put = [0], filed.FileLevel.put

def killed(self, window, texels):
    count[0] += 1
    if count[0] == 12:
        os.kill(os.getpid(), signal.SIGKILL)
    put(self, window, texels)

filed.FileLevel.put, parts._MOST = killed, 8
sm.tiles.write_file(*sys.argv[1:2], "latlong", sys.argv[2], format="marzipano", memory=128 << 20)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs a signal that ends a process at once")
def test_a_killed_process_leaves_no_manifest_and_no_level(tmp_path: Path) -> None:
    source = stored(tmp_path, light(32))
    command = [sys.executable, "-c", KILLED, source, tmp_path / "a"]
    done = subprocess.run(command, check=False, capture_output=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    left = [path for path in (tmp_path / "a").rglob("*") if path.is_file()]
    # Of a source without tiles its copy in tiles has a name.
    assert all(path.parent.name.startswith(".spheremap-tiles-") for path in left)


def test_progress_goes_up_to_one(tmp_path: Path) -> None:
    source, said = stored(tmp_path, light(64)), list[float]()
    with told(said.append):
        sm.tiles.write_file(
            source, "latlong", tmp_path / "a", format="hips", tile_size=16, memory=MEMORY
        )
    assert said == sorted(said) and said[0] == 0 and 0.9 < said[-1] <= 1
    assert len(set(said)) > 20


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        ({"memory": 0}, ValueError, "`memory` to be at least 134217728 bytes, got 0"),
        ({"memory": 1 << 20}, ValueError, "`memory` to be at least 134217728 bytes, got 1048576"),
        ({"tile_size": 4096}, ValueError, "`memory` to be at least 1073741824 bytes"),
        ({"memory": 1.5}, TypeError, "memory"),
        ({"format": "krpano"}, ValueError, "unknown format 'krpano'"),
        ({"extension": "fits"}, ValueError, "`extension` 'fits' is of 'hips' alone"),
        ({"format": "hips", "extension": "fits"}, ValueError, "hold one channel, `image` has 3"),
        ({"curve": "reinhard", "source": "in.png"}, ValueError, "are for floats, got uint8"),
        ({"projection": "cube"}, ValueError, "give it a layout"),
        ({"projection": "angular"}, ValueError, "as wide as high"),
        ({"source": "none.exr"}, FileNotFoundError, "no such file"),
        ({"source": "text.exr"}, OSError, "cannot read"),
        ({"folder": "full"}, OSError, "the folder is not empty"),
        ({"folder": "in.png"}, OSError, "it is no folder"),
    ],
)
def test_errors_come_before_the_work(
    change: dict[str, Any], error: type, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    stored(tmp_path, light(16))
    stored(tmp_path, io.tonemap(light(16)))
    (tmp_path / "text.exr").write_text("no image")
    (tmp_path / "full").mkdir()
    (tmp_path / "full/a.txt").write_text("a")
    given = {"source": "in.exr", "projection": "latlong", "folder": "out", "format": "marzipano"}
    given |= change
    source, folder = (tmp_path / given.pop(name) for name in ("source", "folder"))
    with pytest.raises(error, match=re.escape(says)):
        sm.tiles.write_file(source, given.pop("projection"), folder, **given)
    assert not (tmp_path / "out").exists()


def test_what_is_turned_by_its_header_is_an_error(tmp_path: Path) -> None:
    oiio = pytest.importorskip("OpenImageIO")
    spec = oiio.ImageSpec(8, 4, 3, "uint8")
    spec.attribute("Orientation", 6)
    place = str(tmp_path / "turned.tif")
    sink = oiio.ImageOutput.create(place)
    sink.open(place, spec)
    sink.write_image(np.zeros((4, 8, 3), np.uint8))
    sink.close()
    with pytest.raises(ValueError, match="turned"):
        sm.tiles.write_file(place, "latlong", tmp_path / "a", format="marzipano")


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room can be set aside")
def test_a_disk_without_room_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    source = stored(tmp_path, light(16))
    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(OSError, match=r"cannot write '.*a': no room for its texels: No space"):
        sm.tiles.write_file(source, "latlong", tmp_path / "a", format="hips", memory=MEMORY)
    assert [path for path in (tmp_path / "a").rglob("*")] == []
