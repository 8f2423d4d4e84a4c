"""Where a camera sees the directions of a world on a mirrored ball, for millions of them.

`View` says it exactly, by Newton's method and a dozen sines for each direction. Seen from the ball,
all of that depends on one number, the angle ψ from the camera; it is tabulated here, over
s = cos(ψ/2). With t the direction to the camera and P the ray to the place on the ball, in units in
which it is 1 along -t,

    P = g (d - (d·t) t) - t,  g = tan γ / sin ψ = k / 2s,

where k = tan γ / sin(ψ/2) is smooth up to the rim, and 1 for the ideal camera, in which tan γ
stands for the radius in the picture. The picture is linear in P: a matrix takes d to all but g.

How finely it is sampled follows from the same numbers. Away from t P moves by A = d tan γ / dψ, and
across by g; of the derivative's sum of squares everything but A and g is known from the place p in
the picture alone, without any direction in it: (A² - g²) / tan²γ = M / 4s² is smooth, too.

4096 steps put places within 1e-8 of the radius, and within 1e-5 for a camera that nearly touches
the ball.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .camera import _across
from .metals import fresnel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .camera import View

    Array = NDArray[np.float64]

_STEPS = 4096
# In place of ψ = 0, where quotients are 0/0: they differ by its square.
_LEAST = 1e-3


class Aim:
    """A view, and how its camera is turned: ``turn`` takes its frame to the world.

    Places are rays of the perspective projection of 90° whose image is the photo: what
    `sample` wants. None is nearer to the rim than `inset` pixels.
    """

    def __init__(self, view: View, turn: Array, inset: float, metal: str | None = None) -> None:
        height, width = view.size
        self._half = np.array([width / 2, height / 2])
        # From the camera's frame to pixels from the principal point, and the depth.
        if view.ideal:
            c, s = np.cos(view.outline.angle), np.sin(view.outline.angle)
            across = view.outline.matrix() @ np.array([[c, s], [-s, c]])
            origin = np.array(view.outline.center)
        else:
            across, origin = np.eye(2) * view.focal, np.array(view.principal)
        camera = np.zeros((3, 3))
        camera[:2, :2], camera[2, 2] = across * [1, -1], -1
        self._off = origin - self._half
        self._squares = float(np.sum(across**2))
        self._area = float(np.linalg.det(across))
        self._axis = camera @ view.toward
        plane = np.array([[1, 0, self._off[0]], [0, -1, -self._off[1]], [0, 0, -width / 2]])
        ray = plane @ camera / (width / 2)
        self._start = ray @ -view.toward
        sideways = np.eye(3) - np.outer(view.toward, view.toward)
        self._matrix = np.ascontiguousarray(
            turn @ np.concatenate([(ray @ sideways).T, view.toward[:, None]], axis=1)
        )
        self._tabulate(view, inset, metal)

    def _tabulate(self, view: View, inset: float, metal: str | None) -> None:
        self._first = np.sin(view.blind / 2)
        self._scale = _STEPS / (1 - self._first)
        s = np.linspace(self._first, 1, _STEPS + 1)
        psi = np.clip(2 * np.arccos(s), _LEAST, np.pi - view.blind)
        phi = view._reflecting(psi)
        half, cos = np.sin(psi / 2), np.cos(psi / 2)
        if view.ideal:
            tangent, slope = np.sin(phi), np.cos(phi) / 2
            bound = 1.0
        else:
            bend = np.maximum(view._bend(np.cos(phi)), 0)
            tangent = np.sin(phi) / (view.distance - np.cos(phi))
            slope = (1 + tangent**2) * bend / (2 + bend)
            bound = np.tan(view.blind)
        # Here and below: the value at each step, and how much it differs at the next. What comes
        # before the first is the blind cone.
        bound *= 1 - _share(view, bound, inset)
        self._inside = _steps(np.minimum(tangent, bound) / half)
        self._stretch = _steps(tangent / half)
        # A g, by s: at the rim of the ideal camera it is 0/0.
        grown = np.where(view.ideal, 0.25, slope * tangent / (2 * half * np.maximum(cos, 1e-300)))
        self._grown = _steps(grown)
        self._uneven = _steps(((2 * cos * slope) ** 2 - (tangent / half) ** 2) / tangent**2)
        self._metal = None
        if metal is not None:
            self._metal = [_steps(c) for c in fresnel(np.cos(psi - phi), metal).T]

    def places(self, d: Array) -> tuple[Array, Spot]:
        """Return the rays at which unit directions (N, 3) are seen, and where that is."""
        q = d @ self._matrix
        s = np.sqrt(np.maximum(0.5 + 0.5 * q[:, 3], 0))
        step = np.fmax((s - self._first) * self._scale + 1, 0)
        index = step.astype(np.intp)
        spot = Spot(index, step - index, s)
        rays = q[:, :3] * (0.5 * spot.at(self._inside) / s)[:, None]
        rays += self._start
        return rays, spot

    def pixels(self, rays: Array) -> tuple[Array, Array]:
        """Return x and y of places, in pixels from the photo's upper left corner."""
        half = self._half
        far = half[0] / -rays[:, 2]
        return rays[:, 0] * far + half[0], half[1] - rays[:, 1] * far

    def pixels_per_radian(self, rays: Array, x: Array, y: Array, spot: Spot) -> tuple[Array, Array]:
        """Return how far neighboring directions lie apart: least and most, 0 in the blind cone."""
        x, y = x - (self._half[0] + self._off[0]), y - (self._half[1] + self._off[1])
        a, b, c = self._axis
        along = (a - x * c) ** 2 + (b - y * c) ** 2
        depth = -rays[:, 2]
        total = spot.at(self._stretch) ** 2 * (self._squares + x * x + y * y - along)
        total += spot.at(self._uneven) * along
        total /= (2 * spot.s * depth) ** 2
        area = self._area * spot.at(self._grown) / depth**3
        most = np.sqrt((total + np.sqrt(np.maximum(total**2 - 4 * area**2, 0))) / 2)
        least = area / np.where(most > 0, most, 1)
        return np.nan_to_num(least, copy=False), np.nan_to_num(most, copy=False)

    def reflectance(self, spot: Spot) -> Array:
        """Return that of the metal, for red, green and blue."""
        assert self._metal is not None
        return np.stack([spot.at(c) for c in self._metal], axis=-1)


class Spot:
    """Places in the tables."""

    def __init__(self, index: NDArray[np.intp], beyond: Array, s: Array) -> None:
        self._index, self._beyond, self.s = index, beyond, s

    def __getitem__(self, part: slice) -> Spot:
        return Spot(self._index[part], self._beyond[part], self.s[part])

    def at(self, table: tuple[Array, Array]) -> Array:
        """Return a function there."""
        values = table[1].take(self._index, mode="clip")
        values *= self._beyond
        values += table[0].take(self._index, mode="clip")
        return values


def _share(view: View, bound: float, inset: float) -> float:
    """Return the share of `bound`, tan γ at the rim, within which places are `inset` pixels in."""
    wanted = min(inset / min(view.outline.along, view.outline.across), 0.5)
    t = 2 * np.pi * np.arange(64) / 64
    x = _across(view.toward)
    e = np.cos(t)[:, None] * x + np.sin(t)[:, None] * np.cross(view.toward, x)
    # Of a ball that is seen off the axis both ends of the outline are not equally far.
    far = 1.0 if view.ideal else view.distance
    place = view.outline.relative(view._project(far * bound * (1 - wanted) * e))
    inside = 1 - float(np.hypot(*place.T).max())
    return min(wanted * wanted / inside, 0.9) if wanted > 0 else 0.0


def _steps(values: Array) -> tuple[Array, Array]:
    blind = np.full(1, np.nan)
    return np.concatenate([blind, values]), np.concatenate([blind, np.diff(values), [0.0]])
