"""Sizes as people write them."""

from __future__ import annotations

import re

import spheremap as sm
from spheremap.cli import files
from spheremap.cli.terminal import UsageError

_SIZE = re.compile(r"(\d+)(k?)", re.IGNORECASE)


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


def texels(option: str, text: str) -> int:
    """Return 512 of "512" and 4096 of "4k"."""
    found = _SIZE.fullmatch(text)
    number = int(found[1]) * (1024 if found[2] else 1) if found else 0
    if number < 1:
        raise UsageError(f"{option} is a number of texels, as 512 or 4k; got {text!r}")
    return number
