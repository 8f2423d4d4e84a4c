"""An environment into the photo of a mirrored ball."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._arrays import as_image, as_size, expect_room, spatial_shape
from .._scalars import as_text, as_whole
from .._threads import on_all_threads
from ..map.images import images
from ..map.named import resolve
from ..map.variants import pose_matrix
from ..resample.verbs import sample
from .camera import Outline, view
from .metals import fresnel, reflectance_of
from .photo import as_pair_of_numbers, by_hand, expect_point_filter
from .supersample import counts, means

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._names import Filter
    from ..map.named import ProjectionLike

    Array = NDArray[np.float64]

__all__ = ["render"]

# Pixels that a thread takes at a time.
_PIXELS = 1 << 14


# What lies beyond the numbers is seen as infinite, or nowhere.
@np.errstate(over="ignore", invalid="ignore")
def render(
    image: ArrayLike,
    /,
    projection: ProjectionLike = "latlong",
    *,
    size: int | tuple[int, int] = 512,
    center: tuple[float, float] | None = None,
    radius: float | None = None,
    fov: float | None = None,
    distance: float | None = None,
    principal: tuple[float, float] | None = None,
    pose: Any | None = None,
    reflectance: ArrayLike = 1.0,
    metal: str | None = None,
    background: Literal["environment", "black", "alpha"] = "environment",
    filter: Filter | str = "bilinear",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[Any]:
    """Return the photo that a camera would take of a mirrored ball in an environment.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces
        Linear radiance of the environment, infinitely far away. With one more axis in front it is a
        batch, as for `convert`.
    projection : Projection or str
        Its projection. Worlds are matched, as in `convert`: of an image in ``"latlong:blender"``,
        too, the camera sees what is up above.
    size : int or (height, width)
        Of the photo, in pixels.
    center, radius, fov, distance, principal
        As for `unwrap`. By default the ball is in the middle and just fits, seen by the ideal
        camera.
    pose : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        The camera's orientation in the world, which is +y up and -z ahead whatever `projection` is.
        Without it, the camera looks ahead.
    reflectance : float or one for each channel
        Of the ball.
    metal : {"Ag", "Al", "Au", "Cr", "Cu"}, optional
        Times the reflectance of this metal for red, green and blue, at each angle.
    background : {"environment", "black", "alpha"}
        What is beside the ball. "alpha" is black with a channel more: how much of each pixel the
        ball covers. The colors are multiplied by it, as compositing wants them.
    filter : str
        How the environment is looked up, as for `sample`.
    any_aspect, channels_first : bool
        As for `convert`, of the environment; channels then come first in the photo, too.

    Returns
    -------
    photo : ndarray of float32 or float64, shape (height, width) or (height, width, C)
        Of a batch as many.

    Raises
    ------
    ValueError, TypeError
        As for `sample` and `unwrap`.

    Notes
    -----
    Each pixel is the mean of 1 to 32 × 32 lookups, by how much of the environment it sees: a box
    filter.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> white = np.ones((32, 64, 3), np.float32)
    >>> gold = sm.ball.render(white, size=64, metal="Au", background="black")
    >>> (100 * gold[32, 32]).round().tolist(), gold[0, 0].tolist()
    ([98.0, 79.0, 34.0], [0.0, 0.0, 0.0])
    """
    if as_text(background, "background") not in ("environment", "black", "alpha"):
        raise ValueError(
            f"Expected `background` to be 'environment', 'black' or 'alpha', got {background!r}."
        )
    expect_point_filter(filter)
    source = resolve(projection).in_world_of("latlong")
    several = images(image, source, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        return several.each(render, locals())
    light = as_image(image, None)
    held = spatial_shape(light, source, "image")
    if light.dtype not in (np.float32, np.float64):
        light = light.astype(np.float32)
    scalar = light.ndim == len(held)
    if scalar:
        light = light[..., None]
    channels = light.shape[-1]
    shape = _photo_shape(size)
    middle = (
        (shape[1] / 2, shape[0] / 2) if center is None else as_pair_of_numbers(center, "center")
    )
    rim = None
    if radius is not None:
        rim = by_hand(middle, radius, principal, shape)._outline()
    elif fov is None or distance is None:
        rim = Outline(middle, min(shape) / 2, min(shape) / 2)
    camera = view(
        shape,
        rim,
        center=middle,
        fov=fov,
        distance=distance,
        principal=None if principal is None else as_pair_of_numbers(principal, "principal"),
    )
    reflects, metal = reflectance_of(reflectance, metal, channels)
    turn = pose_matrix(pose)
    # The side of a texel of the environment.
    fine = math.sqrt(source.covered_solid_angle / math.prod(held))

    def radiance(d: Array) -> Array:
        seen = sample(light, d @ turn.T, source, filter=filter, fill=np.nan, any_aspect=True)
        return np.asarray(seen, np.float64)

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

    whole = (math.prod(shape), channels + extra)
    expect_room(whole, np.dtype(np.float64))
    photo = np.empty(whole)

    # Each thread has an error state of its own.
    @np.errstate(over="ignore", invalid="ignore")
    def work(first: int) -> None:
        part = np.arange(first, min(first + _PIXELS, len(photo)))
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

        # A step coarser where that is hardly seen.
        number = np.repeat(counts(0.93 * wanted)[:, None], 2, axis=1)
        photo[part] = means(number, channels + extra, inside)

    on_all_threads(work, range(0, len(photo), _PIXELS))
    photo = photo.astype(light.dtype).reshape(*shape, channels + extra)
    return photo[..., 0] if scalar and not extra else photo


def _photo_shape(size: int | tuple[int, int]) -> tuple[int, int]:
    given = as_size(size)
    sides = [as_whole(n, "size") for n in (given if isinstance(given, tuple) else (given, given))]
    if len(sides) != 2 or min(sides) < 1:
        raise ValueError(f"`size` must be one or two whole numbers above 0, got {size}.")
    return sides[0], sides[1]
