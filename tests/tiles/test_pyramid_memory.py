"""Pyramids of files larger than memory take what they were given, and a tenth."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

oiio = pytest.importorskip("OpenImageIO")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="looks into /proc"),
]

# Memory that no file backs: pages of files the system takes back when it needs the room.
SCRIPT = """
import os, sys, threading, time
import numpy as np, spheremap as sm, spheremap.tiles

place, folder, format, extension, limit = *sys.argv[1:5], int(sys.argv[5]) << 20
os.fsync = lambda handle: None

def used():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) << 10 for line in file if line.startswith("RssAnon"))

def watch():
    while not done.is_set():
        seen.append(used())
        time.sleep(0.002)

def write(source, folder):
    return sm.tiles.write_file(
        source, "latlong", folder, format=format, extension=extension, memory=limit
    )

# What the first call of any size takes is there before.
channels = 1 if extension == "fits" else 3
sm.io.write(folder + ".small.tif", np.ones((64, 128, channels), np.uint16))
write(folder + ".small.tif", folder + ".small")
before, seen, done = used(), [], threading.Event()
watcher = threading.Thread(target=watch)
watcher.start()
made = write(place, folder)
done.set()
watcher.join()
print(made.shape[1], max(seen) - before)
"""


def large(place: str, channels: int, side: int) -> str:
    """Write a file in tiles of such a side, or in strips, whose levels take far more."""
    band = np.random.default_rng(0).integers(0, 50_000, (256, 8192, channels), np.uint16)
    spec = oiio.ImageSpec(8192, 4096, channels, "uint16")
    spec.tile_width = spec.tile_height = side
    spec.attribute("compression", "none")
    out = oiio.ImageOutput.create(place)
    assert out.open(place, spec), out.geterror()
    for top in range(0, 4096, 256):
        if side:
            assert out.write_tiles(0, 8192, top, top + 256, 0, 1, band), out.geterror()
        else:
            assert out.write_scanlines(top, top + 256, 0, band), out.geterror()
    out.close()
    return place


@pytest.mark.parametrize(
    ("format", "extension", "side"),
    [
        ("marzipano", "jpg", 256),
        ("pannellum", "png", 0),
        ("deepzoom", "jpg", 0),
        ("hips", "jpg", 256),
        ("hips", "fits", 256),
    ],
)
def test_it_keeps_within_its_memory(format: str, extension: str, side: int, tmp_path: Path) -> None:
    if extension == "fits":
        pytest.importorskip("astropy")
    place = large(str(tmp_path / "sky.tif"), 1 if extension == "fits" else 3, side)
    command = [sys.executable, "-c", SCRIPT, place, str(tmp_path / "out"), format, extension, "128"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    shape, taken = map(int, done.stdout.split())
    # All of it would take more than twice as much.
    assert shape >= 2048
    # A tenth more is what the page grants.
    assert 8 < taken / 2**20 < 141, f"{taken / 2**20:.0f} MiB"
