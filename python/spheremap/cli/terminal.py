"""What the subcommands share: usage errors, progress, tables, files to write."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

import spheremap as sm
from spheremap import io
from spheremap.io.images import STORED


class UsageError(Exception):
    """The command line asks for something that does not exist or does not go together."""


def check_projection(name: str) -> None:
    """Raise a usage error for a name that is no projection's."""
    with as_usage():
        sm.projection(name)


@contextmanager
def as_usage() -> Iterator[None]:
    """Turn a ValueError of the library into a usage error."""
    try:
        yield
    except ValueError as error:
        raise UsageError(str(error)) from None


def read(path: Path) -> np.ndarray[Any, Any]:
    """Read an image file; what its library prints meanwhile becomes a part of the error."""
    if sys.stderr.isatty():
        # There the spinner prints as well.
        return io.read(path)
    said = b""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with tempfile.TemporaryFile() as file:
            os.dup2(file.fileno(), 2)
            try:
                return io.read(path)
            finally:
                os.dup2(kept, 2)
                file.seek(0)
                said = file.read()
    except OSError as error:
        text = " ".join(said.decode(errors="replace").split())
        if error.errno is None and text and text not in str(error):
            raise OSError(f"{error} ({text})") from None
        raise
    finally:
        os.close(kept)


def write(
    path: Path,
    image: np.ndarray[Any, Any],
    exposure: float,
    compression: str | None,
    names: tuple[str, ...],
) -> None:
    """Write an image, tone-mapped if the format holds no floats."""
    if image.dtype.kind == "f" and "float32" not in STORED[path.suffix.lower()]:
        io.write(path, io.tonemap(image, exposure=exposure), compression=compression)
    else:
        io.write(path, image, compression=compression, channels=names)


def table_console() -> Console:
    """Return a console for tables."""
    # In a pipe there is no width to fit: rows stay whole.
    return Console(width=None if sys.stdout.isatty() else 1000, highlight=False)


class Step:
    """Names the work in hand beside the spinner."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._task = progress.add_task("", total=None)

    def __call__(self, description: str) -> None:
        """Name the work."""
        self._progress.update(self._task, description=escape(description))


@contextmanager
def progress() -> Iterator[Step]:
    """Show a spinner on a terminal, and what is being worked on."""
    console = Console(stderr=True)
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as progress:
        yield Step(progress)
