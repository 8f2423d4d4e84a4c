"""An image on its way from file to file: as light where it becomes floats, as a picture at the end.

Straight alpha (PNG, TIFF) weights colors while they are filtered. Light is premultiplied, as EXR
has it, and filters as it is.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from spheremap import io
from spheremap.cli.terminal import UsageError, read
from spheremap.io.color import color_channels, cut
from spheremap.io.header import is_linear
from spheremap.io.images import write_copy
from spheremap.io.tonemap import Curve

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Formats whose readers expect colors that are not multiplied by alpha.
_STRAIGHT = (".png", ".tif", ".tiff")
LINEAR = "lin_rec709_scene"
SRGB = "srgb_rec709_scene"


@dataclass(frozen=True)
class Picture:
    """Texels, and what there is to know of them."""

    pixels: NDArray[Any]
    names: tuple[str, ...]
    color_space: str
    alpha: Literal["none", "straight", "premultiplied"]
    alpha_channel: int | None
    projection: str | None
    metadata: Mapping[str, Any]

    @property
    def is_light(self) -> bool:
        """Whether the texels are floats."""
        return self.pixels.dtype.kind == "f"


def load(
    path: Path,
    *,
    part: str | None = None,
    fill: float = 0.0,
    color_space: str | None = None,
    head: io.Header | None = None,
) -> Picture:
    """Read an image file; `color_space` is what the file's colors are, whatever it says.

    `head` is what `io.header` reads of it, where that is known.
    """
    head = io.header(path, part=part) if head is None else head
    return described(read(path, part=part, fill=fill), head, color_space=color_space)


def described(pixels: NDArray[Any], head: io.Header, *, color_space: str | None = None) -> Picture:
    """Return texels of a file with what it says of them."""
    alpha = head.alpha
    if alpha == "premultiplied" and head.alpha_channel is not None and pixels.dtype.kind == "u":
        # A curve is undone of colors that are not multiplied; and integers are written so.
        pixels, alpha = straightened(pixels, head.alpha_channel), "straight"
    return Picture(
        pixels,
        head.channels,
        color_space or head.color_space,
        alpha,
        head.alpha_channel,
        head.projection,
        head.metadata,
    )


def with_channels(picture: Picture, names: list[str]) -> Picture:
    """Return a picture with the named channels in that order."""
    missing = [name for name in names if name not in picture.names]
    if missing:
        raise UsageError(f"no channel {missing[0]!r}; the file has {', '.join(picture.names)}")
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise UsageError(f"channel {twice[0]!r} is named twice")
    indices = [picture.names.index(name) for name in names]
    alpha = picture.alpha_channel
    at = indices.index(alpha) if alpha in indices else None
    return replace(
        picture,
        pixels=np.ascontiguousarray(picture.pixels[..., indices]),
        names=tuple(names),
        alpha_channel=at,
        alpha=picture.alpha if at is not None else "none",
    )


def with_colors(picture: Picture) -> Picture:
    """Return a gray picture, with alpha or without, as one of three equal colors."""
    alpha = picture.alpha_channel
    grays = [k for k in range(len(picture.names)) if k != alpha]
    if len(grays) != 1:
        return picture
    order = [*grays * 3, *([] if alpha is None else [alpha])]
    return replace(
        picture,
        pixels=np.ascontiguousarray(picture.pixels[..., order]),
        names=("R", "G", "B", *([] if alpha is None else [picture.names[alpha]])),
        alpha_channel=None if alpha is None else 3,
    )


def without_alpha(picture: Picture) -> Picture:
    """Return a picture without its alpha; colors stay as they are stored."""
    k = picture.alpha_channel
    if k is None:
        return picture
    return with_channels(picture, [name for j, name in enumerate(picture.names) if j != k])


def as_light(picture: Picture) -> Picture:
    """Return a picture as linear light in floats, premultiplied; floats keep their primaries."""
    pixels, alpha = picture.pixels, picture.alpha_channel
    light, space = pixels, picture.color_space
    if not (picture.is_light and is_linear(space)):
        light, space = io.to_linear(pixels, color_space=space, alpha=alpha), LINEAR
    if picture.alpha == "straight" and alpha is not None:
        light = light * _cover(light, alpha)
    metadata = {k: v for k, v in picture.metadata.items() if k != "ICCProfile"}
    return replace(
        picture,
        pixels=light,
        color_space=space,
        alpha="none" if alpha is None else "premultiplied",
        metadata=metadata,
    )


def as_stored(
    picture: Picture, depth: str, suffix: str, *, tonemap: Curve, exposure: float
) -> Picture:
    """Return a picture in the type that a file will hold."""
    alpha = picture.alpha_channel
    if not picture.is_light and not depth.startswith("float"):
        return replace(picture, pixels=_rescaled(picture.pixels, depth))
    light = picture.pixels
    if alpha is not None and suffix in _STRAIGHT:
        cover = _cover(light, alpha)
        light = np.divide(light, cover, out=np.zeros_like(light), where=cover > 0)
    if depth.startswith("float"):
        return replace(picture, pixels=_as_floats(light, depth))
    light = io.to_linear(light, color_space=picture.color_space, alpha=alpha)
    words = {k: v for k, v in picture.metadata.items() if k != "chromaticities"}
    stored = replace(picture, color_space=SRGB, metadata=words)
    if tonemap == "reinhard":
        return replace(stored, pixels=_tonemapped(light, alpha, exposure))
    return replace(stored, pixels=cut(light, depth, exposure=exposure, alpha=alpha))


def _as_floats(light: NDArray[Any], depth: str) -> NDArray[Any]:
    """Return light in a float type; a sun that is beyond half floats is as bright as they are."""
    try:
        with np.errstate(over="raise"):
            return light.astype(depth, copy=False)
    except FloatingPointError:
        # An infinite texel would spread to all that a later filter makes of it.
        most = float(np.finfo(depth).max)
        beyond = np.isfinite(light) & (np.abs(light) > most)
        _warn(f"values above {most:.0f} are clipped: half floats hold no more")
        return np.where(beyond, np.copysign(most, light), light).astype(depth)


@cache
def _warn(words: str) -> None:
    """Say something once, and not for each part of an image."""
    print(f"warning: {words}", file=sys.stderr)


def _tonemapped(light: NDArray[np.float32], alpha: int | None, exposure: float) -> NDArray[Any]:
    """Return 8-bit colors by the curve of `io.tonemap`, and other channels as they are."""
    colors = color_channels(light.shape[-1], alpha)
    whole = np.clip(np.nan_to_num(light), 0.0, 1.0) * np.float32(255)
    stored: NDArray[np.uint8] = np.rint(whole).astype(np.uint8)
    stored[..., colors] = io.tonemap(light[..., colors], exposure=exposure)
    return stored


def as_shown(picture: Picture, suffix: str, *, exposure: float) -> NDArray[Any]:
    """Return what a preview shows: light by the curve of `io.tonemap`, integers as they look."""
    alpha = picture.alpha_channel
    if picture.is_light:
        light = io.to_linear(picture.pixels, color_space=picture.color_space, alpha=alpha)
        return io.tonemap(without_alpha(replace(picture, pixels=light)).pixels, exposure=exposure)
    kept = color_channels(len(picture.names), alpha)
    if alpha is not None and suffix == ".png":
        kept.append(alpha)
    shown = with_channels(picture, [picture.names[k] for k in kept])
    if shown.color_space == SRGB and not exposure:
        return shown.pixels
    alpha = shown.alpha_channel
    light = io.to_linear(shown.pixels, color_space=shown.color_space, alpha=alpha)
    return cut(light, shown.pixels.dtype.name, exposure=exposure, alpha=alpha)


def save(
    path: Path, picture: Picture, *, compression: str | None, projection: str | None = None
) -> None:
    """Write a picture, with what there is to know of it."""
    write_copy(
        path,
        picture.pixels,
        compression=compression,
        channels=picture.names,
        color_space=picture.color_space,
        projection=projection,
        metadata=picture.metadata,
    )


def _cover(pixels: NDArray[Any], alpha: int, whole: int = 1) -> NDArray[Any]:
    """Return what each channel is to be multiplied with: colors with alpha, others with `whole`."""
    cover = np.full_like(pixels, whole)
    cover[..., color_channels(pixels.shape[-1], alpha)] = pixels[..., alpha : alpha + 1]
    return cover


def straightened(pixels: NDArray[Any], alpha: int) -> NDArray[Any]:
    """Return integers with colors that are divided by alpha; what is transparent stays."""
    largest = np.iinfo(pixels.dtype).max
    cover = _cover(pixels, alpha, largest).astype(np.uint64)
    wide = (pixels.astype(np.uint64) * largest + cover // 2) // np.maximum(cover, 1)
    return np.where(cover > 0, np.minimum(wide, largest), pixels).astype(pixels.dtype)


def _rescaled(pixels: NDArray[Any], depth: str) -> NDArray[Any]:
    if pixels.dtype.name == depth:
        return pixels
    if depth == "uint16":
        return pixels.astype(np.uint16) * np.uint16(257)
    return ((pixels.astype(np.uint32) + 128) // 257).astype(np.uint8)
