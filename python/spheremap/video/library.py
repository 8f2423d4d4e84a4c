"""PyAV, which only those need who convert videos."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..io.whole import as_path

if TYPE_CHECKING:
    from av.container import InputContainer

__all__ = ["opened", "reading", "require"]


def require() -> None:
    """Raise an ImportError that says what to install."""
    try:
        import av  # noqa: F401
    except ImportError:
        raise ImportError("videos need PyAV: pip install spheremap[video]", name="av") from None


@contextmanager
def reading(name: str) -> Iterator[None]:
    """Turn PyAV's errors into those of a file that cannot be read."""
    from av.error import FFmpegError

    try:
        yield
    except FFmpegError as error:
        raise OSError(f"cannot read {name!r}: {error.strerror or error}") from None


def opened(path: object) -> InputContainer:
    """Open a video of the disk."""
    require()
    import av

    name = as_path(path)
    place = Path(os.path.realpath(name))
    if not place.exists():
        raise FileNotFoundError(f"no such file: {name!r}")
    if place.is_dir():
        raise IsADirectoryError(f"cannot read {name!r}: it is a folder")
    with reading(name):
        # With all of its path, so that no part before a colon is taken for a protocol.
        container = av.open(str(place))
    if not container.streams.video:
        container.close()
        raise ValueError(f"{name!r} has no video")
    return container
