"""Numbers of texels and of bytes as people write them."""

from __future__ import annotations

import re

from spheremap.cli.terminal import UsageError

_BYTES = re.compile(r"(\d+)\s*([kmgt]?)(?:i?b)?", re.IGNORECASE)
_LENGTH = re.compile(r"(\d+)(k?)", re.IGNORECASE)


def texels(option: str, text: str) -> int:
    """Return 512 of "512" and 4096 of "4k"."""
    found = _LENGTH.fullmatch(text)
    number = int(found[1]) * (1024 if found[2] else 1) if found else 0
    if number < 1:
        raise UsageError(f"{option} is a number of texels, as 512 or 4k; got {text!r}")
    return number


def as_bytes(option: str, text: str) -> int:
    """Return 536870912 of "512M"."""
    found = _BYTES.fullmatch(text)
    if found is None:
        raise UsageError(f"{option} is a number of bytes, as 512M or 4G; got {text!r}")
    return int(found[1]) << (10 * " kmgt".index(found[2].lower() or " "))
