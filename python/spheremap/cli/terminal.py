"""What the subcommands share: usage errors, progress, files to read and write."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import typer

import spheremap as sm
from spheremap import _core, io
from spheremap.cli import files
from spheremap.cli.steps import Step


class UsageError(Exception):
    """The command line asks for something that does not exist or does not go together."""


def check_projection(name: str) -> None:
    """Raise a usage error for a name that is no projection's."""
    with as_usage():
        sm.projection(name)


def tell_worlds(src: sm.Projection, dst: sm.Projection, world: str) -> None:
    """Say what was done to match the worlds of two programs, where they differ."""
    said = _core.worlds(src, dst) if world == "match" else None
    if said:
        print(said, file=sys.stderr)


def tell_tilt(path: Path, head: io.Header, name: str | None) -> None:
    """Say that the camera of an image was tilted, where it is taken for what it says."""
    leveled = files.leveled(head.tilt)
    if leveled and name in (None, head.projection):
        print(f"{path}: {leveled}", file=sys.stderr)


@contextmanager
def as_usage() -> Iterator[None]:
    """Turn a ValueError of the library into a usage error."""
    try:
        yield
    except ValueError as error:
        raise UsageError(str(error)) from None


def read(path: Path, *, part: str | None = None, fill: float = 0.0) -> np.ndarray[Any, Any]:
    """Read an image file; what its library prints meanwhile becomes a part of the error."""
    if sys.stderr.isatty():
        # There the spinner prints as well.
        return io.read(path, part=part, fill=fill)
    import tempfile

    said = b""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with tempfile.TemporaryFile() as file:
            os.dup2(file.fileno(), 2)
            try:
                return io.read(path, part=part, fill=fill)
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


def was_given(context: typer.Context, name: str) -> bool:
    """Tell whether an option stands on the command line, at its default or not."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def refuse(context: typer.Context, names: Sequence[str], why: str) -> None:
    """Raise a usage error for the first of these options that is given and would do nothing."""
    for name in names:
        if was_given(context, name):
            raise UsageError(f"--{name.strip('_').replace('_', '-')} does nothing {why}")


@contextmanager
def progress(total: int = 1) -> Iterator[Step]:
    """Show on a terminal what is being worked on, how far it is, and how long yet."""
    if not sys.stderr.isatty():
        yield Step()
        return
    from spheremap.cli.display import shown

    with shown(total) as step:
        yield step
