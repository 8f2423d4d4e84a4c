"""Make many calls, or one again: ``python -m fuzz --calls 1000000``, ``--seed 1 --only 42``."""

from __future__ import annotations

import argparse
import os
import sys
from concurrent.futures import ThreadPoolExecutor

from .calls import call
from .campaign import run

# Calls to a process, so that one that leaks would not starve the rest.
PIECE = 5000


def main() -> int:
    parser = argparse.ArgumentParser(prog="fuzz", description=__doc__)
    parser.add_argument("--calls", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int, help="make this call alone")
    options = parser.parse_args()
    if options.only is not None:
        print(call(options.seed, options.only))
        found = run(options.seed, options.only, options.only + 1)
        print(*found, sep="\n")
        return bool(found)
    pieces = range(0, options.calls, PIECE)
    count = 0
    with ThreadPoolExecutor(max(1, (os.cpu_count() or 2) // 2)) as pool:
        for found in pool.map(
            lambda k: run(options.seed, k, min(k + PIECE, options.calls)), pieces
        ):
            for finding in found:
                print(finding, flush=True)
            count += len(found)
    print(f"{options.calls} calls, {count} findings")
    return bool(count)


if __name__ == "__main__":
    sys.exit(main())
