"""`footprints`: what the texels of one map see of another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._scalars import as_flag
from ..map.named import resolve_pair
from .distortion import texel_uv
from .drawing import bare, drawn_shape, label, mark_valid, new_axes, pieces, places
from .image import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["footprints"]

# Places along a line of texel borders: it bends, and ends where it meets a seam.
_PLACES = 1025


def footprints(
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: int | tuple[int, ...] = 8,
    image: ArrayLike | None = None,
    rotation: Any | None = None,
    world: Worlds = "match",
    labels: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Draw what the texels of `dst` see of `src`: their borders, and dots in their centers.

    Parameters
    ----------
    src : Projection or str
        The map that is looked at, and drawn.
    dst : Projection or str
        The map whose texels look; each of its faces has a color.
    size : int or tuple of int
        Of `dst`: few texels are enough to see where they are long, and where many see one.
    image : array_like, optional
        An image in `src` that is drawn below, as by `show`.
    rotation, world
        As for `spheremap.convert`.
    labels : bool
        Whether to name the directions.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.convert`.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import spheremap as sm
    >>> ax = sm.plot.footprints("latlong", "cube", size=4)
    >>> len(ax.collections)
    12
    """
    labels = as_flag(labels, "labels")
    source, target = resolve_pair(src, dst, rotation, world)
    shape = drawn_shape(target, size)
    if image is None:
        ax = new_axes(ax)
        rows, columns = source.shape(256)[-2:]
        mark_valid(ax, source, rows, columns)
        bare(ax, source, columns, rows)
    else:
        ax = show(image, source, ax=ax, labels=False)
    from matplotlib.collections import LineCollection

    width, height = float(ax.get_xlim()[1]), float(ax.get_ylim()[0])
    centers = texel_uv(target, shape).reshape(target.faces, -1, 3 if target.faces > 1 else 2)
    for face in range(target.faces):
        lines = [
            piece
            for line in _borders(target, shape, face)
            for piece in pieces(
                places(source, _seen(target, line), width, height), width / source.faces, height
            )
        ]
        color = f"C{face % 10}"
        ax.add_collection(LineCollection(lines, colors=color, linewidths=1.0))
        dots = places(source, _seen(target, centers[face]), width, height)
        ax.scatter(dots[:, 0], dots[:, 1], s=6, color=color)
    if labels:
        label(ax, source, width, height)
    return ax


def _seen(p: Projection, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(p.decode(uv), np.float64)


def _borders(p: Projection, shape: tuple[int, ...], face: int) -> list[NDArray[np.float64]]:
    """Return lines of (u, v) or (u, v, face) between the texels of a face, and around it."""
    along = np.linspace(0.0, 1.0, _PLACES)
    lines = []
    for axis, count in enumerate(shape[:-3:-1]):
        corners = p.grid == "corners" or (p.grid == "corners-v" and axis == 1)
        # On a grid of corners the texels at the edges are cut in half.
        edges = (
            (np.arange(count + 1) - 0.5) / (count - 1) if corners else np.arange(count + 1) / count
        )
        for edge in np.clip(edges, 0.0, 1.0):
            line = np.full((_PLACES, 3 if p.faces > 1 else 2), float(face))
            line[:, axis], line[:, 1 - axis] = edge, along
            lines.append(line)
    return lines
