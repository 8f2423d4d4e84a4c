"""Sizes as people write them."""

from __future__ import annotations

import spheremap as sm
from spheremap.cli import files
from spheremap.cli.lengths import texels
from spheremap.cli.terminal import UsageError


def wanted(
    dst: sm.Projection, height: str | None, width: str | None, size: str | None
) -> int | None:
    """Return the size that one of three options asks for."""
    given = {"--height": height, "--width": width, "--size": size}
    asked = [(name, text) for name, text in given.items() if text is not None]
    if not asked:
        return None
    if len(asked) > 1:
        raise UsageError(f"give {asked[0][0]} or {asked[1][0]}, not both")
    ((name, text),) = asked
    number = texels(name, text)
    if name == "--height":
        return files.size_of_height(dst, number)
    return files.size_of_width(dst, number) if name == "--width" else number
