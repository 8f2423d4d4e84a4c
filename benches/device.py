"""Time spheremap.torch on a device against a copy; write a section of BENCHMARKS.md.

    python benches/device.py             # on a graphics card
    python benches/device.py --device cpu --quick    # a smoke test

A copy reads and writes the directions. Entrants of a row take turns.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import spheremap as sm
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
            entrants: dict[str, Call] = {
                "copy": ended(directions.clone),
                "as it is": ended(lambda f=function, x=argument, n=name: f(x, n)),
                "compiled": ended(lambda f=compiled, x=argument, n=name: f(x, n)),
            }
            if directions.is_cuda:
                printed = kernel(name, verb)
                entrants["CUDA"] = ended(lambda f=printed, x=argument: f(x))
            seconds = race(entrants, args.rounds)
            copy, *others = seconds.values()
            rows.append([name, verb, f"{copy * 1e3:.2f}"])
            for t in others:
                rows[-1] += [f"{t * 1e3:.2f}", f"{t / copy:.1f}"]
    return rows


# One thread for each place; `{0}` numbers go in and `{1}` come out.
KERNEL = """
extern "C" __global__ void run(const float* given, float* made, long long count) {{
    long long k = blockIdx.x * (long long)blockDim.x + threadIdx.x;
    if (k >= count) return;
    const float* at = given + {0} * k;
    float{1} found = m_{2}(make_float{0}({3}));
    {4}
}}
"""


def kernel(name: str, verb: str) -> Callable[[Any], Any]:
    """Return a verb of a map as the CUDA C++ that is printed, which keeps the library's bits."""
    import cupy

    width = 3 if sm.projection(name).layout == "faces" else 2
    taken, given = (3, width) if verb == "encode" else (width, 3)
    numbers = ", ".join(f"at[{k}]" for k in range(taken))
    axes = "xyz"[:given]
    results = " ".join(f"made[{given} * k + {k}] = found.{axis};" for k, axis in enumerate(axes))
    text = sm.code(name, "cuda", verbs=(verb,), name="m")
    text += KERNEL.format(taken, given, verb, numbers, results)
    compiled = cupy.RawModule(code=text, options=("-std=c++14", "-fmad=false")).get_function("run")

    def call(data: Any) -> Any:
        made = torch.empty((len(data), given), device=data.device)
        arguments = (cupy.asarray(data), cupy.asarray(made), len(data))
        # cupy has a stream of its own, torch the usual one.
        with cupy.cuda.Stream.from_external(torch.cuda.current_stream()):
            compiled((-(-len(data) // 256),), (256,), arguments)
        return made

    return call


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
    torch.compiler.reset()
    entrants: dict[str, Call] = {}
    kinds = ("forward", "gradient", "forward, compiled", "gradient, compiled")
    for how, verb in hows.items():
        runs = (verb, verb, *(2 * [torch.compile(verb)]))
        for kind, run in zip(kinds, runs, strict=True):
            call = with_gradient(run, learned) if "gradient" in kind else lambda v=run: v(batch)
            entrants[f"{how} {kind}"] = ended(call)
    seconds = race(entrants, args.rounds)
    return [[how, *(f"{seconds[f'{how} {kind}'] * 1e3:.2f}" for kind in kinds)] for how in hows]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--device", default="cuda")
    parser.add_argument("--rounds", type=int, default=15)
    args = parser.parse_args()
    count = 10_000 if args.quick else 50_000_000
    directions = torch.randn(count, 3, generator=torch.Generator().manual_seed(0))
    directions = torch.nn.functional.normalize(directions).to(args.device)
    what = torch.cuda.get_device_name() if directions.is_cuda else args.device
    head = ["map", "verb", "copy, ms"]
    for how in ("as it is", "compiled", *(("CUDA",) if directions.is_cuda else ())):
        head += [f"{how}, ms", "of a copy"]
    text = [
        BEGIN,
        "## On a graphics card",
        f"{what}; torch {torch.__version__}; {count:,} directions of f32, as it is, under "
        "`torch.compile`, and by the CUDA C++ that `sm.code` prints; medians of rounds in turn.",
        table(head, maps(args, directions), 2),
        "Eight latlong images of three channels to cubes, plain bilinear lookups:",
        table(["how", "ms", "with the gradient", "compiled", "with the gradient"], images(args)),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
