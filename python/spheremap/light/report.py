"""What light an image holds, in one report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._show import line
from ..map.images import images
from ..map.named import resolve
from .sources import as_sun, light_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative
    from ..map.named import ProjectionLike
    from .sources import Sun

__all__ = ["Energy", "energy"]


@dataclass(frozen=True, eq=False)
class Energy:
    """The light of an image, as `energy` reports it; `print` shows it as a readable text.

    Attributes
    ----------
    solid_angle : float
        What the image covers, in steradians; 4π for the whole sphere.
    integral : ndarray, shape (C,)
        ∫ L dω of each channel.
    mean : ndarray, shape (C,)
        The mean radiance, integral / solid_angle.
    luminance : float
        The mean luminance.
    peak : float
        The largest luminance of a texel.
    peak_direction : ndarray, shape (3,)
        Where it is, in the world.
    darkest : float
        The smallest luminance above 0; NaN if none is.
    dynamic_range : float
        log2(peak / darkest), in stops; NaN if nothing is above 0.
    negative : int
        Texels with a number below 0. They are kept in the integrals; where they are clipped there
        are none.
    sun : Sun or None
        As `sun` finds it.
    """

    solid_angle: float
    integral: NDArray[np.float64]
    mean: NDArray[np.float64]
    luminance: float
    peak: float
    peak_direction: NDArray[np.float64]
    darkest: float
    dynamic_range: float
    negative: int
    sun: Sun | None

    __repr__ = line

    def __str__(self) -> str:
        lines = [
            ("covers", f"{self.solid_angle:.4f} sr ({self.solid_angle / (4 * np.pi):.1%})"),
            ("energy", f"{_numbers(self.integral)} (∫ L dω)"),
            ("mean", f"{_numbers(self.mean)}, luminance {self.luminance:.4g}"),
            ("peak", f"luminance {self.peak:.4g} toward {_direction(self.peak_direction)}"),
            ("range", f"{self.dynamic_range:.1f} stops, down to {self.darkest:.3g}"),
        ]
        if self.negative:
            lines.append(("negative", f"{self.negative} texels, kept"))
        if self.sun is None:
            lines.append(("sun", "none"))
        else:
            degrees = self.sun.angular_diameter
            where = f"{_direction(self.sun.direction)}, {degrees:.2f}° wide"
            lines.append(("sun", f"toward {where} ({self.sun.solid_angle:.3g} sr)"))
            lines.append(("", f"irradiance {_numbers(self.sun.irradiance)}"))
        return "\n".join(f"{name:<9} {text}" for name, text in lines)


def _numbers(x: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.5g}" for value in x)


def _direction(d: NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{x + 0.0:.3f}" for x in d) + ")"


def energy(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> Energy | Any:
    """Report the light that an image holds: energy, peak, dynamic range, sun.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Linear radiance. With one more axis in front it is a batch, as for `convert`.
    projection, axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`.
    luminance, skipna
        As for `Distribution`.
    negative, any_aspect, channels_first
        As for `lights`.

    Returns
    -------
    report : Energy
        Of a batch, or with many rotations, a list of them.

    Raises
    ------
    ValueError, TypeError
        As for `lights`.

    Notes
    -----
    Every texel counts with the solid angle that it covers; what lies outside the valid image does
    not count.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.full((64, 128), 0.5)
    >>> sky[20, 40] = 4096
    >>> print(sm.light.energy(sky, "latlong"))
    covers    12.5664 sr (100.0%)
    energy    14.62 (∫ L dω)
    mean      1.1634, luminance 1.163
    peak      luminance 4096 toward (-0.772, 0.535, -0.342)
    range     13.0 stops, down to 0.5
    sun       toward (-0.772, 0.535, -0.342), 2.92° wide (0.00204 sr)
              irradiance 8.3365
    """
    p = resolve(projection, axes)
    several = images(
        image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(energy, locals(), "object")
    light = light_of(image, resolve(p, rotation=rotation), luminance, skipna, negative)
    return report(*_core.energy(*light))


def report(
    solid_angle: float,
    integral: NDArray[np.float64],
    mean: float,
    peak: float,
    peak_direction: Any,
    darkest: float,
    below: int,
    sun: Any,
) -> Energy:
    """Return a report of what the core found."""
    return Energy(
        solid_angle=solid_angle,
        integral=integral,
        mean=integral / solid_angle,
        luminance=mean,
        peak=peak,
        peak_direction=np.array(peak_direction),
        darkest=darkest,
        dynamic_range=float(np.log2(peak / darkest)),
        negative=below,
        sun=as_sun(sun),
    )
