"""What stands on the sphere besides images: marks, lights, and lines around something."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_doubles
from .._scalars import as_items, as_number, as_text, as_whole
from .._srgb import encoded
from ..light.image import REC709
from ..light.sources import Light, Sun
from ..map.pixels import pixels_to_directions
from .look import as_direction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection

__all__ = ["Overlays"]

# What a page places one by one, and places of lines.
_MOST, _MOST_PLACES = 1024, 1 << 16
# Degrees between places of a line, and places along a side of a box.
_STEP, _ALONG = 2.0, 64


@dataclass
class Overlays:
    """What a page draws over images, in the world of the first."""

    marks: list[tuple[str, tuple[float, ...]]] = field(default_factory=list)
    lights: list[dict[str, Any]] = field(default_factory=list)
    lines: list[tuple[str, NDArray[np.float64]]] = field(default_factory=list)

    def records(self, world: NDArray[np.float64]) -> dict[str, list[dict[str, Any]]]:
        """Return what the page reads; `world` takes its directions to those of the image."""

        def home(d: Any) -> Any:
            return (np.asarray(d) @ world).tolist()

        return {
            "marks": [{"text": text, "direction": home(at)} for text, at in self.marks],
            "lights": [light | {"direction": home(light["direction"])} for light in self.lights],
            "lines": [{"text": text, "points": home(points)} for text, points in self.lines],
        }

    def mark(self, directions: ArrayLike, names: Sequence[str] | str | None) -> None:
        """Add names, or dots."""
        given = as_doubles(directions, "directions")
        if given.shape[-1:] != (3,) or given.ndim > 2:
            raise ValueError(
                f"Expected `directions` to have shape (3,) or (N, 3), got {given.shape}."
            )
        rows = given.reshape(-1, 3)
        self._expect_room(len(rows), "marks")
        if names is None:
            names = ["•"] * len(rows)
        elif isinstance(names, str):
            names = [names]
        words = [as_text(name, "names") for name in as_items(names, "names", "str")]
        if len(words) != len(rows):
            raise ValueError(f"Expected {len(rows)} names, one a direction, got {len(words)}.")
        places = [as_direction(row, "directions") for row in rows]
        self.marks += list(zip(words, places, strict=True))

    def light(self, given: object) -> None:
        """Add lights: disks whose area is their share of the strongest, and rings for suns."""
        several = [given] if isinstance(given, Light | Sun) else as_items(given, "lights", "lights")
        found = list(several)
        for one in found:
            if not isinstance(one, Light | Sun):
                raise TypeError(
                    f"Expected `lights` to be of Light or Sun, got {type(one).__name__}."
                )
        self._expect_room(len(found), "lights")
        colors = [_three(one.irradiance) for one in found]
        strong = [float(color @ np.array(REC709)) for color in colors]
        strongest = max(strong, default=0.0) or 1.0
        for one, color, strength in zip(found, colors, strong, strict=True):
            shade = np.rint(255 * encoded(color / (color.max() or 1.0))).astype(int).tolist()
            self.lights.append(
                {
                    "direction": as_direction(one.direction, "lights"),
                    "size": math.sqrt(strength / strongest),
                    "color": "#{:02x}{:02x}{:02x}".format(*shade),
                    "sun": isinstance(one, Sun),
                }
            )

    def outline(self, directions: ArrayLike, name: str, closed: bool) -> None:
        """Add great circles from each direction to the next."""
        given = as_doubles(directions, "directions")
        if given.ndim != 2 or given.shape[1] != 3 or len(given) < 2:
            raise ValueError(
                f"Expected `directions` to have shape (N, 3) of two or more, got {given.shape}."
            )
        corners = np.array([as_direction(row, "directions") for row in given])
        ends = np.roll(corners, -1, axis=0)
        if not closed:
            corners, ends = corners[:-1], ends[:-1]
        angles = 2 * np.arcsin(np.clip(np.linalg.norm(ends - corners, axis=1) / 2, 0, 1))
        if (angles > math.pi - 1e-6).any():
            raise ValueError("Expected no two `directions` in a row to be opposite.")
        parts = []
        for start, end, angle in zip(corners, ends, angles, strict=True):
            count = max(1, math.ceil(math.degrees(angle) / _STEP))
            t = np.arange(count)[:, np.newaxis] / count
            parts.append((1 - t) * start + t * end)
        self._add(name, np.concatenate([*parts, ends[-1:]]))

    def box(
        self,
        box: Sequence[float],
        name: str,
        face: int | None,
        p: Projection,
        shape: tuple[int, ...],
    ) -> None:
        """Add the border of a rectangle of an image, in its pixels."""
        # The fifth tells that there are too many: a view that repeats a number may have any length.
        some = islice(as_items(box, "box", "four numbers"), 5)
        sides = [as_number(x, "box") for x in some]
        if len(sides) != 4:
            count = "more" if len(sides) > 4 else f"{len(sides)} numbers"
            raise ValueError(f"Expected `box` to be left, top, right, bottom, got {count}.")
        left, top, right, bottom = sides
        if not (np.isfinite(sides).all() and left < right and top < bottom):
            raise ValueError(
                f"Expected `box` to be left < right and top < bottom, got {tuple(sides)}."
            )
        if (face is None) is (p.faces > 1):
            wanted = (
                f"one of {p.faces} faces" if p.faces > 1 else "none: the image has no array of them"
            )
            raise ValueError(f"Expected `face` to be {wanted}, got {face}.")
        t = np.arange(_ALONG) / _ALONG
        x = np.concatenate(
            [
                left + t * (right - left),
                0 * t + right,
                right - t * (right - left),
                0 * t + left,
                [left],
            ]
        )
        y = np.concatenate(
            [
                0 * t + top,
                top + t * (bottom - top),
                0 * t + bottom,
                bottom - t * (bottom - top),
                [top],
            ]
        )
        places = [x, y]
        if face is not None:
            number = as_whole(face, "face")
            if not 0 <= number < p.faces:
                raise ValueError(f"Expected `face` to be from 0 to {p.faces - 1}, got {number}.")
            places.append(np.full(len(x), float(number)))
        points = np.asarray(
            pixels_to_directions(np.stack(places, axis=-1), p, shape, any_aspect=True), np.float64
        )
        seen = points[np.isfinite(points).all(axis=-1)]
        if len(seen) < 2:
            raise ValueError(f"The image holds no sphere around the box {tuple(sides)}.")
        self._add(name, seen)

    def _add(self, name: str, points: NDArray[np.float64]) -> None:
        self._expect_room(1, "lines")
        if sum(len(line) for _, line in self.lines) + len(points) > _MOST_PLACES:
            raise ValueError(f"Expected lines of at most {_MOST_PLACES} places in all.")
        self.lines.append((as_text(name, "name"), points))

    def _expect_room(self, more: int, what: str) -> None:
        if more + len(getattr(self, what)) > _MOST:
            raise ValueError(f"Expected at most {_MOST} {what}, got {more} more.")


def _three(irradiance: ArrayLike) -> NDArray[np.float64]:
    """Return light in three channels: one is gray, and a fourth is no color."""
    given = np.nan_to_num(np.atleast_1d(np.asarray(irradiance, np.float64))).clip(0)
    return given[:3] if len(given) >= 3 else given[:1].repeat(3)
