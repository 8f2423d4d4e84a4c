"""What was written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

__all__ = ["Pyramid"]


@dataclass(frozen=True)
class Pyramid:
    """What `write` wrote.

    Attributes
    ----------
    manifest : Path
        The file that says what there is, which a viewer is given; it was written last.
    shape : tuple of int
        Of the largest level, without channels.
    levels : int
        How many levels there are.
    tiles : int
        How many tiles there are in all levels.
    """

    manifest: Path
    shape: tuple[int, ...]
    levels: int
    tiles: int
