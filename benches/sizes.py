"""Time conversions of images of all sizes, by one thread and two; write its part of BENCHMARKS.md.

    python benches/sizes.py            # rewrites the section
    python benches/sizes.py --quick    # a smoke test: small images, printed only

Each size runs in a process of its own, whose memory while it converts the kernel tells (Linux).
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import spheremap as sm
from measure import machine, publish, say, table

BEGIN, END = "<!-- sizes: written by benches/sizes.py -->", "<!-- sizes: end -->"
# From here on neither source nor target is in the cache of any core.
BEYOND = 4096
MIB = 1 << 20


def status(name: str) -> int:
    """Return a number of bytes that the kernel keeps of this process."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    (line,) = (line for line in lines if line.startswith(name))
    return int(line.split()[1]) << 10


def measured(width: int) -> dict[str, float]:
    """Return seconds by one thread and by two, and the bytes of memory beside both images."""
    image = np.full((width // 2, width, 3), 100, np.uint8)
    image += np.arange(width, dtype=np.uint8)[None, :, None]
    out = np.ones((6, width // 4, width // 4, 3), np.uint8)
    found: dict[str, float] = {}
    for antialias in (False, True):
        for threads in (1, 2):
            sm.set_num_threads(threads)
            times: list[float] = []
            while len(times) < 3 or (sum(times) < 0.3 and len(times) < 100):
                before = status("VmRSS")
                Path("/proc/self/clear_refs").write_text("5")
                start = time.perf_counter()
                sm.convert(image, "latlong", "cube", size=width // 4, antialias=antialias, out=out)
                times.append(time.perf_counter() - start)
                beside = status("VmHWM") - before
                found["memory"] = max(found.get("memory", 0), beside)
            # The first call wakes threads.
            found[f"{antialias} {threads}"] = statistics.median(times[1:])
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small images")
    parser.add_argument("--one", type=int, help="measure this width alone, and print it")
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    if args.one:
        print(json.dumps(measured(args.one)))
        return
    widths = [256 << k for k in range(3 if args.quick else 8)]
    found = {}
    for width in widths:
        say(f"{width}×{width // 2}")
        command = [sys.executable, __file__, "--one", str(width)]
        run = subprocess.run(command, check=True, capture_output=True, text=True)
        found[width] = json.loads(run.stdout)
    count = {width: 6 * (width // 4) ** 2 for width in widths}
    body = []
    for width, its in found.items():
        texels = count[width]
        row = [f"{width}×{width // 2}", f"{texels / 1e6:.3g}"]
        for antialias in (False, True):
            one, two = (its[f"{antialias} {threads}"] for threads in (1, 2))
            row += [f"{one / texels * 1e9:.1f}", f"{two / texels * 1e9:.1f}", f"{one / two:.2f}×"]
        body.append([*row, f"{its['memory'] / MIB:.1f}"])
    large = [width for width in widths if width >= BEYOND] or widths
    x = [math.log(count[width]) for width in large]
    slopes = []
    for antialias in (False, True):
        y = [math.log(found[width][f"{antialias} 2"]) for width in large]
        slopes.append(statistics.linear_regression(x, y).slope)
    remark = args.remark and f", {args.remark}"
    text = [
        BEGIN,
        "## Size and threads",
        "A latlong of three bytes a texel to a cube a quarter as wide, `out=`: nanoseconds by the "
        "clock for each texel of the cube, by one thread and by two, bilinear and with "
        "`convert`'s defaults. The memory is what a call takes beside both images, at most, in "
        f"MiB. {machine()}{remark}.",
        table(
            [
                "latlong",
                "million texels",
                "plain, 1 thread",
                "2 threads",
                "ratio",
                "default, 1 thread",
                "2 threads",
                "ratio",
                "memory",
            ],
            body,
        ),
        f"From {BEYOND} columns on, time grows as the number of texels to the power of "
        f"{slopes[0]:.2f} (plain) and {slopes[1]:.2f} (default), by two threads.",
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
