"""Time printed code against the kernels of the library; write a section of BENCHMARKS.md.

    python benches/languages.py
    python benches/languages.py --quick    # a smoke test: small arrays, printed only

C is compiled with -O3 for this machine, in one thread, as the kernels run here. Entrants of a row
take turns. Flags are those that keep the bits: a product and a sum are not contracted, and a
compiler that need not set errno or traps may use vectors.
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
void run(const float *given, float *made, long count) {{
    for (long k = 0; k < count; k++) m_{verb}(given + {taken} * k, made + {given} * k);
}}
"""
TARGET = 0.9


def compiled(folder: Path, name: str, verb: str, shape: tuple[int, int]) -> Any:
    """Return a loop over what is printed for C."""
    text = sm.code(name, "c", verbs=(verb,), name="m")
    source, library = folder / f"{name}_{verb}.c", folder / f"{name}_{verb}.so"
    source.write_text(text + LOOP.format(verb=verb, taken=shape[0], given=shape[1]))
    subprocess.run(["cc", *FLAGS, "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
    return ctypes.CDLL(str(library)).run


def kernels(args: argparse.Namespace) -> list[list[str]]:
    count = 20_000 if args.quick else 2_000_000
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
                other = np.empty_like(own)
                run = compiled(Path(folder), name, verb, (data.shape[1], own.shape[1]))
                pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (data, other)]
                entrants: dict[str, Call] = {
                    "kernel": lambda f=own_verb, x=data, y=own: f(x, out=y),
                    "C": lambda f=run, at=pointers: f(*at, ctypes.c_long(count)),
                }
                seconds = race(entrants, args.rounds)
                same = "yes" if own.tobytes() == other.tobytes() else "no"
                times = [f"{t * 1e9 / count:.2f}" for t in seconds.values()]
                ratio = verdict(seconds["kernel"] / seconds["C"], TARGET)
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
    head = ["map", "verb", "kernel, ns", "C, ns", "kernel/C", "target", "met", "same bits"]
    text = [
        BEGIN,
        "## Printed code",
        f"{machine()}; f32, one thread, `cc {' '.join(FLAGS)}`; nanoseconds a direction, medians "
        "of rounds in turn.",
        table(head, kernels(args), 2),
        printing(),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
