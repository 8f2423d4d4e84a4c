"""`packing_error`: how far a code is off, direction by direction."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from .. import packing
from ..map.named import resolve
from .drawing import drawn_shape
from .image import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..map.named import ProjectionLike
    from ..packing import Packing

__all__ = ["packing_error"]


def packing_error(
    name: str | Packing,
    /,
    projection: ProjectionLike = "latlong",
    *,
    rounding: str | None = None,
    size: int | tuple[int, ...] = 512,
    labels: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Draw a map of the error of a packing: the angle that a direction comes back off by.

    Parameters
    ----------
    name : Packing or str
        The scheme, as for `spheremap.packing.packing`.
    projection : Projection or str
        Of the map; a direction is packed for each of its texels.
    rounding : {"precise", "nearest", "hex"}, optional
        As for `spheremap.packing.pack`; by default the scheme's own.
    size : int or tuple of int
        Of the map.
    labels : bool
        Whether to name the directions.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Its title says the mean over the directions that the scheme holds, the largest, and the
        stated bound. What a hemisphere does not hold is gray.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.pack` and `spheremap.directions`.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.plot.packing_error("oct16", size=128).get_title()
    'oct16: mean 0.317°, largest 0.602°, never above 0.638°'
    """
    about, p = packing.packing(name), resolve(projection)
    shape = drawn_shape(p, size)
    d = p.directions(shape, dtype=np.float64)
    held = np.isfinite(d[..., 0]) & ((d[..., 2] >= 0) | (not about.hemisphere))
    rounding = rounding or next(
        way for way in ("precise", *about.roundings) if way in about.roundings
    )
    some = d[held]
    with warnings.catch_warnings():
        # The title says that there is no bound.
        warnings.simplefilter("ignore", packing.UnboundedPackingWarning)
        codes = packing.pack(some, about, rounding)
    back = packing.unpack(codes, about, dtype=np.float64)
    error = np.full(d.shape[:-1], np.nan)
    # Of a small angle the chord has the digits that the cosine has lost.
    chord = np.linalg.norm(back - some, axis=-1)
    error[held] = np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1)))
    ax = show(error, p, ax=ax, labels=labels, cmap="magma", vmin=0.0)
    weights = p.solid_angle(shape)[held]
    mean = float(np.average(error[held], weights=weights))
    bound = np.degrees(about.bounds[rounding])
    never = f"never above {bound:.3g}°" if np.isfinite(bound) else "without a bound"
    ax.set_title(
        f"{about.name}: mean {mean:.3g}°, largest {np.nanmax(error):.3g}°, {never}", fontsize=9
    )
    return ax
