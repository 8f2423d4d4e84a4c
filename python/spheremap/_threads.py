"""How many threads there are and what they run; the same work on many blocks, by all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from . import _core
from ._progress import counted
from ._scalars import as_whole

T = TypeVar("T")


def set_num_threads(n: int, /) -> None:
    """Set how many threads large calls use. Results have the same bits with any number.

    Parameters
    ----------
    n : int
        From 1 to 4096; no more than four a core are used.

    Raises
    ------
    ValueError
        For a number out of range.
    TypeError
        For what is no integer, as a bool.

    Examples
    --------
    >>> import spheremap as sm
    >>> before = sm.get_num_threads()
    >>> sm.set_num_threads(1)
    >>> sm.get_num_threads()
    1
    >>> sm.set_num_threads(before)
    """
    _core.set_num_threads(as_whole(n, "n"))


def get_num_threads() -> int:
    """Return how many threads large calls use.

    Returns
    -------
    n : int
        What `set_num_threads` was told, else the environment variable ``SPHEREMAP_NUM_THREADS``,
        else one a core; at most four a core.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.get_num_threads() >= 1
    True
    """
    return _core.get_num_threads()


def simd_level() -> str:
    """Return which instructions of the CPU the library uses: the widest that it knows and has.

    Returns
    -------
    level : {"baseline", "avx2", "avx512"}
        Results have the same bits at every level. ``"baseline"`` is what every CPU of its kind has.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.simd_level() in ("baseline", "avx2", "avx512")
    True
    """
    return _core.simd_level()


def on_all_threads(work: Callable[[T], None], blocks: Iterable[T], most: int | None = None) -> None:
    """Do the work on each block, on `most` at once. NumPy and lookups release Python's lock."""
    # Not with the package: it takes a while to import, and few calls have work for it.
    from concurrent.futures import ThreadPoolExecutor

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
