"""What a command tells of its work while it is at it."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from spheremap._progress import told


class Step:
    """Names the work in hand and tells how far it is; here to nobody."""

    is_shown = False

    def __call__(self, description: str) -> None:
        """Name the work; how long it takes is not known yet."""

    def part(self, fraction: float) -> None:
        """Tell how much of the work in hand is done."""

    def done(self) -> None:
        """Count one more of several things."""

    def listening(self) -> AbstractContextManager[None]:
        """Tell how much is done of what the library does meanwhile."""
        return told(self.part) if self.is_shown else nullcontext()
