"""Time importance sampling and lights against mitsuba; write a section of BENCHMARKS.md.

    python benches/light_distribution.py            # rewrites its section of BENCHMARKS.md
    python benches/light_distribution.py --quick    # a smoke test: small arrays, printed only

Entrants take turns, as in map.py, and all numbers of a row come from one run.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import spheremap as sm
from measure import publish, race, say, table

BEGIN, END = "<!-- distribution: benches/light_distribution.py -->", "<!-- end of distribution -->"
SIZES = (512, 2048)
TARGET = 2.0


def environment(n: int) -> np.ndarray:
    """A sky with a sun: a dynamic range of 10⁵."""
    rng = np.random.default_rng(1)
    image = rng.random((n, 2 * n, 3), np.float32) + np.float32(0.1)
    image[n // 4, n // 2] = 1e5
    return image


def mitsuba_calls(image: np.ndarray, xi: np.ndarray, d: np.ndarray) -> dict[str, Callable]:
    """Return sampling and density lookups of mitsuba's llvm variant, from numpy to numpy."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(image)})
    si = dr.zeros(mi.SurfaceInteraction3f)

    def sample() -> object:
        pair = dr.unravel(mi.Point2f, mi.Float(xi.reshape(-1)))
        ds, weight = emitter.sample_direction(si, pair)
        dr.eval(ds.d, ds.pdf, weight)
        return dr.ravel(ds.d).numpy(), ds.pdf.numpy(), dr.ravel(weight).numpy()

    def pdf() -> object:
        ds = dr.zeros(mi.DirectionSample3f)
        ds.d = dr.unravel(mi.Vector3f, mi.Float(d.reshape(-1)))
        return emitter.pdf_direction(si, ds).numpy()

    return {"sample": sample, "pdf": pdf}


def mitsuba_runs() -> bool:
    """Tell whether the llvm variant works here, in a process that may end without a word."""
    command = [sys.executable, __file__, "--try-mitsuba"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def bench(args: argparse.Namespace) -> list[str]:
    count = 100_000 if args.quick else 8_000_000
    rng = np.random.default_rng(2)
    xi = rng.random((count, 2), np.float32)
    d = rng.standard_normal((count, 3), np.float32)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    theirs = mitsuba_runs()
    body = []
    for n in (16, 32) if args.quick else SIZES:
        say(f"{2 * n}×{n}")
        image = environment(n)
        dist = sm.light.Distribution(image, "latlong:mitsuba")
        drawn = dist.sample(xi, weights=True)
        density = dist.pdf(d)
        entrants: dict[str, Callable[[], object]] = {
            "sample out": lambda dist=dist, o=drawn: dist.sample(xi, weights=True, out=o),
            "sample": lambda dist=dist: dist.sample(xi, weights=True),
            "pdf out": lambda dist=dist, o=density: dist.pdf(d, out=o),
            "pdf": lambda dist=dist: dist.pdf(d),
        }
        if theirs:
            calls = mitsuba_calls(image, xi, d)
            entrants |= {f"mitsuba {name}": call for name, call in calls.items()}
        seconds = race(entrants, args.rounds, patience=9)
        rate = {name: count / s / 1e6 for name, s in seconds.items()}
        for work, name in (("direction, pdf and weight", "sample"), ("pdf", "pdf")):
            peer = rate.get(f"mitsuba {name}")
            ratio = rate[name] / peer if peer else None
            reached = "" if ratio is None or name == "pdf" else "**no**"
            if ratio is not None and name == "sample" and ratio >= TARGET:
                reached = "yes"
            body.append(
                [
                    f"{work}, latlong {2 * n}×{n}×3 f32",
                    f"{rate[name]:,.1f}",
                    f"{rate[f'{name} out']:,.1f}",
                    "–" if peer is None else f"{peer:,.1f}",
                    "–" if ratio is None else f"{ratio:.1f}×",
                    f"{TARGET:g}" if name == "sample" else "",
                    reached,
                ]
            )
    head = ["work", "ours", "ours, `out=`", "mitsuba llvm", "ours to it", "target", "reached"]
    text = [
        "## Importance sampling",
        f"Millions a second from numpy to numpy, {args.threads} threads, {count:,} float32 samples "
        "a call. The ratio is to ours without `out=`.",
        table(head, body),
    ]
    if not theirs:
        text.append("mitsuba's llvm variant found no LLVM library (`DRJIT_LIBLLVM_PATH`).")
    return text + bench_others(args, xi[: count // 8])


def bench_others(args: argparse.Namespace, xi: np.ndarray) -> list[str]:
    """Other projections, the tables, lights."""
    size = 32 if args.quick else 512
    body = []
    for name in sm.projections():
        say(name)
        p = sm.projection(name)
        n = max(1, size)
        image = np.random.default_rng(3).random((*p.shape(n), 3), np.float32) + np.float32(0.1)
        dist = sm.light.Distribution(image, p)
        drawn = dist.sample(xi, weights=True)
        seconds = race(
            {
                "sample": lambda dist=dist, o=drawn: dist.sample(xi, weights=True, out=o),
                "build": lambda image=image, p=p: sm.light.Distribution(image, p),
                "lights": lambda image=image, p=p: sm.light.lights(image, p, count=64),
                "energy": lambda image=image, p=p: sm.light.energy(image, p),
            },
            3,
            patience=9,
        )
        body.append(
            [
                f"{name} {'×'.join(map(str, p.shape(n)))}",
                f"{len(xi) / seconds['sample'] / 1e6:,.1f}",
                *(f"{seconds[k] * 1e3:,.0f}" for k in ("build", "lights", "energy")),
            ]
        )
    head = ["image", "samples, M/s, `out=`", "the distribution, ms", "64 lights, ms", "energy, ms"]
    return [
        "Every projection, direction, pdf and weight, and what else is made of an image:",
        table(head, body),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--try-mitsuba", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.try_mitsuba:
        xi = np.full((8, 2), 0.5, np.float32)
        for call in mitsuba_calls(environment(4), xi, np.eye(3, dtype=np.float32)).values():
            call()
        return
    sm.set_num_threads(args.threads)
    publish([BEGIN, *bench(args), END], args.quick)


if __name__ == "__main__":
    main()
