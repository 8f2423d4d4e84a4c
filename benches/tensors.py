"""Time spheremap.torch against the verbs of arrays, and against what is usually written in torch.

    python benches/tensors.py            # rewrites its section of BENCHMARKS.md
    python benches/tensors.py --quick    # a smoke test: small arrays

Entrants of a row take turns; what is counted is CPU time of all threads, so that other programs do
not matter. The usual way is the formula in operations of torch and
`torch.nn.functional.grid_sample`, face by face, with what a seam needs left out. kornia has no
conversion, but `remap` by places, which are found once; equilib has one, into a strip.
"""

from __future__ import annotations

import os

# A thread of torch that has nothing to do would count as working.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import argparse
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import spheremap as sm
import spheremap.torch as smt
import torch
from measure import machine, publish, race, table

BEGIN = "<!-- tensors: written by benches/tensors.py -->"
END = "<!-- end of tensors -->"

Call = Callable[[], object]


def usual_encode(d: Any) -> Any:
    x, y, z = (d / torch.linalg.vector_norm(d, dim=-1, keepdim=True)).unbind(-1)
    u = torch.atan2(x, -z) / (2 * torch.pi) + 0.5
    return torch.stack([u, 0.5 - torch.asin(y) / torch.pi], dim=-1)


def usual_sample(image: Any, directions: Any) -> Any:
    grid = 2 * usual_encode(directions)[None, None] - 1
    return torch.nn.functional.grid_sample(
        image[None], grid, padding_mode="border", align_corners=False
    )


def usual_cube(image: Any, directions: Any) -> Any:
    grid = 2 * usual_encode(directions) - 1
    faces = [
        torch.nn.functional.grid_sample(
            image, face.expand(len(image), -1, -1, -1), padding_mode="border", align_corners=False
        )
        for face in grid
    ]
    return torch.stack(faces, dim=1)


def backward(result: Any, *inputs: Any) -> Call:
    gradient = torch.ones_like(result)
    return lambda: torch.autograd.grad(result, inputs, gradient, retain_graph=True)


def with_gradient(verb: Callable[[Any], Any], image: Any) -> Call:
    # What comes back to a result is there: it is not what is measured.
    gradient = torch.ones_like(verb(image))

    def run() -> object:
        return torch.autograd.grad(verb(image), image, gradient)

    return run


def cube(x: Any) -> Any:
    side = x.shape[-2] // 2
    return smt.convert(x, "latlong", "cube", size=side, antialias=False)


def others(batch: Any, toward: Any) -> dict[str, Callable[[Any], Any]]:
    """Return the conversions of other libraries that are installed."""
    found: dict[str, Callable[[Any], Any]] = {}
    height, width = batch.shape[-2:]
    if find_spec("kornia"):
        from kornia.geometry.transform import remap

        uv = usual_encode(toward)
        # Where texels' centers lie for it.
        places = [(face[..., 0] * width - 0.5, face[..., 1] * height - 0.5) for face in uv]
        maps = [[p.expand(len(batch), -1, -1) for p in pair] for pair in places]

        def kornia(x: Any) -> Any:
            options = {"padding_mode": "border", "align_corners": True}
            return torch.stack([remap(x, u, v, **options) for u, v in maps], dim=1)

        found["kornia, places known"] = kornia
    if find_spec("equilib"):
        from equilib import equi2cube

        level = [{"roll": 0.0, "pitch": 0.0, "yaw": 0.0}] * len(batch)
        # Its own clipping writes into what a gradient needs.
        found["equilib"] = lambda x: equi2cube(x, level, height // 2, "horizon", clip_output=False)
    return found


# What is measured in a process of its own: a name, what is prepared, and what is done.
PEAKS = {
    "sample, ours": "smt.sample(image, d, 'latlong')",
    "sample, usual": "bench.usual_sample(image, d)",
    "convert, ours": "bench.cube(batch)",
    "convert, usual": "bench.usual_cube(batch, toward)",
}


def peak(name: str) -> tuple[float, float]:
    """Return how many MB a call and its gradient take, and how many of them are results."""
    code = f"""
import gc, sys
sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})
import tensors as bench, torch, spheremap.torch as smt
def status(key):
    lines = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(key)) / 1024
d = torch.randn(1_000_000, 3)
image = torch.rand(3, 512, 1024).requires_grad_()
batch = torch.rand(8, 3, 512, 1024).requires_grad_()
toward = smt.directions("cube", 256)
weights = {{}}
def call():
    found = {PEAKS[name]}
    if not weights:
        weights["ones"] = torch.ones_like(found)
    leaf = image if "sample" in {name!r} else batch
    (back,) = torch.autograd.grad(found, leaf, weights["ones"])
    return found, back
call()
gc.collect()
open("/proc/self/clear_refs", "w").write("5")
before = status("VmRSS")
kept = call()
print(status("VmHWM") - before, sum(part.nbytes for part in kept) / 2**20)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    taken, results = map(float, done.stdout.split())
    return taken, results


def judged(ratio: float, goal: str | None) -> list[str]:
    """Return a ratio beside "at most 2" or "at least 2", and whether it is."""
    if goal is None:
        return [f"{ratio:.2f}", "", ""]
    bound = float(goal.split()[-1])
    is_met = ratio <= bound if "most" in goal else ratio >= bound
    return [f"{ratio:.2f}", goal, "yes" if is_met else "**no**"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=15)
    args = parser.parse_args()
    sm.set_num_threads(args.threads)
    torch.set_num_threads(args.threads)
    count, height = (10_000, 32) if args.quick else (1_000_000, 512)
    d = torch.randn(count, 3, generator=torch.Generator().manual_seed(0))
    wanted = d.clone().requires_grad_()
    image = torch.rand(3, height, 2 * height)
    learned = image.clone().requires_grad_()
    batch = torch.rand(8, 3, height, 2 * height)
    taught = batch.clone().requires_grad_()
    toward = smt.directions("cube", height // 2)

    def array_cube() -> object:
        options: dict[str, Any] = {"size": height // 2, "antialias": False}
        return sm.convert(batch.numpy(), "latlong", "cube", channels_first=True, **options)

    looked_up = (image.numpy(), d.numpy(), "latlong")
    rest = others(batch, toward)
    shape = tuple(batch.shape)
    # A race has the one that the others are measured by first, and which ratio is wanted of which.
    races: list[tuple[str, dict[str, Call], dict[str, str]]] = [
        (
            "encode, latlong",
            {
                "arrays": lambda: sm.encode(d.numpy(), "latlong"),
                "ours": lambda: smt.encode(d, "latlong"),
                "usual": lambda: usual_encode(d),
                "ours, gradient": backward(smt.encode(wanted, "latlong"), wanted),
                "usual, gradient": backward(usual_encode(wanted), wanted),
            },
            {"ours": "at most 1.15"},
        ),
        (
            "sample, latlong",
            {
                "arrays": lambda: sm.sample(*looked_up, channels_first=True),  # type: ignore[arg-type]
                "ours": lambda: smt.sample(image, d, "latlong"),
                "usual": lambda: usual_sample(image, d),
                "ours, gradient of the image": backward(smt.sample(learned, d, "latlong"), learned),
                "usual, gradient of the image": backward(usual_sample(learned, d), learned),
                "ours, gradient of directions": backward(
                    smt.sample(image, wanted, "latlong"), wanted
                ),
                "usual, gradient of directions": backward(usual_sample(image, wanted), wanted),
            },
            {"ours": "at most 1.15", "ours, gradient of the image": "at most 2.5"},
        ),
        (
            f"convert, latlong to cube, {shape}",
            {
                "arrays": array_cube,
                "ours": lambda: cube(batch),
                "usual": lambda: usual_cube(batch, toward),
            },
            {"ours": "at most 1.15"},
        ),
        (
            f"convert with the gradient, {shape}",
            {
                "ours": with_gradient(cube, taught),
                "usual": with_gradient(lambda x: usual_cube(x, toward), taught),
                **{name: with_gradient(verb, taught) for name, verb in rest.items()},
            },
            {"usual": "at least 4", **dict.fromkeys(rest, "at least 2")},
        ),
    ]
    body = []
    for work, entrants, goals in races:
        rounds = 4 if args.quick else args.rounds
        seconds = race(entrants, rounds, patience=1.0, clock=time.process_time)
        first = next(iter(seconds.values()))
        for name, t in seconds.items():
            body.append([work, name, f"{t * 1e3:.1f}", *judged(t / first, goals.get(name))])
    text = [
        BEGIN,
        "## Tensors",
        f"{args.threads} threads, {machine()}, torch {torch.__version__}, {count} directions of "
        f"f32, images of {height} rows; CPU time of all threads, of each line's first entrant, "
        "medians of rounds in turn, on a machine with other work. The usual way is the formula in "
        "operations of torch and "
        "`grid_sample`, without seams.",
        table(["work", "how", "CPU ms", "of the first", "goal", "met"], body, 2),
    ]
    if not args.quick:
        rows = []
        for name in PEAKS:
            taken, results = peak(name)
            rows.append([name, f"{results:.0f}", f"{taken:.0f}", f"{taken - results:.0f}"])
        text += [
            "Memory of a call with its gradient, beside its inputs, at the highest: a million "
            "lookups in an image of (3, 512, 1024), and (8, 3, 512, 1024) to cubes. Results are "
            "values and the gradient.",
            table(["work", "results, MB", "taken, MB", "beside results, MB"], rows, 1),
        ]
    publish([*text, END], args.quick)


if __name__ == "__main__":
    main()
