"""Pictures of projections, by matplotlib: `pip install spheremap[plot]`.

Each function draws into `ax`, or into new axes of pyplot, and returns the axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .io.tonemap import tonemap
from .map.named import resolve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from ._projection import Projection
    from .map.named import ProjectionLike

__all__ = ["density_map", "show", "tissot"]


def __dir__() -> list[str]:
    return __all__


_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
_OUTSIDE = (0.85, 0.85, 0.85)


def show(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    ax: Axes | None = None,
    labels: bool = True,
    mask: bool = True,
    exposure: float | None = 0.0,
) -> Axes:
    """Show an image with the directions ±x, ±y, ±z where they land.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Floats are linear light and are tone-mapped (`spheremap.io.tonemap`); uint8 and uint16
        are shown as they are. Faces stand in a row.
    projection : Projection or str
        How the image maps the sphere.
    ax : matplotlib.axes.Axes, optional
        Where to draw.
    labels : bool
        Whether to name the directions.
    mask : bool
        Whether to gray out what holds no sphere.
    exposure : float or None
        As for `spheremap.io.tonemap`.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError
        For an image that the projection cannot have.
    ImportError
        If matplotlib is missing.
    """
    ax = _axes(ax)
    p = resolve(projection)
    pixels = np.asarray(image)
    spatial = 2 if p.faces == 1 else 3
    if pixels.ndim not in (spatial, spatial + 1):
        raise ValueError(
            f"Expected `image` to have {spatial} or {spatial + 1} dimensions for "
            f"{p.name!r}, got shape {pixels.shape}."
        )
    shape = p.shape(pixels.shape[:spatial])
    outside = ~np.isfinite(p.directions(shape, dtype=np.float32)[..., 0]) if mask else None
    if p.faces > 1:
        pixels = np.concatenate(list(pixels), axis=1)
        outside = None if outside is None else np.concatenate(list(outside), axis=1)

    picture = _rgb(pixels, exposure)
    if outside is not None:
        picture[outside] = np.rint(np.array(_OUTSIDE) * 255)
    height, width = picture.shape[:2]
    ax.imshow(picture, extent=(0, width, height, 0), interpolation="antialiased")
    if labels:
        _label(ax, p, width, height)
    _bare(ax, p, width / p.faces, height)
    return ax


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
        Between the centers, in degrees of latitude and about as much along a parallel.
    size : int or tuple of int
        The image size to draw it at, which gives the aspect.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError
        For a radius or step that is not positive.
    ImportError
        If matplotlib is missing.
    """
    if not radius > 0 or not step > 0:
        raise ValueError(f"`radius` and `step` must be positive, got {radius} and {step}.")
    ax = _axes(ax)
    from matplotlib.collections import PolyCollection

    p = resolve(projection)
    height, width = p.shape(size)[-2:]
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
    _mark_valid(ax, p, height, width)
    _label(ax, p, width * p.faces, height)
    _bare(ax, p, width, height)
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
    ImportError
        If matplotlib is missing.
    """
    ax = _axes(ax)
    from matplotlib.colors import LogNorm

    p = resolve(projection)
    uv = _texel_uv(p, p.shape(size))
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
    ax.set_facecolor(_OUTSIDE)
    bar = ax.get_figure(root=True).colorbar(picture, ax=ax, shrink=0.8)  # type: ignore[union-attr]
    bar.set_label("steradians per unit of uv area")
    ticks = np.geomspace(middle / spread, middle * spread, 5)
    bar.set_ticks(list(ticks), labels=[f"{tick:.3g}" for tick in ticks])
    bar.minorticks_off()
    _bare(ax, p, width / p.faces, height)
    return ax


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError(
            "plots need matplotlib: pip install spheremap[plot]", name="matplotlib"
        ) from None
    return plt.subplots(layout="constrained")[1]


def _rgb(image: NDArray[Any], exposure: float | None) -> NDArray[np.uint8]:
    if image.dtype.kind == "f":
        picture = tonemap(image, exposure=exposure)
    elif image.dtype == np.uint16:
        picture = ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)
    elif image.dtype == np.uint8:
        picture = image
    else:
        raise TypeError(f"Expected `image` to be uint8, uint16 or floats, got {image.dtype}.")
    if picture.ndim == 2:
        picture = picture[..., np.newaxis]
    if picture.shape[-1] < 3:
        picture = np.repeat(picture[..., :1], 3, axis=-1)
    return picture[..., :3].copy()


def _label(ax: Axes, p: Projection, width: float, height: float) -> None:
    from matplotlib.patheffects import withStroke

    for i, name in enumerate(_AXES):
        direction = np.zeros(3)
        direction[i // 2] = 1 - 2 * (i % 2)
        uv = p.encode(direction)
        if not np.isfinite(uv).all():
            continue
        face = uv[2] if p.faces > 1 else 0.0
        # At the very edge a label would hang half outside.
        x = np.clip((face + uv[0]) / p.faces, 0.03, 0.97) * width
        y = np.clip(uv[1], 0.03, 0.97) * height
        ax.text(
            float(x),
            float(y),
            name,
            color="white",
            fontsize=9,
            fontweight="bold",
            horizontalalignment="center",
            verticalalignment="center",
            path_effects=[withStroke(linewidth=2.5, foreground="black")],
        )


def _mark_valid(ax: Axes, p: Projection, height: int, width: int) -> None:
    shape = (height, width) if p.faces == 1 else (p.faces, height, width)
    held = np.isfinite(p.directions(shape, dtype=np.float32)[..., 0])
    if p.faces > 1:
        held = np.concatenate(list(held), axis=1)
    ax.imshow(
        np.where(held[..., np.newaxis], 1.0, _OUTSIDE),
        extent=(0, held.shape[1], held.shape[0], 0),
        zorder=0,
    )


def _bare(ax: Axes, p: Projection, face_width: float, height: float) -> None:
    for face in range(1, p.faces):
        ax.axvline(face * face_width, color="gray", linewidth=0.8)
    ax.set(xlim=(0, face_width * p.faces), ylim=(height, 0), xticks=[], yticks=[])
    ax.set_aspect("equal")
    for spine in ax.spines.values():
        spine.set(color="gray", linewidth=0.5)


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


def _texel_uv(p: Projection, shape: tuple[int, ...]) -> NDArray[np.float64]:
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
