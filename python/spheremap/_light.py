"""Integrals over the sphere, irradiance, and light under other lobes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _core
from ._api import _resolve
from ._finite import checked_image

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._api import ProjectionLike, Size
    from ._core import Projection

__all__ = [
    "average_direction",
    "convolve",
    "integrate",
    "irradiance",
    "irradiance_at",
    "mean",
    "weights",
    "ws_psnr",
]

Lobe = Literal["cone", "phong", "vmf"]


def weights(
    projection: ProjectionLike, shape: Size, /, *, normalized: bool = False
) -> NDArray[np.float64]:
    """Return the weight of each texel in an integral over the sphere: dω = sin θ dθ dφ.

    ``(weights * image).sum()`` is the integral of the image, and ``(weights * error**2).sum()``
    a loss that counts every part of the sphere by its size.

    Parameters
    ----------
    projection, shape
        As for `solid_angle`.
    normalized : bool
        Divide by the covered solid angle, so that the weights sum to 1 and sums are means.

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
    >>> w = sm.weights("latlong", 64, normalized=True)
    >>> round(float(np.sum(w * a**2)), 3)
    0.333
    """
    resolved = _resolve(projection)
    found = _core.quadrature_weights(resolved, _size(shape))
    return found / resolved.covered_solid_angle if normalized else found


def integrate(
    image: ArrayLike, projection: ProjectionLike, /, *, skipna: bool = False
) -> NDArray[np.float64]:
    """Integrate an image over the sphere: ∫ L dω.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Radiance, or anything else per direction. Negative values count as they are.
    projection : Projection or str
        How the image maps the sphere.
    skipna : bool
        Count NaN and infinite values as 0 instead of raising.

    Returns
    -------
    integral : ndarray of float64, shape () or (C,)
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
    >>> float(sm.integrate(np.ones((64, 128)), "latlong") / np.pi)
    4.0
    """
    resolved = _resolve(projection)
    pixels = checked_image(image, skipna=skipna)
    return _shaped(_core.moments(pixels, resolved)[:-1, 0], pixels, resolved)


def mean(
    image: ArrayLike, projection: ProjectionLike, /, *, skipna: bool = False
) -> NDArray[np.float64]:
    """Average an image over the part of the sphere that it covers.

    Parameters
    ----------
    image, projection
        As for `integrate`.
    skipna : bool
        Average over the finite values alone, channel by channel.

    Returns
    -------
    mean : ndarray of float64, shape () or (C,)

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    The plain average of a latlong counts its poles too much:

    >>> import numpy as np, spheremap as sm
    >>> up = np.abs(sm.directions("latlong", 64)[..., 1])
    >>> float(up.mean().round(3)), float(sm.mean(up, "latlong").round(3))
    (0.637, 0.5)
    """
    resolved = _resolve(projection)
    pixels = checked_image(image, skipna=skipna)
    moments = _core.moments(pixels, resolved)
    total: Any = moments[-1, 0]
    if skipna and pixels.dtype.kind == "f":
        finite = np.isfinite(np.asarray(image)).astype(np.float32)
        total = _core.moments(finite, resolved)[:-1, 0]
    with np.errstate(invalid="ignore"):
        return _shaped(moments[:-1, 0] / total, pixels, resolved)


def average_direction(
    image: ArrayLike, projection: ProjectionLike, /, *, skipna: bool = False
) -> NDArray[np.float64]:
    """Return where the light comes from on average: ∫ L ω dω / ∫ L dω.

    Parameters
    ----------
    image, projection, skipna
        As for `integrate`.

    Returns
    -------
    direction : ndarray of float64, shape (3,) or (C, 3)
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
    >>> np.round(sm.average_direction(sky, "latlong") + 0.0, 3).tolist()
    [0.0, 0.667, 0.0]
    """
    resolved = _resolve(projection)
    pixels = checked_image(image, skipna=skipna)
    moments = _core.moments(pixels, resolved)[:-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        vectors: NDArray[np.float64] = moments[:, 1:] / moments[:, :1]
    return vectors if _has_channels(pixels, resolved) else vectors[0]


def ws_psnr(
    image: ArrayLike,
    reference: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    peak: float | None = None,
) -> float:
    """Return the weighted-to-spherically-uniform peak signal-to-noise ratio, in decibels.

    Parameters
    ----------
    image, reference : array_like
        As for `integrate`, of one shape.
    projection : Projection or str
        Of both.
    peak : float, optional
        The largest possible value: by default that of the integer type, or 1 for floats.

    Returns
    -------
    psnr : float
        10 log10(peak² / MSE), the squared error averaged over channels and, by solid angle, over
        the sphere. Infinite for equal images.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`, and for two shapes.

    Notes
    -----
    Sun, Lu and Yu 2017, with exact solid angles in place of the cosine of the latitude.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> round(sm.ws_psnr(np.full((8, 16), 0.5), np.full((8, 16), 0.6), "latlong"), 6)
    20.0
    """
    a, b = checked_image(image), checked_image(reference, name="reference")
    if a.shape != b.shape:
        raise ValueError(f"Expected two images of one shape, got {a.shape} and {b.shape}.")
    if peak is None:
        peak = float(np.iinfo(a.dtype).max) if a.dtype.kind == "u" else 1.0
    squared = np.square(a.astype(np.float64) - b.astype(np.float64))
    error = float(np.mean(mean(squared, projection)))
    return 10.0 * math.log10(peak**2 / error) if error > 0 else math.inf


def irradiance(
    image: ArrayLike,
    src: ProjectionLike,
    dst: ProjectionLike,
    /,
    *,
    size: Size = 32,
    method: Literal["exact", "sh"] = "exact",
    order: int = 8,
    skipna: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the irradiance of a surface for every normal: E(n) = ∫ L max(0, n·ω) dω.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Radiance.
    src, dst : Projection or str
        The maps of the image and of the result.
    size : int or tuple of int
        Of the result, as for `solid_angle`.
    method : {"exact", "sh"}
        The sum over all texels, or spherical harmonics up to `order`.
    order : int
        For "sh": with Φ = ∫|L| dω the result is within 0.094 Φ of the exact one at order 2,
        0.059 Φ at 4, 0.034 Φ at 8 and 0.0183 Φ at 16 (a single sun reaches that; skies stay
        far below).
    skipna : bool
        Count NaN and infinite values as 0 instead of raising.

    Returns
    -------
    irradiance : ndarray, shape of `dst` (+ channels)
        float32 for float16 and float32 images, else float64; summed in float64. Divided by π it
        is what a white Lambertian surface sends back. 0 outside the valid image of `dst`.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

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
    >>> E = sm.irradiance(white, "latlong", "cube", size=8)
    >>> E.shape, float(np.abs(E - np.pi).max()) < 1e-6
    ((6, 8, 8, 3), True)
    """
    if method not in ("exact", "sh"):
        raise ValueError(f"Expected `method` to be 'exact' or 'sh', got {method!r}.")
    if method == "exact":
        return _lobe_image(image, src, dst, size, "cosine", 0.0, skipna)
    from ._sh import sh_convolve, sh_evaluate, sh_project

    coefficients = sh_project(image, src, order=order, skipna=skipna)
    target = _resolve(dst)
    directions = target.directions(target.shape(_size(size)))
    found = sh_evaluate(sh_convolve(coefficients, "cosine"), directions)
    return np.nan_to_num(found, nan=0.0).astype(_result_dtype(np.asarray(image)))


def irradiance_at(
    image: ArrayLike,
    normals: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    skipna: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the irradiance of surfaces with these normals, as exactly as `irradiance`.

    Parameters
    ----------
    image, skipna
        As for `irradiance`.
    normals : array_like, shape (..., 3)
        World directions of any length.
    projection : Projection or str
        The map of the image.

    Returns
    -------
    irradiance : ndarray, shape (...) or (..., C)
        NaN for a normal that is zero or not finite.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = (sm.directions("latlong", 64)[..., 1] > 0).astype(float)
    >>> np.round(sm.irradiance_at(sky, [[0, 1, 0], [1, 0, 0]], "latlong") / np.pi, 3).tolist()
    [1.0, 0.5]
    """
    resolved = _resolve(projection)
    pixels = checked_image(image, skipna=skipna)
    unit, leading = _unit(normals, "normals")
    found = _core.lobe(pixels, resolved, unit, "cosine", 0.0)
    channels = found.shape[1:] if _has_channels(pixels, resolved) else ()
    return found.reshape(*leading, *channels).astype(_result_dtype(pixels))


def convolve(
    image: ArrayLike,
    src: ProjectionLike,
    dst: ProjectionLike,
    lobe: Lobe,
    /,
    *,
    half_angle: float | None = None,
    exponent: float | None = None,
    kappa: float | None = None,
    size: Size = 32,
    skipna: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the mean radiance under a lobe about every direction, by exact summation.

    Parameters
    ----------
    image, src, dst, size, skipna
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
    >>> wide = sm.convolve(sky, "latlong", "latlong", "cone", half_angle=90, size=8)
    >>> wide.shape, float(wide.max()) < 1
    ((8, 16), True)
    """
    given = {"half_angle": half_angle, "exponent": exponent, "kappa": kappa}
    names = {"cone": "half_angle", "phong": "exponent", "vmf": "kappa"}
    if lobe not in names:
        raise ValueError(f"unknown lobe {lobe!r}; there are {', '.join(names)}")
    wanted = names[lobe]
    value = given.pop(wanted)
    surplus = [name for name, x in given.items() if x is not None]
    if surplus:
        raise ValueError(f"lobe {lobe!r} takes `{wanted}`, got `{surplus[0]}`.")
    if value is None:
        raise ValueError(f"lobe {lobe!r} needs `{wanted}`.")
    parameter = float(value)
    if lobe == "cone":
        if not 0 < parameter <= 180:
            raise ValueError(f"`half_angle` must be in (0, 180], got {value}.")
        # The direction opposite is in a full cone whatever its rounding.
        parameter = -2.0 if parameter == 180 else math.cos(math.radians(parameter))
    elif not (math.isfinite(parameter) and parameter >= 0):
        raise ValueError(f"`{wanted}` must be at least 0 and finite, got {value}.")
    return _lobe_image(image, src, dst, size, lobe, parameter, skipna)


def _lobe_image(
    image: ArrayLike,
    src: ProjectionLike,
    dst: ProjectionLike,
    size: Size,
    lobe: str,
    parameter: float,
    skipna: bool,
) -> NDArray[np.floating[Any]]:
    source, target = _resolve(src), _resolve(dst)
    pixels = checked_image(image, skipna=skipna)
    shape = target.shape(_size(size))
    normals: NDArray[Any] = target.directions(shape).reshape(-1, 3)
    inside = ~np.isnan(normals[:, 0])
    everywhere = bool(inside.all())
    wanted = normals if everywhere else np.ascontiguousarray(normals[inside])
    found = _core.lobe(pixels, source, wanted, lobe, parameter)
    empty = np.isnan(found[:, 0]) if len(found) else np.zeros(0, bool)
    if empty.any():
        light = pixels.astype(np.float64)
        values = source.sample(light, wanted[empty], fill=0.0)
        found[empty] = values.reshape(len(values), -1)
    if not everywhere:
        whole = np.zeros((len(normals), found.shape[1]))
        whole[inside] = found
        found = whole
    channels = found.shape[1:] if _has_channels(pixels, source) else ()
    return found.reshape(*shape, *channels).astype(_result_dtype(pixels), copy=False)


def _size(size: Size) -> Any:
    return size if isinstance(size, int | np.integer) else tuple(size)


def _result_dtype(image: NDArray[Any]) -> type[np.floating[Any]]:
    return np.float32 if image.dtype.kind == "f" and image.dtype.itemsize <= 4 else np.float64


def _has_channels(image: NDArray[Any], projection: Projection) -> bool:
    return image.ndim > (2 if projection.faces == 1 else 3)


def _shaped(
    values: NDArray[np.float64], image: NDArray[Any], projection: Projection
) -> NDArray[np.float64]:
    return values if _has_channels(image, projection) else values.reshape(())


def _unit(directions: ArrayLike, name: str) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Return unit vectors as (N, 3), NaN for what is none, and the leading axes."""
    from ._arrays import as_real

    array = as_real(directions, name).astype(np.float64, copy=False)
    if array.shape[-1:] != (3,):
        raise ValueError(f"Expected `{name}` to have shape (..., 3), got {array.shape}.")
    with np.errstate(all="ignore"):
        scaled = array / np.abs(array).max(axis=-1, keepdims=True)
        unit = scaled / np.sqrt(np.square(scaled).sum(axis=-1, keepdims=True))
    return np.ascontiguousarray(unit.reshape(-1, 3)), array.shape[:-1]
