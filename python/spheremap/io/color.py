"""From the numbers of a file to light and back, by OpenImageIO's color spaces."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array, as_real
from .._scalars import as_text, as_whole
from .opened import library, one_line

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["cut", "from_linear", "to_linear"]

LINEAR = "lin_rec709_scene"


def to_linear(
    image: ArrayLike, *, color_space: str = "srgb_rec709_scene", alpha: int | None = None
) -> NDArray[np.float32]:
    """Turn the numbers of a file into linear light of sRGB's primaries.

    Parameters
    ----------
    image : array_like, shape (H, W, C)
        Integers count as fractions of their largest. Colors are the first three channels, or the
        first of fewer; others are but scaled.
    color_space : str
        As `Header` or OpenImageIO's ``ColorConfig`` names it.
    alpha : int, optional
        A channel that is no color.

    Returns
    -------
    light : ndarray of float32, shape (H, W, C)

    Raises
    ------
    ValueError
        For an unknown color space, or a shape that is no image.
    ImportError
        If OpenImageIO is missing.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap.io import to_linear
    >>> to_linear(np.full((1, 1, 3), 188, np.uint8)).round(2).tolist()
    [[[0.5, 0.5, 0.5]]]
    """
    return _converted(_fractions(as_array(image, "image")), color_space, LINEAR, alpha)


def from_linear(
    light: ArrayLike, *, color_space: str = "srgb_rec709_scene", alpha: int | None = None
) -> NDArray[np.float32]:
    """Turn linear light into the numbers of a file, 1.0 for the largest: the way back.

    Parameters
    ----------
    light : array_like, shape (H, W, C)
    color_space, alpha
        As for `to_linear`.

    Returns
    -------
    image : ndarray of float32, shape (H, W, C)

    Raises
    ------
    ValueError, ImportError
        As for `to_linear`.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap.io import from_linear
    >>> (from_linear(np.full((1, 1, 3), 0.5)) * 255).round().tolist()
    [[[188.0, 188.0, 188.0]]]
    """
    return _converted(_fractions(as_array(light, "light")), LINEAR, color_space, alpha)


def cut(
    light: NDArray[Any], dtype: str, *, exposure: float = 0.0, alpha: int | None = None
) -> NDArray[Any]:
    """Return light (H, W, C) as integers of sRGB; what is below 0 or above 1 is cut."""
    light = _fractions(light)
    others = [k for k in range(light.shape[-1]) if k != alpha]
    # Beyond these all light is white, or black.
    factor = np.float32(2.0 ** min(max(exposure, -126.0), 126.0))
    with np.errstate(over="ignore"):
        light[..., others] *= factor
    light = np.clip(np.nan_to_num(light, nan=0.0), 0.0, 1.0)
    encoded = np.clip(from_linear(light, alpha=alpha), 0.0, 1.0)
    return np.asarray(np.rint(encoded * np.float32(np.iinfo(dtype).max)), dtype=dtype)


def _fractions(image: NDArray[Any]) -> NDArray[np.float32]:
    if image.ndim != 3 or 0 in image.shape:
        raise ValueError(f"Expected `image` to have shape (H, W, C), got {image.shape}.")
    if image.dtype.kind == "u":
        return np.asarray(image / np.float32(np.iinfo(image.dtype).max), np.float32)
    # What float32 does not hold becomes infinite.
    with np.errstate(over="ignore"):
        return np.array(as_real(image, "image"), np.float32)


def color_channels(count: int, alpha: int | None) -> list[int]:
    """Return which channels are colors: the first three but alpha, or the first of fewer."""
    others = [k for k in range(count) if k != alpha]
    return others[:3] if len(others) >= 3 else others[:1]


@cache
def _config() -> Any:
    """Return what knows color spaces: a new one reads all of them again, in 80 ms."""
    return library().ColorConfig()


def is_color_space(name: str) -> bool:
    """Tell whether OpenImageIO knows a color space by this name."""
    config = _config()
    return bool(config.getColorSpaceIndex(config.resolve(name)) >= 0)


def _converted(
    image: NDArray[np.float32], source: str, target: str, alpha: int | None
) -> NDArray[np.float32]:
    oiio = library()
    for name in (source, target):
        as_text(name, "color_space")
    if alpha is not None:
        as_whole(alpha, "alpha")
    colors = color_channels(image.shape[-1], alpha)
    config = _config()
    if config.resolve(source) == config.resolve(target) or not colors:
        return image
    # The library turns three channels at a time.
    triple = image[..., colors] if len(colors) == 3 else np.repeat(image[..., colors[:1]], 3, -1)
    turned = oiio.ImageBufAlgo.colorconvert(
        oiio.ImageBuf(np.ascontiguousarray(triple)), source, target
    )
    if turned.has_error:
        raise ValueError(f"unknown color space: {one_line(turned.geterror())}")
    image[..., colors] = np.asarray(turned.get_pixels(oiio.FLOAT))[..., : len(colors)]
    return image
