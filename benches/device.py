"""Time spheremap.torch on a device, the printed code as it is and compiled, against a copy there.

    python benches/device.py             # on the first graphics card
    python benches/device.py --device cpu --quick    # a smoke test

A copy reads and writes the directions. Entrants of a row take turns.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import spheremap.torch as smt
import torch
from measure import race, table

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
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--device", default="cuda")
    parser.add_argument("--rounds", type=int, default=15)
    args = parser.parse_args()
    device = torch.device(args.device)
    count = 10_000 if args.quick else 10_000_000
    directions = torch.randn(count, 3, generator=torch.Generator().manual_seed(0)).to(device)

    def ended(call: Callable[[], Any]) -> Callable[[], object]:
        def run() -> object:
            result = call()
            if device.type != "cpu":
                torch.accelerator.synchronize()
            return result

        return run

    body = []
    # Each map compiles anew, and torch gives up after eight of one function.
    for name in MAPS[:2] if args.quick else MAPS:
        verbs: dict[str, tuple[Callable[..., Any], Any]] = {
            "encode": (smt.encode, directions),
            "decode": (smt.decode, smt.encode(directions, name)),
        }
        for verb, (function, argument) in verbs.items():
            torch.compiler.reset()
            compiled = torch.compile(function)
            seconds = race(
                {
                    "copy": ended(directions.clone),
                    "printed": ended(lambda f=function, x=argument, n=name: f(x, n)),
                    "compiled": ended(lambda f=compiled, x=argument, n=name: f(x, n)),
                },
                args.rounds,
            )
            copy = seconds["copy"]
            times = [f"{t * 1e3:.2f}" for t in seconds.values()]
            body.append([name, verb, *times, f"{seconds['printed'] / copy:.0f}"])
    what = torch.cuda.get_device_name(device) if device.type == "cuda" else str(device)
    print(f"{what}, torch {torch.__version__}, {count} directions.\n")
    head = ["map", "verb", "copy, ms", "printed, ms", "compiled, ms", "of a copy"]
    print(table(head, body, 2))


if __name__ == "__main__":
    main()
