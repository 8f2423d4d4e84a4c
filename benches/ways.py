"""Time every way that a conversion can go, so that none is slow unseen; write it to BENCHMARKS.md.

    python benches/ways.py            # rewrites the section
    python benches/ways.py --quick    # a smoke test: small images, printed only

A way is a dtype, a filter, with or without antialiasing, turned or not, and how faces of a cube lie
in the image. Each takes turns with the plainest one, and what counts is the ratio of CPU times.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Iterator

import numpy as np
import spheremap as sm
from measure import Call, machine, publish, race, say, table
from spheremap import _core

BEGIN, END = "<!-- ways: written by benches/ways.py -->", "<!-- ways: end -->"
DTYPES = ("uint8", "uint16", "float16", "float32", "float64")
# Faces by themselves; rows of faces as rows of one image; and one of whose faces is upside down.
LAYOUTS = ("faces", "cross", "vertical_cross")


def ways() -> Iterator[tuple[str, bool, bool]]:
    """Return filters, whether they antialias, and whether the content is turned."""
    for info in _core.filters():
        for antialias in (False, True) if info["antialiased"] else (False,):
            for turned in (False, True):
                yield info["name"], antialias, turned


class Conversions:
    """From a cube to a latlong, or from there to a cube, of a dtype and a layout."""

    def __init__(self, side: int, *, to_cube: bool) -> None:
        self.side, self.to_cube = side, to_cube
        rng = np.random.default_rng(0)
        self.images = {
            (layout, dtype): (
                200 * rng.random((*self.ends(layout)[0].shape(self.size()[0]), 3), np.float32)
            ).astype(dtype)
            for layout in LAYOUTS
            for dtype in DTYPES
        }

    def size(self) -> tuple[int, int]:
        """Return the sides of source and target: about one to two source texels for one."""
        return (2 * self.side, self.side // 2) if self.to_cube else (self.side, self.side)

    def ends(self, layout: str) -> tuple[sm.Projection, sm.Projection]:
        cube, latlong = sm.projection("cube", layout=layout), sm.projection("latlong")
        return (latlong, cube) if self.to_cube else (cube, latlong)

    def call(
        self, layout: str, dtype: str, filter: str, antialias: bool = False, turned: bool = False
    ) -> Call:
        image = self.images[layout, dtype]
        rotation = sm.rotation(25, 35, 15) if turned else None
        options = {"filter": filter, "antialias": antialias, "rotation": rotation}
        return lambda: sm.convert(image, *self.ends(layout), size=self.size()[1], **options)


def ratio(
    of: Conversions, way: tuple[str, bool, bool], layout: str, dtype: str, rounds: int
) -> str:
    """Return how long a way takes, as a multiple of the plainest one."""
    entrants = {
        "way": of.call(layout, dtype, *way),
        "plain": of.call("faces", "float32", "bilinear"),
    }
    seconds = race(entrants, rounds, clock=time.process_time)
    value = seconds["way"] / seconds["plain"]
    return f"{value:.1f}" if value < 10 else f"{value:.0f}"


def rows(of: Conversions, rounds: int) -> list[list[str]]:
    body = []
    for way in ways():
        filter, antialias, turned = way
        say(f"{filter}, antialias={antialias}, turned={turned}")
        words = [filter, "yes" if antialias else "no", "yes" if turned else "no"]
        kinds = itertools.product(LAYOUTS, DTYPES)
        body.append(words + [ratio(of, way, layout, dtype, rounds) for layout, dtype in kinds])
    return body


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small images")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    side = 32 if args.quick else 256
    rounds = 1 if args.quick else args.rounds
    remark = args.remark and f", {args.remark}"
    head = ["filter", "antialiased", "turned"]
    head += [f"{layout.replace('_', ' ')}, {dtype}" for layout in LAYOUTS for dtype in DTYPES]
    text = [
        BEGIN,
        "## Every way of a conversion",
        "CPU time of all threads, as a multiple of that of the plainest way in the same run: "
        "float32, bilinear, `antialias=False`, faces by themselves, not turned. Three numbers a "
        "texel; the layout is that of the cube, where in a vertical cross one face is upside down; "
        f"medians of {rounds} rounds in turn; {machine()}{remark}.",
    ]
    for to_cube in (False, True):
        of = Conversions(side, to_cube=to_cube)
        given, made = of.size()
        faces, latlong = "cube of 6×{}²", "latlong of {} rows"
        source, target = (latlong, faces) if to_cube else (faces, latlong)
        text.append(f"From a {source.format(given)} to a {target.format(made)}:")
        text.append(table(head, rows(of, rounds), 3))
    publish([*text, END], args.quick)


if __name__ == "__main__":
    main()
