"""Time what goes over an image once against a copy of it; write its part of BENCHMARKS.md.

python benches/passes.py            # rewrites the section
python benches/passes.py --quick    # a smoke test: a small image, printed only
"""

from __future__ import annotations

import argparse

import numpy as np
import spheremap as sm
from measure import Call, machine, publish, race, table

BEGIN, END = "<!-- passes: written by benches/passes.py -->", "<!-- passes: end -->"
# How many copies each may take; a chain's lookups, the chain and a plain conversion.
MOST = {
    "light.integrate": 3.0,
    "light.mean": 3.0,
    "light.energy": 6.0,
    "mipmaps": 6.0,
    "pad, 16 texels": 3.0,
    "light.Distribution": 15.0,
    "light.sun": 40.0,
    "light.lights, 64": 40.0,
}
CHAINED = ("trilinear", "ewa")


def entrants(rows: int) -> dict[str, Call]:
    """Return calls on a sky of noise with a sun in it."""
    rng = np.random.default_rng(1)
    image = rng.random((rows, 2 * rows, 3), dtype=np.float32)
    image[rows // 4, rows // 3] = 3e4

    def to_cube(**options: str | bool) -> Call:
        return lambda: sm.convert(image, "latlong", "cube", size=rows // 8, **options)

    return {
        "a copy": image.copy,
        "light.integrate": lambda: sm.light.integrate(image, "latlong"),
        "light.mean": lambda: sm.light.mean(image, "latlong"),
        "light.energy": lambda: sm.light.energy(image, "latlong"),
        "mipmaps": lambda: sm.mipmaps(image, "latlong"),
        "pad, 16 texels": lambda: sm.pad(image, "latlong", 16),
        "light.Distribution": lambda: sm.light.Distribution(image, "latlong"),
        "light.sun": lambda: sm.light.sun(image, "latlong"),
        "light.lights, 64": lambda: sm.light.lights(image, "latlong", count=64),
        "plain": to_cube(antialias=False),
        **{name: to_cube(filter=name) for name in CHAINED},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with a small image")
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    rows = 128 if args.quick else 1024
    seconds = race(entrants(rows), 3 if args.quick else 25)
    copy, plain = seconds["a copy"], seconds["plain"]
    goals = {name: most * copy for name, most in MOST.items()}
    goals |= dict.fromkeys(CHAINED, seconds["mipmaps"] + plain)
    body = []
    for name, goal in goals.items():
        took = seconds[name]
        numbers = [f"{took * 1e3:.1f}", f"{took / copy:.1f}", f"{goal / copy:.1f}"]
        body.append([name, *numbers, "yes" if took <= goal else "**no**"])
    text = [
        BEGIN,
        "## Once over an image",
        f"A latlong of {2 * rows}×{rows}×3 float32: milliseconds by the clock with "
        f"{sm.get_num_threads()} threads, and how many copies of the image by `image.copy()` "
        f"({copy * 1e3:.2f} ms, one thread) that is. `trilinear` and `ewa` are `convert` to a cube "
        f"of {rows // 8}², and may take what `mipmaps` and a plain conversion "
        f"({plain * 1e3:.1f} ms) take. {machine()}{args.remark and ', ' + args.remark}.",
        table(["work", "ms", "copies", "at most", "reached"], body),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
