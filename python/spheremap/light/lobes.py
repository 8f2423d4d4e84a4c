"""An image seen through a lobe about each direction: irradiance, cones, glossy reflections."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .._arrays import as_unit_vectors, checked_image, has_channels, result_dtype
from .._scalars import as_text
from ..map.images import images, target_shape
from ..map.named import resolve, resolve_pair
from ..sh import LOBES, as_order, lobe_parameter
from ..sh import convolve as sh_convolve
from ..sh import evaluate as sh_evaluate
from ..sh import project as sh_project

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative, Size
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["convolve", "irradiance", "irradiance_at"]

Lobe = Literal["cone", "phong", "vmf"]


def irradiance(
    image: ArrayLike,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size = 32,
    rotation: Any | None = None,
    method: Literal["exact", "sh"] = "exact",
    order: int = 8,
    skipna: bool = False,
    world: Worlds = "match",
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the irradiance of a surface for every normal: E(n) = ∫ L max(0, n·ω) dω.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Radiance. With one more axis in front it is a batch, as for `convert`.
    src, dst : Projection or str
        The maps of the image and of the result.
    size : int or tuple of int
        Of the result, as for `solid_angle`.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the world, as for `convert`.
    method : {"exact", "sh"}
        The sum over all texels, or spherical harmonics up to `order`.
    order : int
        For "sh": with Φ = ∫|L| dω the result is within 0.094 Φ of the exact one at order 2,
        0.059 Φ at 4, 0.034 Φ at 8 and 0.0183 Φ at 16 (a single sun reaches that; skies stay
        far below).
    skipna : bool
        Count NaN and infinite values as 0 instead of raising.
    world : {"match", "literal"}
        Whether what is up in the world of `src` is so in that of `dst`, as for `convert`.
    negative : {"keep", "clip", "raise"}
        What numbers below 0 count as: what they are, 0, or an error.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    irradiance : ndarray, shape of `dst` (+ channels), and a batch of a batch
        float32 for float16 and float32 images, else float64; summed in float64. Divided by π it
        is what a white Lambertian surface sends back. 0 outside the valid image of `dst`.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`, and for an order that is no whole number from 0 to 64.

    Notes
    -----
    Each texel counts with its exact solid angle at the direction of its center. On images of the
    whole sphere the sum is divided by the same sum of a constant 1 and multiplied by π: a constant
    L gives πL at any size. What a partial coverage does not hold is black. The best results with
    "sh" are those of a smooth environment, in a hundredth of the time.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> white = np.ones((64, 128, 3), np.float32)
    >>> E = sm.light.irradiance(white, "latlong", "cube", size=8)
    >>> E.shape, float(np.abs(E - np.pi).max()) < 1e-6
    ((6, 8, 8, 3), True)
    """
    if as_text(method, "method") not in ("exact", "sh"):
        raise ValueError(f"Expected `method` to be 'exact' or 'sh', got {method!r}.")
    order = as_order(order)
    several = images(
        image,
        resolve(src),
        any_aspect=any_aspect,
        channels_first=channels_first,
        rotation=rotation,
    )
    if several is not None:
        target_shape(resolve(dst), size, any_aspect)
        return several.each(irradiance, locals())
    source, target = resolve_pair(src, dst, rotation, world)
    shape = target_shape(target, size, any_aspect)
    pixels = checked_image(image, source, skipna=skipna, negative=negative)
    if method == "exact":
        return lobe_image(pixels, source, target, shape, "cosine", 0.0)
    coefficients = sh_project(pixels, source, order=order, any_aspect=True)
    return _as_result(seen_by(coefficients, target, shape), pixels)


def irradiance_at(
    image: ArrayLike,
    normals: ArrayLike,
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
    """Return the irradiance of surfaces with these normals, as exactly as `irradiance`.

    Parameters
    ----------
    image, skipna, negative, any_aspect, channels_first
        As for `irradiance`.
    normals : array_like, shape (..., 3)
        World directions of any length.
    projection : Projection or str
        The map of the image.
    axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`.

    Returns
    -------
    irradiance : ndarray, shape (...) or (..., C), or (N, ..., C) of a batch
        NaN for a normal that is zero or not finite.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = (sm.directions("latlong", 64)[..., 1] > 0).astype(float)
    >>> np.round(sm.light.irradiance_at(sky, [[0, 1, 0], [1, 0, 0]], "latlong") / np.pi, 3).tolist()
    [1.0, 0.5]
    """
    resolved = resolve(projection, axes)
    several = images(
        image, resolved, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(irradiance_at, locals(), "values")
    resolved = resolve(resolved, rotation=rotation)
    pixels = checked_image(image, resolved, skipna=skipna, negative=negative)
    unit, leading = as_unit_vectors(normals, "normals")
    found = _core.lobe(pixels, resolved, unit, "cosine", 0.0)
    channels = found.shape[1:] if has_channels(pixels, resolved) else ()
    return _as_result(found.reshape((*leading, *channels)), pixels)


def convolve(
    image: ArrayLike,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    lobe: Lobe,
    half_angle: float | None = None,
    exponent: float | None = None,
    kappa: float | None = None,
    size: Size = 32,
    rotation: Any | None = None,
    skipna: bool = False,
    world: Worlds = "match",
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the mean radiance under a lobe about every direction, by exact summation.

    Parameters
    ----------
    image, src, dst, size, rotation, skipna, world, negative, any_aspect, channels_first
        As for `irradiance`.
    lobe : {"cone", "phong", "vmf"}
        ``"cone"``: all directions within `half_angle`, equally. ``"phong"``: max(0, cos)^exponent.
        ``"vmf"`` (von Mises-Fisher): exp(kappa (cos - 1)).
    half_angle : float
        In degrees, in (0, 180].
    exponent : float
        At least 0.
    kappa : float
        Concentration, at least 0.

    Returns
    -------
    mean : ndarray, shape of `dst` (+ channels)
        Every lobe is normalized: a constant L gives L. dtypes as for `irradiance`.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`, and for a parameter that is missing, out of range or of another lobe.

    Notes
    -----
    A lobe that is narrower than the texels meets few of them or none; where none, the result is
    the bilinear lookup in its direction.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = (sm.directions("latlong", 64)[..., 1] > 0).astype(np.float32)
    >>> wide = sm.light.convolve(
    ...     sky, "latlong", "latlong", lobe="cone", half_angle=90, size=8
    ... )
    >>> wide.shape, float(wide.max()) < 1
    ((8, 16), True)
    """
    given = {"half_angle": half_angle, "exponent": exponent, "kappa": kappa}
    # Irradiance is no mean.
    means = {name: wanted for name, wanted in LOBES.items() if wanted is not None}
    parameter = lobe_parameter(lobe, means, given)
    if lobe == "cone":
        if not 0 < parameter <= 180:
            raise ValueError(f"`half_angle` must be in (0, 180], got {half_angle}.")
        # The direction opposite is in a full cone whatever its rounding.
        parameter = -2.0 if parameter == 180 else float(_core.rotation(parameter, 0, 0)[0, 0])
    elif not (math.isfinite(parameter) and parameter >= 0):
        raise ValueError(
            f"`{means[lobe]}` must be at least 0 and finite, got {given[means[lobe]]}."
        )
    several = images(
        image,
        resolve(src),
        any_aspect=any_aspect,
        channels_first=channels_first,
        rotation=rotation,
    )
    if several is not None:
        target_shape(resolve(dst), size, any_aspect)
        return several.each(convolve, locals())
    source, target = resolve_pair(src, dst, rotation, world)
    pixels = checked_image(image, source, skipna=skipna, negative=negative)
    shape = target_shape(target, size, any_aspect)
    return lobe_image(pixels, source, target, shape, lobe, parameter)


def seen_by(
    coefficients: NDArray[np.float64], target: Projection, shape: tuple[int, ...]
) -> NDArray[np.float64]:
    """Return the irradiance of harmonics for every normal of an image."""
    directions = target.directions(shape, any_aspect=True)
    found = sh_evaluate(sh_convolve(coefficients, lobe="cosine"), directions)
    return np.nan_to_num(found, nan=0.0)


def normals_of(
    target: Projection, shape: tuple[int, ...]
) -> tuple[NDArray[np.float64], NDArray[np.bool_] | None]:
    """Return the directions of texels, (N, 3), and which texels have one, if not all have."""
    normals: NDArray[Any] = target.directions(shape, any_aspect=True).reshape(-1, 3)
    inside: NDArray[np.bool_] = ~np.isnan(normals[:, 0])
    if inside.all():
        return normals, None
    return np.ascontiguousarray(normals[inside]), inside


def placed(found: NDArray[np.float64], inside: NDArray[np.bool_] | None) -> NDArray[np.float64]:
    """Return values of all texels, 0 of those that have no direction."""
    if inside is None:
        return found
    whole = np.zeros((len(inside), found.shape[1]))
    whole[inside] = found
    return whole


def lobe_image(
    pixels: NDArray[Any],
    source: Projection,
    target: Projection,
    shape: tuple[int, ...],
    lobe: str,
    parameter: float,
) -> NDArray[np.floating[Any]]:
    wanted, inside = normals_of(target, shape)
    found = _core.lobe(pixels, source, wanted, lobe, parameter)
    empty = np.isnan(found[:, 0]) if len(found) else np.zeros(0, bool)
    if empty.any():
        light = pixels.astype(np.float64)
        values = source.sample(light, wanted[empty], any_aspect=True)
        found[empty] = values.reshape(len(values), -1)
    found = placed(found, inside)
    channels = found.shape[1:] if has_channels(pixels, source) else ()
    return _as_result(found.reshape(*shape, *channels), pixels)


def _as_result(found: NDArray[np.float64], pixels: NDArray[Any]) -> NDArray[np.floating[Any]]:
    # What float32 does not hold becomes infinite.
    with np.errstate(over="ignore"):
        return found.astype(result_dtype(pixels), copy=False)
