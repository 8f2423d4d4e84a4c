"""A photo of a mirrored ball whose camera is known, and what callers say about it."""

from __future__ import annotations

import copy
import math
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from .. import _core
from .._arrays import as_array, as_doubles
from .._names import Filter
from .._scalars import as_text, kind_of
from .._threads import on_all_threads
from ..map.named import projection
from ..resample.verbs import sample
from ..resample.views import mask_weights
from .aiming import Aim
from .finding import Ball
from .supersample import Texels, counts, means, spreads

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
    from .aiming import Spot
    from .camera import Outline, View

    Array = NDArray[np.float64]

# Pixels across the rim hold what is behind the ball as well: none is looked up nearer to it.
_INSET = 0.5
# Lookups lie at most this much more than a pixel apart, as in `convert`.
_SLACK = 0.15
# Filters of which so many lie in a pixel each way: one would miss their lobes.
_DENSE = {"bicubic": 2, "catmull-rom": 2, "lanczos3": 2}


def expect_point_filter(filter: object) -> None:
    """Raise for a filter that goes by how much a lookup sees, which nobody says here."""
    known = {each["name"]: each["method"] for each in _core.filters()}
    if known.get(as_text(filter, "filter")) == "mipmapped":
        fit = ", ".join(get_args(Filter))
        raise ValueError(f"Expected `filter` to be one of {fit}, got {filter!r}.")


class Shot:
    """A photo of a ball whose camera is known."""

    def __init__(
        self,
        pixels: NDArray[Any],
        seen_by: View,
        mask: ArrayLike | None,
        reflectance: Array,
        metal: str | None,
        filter: Filter | str = "bilinear",
    ) -> None:
        expect_point_filter(filter)
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

    def seen_by(self, view: View) -> Shot:
        """Return the same photo, taken by another camera."""
        other = copy.copy(self)
        other.view = view
        return other

    def aim(self, turn: Array) -> Aim:
        """Return where directions of a world are seen, in which the camera is turned."""
        return Aim(self.view, turn, _INSET, self.metal)

    def look(self, d: Array) -> Array:
        """Return what the photo shows of unit directions in the camera's frame; NaN if nothing."""
        aim = self.aim(np.eye(3))
        rays, spot = aim.places(d.reshape(-1, 3))
        colors = self._colors(aim, rays, spot)
        return np.asarray(colors, np.float64).reshape(*d.shape[:-1], -1)

    def weight(self, d: Array) -> Array:
        """Return the mask in unit directions: 0 where the photo saw nothing."""
        aim = self.aim(np.eye(3))
        rays, _ = aim.places(d.reshape(-1, 3))
        weights = self._weights(rays, *aim.pixels(rays))
        return np.asarray(weights, np.float64).reshape(d.shape[:-1])

    def _colors(self, aim: Aim, rays: Array, spot: Spot) -> NDArray[np.floating[Any]]:
        values = sample(self.pixels, rays, self._plane, filter=self.filter, fill=np.nan)
        if self.metal is not None:
            values /= np.maximum(aim.reflectance(spot), 1e-9)
        if np.any(self.reflectance != 1):
            values /= self.reflectance
        return values

    def _weights(self, rays: Array, x: Array, y: Array) -> NDArray[np.floating[Any]]:
        height, width = self.pixels.shape[:2]
        if self.mask is None:
            inside = (x >= 0) & (x <= width) & (y >= 0) & (y <= height)
            return np.asarray(inside, np.float32)
        weights = sample(self.mask, rays, self._plane, fill=np.nan)
        return np.asarray(np.nan_to_num(weights, copy=False))

    def unwrap(
        self, p: Projection, shape: tuple[int, ...], turn: Array
    ) -> tuple[NDArray[np.floating[Any]], Array, Array]:
        """Return the texels, (N, C), and the pixels per radian there: least and most."""
        texels, total = Texels(p, shape), math.prod(shape)
        image = np.empty((total, self.channels), self.pixels.dtype)
        least, most = np.empty(total), np.empty(total)
        aim = self.aim(turn)

        def work(block: tuple[int, int, slice]) -> None:
            part = slice(block[0] * shape[-1], block[1] * shape[-1])
            image[part], least[part], most[part] = self._unwrapped(aim, texels, block)

        on_all_threads(work, texels.row_blocks())
        return image, least, most

    def _unwrapped(
        self, aim: Aim, texels: Texels, block: tuple[int, int, slice]
    ) -> tuple[NDArray[np.floating[Any]], Array, Array]:
        """Return the same for a block of rows."""
        first, last, rows = block
        width = texels.shape[-1]
        rays, spot = aim.places(texels.directions_of_rows(rows))
        x, y = aim.pixels(rays)
        inner = slice((first - rows.start) * width, (last - rows.start) * width)
        sides = self._sides(x.reshape(-1, width), y.reshape(-1, width)).reshape(-1, 2)[inner]
        rays, x, y, spot = rays[inner], x[inner], y[inner], spot[inner]
        least, most = aim.pixels_per_radian(rays, x, y, spot)
        values = self._colors(aim, rays, spot)
        seen = (self._weights(rays, x, y) > 0) & (least > 0)
        spread = spreads(sides)
        number = counts(_DENSE.get(self.filter, 1) * spread * sides - _SLACK)
        several = np.flatnonzero((number > 1).any(axis=-1) & seen)

        def look(index: NDArray[np.intp], offset: Array) -> NDArray[np.floating[Any]]:
            texel = several[index]
            d = texels.directions(first * width + texel, offset * spread[texel])
            return self._colors(aim, *aim.places(d))

        values[several] = means(number[several], self.channels, look)
        values[~seen] = np.nan
        unknown = np.isnan(values).all(axis=-1)
        least[unknown] = most[unknown] = 0
        return values, least, most

    def _sides(self, x: Array, y: Array) -> Array:
        """Return how many pixels long the sides of texels are, from neighbors: (..., 2).

        Of the two on a side the nearer one counts: the other may be across a seam.
        """
        sides = np.full((*x.shape, 2), np.nan)
        for k, axis in ((0, 1), (1, 0)):
            far = np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis))
            side = np.moveaxis(sides[..., k], axis, 0)
            far = np.moveaxis(far, axis, 0)
            side[:-1] = far
            side[1:] = np.fmin(side[1:], far)
        outline = self.view.outline
        return np.where(np.isnan(sides), 2 * max(outline.along, outline.across), sides)


def by_hand(
    center: tuple[float, float],
    radius: float | tuple[float, float],
    principal: tuple[float, float] | None,
    shape: tuple[int, ...],
) -> Ball:
    """Return the ball that a caller described, turned toward the principal point."""
    x, y = as_pair_of_numbers(center, "center")
    if np.asarray(radius).dtype.kind == "b":
        raise TypeError(f"Expected `radius` to be one or two numbers, got {kind_of(radius)}.")
    radii = as_doubles(radius, "radius")
    if radii.shape not in ((), (2,)) or not np.all((radii > 0) & np.isfinite(radii)):
        raise ValueError(f"`radius` must be one or two numbers above 0, got {radius}.")
    along, across = (float(r) for r in np.broadcast_to(radii, 2))
    px, py = (
        (shape[1] / 2, shape[0] / 2)
        if principal is None
        else as_pair_of_numbers(principal, "principal")
    )
    return Ball((x, y), (along, across), math.degrees(math.atan2(y - py, x - px)), 1.0)


def expect_seen(shot: Shot) -> None:
    """Raise for a ball of which the photo shows nothing."""
    rim, (height, width) = shot.view.outline, shot.view.size
    expect_inside(rim, (height, width))
    xy = rim.points(64)
    (left, top), (right, bottom) = np.floor(xy.min(axis=0)), np.ceil(xy.max(axis=0))
    rows = slice(int(max(top, 0)), int(min(bottom, height)))
    columns = slice(int(max(left, 0)), int(min(right, width)))
    # A few pixels mostly do.
    for step in (8, 1):
        at = (slice(rows.start, rows.stop, step), slice(columns.start, columns.stop, step))
        y, x = (np.arange(part.start, part.stop, part.step) + 0.5 for part in at)
        place = rim.relative(np.stack(np.meshgrid(x, y), axis=-1))
        on_ball = np.sum(place * place, axis=-1) < 1
        if (on_ball & ~np.isnan(shot.pixels[at]).all(axis=-1)).any():
            return
    if shot.mask is not None and not (on_ball & (shot.mask[at] > 0)).any():
        raise ValueError("`mask` is 0 on all of the ball: no pixel counts.")
    raise ValueError("Expected the photo to have pixels of the ball that are not NaN, got none.")


def expect_inside(rim: Outline, size: tuple[int, int]) -> None:
    """Raise for a ball that is nowhere in a photo of this height and width."""
    height, width = size
    x, y = np.concatenate([rim.points(360), [rim.center]]).T
    seen = ((x >= 0) & (x <= width) & (y >= 0) & (y <= height)).any()
    corners = rim.relative(np.array([[0, 0], [width, 0], [0, height], [width, height]], np.float64))
    if not seen and not (np.hypot(*corners.T) < 1).any():
        x, y = rim.center
        raise ValueError(
            f"a ball with its center at ({x:g}, {y:g}) and a radius of {rim.mean:g} pixels lies "
            f"outside of the photo, which is {width} x {height}: look at `center` and `radius`."
        )


def as_pair_of_numbers(value: tuple[float, float], name: str) -> tuple[float, float]:
    """Return x and y as floats, or raise."""
    array = as_array(value, name)
    if array.shape != (2,) or array.dtype.kind not in "fiu" or not np.all(np.isfinite(array)):
        raise ValueError(f"`{name}` must be two finite numbers (x, y), got {value}.")
    return float(array[0]), float(array[1])


def fitting_size(target: Projection, pixels: float) -> int:
    """Return the size at which an image has as many texels a steradian as a ball has pixels."""
    unit = math.prod(target.shape(64)) / 64**2
    share = target.covered_solid_angle / (4 * math.pi)
    return max(1, round(math.sqrt(pixels * share / unit)))
