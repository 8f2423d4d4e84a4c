"""Sums over the sphere: the light of an image, its mean, its center, its errors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._arrays import as_array, checked_image, has_channels, spatial_axes
from .._scalars import as_flag, as_number
from ..map.images import channels_last, images, target_shape
from ..map.named import resolve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative, Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["average_direction", "integrate", "mean", "weights", "ws_psnr"]


def weights(
    projection: ProjectionLike,
    size: Size,
    *,
    normalized: bool = False,
    any_aspect: bool = False,
) -> NDArray[np.float64]:
    """Return the weight of each texel in an integral over the sphere: dω = sin θ dθ dφ.

    ``(weights * image).sum()`` is the integral of the image, and ``(weights * error**2).sum()``
    a loss that counts every part of the sphere by its size.

    Parameters
    ----------
    projection, size
        As for `solid_angle`.
    normalized : bool
        Divide by the covered solid angle, so that the weights sum to 1 and sums are means.
    any_aspect : bool
        As for `convert`, of a size with all its sides.

    Returns
    -------
    weights : ndarray of float64, the image's shape without channels
        In steradians. It is `solid_angle`, but for texels across the rim of a disk whose center
        lies outside: they hold no value, and their part counts with the nearest texel that does.

    Raises
    ------
    ValueError, TypeError
        As for `solid_angle`.

    Examples
    --------
    A mean squared error on the sphere:

    >>> import numpy as np, spheremap as sm
    >>> a = sm.directions("latlong", 64)[..., 1]
    >>> w = sm.light.weights("latlong", 64, normalized=True)
    >>> round(float(np.sum(w * a**2)), 3)
    0.333
    """
    resolved = resolve(projection)
    found = _core.texel_weights(resolved, target_shape(resolved, size, any_aspect))
    return found / resolved.covered_solid_angle if as_flag(normalized, "normalized") else found


def integrate(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.float64]:
    """Integrate an image over the sphere: ∫ L dω.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Radiance, or anything else per direction. With one more axis in front it is a batch, as for
        `convert`.
    projection : Projection or str
        How the image maps the sphere.
    skipna : bool
        Count NaN and infinite values as 0 instead of raising.
    negative : {"keep", "clip", "raise"}
        What numbers below 0 count as: what they are, 0, or an error.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    integral : ndarray of float64, shape () or (C,), or (N, C) of a batch
        Sums run in float64 over exact solid angles (`weights`), in an order that depends on the
        shape alone. What a partial coverage does not hold counts as 0.

    Raises
    ------
    ValueError
        For a shape that the projection cannot have, or values that are not finite.
    TypeError
        For an unsupported dtype.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> float(sm.light.integrate(np.ones((64, 128)), "latlong") / np.pi)
    4.0
    """
    resolved = resolve(projection)
    several = images(image, resolved, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        return several.each(integrate, locals(), "numbers")
    pixels = checked_image(image, resolved, skipna=skipna, negative=negative)
    return _shaped(_core.integrals(pixels, resolved)[:-1], pixels, resolved)


def mean(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.float64]:
    """Average an image over the part of the sphere that it covers.

    Parameters
    ----------
    image, projection, negative, any_aspect, channels_first
        As for `integrate`.
    skipna : bool
        Average over the finite values alone, channel by channel.

    Returns
    -------
    mean : ndarray of float64, shape () or (C,), or (N, C) of a batch

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    The plain average of a latlong counts its poles too much:

    >>> import numpy as np, spheremap as sm
    >>> up = np.abs(sm.directions("latlong", 64)[..., 1])
    >>> float(up.mean().round(3)), float(sm.light.mean(up, "latlong").round(3))
    (0.637, 0.5)
    """
    resolved = resolve(projection)
    several = images(image, resolved, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        return several.each(mean, locals(), "numbers")
    pixels = checked_image(
        image, resolved, skipna=skipna, negative=negative, skipping="leaves them out"
    )
    integrals = _core.integrals(pixels, resolved)
    total: Any = integrals[-1]
    if skipna and pixels.dtype.kind == "f":
        finite = np.isfinite(np.asarray(image)).astype(np.float32)
        total = _core.integrals(finite, resolved)[:-1]
    with np.errstate(invalid="ignore"):
        return _shaped(integrals[:-1] / total, pixels, resolved)


def average_direction(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.float64]:
    """Return where the light comes from on average: ∫ L ω dω / ∫ L dω.

    Parameters
    ----------
    image, projection, skipna, negative, any_aspect, channels_first
        As for `integrate`.
    axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`.

    Returns
    -------
    direction : ndarray of float64, shape (3,) or (C, 3), or (N, C, 3) of a batch
        Of a length between 0, for light that is the same from all sides, and 1, for a point.
        NaN where the integral is 0.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.maximum(sm.directions("latlong", 64)[..., 1], 0)
    >>> np.round(sm.light.average_direction(sky, "latlong") + 0.0, 3).tolist()
    [0.0, 0.667, 0.0]
    """
    resolved = resolve(projection, axes)
    several = images(
        image, resolved, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(average_direction, locals(), "numbers")
    resolved = resolve(resolved, rotation=rotation)
    pixels = checked_image(image, resolved, skipna=skipna, negative=negative)
    moments = _core.moments(pixels, resolved)[:-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        vectors: NDArray[np.float64] = moments[:, 1:] / moments[:, :1]
    return vectors if has_channels(pixels, resolved) else vectors[0]


def ws_psnr(
    image: ArrayLike,
    reference: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    peak: float | None = None,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> float | Any:
    """Return the weighted-to-spherically-uniform peak signal-to-noise ratio, in decibels.

    Parameters
    ----------
    image, reference : array_like
        As for `integrate`, of one shape.
    projection : Projection or str
        Of both.
    peak : float, optional
        The largest possible value of both: by default that of the integer type, or 1 for floats.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    psnr : float, or ndarray of float64, shape (N,), of two batches
        10 log10(peak² / MSE), the squared error averaged over channels and, by solid angle, over
        the sphere. Infinite for equal images.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`, and for two shapes, or two dtypes whose largest values differ without
        `peak`.

    Notes
    -----
    Sun, Lu and Yu 2017, with exact solid angles in place of the cosine of the latitude.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> round(sm.light.ws_psnr(np.full((8, 16), 0.5), np.full((8, 16), 0.6), "latlong"), 6)
    20.0
    """
    p = resolve(projection)
    several = images(image, p, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        against = as_array(reference, "reference")
        if channels_first:
            against = channels_last(against, spatial_axes(p))
        _expect_one_shape(several.array, against)
        own = {"reference": against} if several.is_many else {}
        reference = against
        return several.each(ws_psnr, locals(), "numbers", **own)
    a = checked_image(image, p, skipping=None)
    b = checked_image(reference, p, name="reference", skipping=None)
    _expect_one_shape(a, b)
    if peak is None:
        peak = _common_peak(a.dtype, b.dtype)
    elif not (0 < as_number(peak, "peak") < math.inf):
        raise ValueError(f"`peak` must be above 0 and finite, got {peak}.")
    # Differences beyond the squares that float64 holds are infinite.
    with np.errstate(over="ignore", invalid="ignore"):
        squared = np.square(a.astype(np.float64) - b.astype(np.float64))
    error = float(np.mean(mean(squared, p, any_aspect=True)))
    return math.inf if error == 0 else 20.0 * math.log10(peak) - 10.0 * math.log10(error)


def _common_peak(a: np.dtype[Any], b: np.dtype[Any]) -> float:
    """Return the largest value of two images, or raise where they have two."""
    first, second = (float(np.iinfo(t).max) if t.kind == "u" else 1.0 for t in (a, b))
    if first != second:
        raise TypeError(
            "Expected `image` and `reference` of one dtype, or `peak`, the largest value of both, "
            f"got {a} and {b}."
        )
    return first


def _expect_one_shape(a: NDArray[Any], b: NDArray[Any]) -> None:
    if a.shape != b.shape:
        raise ValueError(f"Expected two images of one shape, got {a.shape} and {b.shape}.")


def _shaped(
    values: NDArray[np.float64], image: NDArray[Any], projection: Projection
) -> NDArray[np.float64]:
    return values if has_channels(image, projection) else values.reshape(())
