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
from .look import FOV, as_direction
from .shaders import LENSES
from .still import lens, placed, seen, sights
from .texels import halves, shown_channels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Shown", "picked", "sharper"]

# How much wider than the view a perspective is, so that a small turn needs no other; and at most.
_MARGIN, _WIDEST, _LARGEST = 1.2, 165.0, 2048
_ZOOM = 64.0
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


def sharper(
    shown: Shown, asked: dict[str, Any], screen: Projection | None = None
) -> tuple[dict[str, Any], bytes] | None:
    """Return what a camera sees of an image, as halves of RGBA, or None for what is none.

    `asked` has its angles, field of view, zoom, and rows and columns of the picture; `screen` is
    what the picture plane is.
    """
    yaw, pitch, fov = (as_number(asked[name], name) for name in ("yaw", "pitch", "fov"))
    zoom = as_number(asked.get("zoom", 1.0), "zoom")
    height, width = (as_number(n, "size") for n in as_items(asked["size"], "size", "two sides"))
    if not (FOV[0] <= fov <= FOV[1] and 1 <= zoom <= _ZOOM and math.isfinite(height + width)):
        return None
    if min(height, width) < 2:
        return None
    screen = resolve("perspective") if screen is None else screen
    name = lens(screen.name, fov) if screen.name in LENSES else ""
    margin = 1.0
    if name == "perspective":
        # One that is wide enough holds what is seen after a small turn as well.
        wide, widest = (math.tan(math.radians(angle) / 2) for angle in (fov, _WIDEST))
        margin = max(1.0, min(_MARGIN, widest / wide))
        fov = math.degrees(2 * math.atan(wide * margin))
    scale = min(margin, _LARGEST / max(height, width))
    size = max(2, round(height * scale)), max(2, round(width * scale))
    # A disk has as many pixels to each side of it.
    size = size[0], size[1] - (size[1] - size[0]) % 2
    pose = rotation(yaw, pitch)
    p = shown.projection
    pixels = shown_channels(shown.pixels, p)
    by = placed(screen, name, fov, pose, size, zoom)
    light, held = seen(pixels, p, *by, sights(*by))
    size = held.shape[0], held.shape[1]
    missing = np.isnan(light).any(axis=-1)
    words = np.empty((*size, 4), np.uint16)
    known = np.where((held & ~missing)[..., np.newaxis], light, np.float32(0))
    words[..., :3], gain = halves(known)
    words[..., 3] = np.where(held, np.where(missing, _MISSING, _VALUE), _OUTSIDE)
    if name:
        # Of the lens that is printed.
        turns = 2 if name == "perspective" else 4
        half = math.tan(math.radians(fov) / turns) / math.tan(math.radians(LENSES[name]) / turns)
        parts = half, half * size[0] / size[1]
    else:
        _, whole, _ = by
        parts = size[1] / whole[1], size[0] / whole[0]
    record = {
        "width": size[1],
        "height": size[0],
        "pose": pose.T.ravel().tolist(),
        "scale": [*parts, gain],
        # What it is a picture by; a perspective is a part of other screens as well.
        "screen": "" if name == "perspective" else str(asked.get("screen", "")),
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
