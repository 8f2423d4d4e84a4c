"""The folder that tiles go to: each file whole or not at all, and all before the last."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..io.images import write_among
from ..io.whole import as_path, bring_to_disk, write_bytes, written_among

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Folder", "empty_folder"]

_PAGES = Path(__file__).parent / "pages"


@dataclass(frozen=True)
class Folder:
    """A folder, and the quality of its .jpg, from 1 to 100."""

    path: Path
    quality: int

    def picture(self, name: str, pixels: NDArray[np.uint8]) -> None:
        """Write a .jpg or .png."""
        is_jpg = name.endswith(".jpg")
        place = self._place(name)
        write_among(place, pixels, compression=f"jpeg:{self.quality}" if is_jpg else None)

    def data(self, name: str, data: bytes) -> None:
        """Write any other file."""
        write_bytes(self._place(name), data, written_among)

    def manifest(self, name: str, data: bytes) -> Path:
        """Write the file that a viewer is given: the last one."""
        place = self._place(name)
        try:
            bring_to_disk(self.path)
        except OSError as error:
            raise _said(error, str(self.path)) from None
        write_bytes(place, data)
        return place

    def json(self, name: str, values: Mapping[str, Any]) -> Path:
        """Write it as JSON."""
        return self.manifest(name, (json.dumps(values, indent=2) + "\n").encode())

    def page(self, name: str) -> None:
        """Write the page that shows a format."""
        self.data("index.html", (_PAGES / f"{name}.html").read_bytes())

    def _place(self, name: str) -> Path:
        place = self.path / name
        place.parent.mkdir(parents=True, exist_ok=True)
        return place


def empty_folder(path: object) -> Callable[[], Path]:
    """Raise an OSError where no tiles can go, and return what makes the folder.

    What is there already would lie among the tiles.
    """
    name = as_path(path)
    place = Path(os.path.realpath(name))
    try:
        if place.exists():
            if not place.is_dir():
                raise NotADirectoryError(f"cannot write {name!r}: it is no folder")
            if any(place.iterdir()):
                raise FileExistsError(f"cannot write to {name!r}: the folder is not empty")
    except OSError as error:
        raise _said(error, name) from None

    def make() -> Path:
        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _said(error, name) from None
        return place

    return make


def _said(error: OSError, name: str) -> OSError:
    if error.errno is None:
        return error
    return type(error)(f"cannot write {name!r}: {error.strerror}")
