"""`compare`: two conventions beside each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..align.comparison import compare as told
from ..map.named import resolve_pair
from ..map.picture import colors
from ..resample.verbs import convert
from .drawing import AXES, axis, drawn_shape, expect_image, new_figure, places
from .image import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from numpy.typing import ArrayLike

    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["compare"]

# Of x, y and z; what points the other way is dashed.
_COLORS = ("#c03030", "#208040", "#2050c0")
# Of the words, in points, and from line to line in fonts.
_FONT, _LINE = 8, 1.2
# Wider than this for its height, a pair stands one above the other.
_WIDEST = 5.0


def compare(
    a: ProjectionLike,
    b: ProjectionLike,
    *,
    image: ArrayLike | None = None,
    world: Worlds = "match",
    size: int | tuple[int, ...] = 256,
    exposure: float | None = 0.0,
    figure: Figure | SubFigure | None = None,
) -> list[Axes]:
    """Draw one scene in two conventions, and lines between places of the same axis.

    Parameters
    ----------
    a, b : Projection or str
        As for `spheremap.align.compare`, whose words stand below.
    image : array_like, optional
        A scene in `a`; by default colors of its directions, with a graticule.
    world : {"match", "literal"}
        As for `spheremap.convert`, which makes the second picture of the first.
    size : int or tuple of int
        Of the first picture, where no image is given.
    exposure : float or None
        As for `spheremap.io.tonemap`.
    figure : matplotlib.figure.Figure or SubFigure, optional
        Where to draw.

    Returns
    -------
    axes : list of matplotlib.axes.Axes
        Of `a` and of `b`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.align.compare` and `spheremap.convert`.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import spheremap as sm
    >>> first, second = sm.plot.compare("latlong:blender", "latlong:unity", size=32)
    >>> first.get_title(), second.get_title()
    ('latlong:blender', 'latlong:unity')
    """
    from matplotlib.patches import ConnectionPatch

    found = told(a, b)
    p, q = resolve_pair(found.a, found.b, None, world)
    pixels = colors(p, drawn_shape(p, size))[..., :3] if image is None else np.asarray(image)
    expect_image(p, pixels.shape)
    pictures = (pixels, convert(pixels, found.a, found.b, world=world))

    def extent(k: int) -> tuple[float, float]:
        pair, faces = pictures[k], (p, q)[k].faces
        height, width = pair.shape[0 if faces == 1 else 1 :][:2]
        return float(width * faces), float(height)

    aspects = [extent(k)[0] / extent(k)[1] for k in range(2)]
    if sum(aspects) > _WIDEST:
        drawn = new_figure(figure, (8, 8 * sum(1 / x for x in aspects) + 1.4))
        axes = drawn.subplots(2, 1, height_ratios=[1 / x for x in aspects])
    else:
        drawn = new_figure(figure, (9, 9 / sum(aspects) + 1.4))
        axes = drawn.subplots(1, 2, width_ratios=aspects)
    for ax, picture, title, own in zip(
        axes, pictures, (_title(found.a), _title(found.b)), (found.a, found.b), strict=True
    ):
        show(picture, own, ax=ax, exposure=exposure)
        ax.set_title(title, fontsize=10, family="monospace")
    for k, name in enumerate(AXES):
        here, there = (places(each, axis(name), *extent(side)) for side, each in enumerate((p, q)))
        if not np.isfinite([*here, *there]).all():
            continue
        line = ConnectionPatch(
            (float(here[0]), float(here[1])),
            (float(there[0]), float(there[1])),
            "data",
            "data",
            axesA=axes[0],
            axesB=axes[1],
            color=_COLORS[k // 2],
            linewidth=1.2,
            linestyle="--" if k % 2 else "-",
            alpha=0.8,
        )
        line.set_in_layout(False)
        drawn.add_artist(line)
    words = str(found)
    drawn.supxlabel(words, fontsize=_FONT, family="monospace", ha="center")
    if drawn.get_layout_engine() is None:
        # Nothing else keeps the pictures off the words.
        points = 72 * drawn.bbox.height / drawn.get_figure(root=True).dpi
        room = _FONT * _LINE * (words.count("\n") + 2) / points
        drawn.subplots_adjust(bottom=min(max(room, drawn.subplotpars.bottom), 0.5))
    return list(axes)


def _title(p: Projection) -> str:
    return f"{p.name}:{p.convention}" if p.convention else p.name
