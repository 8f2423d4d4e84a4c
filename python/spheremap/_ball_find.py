"""Finding the rim of a mirrored ball in a photo.

A mirrored ball shows everything that is around it, so its inside is full of edges, and at its rim
it shows what is right beside it: far away from any wall the rim is no step in brightness at all,
but a place where the picture is compressed without bound. What tells it from all other edges is
that they lie on one ellipse.

Edges of a small copy (by scikit-image) vote for centres along their gradients. Around the best
centres the most complete circle is taken. It is then drawn to the strongest gradient along its
normals, in windows that shrink from a tenth of the radius to two pixels, on the photo itself: each
time the offsets are fitted robustly by the five harmonics in which an ellipse may differ from an
ellipse nearby.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import as_image
from ._ball_geometry import Outline

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

__all__ = ["Ball", "find_ball"]

# The longer side of the copy in which the ball is looked for.
_SMALL = 320
# The longer side of that in which its rim is measured.
_LARGE = 2400
# Radii that a ball may have, in shorter sides of the photo.
_LEAST, _MOST = 0.06, 0.75
# Places along the rim where it is measured.
_SPOKES = 360
# How much of the rim must be there.
_CERTAIN = 0.6
# Candidates that are measured.
_TRIED = 6
# How far a rim is drawn in each step, in radii, and the harmonics that may change: all five,
# or but the first three, which keep the shape.
_WIDE = ((0.10, 3), (0.08, 5), (0.05, 5), (0.03, 5), (0.02, 5), (0.01, 5), (0.01, 5))
_NEAR = ((0.10, 3), (0.05, 5), (0.03, 5), (0.02, 5), (0.01, 5), (0.01, 5))


@dataclass(frozen=True)
class Ball:
    """The outline of a ball in a photo.

    Attributes
    ----------
    center : (x, y)
        Of the ellipse, in pixels from the photo's upper left corner; the first pixel's own centre
        is (0.5, 0.5).
    radii : (float, float)
        Its semi-axes in pixels.
    angle : float
        The direction of the first one, in degrees clockwise from +x.
    confidence : float
        From 0 to 1: how much of the rim within the photo is an edge. 1 if given by hand.
    """

    center: tuple[float, float]
    radii: tuple[float, float]
    angle: float
    confidence: float

    @property
    def radius(self) -> float:
        """The radius of the circle of the same area."""
        return self._outline().mean

    def points(self, count: int = 360) -> NDArray[np.float64]:
        """Return points (x, y) of the rim, to draw it."""
        return self._outline().points(count)

    def _outline(self) -> Outline:
        return Outline(self.center, *self.radii, math.radians(self.angle))


def find_ball(photo: ArrayLike, /, *, mask: ArrayLike | None = None) -> Ball:
    """Find the rim of a mirrored ball.

    Parameters
    ----------
    photo : array_like, shape (H, W) or (H, W, C)
        Of any brightness. The ball's radius lies between 6 % and 75 % of the shorter side; part of
        it may lie outside the photo.
    mask : array_like, shape (H, W), optional
        Pixels where it is 0 are not looked at.

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
    >>> photo = sm.render_ball(scene, size=240, center=(130, 110), radius=80, background="black")
    >>> ball = sm.find_ball(photo)
    >>> bool(np.hypot(ball.center[0] - 130, ball.center[1] - 110) < 1)
    True
    >>> bool(abs(ball.radius - 80) < 1.5)
    True
    """
    feature, filters = _skimage()
    image = as_image(photo, None)
    if image.ndim not in (2, 3) or 0 in image.shape:
        raise ValueError(f"Expected `photo` to have shape (H, W) or (H, W, C), got {image.shape}.")
    grey = _toned(image)
    known = np.isfinite(grey)
    if mask is not None:
        weights = np.asarray(mask)
        if weights.shape != grey.shape:
            raise ValueError(
                f"Expected `mask` to have the photo's shape {grey.shape}, got {weights.shape}."
            )
        known &= weights > 0
    if min(grey.shape) < 16 or not known.any():
        raise ValueError("no ball found: the photo is too small or empty.")
    grey = np.where(known, grey, np.median(grey[known]))

    shrink = max(1, math.ceil(max(grey.shape) / _SMALL))
    small = filters.gaussian(_shrunk(grey, shrink), 1.0)
    usable = _shrunk(known.astype(np.float64), shrink) > 0.99
    edges = feature.canny(
        small, sigma=1.0, low_threshold=0.7, high_threshold=0.88, use_quantiles=True, mask=usable
    )
    circles = _circles(small, edges)
    factor = max(1, round(max(grey.shape) / _LARGE))
    large = filters.gaussian(_shrunk(grey, factor), 0.7)
    best: tuple[float, Outline] | None = None
    for x, y, r in circles:
        scale = shrink / factor
        rim = _drawn(large, Outline((x * scale, y * scale), r * scale, r * scale), _WIDE, False)
        # What is compressed just inside the rim runs along it, and may be stronger than the rim.
        outer = None if rim is None else _drawn(large, rim, _NEAR, True)
        for found in (rim, outer):
            if found is None:
                continue
            quality = _confidence(large, found)
            # Of two rims that are whole, the larger one: a ball may show another.
            if best is None or quality * found.mean**0.5 > best[0] * best[1].mean ** 0.5:
                best = quality, found
    if best is None or best[0] < _CERTAIN:
        near = "" if best is None else f" (the best rim is {best[0]:.0%} there)"
        raise ValueError(f"no ball found in the photo{near}: give `center` and `radius` by hand.")
    quality, rim = best
    rim = _without_bias(large, rim)
    center = (rim.center[0] * factor, rim.center[1] * factor)
    angle = (math.degrees(rim.angle) + 90) % 180 - 90
    return Ball(center, (rim.along * factor, rim.across * factor), angle, min(quality, 1.0))


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
        # Two channels are grey and alpha, four are colors and alpha.
        values = values[..., :3] if values.shape[-1] >= 3 else values[..., :1]
        values = values.mean(axis=-1)
    bright = values[np.isfinite(values) & (values > 0)]
    if bright.size == 0:
        return np.where(np.isfinite(values), 0.0, np.nan)
    with np.errstate(invalid="ignore"):
        toned = np.log1p(4 * np.maximum(values, 0) / np.median(bright))
    return np.where(np.isfinite(toned), toned, np.nan)


def _shrunk(image: Array, factor: int) -> Array:
    h, w = (n // factor for n in image.shape)
    blocks = image[: h * factor, : w * factor].reshape(h, factor, w, factor)
    return np.asarray(blocks.mean(axis=(1, 3)))


def _circles(image: Array, edges: NDArray[np.bool_]) -> list[tuple[float, float, float]]:
    """Return likely circles (x, y, radius) in pixels, the best first."""
    height, width = image.shape
    gy, gx = np.gradient(image)
    rows, columns = np.nonzero(edges)
    if len(rows) < 20:
        return []
    norm = np.maximum(np.hypot(gx, gy), 1e-12)
    ux, uy = (gx / norm)[rows, columns], (gy / norm)[rows, columns]
    x, y = columns + 0.5, rows + 0.5
    least, most = _LEAST * min(height, width), _MOST * min(height, width)
    radii = np.arange(least, most, 1.0)
    # Votes for centres on a grid of two pixels, at both ends of the gradient.
    cells = np.zeros((height // 2 + 1, width // 2 + 1))
    for sign in (-1.0, 1.0):
        cx = ((x[:, None] + sign * ux[:, None] * radii) / 2).astype(np.intp)
        cy = ((y[:, None] + sign * uy[:, None] * radii) / 2).astype(np.intp)
        inside = (cx >= 0) & (cy >= 0) & (cx < cells.shape[1]) & (cy < cells.shape[0])
        flat = (cy * cells.shape[1] + cx)[inside]
        # A centre that is far away is hit by chance as often as one that is near.
        cells += np.bincount(flat, minlength=cells.size).reshape(cells.shape)
    votes = _blurred(cells)
    found: list[tuple[float, float, float, float]] = []
    for _ in range(4 * _TRIED):
        row, column = np.unravel_index(int(np.argmax(votes)), votes.shape)
        if votes[row, column] <= 0:
            break
        cx0, cy0 = 2.0 * column + 1, 2.0 * row + 1
        votes[max(row - 4, 0) : row + 5, max(column - 4, 0) : column + 5] = 0
        found += _radii(x - cx0, y - cy0, ux, uy, cx0, cy0, least, most)
    found.sort(key=lambda entry: -entry[3])
    return [(cx, cy, r) for cx, cy, r, _ in found[:_TRIED]]


def _radii(
    dx: Array, dy: Array, ux: Array, uy: Array, cx: float, cy: float, least: float, most: float
) -> list[tuple[float, float, float, float]]:
    """Return the circles around a centre on which most edges lie, and how complete they are."""
    r = np.hypot(dx, dy)
    aligned = np.abs(dx * ux + dy * uy) > 0.94 * r
    near = aligned & (r > least) & (r < most)
    if not near.any():
        return []
    sector = np.floor((np.arctan2(dy, dx) / (2 * np.pi) + 0.5) * 72).astype(np.intp) % 72
    # Sectors of 5° in which a circle of each radius, ±1.5 %, has an edge.
    best = []
    steps = np.geomspace(least, most, max(2, int(np.log(most / least) / 0.015)))
    hits = np.zeros((len(steps), 72), np.bool_)
    index = np.round(np.log(r[near] / least) / 0.015).astype(np.intp)
    for shift in (-1, 0, 1):
        hits[np.clip(index + shift, 0, len(steps) - 1), sector[near]] = True
    complete = hits.mean(axis=1) * steps**0.25
    for _ in range(2):
        k = int(np.argmax(complete))
        best.append((cx, cy, float(steps[k]), float(complete[k])))
        complete[max(k - 4, 0) : k + 5] = 0
    return best


def _blurred(cells: Array) -> Array:
    for axis in (0, 1):
        for _ in range(2):
            cells = (np.roll(cells, 1, axis) + cells + np.roll(cells, -1, axis)) / 3
    return cells


def _lookup(image: Array, xy: Array) -> Array:
    """Return the picture between its pixels; NaN outside."""
    height, width = image.shape
    x, y = xy[..., 0] - 0.5, xy[..., 1] - 0.5
    inside = (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)
    i = np.clip(np.floor(x), 0, max(width - 2, 0)).astype(np.intp)
    j = np.clip(np.floor(y), 0, max(height - 2, 0)).astype(np.intp)
    s, t = x - i, y - j
    top = image[j, i] * (1 - s) + image[j, i + 1] * s
    bottom = image[j + 1, i] * (1 - s) + image[j + 1, i + 1] * s
    return np.where(inside, top * (1 - t) + bottom * t, np.nan)


def _slopes(image: Array, rim: Outline, reach: float, step: float) -> tuple[Array, Array]:
    """Return the slopes along the rim's normals, (spokes, offsets), and the offsets in pixels."""
    offsets = np.arange(-reach, reach + step / 2, step)
    base = rim.points(_SPOKES)
    t = 2 * np.pi * np.arange(_SPOKES) / _SPOKES
    c, s = math.cos(rim.angle), math.sin(rim.angle)
    normal = np.stack([np.cos(t) / rim.along, np.sin(t) / rim.across], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = normal @ np.array([[c, s], [-s, c]])
    h = max(0.5, step / 2)

    def at(shift: float) -> Array:
        far = (offsets + shift)[:, None] * normal[:, None, :]
        return _lookup(image, base[:, None, :] + far)

    return np.abs(at(h) - at(-h)) / (2 * h), offsets


def _drawn(
    image: Array, rim: Outline, steps: tuple[tuple[float, int], ...], outermost: bool
) -> Outline | None:
    """Draw an outline to the strongest edge near it, or to the outermost of the strong ones."""
    t = 2 * np.pi * np.arange(_SPOKES) / _SPOKES
    harmonics = np.stack(
        [np.ones_like(t), np.cos(t), np.sin(t), np.cos(2 * t), np.sin(2 * t)], axis=-1
    )
    for share, terms in steps:
        reach = max(share * rim.mean, 2.0)
        step = max(reach / 24, 0.125)
        slopes, offsets = _slopes(image, rim, reach, step)
        known = np.asarray(np.isfinite(slopes).all(axis=1))
        if known.sum() < _SPOKES / 4:
            return None
        # The strongest slope of each spoke, and the two places beside it for its middle.
        s = np.where(known[:, None], slopes, 0)
        power = s / (np.mean(s, axis=1, keepdims=True) + 1e-9)
        best = np.argmax(power, axis=1)
        if outermost:
            strong = power > 0.4 * power.max(axis=1, keepdims=True)
            tops = (power[:, 1:-1] >= power[:, :-2]) & (power[:, 1:-1] > power[:, 2:])
            strong[:, 1:-1] &= tops
            strong[:, [0, -1]] = False
            last = len(offsets) - 1 - np.argmax(strong[:, ::-1], axis=1)
            best = np.where(strong.any(axis=1), last, best)
        k = np.clip(best, 1, len(offsets) - 2)
        rows = np.arange(_SPOKES)
        left, top, right = power[rows, k - 1], power[rows, k], power[rows, k + 1]
        bend = left - 2 * top + right
        middle = np.where(
            bend < -1e-12, 0.5 * (left - right) / np.where(bend < -1e-12, bend, -1), 0
        )
        peak = offsets[k] + np.clip(middle, -1, 1) * step
        basis = harmonics[:, :terms]
        weight = np.where(known, np.minimum(top, 8.0), 0)
        fitted = np.zeros(terms)
        fitted[0] = _mode(peak, weight, reach / 6)
        for width in (reach / 2, reach / 3, reach / 5, reach / 8):
            left_over = (peak - basis @ fitted) / max(width, 0.4)
            trust = weight * np.clip(1 - left_over**2, 0, 1) ** 2
            if trust.sum() <= 0:
                return None
            normal = basis.T @ (trust[:, None] * basis)
            normal += 1e-3 * trust.sum() * np.diag([0, 0, 0, 1, 1][:terms])
            fitted = np.linalg.solve(normal, basis.T @ (trust * peak))
        rim = _moved(rim, basis @ fitted)
        if not (rim.across > 0.5 * rim.along and rim.along > 0.5 * rim.across and rim.mean > 4):
            return None
    return rim


def _mode(values: Array, weights: Array, width: float) -> float:
    """Return where most of the weight lies."""
    centers = np.linspace(values.min(), values.max(), 49)
    share = np.clip(1 - ((values - centers[:, None]) / width) ** 2, 0, 1) @ weights
    return float(centers[np.argmax(share)])


def _moved(rim: Outline, offsets: Array) -> Outline:
    """Return the ellipse through the points of a rim moved along its normals."""
    t = 2 * np.pi * np.arange(_SPOKES) / _SPOKES
    base = rim.points(_SPOKES)
    c, s = math.cos(rim.angle), math.sin(rim.angle)
    normal = np.stack([np.cos(t) / rim.along, np.sin(t) / rim.across], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    points = base + offsets[:, None] * (normal @ np.array([[c, s], [-s, c]]))
    # The conic A x² + B xy + C y² + D x + E y = 1 about the middle: an ellipse as it was one.
    middle, scale = points.mean(axis=0), rim.mean
    x, y = ((points - middle) / scale).T
    terms = np.stack([x * x, x * y, y * y, x, y], axis=-1)
    A, B, C, D, E = np.linalg.lstsq(terms, np.ones(len(x)), rcond=None)[0]
    quadratic = np.array([[A, B / 2], [B / 2, C]])
    values, vectors = np.linalg.eigh(quadratic)
    if values[0] <= 0:
        return rim
    center = np.linalg.solve(quadratic, [-D / 2, -E / 2])
    level = 1 + center @ quadratic @ center
    along, across = np.sqrt(level / values)
    at = middle + center * scale
    angle = math.atan2(vectors[1, 0], vectors[0, 0])
    return Outline((float(at[0]), float(at[1])), float(along * scale), float(across * scale), angle)


def _without_bias(image: Array, rim: Outline) -> Outline:
    """Move a rim out that was drawn to where the picture is compressed.

    Before a distant background brightness is continuous across the rim and goes with the root of
    the distance inside. Its slope, after the blur of pixels, copy and difference, σ = 0.8 pixels in
    all, is steepest 0.77 σ inside; a step's is steepest on the rim. The two are told apart by the
    slope a few pixels inside, which a step has not.
    """
    slopes, offsets = _slopes(image, rim, 6.0, 0.25)
    mean = np.nanmean(slopes, axis=0)
    inside = mean[(offsets > -5) & (offsets < -3)].mean()
    outside = mean[(offsets > 3) & (offsets < 5)].mean()
    peak = mean[np.abs(offsets) < 1].max()
    # A root's slope at 4 pixels is 0.4 of its blurred top.
    share = float(np.clip((inside - outside) / max(0.4 * (peak - outside), 1e-12), 0, 1))
    shift = 0.62 * share
    return replace(rim, along=rim.along + shift, across=rim.across + shift)


def _confidence(image: Array, rim: Outline) -> float:
    """Return the share of the visible rim that is an edge."""
    reach = max(0.06 * rim.mean, 5.0)
    slopes, offsets = _slopes(image, rim, reach, 0.5)
    known = np.isfinite(slopes).all(axis=1)
    if known.sum() < _SPOKES / 4:
        return 0.0
    slopes = slopes[known]
    at = slopes[:, np.abs(offsets) <= max(1.5, 0.006 * rim.mean)].max(axis=1)
    outside = slopes[:, offsets > max(2.5, 0.012 * rim.mean)]
    # By chance the strongest of so few places exceeds most of the others, too.
    usual = np.quantile(outside, 0.85, axis=1)
    return float(np.mean(at > 1.5 * usual + 1e-3))
