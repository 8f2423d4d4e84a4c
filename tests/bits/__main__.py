"""Make inputs, compute, compare: what `make test-aarch64` runs.

python -m bits inputs INPUTS.npz
python -m bits run INPUTS.npz RESULTS.npz [--level LEVEL]
python -m bits compare RESULTS.npz OTHERS.npz...

NaN equals NaN: which payload a NaN carries is nobody's promise. Every other number is compared by
its bits, the sign of a zero included.
"""

from __future__ import annotations

import argparse
import hashlib
import platform
import sys
from pathlib import Path

import numpy as np


def canonical(a: np.ndarray) -> np.ndarray:
    """Return an array with all NaN made the same one, and -0 kept."""
    a = np.ascontiguousarray(a)
    if a.dtype.kind == "f":
        a = np.where(np.isnan(a), a.dtype.type(np.nan), a)
    return a


def digest(a: np.ndarray) -> str:
    """Return the SHA-256 of an array's type, shape and bytes."""
    said = hashlib.sha256(f"{a.dtype.str} {a.shape} ".encode())
    said.update(canonical(a).tobytes())
    return said.hexdigest()


def run(inputs: Path, results: Path, level: str | None) -> None:
    from spheremap import _core

    from . import calls

    if level is not None:
        _core.set_simd_level(level)
    with np.load(inputs) as given:
        found = dict(calls.results({name: given[name] for name in given.files}))
    whole = hashlib.sha256("".join(f"{n} {digest(a)}\n" for n, a in found.items()).encode())
    where = f"{platform.machine()} {_core.simd_level()}"
    print(
        f"{where}: {len(found)} arrays, {sum(a.size for a in found.values())} numbers, "
        f"sha256 {whole.hexdigest()}"
    )
    np.savez(results, names=np.array(list(found)), where=where, **number(found))


def number(found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return arrays by number: their names are no file names."""
    return {str(k): a for k, a in enumerate(found.values())}


def read(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    with np.load(path) as held:
        names = held["names"].tolist()
        return str(held["where"]), {name: held[str(k)] for k, name in enumerate(names)}


def differ(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Tell for each number of two arrays of one type and shape whether its bits differ."""
    word = np.dtype(f"u{a.dtype.itemsize}") if a.dtype.itemsize <= 8 else np.dtype("u8")
    a, b = canonical(a), canonical(b)
    return a.reshape(-1).view(word) != b.reshape(-1).view(word)


def compare(first: Path, others: list[Path]) -> int:
    """Print, for each verb, how many arrays differ and by how much; return 1 if one may not."""
    here, want = read(first)
    wrong = 0
    for path in others:
        there, got = read(path)
        print(f"{there} against {here}:")
        if list(got) != list(want):
            print(f"  different calls: {sorted(set(got) ^ set(want))[:5]}")
            wrong = 1
        verbs: dict[str, list[str]] = {}
        for name in want:
            if name in got:
                verbs.setdefault(name.split(":")[0].split(" [")[0], []).append(name)
        same = 0
        for verb, names in verbs.items():
            lines = []
            worst = 0.0
            for name in names:
                a, b = want[name], got[name]
                if digest(a) == digest(b):
                    continue
                if a.dtype != b.dtype or a.shape != b.shape:
                    lines.append(f"{name}: {a.dtype} {a.shape}, {b.dtype} {b.shape}")
                    worst = np.inf
                    continue
                off = distance(a, b)
                worst = max(worst, off)
                count = np.count_nonzero(differ(a, b))
                lines.append(f"{name}: {count} of {a.size} numbers, by {off:.1e} of the largest")
            if not lines:
                same += 1
                continue
            wrong = 1
            print(f"  {verb}: {len(lines)} of {len(names)} arrays differ, by {worst:.1e} at most")
            print(*(f"    {line}" for line in lines[:8]), sep="\n")
        print(f"  {same} of {len(verbs)} verbs have the same bits")
    return wrong


def distance(a: np.ndarray, b: np.ndarray) -> float:
    """Return the largest difference of two arrays over their largest number."""
    if a.dtype.kind not in "fiu":
        return float("inf")
    x, y = a.astype(np.float64), b.astype(np.float64)
    if not np.array_equal(np.isfinite(x), np.isfinite(y)):
        return float("inf")
    x, y = x[np.isfinite(x)], y[np.isfinite(y)]
    return float(np.abs(x - y).max() / max(np.abs(x).max(), 1e-300)) if x.size else 0.0


def main() -> int:
    parser = argparse.ArgumentParser(prog="bits", description=__doc__)
    jobs = parser.add_subparsers(dest="job", required=True)
    jobs.add_parser("inputs").add_argument("inputs", type=Path)
    job = jobs.add_parser("run")
    job.add_argument("inputs", type=Path)
    job.add_argument("results", type=Path)
    job.add_argument("--level", help="of instructions; the best there is by default")
    job = jobs.add_parser("compare")
    job.add_argument("first", type=Path)
    job.add_argument("others", type=Path, nargs="+")
    given = parser.parse_args()
    if given.job == "inputs":
        from . import inputs

        np.savez(given.inputs, **inputs.make())
        return 0
    if given.job == "run":
        run(given.inputs, given.results, given.level)
        return 0
    return compare(given.first, given.others)


if __name__ == "__main__":
    sys.exit(main())
