"""What a widget asks its kernel for: sharper pictures of what is seen, and values of texels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import spatial_axes
from .._scalars import as_items, as_number
from ..map.named import resolve
from ..map.verbs import rotation
from .look import as_direction
from .shaders import LENSES
from .still import seen
from .texels import halves, shown_channels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Shown", "picked", "sharper"]

# How much wider than the view a picture is, so that a small turn needs no other; and at most.
_MARGIN, _WIDEST, _LARGEST = 1.2, 165.0, 2048
# Halves of what a texel is: a value, outside, NaN.
_VALUE, _OUTSIDE, _MISSING = 0x3C00, 0, 0xBC00


@dataclass(frozen=True)
class Shown:
    """One image with its map, its channels last."""

    pixels: NDArray[Any]
    projection: Projection
    name: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the image without channels."""
        return self.pixels.shape[: spatial_axes(self.projection)]


def sharper(shown: Shown, asked: dict[str, Any]) -> tuple[dict[str, Any], bytes] | None:
    """Return what a camera sees of an image, as halves of RGBA, or None where it sees too much.

    `asked` has its angles, field of view, and rows and columns of the picture.
    """
    yaw, pitch, fov = (as_number(asked[name], name) for name in ("yaw", "pitch", "fov"))
    height, width = (as_number(n, "size") for n in as_items(asked["size"], "size", "two sides"))
    if not (0 < fov < _WIDEST and math.isfinite(height + width) and min(height, width) >= 2):
        return None
    wide, widest = (math.tan(math.radians(angle) / 2) for angle in (fov, _WIDEST))
    margin = min(_MARGIN, widest / wide)
    scale = min(margin, _LARGEST / max(height, width))
    size = max(2, round(height * scale)), max(2, round(width * scale))
    pose = rotation(yaw, pitch)
    across = math.degrees(2 * math.atan(wide * margin))
    p = shown.projection
    lens = resolve("perspective")
    pixels = shown_channels(shown.pixels, p)
    light, held = seen(pixels, p, lens, "perspective", across, pose, size)
    missing = np.isnan(light).any(axis=-1)
    words = np.empty((*size, 4), np.uint16)
    known = np.where((held & ~missing)[..., np.newaxis], light, np.float32(0))
    words[..., :3], gain = halves(known)
    words[..., 3] = np.where(held, np.where(missing, _MISSING, _VALUE), _OUTSIDE)
    half = wide * margin / math.tan(math.radians(LENSES["perspective"]) / 2)
    record = {
        "width": size[1],
        "height": size[0],
        "pose": pose.T.ravel().tolist(),
        "scale": [half, half * size[0] / size[1], gain],
    }
    return record, words.tobytes()


def picked(shown: Shown, first: Projection, direction: Any) -> dict[str, Any]:
    """Return what lies in a direction of the world of `first`, from the image itself."""
    toward = as_direction(direction)
    found: dict[str, Any] = {"image": shown.name, "direction": list(toward)}
    p = shown.projection.in_world_of(first)
    d = np.array(toward)
    uv = np.asarray(p.encode(d), np.float64)
    place = np.asarray(p.directions_to_pixels(d, shown.shape, any_aspect=True), np.float64)
    if not (np.isfinite(uv).all() and np.isfinite(place).all()):
        return found
    height, width = shown.shape[-2:]
    column, row = (
        int(np.clip(np.floor(x), 0, n - 1)) for x, n in zip(place, (width, height), strict=False)
    )
    at: tuple[int, ...] = (row, column)
    if p.faces > 1:
        face = int(place[2])
        found["face"], at = face, (face, row, column)
    # A message has no NaN.
    value = [x if math.isfinite(x) else None for x in map(float, np.ravel(shown.pixels[at]))]
    return found | {
        "uv": uv[:2].tolist(),
        "texel": [column, row],
        "value": value,
        "solid_angle": float(p.density(uv)) / (height * width),
    }
