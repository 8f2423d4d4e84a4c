"""Options of the form NAME=VALUE, which may be given many times."""

from __future__ import annotations

from collections.abc import Iterable

from spheremap.cli.terminal import UsageError


def named_values(option: str, given: Iterable[str] | None, example: str) -> dict[str, str]:
    """Return the values that an option gives, by their names."""
    found = {}
    for text in given or ():
        name, sign, value = text.partition("=")
        if not sign or not name.strip():
            raise UsageError(f"{option} is NAME=VALUE, as {example}; got {text!r}")
        found[name.strip()] = value.strip()
    return found
