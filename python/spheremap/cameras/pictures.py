"""Pictures and cameras as callers give them: one picture each, with channels last and weights."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .._arrays import as_array, as_image
from .._scalars import as_items, as_number
from .._threads import on_all_threads
from ..map.images import expect_aspect
from ..map.named import resolve
from .lenses import lenses_of, parts_of
from .views import Rig, View
from .weights import ViewWeights, view_weights

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

    Cameras: TypeAlias = Rig | Sequence[View | ProjectionLike] | ProjectionLike

__all__ = ["Cameras", "Picture", "blocks", "exact", "pictures_of", "projections_of"]

# About so many numbers are worked on at a time by a thread: they stay in its cache.
BLOCK = 1 << 17


@dataclass(frozen=True, slots=True)
class Picture:
    """A view's pixels with channels last, where they are from, and how much each counts."""

    pixels: NDArray[Any]
    camera: Projection
    weights: ViewWeights

    def weighted(
        self, values: NDArray[np.float32] | float, into: NDArray[Any] | None = None
    ) -> NDArray[Any]:
        """Return pixels times their weights, and the weights as one more channel.

        A pixel counts as `values` times what it is, or as the one of them that it numbers. The
        result lies in `into`, where that has its shape.
        """
        height, width, channels = self.pixels.shape
        shape = (height, width, channels + 1)
        found = into if into is not None and into.shape == shape else None
        if found is None:
            found = np.empty(shape, exact(self.pixels.dtype))

        def work(rows: slice) -> None:
            pixels, weight = self.pixels[rows], self.weights.rows(rows.start, rows.stop)
            if pixels.dtype.kind == "f":
                finite = np.isfinite(pixels).all(axis=-1)
                if not finite.all():
                    weight *= finite
                    pixels = np.where(finite[..., None], pixels, 0)
            found[rows, :, -1] = weight
            if isinstance(values, np.ndarray):
                pixels = values[pixels]
            else:
                weight *= np.float32(values)
            # By channels: loops over three numbers cost more than what they do.
            for c in range(channels):
                np.multiply(pixels[..., c], weight, out=found[rows, :, c])

        on_all_threads(work, blocks(height, width * (channels + 1)))
        return found


def exact(dtype: np.dtype[Any]) -> type[np.floating[Any]]:
    """Return the type that mixes are computed in."""
    return np.float64 if dtype == np.float64 else np.float32


def blocks(rows: int, each: int) -> list[slice]:
    """Return slices of rows, of so many numbers each, for one thread at a time."""
    step = max(1, BLOCK // max(each, 1))
    return [slice(first, min(first + step, rows)) for first in range(0, rows, step)]


def projections_of(cameras: Any, name: str = "cameras") -> list[Projection]:
    """Return the cameras of a rig, or of a sequence, with their poses."""
    if isinstance(cameras, Rig):
        return [view.projection for view in cameras]
    if isinstance(cameras, View | str) or hasattr(cameras, "encode"):
        cameras = [cameras]
    found = []
    for one in as_items(cameras, name, "cameras"):
        camera = one.projection if isinstance(one, View) else resolve(one)
        if camera.faces > 1:
            raise ValueError(
                f"Expected `{name}` to see one picture each, got '{camera.name}', which has "
                f"{camera.faces} faces."
            )
        found.append(camera)
    if not found:
        raise ValueError(f"Expected at least one camera in `{name}`, got none.")
    return found


def pictures_of(
    images: Any, cameras: Any, masks: Any, fov: Any, any_aspect: object
) -> tuple[list[Picture], bool]:
    """Return the pictures with their cameras and weights, and whether they are gray."""
    if _is_both_lenses(cameras):
        raw = resolve(cameras)
        given: list[Any] = parts_of(as_array(images, "images"), raw)
        seen = list(lenses_of(raw))
    else:
        seen = projections_of(cameras)
        given = _separate(images, len(seen))
    count = len(seen)
    if len(given) != count:
        raise ValueError(
            f"Expected `images` to hold a picture for each camera, got {len(given)} for {count} "
            + ("camera; of one lens `back_to_back` makes two." if count == 1 else "cameras.")
        )
    angles = _each(fov, count, "fov")
    covers = _each(masks, count, "masks")
    arrays = [as_image(one, None, "images") for one in given]
    first = arrays[0]
    for k, array in enumerate(arrays):
        if array.ndim not in (2, 3) or 0 in array.shape:
            raise ValueError(
                f"Expected picture {k} of `images` to have shape (H, W) or (H, W, C), "
                f"got {array.shape}."
            )
        if array.shape[2:] != first.shape[2:] or array.dtype != first.dtype:
            raise ValueError(
                "Expected pictures of one dtype and as many channels, got shape "
                f"{first.shape} of {first.dtype} and {array.shape} of {array.dtype}."
            )
    found = []
    for array, camera, angle, mask in zip(arrays, seen, angles, covers, strict=True):
        expect_aspect(camera, array.shape, any_aspect, "images")
        shape = (array.shape[0], array.shape[1])
        pixels = array if array.ndim == 3 else array[..., None]
        weights = view_weights(camera, shape, _mask(mask, shape), _radians(angle))
        found.append(Picture(pixels, camera, weights))
    return found, first.ndim == 2


def _is_both_lenses(cameras: Any) -> bool:
    one = isinstance(cameras, str) or hasattr(cameras, "encode")
    return one and resolve(cameras).name == "dual_fisheye"


def _separate(images: Any, count: int) -> list[Any]:
    """Return the pictures of an array: a batch, or one that holds all side by side."""
    if not isinstance(images, np.ndarray):
        return list(as_items(images, "images", "pictures"))
    if images.ndim == 4 or (images.ndim == 3 and len(images) == count > 1):
        return list(images)
    if images.ndim not in (2, 3) or images.shape[1] % count:
        raise ValueError(
            f"Expected `images` to be {count} pictures, or one of them side by side, "
            f"got shape {images.shape}."
        )
    return np.split(images, count, axis=1)


def _each(value: Any, count: int, name: str) -> list[Any]:
    if value is None or isinstance(value, int | float | np.number):
        return [value] * count
    found = list(as_items(value, name, "entries"))
    if len(found) != count:
        raise ValueError(
            f"Expected `{name}` to have an entry for each of {count} cameras, got {len(found)}."
        )
    return found


def _mask(mask: ArrayLike | None, shape: tuple[int, int]) -> NDArray[np.bool_] | None:
    if mask is None:
        return None
    found = as_array(mask, "masks")
    if found.dtype != np.bool_:
        raise TypeError(f"Expected `masks` to be of bool, got dtype {found.dtype}.")
    if found.shape != shape:
        raise ValueError(f"Expected a mask of shape {shape} in `masks`, got {found.shape}.")
    return found


def _radians(angle: Any) -> float | None:
    if angle is None:
        return None
    degrees = as_number(angle, "fov")
    if not 0 < degrees <= 360:
        raise ValueError(f"Expected `fov` to be in (0, 360], got {degrees:g}.")
    return math.radians(degrees)
