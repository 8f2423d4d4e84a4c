"""What the benchmarks share: yardsticks, races in turn, tables.

All entrants of a race take turns (A B C A B C ...), and what counts is the ratio of their medians,
so a machine that is slow for a while is slow for all of them.
"""

from __future__ import annotations

import ctypes
import itertools
import os
import platform
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from spheremap import _core

ROOT = Path(__file__).resolve().parent.parent
Call = Callable[[], object]
# Whose idle threads spin.
THREADED = ("drjit", "numba", "numpy", "cv2", "py360convert", "skylibs", "mitsuba")


class Yardsticks:
    """A memcpy and a plain loop over the same bytes.

    They are C where there is a compiler, else memmove in Python threads and no loop.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.library: ctypes.CDLL | None = None
        self.compiler = "none: two Python threads with memmove; no loop"
        cc = shutil.which(os.environ.get("CC", "cc"))
        if cc is None:
            return
        with tempfile.TemporaryDirectory() as folder:
            built = Path(folder) / "moveloop.so"
            flags = ["-O2", "-pthread", "-shared", "-fPIC"]
            if platform.machine() in ("x86_64", "AMD64"):
                flags.append("-march=x86-64")
            source = ROOT / "benches" / "moveloop.c"
            if subprocess.run([cc, *flags, str(source), "-o", str(built)], check=False).returncode:
                return
            self.library = ctypes.CDLL(str(built))
        version = subprocess.run([cc, "--version"], capture_output=True, text=True, check=False)
        self.compiler = f"{version.stdout.splitlines()[0]}, {' '.join(flags[:2])}"

    def copy(self, bytes_moved: int) -> Call:
        """Copy half of `bytes_moved`: each byte is read once and written once."""
        size = bytes_moved // 2
        source, target = np.ones(size, np.uint8), np.ones(size, np.uint8)
        keep = (source, target)
        a, b = source.ctypes.data, target.ctypes.data
        if self.library is not None:
            function, n = self.library.copy, ctypes.c_size_t(size)
            arguments = (ctypes.c_void_p(a), ctypes.c_void_p(b), n, self.threads)
            return lambda: (function(*arguments), keep)

        def run() -> object:
            edges = [size * i // self.threads for i in range(self.threads + 1)]
            parts = [
                threading.Thread(target=ctypes.memmove, args=(b + lo, a + lo, hi - lo))
                for lo, hi in itertools.pairwise(edges)
            ]
            for part in parts:
                part.start()
            for part in parts:
                part.join()
            return keep

        return run

    def loop(self, source: np.ndarray, out: np.ndarray | None, columns: int) -> Call | None:
        """Read `source`, write `columns` numbers a row into `out` or into fresh numpy memory."""
        if self.library is None:
            return None
        kind = "f32" if source.dtype == np.float32 else "f64"
        function = getattr(self.library, f"move_{kind}_{source.shape[1]}_{columns}")
        count, a = ctypes.c_size_t(len(source)), ctypes.c_void_p(source.ctypes.data)
        shape = (len(source), columns)

        def run() -> object:
            result = np.empty(shape, source.dtype) if out is None else out
            function(a, ctypes.c_void_p(result.ctypes.data), count, self.threads)
            return result

        return run


def race(
    entrants: dict[str, Call],
    rounds: int,
    patience: float = 0.25,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Return each entrant's median time in seconds. Slow ones leave after four rounds.

    `time.process_time` is a clock for a machine with other work, and entrants of one thread.
    """
    times: dict[str, list[float]] = {name: [] for name in entrants}
    for call in entrants.values():
        call()
    # Threads of some spin when they are done, and take a core from the next entrant until they
    # sleep. A pause costs the next one a start from idle: after all or after none, lest it hit one
    # more often than another.
    pause = any(name.split()[0] in THREADED for name in entrants)
    order = random.Random(0)
    for turn in range(rounds):
        # In another order each time: some leave the image in the cache to the next, some do not.
        for name, call in order.sample(list(entrants.items()), len(entrants)):
            if turn >= 4 and times[name][0] > patience:
                continue
            start = clock()
            result = call()
            times[name].append(clock() - start)
            del result
            if pause:
                time.sleep(0.02)
    return {name: statistics.median(t) for name, t in times.items()}


def at_level(level: str | None, call: Call) -> Call:
    def run() -> object:
        _core.set_simd_level(level)
        return call()

    return run


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def publish(text: list[str], quick: bool) -> None:
    """Print a section; where it is no smoke test, put it into BENCHMARKS.md or at its end.

    The first and the last of its paragraphs are the marks that it is found by.
    """
    section, begin, end = "\n\n".join(text), text[0], text[-1]
    print(section)
    if quick:
        return
    page = ROOT / "BENCHMARKS.md"
    old = page.read_text(encoding="utf-8")
    if begin in old:
        new = old.split(begin)[0] + section + old.split(end)[1]
    else:
        new = old.rstrip("\n") + "\n\n" + section + "\n"
    page.write_text(new, encoding="utf-8")
    say(f"wrote a section of {page}")


def table(head: list[str], rows: list[list[str]], left: int = 1) -> str:
    """Return a Markdown table; the first `left` columns are text, the rest numbers."""
    rule = ["---" if i < left else "---:" for i in range(len(head))]
    return "\n".join("| " + " | ".join(r) + " |" for r in [head, rule, *rows])


def verdict(ratio: float, goal: float | None) -> list[str]:
    judged = ["", ""] if goal is None else [f"{goal:g}", "yes" if ratio >= goal else "**no**"]
    return [f"{ratio:.2f}", *judged]


def machine() -> str:
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = [x for x in info.read_text().splitlines() if x.startswith("model name")]
        model = lines[0].split(":", 1)[1].strip() if lines else model
    return f"{model}, {os.cpu_count()} cores"
