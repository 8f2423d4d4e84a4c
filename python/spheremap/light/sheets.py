"""The light of an image sheet by sheet, where not all of it is there at once.

A sheet is a square of texels of one face. Sums over the sphere are sums of sheets, in an order that
the shape of the image gives: who looks at them one by one has the bits of the whole.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .. import _core
from .._arrays import spatial_axes
from ..resample.seen import Rectangle, SourceTiles
from .report import Energy, report

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["SIDE", "Place", "energy_of_sheets", "rectangle", "sheet_places", "texels_around"]

Place: TypeAlias = tuple[slice, ...]

# What a listed texel takes until the sun is found among all, and each of its channels.
_TEXEL, _CHANNEL = 240, 24

# Rows and columns of a sheet, and of blocks of texels that have a mean.
SIDE = 512
_BLOCKS = (1, 2, 4, 8, 16, 32, 64, 128, 256, SIDE)


def sheet_places(projection: Projection, shape: tuple[int, ...]) -> list[Place]:
    """Return where the sheets of an image of this shape lie in it."""
    axes = spatial_axes(projection)
    rest = tuple(slice(0, n) for n in shape[axes:])
    rows = shape[axes - 2]
    found = []
    for top, bottom, left, right in _core.sheets(projection, shape[:axes]):
        columns = slice(left, right)
        if axes == 2:
            found.append((slice(top, bottom), columns, *rest))
        else:
            face = top // rows
            within = slice(top - face * rows, bottom - face * rows)
            found.append((slice(face, face + 1), within, columns, *rest))
    return found


def texels_around(memory: int, channels: int) -> int:
    """Return how many texels may be listed in so many bytes."""
    return max(memory // (_TEXEL + _CHANNEL * channels), 1)


def energy_of_sheets(
    projection: Projection,
    shape: tuple[int, ...],
    luminance: NDArray[np.float64],
    of_each: Callable[[Any, Sequence[int]], Iterable[NDArray[np.float64]]],
    most: int | None = None,
) -> Energy:
    """Report the light of an image from what its sheets give.

    Parameters
    ----------
    projection : Projection
    shape : tuple of int
        Of the image, with channels.
    luminance : ndarray, shape (C,)
        What makes luminance of its channels.
    of_each : callable
        Called with what has a method ``part(image, number)``, and with numbers of sheets; returns
        what that gives for each. It is asked for all sheets, and then for some.
    most : int, optional
        How many texels may be listed among which the sun is looked for. Of more, blocks have their
        means.
    """
    axes = spatial_axes(projection)
    places = sheet_places(projection, shape)
    surveys = np.stack(list(of_each(_Survey(projection, luminance), range(len(places)))))
    light = _core.energy_from(surveys, projection, shape[:axes])
    toward, angle = light[4], light[7]
    near = list(range(len(places)))
    if angle is not None:
        near = _near(projection, shape, places, np.array(toward), angle)
    listed: list[NDArray[np.float64]] = []
    for block in _BLOCKS:
        listed = []
        around = _Around(projection, luminance, tuple(toward), angle, block)
        for texels in of_each(around, near):
            listed.append(texels)
            if most is not None and sum(map(len, listed)) > most and block != _BLOCKS[-1]:
                break
        else:
            break
    return report(*light[:7], _core.sun_from(np.concatenate(listed)))


def rectangle(place: Place) -> Rectangle:
    """Return a place, without channels, as rows and columns of a face."""
    *faces, rows, columns = place
    face = faces[0].start if faces else None
    return Rectangle(rows.start, rows.stop, columns.start, columns.stop, face)


def _near(
    projection: Projection,
    shape: tuple[int, ...],
    places: Sequence[Place],
    direction: NDArray[np.float64],
    angle: float,
) -> list[int]:
    """Return the numbers of the sheets that may hold texels within an angle of a direction."""
    axes = spatial_axes(projection)
    parts = [rectangle(place[:axes]) for place in places]
    near: list[int] = SourceTiles(projection, shape[:axes], parts).within(direction, angle).tolist()
    return near


@dataclass(frozen=True, slots=True, eq=False)
class _Survey:
    """What a sheet tells of its light."""

    projection: Projection
    luminance: NDArray[np.float64]

    def part(self, image: NDArray[Any], number: int) -> NDArray[np.float64]:
        return _core.survey_of(image, self.projection, number, self.luminance)


@dataclass(frozen=True, slots=True, eq=False)
class _Around:
    """The texels of a sheet around the brightest of the image, or means over blocks of them."""

    projection: Projection
    luminance: NDArray[np.float64]
    direction: tuple[float, ...]
    angle: float | None
    block: int

    def part(self, image: NDArray[Any], number: int) -> NDArray[np.float64]:
        return _core.lit_of(
            image,
            self.projection,
            number,
            self.luminance,
            self.direction,
            self.angle,
            self.block,
        )
