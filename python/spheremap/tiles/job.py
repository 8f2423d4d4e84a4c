"""What is asked for, checked: the same for all formats."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..map.size import matching_size
from ..resample.conversion import Conversion
from .colors import Look
from .folder import Folder

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import Worlds
    from .level import Image, Level

__all__ = ["Job"]


@dataclass(frozen=True)
class Job:
    """An image with its channels last, where its tiles go, and how they are made."""

    image: Image
    src: Projection
    folder: Folder
    size: int | None
    tile_size: int
    extension: str
    look: Look
    filter: ConvertFilter | str
    world: Worlds
    title: str
    frame: str
    properties: Mapping[str, str]
    page: bool

    def into(self, make: Callable[[], Path]) -> Job:
        """Return what goes to a folder that is made now, when all else has been asked for."""
        return replace(self, folder=replace(self.folder, path=make()))

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the image, without channels."""
        return self.image.shape[:-1]

    def wanted(self, dst: Projection) -> int:
        """Return the size that is asked for, or at which nothing of the image is lost."""
        if self.size is not None:
            return self.size
        if self.src.name == "latlong" and dst.name == "cube":
            # The middle of a face is its coarsest place, and the equator that of a latlong: 2/n
            # radians a texel, and 2π/width.
            return max(1, round(self.shape[-1] / np.pi))
        if self.src.name == dst.name == "latlong":
            return self.shape[-2]
        return max(1, matching_size(self.shape, self.src, dst))

    def converted(self, dst: Projection, shape: tuple[int, ...], *, fill: float = 0.0) -> Level:
        """Return the image in another projection."""
        options = {
            "filter": self.filter,
            "fill": fill,
            "world": self.world,
            # It was held to its aspect when it was given.
            "any_aspect": True,
        }
        image = self.image
        conversion = Conversion(self.src, dst, image.shape, image.dtype, shape, options)
        return image.converted(conversion, self.folder.path)
