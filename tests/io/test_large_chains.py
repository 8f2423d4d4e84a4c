"""Filters that look a mip chain up, on files larger than memory: the bits of the whole."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import spheremap as sm
from large_files import shrink
from spheremap.io import levels, parts, reading, sight
from spheremap.resample import chained

rng = np.random.default_rng(23)

CROSS = sm.projection("cube", layout="cross")


@pytest.fixture(autouse=True)
def little_memory(monkeypatch):
    """Images of a test are small: so are tiles, windows and what there is."""
    shrink(monkeypatch, window=24)
    monkeypatch.setattr(levels, "_MOST", 13)
    monkeypatch.setattr(parts, "LEAST_MEMORY", 0)


def expect_same(folder, image, src, dst, **options):
    """A file made of parts holds what is made of the whole, and nothing is left beside it."""
    extension = ".png" if image.dtype.kind == "u" else ".exr"
    source, target = folder / f"in{extension}", folder / f"out{extension}"
    sm.io.write(source, image)
    sm.io.convert_file(source, target, src, dst, memory=4 << 20, **options)
    whole = sm.convert(image, src, dst, **options)
    np.testing.assert_array_equal(sm.io.read(target), whole)
    assert sorted(p.name for p in folder.iterdir()) == sorted([source.name, target.name])


def random_image(p, size, dtype=np.float32, channels=3):
    p = sm.projection(p) if isinstance(p, str) else p
    image = rng.random((*p.shape(size), channels))
    if np.dtype(dtype).kind == "u":
        return (image * np.iinfo(dtype).max).astype(dtype)
    return image.astype(dtype)


@pytest.mark.parametrize("filter", ["trilinear", "ewa"])
@pytest.mark.parametrize(
    ("src", "size", "dst", "to"),
    [
        ("latlong", 67, CROSS, 20),
        ("latlong", 96, "angular", 200),
        ("latlong:cmft", 49, "octahedral", 30),
        (CROSS, 31, "latlong", 16),
        ("cube:filament", 33, "latlong", 60),
        ("angular", 101, "latlong", 24),
        ("sinusoidal", 60, CROSS, 25),
        ("octahedral", 70, "latlong:blender", 9),
    ],
    ids=str,
)
def test_a_file_has_the_bits_of_the_whole(tmp_path, filter, src, size, dst, to):
    turn = sm.rotation(30, 40, 50)
    expect_same(tmp_path, random_image(src, size), src, dst, filter=filter, size=to, rotation=turn)


@pytest.mark.parametrize("filter", ["trilinear", "ewa"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32])
def test_all_types_of_texels(tmp_path, filter, dtype):
    image = random_image("latlong", 80, dtype, channels=1)
    expect_same(tmp_path, image, "latlong", "equal_area", filter=filter, size=24, world="literal")


@pytest.mark.parametrize(
    "options", [{"skipna": True}, {"alpha": 3}, {"alpha": -1, "skipna": True}], ids=str
)
@pytest.mark.parametrize("filter", ["trilinear", "ewa"])
@pytest.mark.parametrize("holes", [True, False])
def test_the_chain_is_that_of_weighed_texels(tmp_path, filter, options, holes):
    image = random_image("latlong", 80, channels=4)
    if holes:
        image[10:20, 100:130] = np.nan
        image[70:, :9, 2] = np.inf
        image[40, 40, 3] = np.inf
    options = {"size": 30, "fill": 2.0, **options}
    expect_same(tmp_path, image, "latlong", "angular", filter=filter, **options)


def test_alpha_of_integers(tmp_path):
    image = random_image("latlong", 80, np.uint16, channels=4)
    image[20:50, :, 3] = 0
    expect_same(tmp_path, image, "latlong", CROSS, filter="ewa", alpha=3, size=20)


def test_images_without_levels(tmp_path):
    image = random_image("latlong", 1)
    expect_same(tmp_path, image, "latlong", "octahedral", filter="ewa", size=4)


@pytest.mark.parametrize("every", [8, 10**6])
@pytest.mark.parametrize("memory", [1 << 20, 3 << 20])
def test_little_memory_makes_smaller_parts(tmp_path, monkeypatch, memory, every):
    """Also where a window sees what its first row and its last do not."""
    monkeypatch.setattr(sight, "_TILE", (8, 16))
    monkeypatch.setattr(chained, "_EVERY", every)
    image = random_image("latlong", 192)
    sm.io.write(tmp_path / "in.exr", image)
    target = tmp_path / "out.exr"
    options = {"filter": "ewa", "size": 96}
    sm.io.convert_file(tmp_path / "in.exr", target, "latlong", CROSS, memory=memory, **options)
    whole = sm.convert(image, "latlong", CROSS, **options)
    np.testing.assert_array_equal(sm.io.read(target), whole)


def test_what_is_made_smaller_reads_the_image_once(tmp_path, monkeypatch):
    """Where no lookup is among its texels, they are not read for the result."""
    read = []
    texels = reading.Reader.read

    def counted(self, part):
        read.append((part.bottom - part.top) * (part.right - part.left))
        return texels(self, part)

    monkeypatch.setattr(reading.Reader, "read", counted)
    image = random_image("latlong", 128)
    expect_same(tmp_path, image, "latlong", "octahedral", filter="trilinear", size=16)
    assert sum(read) == 128 * 256


def cut_off(monkeypatch, of, name, after):
    """Let a call fail after so many calls of a method, and count these."""
    count, method = [0], getattr(of, name)

    def counted(*arguments):
        count[0] += 1
        if count[0] > after:
            raise KeyboardInterrupt
        return method(*arguments)

    monkeypatch.setattr(of, name, counted)
    return count


@pytest.mark.parametrize("resume", [True, False])
def test_what_was_cut_off_goes_on(tmp_path, resume):
    image = random_image("latlong", 96)
    sm.io.write(tmp_path / "in.exr", image)
    places = tmp_path / "in.exr", tmp_path / "out.exr"
    options = {"size": 48, "filter": "ewa"}

    def call():
        sm.io.convert_file(*places, "latlong", CROSS, memory=4 << 20, resume=resume, **options)

    # While the levels are made, and while the result is.
    for of, name in ((levels.LevelFile, "_mapped"), (parts._Made, "put")):
        with pytest.MonkeyPatch.context() as patch:
            cut_off(patch, of, name, 5)
            with pytest.raises(KeyboardInterrupt):
                call()
        # Tiles of the source, its levels, and texels.
        assert len(list(tmp_path.iterdir())) == 1 + 3 * resume
        assert not places[1].exists()
    call()
    whole = sm.convert(image, "latlong", CROSS, **options)
    np.testing.assert_array_equal(sm.io.read(places[1]), whole)
    assert len(list(tmp_path.iterdir())) == 2


def test_levels_that_are_there_are_not_made_again(tmp_path, monkeypatch):
    image = random_image("latlong", 96)
    sm.io.write(tmp_path / "in.exr", image)
    places = tmp_path / "in.exr", tmp_path / "out.exr"
    options = {"size": 48, "filter": "trilinear", "memory": 4 << 20, "resume": True}
    with pytest.MonkeyPatch.context() as patch:
        cut_off(patch, parts._Made, "put", 5)
        with pytest.raises(KeyboardInterrupt):
            sm.io.convert_file(*places, "latlong", CROSS, **options)
    made = cut_off(monkeypatch, parts.Chained, "halved", 0)
    sm.io.convert_file(*places, "latlong", CROSS, **options)
    assert made[0] == 0
    whole = sm.convert(image, "latlong", CROSS, size=48, filter="trilinear")
    np.testing.assert_array_equal(sm.io.read(places[1]), whole)


KILLED = """
import os, signal, sys
import spheremap as sm
from spheremap.io import levels, parts, sight

count, last = [0], int(sys.argv[3])
of, name = (levels.LevelFile, "_mapped") if last < 30 else (parts._Made, "put")
method = getattr(of, name)

def killed(*arguments):
    count[0] += 1
    if count[0] == last % 30:
        os.kill(os.getpid(), signal.SIGKILL)
    return method(*arguments)

setattr(of, name, killed)
sight._TILE, parts._MOST, parts._SAY, levels._MOST = (16, 32), 24, 0.0, 13
parts.LEAST_MEMORY, sight._KEPT = 0, 1
cross = sm.projection("cube", layout="cross")
sm.io.convert_file(
    *sys.argv[1:3], "latlong", cross, size=48, memory=4 << 20, filter="ewa", resume=True
)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs a signal that ends a process at once")
def test_killed_processes_leave_what_the_next_one_goes_on_with(tmp_path):
    image = random_image("latlong", 96)
    source, target = tmp_path / "in.exr", tmp_path / "out.exr"
    sm.io.write(source, image)
    # While the levels are made, and while the result is.
    for last in (20, 49):
        command = [sys.executable, "-c", KILLED, source, target, str(last)]
        done = subprocess.run(command, check=False, capture_output=True)
        assert done.returncode == -signal.SIGKILL, done.stderr
        assert not target.exists()
    options = {"size": 48, "filter": "ewa"}
    sm.io.convert_file(source, target, "latlong", CROSS, memory=4 << 20, resume=True, **options)
    whole = sm.convert(image, "latlong", CROSS, **options)
    np.testing.assert_array_equal(sm.io.read(target), whole)
    assert len(list(tmp_path.iterdir())) == 2
