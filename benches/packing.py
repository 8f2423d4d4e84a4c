"""Time packing against a C loop, meshoptimizer, numba and numpy; write a section of BENCHMARKS.md.

    python benches/packing.py            # rewrites its section
    python benches/packing.py --quick    # a smoke test: small arrays, printed only

All entrants take turns, as in map.py, and ratios are of medians. Everybody
but numpy writes to memory that is there already.
"""

from __future__ import annotations

import argparse
import ctypes
import os

import numpy as np
import spheremap as sm
from measure import ROOT, Call, Yardsticks, at_level, race, say, table, verdict
from spheremap import _core

BEGIN = "<!-- packing: written by benches/packing.py -->"
END = "<!-- end of packing -->"
TARGET = {"nearest": 0.8, "hex": 0.8, "precise": 0.5, "unpack": 0.8}
NAME = "oct16x2"
# Who is given only a part of the work, and how small a part.
SHARE = {"numpy": 16}


def numpy_pack(d: np.ndarray) -> np.ndarray:
    p = d[:, :2] / np.abs(d).sum(1, keepdims=True)
    folded = (1 - np.abs(p[:, ::-1])) * np.where(p < 0, np.float32(-1), np.float32(1))
    return np.rint(np.where(d[:, 2:] < 0, folded, p) * np.float32(32767)).astype(np.int16)


def numpy_unpack(c: np.ndarray) -> np.ndarray:
    p = c.astype(np.float32) / np.float32(32767)
    z = 1 - np.abs(p).sum(1, keepdims=True)
    over = np.maximum(-z, 0)
    n = np.concatenate([p - np.where(p < 0, -over, over), z], 1)
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def numba_peers(threads: int) -> tuple[Call, Call]:
    import numba

    numba.set_num_threads(threads)

    @numba.njit(parallel=True, fastmath=True)
    def pack(d, out):
        for i in numba.prange(len(d)):
            x, y, z = d[i, 0], d[i, 1], d[i, 2]
            scale = np.float32(1) / (abs(x) + abs(y) + abs(z))
            p, q = x * scale, y * scale
            if z < 0:
                p, q = (
                    (np.float32(1) - abs(q)) * (np.float32(-1) if p < 0 else np.float32(1)),
                    (np.float32(1) - abs(p)) * (np.float32(-1) if q < 0 else np.float32(1)),
                )
            out[i, 0] = np.int16(np.rint(p * np.float32(32767)))
            out[i, 1] = np.int16(np.rint(q * np.float32(32767)))

    @numba.njit(parallel=True, fastmath=True)
    def unpack(c, out):
        for i in numba.prange(len(c)):
            x, y = np.float32(c[i, 0]), np.float32(c[i, 1])
            z = np.float32(32767) - abs(x) - abs(y)
            over = max(-z, np.float32(0))
            x += over if x < 0 else -over
            y += over if y < 0 else -over
            scale = np.float32(1) / np.sqrt(x * x + y * y + z * z)
            out[i, 0], out[i, 1], out[i, 2] = x * scale, y * scale, z * scale

    return pack, unpack


def loop(yard: Yardsticks, name: str, source: np.ndarray, target: np.ndarray) -> Call | None:
    if yard.library is None:
        return None
    arguments = (
        ctypes.c_void_p(source.ctypes.data),
        ctypes.c_void_p(target.ctypes.data),
        ctypes.c_size_t(len(source)),
        yard.threads,
    )
    return lambda: (getattr(yard.library, name)(*arguments), source, target)


def peers(args: argparse.Namespace, d: np.ndarray, codes: np.ndarray, back: np.ndarray):
    """Return (name, pack, unpack) of each library that is installed."""
    found = []
    try:
        import meshoptimizer  # noqa: F401
        from meshoptimizer._loader import lib

        four = np.zeros((len(d), 4), np.float32)
        four[:, :3] = d
        wide = np.zeros((len(d), 4), np.int16)
        count, stride, bits = ctypes.c_size_t(len(d)), ctypes.c_size_t(8), ctypes.c_int(16)
        into, source = ctypes.c_void_p(wide.ctypes.data), ctypes.c_void_p(four.ctypes.data)
        keep = (four, wide)
        lib.meshopt_encodeFilterOct(into, count, stride, bits, source)
        found.append(
            (
                "meshoptimizer (one thread, 16-byte in, 8-byte codes)",
                lambda: (lib.meshopt_encodeFilterOct(into, count, stride, bits, source), keep),
                lambda: (lib.meshopt_decodeFilterOct(into, count, stride), keep),
            )
        )
    except ImportError:
        args.notes.append("meshoptimizer was left out: it is not installed.")
    try:
        pack, unpack = numba_peers(args.threads)
        theirs = np.empty_like(codes)
        pack(d, theirs)
        ours = sm.packing.pack(d, NAME, "nearest")
        if np.mean(np.abs(theirs.astype(int) - ours) > 1) > 1e-4:
            raise SystemExit("numba and spheremap pack to different codes")
        found.append(("numba", lambda: pack(d, theirs), lambda: unpack(codes, back)))
    except ImportError:
        args.notes.append("numba was left out: it is not installed.")
    few = args.count // SHARE["numpy"]
    found.append(("numpy", lambda: numpy_pack(d[:few]), lambda: numpy_unpack(codes[:few])))
    return found


def section(args: argparse.Namespace) -> str:
    d = np.random.default_rng(0).standard_normal((args.count, 3), np.float32)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    codes = sm.packing.pack(d, NAME, "nearest")
    back = np.empty_like(d)
    yard = Yardsticks(args.threads)
    rivals = peers(args, d, codes, back)
    levels = _core.simd_levels()[::-1]
    words = np.empty(args.count, np.uint32)
    out = np.empty_like(codes)

    packing: dict[str, Call] = {}
    if move := loop(yard, "move_pack", d, words):
        packing["C loop"] = move
    for rounding in ("nearest", "hex", "precise"):
        for level in levels:
            call = lambda r=rounding: sm.packing.pack(d, NAME, r, out=out)  # noqa: E731
            packing[f"{rounding} {level}"] = at_level(level, call)
    packing |= {name: pack for name, pack, _ in rivals}
    unpacking: dict[str, Call] = {}
    if move := loop(yard, "move_unpack", words, back):
        unpacking["C loop"] = move
    for level in levels:
        unpacking[f"unpack {level}"] = at_level(
            level, lambda: sm.packing.unpack(codes, NAME, out=back)
        )
    unpacking |= {name: unpack for name, _, unpack in rivals}

    body = []
    for way, entrants in (("pack", packing), ("unpack", unpacking)):
        say(way)
        seconds = race(entrants, args.rounds)
        seconds = {name: s * SHARE.get(name, 1) for name, s in seconds.items()}
        _core.set_simd_level(None)
        for name, s in seconds.items():
            stem, _, level = name.partition(" ")
            ratio = seconds["C loop"] / s if "C loop" in seconds else np.nan
            goal = TARGET.get(stem) if level == levels[0] else None
            label = f"**ours, {name}**" if stem in TARGET else name
            body.append([way, label, f"{args.count / s / 1e6:,.0f}", *verdict(ratio, goal)])
    head = ["way", "who", "million/s", "to the C loop", "target", "reached"]
    parts = [
        BEGIN,
        "## Packing unit vectors",
        f"Written by `benches/packing.py`: {args.count:,} float32 directions to `{NAME}` (two "
        f"int16) and back, {args.threads} threads, {args.rounds} rounds in turn. The C loop moves "
        "the same bytes and computes nothing.",
        table(head, body, 2),
        *(f"- {note}" for note in args.notes),
        END,
    ]
    return "\n\n".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=11)
    args = parser.parse_args()
    args.notes = []
    args.count = 1 << 18 if args.quick else 1 << 24
    sm.set_num_threads(args.threads)
    text = section(args)
    print(text)
    if not args.quick:
        path = ROOT / "BENCHMARKS.md"
        whole = path.read_text(encoding="utf-8") if path.exists() else ""
        before, _, rest = whole.partition(BEGIN)
        after = rest.partition(END)[2]
        path.write_text(f"{before.rstrip()}\n\n{text}\n{after.lstrip()}", encoding="utf-8")


if __name__ == "__main__":
    main()
