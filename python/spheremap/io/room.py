"""Room on a disk, before there is anything to put there."""

from __future__ import annotations

import os
from typing import IO

__all__ = ["set_aside"]


def set_aside(file: IO[bytes], length: int) -> None:
    """Make an open file so many bytes long, or raise an OSError where there is no room for it.

    Where it is mapped, a full disk would end the process at a store.
    """
    file.truncate(length)
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, length)
