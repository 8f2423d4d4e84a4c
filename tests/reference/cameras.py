"""The NumPy reference of calibrated cameras, from their papers and OpenCV's pages.

Only cameras whose lens holds the whole image: `tests/map/test_cameras.py` has the others. Inverses
are bisections, and Newton's method along a ray from the axis for what has no symmetry.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from .atlas import Array, Parameters, World, azimuth, gauss, inverse, pi, polynomial, within

# A lens ends where its slope has fallen to this part of its chord's.
LEAST_SLOPE = 0.01


def sensor(k: Parameters) -> tuple[float, float, float, float]:
    """Focal lengths and principal point in p and q."""
    return (
        2 * k.get("fx", 0.5),
        2 * k.get("fy", 0.5),
        2 * k.get("cx", 0.0),
        2 * k.get("cy", 0.0),
    )


@dataclass(frozen=True)
class Radial:
    """The image radius of an angle from the axis, and how far it may be asked."""

    radius: Callable[[Array, Parameters], Array]

    def slope(self, theta: Array, k: Parameters) -> Array:
        """Differences of sixth order over a thousandth: 1e-15 or so in longdouble."""
        h = 1e-3
        r = lambda n: self.radius(theta + n * h, k) - self.radius(theta - n * h, k)  # noqa: E731
        return (45 * r(1) - 9 * r(2) + r(3)) / (60 * h)

    def end(self, k: Parameters) -> float:
        return _end(self, tuple(sorted(k.items())))

    def theta(self, r: Array, k: Parameters) -> Array:
        return inverse(lambda theta: self.radius(theta, k), r, self.end(k))


@cache
def _end(lens: Radial, parameters: tuple[tuple[str, float], ...]) -> float:
    """Search once for each lens: it took most of the time of tests that ask about it."""
    k = dict(parameters)
    theta = np.linspace(0, math.pi, 20_001)[1:].astype(np.longdouble)
    with np.errstate(all="ignore"):
        r = lens.radius(theta, k)
        good = (r > 0) & (lens.slope(theta, k) * theta > LEAST_SLOPE * r)
    return float(theta[-1] if good.all() else theta[max(np.argmin(good) - 1, 0)])


def _plane(theta: Array, _: Parameters) -> Array:
    return np.where(theta < pi(theta.dtype) / 2, np.tan(theta), np.nan)


def _mei(theta: Array, k: Parameters) -> Array:
    depth = np.cos(theta) + k.get("xi", 1.0)
    return np.where(depth > 0, np.sin(theta) / depth, np.nan)


def _two_spheres(theta: Array, k: Parameters) -> Array:
    xi, alpha = k.get("xi", -0.2), k.get("alpha", 0.6)
    x, z = np.sin(theta), np.cos(theta)
    depth = alpha * np.sqrt(x * x + (xi + z) ** 2) + (1 - alpha) * (xi + z)
    return np.where(depth > 0, x / depth, np.nan)


def _ellipsoid(theta: Array, k: Parameters) -> Array:
    alpha, beta = k.get("alpha", 0.5), k.get("beta", 1.0)
    x, z = np.sin(theta), np.cos(theta)
    depth = alpha * np.sqrt(beta * x * x + z * z) + (1 - alpha) * z
    return np.where(depth > 0, x / depth, np.nan)


def _stretched(theta: Array, k: Parameters) -> Array:
    omega = np.asarray(k.get("omega", 0.9), theta.dtype)
    return np.arctan2(2 * np.tan(omega / 2) * np.sin(theta), np.cos(theta)) / omega


def _angle(theta: Array, _: Parameters) -> Array:
    return theta


RADIAL = {
    "camera_pinhole": Radial(_plane),
    "camera_brown_conrady": Radial(_plane),
    "camera_kannala_brandt": Radial(polynomial),
    "camera_unified": Radial(_mei),
    "camera_double_sphere": Radial(_two_spheres),
    "camera_eucm": Radial(_ellipsoid),
    "camera_fov": Radial(_stretched),
    "camera_thin_prism_fisheye": Radial(_angle),
    "camera_rad_tan_thin_prism_fisheye": Radial(_angle),
}
COEFFICIENTS = (
    *("k0", "k1", "k2", "k3", "k4", "k5", "k6", "p0", "p1", "p2"),
    *("s0", "s1", "s2", "s3", "s4", "tau_x", "tau_y"),
)


Distortion = Callable[[Array, Array, Parameters], tuple[Array, Array]]


def distort(x: Array, y: Array, k: Parameters) -> tuple[Array, Array]:
    """OpenCV's x''' and y''' of x' and y'."""
    c = {name: k.get(name, 0.0) for name in COEFFICIENTS}
    r2 = x * x + y * y
    over = 1 + r2 * (c["k1"] + r2 * (c["k2"] + r2 * c["k3"]))
    q = over / (1 + r2 * (c["k4"] + r2 * (c["k5"] + r2 * c["k6"])))
    a = x * q + 2 * c["p1"] * x * y + c["p2"] * (r2 + 2 * x * x) + c["s1"] * r2 + c["s2"] * r2**2
    b = y * q + c["p1"] * (r2 + 2 * y * y) + 2 * c["p2"] * x * y + c["s3"] * r2 + c["s4"] * r2**2
    if not (c["tau_x"] or c["tau_y"]):
        return a, b
    # The page's matrices, in the precision of what is mapped.
    tau = np.asarray([c["tau_x"], c["tau_y"]], a.real.dtype)
    (cx, cy), (sx, sy) = np.cos(tau), np.sin(tau)
    r = np.array([[cy, 0 * cx, -sy], [0 * cx, 1 + 0 * cx, 0 * cx], [sy, 0 * cx, cy]]) @ np.array(
        [[1 + 0 * cx, 0 * cx, 0 * cx], [0 * cx, cx, sx], [0 * cx, -sx, cx]]
    )
    back = np.array([[r[2, 2], 0, -r[0, 2]], [0, r[2, 2], -r[1, 2]], [0, 0, 1]]) @ r
    u, v, w = (row[0] * a + row[1] * b + row[2] for row in back)
    return u / w, v / w


def distort_fisheye(x: Array, y: Array, k: Parameters) -> tuple[Array, Array]:
    """COLMAP's du and dv, added to u and v: four powers of the radius, and a prism of the first."""
    k1, k2, p1, p2, k3, k4, sx1, sy1 = (
        k.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "s1", "s2")
    )
    r2 = x * x + y * y
    # By products here and below: powers of complex numbers are calls of a function.
    radial = r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)))
    return (
        x + x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + sx1 * r2,
        y + y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y) + sy1 * r2,
    )


def distort_twice(x: Array, y: Array, k: Parameters) -> tuple[Array, Array]:
    """COLMAP's and Project Aria's: six powers of the angle, and of that place what is not round."""
    t2 = x * x + y * y
    k0, k1, k2, k3, k4, k5 = (k.get(f"k{n}", 0.0) for n in range(6))
    q = 1 + t2 * (k0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * (k4 + t2 * k5)))))
    x, y = x * q, y * q
    r2 = x * x + y * y
    p0, p1, s0, s1, s2, s3 = (k.get(name, 0.0) for name in ("p0", "p1", "s0", "s1", "s2", "s3"))
    return (
        x + 2 * p1 * x * y + p0 * (r2 + 2 * x * x) + s0 * r2 + s1 * r2**2,
        y + 2 * p0 * x * y + p1 * (r2 + 2 * y * y) + s2 * r2 + s3 * r2**2,
    )


DISTORTED: dict[str, Distortion] = {
    "camera_brown_conrady": distort,
    "camera_unified": distort,
    "camera_thin_prism_fisheye": distort_fisheye,
    "camera_rad_tan_thin_prism_fisheye": distort_twice,
}


def distortion_slopes(
    x: Array, y: Array, k: Parameters, bend: Distortion
) -> tuple[Array, Array, Array, Array]:
    """∂x''/∂x', ∂x''/∂y', ∂y''/∂x', ∂y''/∂y', by steps into the imaginary, which lose nothing."""
    h = np.asarray(1e-30, x.dtype)
    step = np.asarray(1j, np.result_type(x, np.complex64)) * h
    (xx, yx), (xy, yy) = bend(x + step, y, k), bend(x, y + step, k)
    return xx.imag / h, xy.imag / h, yx.imag / h, yy.imag / h


def undistort(a: Array, b: Array, k: Parameters, bend: Distortion) -> tuple[Array, Array]:
    """Newton's method: a step at each of eight places on the way from the axis, more at its end.

    All of the way is float64's, whose complex functions are a lot quicker than long double's. From
    where it ends, each step by the last slopes is off by 1e-10 times the error before it.
    """
    near_a, near_b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    x, y = np.zeros_like(near_a), np.zeros_like(near_b)
    for n in range(1, 20):
        part = min(n / 8, 1)
        u, v = bend(x, y, k)
        slopes = distortion_slopes(x, y, k, bend)
        dx, dy = _step(slopes, near_a * part - u, near_b * part - v)
        x, y = x + dx, y + dy
        # A step of this length leaves an error of its square.
        if part == 1 and not (np.abs(dx) + np.abs(dy) > 1e-10).any():
            break
    if a.dtype == np.float64:
        return x, y
    x, y = x.astype(a.dtype), y.astype(a.dtype)
    for _ in range(4):
        u, v = bend(x, y, k)
        dx, dy = _step(slopes, a - u, b - v)
        x, y = x + dx, y + dy
    return x, y


def _step(slopes: tuple[Array, Array, Array, Array], da: Array, db: Array) -> tuple[Array, Array]:
    xx, xy, yx, yy = slopes
    det = xx * yy - xy * yx
    return (yy * da - xy * db) / det, (xx * db - yx * da) / det


def _camera(name: str) -> World:
    radial = RADIAL[name]
    bend = DISTORTED.get(name, distort)

    def bent(k: Parameters) -> bool:
        return name in DISTORTED and any(k.get(c, 0.0) for c in COEFFICIENTS)

    def encode(x: Array, y: Array, z: Array, k: Parameters) -> Any:
        fx, fy, cx, cy = sensor(k)
        c, s, h = azimuth(x, y)
        theta = np.arctan2(h, z)
        if name == "camera_pinhole":
            r, seen = h / z, z > 0
        else:
            r, seen = radial.radius(theta, k), theta <= radial.end(k)
        a, b = r * c, r * s
        if bent(k):
            # Whole images alone: what the lens bends back lies beyond this angle, and outside.
            seen = seen & (r <= _reach(k))
            a, b = bend(a, b, k)
        return *within(a * fx + cx, b * fy + cy, seen), np.zeros_like(x)

    def _reach(k: Parameters) -> float:
        """The undistorted radius of the farthest place of the image's border."""
        t = np.linspace(-1, 1, 401)
        one = np.ones_like(t)
        p, q = np.concatenate([t, t, one, -one]), np.concatenate([one, -one, t, t])
        fx, fy, cx, cy = sensor(k)
        x, y = undistort((p - cx) / fx, (q - cy) / fy, k, bend)
        return float(np.hypot(x, y).max()) * (1 + 1e-12)

    def place(p: Array, q: Array, k: Parameters) -> tuple[Array, Array, Array, Array]:
        """Cosine and sine of the azimuth, the undistorted radius, and its angle."""
        fx, fy, cx, cy = sensor(k)
        a, b = (p - cx) / fx, (q - cy) / fy
        if bent(k):
            a, b = undistort(a, b, k, bend)
        c, s, r = azimuth(a, b)
        if name in ("camera_pinhole", "camera_brown_conrady"):
            return c, s, r, np.arctan(r)
        return c, s, r, radial.theta(r, k)

    def decode(p: Array, q: Array, _f: Array, k: Parameters) -> Array:
        bad = np.isnan(p) | np.isnan(q)
        c, s, _r, theta = place(np.where(bad, 0, p), np.where(bad, 0, q), k)
        d = np.stack([c * np.sin(theta), s * np.sin(theta), np.cos(theta)], -1)
        return np.where(bad[..., None], np.nan, d)

    def density(p: Array, q: Array, k: Parameters) -> Array:
        bad = np.isnan(p) | np.isnan(q)
        fx, fy, _, _ = sensor(k)
        c, s, r, theta = place(np.where(bad, 0, p), np.where(bad, 0, q), k)
        slope = radial.slope(theta, k)
        if name in ("camera_pinhole", "camera_brown_conrady"):
            slope = 1 + r * r
        # On the axis sin θ and r are one.
        near = r < 1e-9
        ratio = np.where(near, 1 / slope, np.sin(theta) / np.where(near, 1, r))
        out = ratio / slope / (fx * fy)
        if bent(k):
            xx, xy, yx, yy = distortion_slopes(r * c, r * s, k, bend)
            out = out / (xx * yy - xy * yx)
        return np.where(bad, np.nan, out)

    def covered(k: Parameters) -> float:
        return integral(tuple(sorted(k.items())))

    @cache
    def integral(parameters: tuple[tuple[str, float], ...]) -> float:
        """Gauss's rule over eight parts of the image each way."""
        k = dict(parameters)
        x, w = gauss(12)
        parts = 8
        edges = np.linspace(-1, 1, parts + 1)
        half = 1 / parts
        at = ((edges[:-1, None] + edges[1:, None]) / 2 + half * x).ravel().astype(np.longdouble)
        weight = np.tile(w, parts) * half
        p, q = np.meshgrid(at, at)
        return float(weight @ density(p, q, k) @ weight)

    return World(encode, decode, density, "+x -y -z", covered, lambda k: k.get("aspect", 1.0))


CAMERAS: dict[str, World] = {name: _camera(name) for name in RADIAL}
