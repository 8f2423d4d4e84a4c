"""Rims and rotations of several photos of a ball at once, from where they show the same.

A rim that is half a pixel off, of a radius of 80, turns the middle of what the photo shows by
2 · 0.5 / 80 = 0.7° and the rest by other angles: no rotation mends that. So center and radius of
each rim are unknowns beside each rotation, and Gauss and Newton's method looks for those at which
the photos differ least in log brightness. At each of some thousand directions both photos of a pair
are averaged over a disk as wide as the coarser one's pixels there. Tukey's weights keep out what
moved. How well a rim was found is a prior: where the photos say little, it stays.

Nor does one rotation mend a wrong distance: taken as infinite, a camera 5 radii away puts what its
rim shows asin(1/5) = 12° off, and the second photo has that elsewhere. So the photos' angle, from
which each rim has its distance, may be one unknown more, the same for all of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from .._progress import done
from ..align.rotation_search import median, orthogonal, rotation_of_vector
from ..map.evenly import points

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
_SLOPE = np.array([2e-3, 2e-3, 2e-3, 1e-3, 1e-3, 1e-3, 2e-3])
# The angle of a rim about which the lens is looked for, and how far it may be from there, in
# radians: most photos are taken from 3 radii (0.34) or farther.
LIKELY_ANGLE, _LENS = 0.12, 0.2
# The camera looked for is between these angles of a rim, in radians.
_FARTHEST_LENS, _NEAREST_LENS = 1e-3, 0.9
# The widest picture by how far it is: 170°.
_WIDEST = 2 * math.tan(math.radians(85))
# Neighboring places err alike, and rims are not where they were said: by so much more than its
# formal error an estimate is off, at most 1.3 times the doubt in eight pairs of known distances.
_ALIKE = 20.0
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

    `seen_by` returns the camera that sees a rim, with a lens whose picture is `lens` times as wide
    as far; None where it is known. `gain` makes its channels as bright as those of the others.
    """

    shot: Shot
    ball: Ball
    turn: Array
    seen_by: Callable[[Ball, float | None], View]
    free_rim: bool
    free_turn: bool
    lens: float | None = None
    gain: Array | float = 1.0

    def changed(self, change: Array) -> Placed:
        """Return it turned by three radians, its rim moved and grown by shares of the radius.

        The seventh is what the lens's `lens` grows by.
        """
        ball, shot, lens = self.ball, self.shot, self.lens
        if np.any(change[3:6]):
            x, y = ball.center
            grown = 1 + change[5]
            ball = replace(
                ball,
                center=(x + change[3] * self.ball.radius, y + change[4] * self.ball.radius),
                radii=(ball.radii[0] * grown, ball.radii[1] * grown),
            )
        if lens is not None:
            width = shot.view.size[1] / ball.radius
            lens = float(np.clip(lens + change[6], _FARTHEST_LENS * width, _NEAREST_LENS * width))
            lens = min(lens, _WIDEST)
        if np.any(change[3:]):
            shot = shot.seen_by(self.seen_by(ball, lens))
        turn = orthogonal(rotation_of_vector(change[:3]) @ self.turn)
        return replace(self, shot=shot, ball=ball, turn=turn, lens=lens)

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which of the seven numbers of `changed` are unknown."""
        return np.array(
            [self.free_turn] * 3 + [self.free_rim] * 3 + [self.lens is not None], np.bool_
        )


def refined(photos: Sequence[Placed], behind: float) -> tuple[list[Placed], float]:
    """Return the photos with the rims, rotations and lens at which they differ least.

    `behind` is half the angle of the cone about each camera that does not count. Also returned is
    how far, in radians, the angle of the first rim may be off, one standard deviation; infinite
    where it is unknown.
    """
    first, photos = list(photos), list(photos)
    free = np.array([photo.free for photo in photos])
    # One lens for all of them: the last unknown.
    unknown = np.append(free[:, :6].ravel(), free[:, 6].any())
    if not unknown.any():
        return photos, 0.0
    used = np.flatnonzero(unknown)
    moved = np.zeros(len(unknown))  # of rims and lens, from where they were found
    prior = np.zeros(len(unknown))
    for k, photo in enumerate(photos):
        prior[6 * k + 3 : 6 * k + 6] = (max(photo.ball.confidence, 0.1) / _RIM) ** 2
    angle = photos[0].ball.radius / photos[0].shot.view.size[1]
    prior[-1] = (angle / _LENS) ** 2
    data = np.zeros((len(used), len(used)))
    all_steps, ended = sum(steps for _, steps in _WIDTHS), 0
    for width, steps in _WIDTHS:
        for step in range(steps):
            done((ended + step) / all_steps)
            normal, right = _equations(photos, behind, width)
            data = normal[np.ix_(used, used)]
            normal += np.diag(prior)
            right -= prior * moved
            matrix = normal[np.ix_(used, used)]
            matrix += 1e-9 * np.trace(matrix) * np.eye(len(used))
            change = np.zeros(len(unknown))
            change[used] = np.linalg.solve(matrix, right[used])
            # Slopes hold for as far as a disk is wide.
            change *= min(1.0, 0.02 / max(float(np.abs(change).max()), 1e-12))
            each = np.concatenate(
                [change[:-1].reshape(-1, 6), np.full((len(photos), 1), change[-1])], axis=1
            )
            photos = [p.changed(c) for p, c in zip(photos, each, strict=True)]
            moved += change
            if np.abs(change).max() < 1e-4 * width:
                break
        ended += steps
    if np.abs(moved[:-1].reshape(-1, 6)[:, 3:]).max() >= _FARTHEST:
        return first, math.inf
    if not unknown[-1]:
        return photos, 0.0
    known = data / _ALIKE**2 + np.diag(prior[used] + 1e-9)
    return photos, angle * math.sqrt(float(np.linalg.inv(known)[-1, -1]))


def _equations(photos: Sequence[Placed], behind: float, disk: float) -> tuple[Array, Array]:
    """Return the normal equations of all unknowns, six to a photo and one for the lens."""
    count = len(photos)
    normal, right = np.zeros((6 * count + 1, 6 * count + 1)), np.zeros(6 * count + 1)
    everywhere = points(_POINTS)
    spacing = [disk * _spacing(photo, everywhere, behind) for photo in photos]
    for i, j in combinations(range(count), 2):
        width = np.maximum(spacing[i], spacing[j])
        used = width < _COARSEST * math.sqrt(disk)
        if used.sum() < _ENOUGH:
            continue
        d = _disks(everywhere[used], width[used])
        a, b = _brightness(photos[i], d), _brightness(photos[j], d)
        columns = np.zeros((len(d), 13))
        for side, photo in enumerate((photos[i], photos[j])):
            for k in np.flatnonzero(photo.free):
                step = _SLOPE[k] * np.eye(7)[k]
                ahead, back = photo.changed(step), photo.changed(-step)
                slope = (_brightness(ahead, d) - _brightness(back, d)) / (2 * _SLOPE[k])
                columns[:, 6 * side + k if k < 6 else 12] += slope if side == 0 else -slope
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
        place = np.concatenate([6 * i + np.arange(6), 6 * j + np.arange(6), [6 * count]])
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
    colors = photo.shot.look((d @ photo.turn).reshape(-1, 3)) * photo.gain
    values = colors.mean(axis=-1).reshape(shape)
    mean = np.maximum(values.mean(axis=-1), 0)
    bright = mean[np.isfinite(mean) & (mean > 0)]
    # What is far below the middle is noise, and its logarithm would be loud.
    floor = 0.02 * float(np.median(bright)) if bright.size else 1.0
    return np.asarray(np.log(mean + floor))
