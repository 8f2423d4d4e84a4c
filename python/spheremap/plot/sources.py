"""`lights`: where the light of an image comes from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._scalars import as_items
from .._srgb import encoded
from ..light.image import REC709
from ..light.sources import Light, Lights, Sun
from ..light.sources import lights as found_lights
from ..light.sources import sun as found_sun
from ..map.named import resolve
from .drawing import expect_image, places
from .image import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from ..map.named import ProjectionLike

__all__ = ["lights"]

# Points across: of the strongest light, and what each has at least.
_LARGEST, _SMALLEST = 18.0, 3.0


def lights(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    lights: Lights | Light | Sun | Sequence[Light | Sun] | None = None,
    count: int = 16,
    exposure: float | None = 0.0,
    labels: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Show an image with its lights and its sun.

    A light is a disk whose area is its irradiance, in the color that it has. The sun is a ring.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Linear radiance.
    projection : Projection or str
        How the image maps the sphere.
    lights : Lights, Light, Sun, or a sequence of these, optional
        What is drawn; by default what `spheremap.light.lights` and `spheremap.light.sun` find.
    count : int
        How many lights to find, where none are given.
    exposure : float or None
        As for `spheremap.io.tonemap`.
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
        As for `show` and `spheremap.light.lights`; for what is no light.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.full((32, 64, 3), 0.2, np.float32)
    >>> sky[8, 20] = 500
    >>> ax = sm.plot.lights(sky, "latlong", count=4)
    >>> len(ax.lines)
    5
    """
    p = resolve(projection)
    expect_image(p, np.shape(image))
    if lights is None:
        sun = found_sun(image, p)
        drawn = [*found_lights(image, p, count=count), *([] if sun is None else [sun])]
    elif isinstance(lights, Light | Sun):
        drawn = [lights]
    else:
        drawn = list(as_items(lights, "lights", "lights"))
    for light in drawn:
        if not isinstance(light, Light | Sun):
            raise TypeError(f"Expected `lights` to be of Light or Sun, got {type(light).__name__}.")
    # What has one channel is gray light, which `show` would take for a quantity.
    pixels = np.asanyarray(image)
    if pixels.ndim == (2 if p.faces == 1 else 3):
        pixels = pixels[..., np.newaxis]
    if pixels.shape[-1] < 3:
        pixels = np.repeat(pixels[..., :1], 3, axis=-1)
    ax = show(pixels, p, ax=ax, labels=labels, exposure=exposure)
    width, height = float(ax.get_xlim()[1]), float(ax.get_ylim()[0])
    strongest = max((_strength(light) for light in drawn if isinstance(light, Light)), default=0.0)
    for light in drawn:
        x, y, _ = places(p, np.asarray(light.direction, np.float64), width, height)
        if not np.isfinite([x, y]).all():
            continue
        (point,) = ax.plot([float(x)], [float(y)], "o")
        if isinstance(light, Sun):
            point.set(markersize=_LARGEST + 6, markerfacecolor="none")
            point.set(markeredgecolor="#ffd000", markeredgewidth=2.0)
        else:
            part = _strength(light) / strongest if strongest else 1.0
            point.set(markersize=max(_SMALLEST, _LARGEST * part**0.5))
            point.set(markerfacecolor=_color(light), markeredgecolor="black")
    return ax


def _strength(light: Light | Sun) -> float:
    """Return the luminance of what a light gives."""
    return float(_three(light) @ np.array(REC709))


def _color(light: Light) -> tuple[float, float, float]:
    """Return the hue of a light, as bright as a screen shows it."""
    light_of = _three(light)
    red, green, blue = encoded(light_of / (light_of.max() or 1.0)).tolist()
    return red, green, blue


def _three(light: Light | Sun) -> NDArray[np.float64]:
    """Return irradiance in three channels: one is gray, and a fourth is no color."""
    given = np.nan_to_num(np.atleast_1d(np.asarray(light.irradiance, np.float64))).clip(0)
    return given[:3] if len(given) >= 3 else given[:1].repeat(3)
