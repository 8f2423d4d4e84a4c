"""A mirrored ball before a camera: which pixel shows which direction, and how finely.

The ball has radius 1 and the environment is infinitely far away. In the plane of the camera, the
center of the ball and the direction, let φ be the angle at the center between the camera and the
point that reflects, γ the angle at the camera between the center and that point, D the distance of
the camera from the center. The ray arrives φ + γ off the normal and leaves ψ = 2φ + γ off the axis
from the ball to the camera, with tan γ = sin φ / (D - cos φ). The way back is Alhazen's problem; as
the light comes from infinity it is one equation in φ, concave and increasing up to the outline at
cos φ = 1/D, so that Newton's method converges from every start. With D → ∞ it is φ = ψ/2: the
`sphere` projection.

The outline is a conic. A ball β = asin(1/D) in angular radius whose center lies α off the
camera's axis has, at focal length 1 and with A = cos²α - sin²β = cos(α+β) cos(α-β), its center at
sin 2α / 2A, the semi-axis sin 2β / 2A toward the principal point and sin β / √A across.
The last ray that is reflected goes straight on: what lies within β of the direction from the
camera to the ball is never seen. That is the blind cone.

Frames: pixels have x to the right and y down from the picture's upper left corner, so that the
first pixel's center is (½, ½). Directions are in the camera's frame, x right, y up, z from the
scene to the camera, as the axes "+x -y +z" of `sphere` have it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .._scalars import as_number, kind_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

# Newton's steps for φ, from near and from 2 radii on: they converge quadratically (a test).
_STEPS, _STEPS_FAR = 9, 4
# The nearest camera, in radii from the center.
NEAREST = 1.001
# Radii of an outline, in pixels: beyond, its numbers end.
_SMALLEST, _LARGEST = 1e-3, 1e7
# From here on a camera is the ideal one: directions differ by 1e-8.
_IDEAL = 1e8
# How far two statements about one camera may differ, in the size of the outline.
_TOLERANCE = 0.05


@dataclass(frozen=True)
class Outline:
    """The rim of a ball in a picture: an ellipse, in pixels.

    `along` is the semi-axis in the direction of `angle` (radians, clockwise from x), `across` the
    other.
    """

    center: tuple[float, float]
    along: float
    across: float
    angle: float = 0.0

    @property
    def mean(self) -> float:
        """The radius of the circle of the same area."""
        return math.sqrt(self.along * self.across)

    def matrix(self) -> Array:
        """Return what takes the unit disk to the ellipse, but for the center."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        turn = np.array([[c, -s], [s, c]])
        return turn * [self.along, self.across]

    def relative(self, xy: Array) -> Array:
        """Return pixels in the frame in which the ellipse is the unit circle."""
        return (xy - self.center) @ np.linalg.inv(self.matrix()).T

    def points(self, count: int, inset: float = 0.0) -> Array:
        """Return `count` points on the rim, `inset` pixels inside."""
        t = 2 * np.pi * np.arange(count) / count
        shrunk = replace(self, along=self.along - inset, across=self.across - inset)
        circle = np.stack([np.cos(t), np.sin(t)], axis=-1)
        return circle @ shrunk.matrix().T + self.center


@dataclass(frozen=True)
class View:
    """A camera that looks at a ball.

    `focal` is in pixels; it and `distance` (in radii of the ball) are infinite for the ideal
    camera. `toward` is the direction from the ball to the camera.
    """

    size: tuple[int, int]
    outline: Outline
    principal: tuple[float, float]
    focal: float
    distance: float
    toward: Array

    @property
    def ideal(self) -> bool:
        """Whether it is infinitely far away."""
        return math.isinf(self.distance)

    @property
    def fov(self) -> float | None:
        """The horizontal angle of the picture in degrees; None for the ideal camera."""
        return None if self.ideal else math.degrees(2 * math.atan(self.size[1] / 2 / self.focal))

    @property
    def blind(self) -> float:
        """Half the angle of the blind cone, in radians."""
        return 0.0 if self.ideal else math.asin(1 / self.distance)

    def rays(self, xy: Array) -> Array:
        """Return unit directions of the rays from the camera through pixels."""
        ray = np.empty((*xy.shape[:-1], 3))
        if self.ideal:
            ray[...] = -self.toward
            return ray
        ray[..., 0] = (xy[..., 0] - self.principal[0]) / self.focal
        ray[..., 1] = (self.principal[1] - xy[..., 1]) / self.focal
        ray[..., 2] = -1
        return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))

    def reflections(self, xy: Array) -> tuple[Array, Array]:
        """Return the directions that pixels show, and the cosines of incidence there.

        Both are NaN beside the ball.
        """
        with np.errstate(invalid="ignore"):
            if self.ideal:
                p = self.outline.relative(xy) @ self._unskewed().T
                cosine = np.sqrt(1 - np.sum(p * p, axis=-1))
                normal = np.stack([p[..., 0], -p[..., 1], cosine], axis=-1)
                return 2 * cosine[..., None] * normal - [0, 0, 1], cosine
            ray = self.rays(xy)
            center = -self.distance * self.toward
            middle = ray @ center
            # What of the center is across the ray: its square against 1, without canceling.
            off = np.sum((center - middle[..., None] * ray) ** 2, axis=-1)
            cosine = np.sqrt(1 - off)  # of the incidence, on a ball of radius 1
            normal = (middle - cosine)[..., None] * ray - center
            return ray + 2 * cosine[..., None] * normal, cosine

    def pixels(self, d: Array) -> Array:
        """Return the pixels that show unit directions; NaN in the blind cone."""
        psi, e = self._polar(d)
        phi = self._reflecting(psi)
        normal = np.cos(phi)[..., None] * self.toward + np.sin(phi)[..., None] * e
        return self._project(normal)

    def _project(self, normal: Array) -> Array:
        """Return where a point of the ball is in the picture."""
        if self.ideal:
            p = np.stack([normal[..., 0], -normal[..., 1]], axis=-1)
            return (p @ self._unskewed()) @ self.outline.matrix().T + self.outline.center
        point = normal - self.distance * self.toward
        scale = self.focal / -point[..., 2]
        x = self.principal[0] + scale * point[..., 0]
        return np.stack([x, self.principal[1] - scale * point[..., 1]], axis=-1)

    def _unskewed(self) -> Array:
        """Return the turn from the ellipse's own frame to the picture's."""
        c, s = math.cos(self.outline.angle), math.sin(self.outline.angle)
        return np.array([[c, -s], [s, c]])

    def pixels_per_radian(self, d: Array) -> tuple[Array, Array]:
        """Return how far neighboring directions lie apart in the picture: least and most.

        Pixels per radian, 0 in the blind cone; their product is pixels per steradian.
        """
        psi, e = self._polar(d)
        phi = self._reflecting(psi)
        sin, cos = np.sin(phi), np.cos(phi)
        if self.ideal:
            slope = np.full_like(phi, 0.5)
        else:
            with np.errstate(divide="ignore"):
                slope = 1 / (2 + self._bend(cos))
        # At the middle of the ball both are its curvature.
        near = psi < 1e-6
        ratio = np.where(near, slope, sin / np.where(near, 1, np.sin(psi)))
        along = slope[..., None] * (cos[..., None] * e - sin[..., None] * self.toward)
        across = ratio[..., None] * np.cross(self.toward, e)
        if self.ideal:
            matrix = self.outline.matrix() @ self._unskewed().T * [1, -1]
            columns = [v[..., :2] @ matrix.T for v in (along, across)]
        else:
            point = cos[..., None] * self.toward + sin[..., None] * e
            point = point - self.distance * self.toward
            depth = -point[..., 2]
            columns = []
            for v in (along, across):
                x = v[..., 0] * depth + point[..., 0] * v[..., 2]
                y = -v[..., 1] * depth - point[..., 1] * v[..., 2]
                columns.append(np.stack([x, y], axis=-1) * (self.focal / depth**2)[..., None])
        (a, c), (b, d_) = (np.moveaxis(v, -1, 0) for v in columns)
        # Singular values of [[a, b], [c, d]].
        total = a * a + b * b + c * c + d_ * d_
        area = np.abs(a * d_ - b * c)
        most = np.sqrt((total + np.sqrt(np.maximum(total**2 - 4 * area**2, 0))) / 2)
        least = area / np.where(most > 0, most, 1)
        return np.nan_to_num(least), np.nan_to_num(most)

    def incidence(self, d: Array) -> Array:
        """Return the cosine of the angle at which light from a direction meets the mirror."""
        psi, _ = self._polar(d)
        # ψ = φ + i
        return np.cos(psi - self._reflecting(psi))

    def _polar(self, d: Array) -> tuple[Array, Array]:
        """Return the angle from the axis, and the unit vector away from it."""
        along = d @ self.toward
        off = d - along[..., None] * self.toward
        # Sums over an axis of three are slow.
        h = np.sqrt(off[..., 0] ** 2 + off[..., 1] ** 2 + off[..., 2] ** 2)
        straight = h < 1e-300
        e = off / np.where(straight, 1, h)[..., None]
        if np.any(straight):
            e = np.where(straight[..., None], _across(self.toward), e)
        return np.arctan2(h, along), e

    def _reflecting(self, psi: Array) -> Array:
        """Return φ for ψ = 2φ + γ; NaN in the blind cone."""
        if self.ideal:
            return psi / 2
        top = math.acos(1 / self.distance)
        # γ bends most at 0: this start, and every step from it, is left of the root.
        phi = psi / (2 + 1 / (self.distance - 1))
        for _ in range(_STEPS if self.distance < 2 else _STEPS_FAR):
            sin, cos = np.sin(phi), np.cos(phi)
            error = psi - 2 * phi - np.arctan2(sin, self.distance - cos)
            phi = np.minimum(phi + error / (2 + self._bend(cos)), top)
        return np.where(psi <= np.pi - self.blind, phi, np.nan)

    def _bend(self, cos: Array) -> Array:
        """Return dγ/dφ."""
        D = self.distance
        return (D * cos - 1) / (D * D - 2 * D * cos + 1)


def _across(axis: Array) -> Array:
    """Return some unit vector at right angles."""
    k = int(np.argmin(np.abs(axis)))
    v = np.cross(axis, np.eye(3)[k])
    return np.asarray(v / np.linalg.norm(v))


def number(value: object, name: str) -> float:
    """Return a number as a float; a bool is none."""
    if isinstance(value, bool | np.bool_):
        raise TypeError(f"Expected `{name}` to be a number, got {kind_of(value)}.")
    return as_number(value, name)


def optional_number(value: object, name: str) -> float | None:
    """Return a number as a float, or None."""
    return None if value is None else number(value, name)


def view(
    size: tuple[int, int],
    outline: Outline | None,
    *,
    center: tuple[float, float] | None = None,
    fov: float | None = None,
    distance: float | None = None,
    principal: tuple[float, float] | None = None,
) -> View:
    """Return the camera that sees a ball with this outline.

    Of the field of view, the distance and the size of the outline, two give the third. With the
    outline alone, or with a distance of 1e8 and more, the camera is at infinity. Without an
    outline, its `center` is needed and both others.
    """
    height, width = size
    middle = (width / 2, height / 2) if principal is None else principal
    fov, distance = optional_number(fov, "fov"), optional_number(distance, "distance")
    if distance is not None and distance >= _IDEAL and fov is None:
        distance = None
    if distance is not None and not distance >= NEAREST:
        raise ValueError(
            f"`distance` must be at least {NEAREST} (radii of the ball, from its center to the "
            f"camera), got {distance}."
        )
    if fov is not None and not 1e-6 <= fov < 179:
        raise ValueError(f"`fov` must be in [1e-6, 179) degrees, got {fov}.")
    focal = math.inf if fov is None else width / 2 / math.tan(math.radians(fov) / 2)
    if outline is not None:
        for radius in (outline.along, outline.across):
            if not _SMALLEST <= radius <= _LARGEST:
                raise ValueError(
                    f"`radius` must be from {_SMALLEST:g} to {_LARGEST:g} pixels, got {radius:g}."
                )
    if fov is not None and distance == math.inf:
        raise ValueError(
            f"`fov` {fov:g} and `distance` inf do not go together: the ideal camera, "
            "infinitely far away, has no angle. Give one of both."
        )
    if outline is None:
        if fov is None or distance is None or center is None:
            raise ValueError("Without `radius`, `fov` and `distance` must both be given.")
        return _placed(size, center, middle, focal, distance)
    if fov is None and distance is None:
        return View(size, outline, middle, math.inf, math.inf, np.array([0.0, 0.0, 1.0]))
    off = math.dist(outline.center, middle)
    if distance is not None:
        wanted = math.asin(1 / distance)
        # A longer focal length makes the same outline a smaller angle.
        found = math.exp(
            _bisect(
                lambda t: wanted - _angles(off, outline.mean, math.exp(t))[1],
                math.log(outline.mean * 1e-3),
                math.log(outline.mean * 10 * distance),
            )
        )
        if fov is None:
            focal = found
        elif abs(_size_at(off, outline.mean, focal, wanted) - 1) > _TOLERANCE:
            raise ValueError(
                f"`fov` {fov:g}, `distance` {distance:g} and an outline {outline.mean:.1f} pixels "
                f"in radius do not go together: with this distance the outline says fov "
                f"{math.degrees(2 * math.atan(width / 2 / found)):.4g}. Give two of the three."
            )
    alpha, beta = _angles(off, outline.mean, focal)
    if distance is None and beta > math.asin(1 / NEAREST):
        raise ValueError(
            f"`fov` {fov:g} and a `radius` of {outline.mean:g} pixels do not go together: the "
            f"camera would be nearer to the ball's center than {NEAREST} radii."
        )
    return _seen(size, outline.center, middle, focal, alpha, beta)


def _seen(
    size: tuple[int, int],
    center: tuple[float, float],
    principal: tuple[float, float],
    focal: float,
    alpha: float,
    beta: float,
) -> View:
    dx, dy = center[0] - principal[0], center[1] - principal[1]
    off = math.hypot(dx, dy)
    ex, ey = (dx / off, dy / off) if off > 0 else (1.0, 0.0)
    _, along, across = _conic(alpha, beta)
    outline = Outline(center, along * focal, across * focal, math.atan2(ey, ex))
    toward = np.array([-math.sin(alpha) * ex, math.sin(alpha) * ey, math.cos(alpha)])
    return View(size, outline, principal, focal, 1 / math.sin(beta), toward)


def _placed(
    size: tuple[int, int],
    center: tuple[float, float],
    principal: tuple[float, float],
    focal: float,
    distance: float,
) -> View:
    beta = math.asin(1 / distance)
    off = math.dist(center, principal) / focal
    # The ball is wholly before the camera while α + β < 90°.
    alpha = _bisect(lambda a: _conic(a, beta)[0] - off, 0.0, math.pi / 2 - beta - 1e-9)
    return _seen(size, center, principal, focal, alpha, beta)


def _conic(alpha: float, beta: float) -> tuple[float, float, float]:
    """Return the outline at focal length 1: its center's distance, and the semi-axes."""
    a = math.cos(alpha + beta) * math.cos(alpha - beta)
    return math.sin(2 * alpha) / (2 * a), math.sin(2 * beta) / (2 * a), math.sin(beta) / a**0.5


def _angles(off: float, mean: float, focal: float) -> tuple[float, float]:
    """Return α and β of an outline whose center is `off` pixels from the principal point."""

    def both(along: float) -> tuple[float, float]:
        far, near = math.atan((off + along) / focal), math.atan((off - along) / focal)
        return (far + near) / 2, (far - near) / 2

    def excess(along: float) -> float:
        _, a, b = _conic(*both(along))
        return math.sqrt(a * b) * focal - mean

    # The semi-axis toward the principal point is the longer one.
    high = mean
    while excess(high) < 0:
        high *= 1.5
    return both(_bisect(excess, 0.5 * mean, high))


def _size_at(off: float, mean: float, focal: float, beta: float) -> float:
    """Return how much larger a ball of that angle would be than its outline is."""
    return math.tan(beta) / math.tan(_angles(off, mean, focal)[1])


def _bisect(f: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of an increasing function."""
    for _ in range(80):
        middle = (low + high) / 2
        if f(middle) < 0:
            low = middle
        else:
            high = middle
    return (low + high) / 2
