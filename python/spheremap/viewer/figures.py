"""What stands on the sphere, drawn over a still by matplotlib."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.pixels import directions_to_pixels
from ..map.verbs import decode
from .look import TISSOT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Frame", "circles", "graticule", "over"]

# Where longitude and latitude are u and v.
_GLOBE = "latlong"
# Places along a meridian; the page's lines and disks, in pixels.
_ALONG = 361
_SUN, _LIGHT, _LEAST = 26.0, 20.0, 5.0
_DPI = 100


@dataclass(frozen=True)
class Frame:
    """A picture's camera, in the world of the page, and which part of its image it is."""

    camera: Projection
    shape: tuple[int, ...]
    crop: tuple[slice, slice]

    def places(self, directions: Any) -> NDArray[np.float64]:
        """Return columns and rows of the picture; NaN for what it does not see."""
        found = directions_to_pixels(directions, self.camera, self.shape, any_aspect=True)
        rows, columns = self.crop
        places: NDArray[np.float64] = np.asarray(found, np.float64)[..., :2]
        return places - np.array([columns.start, rows.start], np.float64)

    def pieces(self, directions: Any) -> list[NDArray[np.float64]]:
        """Return a line in pieces: none over a seam of the screen, or far outside."""
        places = self.places(directions)
        size = np.array([side.stop - side.start for side in self.crop[::-1]])
        with np.errstate(invalid="ignore"):
            near = (np.abs(places / size - 0.5) < 8).all(axis=-1)
            joined = (np.abs(np.diff(places, axis=0)) < 0.25 * size).all(axis=-1)
        cuts = np.flatnonzero(~(joined & near[1:] & near[:-1])) + 1
        return [piece for piece in np.split(places, cuts) if len(piece) > 1]


def graticule(step: float) -> list[NDArray[Any]]:
    """Return parallels and meridians so many degrees apart."""
    along = np.linspace(0, 1, _ALONG)
    # A little within the poles and the seam, where places are not unique.
    within = np.clip(along, 1e-6, 1 - 1e-6)
    lines = [decode(np.stack([within, 0 * along + v], -1), _GLOBE) for v in _whole(180 / step)]
    lines += [decode(np.stack([0 * along + u, within], -1), _GLOBE) for u in _whole(360 / step, 0)]
    return lines


def _whole(count: float, first: int = 1) -> list[float]:
    return [k / count for k in range(first, math.ceil(count - 1e-9))]


def circles() -> list[NDArray[np.float64]]:
    """Return small circles of the page's radius, on parallels as far apart."""
    radius, apart = (math.radians(angle) for angle in TISSOT)
    rows = round(math.pi / apart)
    turns = np.linspace(0, 2 * math.pi, 73)
    found = []
    for row in range(rows):
        v = (row + 0.5) / rows
        count = max(3, math.floor(2 * math.pi / apart * math.sin(math.pi * v) + 0.5))
        for k in range(count):
            center = np.asarray(decode([(k + 0.5) / count, v], _GLOBE), np.float64)
            side = np.cross(center, [0.0, 1.0, 0.0])
            side /= np.linalg.norm(side)
            ring = np.outer(np.cos(turns), side) + np.outer(np.sin(turns), np.cross(side, center))
            found.append(math.cos(radius) * center + math.sin(radius) * ring)
    return found


def over(
    picture: NDArray[np.uint8],
    frame: Frame,
    *,
    thin: Sequence[NDArray[Any]],
    circles: Sequence[NDArray[Any]],
    records: dict[str, list[dict[str, Any]]],
) -> NDArray[np.uint8]:
    """Return a picture with lines, and with marks, lights and outlines as a page has them."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import LineCollection
        from matplotlib.figure import Figure
        from matplotlib.patheffects import withStroke
    except ImportError:
        raise ImportError(
            "what is drawn over stills needs matplotlib: pip install spheremap[plot]",
            name="matplotlib",
        ) from None
    height, width = picture.shape[:2]
    # A point is a pixel.
    points = 72 / _DPI
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)
    canvas: Any = FigureCanvasAgg(figure)
    figure.figimage(picture, origin="upper", zorder=-1)
    ax = figure.add_axes((0, 0, 1, 1), frameon=False, xlim=(0, width), ylim=(height, 0))
    ax.set_axis_off()

    def draw(lines: Sequence[NDArray[Any]], *strokes: tuple[Any, float, float]) -> None:
        pieces = [piece for line in lines for piece in frame.pieces(line)]
        for color, wide, alpha in strokes:
            ax.add_collection(
                LineCollection(pieces, colors=color, linewidths=wide * points, alpha=alpha)
            )

    def write(text: str, at: NDArray[Any], size: float, **where: Any) -> None:
        if np.isfinite(at).all() and (at >= 0).all() and (at <= [width, height]).all():
            edge = [withStroke(linewidth=2.5 * points, foreground="black")]
            style: dict[str, Any] = {"color": "white", "fontweight": "bold", "path_effects": edge}
            ax.text(float(at[0]), float(at[1]), text, fontsize=size * points, **style, **where)

    draw(thin, ("black", 3, 0.45), ("white", 1, 0.65))
    draw(circles, ((0.5, 0.05, 0.05), 2, 1))
    outlines = [np.asarray(line["points"]) for line in records["lines"]]
    draw(outlines, ("black", 4, 0.67), ("#40d8ff", 1.8, 1))
    for light in records["lights"]:
        x, y = frame.places(light["direction"])
        sun = light["sun"]
        across = (_SUN if sun else max(_LEAST, _LIGHT * light["size"])) * points
        ax.plot(
            x,
            y,
            "o",
            markersize=across,
            markerfacecolor="none" if sun else light["color"],
            markeredgecolor="#ffd000" if sun else "black",
            markeredgewidth=2 * points if sun else points,
        )
    for mark in records["marks"]:
        write(
            mark["text"],
            frame.places(mark["direction"]),
            13,
            ha="center",
            va="center",
        )
    for line, places in zip(records["lines"], outlines, strict=True):
        write(line["text"], frame.places(places[0]) + np.array([2, -2]), 12)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
