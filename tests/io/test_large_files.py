"""Files larger than memory: the bits of the whole, from its parts."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from large_files import shrink
from spheremap.io import parts, reading, sight, tiling
from spheremap.resample.seen import Rectangle

rng = np.random.default_rng(17)

CROSS = sm.projection("cube", layout="cross")


@pytest.fixture(autouse=True)
def little_memory(monkeypatch):
    """Images of a test are small: so are tiles, parts and what there is."""
    shrink(monkeypatch)
    monkeypatch.setattr(parts, "LEAST_MEMORY", 0)


def stored(folder, extension, height=96):
    """Return an image file, and what it holds."""
    image = rng.random((height, 2 * height, 3)).astype(np.float32)
    if extension == ".png":
        image = (image * 255).astype(np.uint8)
    sm.io.write(folder / f"in{extension}", image)
    return folder / f"in{extension}", sm.io.read(folder / f"in{extension}")


@pytest.mark.parametrize(
    ("read", "written", "dst", "options"),
    [
        (".exr", ".exr", CROSS, {"rotation": sm.rotation(30, 40, 50)}),
        (".tif", ".exr", "angular", {"filter": "lanczos3", "fill": 2.0}),
        (".png", ".png", "octahedral", {"filter": "nearest"}),
        (".png", ".tif", "latlong:blender", {"world": "literal"}),
        (".png", ".exr", "cube:openexr", {"antialias": False}),
    ],
)
def test_a_file_has_the_bits_of_the_whole(tmp_path, read, written, dst, options):
    source, image = stored(tmp_path, read)
    target, whole = tmp_path / f"out{written}", tmp_path / f"whole{written}"
    sm.io.convert_file(source, target, "latlong", dst, memory=4 << 20, **options)
    sm.io.write(whole, sm.convert(image, "latlong", dst, **options))
    np.testing.assert_array_equal(sm.io.read(target), sm.io.read(whole))
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(
        [source.name, target.name, whole.name]
    )


@pytest.mark.parametrize(
    "options", [{"skipna": True}, {"alpha": 2}, {"alpha": -1, "skipna": True}], ids=str
)
@some_fast("filter", ["bilinear", "catmull-rom", "area", "nearest"], fast=("bilinear", "area"))
def test_what_weighs_texels_sees_parts_alone(tmp_path, filter, options):
    image = rng.random((96, 192, 3)).astype(np.float32)
    if "skipna" in options:
        image[10:20, 100:130] = np.nan
        image[90:, :9, 2] = np.inf
    source, target = tmp_path / "in.exr", tmp_path / "out.exr"
    sm.io.write(source, image)
    options = {"filter": filter, "size": 40, "rotation": sm.rotation(9, 80, 7), **options}
    sm.io.convert_file(source, target, "latlong", "angular", memory=4 << 20, **options)
    whole = sm.convert(image, "latlong", "angular", **options)
    np.testing.assert_array_equal(sm.io.read(target), whole)


def test_little_memory_makes_smaller_parts_and_too_little_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(sight, "_TILE", (8, 16))
    source, image = stored(tmp_path, ".exr", height=192)
    target = tmp_path / "out.exr"
    # Rows of tiles, each with a page, are 20 MiB; half of this is for what a part sees.
    sm.io.convert_file(source, target, "latlong", CROSS, size=32, memory=6 << 20)
    whole = sm.convert(image, "latlong", CROSS, size=32)
    np.testing.assert_array_equal(sm.io.read(target), whole)
    target.unlink()
    with pytest.raises(ValueError, match="memory"):
        sm.io.convert_file(source, target, "latlong", CROSS, size=32, memory=1 << 16)
    assert [p.name for p in tmp_path.iterdir()] == [source.name]


@pytest.mark.parametrize("kind", ["uint8", "uint16", "half", "float"])
@pytest.mark.parametrize("channels", [1, 2, 4, 5])
def test_copies_in_tiles_have_the_same_bits(tmp_path, kind, channels):
    """Those of NaN and of alpha among them: to a copy all is numbers."""
    oiio = pytest.importorskip("OpenImageIO")
    dtype = np.dtype({"half": np.float16, "float": np.float32}.get(kind, kind))
    bits = rng.integers(0, 2 ** (8 * dtype.itemsize), (70, 150, channels), np.uint64)
    image = bits.astype(f"u{dtype.itemsize}").view(dtype)
    place = str(tmp_path / ("a.exr" if dtype.kind == "f" else "a.tif"))
    sink = oiio.ImageOutput.create(place)
    sink.open(place, oiio.ImageSpec(150, 70, channels, kind))
    sink.write_image(image)
    sink.close()
    read = sm.io.read(place)
    source = reading.Source([place], 0, read.dtype, channels, lambda texels: texels)
    assert not tiling.has_tiles(source)
    copies = tiling.in_tiles(source, tmp_path / "tiles", 16 * 150 * channels * dtype.itemsize)
    assert tiling.has_tiles(copies)
    reader = reading.Reader(copies, 150, 1 << 20)
    assert reader.read(Rectangle(0, 70, 0, 150, None)).tobytes() == read.tobytes()
    part = reader.read(Rectangle(13, 66, 5, 149, None))
    assert part.dtype == read.dtype and part.tobytes() == read[13:66, 5:149].tobytes()


def test_a_file_in_strips_is_decoded_once(tmp_path, monkeypatch):
    """Once it is in tiles, nobody opens it; in tiles it is read as it is."""
    oiio = pytest.importorskip("OpenImageIO")
    seen = []

    class Reader(reading.Reader):
        def __init__(self, source, *rest):
            seen.extend(source.files)
            super().__init__(source, *rest)

    monkeypatch.setattr(parts, "Reader", Reader)
    source, image = stored(tmp_path, ".exr")
    spec = oiio.ImageSpec(192, 96, 3, "float")
    spec.tile_width, spec.tile_height = 32, 16
    sink = oiio.ImageOutput.create(str(tmp_path / "tiled.exr"))
    sink.open(str(tmp_path / "tiled.exr"), spec)
    sink.write_image(image)
    sink.close()
    for place in (source, tmp_path / "tiled.exr"):
        sm.io.convert_file(place, tmp_path / "out.exr", "latlong", CROSS, memory=4 << 20)
    copy, itself = seen
    assert copy != str(source) and itself == str(tmp_path / "tiled.exr")


def test_a_file_that_breaks_off_leaves_nothing(tmp_path):
    source, _ = stored(tmp_path, ".png")
    source.write_bytes(source.read_bytes()[:2000])
    with pytest.raises(OSError, match="cannot read"):
        sm.io.convert_file(source, tmp_path / "out.exr", "latlong", CROSS, memory=8 << 20)
    assert [p.name for p in tmp_path.iterdir()] == [source.name]


def test_tiles_that_the_memory_does_not_hold_are_an_error(tmp_path):
    oiio = pytest.importorskip("OpenImageIO")
    place = str(tmp_path / "tiled.tif")
    spec = oiio.ImageSpec(512, 256, 3, "float")
    spec.tile_width, spec.tile_height = 512, 256
    sink = oiio.ImageOutput.create(place)
    sink.open(place, spec)
    sink.write_image(np.zeros((256, 512, 3), np.float32))
    sink.close()
    with pytest.raises(ValueError, match=r"at least 16777216 bytes.*512 x 256"):
        sm.io.convert_file(place, tmp_path / "a.exr", "latlong", "angular", memory=(16 << 20) - 8)
    sm.io.convert_file(place, tmp_path / "a.exr", "latlong", "angular", memory=16 << 20)


PUT = parts._Made.put


def cut_off(monkeypatch, after):
    """Let a conversion fail after so many parts of the result, and count them."""
    count = [0]

    def counted(self, window, texels):
        count[0] += 1
        if count[0] > after:
            raise KeyboardInterrupt
        PUT(self, window, texels)

    monkeypatch.setattr(parts._Made, "put", counted)
    return count


@pytest.mark.parametrize("resume", [True, False])
def test_what_was_cut_off_goes_on(tmp_path, monkeypatch, resume):
    source, image = stored(tmp_path, ".exr")
    target = tmp_path / "out.exr"
    options = {"size": 48, "memory": 8 << 20, "resume": resume}
    whole = cut_off(monkeypatch, 10**9)
    sm.io.convert_file(source, target, "latlong", CROSS, **options)
    target.unlink()
    cut_off(monkeypatch, whole[0] // 2)
    with pytest.raises(KeyboardInterrupt):
        sm.io.convert_file(source, target, "latlong", CROSS, **options)
    assert not target.exists()
    # Texels that are there, and tiles of the source.
    assert len(list(tmp_path.iterdir())) == 1 + 2 * resume
    rest = cut_off(monkeypatch, 10**9)
    sm.io.convert_file(source, target, "latlong", CROSS, **options)
    assert (rest[0] < whole[0]) == resume
    expected = sm.convert(image, "latlong", CROSS, size=48)
    np.testing.assert_array_equal(sm.io.read(target), expected)
    assert len(list(tmp_path.iterdir())) == 2


KILLED = """
import os, signal, sys
import spheremap as sm
from spheremap.io import parts, sight

count, put = [0], parts._Made.put

def killed(self, window, texels):
    count[0] += 1
    if count[0] == 30:
        os.kill(os.getpid(), signal.SIGKILL)
    put(self, window, texels)

parts._Made.put, sight._TILE, parts._MOST, parts._SAY = killed, (16, 32), 40, 0.0
parts.LEAST_MEMORY, sight._KEPT = 0, 1
cross = sm.projection("cube", layout="cross")
sm.io.convert_file(*sys.argv[1:], "latlong", cross, size=48, memory=8 << 20, resume=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs a signal that ends a process at once")
def test_a_killed_process_leaves_what_the_next_one_goes_on_with(tmp_path, monkeypatch):
    source, image = stored(tmp_path, ".exr")
    target = tmp_path / "out.exr"
    command = [sys.executable, "-c", KILLED, source, target]
    done = subprocess.run(command, check=False, capture_output=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert not target.exists()
    rest = cut_off(monkeypatch, 10**9)
    options = {"size": 48, "memory": 8 << 20, "resume": True}
    sm.io.convert_file(source, target, "latlong", CROSS, **options)
    resumed = rest[0]
    np.testing.assert_array_equal(sm.io.read(target), sm.convert(image, "latlong", CROSS, size=48))
    assert len(list(tmp_path.iterdir())) == 2
    sm.io.convert_file(source, target, "latlong", CROSS, **options)
    # 29 parts were there; of a window that was divided in quarters some may be made again.
    assert resumed < rest[0] - resumed


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"dst": "cube"}, ValueError, "layout"),
        ({"src": "angular"}, ValueError, "as wide as high"),
        ({"filter": "linear"}, ValueError, "linear"),
        ({"memory": 1.5}, TypeError, "memory"),
        ({"target": "out.jpg"}, ValueError, "tonemap"),
        ({"target": "out.xyz"}, OSError, "unknown format"),
        ({"source": "none.exr"}, FileNotFoundError, "no such file"),
        ({"compression": "best"}, ValueError, "compression"),
    ],
)
def test_errors_come_before_the_work(tmp_path, change, error, said):
    source, _ = stored(tmp_path, ".exr")
    given = {"source": source, "target": "out.exr", "src": "latlong", "dst": CROSS} | change
    places = tmp_path / given.pop("source"), tmp_path / given.pop("target")
    with pytest.raises(error, match=said):
        sm.io.convert_file(*places, given.pop("src"), given.pop("dst"), **given)
    assert [p.name for p in tmp_path.iterdir()] == [os.path.basename(source)]


def test_what_is_turned_or_placed_is_an_error(tmp_path):
    oiio = pytest.importorskip("OpenImageIO")
    spec = oiio.ImageSpec(8, 4, 3, "uint8")
    spec.attribute("Orientation", 6)
    place = str(tmp_path / "turned.tif")
    sink = oiio.ImageOutput.create(place)
    sink.open(place, spec)
    sink.write_image(np.zeros((4, 8, 3), np.uint8))
    sink.close()
    with pytest.raises(ValueError, match="turned"):
        sm.io.convert_file(place, tmp_path / "a.tif", "latlong", "octahedral")


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room can be set aside")
def test_a_disk_without_room_is_an_error_before_the_work(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    source, _ = stored(tmp_path, ".exr")
    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(OSError, match="no room"):
        sm.io.convert_file(source, tmp_path / "out.exr", "latlong", CROSS, memory=8 << 20)
    assert [p.name for p in tmp_path.iterdir()] == [source.name]
