"""An image as light: its shape checked, its texels weighted by what they see, its luminance.

What lies outside the valid image (the corners around a disk, where photographers print their
credits; the empty cells of a cross) counts for nothing, whatever is there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._arrays import as_doubles, as_image, checked_image, held_texels, spatial_axes

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative
    from .._projection import Projection

# ITU-R BT.709: the luminance of linear RGB with sRGB's primaries.
REC709 = (0.2126, 0.7152, 0.0722)


def as_light(
    image: ArrayLike,
    projection: Projection,
    *,
    skipna: bool = False,
    negative: Negative = "keep",
    skipping: str | None = "counts them as 0",
) -> NDArray[np.floating[Any]]:
    """Return an image as contiguous float32 or float64, 0 where it holds no sphere.

    Whether its aspect fits was asked before. `skipping` is as for `checked_image`.
    """
    array = as_image(image, None)
    spatial = array.shape[: spatial_axes(projection)]
    projection.shape(spatial)
    if array.ndim > len(spatial) + 1 or array.shape[len(spatial) :] == (0,):
        pattern = "(H, W) or (H, W, C)" if len(spatial) == 2 else "(F, N, N) or (F, N, N, C)"
        raise ValueError(
            f"Expected an image of projection '{projection.name}' to have shape {pattern}, "
            f"got {array.shape}."
        )
    if array.dtype.itemsize < 4:
        # A signaling NaN would warn.
        with np.errstate(invalid="ignore"):
            array = array.astype(np.float32)
    held = held_texels(array, projection)
    if not held.all():
        array = np.where(held, array, array.dtype.type(0))
    array = checked_image(array, skipna=skipna, negative=negative, skipping=skipping)
    return np.ascontiguousarray(array)


def as_given_outside(
    light: NDArray[np.floating[Any]], image: ArrayLike, projection: Projection
) -> NDArray[np.floating[Any]]:
    """Return light made of an image, with that image's own texels where it holds no sphere."""
    given = as_image(image, None)
    held = held_texels(given, projection)
    return light if held.all() else np.where(held, light, given.astype(light.dtype, copy=False))


def texel_weights(projection: Projection, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the solid angle that each texel stands for.

    As `solid_angle`, but the covered part of a texel whose center lies outside the valid image
    counts for the nearest texel inside.
    """
    return _core.texel_weights(projection, shape)


def coefficients(image: NDArray[Any], axes: int, given: ArrayLike | None) -> NDArray[np.float64]:
    """Return what makes luminance of channels: what was given, or BT.709 of the first three."""
    channels = 1 if image.ndim == axes else image.shape[-1]
    if given is None:
        if channels == 1:
            return np.ones(1)
        if channels not in (3, 4):
            raise ValueError(
                f"`luminance` must say how {channels} channels make luminance: one number for each."
            )
        given = (*REC709, 0.0)[:channels]
    array = as_doubles(given, "luminance")
    if array.shape != (channels,):
        raise ValueError(f"Expected `luminance` to have shape ({channels},), got {array.shape}.")
    if not (np.isfinite(array).all() and array.min() >= 0 and array.max() > 0):
        raise ValueError(
            f"`luminance` must be finite and not negative, and not all 0, got {array.tolist()}."
        )
    return array


def luminance_of(
    image: NDArray[Any], axes: int, weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the luminance of each texel, in float64."""
    texels = image[..., np.newaxis] if image.ndim == axes else image
    return _core.luminances(texels, weights)
