"""Pictures of projections, by matplotlib: `pip install spheremap[plot]`.

Each function draws into `ax`, or into new axes of pyplot, and returns the axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._scalars import as_number
from .io.tonemap import tonemap
from .map.named import resolve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from numpy.typing import ArrayLike, NDArray

    from ._projection import Projection
    from .map.named import ProjectionLike

__all__ = ["density_map", "show", "tissot"]


def __dir__() -> list[str]:
    return __all__


_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
_OUTSIDE = (0.85, 0.85, 0.85)
_MISSING = (0.55, 0.55, 0.55)
# Of these one channel is a gray picture.
_GRAYS = (np.uint8, np.uint16)


def show(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    ax: Axes | None = None,
    labels: bool = True,
    mask: bool = True,
    exposure: float | None = 0.0,
    cmap: str | Colormap | None = None,
    vmin: float | None = None,
    vmax: float | None = None,
    colorbar: bool = True,
    graticule: float | None = None,
) -> Axes:
    """Show an image with the directions ±x, ±y, ±z where they land.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Colors: floats of several channels are linear light and are tone-mapped
        (`spheremap.io.tonemap`); uint8 and uint16 are shown as they are. One channel of any other
        dtype is a quantity, and so is one of these with `cmap`, `vmin` or `vmax`: it is shown by a
        color map, never tone-mapped. Faces stand in a row.
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
    cmap : str or matplotlib.colors.Colormap, optional
        Of a quantity. By default ``"RdBu_r"`` where its limits lie on both sides of 0, which is
        white, else ``"viridis"``. What is masked or not finite is gray.
    vmin, vmax : float, optional
        The quantity's limits: by default its smallest and largest value, and where those have
        different signs and `cmap` is not given, the larger of both either way.
    colorbar : bool
        Whether a quantity has one.
    graticule : float, optional
        Degrees between parallels, and between meridians, with their labels. Longitude 0 lies ahead
        in the projection's world; it grows to the right, or to the left in a right-handed world
        with +z up, as it does on the sky.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError
        For an image that the projection cannot have, limits that are none, and a `graticule` that
        is not above 0 and at most 90.
    TypeError
        For an image of another dtype.
    ImportError
        If matplotlib is missing.
    """
    ax = _axes(ax)
    p = resolve(projection)
    pixels = np.asanyarray(image)
    spatial = 2 if p.faces == 1 else 3
    if pixels.ndim not in (spatial, spatial + 1):
        raise ValueError(
            f"Expected `image` to have {spatial} or {spatial + 1} dimensions for "
            f"{p.name!r}, got shape {pixels.shape}."
        )
    if graticule is not None:
        graticule = as_number(graticule, "graticule")
        if not 0 < graticule <= 90:
            raise ValueError(f"`graticule` must be in (0, 90], got {graticule:g}.")
    shape = p.shape(pixels.shape[:spatial])
    outside = ~np.isfinite(p.directions(shape, dtype=np.float32)[..., 0]) if mask else None
    if p.faces > 1:
        pixels = np.ma.concatenate(list(pixels), axis=1)  # type: ignore[no-untyped-call]
        outside = None if outside is None else np.concatenate(list(outside), axis=1)
    height, width = pixels.shape[:2]

    single = pixels.ndim == 2 or pixels.shape[2] == 1
    asked = any(option is not None for option in (cmap, vmin, vmax))
    if single and (asked or pixels.dtype not in _GRAYS):
        values = pixels if pixels.ndim == 2 else pixels[..., 0]
        _quantity(ax, values, outside, cmap, (vmin, vmax), colorbar)
    else:
        picture = _rgb(np.asarray(pixels), exposure)
        if outside is not None:
            picture[outside] = np.rint(np.array(_OUTSIDE) * 255)
        ax.imshow(picture, extent=(0, width, height, 0), interpolation="antialiased")
    if graticule is not None:
        _graticule(ax, p, graticule, width, height)
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


def _quantity(
    ax: Axes,
    values: NDArray[Any],
    outside: NDArray[np.bool_] | None,
    cmap: str | Colormap | None,
    limits: tuple[float | None, float | None],
    colorbar: bool,
) -> None:
    """Draw numbers by a color map."""
    import matplotlib as mpl
    from matplotlib.colors import Normalize

    if values.dtype.kind not in "fiub":
        raise TypeError(f"Expected `image` to be real numbers, got dtype {values.dtype}.")
    known = np.ma.masked_invalid(np.ma.asarray(values, np.float64))
    if outside is not None:
        known = np.ma.masked_where(outside, known)
    drawn = known.compressed()
    low, high = (
        float(end) if given is None else as_number(given, name)
        for given, name, end in (
            (limits[0], "vmin", drawn.min() if drawn.size else 0.0),
            (limits[1], "vmax", drawn.max() if drawn.size else 1.0),
        )
    )
    if limits == (None, None):
        if low < 0 < high and cmap is None:
            low, high = -max(-low, high), max(-low, high)
        elif low == high:
            # One value still needs a scale with two ends.
            low, high = low - 0.5, high + 0.5
    if not (np.isfinite([low, high]).all() and low < high):
        raise ValueError(f"`vmin` must be less than `vmax`, got {low:g} and {high:g}.")
    if cmap is None:
        cmap = "RdBu_r" if low < 0 < high else "viridis"
    try:
        colors = mpl.colormaps[cmap] if isinstance(cmap, str) else cmap
    except KeyError:
        raise ValueError(f"matplotlib has no color map {cmap!r:.40}.") from None
    height, width = values.shape
    picture = ax.imshow(
        known,
        norm=Normalize(low, high),
        cmap=colors.with_extremes(bad=_MISSING),
        extent=(0, width, height, 0),
        interpolation="nearest",
    )
    if outside is not None and outside.any():
        cover = np.zeros((height, width, 4))
        cover[outside] = (*_OUTSIDE, 1.0)
        ax.imshow(cover, extent=(0, width, height, 0), interpolation="nearest")
    if colorbar:
        ax.get_figure(root=True).colorbar(picture, ax=ax, shrink=0.8)  # type: ignore[union-attr]


def _graticule(ax: Axes, p: Projection, step: float, width: float, height: float) -> None:
    """Draw parallels and meridians, and say which they are."""
    from matplotlib.collections import LineCollection
    from matplotlib.patheffects import withStroke

    right, up, ahead = (_axis(name) for name in p.world.split())
    # As on the sky: right-handed, its longitude grows to the left.
    sky = up[2] == 1 and np.linalg.det([right, up, -ahead]) > 0
    east = -right if sky else right

    def places(longitude: ArrayLike, latitude: ArrayLike) -> NDArray[np.float64]:
        a, b = np.broadcast_arrays(np.radians(longitude), np.radians(latitude))
        a, b = a[..., None], b[..., None]
        d = np.cos(b) * (np.cos(a) * ahead + np.sin(a) * east) + np.sin(b) * up
        uv = p.encode(d)
        face = uv[..., 2] if p.faces > 1 else np.zeros(uv.shape[:-1])
        return np.stack([(face + uv[..., 0]) / p.faces * width, uv[..., 1] * height, face], -1)

    parallels = np.arange(-(np.ceil(90 / step) - 1) * step, 90, step)
    meridians = np.arange(0, 360 - step / 2, step)
    lines = [places(np.linspace(0, 360, 1441), latitude) for latitude in parallels]
    lines += [places(longitude, np.linspace(-90, 90, 721)) for longitude in meridians]
    pieces = []
    for line in lines:
        jump = np.abs(np.diff(line[:, :2], axis=0)) > 0.05 * np.array([width / p.faces, height])
        broken = jump.any(-1) | (np.diff(line[:, 2]) != 0) | ~np.isfinite(line[1:, 0])
        parts = np.split(line[:, :2], np.flatnonzero(broken) + 1)
        pieces += [part for part in parts if len(part) > 1 and np.isfinite(part).all()]
    ax.add_collection(LineCollection(pieces, colors="black", linewidths=0.5, alpha=0.6, zorder=1.5))
    whole = 360 if sky else 180
    marks = [(0.0, latitude, f"{latitude:g}°") for latitude in parallels if latitude]
    marks += [(x, 0.0, f"{x if x <= whole else x - 360:g}°") for x in meridians]
    for longitude, latitude, text in marks:
        x, y, _ = places(longitude, latitude)
        if np.isfinite([x, y]).all():
            # Beside the right edge it would hang outside.
            left = x > 0.97 * width
            ax.annotate(
                text,
                (float(x), float(y)),
                (-3 if left else 3, 3),
                textcoords="offset points",
                fontsize=7,
                horizontalalignment="right" if left else "left",
                path_effects=[withStroke(linewidth=2, foreground="white")],
            )


def _axis(name: str) -> NDArray[np.float64]:
    """Return the unit vector that is called "+x" and so on."""
    vector = np.zeros(3)
    vector["xyz".index(name[1])] = 1 if name[0] == "+" else -1
    return vector


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
