"""How frames are shown: a file may say that they are turned or mirrored first."""

from __future__ import annotations

import struct
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from .metadata import side_data

if TYPE_CHECKING:
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

    from .planes import Plane

__all__ = ["Display", "display"]


class Display(NamedTuple):
    """A quarter turn, mirrored or not: (x, y) right and down goes to (ax + cy, bx + dy)."""

    a: int = 1
    b: int = 0
    c: int = 0
    d: int = 1

    @property
    def is_across(self) -> bool:
        """Whether rows become columns."""
        return self.a == 0

    def picture(self, plane: NDArray[Any]) -> NDArray[Any]:
        """Return a view of a plane as it is shown."""
        if self.is_across:
            return plane.T[:: self.b, :: self.c]
        return plane[:: self.d, :: self.a]

    def shape(self, stored: tuple[int, int]) -> tuple[int, int]:
        """Return height and width as shown."""
        return stored[::-1] if self.is_across else stored

    def plane(self, stored: Plane) -> Plane:
        """Return what a plane is as shown."""
        if not self.is_across:
            return stored
        return replace(stored, across=stored.down, down=stored.across)

    def at(self, offset: tuple[float, float]) -> tuple[float, float]:
        """Return how far right and down of its place a texel lies as shown."""
        x, y = offset
        return self.a * x + self.c * y, self.b * x + self.d * y


def display(frame: VideoFrame, name: str) -> Display:
    """Return how a file says that a frame is shown; ValueError for turns by other angles."""
    matrix = side_data(frame, "DISPLAYMATRIX")
    # FFmpeg's: lines of three, of which the third is of perspective.
    a, b, _, c, d = struct.unpack_from("=5i", matrix) if matrix else (1, 0, 0, 0, 1)
    is_quarter = (b == c == 0 and a and d) or (a == d == 0 and b and c)
    # PyAV may know that frames are turned and yet not hand on how.
    if not is_quarter or (matrix is None and frame.rotation):
        raise ValueError(
            f"{name!r} says that it is shown turned by {frame.rotation}°: only quarter turns are "
            "supported"
        )
    return Display(*((x > 0) - (x < 0) for x in (a, b, c, d)))
