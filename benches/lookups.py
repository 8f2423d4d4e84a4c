"""Time lookups at a level of a mip chain beside bilinear ones; write their part of BENCHMARKS.md.

python benches/lookups.py            # rewrites the section
python benches/lookups.py --quick    # a smoke test: a small image, printed only
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import spheremap as sm
from measure import Call, machine, publish, race, table

BEGIN, END = "<!-- lookups: written by benches/lookups.py -->", "<!-- lookups: end -->"
ORDERS = ("of a picture", "without order")


def entrants(rows: int, columns: int) -> dict[str, Call]:
    """Return lookups of an image's levels, in a picture's order and in none."""
    rng = np.random.default_rng(1)
    image = rng.random((rows, 2 * rows, 3), dtype=np.float32)
    levels = sm.mipmaps(image, "latlong")
    picture = sm.directions("perspective", (columns, columns), dtype=np.float32)
    # As a picture of a third of the columns would have them: of some texels each.
    steps = [3 * np.gradient(picture, axis=axis).reshape(-1, 3) for axis in (1, 0)]
    random = rng.normal(size=(columns**2, 3)).astype(np.float32)
    random /= np.linalg.norm(random, axis=-1, keepdims=True)
    spots = rng.uniform(0.5, 8, (2, columns**2, 1)) * np.pi / rows
    ways = (spots * rng.normal(size=(2, *random.shape))).astype(np.float32)
    lods = rng.uniform(0, 4, columns**2).astype(np.float32)
    given = (picture.reshape(-1, 3), steps, np.full_like(lods, 1.5)), (random, ways, lods)

    def look(where: object, d: np.ndarray, **options: object) -> Call:
        return lambda: sm.sample(where, d, "latlong", **options)

    calls: dict[str, Call] = {}
    for order, (d, derivatives, lod) in zip(ORDERS, given, strict=True):
        calls[f"bilinear, {order}"] = look(image, d)
        calls[f"lod, {order}"] = look(levels, d, lod=lod)
        for name in ("trilinear", "ewa"):
            told = look(levels, d, derivatives=derivatives, filter=name)
            calls[f"derivatives, {name}, {order}"] = told
    return calls


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with a small image")
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    rows, columns = (64, 64) if args.quick else (1024, 700)
    calls = entrants(rows, columns)
    seconds = race(calls, 2 if args.quick else 7, 2.0, time.process_time)
    names = [name.removesuffix(f", {ORDERS[0]}") for name in calls if name.endswith(ORDERS[0])]
    body = []
    for name in names:
        row = [name]
        for order in ORDERS:
            took, plain = seconds[f"{name}, {order}"], seconds[f"bilinear, {order}"]
            row += [f"{took / columns**2 * 1e9:.0f}", f"{took / plain:.1f}"]
        body.append(row)
    text = [
        BEGIN,
        "## Lookups at a level",
        f"`sample` of a latlong of {2 * rows}×{rows}×3 float32 and its `mipmaps`, which are made "
        f"before, in {columns}² directions: nanoseconds of CPU a lookup, and how many bilinear "
        "lookups that is. A pixel of the picture is some two texels wide, or sees level 1.5; those "
        "without order are one to twenty wide, or see a level between 0 and 4. Medians of 7 rounds "
        "in turn. "
        f"{machine()}{args.remark and ', ' + args.remark}.",
        table(["", *(head for order in ORDERS for head in (order, "ratio"))], body),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
