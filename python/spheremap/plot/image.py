"""`show`: an image with the directions where they land."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array
from .._scalars import as_flag, as_number, as_text
from ..map.named import resolve
from .drawing import OUTSIDE, bare, expect_image, imported, label, new_axes, rgb
from .graticule import draw_graticule

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from numpy.typing import ArrayLike, NDArray

    from ..map.named import ProjectionLike

__all__ = ["is_gray", "limits_of", "show"]

_MISSING = (0.55, 0.55, 0.55)
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
        For an image of another dtype, and options that are no axes, numbers, words or flags.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> ax = sm.plot.show(np.ones((32, 64, 3), np.float32), "latlong", graticule=30)
    >>> sorted(text.get_text() for text in ax.texts)[:3]
    ['+x', '+y', '+z']
    """
    labels, mask = as_flag(labels, "labels"), as_flag(mask, "mask")
    colorbar = as_flag(colorbar, "colorbar")
    colors, limits = _color_map(cmap), _limits(vmin, vmax)
    p = resolve(projection)
    pixels = np.asanyarray(image)
    spatial = 2 if p.faces == 1 else 3
    if pixels.ndim not in (spatial, spatial + 1):
        raise ValueError(
            f"Expected `image` to have {spatial} or {spatial + 1} dimensions for "
            f"{p.name!r}, got shape {pixels.shape}."
        )
    expect_image(p, pixels.shape)
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

    # What cannot be drawn leaves no figure behind.
    ax = new_axes(ax)
    single = pixels.ndim == 2 or pixels.shape[2] == 1
    asked = any(option is not None for option in (colors, *limits))
    if single and (asked or not is_gray(pixels)):
        values = pixels if pixels.ndim == 2 else pixels[..., 0]
        _quantity(ax, values, outside, colors, limits, colorbar)
    else:
        picture = rgb(as_array(pixels, "image"), exposure)
        if outside is not None:
            picture[outside] = np.rint(np.array(OUTSIDE) * 255)
        ax.imshow(picture, extent=(0, width, height, 0), interpolation="antialiased")
    if graticule is not None:
        draw_graticule(ax, p, graticule, width, height, named=labels)
    if labels:
        label(ax, p, width, height)
    bare(ax, p, width / p.faces, height)
    return ax


def is_gray(pixels: NDArray[Any]) -> bool:
    """Whether one channel of these is a gray picture."""
    return pixels.dtype in _GRAYS


def limits_of(images: Iterable[NDArray[Any]], *, signed: bool) -> tuple[float, float]:
    """Return the smallest and the largest of what is finite, or 0 and 1.

    With `signed`, where one is below 0 and the other above: the larger of both either way.
    """
    known = [np.ma.masked_invalid(image).compressed() for image in images]
    known = [values for values in known if values.size]
    low = float(min((values.min() for values in known), default=0.0))
    high = float(max((values.max() for values in known), default=1.0))
    if signed and low < 0 < high:
        low, high = -max(-low, high), max(-low, high)
    return low, high


def _color_map(cmap: str | Colormap | None) -> Colormap | None:
    """Return a color map by its name, one that was given, or None."""
    if cmap is None or isinstance(cmap, imported("matplotlib.colors").Colormap):
        return cmap
    try:
        found: Colormap = imported("matplotlib").colormaps[as_text(cmap, "cmap")]
        return found
    except KeyError:
        raise ValueError(f"matplotlib has no color map {cmap!r:.40}.") from None


def _limits(vmin: float | None, vmax: float | None) -> tuple[float | None, float | None]:
    """Return the limits that were given as floats, or raise for what is none."""
    low, high = (
        None if given is None else as_number(given, name)
        for given, name in ((vmin, "vmin"), (vmax, "vmax"))
    )
    for given, name in ((low, "vmin"), (high, "vmax")):
        if given is not None and not np.isfinite(given):
            raise ValueError(f"Expected `{name}` to be finite, got {given:g}.")
    if low is not None and high is not None:
        _expect_rising(low, high)
    return low, high


def _expect_rising(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"`vmin` must be less than `vmax`, got {low:g} and {high:g}.")


def _quantity(
    ax: Axes,
    values: NDArray[Any],
    outside: NDArray[np.bool_] | None,
    colors: Colormap | None,
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
    ends = limits_of([known], signed=limits == (None, None) and colors is None)
    low, high = (end if given is None else given for given, end in zip(limits, ends, strict=True))
    if limits == (None, None) and low == high:
        # One value still needs a scale with two ends.
        low, high = low - 0.5, high + 0.5
    _expect_rising(low, high)
    if colors is None:
        colors = mpl.colormaps["RdBu_r" if low < 0 < high else "viridis"]
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
        cover[outside] = (*OUTSIDE, 1.0)
        ax.imshow(cover, extent=(0, width, height, 0), interpolation="nearest")
    if colorbar:
        ax.get_figure(root=True).colorbar(picture, ax=ax, shrink=0.8)  # type: ignore[union-attr]
