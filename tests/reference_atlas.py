"""The NumPy reference of world maps and lens models, written from their sources as in reference.py.

Everything is in the view frame, with p = 2u - 1 and q = 2v - 1, in the precision of the input.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
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
    low, high = np.zeros_like(p), np.full_like(p, half)
    for _ in range(70):
        middle = (low + high) / 2
        less = (d + 1) / (d + np.cos(middle)) * np.sin(middle) < np.abs(p) * width
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return (low + high) / 2 * np.sign(p)


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
    x, w = np.polynomial.legendre.leggauss(200)
    angle = half * x
    tan = height / _pannini_tall(d, s, angle)
    return float(np.sum(w * half * 2 * tan / np.sqrt(1 + tan * tan)))


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
        """Bisection: no closed form, and no Newton either, so that nothing is shared."""
        rim = self.rim(parameters, r.dtype)
        low, high = np.zeros_like(r), np.full_like(r, rim)
        r = np.where(np.isnan(r), 0, r)
        for _ in range(70 if r.dtype == np.longdouble else 58):
            middle = (low + high) / 2
            less = self.scaled(middle, parameters) < r
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        # Near the axis, where bisection is only good to rounding of the rim, one step of secants.
        theta = (low + high) / 2
        scale = self.radius(rim, parameters)
        off = self.radius(theta, parameters) - r * scale
        return np.clip(theta - off / self.slope(theta, parameters), 0, rim)

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
        near = r < 1e-9
        return np.where(near, 1 / slope, np.sin(theta) / np.where(near, 1, r)) / slope

    def cap(self, r: Array, parameters: Parameters) -> Array:
        return 2 * np.sin(self.theta(np.asarray(r, float), parameters) / 2) ** 2

    def stretch(self, parameters: Parameters) -> float:
        """Radians that a direction moves for a change of u, where that is most."""
        theta = np.linspace(0, float(self.rim(parameters, float)), 2001)
        scale = self.radius(theta[-1], parameters)
        return float(np.max(2 * scale / self.slope(theta, parameters)))


def _polynomial(theta: Array, k: Parameters) -> Array:
    w = theta * theta
    a, b, c, d = (k.get(name, 0.0) for name in ("k1", "k2", "k3", "k4"))
    return theta * (1 + a * w + b * w**2 + c * w**3 + d * w**4)


def _polynomial_slope(theta: Array, k: Parameters) -> Array:
    w = theta * theta
    a, b, c, d = (k.get(name, 0.0) for name in ("k1", "k2", "k3", "k4"))
    return 1 + 3 * a * w + 5 * b * w**2 + 7 * c * w**3 + 9 * d * w**4


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
    "kannala_brandt": Lens(_polynomial, _polynomial_slope),
    "unified": Lens(_unified, _unified_slope),
    "double_sphere": Lens(_double, _double_slope),
}
