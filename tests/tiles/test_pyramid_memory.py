"""Pyramids of files larger than memory take what they were given, and a tenth."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from large_files import WATCH, store

pytest.importorskip("OpenImageIO")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="looks into /proc"),
]

SCRIPT = (
    WATCH
    + """
import os, sys
import numpy as np, spheremap as sm, spheremap.tiles

place, folder, format, extension, limit = *sys.argv[1:5], int(sys.argv[5]) << 20
os.fsync = lambda handle: None

def write(source, folder):
    return sm.tiles.write_file(
        source, "latlong", folder, format=format, extension=extension, memory=limit
    )

# What the first call of any size takes is there before.
channels = 1 if extension == "fits" else 3
sm.io.write(folder + ".small.tif", np.ones((64, 128, channels), np.uint16))
write(folder + ".small.tif", folder + ".small")
made = []
taken = most_taken(lambda: made.append(write(place, folder)))
print(made[0].shape[1], taken)
"""
)


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
    shape = 256, 6144, 1 if extension == "fits" else 3
    band = np.random.default_rng(0).integers(0, 50_000, shape, np.uint16)
    # Its levels take far more than the call may.
    place = store(str(tmp_path / "sky.tif"), 3072, band, side)
    command = [sys.executable, "-c", SCRIPT, place, str(tmp_path / "out"), format, extension, "128"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    made, taken = map(int, done.stdout.split())
    # All of it would take more than twice as much.
    assert made >= 1900
    # A tenth more is what the page grants.
    assert 8 < taken / 2**20 < 141, f"{taken / 2**20:.0f} MiB"
