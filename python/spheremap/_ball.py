"""Photos of mirrored balls into maps of the sphere, and environments into such photos."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _core, _grid
from ._api import _resolve, sample
from ._arrays import as_image
from ._ball_find import Ball, find_ball
from ._ball_geometry import Outline, View, view
from ._metals import fresnel, reflectance_of
from ._supersample import BLOCK, Texels, counts, means
from ._views import _weights

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._api import ProjectionLike, Size
    from ._core import Projection
    from ._names import Filter

    Array = NDArray[np.float64]

__all__ = ["UnwrappedBall", "render_ball", "unwrap_ball"]

# Pixels across the rim hold what is behind the ball as well: none is looked up nearer to it.
_INSET = 0.5


@dataclass(frozen=True, eq=False)
class UnwrappedBall:
    """What a photo of a mirrored ball saw, as `unwrap_ball` returns it.

    Attributes
    ----------
    image : ndarray, the shape of `projection` + channels
        The environment.
    solid_angle : ndarray of float64, the shape of `projection`
        The solid angle in steradians that one pixel of the photo saw in each direction: where it is
        below the texel's own, the photo knows more than the image can hold. Infinite where the
        photo saw nothing.
    spacing : ndarray of float64, the shape of `projection`
        The largest angle in radians between neighboring pixels there: the photo's resolution in its
        worst direction, which is what blurs toward the rim.
    projection : Projection
        Of the image.
    ball : Ball
        The rim in the photo.
    distance : float
        From the center of the ball to the camera, in radii of the ball; infinite for the ideal
        camera.
    fov : float or None
        The photo's horizontal angle in degrees; None for the ideal camera.
    blind_cone : float
        Half the angle, in degrees, of the cone behind the ball that the photo cannot have seen.
    blind_direction : ndarray, shape (3,)
        Its axis, in the world.
    """

    image: NDArray[Any]
    solid_angle: NDArray[np.float64]
    spacing: NDArray[np.float64]
    projection: Projection
    ball: Ball
    distance: float
    fov: float | None
    blind_cone: float
    blind_direction: NDArray[np.float64]

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which directions the photo saw."""
        return np.isfinite(self.solid_angle)

    @property
    def coverage(self) -> float:
        """The share of the sphere that the photo saw."""
        weights = self.projection.solid_angle(self.solid_angle.shape)
        return float(weights[self.seen].sum() / weights.sum())


def unwrap_ball(
    photo: ArrayLike,
    /,
    *,
    center: tuple[float, float] | None = None,
    radius: float | tuple[float, float] | None = None,
    fov: float | None = None,
    distance: float | None = None,
    principal: tuple[float, float] | None = None,
    dst: ProjectionLike = "latlong",
    size: Size | None = None,
    rotation: Any | None = None,
    mask: ArrayLike | None = None,
    reflectance: ArrayLike = 1.0,
    metal: str | None = None,
    filter: Filter = "bilinear",
    fill: float | None = None,
) -> UnwrappedBall:
    """Turn a photo of a mirrored ball into a map of the environment.

    Parameters
    ----------
    photo : array_like, shape (H, W) or (H, W, C)
        Linear light, of a pinhole camera (no lens distortion).
    center : (x, y), optional
        The middle of the ball's outline in pixels, from the upper left corner of the photo: the
        first pixel's own center is (0.5, 0.5). By default `find_ball` looks for the outline.
    radius : float or (float, float), optional
        Of the outline in pixels: of the circle with its area, or its semi-axes toward the
        principal point and across. Left out, it follows from `fov` and `distance`.
    fov : float, optional
        The horizontal angle of the whole photo, in degrees.
    distance : float, optional
        From the camera to the center of the ball, **in radii of the ball**.
    principal : (x, y), optional
        Where the camera's axis meets the photo, in pixels; by default its middle. A cropped photo
        needs it.
    dst : Projection or str
        The projection of the result.
    size : int or tuple of int, optional
        As for `solid_angle`. By default about one texel for each pixel of the ball.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        The camera's orientation in the world.
    mask : array_like, shape (H, W), optional
        Which pixels count: bool, numbers from 0 to 1, or uint8 from 0 to 255.
    reflectance : float or one for each channel
        Of the ball: the result is divided by it.
    metal : {"Ag", "Al", "Au", "Cr", "Cu"}, optional
        Of which the ball is: the result is divided by its reflectance at each angle, too.
    filter : str
        How the photo is looked up between its pixels, as for `sample`. Where the photo is finer
        than the result, up to 32 × 32 lookups are averaged in each texel.
    fill : float, optional
        What the image has where the photo saw nothing. By default NaN, or 0 for integers.

    Returns
    -------
    UnwrappedBall

    Raises
    ------
    ValueError
        For a photo in which no ball is found, a mask of another shape, `fov`, `distance` and
        outline that contradict each other, or numbers out of range.
    TypeError
        For an unsupported dtype.
    ImportError
        If a ball has to be found and scikit-image is missing.

    Notes
    -----
    Of field of view, distance and outline two give the third. If neither `fov` nor `distance` is
    given, the camera is at infinity, as the `sphere` projection has it; no real camera is, and the
    result is then off by asin(1/distance) at the rim: a ball that fills a picture of 40° by 20°.
    `docs/mirror-balls.md` has the geometry and measurements.

    The result is in the camera's frame, x right, y up, z **toward** the camera, unless `rotation`
    turns it.

    Examples
    --------
    A photo of a ball from 6 radii away, and back:

    >>> import numpy as np, spheremap as sm
    >>> scene = 1 + sm.directions("latlong", 64) ** 3
    >>> photo = sm.render_ball(scene, size=200, fov=30, distance=6)
    >>> found = sm.unwrap_ball(photo, center=(100, 100), radius=63.09, fov=30, size=64)
    >>> round(found.distance, 2), round(found.blind_cone, 1)
    (6.0, 9.6)
    >>> known = found.spacing < 0.04
    >>> bool(np.abs(found.image - scene)[known].max() < 0.02)
    True
    """
    pixels, target = as_image(photo, None), _resolve(dst)
    if pixels.ndim not in (2, 3) or 0 in pixels.shape:
        raise ValueError(f"Expected `photo` to have shape (H, W) or (H, W, C), got {pixels.shape}.")
    ball = None
    if center is None:
        if radius is not None:
            raise ValueError("`radius` without `center`: give both, or neither to find the ball.")
        ball = find_ball(pixels, mask=mask)
    elif radius is not None:
        ball = _by_hand(center, radius, principal, pixels.shape)
    seen_by = view(
        pixels.shape[:2],
        None if ball is None else ball._outline(),
        center=None if center is None else _pair(center, "center"),
        fov=fov,
        distance=distance,
        principal=None if principal is None else _pair(principal, "principal"),
    )
    if ball is None:
        rim = seen_by.outline
        ball = Ball(rim.center, (rim.along, rim.across), math.degrees(rim.angle), 1.0)
    turn = _matrix(rotation)
    if size is None:
        size = _fitting(target, math.pi * seen_by.outline.mean**2)
    shape = target.shape(size)
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    reflects, metal = reflectance_of(reflectance, metal, channels)
    shot = Shot(pixels, seen_by, mask, reflects, metal, filter)
    image, least, most = shot.unwrap(target, shape, turn)
    seen = least > 0
    with np.errstate(divide="ignore"):
        solid_angle, spacing = 1 / (least * most), 1 / least
    image = _stored(image, seen, pixels.dtype, fill)
    return UnwrappedBall(
        image=image.reshape(shape + pixels.shape[2:]),
        solid_angle=solid_angle.reshape(shape),
        spacing=spacing.reshape(shape),
        projection=target,
        ball=ball,
        distance=seen_by.distance,
        fov=seen_by.fov,
        blind_cone=math.degrees(seen_by.blind),
        blind_direction=turn @ -seen_by.toward,
    )


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
        self.mask = None if mask is None else _weights(mask, pixels.shape[:2])
        if self.mask is not None:
            self.pixels[self.mask == 0] = np.nan
        height, width = pixels.shape[:2]
        self._plane = _core.projection(
            "perspective", parameters={"fov": 90.0, "aspect": width / height}
        )

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


def render_ball(
    environment: ArrayLike,
    projection: ProjectionLike = "latlong",
    /,
    *,
    size: int | tuple[int, int] = 512,
    center: tuple[float, float] | None = None,
    radius: float | None = None,
    fov: float | None = None,
    distance: float | None = None,
    principal: tuple[float, float] | None = None,
    rotation: Any | None = None,
    reflectance: ArrayLike = 1.0,
    metal: str | None = None,
    background: Literal["environment", "black", "alpha"] = "environment",
    filter: Filter = "bilinear",
) -> NDArray[Any]:
    """Return the photo that a camera would take of a mirrored ball in an environment.

    Parameters
    ----------
    environment : array_like, shape (H, W) or (H, W, C), or with faces
        Linear radiance, infinitely far away.
    projection : Projection or str
        Its projection.
    size : int or (height, width)
        Of the photo, in pixels.
    center, radius, fov, distance, principal
        As for `unwrap_ball`. By default the ball is in the middle and just fits, seen by the ideal
        camera.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        The camera's orientation in the world. Without it, the camera looks along -z.
    reflectance : float or one for each channel
        Of the ball.
    metal : {"Ag", "Al", "Au", "Cr", "Cu"}, optional
        Times the reflectance of this metal for red, green and blue, at each angle.
    background : {"environment", "black", "alpha"}
        What is beside the ball. "alpha" is black with a channel more: how much of each pixel the
        ball covers. The colors are multiplied by it, as compositing wants them.
    filter : str
        How the environment is looked up, as for `sample`.

    Returns
    -------
    photo : ndarray of float32 or float64, shape (height, width) or (height, width, C)

    Raises
    ------
    ValueError, TypeError
        As for `sample` and `unwrap_ball`.

    Notes
    -----
    Each pixel is the mean of 1 to 32 × 32 lookups, by how much of the environment it sees: a box
    filter.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> white = np.ones((32, 64, 3), np.float32)
    >>> gold = sm.render_ball(white, size=64, metal="Au", background="black")
    >>> (100 * gold[32, 32]).round().tolist(), gold[0, 0].tolist()
    ([98.0, 79.0, 34.0], [0.0, 0.0, 0.0])
    """
    if background not in ("environment", "black", "alpha"):
        raise ValueError(
            f"Expected `background` to be 'environment', 'black' or 'alpha', got {background!r}."
        )
    source = _resolve(projection)
    light = as_image(environment, None)
    held = _grid.spatial_shape(light, source, "environment")
    if light.dtype not in (np.float32, np.float64):
        light = light.astype(np.float32)
    scalar = light.ndim == len(held)
    if scalar:
        light = light[..., None]
    channels = light.shape[-1]
    shape = _photo_shape(size)
    middle = (shape[1] / 2, shape[0] / 2) if center is None else _pair(center, "center")
    rim = None
    if radius is not None:
        rim = _by_hand(middle, radius, principal, shape)._outline()
    elif fov is None or distance is None:
        rim = Outline(middle, min(shape) / 2, min(shape) / 2)
    camera = view(
        shape,
        rim,
        center=middle,
        fov=fov,
        distance=distance,
        principal=None if principal is None else _pair(principal, "principal"),
    )
    reflects, metal = reflectance_of(reflectance, metal, channels)
    turn = _matrix(rotation)
    # The side of a texel of the environment.
    fine = math.sqrt(source.covered_solid_angle / math.prod(held))

    def radiance(d: Array) -> Array:
        return np.asarray(sample(light, d @ turn.T, source, filter=filter, fill=np.nan), np.float64)

    extra = 1 if background == "alpha" else 0

    def look(index: NDArray[np.intp], offset: Array) -> Array:
        xy = np.stack([index % shape[1], index // shape[1]], axis=-1) + 0.5 + offset
        values = np.zeros((len(index), channels + extra))
        d, cosine = camera.reflections(xy)
        hit = np.isfinite(cosine)
        seen = radiance(d[hit]) * reflects
        if metal is not None:
            seen *= fresnel(cosine[hit], metal)
        values[hit, :channels] = seen
        if extra:
            values[hit, channels] = 1
        if background == "environment":
            values[~hit, :channels] = radiance(camera.rays(xy[~hit]))
        return values

    photo = np.empty((math.prod(shape), channels + extra))
    for first in range(0, len(photo), BLOCK):
        part = np.arange(first, min(first + BLOCK, len(photo)))
        xy: Array = np.stack([part % shape[1], part // shape[1]], axis=-1) + np.float64(0.5)
        d, cosine = camera.reflections(xy)
        hit = np.isfinite(cosine)
        wanted = np.ones(len(part))
        least, _ = camera.pixels_per_radian(d[hit])
        wanted[hit] = 1 / np.maximum(least * fine, 1e-9)
        # What a pixel sees beside the ball.
        if not camera.ideal:
            wanted[~hit] = 1 / (camera.focal * fine)
        place = camera.outline.relative(xy)
        off = np.abs(np.sqrt(np.sum(place * place, axis=-1)) - 1) * camera.outline.mean
        wanted[off < 1.5] = np.maximum(wanted[off < 1.5], 16)

        def inside(index: NDArray[np.intp], offset: Array, part: Any = part) -> Array:
            return look(part[index], offset)

        photo[part] = means(counts(wanted), channels + extra, inside)
    photo = photo.astype(light.dtype).reshape(*shape, channels + extra)
    return photo[..., 0] if scalar and not extra else photo


def _by_hand(
    center: tuple[float, float],
    radius: float | tuple[float, float],
    principal: tuple[float, float] | None,
    shape: tuple[int, ...],
) -> Ball:
    x, y = _pair(center, "center")
    radii = np.asarray(radius, np.float64)
    if radii.shape not in ((), (2,)) or not np.all((radii > 0) & np.isfinite(radii)):
        raise ValueError(f"`radius` must be one or two numbers above 0, got {radius}.")
    along, across = (float(r) for r in np.broadcast_to(radii, 2))
    px, py = (shape[1] / 2, shape[0] / 2) if principal is None else _pair(principal, "principal")
    return Ball((x, y), (along, across), math.degrees(math.atan2(y - py, x - px)), 1.0)


def _pair(value: tuple[float, float], name: str) -> tuple[float, float]:
    array = np.asarray(value)
    if array.shape != (2,) or array.dtype.kind not in "fiu" or not np.all(np.isfinite(array)):
        raise ValueError(f"`{name}` must be two finite numbers (x, y), got {value}.")
    return float(array[0]), float(array[1])


def _photo_shape(size: int | tuple[int, int]) -> tuple[int, int]:
    array = np.asarray(size)
    if array.dtype.kind not in "iu" or array.shape not in ((), (2,)) or np.any(array < 1):
        raise ValueError(f"`size` must be one or two whole numbers above 0, got {size}.")
    height, width = (int(n) for n in np.broadcast_to(array, 2))
    return height, width


def _matrix(rotation: Any | None) -> Array:
    if rotation is None:
        return np.eye(3)
    # The core checks it and turns the axes with it; the rows are the turned axes.
    p = _core.projection("octahedral")
    return np.asarray(p.decode(p.encode(np.eye(3)), rotation=rotation)).T


def _fitting(target: Projection, pixels: float) -> int:
    """Return the size at which an image has as many texels a steradian as a ball has pixels."""
    unit = math.prod(target.shape(64)) / 64**2
    share = target.covered_solid_angle / (4 * math.pi)
    return max(1, round(math.sqrt(pixels * share / unit)))


def _stored(
    image: Array, seen: NDArray[np.bool_], dtype: np.dtype[Any], fill: float | None
) -> NDArray[Any]:
    """Return float64 texels in the dtype of the photo."""
    if fill is None:
        fill = math.nan if dtype.kind == "f" else 0
    image = np.where(seen[:, None], image, fill)
    if dtype.kind == "u":
        image = np.clip(np.floor(image + 0.5), 0, np.iinfo(dtype).max)
    return image.astype(dtype)
