"""Parallels and meridians, and what they are called."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .drawing import AXES, axis, pieces, places

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection

__all__ = ["draw_graticule"]

# Points from a place to its number; further where the name of an axis stands at the place.
_BESIDE, _BEYOND = (3, 3), (12, 4)


def draw_graticule(
    ax: Axes, p: Projection, step: float, width: float, height: float, *, named: bool
) -> None:
    """Draw parallels and meridians, and say which they are.

    `named` tells that the names of the axes are drawn too: numbers then stand beside them.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.patheffects import withStroke

    right, up, ahead = (axis(name) for name in p.world.split())
    # As on the sky: right-handed, its longitude grows to the left.
    sky = up[2] == 1 and np.linalg.det([right, up, -ahead]) > 0
    east = -right if sky else right

    def at(longitude: ArrayLike, latitude: ArrayLike) -> NDArray[np.float64]:
        a, b = np.broadcast_arrays(np.radians(longitude), np.radians(latitude))
        a, b = a[..., None], b[..., None]
        d = np.cos(b) * (np.cos(a) * ahead + np.sin(a) * east) + np.sin(b) * up
        return places(p, d, width, height)

    parallels = np.arange(-(np.ceil(90 / step) - 1) * step, 90, step)
    meridians = np.arange(0, 360 - step / 2, step)
    lines = [at(np.linspace(0, 360, 1441), latitude) for latitude in parallels]
    lines += [at(longitude, np.linspace(-90, 90, 721)) for longitude in meridians]
    drawn = [piece for line in lines for piece in pieces(line, width / p.faces, height)]
    ax.add_collection(LineCollection(drawn, colors="black", linewidths=0.5, alpha=0.6, zorder=1.5))
    whole = 360 if sky else 180
    marks = [(0.0, latitude, f"{latitude:g}°") for latitude in parallels if latitude]
    marks += [(x, 0.0, f"{x if x <= whole else x - 360:g}°") for x in meridians]
    names = np.array([places(p, axis(name), width, height)[:2] for name in AXES])
    for longitude, latitude, text in marks:
        x, y, _ = at(longitude, latitude)
        if not np.isfinite([x, y]).all():
            continue
        taken = named and bool((np.abs(names - [x, y]).max(axis=-1) < 1e-6 * width).any())
        right_by, up_by = _BEYOND if taken else _BESIDE
        # Beside the right edge, and above the upper, it would hang outside.
        left = x > 0.97 * width
        up_by = -9 if y < 0.05 * height else up_by
        ax.annotate(
            text,
            (float(x), float(y)),
            (-right_by if left else right_by, up_by),
            textcoords="offset points",
            fontsize=7,
            horizontalalignment="right" if left else "left",
            path_effects=[withStroke(linewidth=2, foreground="white")],
        )
