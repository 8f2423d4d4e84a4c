"""The same work on many blocks, by all threads that the library may use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from . import _core
from ._progress import counted

T = TypeVar("T")


def on_all_threads(work: Callable[[T], None], blocks: Iterable[T]) -> None:
    """Do the work on each block. NumPy and lookups release the interpreter's lock."""
    pool = ThreadPoolExecutor(_core.get_num_threads())
    try:
        for under_way in counted([pool.submit(work, block) for block in blocks]):
            under_way.result()
    finally:
        # After an error, or Ctrl-C, what has begun is finished and nothing more begins.
        pool.shutdown(cancel_futures=True)
