"""Time printed code against the kernels of the library; write a section of BENCHMARKS.md.

    python benches/languages.py
    python benches/languages.py --quick    # a smoke test: small arrays, printed only

C is compiled with -O3 for this machine, in one thread, as the kernels run here. Directions stay in
the processor's cache: beyond it kernels gain by how they write memory, which is no part of what is
printed. Entrants of a row take turns. Flags are those that keep the bits: a product and a sum are
not contracted, and a compiler that need not set errno or traps may use vectors.

What gcc 12 does with it depends on two things more. Where a loop stores x, y and z side by side, it
makes vectors of x and y, and computes all that they share twice: so a block is computed into an
array for each component first. And it computes both sides of a choice that is asked for twice,
roots and quotients as well, unless it is told `-fno-tree-dominator-opts`, with which it finds no
vectors in arctangents: so there are two entrants.
"""

from __future__ import annotations

import argparse
import ctypes
import platform
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, get_args

import numpy as np
import spheremap as sm
from measure import Call, machine, publish, race, table, verdict
from spheremap._names import Language

BEGIN, END = "<!-- languages: written by benches/languages.py -->", "<!-- languages: end -->"
# Where compilers have 512 bits they use 256, unless they are asked.
WIDE = ("-mprefer-vector-width=512",) if platform.machine() == "x86_64" else ()
KEEPING_BITS = ("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
FLAGS = ("-O3", "-march=native", *WIDE, *KEEPING_BITS)
MAPS = (
    "sphere",
    "matcap",
    "dual_paraboloid",
    "cube",
    "angular",
    "octahedral",
    "hemioctahedral",
    "latlong",
    "equal_area",
    "equisolid",
    "stereographic",
)
LOOP = """
enum {{ BLOCK = 64 }};
void run(const float *given, float *made, long count) {{
    float parts[{given}][BLOCK];
    for (long first = 0; first < count; first += BLOCK) {{
        const long n = count - first < BLOCK ? count - first : BLOCK;
        const float *from = given + {taken} * first;
        float *to = made + {given} * first;
        for (long k = 0; k < n; k++) {{
            float r[{given}];
            m_{verb}(from + {taken} * k, r);
            {spread}
        }}
        for (long k = 0; k < n; k++) {{
            {gathered}
        }}
    }}
}}
"""
# Beside the flags of all.
CHOICES = {"C": (), "C, choices kept": ("-fno-tree-dominator-opts",)}
TARGET = 0.9


def compiled(
    folder: Path, name: str, verb: str, shape: tuple[int, int], flags: tuple[str, ...]
) -> Any:
    """Return a loop over what is printed for C."""
    text = sm.code(name, "c", verbs=(verb,), name="m")
    label = "_".join([name, verb, *flags])
    source, library = folder / f"{label}.c", folder / f"{label}.so"
    taken, given = shape
    spread = " ".join(f"parts[{c}][k] = r[{c}];" for c in range(given))
    gathered = " ".join(f"to[{given} * k + {c}] = parts[{c}][k];" for c in range(given))
    loop = LOOP.format(verb=verb, taken=taken, given=given, spread=spread, gathered=gathered)
    source.write_text(text + loop)
    command = ["cc", *FLAGS, *flags, "-shared", "-fPIC", source, "-o", library, "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library)).run


def repeated(call: Call, times: int) -> Call:
    """Return what calls so often."""

    def run() -> None:
        for _ in range(times):
            call()

    return run


def kernels(args: argparse.Namespace) -> list[list[str]]:
    count, calls = 16_384, 1 if args.quick else 100
    rng = np.random.default_rng(0)
    d = rng.standard_normal((count, 3)).astype(np.float32)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in MAPS[:2] if args.quick else MAPS:
            p = sm.projection(name)
            seen = np.ascontiguousarray(np.where(p.covers(d)[:, None], d, -d))
            for verb, data in (("encode", seen), ("decode", p.encode(seen))):
                own_verb = getattr(p, verb)
                own = np.asarray(own_verb(data))
                others = {label: np.empty_like(own) for label in CHOICES}
                entrants: dict[str, Call] = {
                    "kernel": lambda f=own_verb, x=data, y=own: f(x, out=y)
                }
                for label, flags in CHOICES.items():
                    shape = (data.shape[1], own.shape[1])
                    run = compiled(Path(folder), name, verb, shape, flags)
                    at = [a.ctypes.data_as(ctypes.c_void_p) for a in (data, others[label])]
                    entrants[label] = lambda f=run, at=at: f(*at, ctypes.c_long(count))
                many = {label: repeated(call, calls) for label, call in entrants.items()}
                seconds = race(many, args.rounds, clock=time.process_time)
                alike = all(own.tobytes() == other.tobytes() for other in others.values())
                same = "yes" if alike else "no"
                times = [f"{t * 1e9 / count / calls:.2f}" for t in seconds.values()]
                fastest = min(seconds[label] for label in CHOICES)
                ratio = verdict(seconds["kernel"] / fastest, TARGET)
                rows.append([name, verb, *times, *ratio, same])
    return rows


def printing() -> str:
    slowest = (0.0, "", "")
    for name in sm.projections():
        for language in get_args(Language):
            start = time.perf_counter()
            sm.code(name, language)
            slowest = max(slowest, (time.perf_counter() - start, name, language))
    return f"The slowest map to print is {slowest[1]}, in {slowest[2]}: {slowest[0] * 1e3:.1f} ms."


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--rounds", type=int, default=15)
    args = parser.parse_args()
    sm.set_num_threads(1)
    head = ["map", "verb", "kernel, ns", *(f"{label}, ns" for label in CHOICES)]
    head += ["kernel/fastest", "target", "met", "same bits"]
    text = [
        BEGIN,
        "## Printed code",
        f"{machine()}; f32, one thread, `cc {' '.join(FLAGS)}`; nanoseconds of CPU time a "
        "direction, medians of rounds in turn, on a machine with other work; 16,384 directions, in "
        "its cache. Choices are kept by `-fno-tree-dominator-opts`.",
        table(head, kernels(args), 2),
        printing(),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
