"""What `spheremap convert` reads, and where each of it goes."""

from __future__ import annotations

from pathlib import Path

from spheremap.cli import targets
from spheremap.cli.terminal import UsageError
from spheremap.io.images import STORED


def pairs(paths: list[Path], output: str | None, format: str | None) -> list[tuple[Path, Path]]:
    """Return each input with its output."""
    if output is None:
        if len(paths) != 2:
            raise UsageError(f"give IN and OUT, or -o PATTERN for several IN; got {len(paths)}")
        found = [(paths[0], paths[1])]
    elif output == targets.STDOUT:
        found = [(path, Path(output)) for path in paths]
    else:
        found = [(path, targets.named(output, path)) for path in paths]
    targets.check_apart(found)
    if (format is not None) != (found[0][1].name == targets.STDOUT):
        raise UsageError("--format goes with standard output, and standard output with --format")
    if format is not None and f".{format}" not in STORED:
        raise UsageError(f"unknown format {format!r}; use one of {', '.join(STORED)}")
    return found
