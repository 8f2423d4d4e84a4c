"""An image as a few directional lights, and its sun: found, taken out, put back."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np

from .. import _core
from .._arrays import as_doubles, spatial_axes
from .._scalars import as_number, as_text, as_whole
from .._show import line
from ..map.images import images
from ..map.named import resolve
from ..map.picture import figure
from .image import as_given_outside, as_light, coefficients

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative
    from .._projection import Projection
    from ..map.named import ProjectionLike

    Array: TypeAlias = NDArray[np.float64]
    Method: TypeAlias = Literal["median", "variance"]

__all__ = ["Light", "Lights", "Sun", "add_sun", "lights", "remove_sun", "sun"]


@dataclass(frozen=True, eq=False)
class Light:
    """One directional light.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        Toward the light, in the world, of unit length.
    irradiance : ndarray, shape (C,)
        ∫ L dω over its part of the sphere: what a surface that faces it receives.
    solid_angle : float
        That part's, in steradians.
    """

    direction: Array
    irradiance: Array
    solid_angle: float

    __repr__ = line

    @property
    def radiance(self) -> Array:
        """The mean radiance of its part of the sphere."""
        return _spread(self.irradiance, self.solid_angle)


@dataclass(frozen=True, eq=False)
class Lights:
    """Directional lights that stand for an image, brightest first; a sequence of `Light`.

    A slice of them is `Lights`.

    Attributes
    ----------
    directions : ndarray, shape (N, 3)
        As `Light.direction`.
    irradiance : ndarray, shape (N, C)
        As `Light.irradiance`; the sum is the image's ∫ L dω.
    solid_angle : ndarray, shape (N,)
        As `Light.solid_angle`; the sum is the coverage.
    """

    directions: Array
    irradiance: Array
    solid_angle: Array

    __repr__ = line

    def __len__(self) -> int:
        return len(self.directions)

    @overload
    def __getitem__(self, index: int) -> Light: ...
    @overload
    def __getitem__(self, index: slice) -> Lights: ...
    def __getitem__(self, index: int | slice) -> Light | Lights:
        parts = self.directions[index], self.irradiance[index], self.solid_angle[index]
        return Lights(*parts) if isinstance(index, slice) else Light(*parts[:2], float(parts[2]))

    def __iter__(self) -> Iterator[Light]:
        return (self[index] for index in range(len(self)))

    def _repr_html_(self) -> str:
        return _drawn(self, self.directions, self.irradiance)


@dataclass(frozen=True, eq=False)
class Sun:
    """A small bright source on a duller surround.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        Toward the middle of its light, in the world.
    solid_angle : float
        Of the disc that gives its irradiance at its peak's luminance, in steradians. For a disc
        of one brightness it is the disc's; for one in a single texel, the texel's.
    irradiance : ndarray, shape (C,)
        What it adds to its surround, ∫ (L - surround) dω, on a surface that faces it.
    surround : ndarray, shape (C,)
        The radiance around it.
    reach : float
        The angle from its brightest texel to the end of what counts as sun, in radians.
    """

    direction: Array
    solid_angle: float
    irradiance: Array
    surround: Array
    reach: float

    __repr__ = line

    @property
    def radiance(self) -> Array:
        """Its mean radiance above the surround."""
        return _spread(self.irradiance, self.solid_angle)

    @property
    def angular_diameter(self) -> float:
        """Of a disc with its solid angle, in degrees. The sun in our sky has 0.53."""
        half_chord = np.sqrt(self.solid_angle / (4 * np.pi))
        return float(np.degrees(4 * np.arcsin(min(1.0, half_chord))))

    def _repr_html_(self) -> str:
        return _drawn(self, self.direction, self.irradiance)


def _spread(irradiance: Array, solid_angle: float) -> Array:
    """Return the mean radiance over a solid angle; 0 where there is none."""
    return irradiance / solid_angle if solid_angle else irradiance * 0


def _drawn(shown: Lights | Sun, directions: Array, irradiance: Array) -> str:
    """Return lights as dots on a latlong, in HTML: as large and of the color that they are."""
    places = np.asarray(directions, np.float64).reshape(-1, 3)
    # One channel is gray, and a fourth is no color.
    light = np.nan_to_num(np.atleast_2d(np.asarray(irradiance, np.float64))).clip(0)
    color = (light if light.shape[1] >= 3 else light[:, :1].repeat(3, axis=1))[:, :3]
    strong = color.max(axis=1, keepdims=True)
    radius = 2 + 7 * np.sqrt(strong / (strong.max(initial=0) or 1))
    # Encoded as screens are: of 2.2 sRGB is near enough to tell colors by.
    shade = np.rint(255 * (color / np.where(strong > 0, strong, 1)) ** (1 / 2.2)).astype(int)
    dots = [
        (d, float(r), "#{:02x}{:02x}{:02x}".format(*rgb))
        for d, r, rgb in zip(places, radius.ravel(), shade, strict=True)
    ]
    return figure(resolve("latlong"), [repr(shown)], dots[::-1])


def light_of(
    image: ArrayLike,
    p: Projection,
    luminance: ArrayLike | None,
    skipna: bool,
    negative: Negative,
) -> tuple[NDArray[np.floating[Any]], Projection, Array]:
    """Return an image as light, its projection, and what makes luminance of its channels."""
    array = as_light(image, p, skipna=skipna, negative=negative)
    return array, p, coefficients(array, spatial_axes(p), luminance)


def lights(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    count: int,
    method: Method = "median",
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> Lights | Any:
    """Approximate an image by directional lights.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Linear radiance. With one more axis in front it is a batch, as for `convert`.
    projection, axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`.
    count : int
        How many lights, at least 1. There are fewer where the light comes from fewer places.
    method : {"median", "variance"}
        Median cut [1]_ halves the light of the brightest region, across its longer side. The
        other way [2]_ cuts the region of the largest variance where the larger variance of its
        parts is smallest; it does not cut through lamps.
    luminance, skipna
        As for `Distribution`.
    negative : {"keep", "clip", "raise"}
        What numbers below 0 count as: what they are, 0, or an error.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    lights : Lights
        Their irradiances sum to the image's ∫ L dω, negative texels included, and their solid
        angles to the coverage. Of a batch, or with many rotations, a list of them.

    Raises
    ------
    ValueError
        For a count below 1, an unknown method, NaN or infinite texels, or an unfit shape.
    TypeError
        For an unfit dtype, and a count that is no whole number.

    Notes
    -----
    Any projection will do: texels are counted, whole, into a grid of latitude and longitude with
    as many cells, at most 512×1024, and regions are rectangles of that. A light stands at the
    centroid of its region's luminance. The variance is ``∑ L ω |d - centroid|²``, d on the sphere.

    References
    ----------
    .. [1] P. Debevec, "A Median Cut Algorithm for Light Probe Sampling", SIGGRAPH 2005 posters.
    .. [2] K. Viriyothai, P. Debevec, "Variance Minimization Light Probe Sampling", SIGGRAPH 2009
       posters.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.maximum(sm.directions("latlong", 64), 0)[..., 1]
    >>> four = sm.light.lights(sky, "latlong", count=4)
    >>> len(four), bool(np.isclose(four.irradiance.sum(), np.pi, rtol=1e-3))
    (4, True)
    """
    # There are never as many as the core can count to.
    count = min(as_whole(count, "count"), sys.maxsize)
    if count < 1:
        raise ValueError(f"Expected `count` to be at least 1, got {count}.")
    if as_text(method, "method") not in ("median", "variance"):
        raise ValueError(f"unknown method {method!r}; there are 'median' and 'variance'")
    p = resolve(projection, axes)
    several = images(
        image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(lights, locals(), "object")
    light = light_of(image, resolve(p, rotation=rotation), luminance, skipna, negative)
    return Lights(*_core.lights(*light, count, method))


def as_sun(found: tuple[Any, ...] | None) -> Sun | None:
    if found is None:
        return None
    direction, solid_angle, irradiance, surround, reach = found
    return Sun(np.array(direction), solid_angle, irradiance, surround, reach)


def sun(
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
) -> Sun | Any | None:
    """Find the sun of an image: its brightest source, if that is small and far above the rest.

    Parameters
    ----------
    image, projection, axes, rotation, luminance, skipna, negative, any_aspect, channels_first
        As for `lights`.

    Returns
    -------
    sun : Sun or None
        None where the brightest texel is not 10 times brighter than what surrounds it, or its
        like reach further than 10 degrees. Of a batch, or with many rotations, a list of them.

    Raises
    ------
    ValueError, TypeError
        As for `lights`.

    Notes
    -----
    From the brightest texel outward, everything counts up to the first gap in the texels above a
    tenth of it, and one and a half texels more for its blurred edge. The surround is the median of
    a ring around that.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.full((64, 128), 0.5)
    >>> sky[20, 40] = 1000
    >>> found = sm.light.sun(sky, "latlong")
    >>> bool(np.allclose(found.direction, sm.directions("latlong", 64)[20, 40]))
    True
    """
    p = resolve(projection, axes)
    several = images(
        image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(sun, locals(), "object")
    light = light_of(image, resolve(p, rotation=rotation), luminance, skipna, negative)
    return as_sun(_core.sun(*light))


def remove_sun(
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
) -> tuple[NDArray[np.floating[Any]], Sun | Any | None]:
    """Return the image with its sun painted over by the surround, and the sun.

    Parameters
    ----------
    image, projection, axes, rotation, luminance, skipna, negative, any_aspect, channels_first
        As for `lights`.

    Returns
    -------
    image : ndarray
        A copy, float32 or float64. What it lost is the sun's irradiance.
    sun : Sun or None
        As `sun` finds it. Without one the image is as it was. Of a batch, a list of them.

    Raises
    ------
    ValueError, TypeError
        As for `lights`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.full((64, 128), 0.5)
    >>> sky[20, 40] = 1000
    >>> dull, found = sm.light.remove_sun(sky, "latlong")
    >>> float(dull.max())
    0.5
    >>> bool(np.allclose(sm.light.add_sun(dull, found, "latlong"), sky))
    True
    """
    p = resolve(projection, axes)
    several = images(
        image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(remove_sun, locals(), ("image", "object"))
    light = light_of(image, resolve(p, rotation=rotation), luminance, skipna, negative)
    result, found = _core.remove_sun(*light)
    return as_given_outside(result, image, p), as_sun(found)


def add_sun(
    image: ArrayLike,
    sun: Sun | Sequence[Sun | None] | None,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the image with a sun added: a disc of its solid angle and irradiance.

    Parameters
    ----------
    image, projection, axes, rotation, skipna, negative, any_aspect, channels_first
        As for `lights`.
    sun : Sun or None
        From `sun` or `remove_sun`, of this image or another. Its `direction` may be of any length,
        its `solid_angle` any that is not negative: a disc narrower than a texel fills the texel
        that it is in, to the same irradiance. None adds nothing. For a batch it is one, or a
        sequence with one for each image.

    Returns
    -------
    image : ndarray
        A copy, float32 or float64. What it gained is the sun's irradiance.

    Raises
    ------
    ValueError
        As for `lights`, for a direction or a solid angle that is none, and where the image does not
        cover the sun or has other channels.
    TypeError
        As for `lights`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> true = sm.light.Sun(np.array([0.0, 1.0, 0.0]), 6.8e-5, np.array([1.5]), np.zeros(1), 0.01)
    >>> sky = sm.light.add_sun(np.zeros((64, 128)), true, "latlong")
    >>> bool(np.isclose(np.vdot(sky, sm.solid_angle("latlong", 64)), 1.5))
    True
    """
    p = resolve(projection, axes)
    several = images(
        image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        own = {"sun": sun} if several.is_many and isinstance(sun, Sequence) else {}
        return several.each(add_sun, locals(), "image", **own)
    p = resolve(p, rotation=rotation)
    array = as_light(image, p, skipna=skipna, negative=negative)
    if sun is None:
        return as_given_outside(np.array(array), image, p)
    if not isinstance(sun, Sun):
        raise TypeError(f"Expected `sun` to be a Sun, got {type(sun).__name__}.")
    toward = as_doubles(sun.direction, "sun.direction")
    if toward.shape != (3,):
        raise ValueError(f"Expected `sun.direction` to have shape (3,), got {toward.shape}.")
    longest = np.abs(toward).max()
    if not 0 < longest < np.inf:
        raise ValueError(f"Expected `sun.direction` to be finite and not zero, got {toward}.")
    # Squares of the largest and the smallest have no width.
    toward = toward / longest
    toward = toward / np.linalg.norm(toward)
    solid_angle = as_number(sun.solid_angle, "sun.solid_angle")
    if not 0 <= solid_angle < np.inf:
        raise ValueError(
            f"Expected `sun.solid_angle` to be at least 0 and finite, got {solid_angle:g}."
        )
    irradiance = as_doubles(sun.irradiance, "sun.irradiance").ravel()
    result = _core.add_sun(array, p, tuple(toward.tolist()), solid_angle, irradiance.tolist())
    return as_given_outside(result, image, p)
