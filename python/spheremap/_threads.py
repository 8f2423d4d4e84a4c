"""The same work on many blocks, by all threads that the library may use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from . import _core
from ._progress import counted

T = TypeVar("T")


def on_all_threads(work: Callable[[T], None], blocks: Iterable[T], most: int | None = None) -> None:
    """Do the work on each block, on `most` at once. NumPy and lookups release Python's lock."""
    blocks = list(blocks)
    if len(blocks) == 1:
        # To start a thread takes longer than many a work.
        work(blocks[0])
        return
    threads = _core.get_num_threads()
    pool = ThreadPoolExecutor(threads if most is None else min(threads, most))
    try:
        for under_way in counted([pool.submit(work, block) for block in blocks]):
            under_way.result()
    finally:
        # After an error, or Ctrl-C, what has begun is finished and nothing more begins.
        pool.shutdown(cancel_futures=True)
