"""What a map does to small circles and to areas."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .._scalars import as_number
from ..map.named import resolve
from .drawing import OUTSIDE, bare, drawn_shape, label, mark_valid, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["density_map", "texel_uv", "tissot"]


def tissot(
    projection: ProjectionLike,
    *,
    ax: Axes | None = None,
    radius: float = 5.0,
    step: float = 30.0,
    size: int | tuple[int, ...] = 256,
) -> Axes:
    """Draw Tissot's indicatrices: what small circles on the sphere become in the image.

    Parameters
    ----------
    projection : Projection or str
    ax : matplotlib.axes.Axes, optional
        Where to draw.
    radius : float
        Of the circles, in degrees. They are mapped by the Jacobian at their centers, so each is
        an ellipse whole on its side of a seam.
    step : float
        Between the centers, in degrees of latitude and about as much along a parallel; at most 180.
    size : int or tuple of int
        The image size to draw it at, which gives the aspect.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError, TypeError
        For a radius or step that is out of range, and a size that the projection cannot have.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import spheremap as sm
    >>> ax = sm.plot.tissot("mollweide", radius=8, step=30, size=64)
    >>> len(ax.collections[0].get_paths()) > 20
    True
    """
    radius, step = as_number(radius, "radius"), as_number(step, "step")
    if not radius > 0 or not 0 < step <= 180:
        raise ValueError(
            f"Expected `radius` above 0 and `step` in (0, 180], got {radius:g} and {step:g}."
        )
    ax = new_axes(ax)
    from matplotlib.collections import PolyCollection

    p = resolve(projection)
    height, width = drawn_shape(p, size)[-2:]
    uv = p.encode(_lattice(step))
    uv = uv[np.isfinite(uv).all(axis=-1)]
    jacobian = p.jacobian(uv)
    rows = np.swapaxes(jacobian, -1, -2)
    metric = rows @ jacobian
    # Where the map folds, a circle has no image of finite size.
    regular = np.linalg.det(np.nan_to_num(metric)) > 1e-9
    uv, metric = uv[regular], metric[regular]

    turn = np.linspace(0, 2 * np.pi, 65)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    # The square root of the inverse metric takes the unit circle to the indicatrix.
    values, vectors = np.linalg.eigh(metric)
    root = vectors @ (np.swapaxes(vectors, -1, -2) / np.sqrt(values)[..., np.newaxis])
    ellipses = np.swapaxes(np.radians(radius) * (root @ circle), -1, -2) + uv[:, np.newaxis, :2]

    faces = uv[:, 2] if p.faces > 1 else np.zeros(len(uv))
    ellipses = (ellipses + np.stack([faces, 0 * faces], axis=-1)[:, np.newaxis]) * [width, height]
    ax.add_collection(
        PolyCollection(list(ellipses), facecolors="#d0606099", edgecolors="#802020", linewidths=0.8)
    )
    mark_valid(ax, p, height, width)
    label(ax, p, width * p.faces, height)
    bare(ax, p, width, height)
    return ax


def density_map(
    projection: ProjectionLike, *, ax: Axes | None = None, size: int | tuple[int, ...] = 256
) -> Axes:
    """Draw the solid angle per unit of image area, dω/(du dv), on a logarithmic scale.

    Parameters
    ----------
    projection : Projection or str
    ax : matplotlib.axes.Axes, optional
        Where to draw.
    size : int or tuple of int
        The image size to compute it at.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError, TypeError
        For a size that the projection cannot have.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import spheremap as sm
    >>> ax = sm.plot.density_map("octahedral", size=32)
    >>> ax.get_images()[0].get_array().shape
    (32, 32)
    """
    ax = new_axes(ax)
    from matplotlib.colors import LogNorm

    p = resolve(projection)
    uv = texel_uv(p, drawn_shape(p, size))
    density = np.asarray(p.density(uv), dtype=np.float64)
    if p.faces > 1:
        density = np.concatenate(list(density), axis=1)
    height, width = density.shape
    drawable = np.isfinite(density) & (density > 0)
    low, high = np.percentile(density[drawable], (0.1, 99.9))
    # One value (an equal-area map) still needs a scale with two ends.
    middle, spread = np.sqrt(low * high), max(np.sqrt(high / low), 1.1)
    picture = ax.imshow(
        np.ma.masked_array(density, ~drawable),
        norm=LogNorm(middle / spread, middle * spread),
        extent=(0, width, height, 0),
        cmap="viridis",
    )
    ax.set_facecolor(OUTSIDE)
    bar = ax.get_figure(root=True).colorbar(picture, ax=ax, shrink=0.8)  # type: ignore[union-attr]
    bar.set_label("steradians per unit of uv area")
    ticks = np.geomspace(middle / spread, middle * spread, 5)
    bar.set_ticks(list(ticks), labels=[f"{tick:.3g}" for tick in ticks])
    bar.minorticks_off()
    bare(ax, p, width / p.faces, height)
    return ax


def _lattice(step: float) -> NDArray[np.float64]:
    """Return directions about `step` degrees apart, on parallels."""
    found = []
    for latitude in np.radians(np.arange(-90 + step / 2, 90, step)):
        count = max(3, round(360 / step * float(np.cos(latitude))))
        azimuth = (np.arange(count) + 0.5) * (2 * np.pi / count)
        ring = np.cos(latitude)
        height = np.full(count, np.sin(latitude))
        found.append(np.stack([ring * np.sin(azimuth), height, ring * np.cos(azimuth)], axis=-1))
    return np.concatenate(found)


def texel_uv(p: Projection, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return (u, v) or (u, v, face) of the centers of all texels."""
    height, width = shape[-2:]
    u = _texels(width, corners=p.grid == "corners")
    v = _texels(height, corners=p.grid in ("corners", "corners-v"))
    if p.faces == 1:
        return np.stack(np.meshgrid(u, v), axis=-1)
    face, row, column = np.meshgrid(np.arange(p.faces), v, u, indexing="ij")
    return np.stack([column, row, face], axis=-1)


def _texels(count: int, *, corners: bool) -> NDArray[np.float64]:
    if corners:
        return np.linspace(0.0, 1.0, count)
    return (np.arange(count) + 0.5) / count
