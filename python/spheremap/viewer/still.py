"""What is seen, as an array: by the library's own conversion, and no browser."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..io.tonemap import tonemap
from ..map.named import resolve
from ..map.pixels import pixels_to_directions
from ..resample.verbs import convert
from .colors import MISSING, OUTSIDE, falsely
from .shaders import LENSES
from .texels import light

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

    # Rows and columns of a picture.
    Crop = tuple[slice, slice]

__all__ = ["lens", "placed", "seen", "sights", "toned"]


def lens(name: str, fov: float) -> str:
    """Return what a screen is at a field of view: a perspective ends where a planet begins."""
    return "stereographic" if name == "perspective" and fov > 170 else name


def seen(
    image: NDArray[Any],
    p: Projection,
    camera: Projection,
    shape: tuple[int, ...],
    crop: Crop,
    directions: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return the light of a picture (H, W, 3) and where it holds some.

    What it is by is what `placed` returns; `directions` are those of its pixels, by `sights`.
    """
    there = p.in_world_of("latlong")
    picture = convert(image, there, camera, size=shape, any_aspect=True, window=crop)
    held = np.isfinite(directions[..., 0])
    held &= there.covers(np.where(held[..., None], directions, np.float32(1.0)))
    picture = picture if picture.ndim == 3 else picture[..., None]
    picture = picture[..., : 3 if picture.shape[-1] >= 3 else 1]
    return np.broadcast_to(light(picture), (*held.shape, 3)), held


def sights(camera: Projection, shape: tuple[int, ...], crop: Crop) -> NDArray[np.float32]:
    """Return the directions that the pixels of a part of a picture see."""
    rows, columns = (np.arange(side.start, side.stop) + 0.5 for side in crop)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1)
    return pixels_to_directions(pixels, camera, shape, any_aspect=True).astype(np.float32)


def placed(
    screen: Projection,
    name: str,
    fov: float,
    pose: NDArray[np.float64],
    size: tuple[int, int],
    zoom: float = 1.0,
) -> tuple[Projection, tuple[int, ...], Crop]:
    """Return what a picture is by: a camera, the shape of all that it sees, and a part of that.

    `size` is that of a lens, and what a flat map fits into, of which `zoom` shows the middle.
    `pose` is the camera's in a world that is x right, y up, -z ahead.
    """
    height, width = size
    name = lens(name, fov)
    crop = (slice(0, height), slice(0, width))
    if name == "perspective":
        camera = resolve(f"perspective(fov={fov!r},aspect={width / height!r})")
        shape: tuple[int, ...] = size
    elif name in LENSES:
        # A disk around the picture, of which the middle is taken.
        side = math.ceil(math.hypot(height, width))
        side += (side - width) % 2
        if (side - height) % 2:
            raise ValueError(
                f"Expected the sides of `size` to be both even or both odd for {name!r}, "
                f"got {size}."
            )
        wider = math.tan(math.radians(fov) / 4) * side / width
        camera = resolve(f"{name}(fov={math.degrees(4 * math.atan(wider))!r})")
        shape = (side, side)
        crop = _middle(shape, size)
    else:
        camera, shape = screen, _fitting(screen, (zoom * height, zoom * width))
        # As much as the size holds, with as many pixels to each side of it.
        rows, columns = (
            (n := min(side, whole)) - (whole - n) % 2
            for side, whole in zip(size, shape, strict=True)
        )
        crop = _middle(shape, (rows, columns))
    return camera.in_world_of("latlong").turned(pose), shape, crop


def toned(
    found: NDArray[np.float32],
    held: NDArray[np.bool_],
    *,
    exposure: float,
    curve: str,
    false_color: bool,
) -> NDArray[np.uint8]:
    """Return light as a picture for a screen."""
    picture = (
        falsely(found, exposure) if false_color else tonemap(found, exposure=exposure, curve=curve)
    )
    picture[np.isnan(found).any(axis=-1)] = np.rint(np.array(MISSING) * 255)
    picture[~held] = np.rint(np.array(OUTSIDE) * 255)
    return picture


def _middle(shape: tuple[int, ...], size: tuple[int, int]) -> Crop:
    (top, height), (left, width) = (
        ((whole - side) // 2, side) for whole, side in zip(shape, size, strict=True)
    )
    return slice(top, top + height), slice(left, left + width)


def _fitting(screen: Projection, size: tuple[float, float]) -> tuple[int, ...]:
    """Return the shape of a flat map that fits into a size."""
    rows, columns = screen.shape(64)
    count = int(64 * min(size[0] / rows, size[1] / columns))
    return screen.shape(max(count, 1))
