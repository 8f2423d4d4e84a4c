"""Time spheremap.torch on a device against a copy; write a section of BENCHMARKS.md.

    python benches/device.py             # on a graphics card
    python benches/device.py --device cpu --quick    # a smoke test

A copy reads and writes the directions. Entrants of a row take turns.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import spheremap.torch as smt
import torch
from measure import Call, publish, race, table
from tensors import usual_cube, with_gradient

BEGIN, END = "<!-- device: written by benches/device.py -->", "<!-- device: end -->"
MAPS = (
    "sphere",
    "octahedral",
    "cube",
    "angular",
    "latlong",
    "equal_area",
    "mollweide",
    "healpix",
    "kannala_brandt",
    "camera_brown_conrady",
)


def ended(call: Call) -> Call:
    """Return a call that waits for the device, which works on after a function returns."""

    def run() -> object:
        result = call()
        if torch.cuda.is_available():
            torch.cuda.synchronize()
        return result

    return run


def maps(args: argparse.Namespace, directions: Any) -> list[list[str]]:
    rows = []
    for name in MAPS[:2] if args.quick else MAPS:
        verbs: dict[str, tuple[Callable[..., Any], Any]] = {
            "encode": (smt.encode, directions),
            "decode": (smt.decode, smt.encode(directions, name)),
        }
        for verb, (function, argument) in verbs.items():
            # Each map compiles anew, and torch gives up after eight of one function.
            torch.compiler.reset()
            compiled = torch.compile(function)
            seconds = race(
                {
                    "copy": ended(directions.clone),
                    "as it is": ended(lambda f=function, x=argument, n=name: f(x, n)),
                    "compiled": ended(lambda f=compiled, x=argument, n=name: f(x, n)),
                },
                args.rounds,
            )
            times = [f"{t * 1e3:.2f}" for t in seconds.values()]
            rows.append([name, verb, *times, f"{seconds['as it is'] / seconds['copy']:.0f}"])
    return rows


def images(args: argparse.Namespace) -> list[list[str]]:
    height = 32 if args.quick else 512
    side = height // 2
    batch = torch.rand(8, 3, height, 2 * height, device=args.device)
    learned = batch.clone().requires_grad_()
    directions = smt.directions("cube", side, device=args.device)
    hows: dict[str, Callable[[Any], Any]] = {
        "`torch.nn.functional.grid_sample`, without seams": lambda x: usual_cube(x, directions),
        "`spheremap.torch.sample`": lambda x: smt.sample(x, directions, "latlong"),
        "`spheremap.torch.convert`": lambda x: smt.convert(
            x, "latlong", "cube", size=side, antialias=False
        ),
    }
    entrants: dict[str, Call] = {}
    for how, verb in hows.items():
        entrants[how] = ended(lambda v=verb: v(batch))
        entrants[f"{how}, with the gradient"] = ended(with_gradient(verb, learned))
    seconds = race(entrants, args.rounds)
    return [[how, f"{t * 1e3:.2f}"] for how, t in seconds.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--device", default="cuda")
    parser.add_argument("--rounds", type=int, default=15)
    args = parser.parse_args()
    count = 10_000 if args.quick else 10_000_000
    directions = torch.randn(count, 3, generator=torch.Generator().manual_seed(0)).to(args.device)
    what = torch.cuda.get_device_name() if directions.is_cuda else args.device
    head = ["map", "verb", "copy, ms", "as it is, ms", "compiled, ms", "of a copy"]
    text = [
        BEGIN,
        "## On a graphics card",
        f"{what}; torch {torch.__version__}; {count:,} directions of f32, as it is and under "
        "`torch.compile`, medians of rounds in turn.",
        table(head, maps(args, directions), 2),
        "Eight latlong images of three channels to cubes, plain bilinear lookups:",
        table(["how", "ms"], images(args)),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
