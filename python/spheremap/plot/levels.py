"""`chain`: levels of detail in a row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._scalars import as_items, as_text
from ..map.named import resolve
from .drawing import new_figure
from .image import is_gray, limits_of, show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from numpy.typing import ArrayLike

    from ..map.named import ProjectionLike

__all__ = ["chain"]

# Wider than this for its height, levels stand one above the other.
_WIDEST = 2.5


def chain(
    images: Sequence[ArrayLike],
    /,
    projection: ProjectionLike,
    *,
    titles: Sequence[str] | None = None,
    labels: bool = False,
    exposure: float = 0.0,
    figure: Figure | SubFigure | None = None,
) -> list[Axes]:
    """Draw a chain of images, each as large as the first, by one exposure and one scale.

    Parameters
    ----------
    images : sequence of array_like
        As `spheremap.light.prefilter_chain` or `spheremap.mipmaps` gives them: images of one
        projection, of any sizes.
    projection : Projection or str
        How they map the sphere.
    titles : sequence of str, optional
        One for each; by default its number and size.
    labels : bool
        Whether to name the directions.
    exposure : float
        As for `spheremap.io.tonemap`.
    figure : matplotlib.figure.Figure or SubFigure, optional
        Where to draw.

    Returns
    -------
    axes : list of matplotlib.axes.Axes
        One for each image.

    Raises
    ------
    ValueError, TypeError
        As for `show`, for no images, and for another number of titles.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.ones((16, 32, 3), np.float32)
    >>> levels = sm.light.prefilter_chain(sky, "latlong", "latlong", size=16, levels=3, samples=16)
    >>> [ax.get_title() for ax in sm.plot.chain(levels, "latlong")]
    ['0: 16 × 32', '1: 8 × 16', '2: 4 × 8']
    """
    p = resolve(projection)
    levels = [np.asanyarray(image) for image in as_items(images, "images", "images")]
    if not levels:
        raise ValueError("Expected `images` to have at least one image.")
    spatial = 2 if p.faces == 1 else 3
    if titles is None:
        sizes = [" × ".join(map(str, level.shape[:spatial])) for level in levels]
        titles = [f"{k}: {size}" for k, size in enumerate(sizes)]
    if isinstance(titles, str):
        raise TypeError("Expected `titles` to be a sequence of str, got str.")
    words = [as_text(title, "titles") for title in as_items(titles, "titles", "str")]
    if len(words) != len(levels):
        raise ValueError(f"Expected {len(levels)} titles, one an image, got {len(words)}.")
    quantity = all(
        (level.ndim == spatial or level.shape[-1] == 1) and not is_gray(level) for level in levels
    )
    limits: tuple[float | None, float | None] = (None, None)
    if quantity:
        low, high = limits_of(levels, signed=True)
        limits = (low, high) if low < high else (low - 0.5, high + 0.5)

    rows, columns = p.shape(64)[-2:]
    aspect = columns * p.faces / rows
    if aspect > _WIDEST:
        drawn = new_figure(figure, (7, len(levels) * (7 / aspect + 0.3)))
        axes = drawn.subplots(len(levels), 1, squeeze=False)
    else:
        drawn = new_figure(figure, (2.2 * len(levels) * aspect**0.5, 2.2 / aspect**0.5 + 0.3))
        axes = drawn.subplots(1, len(levels), squeeze=False)
    for level, title, ax in zip(levels, words, axes.flat, strict=True):
        show(
            level,
            p,
            ax=ax,
            labels=labels,
            exposure=exposure,
            vmin=limits[0],
            vmax=limits[1],
            colorbar=False,
        )
        ax.set_title(title, fontsize=9)
    if quantity:
        drawn.colorbar(axes.flat[0].get_images()[0], ax=axes, shrink=0.8)
    return list(axes.flat)
