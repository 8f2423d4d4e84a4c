"""Finding the rim of a mirrored ball in a photo.

A mirrored ball shows everything that is around it, so its inside is full of edges, and at its rim
it shows what is right beside it: far away from any wall the rim is no step in brightness at all,
but a place where the picture is compressed without bound.

Edges of a small copy (by scikit-image) vote for circles. Around each of the best the ellipse with
the most evidence of a rim is taken (`_ball_rim` says what that is), the best of them wins, and is
refined on ever larger copies, up to the photo itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array, as_image
from .._progress import counted, done, part
from .._scalars import as_number, as_whole
from .._show import line
from ..resample.views import mask_weights
from .camera import Outline
from .circles import circles
from .rim import Picture, compression, found_near, prominence, refined

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

__all__ = ["Ball", "find"]

# The longer side of the copy in which the ball is looked for.
_SMALL = 320
# The longer side of that in which its rim is measured.
_LARGE = 2400
# How far a rim must stand out to count as a ball, and to count fully.
_LEAST, _CERTAIN = 0.3, 0.5
# How much a picture must be compressed toward the rim to count fully as a mirror's: balls in four
# scenes have 0.33 to 1.0, round frames of fisheyes and flat pictures there -0.4 to 0.0 but for two
# that are mostly black.
_COMPRESSED = 0.3
# How far a rim may move, in radii, at half the confidence, if a quarter of it is not asked.
_SHARP = 0.005
# More are rows, or columns.
_MOST_CHANNELS = 4
# How much of the time has passed when edges are found, and when circles were looked at.
_OF_EDGES, _OF_CIRCLES = 0.2, 0.8


@dataclass(frozen=True)
class Ball:
    """The outline of a ball in a photo.

    Attributes
    ----------
    center : (x, y)
        Of the ellipse, in pixels from the photo's upper left corner; the first pixel's own center
        is (0.5, 0.5).
    radii : (float, float)
        Its semi-axes in pixels.
    angle : float
        The direction of the first one, in degrees clockwise from +x.
    confidence : float
        From 0 to 1, the product of four: how far the rim stands out from what is beside it, how
        little it moves if a quarter of it is left out, whether what is inside is compressed
        toward it, as a mirror's picture is and a fisheye's or a porthole's is not, and how much of
        it there is to be seen: black before black shows no rim. It is no probability. Below 0.7
        look at it. 1 if given by hand.

    Raises
    ------
    ValueError
        For a center or radii that are not two numbers, an angle that is not finite, and a
        confidence that is not from 0 to 1.
    TypeError
        For an angle or a confidence that is no number.
    """

    center: tuple[float, float]
    radii: tuple[float, float]
    angle: float
    confidence: float

    __repr__ = line

    def __post_init__(self) -> None:
        for name, least, above in (("center", -math.inf, ""), ("radii", 0.0, " above 0")):
            given = getattr(self, name)
            pair = as_array(given, name)
            fits = pair.shape == (2,) and pair.dtype.kind in "fiu"
            if not (fits and np.isfinite(pair).all() and (pair > least).all()):
                raise ValueError(f"Expected `{name}` to be two finite numbers{above}, got {given}.")
        if not math.isfinite(as_number(self.angle, "angle")):
            raise ValueError(f"Expected `angle` to be a finite number, got {self.angle}.")
        if not 0 <= as_number(self.confidence, "confidence") <= 1:
            raise ValueError(f"Expected `confidence` to be from 0 to 1, got {self.confidence}.")

    @property
    def radius(self) -> float:
        """The radius of the circle of the same area."""
        return self._outline().mean

    def points(self, count: int = 360) -> NDArray[np.float64]:
        """Return points of the rim, to draw it.

        Parameters
        ----------
        count : int
            How many, at even steps around the ellipse from the direction of the first radius on.

        Returns
        -------
        points : ndarray, shape (count, 2)
            (x, y) in pixels, from the upper left corner of the photo.

        Raises
        ------
        ValueError, TypeError
            For a count that is no whole number above 0.

        Examples
        --------
        >>> import spheremap as sm
        >>> sm.ball.Ball((40, 30), (10, 8), 0, 1).points(4).round(6).tolist()
        [[50.0, 30.0], [40.0, 38.0], [30.0, 30.0], [40.0, 22.0]]
        """
        if as_whole(count, "count") < 1:
            raise ValueError(f"`count` must be at least 1, got {count}.")
        return self._outline().points(count)

    def _outline(self) -> Outline:
        return Outline(self.center, *self.radii, math.radians(self.angle))


def ball_of(rim: Outline, confidence: float) -> Ball:
    """Return the ball with this outline."""
    return Ball(rim.center, (rim.along, rim.across), math.degrees(rim.angle), confidence)


def expect_photo(shape: tuple[int, ...], name: str) -> None:
    """Raise for the shape of what is no photo."""
    if len(shape) not in (2, 3) or 0 in shape:
        raise ValueError(f"Expected {name} to have shape (H, W) or (H, W, C), got {shape}.")
    if len(shape) == 3 and shape[0] <= _MOST_CHANNELS < shape[2]:
        raise ValueError(
            f"Expected {name} to have shape (H, W) or (H, W, C), got {shape}, which looks like "
            "channels first: move the axis, np.moveaxis(photo, 0, -1)."
        )


def find(photo: ArrayLike, /, *, mask: ArrayLike | None = None) -> Ball:
    """Find the rim of a mirrored ball.

    Parameters
    ----------
    photo : array_like, shape (H, W) or (H, W, C)
        Of any brightness. The ball's radius lies between 6 % and 75 % of the shorter side; part of
        it may lie outside the photo.
    mask : array_like, shape (H, W), optional
        As for `unwrap`. Pixels where it is 0 are not looked at.

    Returns
    -------
    Ball

    Raises
    ------
    ValueError
        If there is no ball, or the photo is none.
    ImportError
        If scikit-image is missing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> d = sm.directions("latlong", 64)
    >>> scene = 1.5 + np.sign(np.sin(9 * d[..., 0]) * np.sin(7 * d[..., 1]) * np.sin(8 * d[..., 2]))
    >>> photo = sm.ball.render(scene, size=240, center=(130, 110), radius=80, background="black")
    >>> ball = sm.ball.find(photo)
    >>> bool(np.hypot(ball.center[0] - 130, ball.center[1] - 110) < 1)
    True
    >>> bool(abs(ball.radius - 80) < 1.5)
    True
    """
    feature, filters = _skimage()
    image = as_image(photo, None, "photo")
    expect_photo(image.shape, "`photo`")
    gray = _toned(image)
    known = np.isfinite(gray)
    if mask is not None:
        known &= mask_weights(mask, gray.shape) > 0
    if min(gray.shape) < 16 or not known.any():
        raise ValueError("no ball found: the photo is too small or empty.")
    gray = np.where(known, gray, np.median(gray[known]))

    def blurred(picture: Array, sigma: float) -> Array:
        return np.asarray(filters.gaussian(picture, sigma))

    def at(factor: int) -> Picture:
        return Picture(_shrunk(gray, factor), _shrunk(known.astype(np.float64), factor), blurred)

    shrink = max(1, math.ceil(max(gray.shape) / _SMALL))
    small = blurred(_shrunk(gray, shrink), 1.0)
    usable = _shrunk(known.astype(np.float64), shrink) > 0.99
    edges = feature.canny(
        small, sigma=1.0, low_threshold=0.7, high_threshold=0.88, use_quantiles=True, mask=usable
    )
    picture = at(shrink)
    found: list[tuple[float, Outline]] = []
    with part(_OF_EDGES, _OF_CIRCLES):
        for x, y, r in counted(circles(small, edges)):
            if not any(_same(rim, (x, y), r) for _, rim in found):
                rim = found_near(picture, Outline((x, y), r, r))
                found.append((prominence(picture, rim), rim))
    # Of two rims that are as good, the larger one: a ball may show another.
    found.sort(key=lambda entry: entry[0] * entry[1].mean ** 0.25)
    if not found or found[-1][0] < _LEAST:
        raise ValueError("no ball found in the photo: give `center` and `radius` by hand.")
    stands_out, rim = found[-1]
    mirrors = min(max(compression(picture, rim) / _COMPRESSED, 0.0), 1.0)
    factor, last = shrink, max(1, round(max(gray.shape) / _LARGE))
    fine = refined(picture, rim)
    done(_OF_CIRCLES)
    while factor > last:
        finer = max(last, factor // 2)
        fine = refined(at(finer), _scaled(fine.rim, factor / finer))
        factor = finer
    rim = _scaled(fine.rim, factor)
    angle = (math.degrees(rim.angle) + 90) % 180 - 90
    sharp = 1 / (1 + (fine.doubt / (_SHARP * fine.rim.mean)) ** 2)
    # Only a hand is certain. The square of what is seen: with a fifth of the rim unseen, wrong rims
    # in a dark studio had 0.8 to 0.95 by the other three.
    confidence = min(stands_out / _CERTAIN, 1.0) * min(sharp, 0.999) * mirrors * fine.seen**2
    return Ball(rim.center, (rim.along, rim.across), angle, confidence)


def _same(rim: Outline, center: tuple[float, float], radius: float) -> bool:
    """Whether a circle is so near an outline that it would lead there."""
    return math.dist(rim.center, center) + abs(rim.mean - radius) < 0.1 * rim.mean


def _scaled(rim: Outline, factor: float) -> Outline:
    x, y = rim.center
    return Outline((x * factor, y * factor), rim.along * factor, rim.across * factor, rim.angle)


def _skimage() -> tuple[Any, Any]:
    try:
        from skimage import feature, filters
    except ImportError:
        raise ImportError(
            "finding a ball needs scikit-image: pip install spheremap[ball]", name="skimage"
        ) from None
    return feature, filters


def _toned(image: NDArray[Any]) -> Array:
    """Return the brightness, compressed: an edge in the dark is as good as one in the light."""
    values = image.astype(np.float64)
    if values.ndim == 3:
        # Two channels are gray and alpha, four are colors and alpha.
        count = 3 if values.shape[-1] >= 3 else 1
        # Infinities of both signs are no number, and what is too large for one is none.
        with np.errstate(invalid="ignore", over="ignore"):
            values = np.asarray(sum(values[..., c] for c in range(count)) / count)
    bright = values[np.isfinite(values) & (values > 0)]
    if bright.size == 0:
        return np.where(np.isfinite(values), 0.0, np.nan)
    with np.errstate(invalid="ignore", over="ignore"):
        toned = np.log1p(4 * np.maximum(values, 0) / np.median(bright))
    return np.where(np.isfinite(toned), toned, np.nan)


def _shrunk(image: Array, factor: int) -> Array:
    if factor == 1:
        return image
    h, w = (n // factor for n in image.shape)
    # Whole rows first: several times faster than both sums at once.
    rows = image[: h * factor, : w * factor].reshape(h, factor, w * factor).sum(axis=1)
    return np.asarray(rows.reshape(h, w, factor).sum(axis=2) / factor**2)
