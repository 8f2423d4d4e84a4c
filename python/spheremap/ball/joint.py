"""Rims and rotations of several photos of a ball at once, from where they show the same.

A rim that is half a pixel off, of a radius of 80, turns the middle of what the photo shows by
2 · 0.5 / 80 = 0.7° and the rest by other angles: no rotation mends that. So center and radius of
each rim are unknowns beside each rotation, and Gauss and Newton's method looks for those at which
the photos differ least in log brightness. At each of some thousand directions both photos of a pair
are averaged over a disk as wide as the coarser one's pixels there. Tukey's weights keep out what
moved. How well a rim was found is a prior: where the photos say little, it stays.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..align.rotation_search import median, orthogonal, points, rotation_of_vector

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .camera import View
    from .finding import Ball
    from .photo import Shot

    Array = NDArray[np.float64]

# Directions that are compared.
_POINTS = 3000
# The coarsest disk, in radians: beyond, a rim shows nothing to go by.
_COARSEST = 0.15
# How wide the disks are, in pixels of the coarser photo, and how many steps each has: wide
# ones first, from far away.
_WIDTHS = ((4.0, 6), (2.0, 12), (1.0, 16))
# The step of a slope: radians of a rotation, radii of a rim.
_SLOPE = np.array([2e-3, 2e-3, 2e-3, 1e-3, 1e-3, 1e-3])
# How far a rim may be off, in radii, when it is found with full confidence.
_RIM = 0.01
# It is left where it was found if it goes farther than this.
_FARTHEST = 0.12
# Errors of this share of their root mean square are never outliers.
_OUTLYING = 0.5
# A pair needs so many directions for its unknowns.
_ENOUGH = 100


@dataclass
class Placed:
    """A photo, its rim, and how its camera is turned; what of them is to be found.

    `seen_by` returns the camera that sees a rim.
    """

    shot: Shot
    ball: Ball
    turn: Array
    seen_by: Callable[[Ball], View]
    free_rim: bool
    free_turn: bool

    def changed(self, change: Array) -> Placed:
        """Return it turned by three radians, its rim moved and grown by shares of the radius."""
        ball, shot = self.ball, self.shot
        if np.any(change[3:]):
            x, y = ball.center
            grown = 1 + change[5]
            ball = replace(
                ball,
                center=(x + change[3] * self.ball.radius, y + change[4] * self.ball.radius),
                radii=(ball.radii[0] * grown, ball.radii[1] * grown),
            )
            shot = copy.copy(shot)
            shot.view = self.seen_by(ball)
        turn = orthogonal(rotation_of_vector(change[:3]) @ self.turn)
        return replace(self, shot=shot, ball=ball, turn=turn)

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which of the six numbers of `changed` are unknown."""
        return np.array([self.free_turn] * 3 + [self.free_rim] * 3)


def refined(photos: Sequence[Placed], behind: float) -> list[Placed]:
    """Return the photos with the rims and rotations at which they differ least.

    `behind` is half the angle of the cone about each camera that does not count.
    """
    first, photos = list(photos), list(photos)
    free = np.concatenate([photo.free for photo in photos])
    if not free.any():
        return photos
    moved = np.zeros(len(free))  # of the rims, from where they were found
    prior = np.zeros(len(free))
    for k, photo in enumerate(photos):
        prior[6 * k + 3 : 6 * k + 6] = (max(photo.ball.confidence, 0.1) / _RIM) ** 2
    used = np.flatnonzero(free)
    for width, steps in _WIDTHS:
        for _ in range(steps):
            normal, right = _equations(photos, behind, width)
            normal += np.diag(prior)
            right -= prior * moved
            matrix = normal[np.ix_(used, used)]
            matrix += 1e-9 * np.trace(matrix) * np.eye(len(used))
            change = np.zeros(len(free))
            change[used] = np.linalg.solve(matrix, right[used])
            # Slopes hold for as far as a disk is wide.
            change *= min(1.0, 0.02 / max(float(np.abs(change).max()), 1e-12))
            photos = [p.changed(c) for p, c in zip(photos, change.reshape(-1, 6), strict=True)]
            moved += change
            if np.abs(change).max() < 1e-4 * width:
                break
    return photos if np.abs(moved.reshape(-1, 6)[:, 3:]).max() < _FARTHEST else first


def _equations(photos: Sequence[Placed], behind: float, disk: float) -> tuple[Array, Array]:
    """Return the normal equations of all unknowns, six to a photo."""
    count = len(photos)
    normal, right = np.zeros((6 * count, 6 * count)), np.zeros(6 * count)
    everywhere = points(_POINTS)
    spacing = [disk * _spacing(photo, everywhere, behind) for photo in photos]
    for i, j in combinations(range(count), 2):
        width = np.maximum(spacing[i], spacing[j])
        used = width < _COARSEST * math.sqrt(disk)
        if used.sum() < _ENOUGH:
            continue
        d = _disks(everywhere[used], width[used])
        a, b = _brightness(photos[i], d), _brightness(photos[j], d)
        columns = np.zeros((len(d), 12))
        for side, photo in enumerate((photos[i], photos[j])):
            for k in np.flatnonzero(photo.free):
                step = _SLOPE[k] * np.eye(6)[k]
                ahead, back = photo.changed(step), photo.changed(-step)
                slope = (_brightness(ahead, d) - _brightness(back, d)) / (2 * _SLOPE[k])
                columns[:, 6 * side + k] = slope if side == 0 else -slope
        known = np.isfinite(a) & np.isfinite(b) & np.isfinite(columns).all(axis=1)
        if known.sum() < _ENOUGH:
            continue
        error, columns = (b - a)[known], columns[known]
        even = np.ones(len(error))
        error = error - median(error, even)
        # Of a dark room with lamps the median sees none: what is yet to be aligned must not be
        # taken for what moved.
        usual = 1.4826 * median(np.abs(error), even)
        spread = max(usual, _OUTLYING * float(np.sqrt(np.mean(error**2)))) + 1e-6
        weight = np.clip(1 - (error / (4.685 * spread)) ** 2, 0, 1) ** 2 / spread**2
        # The exposure is free: what is left about the mean.
        mean = weight / weight.sum()
        columns = columns - mean @ columns
        error = error - mean @ error
        place = np.concatenate([6 * i + np.arange(6), 6 * j + np.arange(6)])
        normal[np.ix_(place, place)] += columns.T @ (weight[:, None] * columns)
        right[place] += columns.T @ (weight * error)
    return normal, right


def _spacing(photo: Placed, d: Array, behind: float) -> Array:
    """Return the angle between pixels in each direction; infinite where nothing counts."""
    seen = d @ photo.turn
    view = photo.shot.view
    least, _ = view.pixels_per_radian(seen)
    hidden = seen @ view.toward > np.cos(behind) if behind > 0 else np.zeros(len(d), np.bool_)
    counts = (photo.shot.weight(seen) > 0.5) & ~hidden & (least > 0)
    return np.where(counts, 1 / np.maximum(least, 1e-9), np.inf)


def _disks(d: Array, width: Array) -> Array:
    """Return directions in disks of a radius of `width` about directions, (N, 19, 3)."""
    k = np.arange(19) + 0.5
    r, t = np.sqrt(k / 19), np.pi * (1 + 5**0.5) * k
    x = np.cross(d, np.eye(3)[np.argmin(np.abs(d), axis=-1)])
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    y = np.cross(d, x)
    around = (r * np.cos(t))[:, None] * x[:, None] + (r * np.sin(t))[:, None] * y[:, None]
    out = d[:, None] + width[:, None, None] * around
    return np.asarray(out / np.linalg.norm(out, axis=-1, keepdims=True))


def _brightness(photo: Placed, d: Array) -> Array:
    """Return the logarithm of what a photo shows in disks; NaN if it shows not all of them."""
    shape = d.shape[:-1]
    values = photo.shot.look((d @ photo.turn).reshape(-1, 3)).mean(axis=-1).reshape(shape)
    mean = np.maximum(values.mean(axis=-1), 0)
    bright = mean[np.isfinite(mean) & (mean > 0)]
    # What is far below the middle is noise, and its logarithm would be loud.
    floor = 0.02 * float(np.median(bright)) if bright.size else 1.0
    return np.asarray(np.log(mean + floor))
