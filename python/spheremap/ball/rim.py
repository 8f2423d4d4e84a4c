"""What tells the rim of a mirrored ball from other edges, and the ellipse that it says.

Spokes run out from the middle of an outline. On each, every place is asked whether the rim is
there; the ellipse is the one whose places have the most evidence, summed over the spokes. No spoke
has more to say than `_MOST`, so that a few of them, with an edge of something else, cannot pull.

The first evidence is how the inside looks. A ball compresses what it reflects along its radius: at
the share q of the radius, 1 - q² times as much as across it (cos²φ of an ideal ball; it differs
little for a near camera). If the edges around the ball run in all directions alike, the angle θ
between a slope in the picture and the radius has the density a / (a² cos²θ + sin²θ) / π with
a = 1 - q² inside, and 1/π beside the ball. The sum of the logarithms of their ratio, from the
middle outward, grows up to the rim and falls beyond it. It needs no step at the rim, and no detail
beside the ball. To it comes by how much the slope drops from the rim to what is right beside it.

The second evidence is for a fraction of a pixel. The picture is taken to be straight outside, and
inside to go with the powers ½ to 2 of the distance from the rim, as something smooth does that a
ball reflects, both blurred. The logarithm of what is left over tells where the one begins and the
other ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from .camera import Outline

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_SPOKES = 180
_T = 2 * np.pi * np.arange(_SPOKES) / _SPOKES
_RING = np.stack([np.cos(_T), np.sin(_T)], axis=-1)
# How one ellipse differs from another nearby: harmonics of the angle.
_HARMONICS = np.stack(
    [np.ones_like(_T), np.cos(_T), np.sin(_T), np.cos(2 * _T), np.sin(2 * _T)], axis=-1
)
# The least share of the rim that must be in the picture.
_VISIBLE = 0.25
# The most that the first and the second evidence of one spoke may differ, in nats.
_MOST, _MOST_PROFILE = 3.0, 6.0
# How much the first counts against the second, where both do.
_SHARE = 1.5
# The blur of a gradient: of a pixel and of what smooths the picture before the difference.
_BLUR = 1.0
# Such a blur carries the drop of a slope this many pixels out.
_CARRIED = 1.1
# Below this share of the largest slope nearby (squared) there is but its blur.
_TAIL = 0.15
# Blur of the pictures that profiles are taken of, pixels in all.
_PROFILE_BLUR = 0.8
# Where it is compared how far the picture is compressed, in radii.
_RINGS = ((0.2, 0.5), (0.75, 0.96))
# Where a slope's power is this many times the picture's median there is something to see.
_SEEN = 10.0
# How far from the rim it may lie, in pixels inside and outside.
_BESIDE = (6, 2)
# How fast shapes are given up that are no circle: a ball 15 % longer than wide is rare.
_ROUND = 150.0


class Picture:
    """A picture of brightness, its slopes, and how much of them is noise. NaN is unknown."""

    def __init__(self, gray: Array, known: Array, blurred: Callable[[Array, float], Array]) -> None:
        unknown = known < 0.99
        self.gray = blurred(gray, 0.7)
        soft = blurred(gray, _BLUR)
        self.gy = np.asarray(np.gradient(soft, axis=0))
        self.gx = np.asarray(np.gradient(soft, axis=1))
        power = self.gx**2 + self.gy**2
        self.slope_power = float(np.median(power[~unknown])) + 4 * 1e-12
        self.slope_noise = 0.25 * self.slope_power
        bends = np.abs(np.diff(self.gray, 2, axis=1))
        self.noise = max(
            0.3 * (float(np.median(bends)) / 0.6745) ** 2 + 1e-10,
            (0.01 * float(self.gray.std())) ** 2,
        )
        for layer in (self.gray, self.gx, self.gy):
            # The blur reaches three pixels.
            layer[_spread(unknown, 3)] = np.nan


@dataclass(frozen=True)
class Fit:
    """An outline, how far it may be off, in pixels, and the share of it where anything is seen."""

    rim: Outline
    doubt: float
    seen: float


def found_near(picture: Picture, rim: Outline) -> Outline:
    """Return the outline near a circle, within 28 % of its radius."""
    for reach in (0.14, 0.06):
        far = 2 * reach * rim.mean
        shifts = np.arange(-far, far + 1e-9, max(0.5, 0.004 * rim.mean))
        evidence = _bounded(_reflection(picture, rim, shifts), _MOST)
        change = _best(evidence, shifts, reach * rim.mean, _ROUND / rim.mean**2)
        rim = _moved(rim, change)
    return rim


def prominence(picture: Picture, rim: Outline) -> float:
    """Return how much more evidence a rim has than places up to 12 % of the radius beside it.

    On a scale on which a spoke's best place has 1.
    """
    steps = max(4, round(0.12 * rim.mean / max(0.5, 0.004 * rim.mean)))
    shifts = np.linspace(-0.12, 0.12, 2 * steps + 1) * rim.mean
    evidence = _bounded(_reflection(picture, rim, shifts), _MOST) / _MOST
    asked = np.asarray(evidence.any(axis=1))
    if asked.mean() < _VISIBLE:
        return 0.0
    return float(evidence[asked, steps].mean() - evidence[asked].mean())


def compression(picture: Picture, rim: Outline) -> float:
    """Return how much the picture is compressed toward a rim: 1 as by a ball, 0 not at all.

    The mean of cos 2θ is (1 - a) / (1 + a) where a is how much it is compressed, for edges that run
    in all directions alike; where they do not, less so near the middle is as telling.
    """
    means, wanted, normals = [], [], _normals(rim)
    for least, most in _RINGS:
        q = np.linspace(least, most, 40)
        xy = q[:, None] * (_RING @ rim.matrix().T)[:, None, :] + rim.center
        gx, gy = _lookup(picture.gx, xy), _lookup(picture.gy, xy)
        along = (gx * normals[:, None, 0] + gy * normals[:, None, 1]) ** 2
        power = gx * gx + gy * gy
        weight = np.where(np.isfinite(power), power / (power + picture.slope_power), 0)
        cosine = np.nan_to_num(2 * along / np.maximum(power, 1e-30) - 1)
        total = max(float(weight.sum()), 1e-9)
        means.append(float(np.sum(weight * cosine)) / total)
        wanted.append(float(np.sum(weight * q * q / (2 - q * q))) / total)
    return (means[1] - means[0]) / max(wanted[1] - wanted[0], 1e-9)


def refined(picture: Picture, rim: Outline) -> Fit:
    """Return the outline within 3 pixels, to a fraction of one."""
    shifts = np.arange(-3.0, 3.01, 0.25)
    evidence = _bounded(_reflection(picture, rim, shifts), _MOST)
    change = _best(evidence, shifts, 2.25)
    rim = _moved(rim, change)
    for _ in range(2):
        shifts, evidence = _both(picture, rim)
        change = _best(evidence, shifts, 1.5)
        rim = _moved(rim, change)
    return Fit(rim, _doubt(evidence, shifts, change), _seen(picture, rim))


def _seen(picture: Picture, rim: Outline) -> float:
    """Return the share of spokes with a slope at the rim: there is none where black meets black.

    What is missing there the jackknife cannot tell, as it misses in every part of the spokes.
    """
    inside, outside = _BESIDE
    offsets = np.arange(-inside, outside + 1.0)
    xy = rim.points(_SPOKES)[:, None, :] + offsets[:, None] * _normals(rim)[:, None, :]
    power = _lookup(picture.gx, xy) ** 2 + _lookup(picture.gy, xy) ** 2
    inside_photo = np.isfinite(power).any(axis=1)
    if not inside_photo.any():
        return 0.0
    steepest = np.nan_to_num(power[inside_photo]).max(axis=1)
    return float(np.mean(steepest > _SEEN * picture.slope_power))


def _doubt(evidence: Array, shifts: Array, change: Array) -> float:
    """Return how far the outline moves if a quarter of the spokes is not asked: the jackknife."""
    moved = []
    for first in range(8):
        kept = np.ones(_SPOKES, np.bool_)
        kept[(np.arange(_SPOKES // 4) + first * _SPOKES // 8) % _SPOKES] = False
        other = _best(evidence * kept[:, None], shifts, 1.5)
        moved.append(np.sqrt(np.mean((_HARMONICS @ (other - change)) ** 2)))
    return float(np.sqrt(np.mean(np.square(moved))))


def _bounded(evidence: Array, most: float) -> Array:
    """Return evidence from 0 to `most`; 0 where a spoke has nothing to say."""
    top = evidence.max(axis=1, keepdims=True)
    silent = top - evidence.min(axis=1, keepdims=True) < 1e-9
    return np.where(silent, 0, np.maximum(evidence - top, -most) + most)


def _both(picture: Picture, rim: Outline) -> tuple[Array, Array]:
    """Return shifts in pixels and both kinds of evidence, from 0 to 1 + _SHARE."""
    # What a ball shows is smooth for a few pixels only, the fewer the smaller it is.
    inside = min(max(round(0.12 * rim.mean) / 4, 1.0), 3.5)
    shifts, profile = _profile(picture, rim, 2.0, inside)
    first = _bounded(_reflection(picture, rim, shifts), 2 * _MOST) / (2 * _MOST)
    return shifts, _bounded(profile, _MOST_PROFILE) / _MOST_PROFILE + _SHARE * first


def _normals(rim: Outline) -> Array:
    normals = _RING @ np.linalg.inv(rim.matrix())
    return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True))


def _reflection(picture: Picture, rim: Outline, shifts: Array) -> Array:
    """Return the first evidence for a rim shifted by pixels, (spokes, shifts)."""
    pixel = 1 / rim.mean
    at = 1 + shifts * pixel
    step = min(max(0.5 * pixel, 0.004), 0.006)
    q = np.arange(0.5 * at[0], at[-1] + 5 * pixel, step)
    normals = _normals(rim)
    xy = q[:, None] * (_RING @ rim.matrix().T)[:, None, :] + rim.center
    gx, gy = _lookup(picture.gx, xy), _lookup(picture.gy, xy)
    along = gx * normals[:, None, 0] + gy * normals[:, None, 1]
    across = gy * normals[:, None, 0] - gx * normals[:, None, 1]
    unknown = ~np.isfinite(along)
    power = np.where(unknown, 0, along * along + across * across)
    steep = np.where(unknown, 0, along * along)
    near = math.ceil(3.5 * pixel / step)
    padded = np.pad(power, ((0, 0), (near, near)), mode="edge")
    tail = _TAIL * sliding_window_view(padded, 2 * near + 1, axis=1).max(axis=-1)
    floor = picture.slope_noise + tail
    weight = np.where(unknown, 0, power / (power + floor))
    cosine2 = steep / np.maximum(power, 1e-30)

    carried = at + _CARRIED * pixel
    evidence = np.empty((_SPOKES, len(at)))
    for k, rim_at in enumerate(carried):
        here = slice(
            int(np.searchsorted(q, 0.55 * rim_at)), int(np.searchsorted(q, rim_at + pixel))
        )
        # At the very rim the blur of a pixel keeps the compression finite.
        a = np.clip(1 - (q[here] / rim_at) ** 2, 4 * pixel + 0.03, 1)
        part = cosine2[:, here]
        evidence[:, k] = (weight[:, here] * np.log(a / (1 - (1 - a * a) * part))).sum(axis=1)
    # Neighbors within the blur are one observation.
    evidence *= step / max(3 * pixel, 0.02)

    def slope(shift: float) -> Array:
        place = np.clip((carried + shift - q[0]) / step, 0, len(q) - 1.001)
        k = place.astype(np.intp)
        return np.asarray(steep[:, k] * (1 - (place - k)) + steep[:, k + 1] * (place - k))

    h = max(2 * pixel, step)
    least = floor[:, np.clip(np.round((carried - q[0]) / step).astype(np.intp), 0, len(q) - 1)]
    top = np.maximum(slope(0), slope(-0.5 * h)) + least
    beyond = np.maximum(slope(h), slope(1.5 * h)) + least
    return np.asarray(evidence + np.clip(np.log(top / beyond), -2, 4))


def _profile(picture: Picture, rim: Outline, reach: float, inside: float) -> tuple[Array, Array]:
    """Return shifts within `reach` pixels, and the second evidence, (spokes, shifts)."""
    places, shifts, bases = _models(reach, inside)
    xy = rim.points(_SPOKES)[:, None, :] + places[:, None] * _normals(rim)[:, None, :]
    values = _lookup(picture.gray, xy)
    known = np.asarray(np.isfinite(values).all(axis=1))
    values = np.where(known[:, None], values, 0)
    values -= values.mean(axis=1, keepdims=True)
    total = (values * values).sum(axis=1)
    explained = np.empty((_SPOKES, len(shifts)))
    for k, basis in enumerate(bases):
        explained[:, k] = ((values @ basis) ** 2).sum(axis=1)
    left = np.maximum(total[:, None] - explained, 0) / len(places)
    # Four places to a pixel.
    evidence = -len(places) / 8 * np.log(left + picture.noise)
    return shifts, np.where(known[:, None], evidence, 0)


@lru_cache(maxsize=32)
def _models(reach: float, inside: float) -> tuple[Array, Array, list[Array]]:
    """Return places along a spoke, shifts, and for each an orthonormal basis of the profiles."""
    places = np.arange(-reach - inside, reach + inside + 0.51, 0.25)
    shifts = np.arange(-reach, reach + 1e-9, 0.125)
    fine = np.arange(places[0] - 4, places[-1] + 4, 0.05)
    blur = np.exp(-0.5 * (np.arange(-60, 61) * 0.05 / _PROFILE_BLUR) ** 2)
    blur /= blur.sum()
    bases = []
    for shift in shifts:
        depth = np.maximum(shift - fine, 0)
        within = (depth > 0).astype(np.float64)
        columns = [1 - within, (1 - within) * (fine - shift), within]
        columns += [depth**power for power in (0.5, 1.0, 1.5, 2.0)]
        blurred = [np.interp(places, fine, np.convolve(c, blur, "same")) for c in columns]
        bases.append(np.linalg.qr(np.stack(blurred, axis=-1))[0])
    return places, shifts, bases


# Directions in which an outline is tried: each harmonic, and each two of them.
_TRIED = np.concatenate(
    [
        np.eye(5),
        -np.eye(5),
        [
            (a * np.eye(5)[i] + b * np.eye(5)[j]) * 0.7
            for i, j in combinations(range(5), 2)
            for a in (-1, 1)
            for b in (-1, 1)
        ],
    ]
)


def _best(evidence: Array, shifts: Array, reach: float, roundness: float = 0.0) -> Array:
    """Return the harmonics, in pixels, with the most evidence."""
    step = float(shifts[1] - shifts[0])
    rows = np.arange(_SPOKES)

    def score(changes: Array) -> Array:
        place = (changes @ _HARMONICS.T - shifts[0]) / step
        k = np.clip(place.astype(np.intp), 0, len(shifts) - 2)
        t = np.clip(place - k, 0, 1)
        found = evidence[rows, k] * (1 - t) + evidence[rows, k + 1] * t
        found[(place < -0.5) | (place > len(shifts) - 0.5)] = 0
        bent = changes[:, 3] ** 2 + changes[:, 4] ** 2
        return np.asarray(found.mean(axis=1) - roundness * bent)

    # Circles about all centers first.
    off = np.linspace(-reach, reach, 13)
    grid = np.stack(np.meshgrid(shifts[::2], off, off, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[np.hypot(grid[:, 1], grid[:, 2]) <= 1.001 * reach]
    grid = np.concatenate([grid, np.zeros((len(grid), 2))], axis=1)
    scores = np.concatenate([score(grid[i : i + 1000]) for i in range(0, len(grid), 1000)])
    change, best = grid[int(np.argmax(scores))], float(scores.max())
    width = float(off[1] - off[0])
    while width > 0.1 * step:
        scores = score(change + width * _TRIED)
        if scores.max() > best + 1e-9:
            change, best = change + width * _TRIED[int(np.argmax(scores))], float(scores.max())
        else:
            width /= 2
    return np.asarray(change)


def _moved(rim: Outline, change: Array) -> Outline:
    """Return the ellipse through the points of a rim moved along its normals."""
    points = rim.points(_SPOKES) + (_HARMONICS @ change)[:, None] * _normals(rim)
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


def _spread(mask: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return what lies within `reach` rows and columns of a mask."""
    if not mask.any():
        return mask
    for axis in (0, 1):
        pad = [(0, 0), (0, 0)]
        pad[axis] = (reach, reach)
        window = sliding_window_view(np.pad(mask, pad), 2 * reach + 1, axis=axis)
        mask = np.asarray(window.any(axis=-1))
    return mask
