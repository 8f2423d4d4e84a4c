"""Files that are to stay."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def refuse_existing(places: Iterable[Path]) -> None:
    """Raise where a file would be replaced."""
    for place in places:
        if place.exists():
            raise FileExistsError(f"{str(place)!r} is there, and --no-clobber keeps it")
