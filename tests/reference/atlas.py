"""The NumPy reference of world maps and lens models, written from their sources as in reference.py.

Everything is in the view frame, with p = 2u - 1 and q = 2v - 1, in the precision of the input.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

Array = np.ndarray
Parameters = dict[str, float]


def pi(dtype: Any) -> Any:
    return np.arctan(np.ones((), dtype)) * 4


def radians(degrees: float, dtype: Any) -> Any:
    return np.asarray(degrees, dtype) * pi(dtype) / 180


def eps(x: Array) -> float:
    return float(np.finfo(x.dtype).eps)


def within(p: Array, q: Array, ok: Any = True) -> tuple[Array, Array]:
    """Points of the square, let out by eight rounding units; NaN elsewhere."""
    # 1 + 8 ε would be 1 in the float64 that ε is.
    ok = ok & (np.abs(p) - 1 <= 8 * eps(p)) & (np.abs(q) - 1 <= 8 * eps(p))
    return np.where(ok, np.clip(p, -1, 1), np.nan), np.where(ok, np.clip(q, -1, 1), np.nan)


def azimuth(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Cosine and sine of the azimuth and the radius; (1, 0, 0) where x = y = 0."""
    m = np.maximum(np.abs(x), np.abs(y))
    zero = m == 0
    _, e = np.frexp(np.where(zero | np.isnan(m), 1, m))
    xs, ys = np.ldexp(x, -e), np.ldexp(y, -e)
    h = np.sqrt(xs * xs + ys * ys)
    safe = np.where(zero, 1, h)
    return np.where(zero, 1, xs / safe), np.where(zero, 0, ys / safe), np.ldexp(h, e)


def in_disk(p: Array, q: Array) -> Array:
    with np.errstate(invalid="ignore"):
        return p * p + q * q - 1 <= 8 * eps(p)


def longitude(x: Array, z: Array) -> Array:
    """In half turns; the seam itself is -1, both poles are 0."""
    out = np.where((x == 0) & (z == 0), 0, np.arctan2(x, z) / pi(x.dtype))
    return np.where((x == 0) & (z < 0), -1, out)


@cache
def gauss(order: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule from -1 to 1: eigenvalues, found once."""
    return np.polynomial.legendre.leggauss(order)


def inverse(f: Callable[[Array], Array], y: Array, end: Any) -> Array:
    """Solve f(x) = y for x from 0 to `end`, where f rises from 0, in the precision of y.

    Bisection brings x near in float64, whose functions are a lot quicker than long double's.
    Each step along the chord of what is left is off by that width times the error before it.
    """
    near = y.astype(np.float64)
    low, high = np.zeros_like(near), np.full_like(near, end)
    for _ in range(26):
        middle = (low + high) / 2
        less = f(middle) < near
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    # Beside a middle the rounding of float64 chooses the side: x may be a little outside.
    room = high - low
    low = np.maximum(low - room, 0).astype(y.dtype)
    high = np.minimum(high + room, np.asarray(end, y.dtype))
    slope = (f(high) - f(low)) / (high - low)
    x = (low + high) / 2
    for _ in range(4):
        x = np.clip(x - (f(x) - y) / slope, low, high)
    return x


@dataclass(frozen=True)
class World:
    """A map of the square, or of an outline inside it."""

    encode: Callable[..., tuple[Array, Array, Array]]
    decode: Callable[..., Array]
    density: Callable[..., Array]
    axes: str
    covered: Callable[[Parameters], float]
    aspect: Callable[[Parameters], float]


# --- Mercator: x = λ, y = asinh tan φ ---------------------------------------------------------

SQUARE = 85.05112877980659


def _mercator_edge(parameters: Parameters, dtype: Any) -> Any:
    latitude = parameters.get("latitude", SQUARE)
    return pi(dtype) if latitude == SQUARE else np.arcsinh(np.tan(radians(latitude, dtype)))


def _encode_mercator(x: Array, y: Array, z: Array, parameters: Parameters) -> Any:
    _c, _s, h = azimuth(x, z)
    q = np.arcsinh(y / h) / _mercator_edge(parameters, x.dtype)
    return *within(longitude(x, z), q), np.zeros_like(x)


def _decode_mercator(p: Array, q: Array, _f: Array, parameters: Parameters) -> Array:
    y = q * _mercator_edge(parameters, p.dtype)
    angle = p * pi(p.dtype)
    return np.stack([np.sin(angle) / np.cosh(y), np.tanh(y), np.cos(angle) / np.cosh(y)], -1)


def _density_mercator(p: Array, q: Array, parameters: Parameters) -> Array:
    edge = _mercator_edge(parameters, p.dtype)
    return pi(p.dtype) * edge / np.cosh(q * edge) ** 2 + 0 * p


# --- Mollweide: Newton in longdouble on the equation as printed, from the pole's own variable -----


def _lag(psi: Array) -> Array:
    """ψ - sin ψ, by its series where the difference would cancel."""
    s = psi * psi
    series = np.zeros_like(psi)
    for n in range(27, 3, -2):
        series = (1 - series) * s / (n * (n - 1))
    return np.where(psi < 2, psi * s / 6 * (1 - series), psi - np.sin(psi))


def _encode_mollweide(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    _c, _s, h = azimuth(x, z)
    side = pi(x.dtype) * h * h / (1 + np.abs(y))
    near = side.astype(np.float64)
    low, high = np.zeros_like(near), np.full_like(near, math.pi)
    # Bisection brings ψ near, in float64 for its speed; Newton takes it the rest of the way.
    psi = np.cbrt(6 * side)
    for _ in range(40):
        middle = (low + high) / 2
        less = _lag(middle) < near
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    psi = np.where(psi > 0.01, (low + high) / 2, psi)
    for _ in range(6):
        slope = 2 * np.sin(psi / 2) ** 2
        psi = psi - np.where(slope > 0, (_lag(psi) - side) / np.where(slope > 0, slope, 1), 0)
    p = longitude(x, z) * np.sin(psi / 2)
    return p, np.cos(psi / 2) * np.where(y < 0, -1, 1), np.zeros_like(x)


def _decode_mollweide(p: Array, q: Array, _f: Array, _: Parameters) -> Array:
    a = np.minimum(np.abs(q), 1)
    s = np.sqrt((1 - a) * (1 + a))
    missing = _lag(2 * np.arctan2(s, a)) / pi(p.dtype)
    cos = np.sqrt(missing * (2 - missing))
    angle = pi(p.dtype) * np.where(s > 0, p / np.where(s > 0, s, 1), 0)
    d = np.stack([cos * np.sin(angle), (1 - missing) * np.sign(q), cos * np.cos(angle)], -1)
    return np.where(in_disk(p, q)[..., None], d, np.nan)


def _four(p: Array, _q: Array, _: Parameters) -> Array:
    return np.full_like(p, 4.0)


# --- Hammer: Snyder's printed form, with half the longitude from the arctangent ------------------


def _encode_hammer(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    _c, _s, h = azimuth(x, z)
    half = longitude(x, z) * pi(x.dtype) / 2
    root = np.sqrt(1 + h * np.cos(half))
    return h * np.sin(half) / root, y / root, np.zeros_like(x)


def _decode_hammer(p: Array, q: Array, _f: Array, _: Parameters) -> Array:
    s = p * p + q * q
    n = np.sqrt(np.maximum(2 - s, 0))
    angle = 2 * np.arctan2(p * n, 1 - s)
    y = q * n
    _c, _s, h = azimuth(p * n, 1 - s)
    d = np.stack([h * np.sin(angle), y, h * np.cos(angle)], -1)
    return np.where(in_disk(p, q)[..., None], d, np.nan)


# --- Sinusoidal ---------------------------------------------------------------------------------


def _encode_sinusoidal(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    _c, _s, h = azimuth(x, z)
    return longitude(x, z) * h, 2 * np.arctan2(h, -y) / pi(x.dtype) - 1, np.zeros_like(x)


def _decode_sinusoidal(p: Array, q: Array, _f: Array, _: Parameters) -> Array:
    theta = (q + 1) / 2 * pi(p.dtype)
    # From the nearer pole, so that both keep their digits.
    near = np.sin((1 - np.abs(q)) / 2 * pi(p.dtype))
    angle = pi(p.dtype) * np.where(near > 0, p / np.where(near > 0, near, 1), 0)
    d = np.stack([near * np.sin(angle), -np.cos(theta), near * np.cos(angle)], -1)
    with np.errstate(invalid="ignore"):
        ok = np.abs(p) <= near + 8 * eps(p)
    return np.where(ok[..., None], d, np.nan)


def _density_sinusoidal(p: Array, _q: Array, _: Parameters) -> Array:
    return np.full_like(p, math.pi**2 / 2)


# --- Miller -------------------------------------------------------------------------------------


def _miller_edge(dtype: Any) -> Any:
    return 1.25 * np.arcsinh(np.tan(pi(dtype) * 2 / 5))


def _encode_miller(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    _c, _s, h = azimuth(x, z)
    tall = 1.25 * np.arcsinh(np.tan(0.8 * np.arctan2(y, h)))
    return longitude(x, z), np.clip(tall / _miller_edge(x.dtype), -1, 1), np.zeros_like(x)


def _miller_latitude(q: Array) -> Array:
    return 1.25 * np.arctan(np.sinh(q * _miller_edge(q.dtype) * 4 / 5))


def _decode_miller(p: Array, q: Array, _f: Array, _: Parameters) -> Array:
    angle, latitude = p * pi(p.dtype), _miller_latitude(q)
    cos = np.cos(latitude)
    return np.stack([cos * np.sin(angle), np.sin(latitude), cos * np.cos(angle)], -1)


def _density_miller(p: Array, q: Array, _: Parameters) -> Array:
    latitude = _miller_latitude(q)
    edge = _miller_edge(q.dtype)
    return pi(q.dtype) * edge * np.maximum(np.cos(latitude), 0) * np.cos(0.8 * latitude) + 0 * p


# --- The upper half of a latlong ------------------------------------------------------------------


def _encode_hemi_latlong(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    _c, _s, h = azimuth(x, z)
    q = 4 * np.arctan2(h, -y) / pi(x.dtype) - 1
    return longitude(x, z), np.where(y > 0, np.nan, np.clip(q, -1, 1)), np.zeros_like(x)


def _decode_hemi_latlong(p: Array, q: Array, _f: Array, _: Parameters) -> Array:
    theta, angle = (q + 1) / 4 * pi(p.dtype), p * pi(p.dtype)
    sin = np.sin(theta)
    return np.stack([sin * np.sin(angle), -np.cos(theta), sin * np.cos(angle)], -1)


def _density_hemi_latlong(p: Array, q: Array, _: Parameters) -> Array:
    return pi(p.dtype) ** 2 / 4 * np.sin((q + 1) / 4 * pi(p.dtype)) + 0 * p


# --- Pannini: equations of the paper; the inverse by bisection ---------------------------------


def _pannini(k: Parameters, dtype: Any) -> tuple[Any, Any, Any, Any, Any]:
    d, s = (np.asarray(k.get(name, v), dtype) for name, v in (("d", 1.0), ("s", 0.0)))
    half = radians(k.get("fov", 150.0), dtype) / 2
    width = (d + 1) / (d + np.cos(half)) * np.sin(half)
    return d, s, half, width, width / k.get("aspect", 2.0)


def _pannini_tall(d: Any, s: Any, longitude: Array) -> Array:
    scale = (d + 1) / (d + np.cos(longitude))
    return scale if s == 0 else (1 - s) * scale + s / np.cos(longitude)


def _encode_pannini(x: Array, y: Array, z: Array, k: Parameters) -> Any:
    d, s, half, width, height = _pannini(k, x.dtype)
    _c, _s, h = azimuth(x, z)
    angle = np.arctan2(x, z)
    p = (d + 1) / (d + np.cos(angle)) * np.sin(angle) / width
    q = _pannini_tall(d, s, angle) * y / h / height
    return *within(p, q, np.abs(angle) < half + 0.02), np.zeros_like(x)


def _pannini_longitude(p: Array, k: Parameters) -> Array:
    d, _, half, width, _ = _pannini(k, p.dtype)

    def across(angle: Array) -> Array:
        return (d.astype(angle.dtype) + 1) / (d + np.cos(angle)) * np.sin(angle)

    return inverse(across, np.abs(p) * width, half) * np.sign(p)


def _decode_pannini(p: Array, q: Array, _f: Array, k: Parameters) -> Array:
    d, s, _, _, height = _pannini(k, p.dtype)
    angle = _pannini_longitude(p, k)
    tan = q * height / _pannini_tall(d, s, angle)
    d_ = np.stack([np.sin(angle), tan, np.cos(angle)], -1)
    return np.where(np.isnan(p)[..., None], np.nan, d_)


def _density_pannini(p: Array, q: Array, k: Parameters) -> Array:
    d, s, _, width, height = _pannini(k, p.dtype)
    angle = _pannini_longitude(p, k)
    tall = _pannini_tall(d, s, angle)
    slope = (d + 1) * (1 + d * np.cos(angle)) / (d + np.cos(angle)) ** 2
    return width * height / (slope * tall * (1 + (q * height / tall) ** 2) ** 1.5)


def _pannini_covered(k: Parameters) -> float:
    """∫ 2 sin φ(λ) dλ over the columns."""
    d, s, half, _, height = _pannini(k, np.float64)
    x, w = gauss(200)
    angle = half * x
    tan = height / _pannini_tall(d, s, angle)
    return float(np.sum(w * half * 2 * tan / np.sqrt(1 + tan * tan)))


# --- Tetrahedral: the four planes, one after the other --------------------------------------------


def _encode_tetrahedral(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    planes = np.stack([x - y + z, -x + y + z, x + y - z, -x - y - z])
    m = planes.max(0)
    left = planes[:2].max(0) >= planes[2:].max(0)
    u = np.where(left, (x / m + 1) / 4, (3 - x / m) / 4)
    return 2 * u - 1, y / m, np.zeros_like(x)


def _tetrahedron(p: Array, q: Array) -> Array:
    u, v = (p + 1) / 2, (q + 1) / 2
    x = np.where(u < 0.5, 4 * u - 1, 3 - 4 * u)
    left = np.where(v < 2 * u, 1 - x + q, 1 + x - q)
    right = np.where(x + q > 0, x + q - 1, -1 - x - q)
    return np.stack([x, q, np.where(u < 0.5, left, right)], -1)


def _decode_tetrahedral(p: Array, q: Array, _f: Array, _: Parameters) -> Array:
    return _tetrahedron(p, q)


def _density_tetrahedral(p: Array, q: Array, _: Parameters) -> Array:
    return 2 * np.sum(_tetrahedron(p, q) ** 2, -1) ** -1.5


# --- Icosahedral: every one of the ten diamonds is tried ------------------------------------------


def _diamonds(dtype: Any) -> list[tuple[Array, Array, Array, Array]]:
    """Corners at (0, 0), (1, 0), (1, 1) and (0, 1) of each face, in the view frame."""
    one = np.ones((), dtype)
    north, south = np.array([0, -one, 0]), np.array([0, one, 0])

    def ring(turns: float, up: float) -> Array:
        a = 2 * pi(dtype) * turns / 5
        zero = 0 * one
        tall, wide = up / np.sqrt(5 * one), 2 / np.sqrt(5 * one)
        return np.array([wide * np.sin(a), zero - tall, wide * np.cos(a)])

    out = [(north, ring(k + 1, 1), ring(k + 0.5, -1), ring(k, 1)) for k in range(5)]
    out += [(ring(k + 1, 1), ring(k + 1.5, -1), south, ring(k + 0.5, -1)) for k in range(5)]
    return out


def encode_icosahedral(x: Array, y: Array, z: Array, _: Parameters) -> Any:
    d = np.stack([x, y, z], -1)
    best = np.full(x.shape, -np.inf)
    u, v, f = np.full_like(x, np.nan), np.full_like(x, np.nan), np.full_like(x, np.nan)
    for face, (a, b, c, e) in enumerate(_diamonds(x.dtype)):
        for tip, second in ((a, False), (c, True)):
            # Cramer's rule for d = t tip + r b + l e.
            n = np.cross(b, e) @ tip
            t, r, m = d @ np.cross(b, e) / n, d @ np.cross(e, tip) / n, d @ np.cross(tip, b) / n
            inside = np.minimum(np.minimum(t, r), m)
            here = inside > best + 64 * eps(x)
            best = np.where(here, inside, best)
            total = t + r + m
            right, left = np.clip(r / total, 0, 1), np.clip(m / total, 0, 1)
            u = np.where(here, 1 - left if second else right, u)
            v = np.where(here, 1 - right if second else left, v)
            f = np.where(here, float(face), f)
    return 2 * u - 1, 2 * v - 1, f


def decode_icosahedral(p: Array, q: Array, f: Array, _: Parameters) -> Array:
    u, v = ((p + 1) / 2)[..., None], ((q + 1) / 2)[..., None]
    out = np.full((*p.shape, 3), np.nan, p.dtype)
    for face, (a, b, c, e) in enumerate(_diamonds(p.dtype)):
        first = (1 - u - v) * a + u * b + v * e
        second = (u + v - 1) * c + (1 - u) * e + (1 - v) * b
        d = np.where(u + v <= 1, first, second)
        out = np.where((f == face)[..., None], d, out)
    return out


def density_icosahedral(p: Array, q: Array, k: Parameters) -> Array:
    a, b, _, e = _diamonds(p.dtype)[0]
    d = decode_icosahedral(p, q, np.zeros_like(p), k)
    return np.cross(b, e) @ a / 4 * np.sum(d * d, -1) ** -1.5


def _whole(_: Parameters) -> float:
    return 4 * math.pi


WORLDS: dict[str, World] = {
    "mercator": World(
        _encode_mercator,
        _decode_mercator,
        _density_mercator,
        "+x -y -z",
        lambda k: 4 * math.pi * math.sin(math.radians(k.get("latitude", SQUARE))),
        lambda k: math.pi / float(_mercator_edge(k, np.float64)),
    ),
    "mollweide": World(
        _encode_mollweide, _decode_mollweide, _four, "+x -y -z", _whole, lambda _: 2.0
    ),
    "hammer": World(_encode_hammer, _decode_hammer, _four, "+x -y -z", _whole, lambda _: 2.0),
    "sinusoidal": World(
        _encode_sinusoidal,
        _decode_sinusoidal,
        _density_sinusoidal,
        "+x -y -z",
        _whole,
        lambda _: 2.0,
    ),
    "miller": World(
        _encode_miller,
        _decode_miller,
        _density_miller,
        "+x -y -z",
        _whole,
        lambda _: math.pi / float(_miller_edge(np.float64)),
    ),
    "hemi_latlong": World(
        _encode_hemi_latlong,
        _decode_hemi_latlong,
        _density_hemi_latlong,
        "+x -y -z",
        lambda _: 2 * math.pi,
        lambda _: 4.0,
    ),
    "tetrahedral": World(
        _encode_tetrahedral,
        _decode_tetrahedral,
        _density_tetrahedral,
        "+x -y -z",
        _whole,
        lambda _: 4 / math.sqrt(3),
    ),
    "pannini": World(
        _encode_pannini,
        _decode_pannini,
        _density_pannini,
        "+x -y -z",
        _pannini_covered,
        lambda k: k.get("aspect", 2.0),
    ),
}


# --- Lenses: the image radius is a function of the angle from the axis --------------------------


@dataclass(frozen=True)
class Lens:
    """The radius of an angle, its derivative, and the default field of view."""

    radius: Callable[[Array, Parameters], Array]
    slope: Callable[[Array, Parameters], Array]
    fov: float = 180.0

    def rim(self, parameters: Parameters, dtype: Any) -> Any:
        return radians(parameters.get("fov", self.fov), dtype) / 2

    def scaled(self, theta: Array, parameters: Parameters) -> Array:
        rim = self.rim(parameters, theta.dtype)
        return self.radius(theta, parameters) / self.radius(rim, parameters)

    def theta(self, r: Array, parameters: Parameters) -> Array:
        rim = self.rim(parameters, r.dtype)
        reached = np.where(np.isnan(r), 0, r) * self.radius(rim, parameters)
        return inverse(lambda theta: self.radius(theta, parameters), reached, rim)

    def encode(self, x: Array, y: Array, z: Array, parameters: Parameters) -> Any:
        c, s, h = azimuth(x, y)
        theta = np.arctan2(h, z)
        rim = self.rim(parameters, x.dtype)
        bad = theta - rim > rim * (8 * eps(x))
        r = np.where(bad, np.nan, np.minimum(self.scaled(theta, parameters), 1))
        return r * c, r * s, np.zeros_like(x)

    def decode(self, p: Array, q: Array, _f: Array, parameters: Parameters) -> Array:
        c, s, r = azimuth(p, q)
        theta = self.theta(np.minimum(r, 1), parameters)
        d = np.stack([c * np.sin(theta), s * np.sin(theta), np.cos(theta)], -1)
        return np.where(in_disk(p, q)[..., None], d, np.nan)

    def density(self, p: Array, q: Array, parameters: Parameters) -> Array:
        """sin θ dθ/(r dr), by its limit at the axis."""
        r = np.sqrt(p * p + q * q)
        theta = self.theta(np.minimum(r, 1), parameters)
        scale = self.radius(self.rim(parameters, r.dtype), parameters)
        slope = self.slope(theta, parameters) / scale
        # sin θ/r is 0/0 at the axis, and less than 1e-17 from its limit there.
        near = r < 1e-9
        return np.where(near, 1 / slope, np.sin(theta) / np.where(near, 1, r)) / slope

    def cap(self, r: Array, parameters: Parameters) -> Array:
        return 2 * np.sin(self.theta(np.asarray(r, float), parameters) / 2) ** 2

    def stretch(self, parameters: Parameters) -> float:
        """Radians that a direction moves for a change of u, where that is most."""
        theta = np.linspace(0, float(self.rim(parameters, float)), 2001)
        scale = self.radius(theta[-1], parameters)
        return float(np.max(2 * scale / self.slope(theta, parameters)))


def polynomial(theta: Array, k: Parameters) -> Array:
    w = theta * theta
    a, b, c, d = (k.get(name, 0.0) for name in ("k1", "k2", "k3", "k4"))
    # By products: powers of long doubles are calls of a function.
    return theta * (1 + w * (a + w * (b + w * (c + w * d))))


def _polynomial_slope(theta: Array, k: Parameters) -> Array:
    w = theta * theta
    a, b, c, d = (k.get(name, 0.0) for name in ("k1", "k2", "k3", "k4"))
    return 1 + w * (3 * a + w * (5 * b + w * (7 * c + w * 9 * d)))


def _unified(theta: Array, k: Parameters) -> Array:
    return np.sin(theta) / (np.cos(theta) + k.get("xi", 0.9))


def _unified_slope(theta: Array, k: Parameters) -> Array:
    xi = k.get("xi", 0.9)
    return (1 + xi * np.cos(theta)) / (np.cos(theta) + xi) ** 2


def _double(theta: Array, k: Parameters) -> Array:
    """Equations 40 to 42 of the paper, for a direction of length one."""
    xi, alpha = k.get("xi", -0.2), k.get("alpha", 0.6)
    x, z = np.sin(theta), np.cos(theta)
    d1 = np.sqrt(x * x + z * z)
    d2 = np.sqrt(x * x + (xi * d1 + z) ** 2)
    return x / (alpha * d2 + (1 - alpha) * (xi * d1 + z))


def _double_slope(theta: Array, k: Parameters) -> Array:
    xi, alpha = k.get("xi", -0.2), k.get("alpha", 0.6)
    x, z = np.sin(theta), np.cos(theta)
    d2 = np.sqrt(x * x + (xi + z) ** 2)
    n = alpha * d2 + (1 - alpha) * (xi + z)
    return (z * n + x * (alpha * xi * x / d2 + (1 - alpha) * x)) / (n * n)


LENSES: dict[str, Lens] = {
    "kannala_brandt": Lens(polynomial, _polynomial_slope),
    "unified": Lens(_unified, _unified_slope),
    "double_sphere": Lens(_double, _double_slope),
}


# --- Two equidistant fisheyes -------------------------------------------------------------------


def encode_dual_fisheye(x: Array, y: Array, z: Array, k: Parameters) -> Any:
    c, s, h = azimuth(x, y)
    rim = radians(k.get("fov", 180.0), x.dtype) / 2
    r = np.arctan2(h, np.abs(z)) / rim
    r = np.where(r - 1 > 8 * eps(x), np.nan, np.minimum(r, 1))
    return r * c * np.where(z < 0, -1, 1), r * s, np.where(z < 0, 1.0, 0.0)


def decode_dual_fisheye(p: Array, q: Array, f: Array, k: Parameters) -> Array:
    c, s, r = azimuth(p, q)
    theta = np.minimum(r, 1) * radians(k.get("fov", 180.0), p.dtype) / 2
    way = np.where(f == 0, 1, -1)
    d = np.stack([way * c * np.sin(theta), s * np.sin(theta), way * np.cos(theta)], -1)
    return np.where(in_disk(p, q)[..., None], d, np.nan)


def density_dual_fisheye(p: Array, q: Array, k: Parameters) -> Array:
    rim = radians(k.get("fov", 180.0), p.dtype) / 2
    return rim * rim * np.sinc(rim * np.sqrt(p * p + q * q) / pi(p.dtype))


def cap_dual_fisheye(r: Array, k: Parameters) -> Array:
    """Only the own hemisphere counts."""
    theta = np.minimum(r * math.radians(k.get("fov", 180.0)) / 2, math.pi / 2)
    return 2 * np.sin(theta / 2) ** 2
