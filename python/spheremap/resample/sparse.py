"""Arrays of any size that take memory only where they are written."""

from __future__ import annotations

import math
import mmap
import platform
import sys
import tempfile
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import DTypeLike, NDArray

__all__ = ["sparse_zeros"]

# The number that the `mmap` of Python has by name since 3.13; other processors have others.
_NORESERVE = getattr(
    mmap,
    "MAP_NORESERVE",
    0x4000
    if sys.platform == "linux" and platform.machine() in ("x86_64", "aarch64", "riscv64")
    else None,
)


def sparse_zeros(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """Return an array of zeros whose pages take memory when something is written to them.

    It may be larger than the memory and the swap together.
    """
    dtype = np.dtype(dtype)
    length = math.prod(shape) * dtype.itemsize
    if length == 0:
        return np.zeros(shape, dtype)
    pages = _anonymous(length)
    if pages is None:
        return _in_file(shape, dtype)
    return np.frombuffer(pages, dtype).reshape(shape)


def _anonymous(length: int) -> mmap.mmap | None:
    """Return pages that nothing is set aside for; None where the system has no such."""
    if _NORESERVE is None:
        return None
    try:
        pages = mmap.mmap(-1, length, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | _NORESERVE)
    except OSError:
        # Some systems count every page that might be written, or bound the addresses.
        return None
    # A huge page would take 2 MiB for the few texels of a row that a chunk has.
    with suppress(AttributeError, OSError):
        pages.madvise(mmap.MADV_NOHUGEPAGE)
    return pages


def _in_file(shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return an array in a file that has no name and no blocks but those that are written."""
    with tempfile.TemporaryFile(prefix="spheremap-") as file:
        file.truncate(math.prod(shape) * dtype.itemsize)
        return np.memmap(file, dtype, "r+", shape=shape)
