"""A photo of a mirrored ball whose camera is known, and what callers say about it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.named import projection
from ..resample.verbs import sample
from ..resample.views import mask_weights
from .finding import Ball
from .metals import fresnel
from .supersample import BLOCK, Texels, counts, means

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._names import Filter
    from .._projection import Projection
    from .camera import View

    Array = NDArray[np.float64]

# Pixels across the rim hold what is behind the ball as well: none is looked up nearer to it.
_INSET = 0.5


class Shot:
    """A photo of a ball whose camera is known."""

    def __init__(
        self,
        pixels: NDArray[Any],
        seen_by: View,
        mask: ArrayLike | None,
        reflectance: Array,
        metal: str | None,
        filter: Filter = "bilinear",
    ) -> None:
        self.view, self.filter = seen_by, filter
        self.reflectance, self.metal = reflectance, metal
        self.pixels = pixels.astype(
            np.float64 if pixels.dtype == np.float64 else np.float32
        ).reshape(*pixels.shape[:2], -1)
        self.channels = self.pixels.shape[-1]
        self.mask = None if mask is None else mask_weights(mask, pixels.shape[:2])
        if self.mask is not None:
            self.pixels[self.mask == 0] = np.nan
        height, width = pixels.shape[:2]
        self._plane = projection("perspective", fov=90.0, aspect=width / height)

    def look(self, d: Array) -> Array:
        """Return what the photo shows of unit directions in the camera's frame; NaN if nothing."""
        values = self._at(self.pixels, self.view.pixels(d), self.filter)
        if self.metal is not None:
            values /= np.maximum(fresnel(self.view.incidence(d), self.metal), 1e-9)
        return values / self.reflectance

    def weight(self, d: Array) -> Array:
        """Return the mask in unit directions: 0 where the photo saw nothing."""
        xy = self.view.pixels(d)
        if self.mask is None:
            height, width = self.pixels.shape[:2]
            inside = (xy >= 0) & (xy <= (width, height))
            return np.asarray(inside.all(axis=-1), np.float64)
        return np.nan_to_num(self._at(self.mask[..., None], xy, "bilinear")[..., 0])

    def _at(self, image: NDArray[Any], xy: Array, filter: Filter) -> Array:
        height, width = image.shape[:2]
        outline = self.view.outline
        place = outline.relative(xy)
        radius = np.hypot(place[..., 0], place[..., 1])
        most = 1 - min(_INSET / min(outline.along, outline.across), 0.5)
        with np.errstate(invalid="ignore", divide="ignore"):
            shrink = np.minimum(most / radius, 1)
        near = shrink < 1
        xy[near] = outline.center + (xy[near] - outline.center) * shrink[near][..., None]
        ray = np.empty((*xy.shape[:-1], 3))
        ray[..., 0] = 2 * xy[..., 0] / width - 1
        ray[..., 1] = (1 - 2 * xy[..., 1] / height) * (height / width)
        ray[..., 2] = -1
        return np.asarray(sample(image, ray, self._plane, filter=filter, fill=np.nan), np.float64)

    def unwrap(
        self, p: Projection, shape: tuple[int, ...], turn: Array
    ) -> tuple[Array, Array, Array]:
        """Return the texels, (N, C), and the pixels per radian there: least and most."""
        texels, total = Texels(p, shape), math.prod(shape)
        image = np.full((total, self.channels), np.nan)
        least, most = np.zeros(total), np.zeros(total)
        for first in range(0, total, BLOCK):
            part = np.arange(first, min(first + BLOCK, total))
            d = texels.directions(part)
            held = np.isfinite(d[:, 0])
            part, d = part[held], d[held] @ turn
            low, high = self.view.pixels_per_radian(d)
            seen = (self.weight(d) > 0) & (low > 0)
            part, low, high = part[seen], low[seen], high[seen]
            number = counts(high * texels.extent(part))

            def look(index: NDArray[np.intp], offset: Array, part: Any = part) -> Array:
                there = texels.directions(part[index], offset)
                known = np.isfinite(there[:, 0])
                values = np.full((len(index), self.channels), np.nan)
                values[known] = self.look(there[known] @ turn)
                return values

            image[part] = means(number, self.channels, look)
            least[part], most[part] = low, high
        unknown = np.isnan(image).all(axis=-1)
        least[unknown] = most[unknown] = 0
        return image, least, most


def by_hand(
    center: tuple[float, float],
    radius: float | tuple[float, float],
    principal: tuple[float, float] | None,
    shape: tuple[int, ...],
) -> Ball:
    """Return the ball that a caller described, turned toward the principal point."""
    x, y = as_pair_of_numbers(center, "center")
    radii = np.asarray(radius, np.float64)
    if radii.shape not in ((), (2,)) or not np.all((radii > 0) & np.isfinite(radii)):
        raise ValueError(f"`radius` must be one or two numbers above 0, got {radius}.")
    along, across = (float(r) for r in np.broadcast_to(radii, 2))
    px, py = (
        (shape[1] / 2, shape[0] / 2)
        if principal is None
        else as_pair_of_numbers(principal, "principal")
    )
    return Ball((x, y), (along, across), math.degrees(math.atan2(y - py, x - px)), 1.0)


def as_pair_of_numbers(value: tuple[float, float], name: str) -> tuple[float, float]:
    """Return x and y as floats, or raise."""
    array = np.asarray(value)
    if array.shape != (2,) or array.dtype.kind not in "fiu" or not np.all(np.isfinite(array)):
        raise ValueError(f"`{name}` must be two finite numbers (x, y), got {value}.")
    return float(array[0]), float(array[1])


def fitting_size(target: Projection, pixels: float) -> int:
    """Return the size at which an image has as many texels a steradian as a ball has pixels."""
    unit = math.prod(target.shape(64)) / 64**2
    share = target.covered_solid_angle / (4 * math.pi)
    return max(1, round(math.sqrt(pixels * share / unit)))
