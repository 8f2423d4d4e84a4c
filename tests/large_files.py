"""Image files in tiles or strips that are larger than what a call may take, and what it takes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from spheremap.io import parts, reading, sight, tiling

if TYPE_CHECKING:
    from numpy.typing import NDArray

# For a script of a process of its own: what a call takes of memory that no file backs, for pages of
# files the system takes back when it needs the room.
WATCH = """
import threading, time

def used():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) << 10 for line in file if line.startswith("RssAnon"))

def most_taken(call):
    before, seen, done = used(), [], threading.Event()

    def watch():
        while not done.is_set():
            seen.append(used())
            time.sleep(0.002)

    watcher = threading.Thread(target=watch)
    watcher.start()
    call()
    done.set()
    watcher.join()
    return max(seen) - before
"""


def store(place: str, rows: int, band: NDArray[Any], side: int) -> str:
    """Write bands below each other, in tiles of such a side, or in strips where it is 0."""
    oiio = pytest.importorskip("OpenImageIO")
    height, width, channels = band.shape
    spec = oiio.ImageSpec(width, rows, channels, band.dtype.name)
    spec.tile_width = spec.tile_height = side
    spec.attribute("compression", "none")
    out = oiio.ImageOutput.create(place)
    assert out.open(place, spec), out.geterror()
    for top in range(0, rows, height):
        if side:
            assert out.write_tiles(0, width, top, top + height, 0, 1, band), out.geterror()
        else:
            assert out.write_scanlines(top, top + height, 0, band), out.geterror()
    out.close()
    return place


def shrink(monkeypatch: pytest.MonkeyPatch, window: int = 40) -> None:
    """Let tiles and windows be small enough for the images of a test to have several."""
    monkeypatch.setattr(sight, "_TILE", (16, 32))
    monkeypatch.setattr(reading, "_CACHED", 16)
    monkeypatch.setattr(tiling, "_TILE", 16)
    monkeypatch.setattr(parts, "_MOST", window)
    monkeypatch.setattr(sight, "_KEPT", 1)
