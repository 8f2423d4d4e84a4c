"""Pyramids for viewers: every level, tile by tile, and what is refused."""

from __future__ import annotations

import errno
import json
import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from full_disk import disk_full_after
from scenes import scene
from spheremap import io
from spheremap.tiles import folder as folders

FORMATS = ("pannellum", "marzipano", "photo-sphere-viewer", "deepzoom", "hips")
# Faces as a person sees them: ahead is -z.
CUBE = sm.projection("cube", axes="+x -y -z")
LETTERS = "rludfb"


@pytest.fixture(autouse=True)
def _disks_are_patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of files need not be on the disk for these tests."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def sky(height: int = 96, dtype: type = np.float32) -> np.ndarray:
    """Return light without a sun, so that nothing is cut at 1."""
    light = io.tonemap(scene(sm.directions("latlong", height))) / np.float32(255)
    if dtype is np.float32:
        return light.astype(np.float32)
    return np.rint(light * np.iinfo(dtype).max).astype(dtype)


def shown(light: np.ndarray) -> np.ndarray:
    """Return the 8 bits of light that `spheremap convert` would write."""
    if light.dtype == np.uint8:
        return light
    rows = light.reshape(-1, 1, light.shape[-1])
    encoded = np.clip(io.from_linear(np.clip(rows, 0, 1)), 0, 1)
    return np.rint(encoded * np.float32(255)).astype(np.uint8).reshape(light.shape)


def assembled(place: Callable[[int, int], Path], size: int, overlap: int = 0) -> np.ndarray:
    """Return an image of tiles, found by column and row; overlaps hold what they should."""
    rows = []
    while place(0, len(rows)).exists():
        row: list[np.ndarray] = []
        while (path := place(len(row), len(rows))).exists():
            tile = io.read(path)
            left, top = (overlap if k else 0 for k in (len(row), len(rows)))
            row.append(tile[top : top + size, left : left + size])
        rows.append(np.concatenate(row, axis=1))
    return np.concatenate(rows)


def faces(folder: Path, pattern: str, size: int) -> np.ndarray:
    return np.stack(
        [
            assembled(lambda x, y, f=letter: folder / pattern.format(f=f, x=x, y=y), size)
            for letter in LETTERS
        ]
    )


def mean_light(pixels: np.ndarray, p: Any) -> np.ndarray:
    if pixels.dtype == np.uint8:
        pixels = io.to_linear(pixels.reshape(-1, 1, pixels.shape[-1])).reshape(pixels.shape)
    return sm.light.mean(pixels, p, any_aspect=True)


@pytest.mark.parametrize("dtype", [np.float32, np.uint8, np.uint16])
def test_pannellum(dtype: type, tmp_path: Path) -> None:
    image = sky(dtype=dtype)
    made = sm.tiles.write(
        image, "latlong", tmp_path, format="pannellum", tile_size=24, extension="png", title="A sky"
    )
    config = json.loads((tmp_path / "config.json").read_text())
    assert made.manifest == tmp_path / "config.json" and config["title"] == "A sky"
    assert config["type"] == "multires"
    multires = config["multiRes"]
    # 192 / π texels, a multiple of four.
    assert multires == {
        "path": "/%l/%s%y_%x",
        "fallbackPath": "/fallback/%s",
        "extension": "png",
        "tileResolution": 24,
        "maxLevel": 3,
        "cubeResolution": 64,
    }
    assert made.shape == (6, 64, 64) and made.levels == 3
    # Three by three, two by two with edge tiles, one smaller than a tile.
    assert made.tiles == 6 * (9 + 4 + 1)
    assert io.read(tmp_path / "3/f2_1.png").shape == (16, 24, 3)
    levels = [faces(tmp_path, f"{k}/{{f}}{{y}}_{{x}}.png", 24) for k in (3, 2, 1)]
    top = sm.convert(image, "latlong", CUBE, size=64)
    if dtype is np.uint16:
        top = ((top.astype(np.uint32) + 128) // 257).astype(np.uint8)
    assert np.array_equal(levels[0], shown(top))
    fallback = np.stack([io.read(tmp_path / f"fallback/{x}.png") for x in LETTERS])
    assert np.array_equal(fallback, levels[0])
    for k, level in enumerate(levels):
        assert level.shape == (6, 64 >> k, 64 >> k, 3)
        # Each texel is rounded to 8 bits of sRGB, and their errors cancel.
        assert np.allclose(mean_light(level, CUBE), mean_light(levels[0], CUBE), atol=5e-4)


def test_marzipano(tmp_path: Path) -> None:
    image = sky()
    made = sm.tiles.write(
        image, "latlong", tmp_path, format="marzipano", tile_size=24, extension="png"
    )
    data = json.loads((tmp_path / "data.json").read_text())
    # 61 texels in 4 tiles of a side, of an even size.
    assert data["levels"] == [
        {"tileSize": 8, "size": 8, "fallbackOnly": True},
        {"tileSize": 16, "size": 16},
        {"tileSize": 16, "size": 32},
        {"tileSize": 16, "size": 64},
    ]
    assert data["faceSize"] == 64 and data["name"] == tmp_path.name
    assert (data["tileUrl"], data["previewUrl"]) == ("{z}/{f}/{y}/{x}.png", "preview.png")
    assert made.tiles == 6 * (16 + 4 + 1) and made.levels == 3
    levels = [faces(tmp_path, f"{k}/{{f}}/{{y}}/{{x}}.png", 16) for k in (3, 2, 1)]
    assert np.array_equal(levels[0], shown(sm.convert(image, "latlong", CUBE, size=64)))
    preview = io.read(tmp_path / "preview.png").reshape(6, 8, 8, 3)
    order = ["bdflru".index(letter) for letter in LETTERS]
    levels.append(preview[order])
    for level in levels:
        # Each texel is rounded to 8 bits of sRGB; there are few of them in the preview.
        assert np.allclose(mean_light(level, CUBE), mean_light(levels[0], CUBE), atol=1e-3)


def test_photo_sphere_viewer(tmp_path: Path) -> None:
    image = sky(100)
    made = sm.tiles.write(
        image, "latlong", tmp_path, format="photo-sphere-viewer", tile_size=32, extension="png"
    )
    config = json.loads((tmp_path / "config.json").read_text())
    # 200 texels in 8 tiles of 25.
    assert config["levels"] == [
        {"width": 50, "cols": 2, "rows": 1},
        {"width": 100, "cols": 4, "rows": 2},
        {"width": 200, "cols": 8, "rows": 4},
    ]
    assert (made.shape, made.levels, made.tiles) == ((100, 200), 3, 32 + 8 + 2)
    levels = [
        assembled(lambda x, y, k=k: tmp_path / f"{k}/panorama_{x}_{y}.png", 25) for k in (2, 1, 0)
    ]
    # Nothing is turned: it is the image itself.
    assert np.array_equal(levels[0], shown(image))
    assert np.array_equal(io.read(tmp_path / config["baseUrl"]), levels[2])
    for level in levels:
        # Each texel is rounded to 8 bits of sRGB, and their errors cancel.
        assert np.allclose(mean_light(level, "latlong"), mean_light(image, "latlong"), atol=5e-4)


@pytest.mark.parametrize("shape", [(100, 200), (51, 103)])
def test_deep_zoom(shape: tuple[int, int], tmp_path: Path) -> None:
    p = sm.projection("latlong")
    image = shown(scene(p.directions(shape, any_aspect=True)) / 50)
    made = sm.tiles.write(
        image, p, tmp_path, format="deepzoom", tile_size=30, extension="png", any_aspect=True
    )
    root = ElementTree.parse(tmp_path / "panorama.dzi").getroot()
    space = "{http://schemas.microsoft.com/deepzoom/2008}"
    assert root.tag == f"{space}Image"
    assert root.attrib == {"Format": "png", "Overlap": "1", "TileSize": "30"}
    size = root.find(f"{space}Size")
    assert size is not None
    assert size.attrib == {"Height": str(shape[0]), "Width": str(shape[1])}
    last = made.levels - 1
    assert 2 ** (last - 1) < shape[1] <= 2**last
    for k in range(made.levels):
        level = assembled(lambda x, y, k=k: tmp_path / f"panorama_files/{k}/{x}_{y}.png", 30, 1)
        assert level.shape[:2] == tuple(-(-side // 2 ** (last - k)) for side in shape)
        if k == last:
            assert np.array_equal(level, image)
        # Few texels of small levels are rounded to 8 bits of sRGB.
        assert np.allclose(mean_light(level, p), mean_light(image, p), atol=2 / 255)
    # Tiles hold a texel of each neighbor that they have.
    corner = io.read(tmp_path / f"panorama_files/{last}/0_0.png")
    inner = io.read(tmp_path / f"panorama_files/{last}/1_1.png")
    assert corner.shape[:2] == (31, 31)
    assert np.array_equal(corner, image[:31, :31])
    assert np.array_equal(inner, image[29 : 60 + 1, 29:61][: inner.shape[0]])


def test_front_is_ahead_and_upright(tmp_path: Path) -> None:
    """Each face is what a camera sees that is turned to it."""
    image = sky()
    sm.tiles.write(image, "latlong", tmp_path, format="pannellum", extension="png", size=32)
    turns = {"f": (0, 0), "r": (-90, 0), "b": (180, 0), "l": (90, 0), "u": (0, 90), "d": (0, -90)}
    for letter, turn in turns.items():
        camera = sm.projection("perspective", fov=90).turned(sm.rotation(*turn))
        wanted = shown(sm.convert(image, "latlong", camera, size=32))
        got = io.read(tmp_path / f"1/{letter}0_0.png")
        # The same lookups, by other roundings.
        assert np.abs(got.astype(int) - wanted).max() <= 1


def test_other_worlds_are_matched(tmp_path: Path) -> None:
    image = sky()
    blender = sm.convert(image, "latlong", "latlong:blender", size=96)
    for name, given, p in (("a", image, "latlong"), ("b", blender, "latlong:blender")):
        sm.tiles.write(
            given, p, tmp_path / name, format="pannellum", extension="png", size=24, filter="area"
        )
    for letter in LETTERS:
        a, b = (io.read(tmp_path / f"{name}/1/{letter}0_0.png") for name in "ab")
        # The same scene.
        assert np.abs(a.astype(int) - b).max() <= 1


def test_rotation_turns_the_content(tmp_path: Path) -> None:
    image, turn = sky(), sm.rotation(90, 0, 0)
    options = {"format": "pannellum", "extension": "png", "size": 32}
    sm.tiles.write(image, "latlong", tmp_path / "a", **options)
    sm.tiles.write(image, "latlong", tmp_path / "b", rotation=turn, **options)
    ahead = io.read(tmp_path / "a/1/f0_0.png").astype(int)
    # The same lookups, by other roundings.
    assert np.abs(io.read(tmp_path / "b/1/l0_0.png") - ahead).max() <= 1


def test_light_is_cut_or_compressed(tmp_path: Path) -> None:
    light = scene(sm.directions("latlong", 32))
    light[3, 5] = [np.nan, -1, np.inf]
    options = {"format": "deepzoom", "extension": "png"}
    sm.tiles.write(light, "latlong", tmp_path / "a", exposure=-2, **options)
    sm.tiles.write(light, "latlong", tmp_path / "b", exposure=-2, curve="reinhard", **options)
    top = "panorama_files/6/0_0.png"
    light = sm.convert(light, "latlong", "latlong", size=32)
    known = np.nan_to_num(light / 4, nan=0, posinf=1)
    assert np.array_equal(io.read(tmp_path / "a" / top), shown(known))
    assert np.array_equal(io.read(tmp_path / "b" / top), io.tonemap(light, exposure=-2))
    # What is not known has no weight in the next levels.
    assert io.read(tmp_path / "a/panorama_files/3/0_0.png").min() > 0


def test_colors_are_one_or_three(tmp_path: Path) -> None:
    image = np.dstack([sky(16, np.uint8)[..., :1]] * 4)
    image[..., 3] = 7
    for count, kept in ((1, 1), (2, 1), (3, 3), (4, 3)):
        place = tmp_path / str(count)
        sm.tiles.write(image[..., :count], "latlong", place, format="deepzoom", extension="png")
        assert io.read(place / "panorama_files/5/0_0.png").shape == (16, 32, kept)
    sm.tiles.write(
        np.moveaxis(image[..., :3], -1, 0), "latlong", tmp_path / "first", format="deepzoom",
        extension="png", channels_first=True,
    )  # fmt: skip
    a, b = (tmp_path / name / "panorama_files/5/0_0.png" for name in ("first", "3"))
    assert a.read_bytes() == b.read_bytes()


@pytest.mark.parametrize("format", FORMATS)
def test_a_page_shows_what_is_there(format: str, tmp_path: Path) -> None:
    made = sm.tiles.write(sky(16), "latlong", tmp_path / "a", format=format, tile_size=16)
    page = (tmp_path / "a/index.html").read_text()
    assert page.startswith("<!doctype html>")
    assert made.manifest.name in page or format == "hips"
    # Each version is named, so that the page shows tomorrow what it shows today.
    for package in re.findall(r"jsdelivr\.net/npm/(\S+)", page):
        assert re.match(r"(@[\w-]+/)?[\w-]+@\d+\.\d+\.\d+/", package), package
    sm.tiles.write(sky(16), "latlong", tmp_path / "b", format=format, tile_size=16, page=False)
    names = [
        {x.relative_to(tmp_path / name) for x in (tmp_path / name).rglob("*.*")} for name in "ab"
    ]
    assert names[0] - names[1] == {Path("index.html")}


def _no_room(_: int) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("format", FORMATS)
def test_the_manifest_comes_last(
    format: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where writing ends early, nothing says that a pyramid is there, and no file is half one."""
    on_disk: list[set[Path]] = []
    bring = folders.bring_to_disk

    def seen(folder: Path) -> None:
        on_disk.append({path for path in folder.rglob("*") if path.is_file()})
        bring(folder)

    monkeypatch.setattr(folders, "bring_to_disk", seen)
    made = sm.tiles.write(sky(32), "latlong", tmp_path / "a", format=format, tile_size=16)
    # When all is brought to the disk, all is there but the file that says so.
    all_files = {path for path in (tmp_path / "a").rglob("*") if path.is_file()}
    assert on_disk == [all_files - {made.manifest}] and made.manifest in all_files
    with monkeypatch.context() as full:
        full.setattr(os, "fsync", _no_room)
        with pytest.raises(OSError, match=r"cannot write '.*c': No space left on device"):
            sm.tiles.write(sky(32), "latlong", tmp_path / "c", format=format, tile_size=16)
    assert not (tmp_path / "c" / made.manifest.name).exists()
    disk_full_after(7, monkeypatch)
    with pytest.raises(OSError, match="no room"):
        sm.tiles.write(sky(32), "latlong", tmp_path / "b", format=format, tile_size=16)
    left = [path for path in (tmp_path / "b").rglob("*") if path.is_file()]
    assert left and not (tmp_path / "b" / made.manifest.name).exists()
    assert all(io.read(path).size for path in left)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"format": "krpano"}, "unknown format 'krpano'; there are pannellum"),
        ({"format": "panellum"}, "did you mean 'pannellum'"),
        ({"extension": "webp"}, "unknown extension 'webp'; there are jpg, png, fits"),
        ({"extension": "fits"}, "`extension` 'fits' is of 'hips' alone"),
        ({"frame": "galactic"}, "`frame` is of 'hips' alone, got"),
        ({"properties": {"a": "b"}}, "`properties` is of 'hips' alone, got"),
        ({"tile_size": 8}, "`tile_size` must be in [16, 8192], got 8"),
        ({"format": "hips", "tile_size": 48}, "must be a power of two, got 48"),
        ({"size": 0}, "`size` must be in [1, "),
        ({"quality": 101}, "`quality` must be in [1, 100]"),
        ({"exposure": np.nan}, "`exposure` must be finite"),
        ({"curve": "aces"}, "unknown curve 'aces'"),
        ({"frame": "horizon"}, "unknown frame 'horizon'"),
        ({"title": "a\nb"}, "a line of text"),
        ({"properties": {"a b": "c"}}, "one word without '='"),
        ({"properties": {"a": "c\nd"}}, "a line of text"),
        ({"format": "hips", "extension": "fits"}, "hold one channel, `image` has 3"),
    ],
)
def test_what_is_not_there_is_refused(options: Any, says: str, tmp_path: Path) -> None:
    options = {"format": "pannellum", **options}
    with pytest.raises(ValueError, match=re.escape(says)):
        sm.tiles.write(sky(16), "latlong", tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_integers_have_no_exposure(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="are for floats, got uint8"):
        sm.tiles.write(sky(16, np.uint8), "latlong", tmp_path / "a", format="hips", exposure=1)


def test_a_folder_is_new_or_empty(tmp_path: Path) -> None:
    full, file = tmp_path / "full", tmp_path / "file"
    full.mkdir()
    (full / "a.txt").write_text("a")
    file.write_text("a")
    with pytest.raises(FileExistsError, match=r"'.*full': the folder is not empty"):
        sm.tiles.write(sky(16), "latlong", full, format="deepzoom")
    with pytest.raises(NotADirectoryError, match=r"'.*file': it is no folder"):
        sm.tiles.write(sky(16), "latlong", file, format="deepzoom")
    sm.tiles.write(sky(16), "latlong", tmp_path / "made" / "with its parents", format="deepzoom")
