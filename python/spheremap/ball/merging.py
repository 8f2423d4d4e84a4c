"""Several photos of a mirrored ball into one map of the whole sphere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_image
from .._progress import counted, part
from .._scalars import as_items, as_whole, kind_of
from .._show import line
from .._threads import on_all_threads
from ..align.rotation_search import Match, Panorama, median, search
from ..align.rotation_search import refined as refined_match
from ..map.evenly import points
from ..map.images import target_shape
from ..map.named import resolve
from ..map.variants import pose_matrix
from ..resample.verbs import sample
from ..resample.views import unseen
from .camera import number, optional_number, view
from .doubts import warn_of_ideal_camera, warn_of_unknown_distance
from .finding import Ball, ball_of, expect_photo, find
from .joint import LIKELY_ANGLE, Placed, refined
from .metals import reflectance_of
from .photo import Shot, expect_point_filter, expect_seen, fitting_size
from .supersample import Texels

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Size
    from .._names import Filter
    from .._projection import Projection
    from ..map.named import ProjectionLike
    from .camera import View

    Array = NDArray[np.float64]

__all__ = ["MergedBalls", "merge"]

# Rows of the panoramas that rotations are found on.
_LEVELS = (16, 32, 64, 128, 256)
# Below this correlation two photos do not show one scene.
_LEAST_CORRELATION = 0.5
# How much the photographer counts, where another photo sees what is behind him.
_PHOTOGRAPHER = 1e-4
# An estimate of the camera that may be farther off than this angle, in radians, is none.
_MOST_DOUBT = math.radians(3)
# A pose is refined with the gains of the channels, on so many points, and so often if these differ
# by more than this share: the white balance changes where a photo is bright.
_SAME_GAIN, _BALANCED_POINTS, _BALANCED = 0.01, 20_000, 3
# The weight of a photo goes with this power of its pixels per radian: at 4 what is sampled half as
# finely counts a sixteenth.
_POWER = 4
# How much of the time has passed when photos are aligned, when they and their cameras fit each
# other, and when they are aligned once more; the rest is joining.
_ALIGNED, _REFINED, _AGAIN = 0.2, 0.6, 0.7


@dataclass(frozen=True, eq=False)
class MergedBalls:
    """A map of the sphere from several photos, as `merge` returns it.

    Attributes
    ----------
    image : ndarray of float32 or float64, the shape of `projection` + channels
        In the frame of the first photo's camera (or in that of the given poses). It is float64 if
        one of the photos is.
    weights : ndarray of float32, shape (K,) + the shape of `projection`
        How much each photo counts in each direction; they sum to 1, or to 0 where none saw
        anything.
    coverage : float
        The share of what `projection` covers that some photo saw: of the sphere, mostly.
    residual : float
        The root mean square difference of the photos from their mean, in stops, where they overlap.
    poses : ndarray, shape (K, 3, 3)
        The orientation of each camera: from its frame to the world, which is +y up and -z ahead
        whatever `projection` is.
    exposures : ndarray, shape (K, C)
        What the channels of each photo were multiplied by; 1 for the first.
    correlations : ndarray, shape (K,)
        Of each photo with those before it: 1 for the first, NaN where the pose was given.
    balls : tuple of Ball
        The rims, as they were used: of a circle off the camera's axis the ellipse of the same area
        that a ball has there.
    distances : ndarray, shape (K,)
        From the center of the ball to each camera, in radii of the ball; infinite for the ideal
        camera.
    fov : float or None
        The horizontal angle of the first photo in degrees; None for the ideal camera.
    doubt : float
        How far, in degrees, directions at the first photo's rim may be off because the camera was
        estimated, one standard deviation: of the angle asin(1/distance). 0 where it was given, or
        taken to be ideal.
    projection : Projection
        Of the image.
    """

    image: NDArray[Any]
    weights: NDArray[np.float32]
    coverage: float
    residual: float
    poses: NDArray[np.float64]
    exposures: NDArray[np.float64]
    correlations: NDArray[np.float64]
    balls: tuple[Ball, ...]
    distances: NDArray[np.float64]
    fov: float | None
    doubt: float
    projection: Projection

    __repr__ = line

    def angle(self, photo: int) -> float:
        """Return the angle in degrees between the cameras of a photo and the first one.

        Parameters
        ----------
        photo : int
            The number of the photo, from 0.

        Returns
        -------
        angle : float
            In degrees, 0 to 180.

        Raises
        ------
        IndexError
            For a photo that there is not.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> scene = 1.2 + np.sin(6 * sm.directions("latlong", 32))
        >>> poses = [np.eye(3), sm.rotation(120, 0, 0)]
        >>> options = {"fov": 30, "distance": 5}
        >>> photos = [sm.ball.render(scene, size=160, pose=pose, **options) for pose in poses]
        >>> ball = sm.ball.Ball((80, 80), (60.95, 60.95), 0, 1)
        >>> merged = sm.ball.merge(photos, balls=[ball, ball], poses=poses, fov=30, size=32)
        >>> round(merged.angle(1), 3)
        120.0
        """
        if not 0 <= as_whole(photo, "photo") < len(self.poses):
            raise IndexError(f"there is no photo {photo}, but 0 to {len(self.poses) - 1}.")
        turn = self.poses[0].T @ self.poses[photo]
        return math.degrees(math.acos(np.clip((np.trace(turn) - 1) / 2, -1, 1)))


def merge(
    photos: Sequence[ArrayLike],
    /,
    *,
    poses: Sequence[Any] | None = None,
    balls: Sequence[Ball | None] | None = None,
    fov: float | Sequence[float | None] | None = None,
    distance: float | Sequence[float | None] | None = None,
    masks: Sequence[ArrayLike | None] | None = None,
    photographer: float = 6.0,
    reflectance: ArrayLike = 1.0,
    metal: str | None = None,
    dst: ProjectionLike = "latlong",
    size: Size | None = None,
    filter: Filter | str = "bilinear",
    fill: float | Sequence[float] = 0.0,
    any_aspect: bool = False,
) -> MergedBalls:
    """Join photos of a mirrored ball from several sides into one map of the whole sphere.

    Parameters
    ----------
    photos : sequence of array_like, shape (H, W) or (H, W, C)
        Linear light, of any sizes.
    poses : sequence, optional
        The orientation of each photo's camera in the world, as `pose` of `unwrap`. By default they
        are found, and so is one that is None; if all are, the result is in the frame of the first
        camera.
    balls : sequence of Ball or None, optional
        The rim in each photo. By default, and for None, `find` finds it. One with a confidence
        below 1 is refined together with the poses, unless the camera is ideal.
    fov, distance : float or sequence, optional
        As for `unwrap`; one for all or one for each photo. If neither is given, two or more photos
        tell: one angle is assumed for all of them, and found together with the poses. With None for
        one photo the other one of both has to be given for it.
    masks : sequence of array_like or None, optional
        For each photo what counts, of its shape (H, W): bool, 0 to 1, or uint8 from 0 to 255.
    photographer : float
        Half the angle in degrees, about the direction to each camera, that is left to the other
        photos. 0 for no such cone.
    reflectance, metal, dst, size, filter, fill, any_aspect
        As for `unwrap`. `fill` is where no photo saw anything: there `weights` are 0.

    Returns
    -------
    MergedBalls

    Raises
    ------
    ValueError
        If no ball is found, or nothing of it is shown, if photos do not overlap, for lists of
        different lengths, a mask of another shape, photos with different channels, and `fov` or
        `distance` given for some photos alone.
    TypeError
        For an unsupported dtype.

    Notes
    -----
    Each photo counts with the fourth power of its pixels per radian, in its worst direction. So the
    rim, where a pixel sees many degrees, gives way to a photo that has that direction nearer its
    middle.

    The camera that is found is off by 0.1° to 0.6° at the rim, in photos of 256 pixels; `doubt` is
    larger where the photos say less, as from one place they say nothing. A `UserWarning` says so
    where it is above 3°, and where a single photo is taken to be of the ideal camera.

    Where the white balance differs, poses that were found are refined once the exposures of the
    channels are known.

    Exposures are the weighted median of the ratio of what two photos show, channel by channel.

    Examples
    --------
    Two photos from opposite sides, the second half as bright and from who knows where:

    >>> import numpy as np, spheremap as sm
    >>> d = sm.directions("latlong", 64)
    >>> scene = 1.2 + np.sin(5 * d) * np.cos(4 * d[..., ::-1])
    >>> camera = dict(size=128, fov=25, distance=6)
    >>> pose = sm.rotation(170, 5, 10)
    >>> a, b = sm.ball.render(scene, **camera), sm.ball.render(scene, pose=pose, **camera) / 2
    >>> ball = sm.ball.Ball((64, 64), (48.8, 48.8), 0, 1)
    >>> found = sm.ball.merge([a, b], balls=[ball, ball], fov=25, size=32)
    >>> found.coverage, found.exposures[1].round(2).tolist()
    (1.0, [2.0, 2.0, 2.0])
    >>> bool(np.abs(found.poses[1] - pose).max() < 0.01)
    True
    """
    _expect_several(photos)
    arrays = [as_image(photo, None, "photos") for photo in as_items(photos, "photos", "images")]
    count = len(arrays)
    if count == 0:
        raise ValueError("Expected `photos` to hold at least one photo, got none.")
    for k, pixels in enumerate(arrays):
        expect_photo(pixels.shape, f"photo {k + 1}")
        if pixels.shape[2:] != arrays[0].shape[2:]:
            raise ValueError(
                f"Expected all photos to have the same channels, got shapes {arrays[0].shape} and "
                f"{pixels.shape}."
            )
    if not 0 <= number(photographer, "photographer") < 90:
        raise ValueError(f"`photographer` must be in [0, 90) degrees, got {photographer}.")
    expect_point_filter(filter)
    channels = arrays[0].shape[2:]
    reflects, metal = reflectance_of(reflectance, metal, channels[0] if channels else 1)
    dtype = np.dtype(np.float64 if any(a.dtype == np.float64 for a in arrays) else np.float32)
    filling = unseen(fill, dtype, channels[0] if channels else 1)
    angles, distances = _numbers(fov, count, "fov"), _numbers(distance, count, "distance")
    known = _poses(poses, count)
    shots, rims, cameras = [], [], []
    outlines = _each(balls, count, "balls")
    for outline in outlines:
        if not isinstance(outline, Ball | None):
            raise TypeError(f"Expected `balls` to hold Ball or None, got {type(outline).__name__}.")
    given = zip(
        arrays,
        outlines,
        angles,
        distances,
        _each(masks, count, "masks"),
        strict=True,
    )
    for k, (pixels, ball, angle, far, mask) in enumerate(given):
        try:
            rim = find(pixels, mask=mask) if ball is None else ball
            camera = partial(_camera, pixels.shape[:2], angle, far)
            shots.append(Shot(pixels, camera(rim), mask, reflects, metal, filter))
            expect_seen(shots[-1])
        except ValueError as error:
            raise ValueError(f"photo {k + 1}: {error}") from None
        rims.append(rim)
        cameras.append(camera)
    # Two photos say how far the camera is; one says nothing of it.
    told = [any(x is not None for x in pair) for pair in zip(angles, distances, strict=True)]
    if any(told) and not all(told):
        raise ValueError(
            f"photo {told.index(False) + 1} has neither `fov` nor `distance`, which photo "
            f"{told.index(True) + 1} has: give one of both for each photo, or for none."
        )
    unknown = count > 1 and not any(told)
    lens = None
    if unknown:
        lens = math.tan(LIKELY_ANGLE) * arrays[0].shape[1] / rims[0].radius
        shots = [
            shot.seen_by(camera(rim, lens))
            for shot, rim, camera in zip(shots, rims, cameras, strict=True)
        ]
    elif not any(told):
        warn_of_ideal_camera(shots[0].view, 2)
    seen_behind = math.radians(photographer)
    # Without what a single photo needs not.
    several = count > 1
    with part(0, _ALIGNED * several):
        turns, gains, correlations = _aligned(shots, known, seen_behind)
    placed = [
        Placed(
            shot,
            rim,
            turn,
            camera,
            rim.confidence < 1 and not shot.view.ideal,
            pose is None,
            lens,
            gain,
        )
        for shot, rim, turn, camera, pose, gain in zip(
            shots, rims, turns, cameras, known, gains, strict=True
        )
    ]
    if all(pose is None for pose in known):
        placed[0].free_turn = False
    doubt = 0.0
    # With rims that are certain the rotation is as good as it gets.
    if unknown or (several and any(p.free_rim for p in placed)):
        with part(_ALIGNED, _REFINED):
            placed, doubt = refined(placed, seen_behind)
        shots, rims, turns = ([getattr(p, n) for p in placed] for n in ("shot", "ball", "turn"))
        with part(_REFINED, _AGAIN):
            _, gains, _ = _aligned(shots, list(turns), seen_behind)
    if unknown and doubt > _MOST_DOUBT:
        warn_of_unknown_distance(doubt)

    target = resolve(dst)
    ours = target.in_world_of("latlong")
    if size is None:
        size = max(fitting_size(target, math.pi * s.view.outline.mean**2) for s in shots)
    shape = target_shape(target, size, any_aspect)
    image = np.zeros((math.prod(shape), shots[0].channels))
    weights = np.zeros((count, len(image)))
    values = []
    with part(_AGAIN * several, 1):
        for k, shot in counted([*enumerate(shots)]):
            with part(0, 0.75):
                texels, least, _ = shot.unwrap(ours, shape, turns[k])
            with part(0.75, 1):
                fade = _weight(shot, ours, shape, turns[k], seen_behind)
            # One that is not finite in some channel is no light.
            finite = np.asarray(np.isfinite(texels).all(axis=-1))
            # Scaled, so that a power of a few hundred pixels stays a number of usual size.
            weights[k] = np.where(finite, fade * (least / 100) ** _POWER, 0)
            values.append(np.where(finite[:, None], texels * gains[k], 0))
            image += weights[k][:, None] * values[-1]
    total = weights.sum(axis=0)
    seen = total > 0
    image = np.where(seen[:, None], image / np.where(seen, total, 1)[:, None], 0)
    weights /= np.where(seen, total, 1)
    solid_angle = target.solid_angle(shape, any_aspect=True).reshape(-1)
    residual = _residual(values, image, weights, solid_angle)
    return MergedBalls(
        image=np.where(seen[:, None], image, filling).astype(dtype).reshape(shape + channels),
        weights=weights.astype(np.float32).reshape(count, *shape),
        coverage=float(solid_angle[seen].sum() / solid_angle.sum()),
        residual=residual,
        poses=np.array(turns),
        exposures=np.array(gains),
        correlations=np.array(correlations),
        balls=tuple(
            ball_of(shot.view.outline, rim.confidence)
            for shot, rim in zip(shots, rims, strict=True)
        ),
        distances=np.array([shot.view.distance for shot in shots]),
        fov=shots[0].view.fov,
        doubt=math.degrees(doubt),
        projection=target,
    )


def _expect_several(photos: Any) -> None:
    """Raise for one photo in the place of a list of them."""
    shape: tuple[int, ...] = photos.shape if isinstance(photos, np.ndarray) else ()
    # Of an array of gray photos the last axis is their width.
    if len(shape) == 2 or (len(shape) == 3 and shape[2] <= 4):
        raise ValueError(
            f"Expected `photos` to be a sequence of photos, got one of shape {shape}; give [photo]."
        )


def _camera(
    shape: tuple[int, int],
    fov: float | None,
    distance: float | None,
    ball: Ball,
    lens: float | None = None,
) -> View:
    """Return the camera that sees a rim; `lens` is the width of its picture by how far that is."""
    if lens is not None:
        fov = math.degrees(2 * math.atan(lens / 2))
    return view(shape, ball._outline(), fov=fov, distance=distance)


def _numbers(value: Any, count: int, name: str) -> list[float | None]:
    """Return a number or None for each photo, of one for all or of as many."""
    # One number is what has no items.
    if value is None or isinstance(value, str) or not hasattr(value, "__len__"):
        return [optional_number(value, name)] * count
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return [optional_number(value[()], name)] * count
    return [optional_number(each, name) for each in _each(value, count, name)]


def _poses(poses: Any, count: int) -> list[Array | None]:
    """Return the pose of each photo, None where it is to be found."""
    found: list[Array | None] = []
    for k, pose in enumerate(_each(poses, count, "poses")):
        try:
            found.append(None if pose is None else pose_matrix(pose))
        except (TypeError, ValueError) as error:
            raise type(error)(f"`poses` of photo {k + 1}: {error}") from None
    return found


def _each(value: Any, count: int, name: str) -> list[Any]:
    """Return one value for each photo, or None for each."""
    if value is None:
        return [None] * count
    if isinstance(value, str | bytes):
        raise TypeError(f"Expected `{name}` to be a sequence of entries, got {kind_of(value)}.")
    values = list(as_items(value, name, "entries"))
    if len(values) != count:
        raise ValueError(
            f"Expected `{name}` to have one entry for each of {count} photos, got {len(values)}."
        )
    return values


def _weight(shot: Shot, p: Projection, shape: tuple[int, ...], turn: Array, behind: float) -> Array:
    """Return the mask in each texel, without what hides behind the photographer."""
    texels, width = Texels(p, shape), shape[-1]
    out = np.empty(math.prod(shape))

    def work(block: tuple[int, int, slice]) -> None:
        first, last, _ = block
        d = texels.directions_of_rows(slice(first, last)) @ turn
        weight = shot.weight(d)
        if behind > 0:
            away = np.nan_to_num(d @ shot.view.toward)
            t = np.clip((np.arccos(np.clip(away, -1, 1)) / behind - 1) / 0.5, 0, 1)
            weight = weight * (_PHOTOGRAPHER + (1 - _PHOTOGRAPHER) * t * t * (3 - 2 * t))
        out[first * width : last * width] = weight

    on_all_threads(work, texels.row_blocks())
    return out


class _Colors:
    """Panoramas of a photo in its own frame: colors and weights at each level."""

    def __init__(self, shot: Shot, behind: float) -> None:
        self.colors: list[Array] = []
        self.weights: list[Array] = []
        latlong = resolve("latlong")
        finest = shot.view.outline.mean * 1.5
        rows = max(r for r in _LEVELS if r <= max(finest, _LEVELS[2]))
        shape = (rows, 2 * rows)
        texels, least, _ = shot.unwrap(latlong, shape, np.eye(3))
        fade = _weight(shot, latlong, shape, np.eye(3), behind)
        known = np.asarray(np.isfinite(texels).all(axis=-1))
        area = latlong.solid_angle(shape) * known.reshape(shape)
        # Sums, so that coarser panoramas are sums of four.
        sums = (
            np.concatenate(
                [np.where(known[:, None], texels, 0), least[:, None], fade[:, None]], axis=-1
            ).reshape(*shape, -1)
            * area[..., None]
        )
        while True:
            rows = len(area)
            mean = sums / np.maximum(area, 1e-12)[..., None]
            # Full weight where a pixel sees no more than a texel.
            fine = np.clip(mean[..., -2] * np.pi / rows, 0, 1) ** 4
            share = area / latlong.solid_angle(area.shape)
            self.colors.insert(0, mean[..., :-2])
            self.weights.insert(0, mean[..., -1] * fine * share)
            if rows == _LEVELS[0]:
                break
            sums = sums.reshape(rows // 2, 2, rows, 2, -1).sum(axis=(1, 3))
            area = area.reshape(rows // 2, 2, rows, 2).sum(axis=(1, 3))

    def turned(self, level: int, turn: Array) -> tuple[Array, Array]:
        """Return the panorama in another frame."""
        latlong = resolve("latlong")
        weight = self.weights[level]
        layers = np.concatenate(
            [self.colors[level] * weight[..., None], weight[..., None]], axis=-1
        )
        d = np.asarray(latlong.directions(weight.shape)) @ turn
        found = np.asarray(sample(layers, d, latlong))
        return found[..., :-1], found[..., -1]


class _Scene:
    """What the photos that are placed so far show, in the common frame."""

    def __init__(self, levels: int) -> None:
        self.sums: list[Array | float] = [0.0] * levels
        self.weights: list[Array | float] = [0.0] * levels

    def add(self, colors: _Colors, turn: Array, gain: Array) -> None:
        for level in range(len(self.sums)):
            values, weight = colors.turned(level, turn)
            self.sums[level] = self.sums[level] + values * gain
            self.weights[level] = self.weights[level] + weight

    def color(self, level: int) -> tuple[Array, Array]:
        weight = np.asarray(self.weights[level])
        return np.asarray(self.sums[level]) / np.maximum(weight, 1e-12)[..., None], weight


def _panorama(color: Array, weight: Array) -> Panorama:
    brightness = np.maximum(color.mean(axis=-1), 0)
    bright = brightness[(weight > 0.1) & (brightness > 0)]
    # What is far below the middle is noise, and its logarithm would be loud.
    floor = 0.02 * float(np.median(bright)) if bright.size else 1.0
    return Panorama(np.log(brightness + floor), np.clip(weight, 0, 1))


def _aligned(
    shots: list[Shot], known: list[Array | None], behind: float
) -> tuple[list[Array], list[Array], list[float]]:
    """Return the rotation, the exposure and the correlation of each photo."""
    count = len(shots)
    # Those whose pose is known come first: they say in which frame the others are.
    base, *others = sorted(range(count), key=lambda k: known[k] is None)
    first = known[base]
    turns = [np.eye(3) if first is None else first] * count
    gains, correlations = [np.ones(shots[0].channels)] * count, [math.nan] * count
    correlations[0] = 1.0
    if count == 1:
        return turns, gains, correlations
    with part(0, 0.3):
        panoramas = [_Colors(shot, behind) for shot in counted(shots)]
    levels = min(len(p.colors) for p in panoramas)
    scene = _Scene(levels)
    scene.add(panoramas[base], turns[base], gains[base])
    with part(0.3, 1):
        for k in counted(others):
            colors, turn = panoramas[k], known[k]
            if turn is None:
                match = _found(k, scene, colors, levels)
                match, gains[k] = _balanced(k, scene, colors, match, levels - 1)
                turns[k], correlations[k] = match.rotation, match.correlation
            else:
                turns[k] = turn
                gains[k] = _gain(k, scene, colors, turn, levels - 1)
            scene.add(colors, turns[k], gains[k])
    return turns, [gain / gains[0] for gain in gains], correlations


def _balanced(
    k: int, scene: _Scene, colors: _Colors, match: Match, level: int
) -> tuple[Match, Array]:
    """Return how a photo is turned and its exposure, one refined with the other."""
    gain = _gain(k, scene, colors, match.rotation, level)
    first = _panorama(*scene.color(level))
    for step in range(_BALANCED):
        if step > 0 and np.ptp(gain) <= _SAME_GAIN * gain.max():
            break
        second = _panorama(colors.colors[level] * gain, colors.weights[level])
        match = refined_match(first, second, match.rotation, points(_BALANCED_POINTS))
        gain = _gain(k, scene, colors, match.rotation, level)
    return match, gain


def _found(k: int, scene: _Scene, colors: _Colors, levels: int) -> Match:
    """Return how a photo is turned, by what it shows of the scene."""
    first = [_panorama(*scene.color(level)) for level in range(levels)]
    second = [_panorama(colors.colors[level], colors.weights[level]) for level in range(levels)]
    match = search(first, second)
    _check_overlap(k, match.overlap)
    if match.correlation < _LEAST_CORRELATION:
        raise ValueError(
            f"photo {k + 1} does not overlap with those before it, or shows another scene: "
            f"the best rotation correlates only {match.correlation:.2f}."
        )
    return match


def _check_overlap(k: int, overlap: float) -> None:
    if overlap < 0.01:
        raise ValueError(
            f"photo {k + 1} does not overlap with those before it: masks, rims and `photographer` "
            f"leave {overlap:.1%} of the sphere in common."
        )


def _gain(k: int, scene: _Scene, colors: _Colors, turn: Array, level: int) -> Array:
    """Return what makes each channel of a photo as bright as the scene."""
    a, wa = scene.color(level)
    b, wb = colors.turned(level, turn)
    b = b / np.maximum(wb, 1e-12)[..., None]
    area = resolve("latlong").solid_angle(wa.shape)
    both = np.minimum(wa, 1) * wb
    _check_overlap(k, float((both * area).sum() / area.sum()))
    gain = np.empty(a.shape[-1])
    for c in range(len(gain)):
        usable = (both > 1e-3) & (a[..., c] > 0) & (b[..., c] > 0)
        if not usable.any():
            gain[c] = 1.0
            continue
        ratio = np.log(a[..., c][usable] / b[..., c][usable])
        # The dark says little about a ratio.
        light = np.sqrt(np.minimum(b[..., c][usable], np.median(b[..., c][usable])))
        gain[c] = np.exp(median(ratio, (both * area)[usable] * light))
    return gain


def _residual(values: list[Array], image: Array, weights: Array, area: Array) -> float:
    """Return how far the photos differ from their mean, in stops."""
    total = squares = 0.0
    mean = image.mean(axis=-1)
    for k, value in enumerate(values):
        bright = value.mean(axis=-1)
        usable = (bright > 0) & (mean > 0) & (weights[k] > 0) & (weights[k] < 1)
        share = (weights[k] * (1 - weights[k]) * area)[usable]
        squares += float(np.sum(share * np.log2(bright[usable] / mean[usable]) ** 2))
        total += float(share.sum())
    return math.sqrt(squares / total) if total > 0 else 0.0
