"""Time spheremap against a memcpy, a C loop and other libraries; write BENCHMARKS.md.

    python benches/map.py                      # everything; rewrites BENCHMARKS.md
    python benches/map.py --only octahedral    # one projection, printed only
    python benches/map.py --quick              # a smoke test: small arrays, printed only

All entrants of a row take turns (A B C A B C ...), and what counts is the ratio of their medians,
so a machine that is slow for a while is slow for all of them.
"""

from __future__ import annotations

import argparse
import datetime
import importlib.metadata
import os
import platform
from pathlib import Path

import map_peers as peers
import numpy as np
import spheremap as sm
from measure import ROOT, Call, Yardsticks, at_level, machine, race, say, table, verdict
from spheremap import _core

COUNT = {"f32": 10_000_000, "f64": 5_000_000}
DTYPE = {"f32": np.float32, "f64": np.float64}
# Maps with an arctangent or a sine; the others are algebraic.
TRANSCENDENTAL = {"angular", "latlong", "cylindrical"}
TARGET_FRESH = 0.9
PEERS = ("drjit", "numba", "numpy")  # each into memory of its own
POOL = "drjit pool"  # DrJit again, a view of memory that it keeps for the next call


def target(name: str, kind: str, level: str) -> float | None:
    """Return the ratio to memcpy that a kernel should reach with `out=`."""
    hard = name in TRANSCENDENTAL
    return {
        ("f32", "avx512"): 0.9 if hard else 1.0,
        ("f32", "avx2"): 0.8 if hard else 0.85,
        ("f64", "avx512"): 0.85 if hard else 0.9,
    }.get((kind, level))


# --- maps


def inputs(projection: sm.Projection, directions: np.ndarray, way: str) -> np.ndarray:
    """Return directions that the projection covers, or their image coordinates."""
    d = np.where(projection.covers(directions)[:, None], directions, -directions)
    return d if way == "encode" else projection.encode(d)


def bench_maps(args: argparse.Namespace, yard: Yardsticks) -> list[dict]:
    rng = np.random.default_rng(0)
    levels = _core.simd_levels()[::-1]
    others: dict[str, dict] = {"numpy": peers.numpy_peers()}
    try:
        others["numba"] = peers.numba_peers(args.threads)
    except ImportError as reason:
        args.notes.append(f"numba was left out: {reason}.")
    able = peers.drjit_maps(args.threads)
    if able:
        kernels = peers.drjit_peers(args.threads)
        others["drjit"] = {key: kernels[key] for key in kernels if key[0] in able}
    if missing := [m for m in peers.MAPS if m not in able]:
        args.notes.append(
            f"DrJit was left out for {', '.join(missing)}: no LLVM library that can run "
            "it was found (`DRJIT_LIBLLVM_PATH` names one)."
        )

    rows: list[dict] = []
    for kind, full in COUNT.items():
        count = min(full, args.count or full)
        directions = rng.standard_normal((count, 3), DTYPE[kind])
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        for name in args.maps:
            p = sm.projection(name)
            for way in ("encode", "decode"):
                say(f"{name} {kind} {way}")
                a = inputs(p, directions, way)
                function = getattr(p, way)
                out = function(a)
                columns = out.shape[1]
                entrants: dict[str, Call | None] = {"copy": yard.copy(a.nbytes + out.nbytes)}
                for level in levels:
                    entrants[level] = at_level(level, lambda f=function, a=a, o=out: f(a, out=o))
                loop_out = np.ones_like(out)
                entrants["loop"] = yard.loop(a, loop_out, columns)
                entrants["loop fresh"] = yard.loop(a, None, columns)
                entrants["fresh"] = at_level(None, lambda f=function, a=a: f(a))
                if kind == "f32" and name in peers.MAPS:
                    for peer, table in others.items():
                        if (name, way) in table:
                            check_peer(peer, name, way, table[name, way], function, a[:10_000])
                            call = lambda f=table[name, way], a=a: f(a)  # noqa: E731
                            if peer == "drjit":
                                entrants[POOL] = call
                                call = lambda view=call: view().copy()  # noqa: E731
                            entrants[peer] = call
                seconds = race({k: c for k, c in entrants.items() if c is not None}, args.rounds)
                _core.set_simd_level(None)
                about = {"map": name, "kind": kind, "way": way, "count": count, "seconds": seconds}
                rows.append(about)
    return rows


def check_peer(
    peer: str, name: str, way: str, theirs: peers.Peer, ours: Call, a: np.ndarray
) -> None:
    """Stop where a peer does other work than we do."""
    x, y = theirs(a), ours(a)
    away = np.abs(x - y)
    if way == "encode" and name == "latlong":  # u = 0 and u = 1 are the same meridian
        away[..., 0] = np.minimum(away[..., 0], 1 - away[..., 0])
    worst = np.quantile(away, 0.999)
    if not worst < 1e-4 or x.dtype != np.float32:
        raise SystemExit(f"{peer} and spheremap differ by {worst:.2g} in {name} {way}")


# --- calls


def bench_calls(args: argparse.Namespace) -> list[tuple[str, float, float | None]]:
    """Return (call, microseconds, target) of one direction."""
    d = np.array([0.3, -0.5, 0.8], np.float32)
    many, out = d[None], np.empty((1, 2), np.float32)
    three = many.copy()
    p = sm.projection("octahedral")
    calls: dict[str, tuple[Call, float | None]] = {
        "p.encode(d, out=out)": (lambda: p.encode(many, out=out), 0.4),
        "p.encode(d)": (lambda: p.encode(many), None),
        'sm.encode(d, "octahedral", out=out)': (
            lambda: sm.encode(many, "octahedral", out=out),
            1.5,
        ),
        'sm.encode(d, "octahedral")': (lambda: sm.encode(many, "octahedral"), None),
        "np.add(d, d, out=d2)": (lambda: np.add(many, many, out=three), None),
    }
    loops = 2_000 if args.quick else 50_000

    def batch(call: Call) -> Call:
        def run() -> None:
            for _ in range(loops):
                call()

        return run

    empty = race({"empty": batch(lambda: None)}, args.rounds)["empty"]
    seconds = race({k: batch(c) for k, (c, _) in calls.items()}, args.rounds, patience=9)
    return [(k, (s - empty) / loops * 1e6, calls[k][1]) for k, s in seconds.items()]


# --- images


def bench_images(args: argparse.Namespace) -> list[tuple[str, float, float]]:
    """Return (work, millions of texels a second, ratio to cv2.remap or nan)."""
    height, side, face = (256, 256, 64) if args.quick else (2048, 4096, 1024)
    rng = np.random.default_rng(1)
    image = rng.random((height, 2 * height, 3), np.float32)
    p = sm.projection("latlong")
    random = rng.standard_normal((side, side, 3), np.float32)
    coherent = np.ascontiguousarray(sm.directions("octahedral", side), dtype=np.float32)
    out = np.empty((side, side, 3), np.float32)
    try:
        import cv2

        cv2.setNumThreads(args.threads)
    except ImportError:
        cv2 = None
        args.notes.append("cv2.remap was left out: OpenCV is not installed.")
    rows = []
    for where, d in (("random", random), ("coherent", coherent)):
        for kind in ("bilinear", "nearest"):
            say(f"sample {where} {kind}")
            entrants = {"ours": lambda d=d, k=kind: p.sample(image, d, filter=k, out=out)}
            if cv2 is not None:
                uv = p.encode(d) * np.float32([2 * height, height]) - np.float32(0.5)
                x, y = np.ascontiguousarray(uv[..., 0]), np.ascontiguousarray(uv[..., 1])
                flag = cv2.INTER_LINEAR if kind == "bilinear" else cv2.INTER_NEAREST
                more = (flag, None, cv2.BORDER_WRAP)
                entrants["cv2"] = lambda x=x, y=y, more=more: cv2.remap(image, x, y, *more)
            seconds = race(entrants, max(3, args.rounds // 2), patience=9)
            name = f"sample {kind}, {where} directions, latlong {2 * height}×{height}×3 f32"
            ratio = seconds["cv2"] / seconds["ours"] if cv2 is not None else np.nan
            rows.append((name, side * side / seconds["ours"] / 1e6, ratio))
    say("convert")
    cube = np.empty((6, face, face, 3), np.float32)
    plain = {"size": face, "antialias": False, "out": cube}
    entrants = {"ours": lambda: sm.convert(image, "latlong", "cube", **plain)}
    if cv2 is not None:
        uv = p.encode(sm.directions("cube", face)).astype(np.float32)
        uv = uv * np.float32([2 * height, height]) - np.float32(0.5)
        x = np.ascontiguousarray(uv[..., 0]).reshape(6 * face, face)
        y = np.ascontiguousarray(uv[..., 1]).reshape(6 * face, face)
        entrants["cv2"] = lambda: cv2.remap(image, x, y, cv2.INTER_LINEAR, None, cv2.BORDER_WRAP)
    seconds = race(entrants, max(3, args.rounds // 2), patience=9)
    ratio = seconds["cv2"] / seconds["ours"] if cv2 is not None else np.nan
    name = f"convert latlong {2 * height}×{height}×3 f32 to cube 6×{face}², bilinear"
    rows.append((name, cube[..., 0].size / seconds["ours"] / 1e6, ratio))
    return rows


# --- report


def versions() -> str:
    parts = [f"spheremap {sm.__version__}", f"Python {platform.python_version()}"]
    for name in ("numpy", "numba", "drjit", "opencv-python-headless"):
        try:
            parts.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    return ", ".join(parts)


def report(args: argparse.Namespace, yard: Yardsticks, maps, calls, images) -> str:
    levels = _core.simd_levels()[::-1]
    scale = ", ".join(f"{n:,} {k}" for k, n in COUNT.items())
    text = [
        "# Benchmarks",
        "Written by `make bench`. All times of a row come from one run in which the entrants take "
        "turns; the numbers are ratios of medians, so 1.00 is as fast as the yardstick and more "
        "is faster.",
        f"- Date: {datetime.date.today().isoformat()}\n"
        f"- Machine: {machine()}; {args.threads} threads each; best level {levels[0]}\n"
        f"- Versions: {versions()}\n"
        f"- C compiler: {yard.compiler}\n"
        f"- Directions a call: {scale}; {args.rounds} rounds",
    ]
    if args.count:
        text[-1] += f"\n- **A short run: at most {args.count:,} directions. Ratios mean little.**"

    head = ["map", "type", "way", "memcpy, ms"]
    for level in levels:
        has_goal = any(target("sphere", k, level) for k in COUNT)
        head += [level, "target", "reached"] if has_goal else [level]
    body = []
    for row in maps:
        s = row["seconds"]
        cells = [row["map"], row["kind"], row["way"], f"{s['copy'] * 1e3:.2f}"]
        for level in levels:
            ratio = s["copy"] / s[level]
            goal = target(row["map"], row["kind"], level)
            has_goal = any(target("sphere", k, level) for k in COUNT)
            cells += verdict(ratio, goal) if has_goal else [f"{ratio:.2f}"]
        body.append(cells)
    text += [
        "## With `out=`, against a memcpy of the same bytes",
        "Inputs and outputs together are as many bytes as the memcpy reads and writes. Each SIMD "
        "level is forced in turn.",
        table(head, body, 3),
    ]

    if yard.library is not None:
        body = []
        for row in maps:
            s = row["seconds"]
            ratio = s["loop fresh"] / s["fresh"]
            loop = f"{s['loop fresh'] * 1e3:.2f}"
            with_out = f"{s['loop'] / s[levels[0]]:.2f}"
            cells = [
                row["map"],
                row["kind"],
                row["way"],
                loop,
                *verdict(ratio, TARGET_FRESH),
                with_out,
            ]
            body.append(cells)
        head = [
            "map",
            "type",
            "way",
            "C loop, ms",
            "ours",
            "target",
            "reached",
            "both with existing memory",
        ]
        text += [
            "## Without `out=`, against a C loop into fresh numpy memory",
            "The loop reads and writes the same numbers and computes one or two sums. Both get "
            "their output from `np.empty`, and both pay for its page faults.",
            table(head, body, 3),
        ]

    existing, fresh = ["loop", levels[0], POOL], ["loop fresh", "fresh", *PEERS]
    heads = ["C loop", "ours, `out=`", "DrJit, pool"]
    heads += ["C loop, fresh", "ours, fresh", "DrJit", "numba", "numpy", "ours to the best"]
    body = []
    for row in maps:
        s, count = row["seconds"], row["count"]
        best = [s[c] for c in PEERS if c in s]
        if best:
            rates = [f"{count / s[c] / 1e6:,.0f}" if c in s else "–" for c in existing + fresh]
            body.append([row["map"], row["way"], *rates, f"{min(best) / s['fresh']:.1f}×"])
    if body:
        text += [
            "## Against other libraries",
            "Millions of float32 directions a second, from a numpy array to a numpy array. First "
            "those that write to memory they already have (DrJit's result is a view of a pool that "
            "it keeps), then those that return an array of its own. The last column is ours among "
            "the latter against the fastest library.",
            table(["map", "way", *heads], body, 2),
        ]

    if calls:
        body = []
        for name, us, goal in calls:
            judged = ["", ""] if goal is None else [f"{goal:g}", "yes" if us <= goal else "**no**"]
            body.append([f"`{name}`", f"{us:.2f}", *judged])
        text += ["## One direction a call", table(["call", "µs", "target", "reached"], body)]
    if images:
        body = [
            [name, f"{rate:,.0f}", "–" if np.isnan(ratio) else f"{ratio:.2f}"]
            for name, rate, ratio in images
        ]
        text += [
            "## Images",
            "Directions in, colors out, nothing kept between calls. Where OpenCV is installed, the "
            "ratio is to `cv2.remap`, which is given its coordinates ready made.",
            table(["work", "million texels/s", "to cv2.remap"], body),
        ]
    if args.notes:
        text += ["## Notes", "\n".join(f"- {note}" for note in args.notes)]
    return "\n\n".join(text) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--only", action="append", metavar="MAP", help="time this projection only (repeatable)"
    )
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument(
        "--output", type=Path, help="where to write (default: BENCHMARKS.md for a whole run)"
    )
    args = parser.parse_args()
    args.notes = []
    args.count = 200_000 if args.quick else 0
    if args.quick:
        args.rounds = 3
    args.maps = args.only or list(sm.projections())

    sm.set_num_threads(args.threads)
    yard = Yardsticks(args.threads)
    maps = bench_maps(args, yard)
    calls = [] if args.only else bench_calls(args)
    images = [] if args.only else bench_images(args)
    text = report(args, yard, maps, calls, images)
    print(text)
    output = args.output
    if output is None and not args.only and not args.quick:
        output = ROOT / "BENCHMARKS.md"
    if output is not None:
        # The sections of other benchmarks stay: each begins with a mark, and this part has none.
        old = output.read_text(encoding="utf-8") if output.exists() else ""
        _, mark, rest = old.partition("<!-- ")
        kept = f"\n{mark}{rest}" if mark else ""
        output.write_text(text + kept, encoding="utf-8")
        say(f"wrote {output}")


if __name__ == "__main__":
    main()
