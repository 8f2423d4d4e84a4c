"""Time `filter="area"` against a plain bilinear conversion; write its part of BENCHMARKS.md.

python benches/areas.py            # rewrites the section
python benches/areas.py --quick    # a smoke test: small images, printed only
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
import spheremap as sm
from measure import Call, machine, publish, race, table

BEGIN, END = "<!-- areas: written by benches/areas.py -->", "<!-- areas: end -->"
# Maps, sizes of source and target, and how many plain conversions an area may take.
WORKS = [
    ("latlong", 1024, "latlong", 500, 3.0),
    ("latlong", 256, "latlong", 128, 3.0),
    ("latlong", 1024, "lambert_cylindrical", 1024, 3.0),
    ("latlong", 1024, "mercator", 1024, 3.0),
    ("mercator", 1024, "latlong", 512, 3.0),
    ("latlong", 1024, "cube", 590, 12.0),
    ("cube", 590, "latlong", 1024, 12.0),
    ("latlong", 1024, "octahedral", 1024, 12.0),
    ("latlong", 1024, "angular", 1024, 12.0),
    ("latlong", 256, "cube", 128, 12.0),
    ("cube", 128, "latlong", 256, 12.0),
    ("latlong", 256, "octahedral", 256, 12.0),
    ("latlong", 64, "cube", 32, 12.0),
    ("octahedral", 32, "latlong", 16, 12.0),
    ("cube", 512, "cube", 128, 12.0),
    ("octahedral", 1024, "octahedral", 300, 12.0),
    ("angular", 1024, "angular", 256, 12.0),
]


def entrants(src: str, rows: int, dst: str, size: int) -> tuple[dict[str, Call], int]:
    """Return both calls on noise, and how many texels they make."""
    image = np.random.default_rng(1).random((*sm.projection(src).shape(rows), 3), dtype=np.float32)

    def convert(**options: str | bool) -> Call:
        return lambda: sm.convert(image, src, dst, size=size, **options)

    calls = {"area": convert(filter="area"), "plain": convert(antialias=False)}
    return calls, math.prod(sm.projection(dst).shape(size))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small images")
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    body = []
    for src, rows, dst, size, most in WORKS:
        part = 8 if args.quick else 1
        calls, texels = entrants(src, rows // part, dst, size // part)
        took = race(calls, 3 if args.quick else 9, clock=time.process_time)
        ratio = took["area"] / took["plain"]
        numbers = [f"{took[name] / texels * 1e9:.3g}" for name in ("area", "plain")]
        reached = "yes" if ratio <= most else "**no**"
        work = [f"{src} {rows}", f"{dst} {size}"]
        body.append([*work, *numbers, f"{ratio:.3g}", f"{most:g}", reached])
    text = [
        BEGIN,
        "## Areas",
        'Nanoseconds of CPU a texel of the target, three numbers of float32: `filter="area"` and a '
        "plain bilinear conversion. Rows of both maps are parallels in the first five. "
        f"{machine()}{args.remark and ', ' + args.remark}.",
        table(["source", "target", "area", "plain", "ratio", "at most", "reached"], body, left=2),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
