"""A photo of a mirrored ball into a map of the sphere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_image
from .._show import line
from ..map.images import target_shape
from ..map.named import resolve
from ..map.variants import pose_matrix
from ..resample.views import unseen
from .camera import view
from .doubts import warn_of_ideal_camera
from .finding import Ball, ball_of, expect_photo, find
from .metals import reflectance_of
from .photo import (
    Shot,
    as_pair_of_numbers,
    by_hand,
    expect_inside,
    expect_point_filter,
    expect_seen,
    fitting_size,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Size
    from .._names import Filter
    from .._projection import Projection
    from ..map.named import ProjectionLike

    Array = NDArray[np.float64]

__all__ = ["UnwrappedBall", "unwrap"]


@dataclass(frozen=True, eq=False)
class UnwrappedBall:
    """What a photo of a mirrored ball saw, as `unwrap` returns it.

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
        The rim in the photo, as it was used: of a circle that was given or found off the camera's
        axis the ellipse of the same area that a ball has there.
    distance : float
        From the center of the ball to the camera, in radii of the ball; infinite for the ideal
        camera.
    fov : float or None
        The photo's horizontal angle in degrees; None for the ideal camera.
    blind_cone : float
        Half the angle, in degrees, of the cone behind the ball that the photo cannot have seen.
    blind_direction : ndarray, shape (3,)
        Its axis, in the world of `pose`.
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

    __repr__ = line

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which directions the photo saw."""
        return np.isfinite(self.solid_angle)

    @property
    def coverage(self) -> float:
        """The share of what `projection` covers that the photo saw: of the sphere, mostly."""
        weights = self.projection.solid_angle(self.solid_angle.shape, any_aspect=True)
        return float(weights[self.seen].sum() / weights.sum())


def unwrap(
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
    pose: Any | None = None,
    mask: ArrayLike | None = None,
    reflectance: ArrayLike = 1.0,
    metal: str | None = None,
    filter: Filter | str = "bilinear",
    fill: float | Sequence[float] = 0.0,
    any_aspect: bool = False,
) -> UnwrappedBall:
    """Turn a photo of a mirrored ball into a map of the environment.

    Parameters
    ----------
    photo : array_like, shape (H, W) or (H, W, C)
        Linear light, of a pinhole camera (no lens distortion).
    center : (x, y), optional
        The middle of the ball's outline in pixels, from the upper left corner of the photo: the
        first pixel's own center is (0.5, 0.5). By default `find` looks for the outline.
    radius : float or (float, float), optional
        Of the outline in pixels: of the circle with its area, or its semi-axes toward the
        principal point and across. Left out, it follows from `fov` and `distance`.
    fov : float, optional
        The horizontal angle of the whole photo, in degrees.
    distance : float, optional
        From the camera to the center of the ball, **in radii of the ball**. ``math.inf`` is the
        ideal camera, and so is what is beyond 1e8.
    principal : (x, y), optional
        Where the camera's axis meets the photo, in pixels; by default its middle. A cropped photo
        needs it.
    dst : Projection or str
        The projection of the result. Of a program with another world, as ``"latlong:blender"``, it
        lies as that program has it: worlds are matched, as in `convert`.
    size : int or tuple of int, optional
        As for `solid_angle`. By default about one texel for each pixel of the ball.
    pose : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        The camera's orientation in the world, which is +y up and -z ahead whatever `dst` is.
    mask : array_like, shape (H, W), optional
        Which pixels count: bool, numbers from 0 to 1, or uint8 from 0 to 255.
    reflectance : float or one for each channel
        Of the ball: the result is divided by it.
    metal : {"Ag", "Al", "Au", "Cr", "Cu"}, optional
        Of which the ball is: the result is divided by its reflectance at each angle, too.
    filter : str
        How the photo is looked up between its pixels, as for `sample`. Where the photo is finer
        than the result, up to 32 × 32 lookups are averaged in each texel.
    fill : float or sequence of float
        What the image has where the photo saw nothing, or one number for each channel.
    any_aspect : bool
        As for `convert`, of a `size` with both sides.

    Returns
    -------
    UnwrappedBall

    Raises
    ------
    ValueError
        For a photo in which no ball is found, a ball outside of the photo or of which it shows
        nothing, a mask of another shape, `fov`, `distance` and outline that contradict each other,
        or numbers out of range.
    TypeError
        For an unsupported dtype.
    ImportError
        If a ball has to be found and scikit-image is missing.

    Notes
    -----
    Of field of view, distance and outline two give the third. If neither `fov` nor `distance` is
    given, the camera is at infinity, as the `sphere` projection has it; no real camera is, and the
    result is then off by asin(1/distance) at the rim: a ball that fills a picture of 40° by 20°.
    A `UserWarning` says so, unless `distance` is infinite. Two photos tell the distance: `merge`.
    `docs/mirror-balls.md` has the geometry and measurements.

    The world is the camera's frame, x right, y up, z **toward** the camera, unless `pose` turns
    it: the camera looks ahead.

    Examples
    --------
    A photo of a ball from 6 radii away, and back:

    >>> import numpy as np, spheremap as sm
    >>> scene = 1 + sm.directions("latlong", 64) ** 3
    >>> photo = sm.ball.render(scene, size=200, fov=30, distance=6)
    >>> found = sm.ball.unwrap(photo, center=(100, 100), radius=63.09, fov=30, size=64)
    >>> round(found.distance, 2), round(found.blind_cone, 1)
    (6.0, 9.6)
    >>> known = found.spacing < 0.04
    >>> bool(np.abs(found.image - scene)[known].max() < 0.02)
    True
    """
    pixels, target = as_image(photo, None, "photo"), resolve(dst)
    expect_photo(pixels.shape, "`photo`")
    expect_point_filter(filter)
    ball = None
    if center is None:
        if radius is not None:
            raise ValueError("`radius` without `center`: give both, or neither to find the ball.")
        ball = find(pixels, mask=mask)
    elif radius is not None:
        ball = by_hand(center, radius, principal, pixels.shape)
        expect_inside(ball._outline(), pixels.shape[:2])
    seen_by = view(
        pixels.shape[:2],
        None if ball is None else ball._outline(),
        center=None if center is None else as_pair_of_numbers(center, "center"),
        fov=fov,
        distance=distance,
        principal=None if principal is None else as_pair_of_numbers(principal, "principal"),
    )
    ball = ball_of(seen_by.outline, 1.0 if ball is None else ball.confidence)
    turn = pose_matrix(pose)
    if size is None:
        size = fitting_size(target, math.pi * seen_by.outline.mean**2)
    shape = target_shape(target, size, any_aspect)
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    filling = unseen(fill, pixels.dtype, channels)
    reflects, metal = reflectance_of(reflectance, metal, channels)
    shot = Shot(pixels, seen_by, mask, reflects, metal, filter)
    expect_seen(shot)
    if seen_by.ideal and distance is None:
        warn_of_ideal_camera(seen_by, 2)
    image, least, most = shot.unwrap(target.in_world_of("latlong"), shape, turn)
    image = _stored(image, least > 0, filling)
    # In place: at the size of a large photo each is a hundred megabytes.
    with np.errstate(divide="ignore"):
        solid_angle = np.divide(1, np.multiply(least, most, out=most), out=most)
        spacing = np.divide(1, least, out=least)
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


def _stored(
    image: NDArray[np.floating[Any]], seen: NDArray[np.bool_], filling: NDArray[Any]
) -> NDArray[Any]:
    """Return texels in the dtype of the photo, that of `filling`. They are overwritten."""
    dtype = filling.dtype
    image[~seen] = filling
    if dtype.kind == "u":
        np.floor(np.add(image, 0.5, out=image), out=image)
        np.clip(image, 0, np.iinfo(dtype).max, out=image)
    return image.astype(dtype, copy=False)
