"""Time spheremap.torch against the verbs of arrays, and against what is usually written in torch.

    python benches/tensors.py            # prints the tables
    python benches/tensors.py --quick    # a smoke test: small arrays

Entrants of a row take turns. The usual way is the formula in operations of torch and
`torch.nn.functional.grid_sample`, face by face, with what a seam needs left out.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from typing import Any

import spheremap as sm
import spheremap.torch as smt
import torch
from measure import machine, race, table

Call = Callable[[], object]


def usual_encode(d: Any) -> Any:
    x, y, z = (d / torch.linalg.vector_norm(d, dim=-1, keepdim=True)).unbind(-1)
    u = torch.atan2(x, -z) / (2 * torch.pi) + 0.5
    return torch.stack([u, 0.5 - torch.asin(y) / torch.pi], dim=-1)


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
    def run() -> object:
        result = verb(image)
        return torch.autograd.grad(result, image, torch.ones_like(result))

    return run


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
    turned = smt.sample(image, wanted, "latlong")
    batch = torch.rand(8, 3, height, 2 * height)
    taught = batch.clone().requires_grad_()
    side = height // 2
    toward = smt.directions("cube", side)
    plain: dict[str, Any] = {"size": side, "antialias": False}

    def cube(x: Any) -> Any:
        return smt.convert(x, "latlong", "cube", **plain)

    def array_cube() -> object:
        return sm.convert(batch.numpy(), "latlong", "cube", channels_first=True, **plain)

    looked_up = (image.numpy(), d.numpy(), "latlong")
    races: list[tuple[str, dict[str, Call]]] = [
        (
            "encode, latlong",
            {
                "arrays": lambda: sm.encode(d.numpy(), "latlong"),
                "ours": lambda: smt.encode(d, "latlong"),
                "usual": lambda: usual_encode(d),
                "ours, gradient": backward(smt.encode(wanted, "latlong"), wanted),
                "usual, gradient": backward(usual_encode(wanted), wanted),
            },
        ),
        (
            "sample, latlong",
            {
                "arrays": lambda: sm.sample(*looked_up, channels_first=True),  # type: ignore[arg-type]
                "ours": lambda: smt.sample(image, d, "latlong"),
                "ours, gradient of the image": backward(smt.sample(learned, d, "latlong"), learned),
                "ours, gradient of directions": backward(turned, wanted),
            },
        ),
        (
            f"convert, latlong to cube, {tuple(batch.shape)}",
            {
                "arrays": array_cube,
                "ours": lambda: cube(batch),
                "usual": lambda: usual_cube(batch, toward),
                "ours, with the gradient": with_gradient(cube, taught),
                "usual, with the gradient": with_gradient(lambda x: usual_cube(x, toward), taught),
            },
        ),
    ]
    body = []
    for work, entrants in races:
        seconds = race(entrants, 4 if args.quick else args.rounds, patience=1.0)
        first = seconds["arrays"]
        body += [[work, name, f"{t * 1e3:.1f}", f"{t / first:.2f}"] for name, t in seconds.items()]
    print(f"{args.threads} threads, {machine()}, torch {torch.__version__}, {count} directions.\n")
    print(table(["work", "how", "ms", "of arrays"], body, 2))


if __name__ == "__main__":
    main()
