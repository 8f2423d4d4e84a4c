"""A disk that has room for a few pictures of a folder of tiles."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

from spheremap.tiles.folder import Folder

if TYPE_CHECKING:
    import numpy as np
    import pytest


def disk_full_after(pictures: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the one after so many, and no other, end in an OSError."""
    write, number = Folder.picture, count()

    def fails(self: Folder, name: str, pixels: np.ndarray) -> None:
        if next(number) == pictures:
            raise OSError("no room")
        write(self, name, pixels)

    monkeypatch.setattr(Folder, "picture", fails)
