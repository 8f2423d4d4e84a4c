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
# Of about as many texels: faces, creases, rims, and lenses without a closed form.
OTHERS = ("cube", "octahedral", "angular", "kannala_brandt", "camera_brown_conrady(k1=-0.1)")


def works(image: np.ndarray, projection: str) -> dict[str, Call]:
    """Return the calls that pass once over an image of any projection."""
    return {
        "light.integrate": lambda: sm.light.integrate(image, projection),
        "light.mean": lambda: sm.light.mean(image, projection),
        "light.energy": lambda: sm.light.energy(image, projection),
        "mipmaps": lambda: sm.mipmaps(image, projection),
        "pad, 16 texels": lambda: sm.pad(image, projection, 16),
        "light.Distribution": lambda: sm.light.Distribution(image, projection),
        "light.sun": lambda: sm.light.sun(image, projection),
        "light.lights, 64": lambda: sm.light.lights(image, projection, count=64),
    }


def entrants(rows: int) -> dict[str, Call]:
    """Return calls on a sky of noise with a sun in it."""
    rng = np.random.default_rng(1)
    image = rng.random((rows, 2 * rows, 3), dtype=np.float32)
    image[rows // 4, rows // 3] = 3e4

    def to_cube(**options: str | bool) -> Call:
        return lambda: sm.convert(image, "latlong", "cube", size=rows // 8, **options)

    return {
        "a copy": image.copy,
        **works(image, "latlong"),
        "plain": to_cube(antialias=False),
        **{name: to_cube(filter=name) for name in CHAINED},
    }


def of_others(rows: int, rounds: int) -> str:
    """Return the table of what passes over images of other projections."""
    body = []
    for projection in OTHERS:
        side = 4 * round((2 / sm.projection(projection).faces) ** 0.5 * rows / 4)
        shape = sm.projection(projection).shape(side)
        image = np.random.default_rng(2).random((*shape, 3), dtype=np.float32)
        image[(0,) * (len(shape) - 2) + (side // 3, side // 2)] = 3e4
        seconds = race({"a copy": image.copy, **works(image, projection)}, rounds)
        copy = seconds.pop("a copy")
        size = "×".join(map(str, shape))
        body.append([f"`{projection}` {size}", *(f"{s / copy:.1f}" for s in seconds.values())])
    return table(["image", *works(image, projection)], body)


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
        "Copies that the same takes of images of other maps, of about as many texels:",
        of_others(rows, 3 if args.quick else 7),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
