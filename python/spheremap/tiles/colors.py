"""Light as the 8 bits that a browser shows; pictures as light, which is what may be averaged."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..io.color import color_channels, cut, to_linear
from ..io.tonemap import tonemap

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Look", "light", "on_black", "shown", "without_alpha"]

_AT_A_TIME = 1 << 16


@dataclass(frozen=True)
class Look:
    """How light becomes a picture; see `spheremap.io.tonemap`."""

    curve: str
    exposure: float

    def picture(self, pixels: NDArray[Any]) -> NDArray[np.uint8]:
        """Return texels (..., C) as `spheremap convert` stores them in 8 bits."""
        if pixels.dtype == np.uint8:
            return pixels
        out = np.empty(pixels.shape, np.uint8)
        texels, stored = (x.reshape(-1, 1, x.shape[-1]) for x in (pixels, out))
        # The library that knows color spaces takes long to begin, and room for what it works on.
        for k in range(0, len(texels), _AT_A_TIME):
            block = slice(k, k + _AT_A_TIME)
            stored[block] = self._stored(texels[block])
        return out

    def _stored(self, pixels: NDArray[Any]) -> NDArray[Any]:
        if pixels.dtype == np.uint16:
            return (pixels.astype(np.uint32) + 128) // 257
        if self.curve == "reinhard":
            return tonemap(pixels, exposure=self.exposure)
        return cut(pixels, "uint8", exposure=self.exposure)


def without_alpha(pixels: NDArray[Any]) -> NDArray[Any]:
    """Return the colors of an image: of two channels the first, of more than three three."""
    count = pixels.shape[-1]
    return pixels if count in (1, 3) else np.ascontiguousarray(pixels[..., : 3 if count > 3 else 1])


def on_black(pixels: NDArray[Any], alpha: int) -> NDArray[np.float32]:
    """Return the light of an image's colors, multiplied by its straight alpha."""
    cover = pixels[..., alpha : alpha + 1]
    if pixels.dtype.kind == "u":
        cover = cover / np.float32(np.iinfo(pixels.dtype).max)
    colors = light(pixels[..., color_channels(pixels.shape[-1], alpha)])
    return np.asarray(colors * cover, np.float32)


def shown(pixels: NDArray[Any]) -> NDArray[Any]:
    """Return what an array (..., C) shows, which does not say whether it has alpha."""
    count = pixels.shape[-1]
    # As in pictures; light is premultiplied, and black already.
    has_alpha = pixels.dtype.kind == "u" and count in (2, 4)
    return on_black(pixels, count - 1) if has_alpha else pixels


def light(pixels: NDArray[Any]) -> NDArray[np.float32]:
    """Return texels as linear light: integers are pictures of sRGB."""
    if pixels.dtype.kind == "f":
        with np.errstate(over="ignore", invalid="ignore"):
            return pixels.astype(np.float32, copy=False)
    return np.asarray(_light_of_each(pixels.dtype)[pixels])


@cache
def _light_of_each(dtype: np.dtype[Any]) -> NDArray[np.float32]:
    """Return the light of all integers of a type."""
    every = np.arange(np.iinfo(dtype).max + 1, dtype=dtype)
    table: NDArray[np.float32] = to_linear(every[np.newaxis, :, np.newaxis])[0, :, 0]
    return table
