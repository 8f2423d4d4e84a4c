"""Measure the conversion of a file larger than its memory; write a part of BENCHMARKS.md.

    python benches/large.py                    # up to 65536×32768, 16 GB of disk; rewrites it
    python benches/large.py --widths 131072    # 65 GB
    python benches/large.py --widths 131072 --compressed    # 30 GB; a section of its own
    python benches/large.py --widths 131072 --compressed --source FILE    # made if it is not there
    python benches/large.py --quick            # a smoke test with a small file, printed only

A BigTIFF of 8 bits in tiles becomes the faces of a cube by `spheremap convert --memory`, and,
beside it, an image of as many texels by the plain resize of libvips and of OpenImageIO, which know
no sphere; OpenImageIO's holds its result, and is left out where that is large. Each runs in a
process of its own, from file to file, in turn. Counted are the memory that no file backs,
of which the largest of many looks is taken, and the time of all its threads beside that on the
clock.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from measure import machine, publish, say, table

BEGIN, END = "<!-- large: written by benches/large.py -->", "<!-- large: end -->"
BEGIN_COMPRESSED = "<!-- large, compressed: written by benches/large.py -->"
END_COMPRESSED = "<!-- large, compressed: end -->"
TILE = 256
# Looks at a process's memory, in seconds.
EVERY = 0.05

# Both kernels are bilinear, antialiased where they make smaller.
VIPS = """
import sys, pyvips
source, target, scale = sys.argv[1], sys.argv[2], float(sys.argv[3])
image = pyvips.Image.new_from_file(source, access="sequential")
how = {"compression": "deflate", "level": 1} if sys.argv[4] == "zip:1" else {}
image.resize(scale, kernel="linear").tiffsave(target, tile=True, bigtiff=True, **how)
"""


# It holds its result: of wider sources too much.
LARGEST_HELD = 32768
OIIO = """
import sys, OpenImageIO as oiio
source, target, scale = sys.argv[1], sys.argv[2], float(sys.argv[3])
image = oiio.ImageBuf(source)
spec = image.spec()
width, height = round(spec.width * scale), round(spec.height * scale)
result = oiio.ImageBuf(oiio.ImageSpec(width, height, spec.nchannels, spec.format))
assert oiio.ImageBufAlgo.resize(result, image, filtername="triangle"), result.geterror()
result.set_write_tiles(256, 256)
result.specmod()["compression"] = sys.argv[4]
assert result.write(target), result.geterror()
"""
PEERS = {
    "libvips: `resize(kernel='linear')` to as many texels": VIPS,
    "OpenImageIO: `resize(filtername='triangle')` to as many texels": OIIO,
}


@dataclass(frozen=True)
class Run:
    """What a process took."""

    wall: float
    cpu: float
    memory: int


def source(path: Path, width: int, compression: str) -> None:
    """Write a latlong in tiles: waves, so that no two tiles are alike."""
    height = width // 2
    spec = oiio.ImageSpec(width, height, 3, "uint8")
    spec.tile_width = spec.tile_height = TILE
    spec.attribute("compression", compression)
    spec.attribute("tiff:bigtiff", 1)
    out = oiio.ImageOutput.create(str(path))
    if not out.open(str(path), spec):
        raise OSError(out.geterror())
    u = np.arange(width, dtype=np.float32)[:, None] * np.float32(2 * math.pi / width)
    across = np.sin(u * np.array([3, 50, 400], np.float32))
    for top in range(0, height, TILE):
        rows = min(TILE, height - top)
        v = np.arange(top, top + rows, dtype=np.float32)[:, None] * np.float32(math.pi / height)
        down = np.cos(v * np.array([2, 60, 500], np.float32))
        band = ((across * down[:, None] + 1) * 127.5).astype(np.uint8)
        if not out.write_tiles(0, width, top, top + rows, 0, 1, band):
            raise OSError(out.geterror())
    out.close()


def run(command: list[str]) -> Run:
    """Run a command and look at its memory as it goes."""
    start, most = time.perf_counter(), 0
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    while True:
        done, status, used = os.wait4(process.pid, os.WNOHANG)
        if done:
            break
        most = max(most, anonymous(process.pid))
        time.sleep(EVERY)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return Run(time.perf_counter() - start, used.ru_utime + used.ru_stime, most)


def anonymous(process: int) -> int:
    """Return the bytes of a process that no file backs."""
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return 0
    for line in text.splitlines():
        if line.startswith("RssAnon"):
            return int(line.split()[1]) << 10
    return 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--widths", type=int, nargs="+", default=[32768, 65536])
    parser.add_argument("--memory", default="512M")
    parser.add_argument("--compressed", action="store_true", help="deflate, on both sides")
    parser.add_argument("--folder", type=Path, help="where there is room")
    parser.add_argument("--source", type=Path, help="of one width, which is left where it is")
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    compression = "zip:1" if args.compressed else "none"
    marks = (BEGIN_COMPRESSED, END_COMPRESSED) if args.compressed else (BEGIN, END)
    rows = []
    for width in [2048] if args.quick else args.widths:
        with tempfile.TemporaryDirectory(dir=args.folder, prefix="spheremap-large-") as name:
            path = args.source or Path(name) / "source.tif"
            if not path.exists():
                source(path, width, compression)
            rows += measured(path, Path(name), width, args.memory, compression)
    remark = args.remark and f", {args.remark}"
    text = [
        marks[0],
        f"## Files larger than memory{', compressed' if args.compressed else ''}",
        "BigTIFFs of 3 channels of 8 bits in tiles, "
        f"{'deflated at level 1' if args.compressed else 'not compressed'}, from file to file; "
        f"{machine()}{remark}. Time of all threads, and the most memory that no file backs. The "
        "resizes know no sphere, and their image has one face.",
        table(
            ["source", "work", "clock", "threads", "Mtexel per CPU second", "memory"],
            rows,
        ),
        marks[1],
    ]
    publish(text, args.quick)


def measured(
    path: Path, folder: Path, width: int, memory: str, compression: str
) -> list[list[str]]:
    """Return the rows of a source of this width."""
    side = width // 4
    texels = 6 * side * side
    size = path.stat().st_size
    say(f"a source of {size / 1e9:.1f} GB")
    to_faces = [
        *("--from", "latlong", "--to", "cube", "--layout", "faces", "--size", str(side)),
        *("--memory", memory, "--compression", compression),
    ]
    command = [sys.executable, "-m", "spheremap.cli", "convert", str(path)]
    found = {}
    name = f"`convert --memory {memory}` to 6 faces of {side}²"
    found[name] = run([*command, str(folder / "out_{face}.tif"), *to_faces])
    for face in folder.glob("out_*.tif"):
        face.unlink()
    say(f"ours: {found[name]}")
    # As many texels, of the source's aspect.
    scale = math.sqrt(texels / (width * width / 2))
    for name, program in PEERS.items():
        if program is OIIO and width > LARGEST_HELD:
            continue
        target = folder / "resized.tif"
        words = [str(path), str(target), str(scale), compression]
        found[name] = run([sys.executable, "-c", program, *words])
        target.unlink()
        say(f"{name}: {found[name]}")
    return [
        [
            f"{width}×{width // 2}, {size / 1e9:.1f} GB",
            what,
            f"{r.wall:.0f} s",
            f"{r.cpu:.0f} s",
            f"{texels / r.cpu / 1e6:.1f}",
            f"{r.memory / (1 << 20):.0f} MiB",
        ]
        for what, r in found.items()
    ]


if __name__ == "__main__":
    main()
