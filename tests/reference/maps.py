"""An independent NumPy reference of every projection.

Nothing here imports the package under test. The formulas are written from their sources, in the
view frame (x right, y down, z forward), with p = 2u - 1 and q = 2v - 1. Every function computes in
the precision of its input, so a caller who passes ``numpy.longdouble`` gets a reference that is
three digits better than float64.

The forms are chosen for accuracy near the singular points: an azimuth is always taken from the
two small components alone, and no 1 - |z| is ever formed by subtraction.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from . import atlas
from .atlas import LENSES, gauss
from .atlas import WORLDS as MAPS
from .cameras import CAMERAS

Array = np.ndarray

WORLDS = {**MAPS, **CAMERAS}
DEFAULT_AXES = {
    "sphere": "+x -y +z",
    "matcap": "+x -y +z",
    "dual_paraboloid": "+x -y +z",
    "cube": "+x -y +z",
    "angular": "+x -y -z",
    "octahedral": "+x +y +z",
    "hemioctahedral": "+x +y +z",
    "latlong": "+x -y -z",
    "perspective": "+x -y -z",
    "cylindrical": "+x -y -z",
    "equisolid": "+x -y -z",
    "stereographic": "+x -y -z",
    "orthographic": "+x -y -z",
    "equal_area": "+x +y +z",
    "concentric": "+x +y +z",
    "lambert_cylindrical": "+x -y -z",
    "cube_equiangular": "+x -y +z",
    "cube_quadratic": "+x -y +z",
    "cube_equal_area": "+x -y +z",
    "healpix": "+x +y +z",
    "dual_fisheye": "+x -y -z",
    "icosahedral": "+x -y -z",
    **dict.fromkeys(LENSES, "+x -y -z"),
    **{name: world.axes for name, world in WORLDS.items()},
}
# The angle that the diameter of a fisheye spans where nothing is said, in degrees.
FISHEYES = {
    "angular": 360.0,
    "equisolid": 180.0,
    "stereographic": 180.0,
    "orthographic": 180.0,
    **{name: lens.fov for name, lens in LENSES.items()},
}
DISKS = frozenset(
    {"sphere", "matcap", "dual_paraboloid", "dual_fisheye", "mollweide", "hammer", *FISHEYES}
)
# Maps whose rim an error ε of a coordinate moves by √ε.
ROOT_RIMS = frozenset({"sphere", "matcap", "orthographic", "lambert_cylindrical"})
CUBES = ("cube", "cube_equiangular", "cube_quadratic", "cube_equal_area")
FACES = {
    **dict.fromkeys(CUBES, 6),
    "dual_paraboloid": 2,
    "dual_fisheye": 2,
    "healpix": 12,
    "icosahedral": 10,
}
HEMISPHERES = frozenset({"matcap", "hemioctahedral", "concentric"})
# Maps whose coverage may have an edge that directions can be moved over.
BORDERED = frozenset(
    {*HEMISPHERES, *FISHEYES, *WORLDS, "dual_fisheye", "perspective", "cylindrical"}
)
# Maps with a row for each pole, where longitude means nothing.
POLES = frozenset({"latlong", "lambert_cylindrical"})
# The lines of a face where a formula or one of its derivatives has a kink.
CREASES: dict[str, frozenset[str]] = {
    "octahedral": frozenset({"axes", "diamond"}),
    "equal_area": frozenset({"axes", "diamond"}),
    "hemioctahedral": frozenset({"diagonals"}),
    "concentric": frozenset({"diagonals", "axes"}),
    "cube_quadratic": frozenset({"axes"}),
    "cube_equal_area": frozenset({"diagonals", "axes"}),
    "healpix": frozenset({"diagonals"}),
    "tetrahedral": frozenset({"band"}),
    "icosahedral": frozenset({"diagonals"}),
}
# Maps whose pieces are gnomonic, and the lines a p + b q + c = 0 between them.
GNOMONIC_PIECES: dict[str, tuple[tuple[float, float, float], ...]] = {
    "tetrahedral": ((1, 0, 0), (2, -1, 1), (2, -1, -1)),
    "icosahedral": ((1, 1, 0),),
}

# The number under which a program stores right, left, up, down, front, back (in the view frame),
# where that is not this order itself.
_FRBLUD = (1, 3, 4, 5, 0, 2)
STORED: dict[tuple[str, str], tuple[int, ...]] = {
    ("cube", "openexr"): (0, 1, 2, 3, 5, 4),
    ("cube", "py360convert-horizon"): _FRBLUD,
    ("cube", "py360convert-list"): _FRBLUD,
    ("cube", "py360convert-dice"): _FRBLUD,
    ("cube", "equilib-horizon"): _FRBLUD,
    ("cube", "equilib-list"): _FRBLUD,
    ("cube", "equilib-dice"): _FRBLUD,
}

# Programs that turn faces by a quarter: test_oracle_atlas has them.
TURNED = frozenset(
    {
        ("cube_equiangular", "ffmpeg-eac"),
        ("cube_equiangular", "s2-tangent"),
        ("cube_quadratic", "s2"),
    }
)

# Layouts that take the faces in the order that they are stored in.
IN_ORDER = frozenset({"strip", "column", "3x2", "4x3", "5x2"})

_PAIR: dict[str, tuple[int, int, list[tuple[int, int, bool]]]] = {
    "strip": (1, 2, [(0, 0, False), (0, 1, False)]),
    "column": (2, 1, [(0, 0, False), (1, 0, False)]),
}
# layout -> (rows, columns, [(row, column, turned by 180°) for each face in face order])
# Cube faces in the view frame: right, left, up, down, front, back.
LAYOUTS: dict[str, dict[str, tuple[int, int, list[tuple[int, int, bool]]]]] = {
    "healpix": {
        "4x3": (3, 4, [(i // 4, i % 4, False) for i in range(12)]),
    },
    "cube": {
        "strip": (1, 6, [(0, i, False) for i in range(6)]),
        "column": (6, 1, [(i, 0, False) for i in range(6)]),
        "3x2": (2, 3, [(i // 3, i % 3, False) for i in range(6)]),
        "cross": (
            3,
            4,
            [
                (1, 2, False),
                (1, 0, False),
                (0, 1, False),
                (2, 1, False),
                (1, 1, False),
                (1, 3, False),
            ],
        ),
        "vertical_cross": (
            4,
            3,
            [
                (1, 2, False),
                (1, 0, False),
                (0, 1, False),
                (2, 1, False),
                (1, 1, False),
                (3, 1, True),
            ],
        ),
        "dice": (
            3,
            4,
            [
                (1, 2, False),
                (1, 0, False),
                (0, 1, False),
                (2, 1, False),
                (1, 1, False),
                (1, 3, False),
            ],
        ),
        "vertical_cross_upright": (
            4,
            3,
            [
                (1, 2, False),
                (1, 0, False),
                (0, 1, False),
                (2, 1, False),
                (1, 1, False),
                (3, 1, False),
            ],
        ),
        "tee": (
            3,
            4,
            [
                (1, 1, False),
                (1, 3, False),
                (0, 0, False),
                (2, 0, False),
                (1, 0, False),
                (1, 2, False),
            ],
        ),
    },
    "dual_paraboloid": _PAIR,
    "dual_fisheye": _PAIR,
    "icosahedral": {"5x2": (2, 5, [(i // 5, i % 5, False) for i in range(10)])},
}
for _name in CUBES[1:]:
    LAYOUTS[_name] = LAYOUTS["cube"]


# Places of a face, in p and q, where a map is like the tip of a cone.
TIPS: dict[str, tuple[tuple[int, int], ...]] = {
    "equal_area": ((0, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)),
    "concentric": ((0, 0),),
    "cube_equal_area": ((0, 0),),
}


def real(a: Any) -> Array:
    """Give a float64 or longdouble array."""
    a = np.asarray(a)
    return a if a.dtype == np.longdouble else a.astype(np.float64)


def axes_matrix(axes: str) -> Array:
    """Signed permutation A with view = A @ world, from a string such as ``"+x -y -z"``."""
    a = np.zeros((3, 3))
    for row, word in enumerate(axes.split()):
        a[row, "xyz".index(word[1])] = -1.0 if word[0] == "-" else 1.0
    return a


def permute(axes: str, d: Array, back: bool) -> Array:
    """World to view (or back), component by component, so that no zero changes its sign twice."""
    out = np.empty_like(d)
    for row, word in enumerate(axes.split()):
        k = "xyz".index(word[1])
        i, j = (row, k) if not back else (k, row)
        out[..., i] = -d[..., j] if word[0] == "-" else d[..., j]
    return out


def unscale(d: Array) -> Array:
    """Bring the largest component into [0.5, 1) by a power of two; NaN for zero, NaN, infinite."""
    with np.errstate(all="ignore"):
        # By components: NumPy is slow at reductions along three numbers.
        x, y, z = np.moveaxis(np.abs(d), -1, 0)
        m = np.maximum(np.maximum(x, y), z)[..., None]  # NaN if any is
        good = np.isfinite(m) & (m > 0)
        _, e = np.frexp(np.where(good, m, 1))
        return np.where(good, np.ldexp(d, -e), np.nan)


def unit(d: Any) -> Array:
    """Unit vectors, for any finite non-zero input."""
    d = unscale(real(d))
    return d / np.sqrt(dot(d, d))[..., None]


def dot(a: Array, b: Array) -> Array:
    """Products of vectors, by components: NumPy is slow at sums along three numbers."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def angle(a: Any, b: Any) -> Array:
    """Angle between directions in longdouble, from atan2(|a × b|, a · b): good at every angle."""
    a = unit(np.asarray(a).astype(np.longdouble))
    b = unit(np.asarray(b).astype(np.longdouble))
    c = np.cross(a, b)
    return np.arctan2(np.sqrt(dot(c, c)), dot(a, b))


def _azimuth(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Cosine and sine of the azimuth and the radius h; (1, 0, 0) where x = y = 0."""
    m = np.maximum(np.abs(x), np.abs(y))
    zero = m == 0
    _, e = np.frexp(np.where(zero | np.isnan(m), 1, m))
    xs, ys = np.ldexp(x, -e), np.ldexp(y, -e)
    h = np.sqrt(xs * xs + ys * ys)
    safe = np.where(zero, 1, h)
    return np.where(zero, 1, xs / safe), np.where(zero, 0, ys / safe), np.ldexp(h, e)


# --- encode, in the view frame: unit vectors -> p, q, face -----------------------------------


def _encode_sphere(x: Array, y: Array, z: Array, _: dict[str, float]) -> tuple[Array, Array, Array]:
    # n = (x, y, z + 1)/|.|. |(x, y, z+1)|² = 2(1 + z), and 1 + z = h²/(1 - z) where z < 0.
    c, s, _h = _azimuth(x, y)
    near = np.sqrt(2 * (1 + np.maximum(z, 0)))
    far = np.sqrt((1 - np.minimum(z, 0)) / 2)
    p = np.where(z >= 0, x / near, c * far)
    q = np.where(z >= 0, y / near, s * far)
    return p, q, np.zeros_like(p)


def _encode_matcap(x: Array, y: Array, z: Array, _: dict[str, float]) -> tuple[Array, Array, Array]:
    bad = z < 0
    return np.where(bad, np.nan, x), np.where(bad, np.nan, y), np.zeros_like(x)


def _encode_dual(x: Array, y: Array, z: Array, _: dict[str, float]) -> tuple[Array, Array, Array]:
    m = 1 + np.abs(z)
    return x / m, y / m, np.where(z >= 0, 0.0, 1.0)


def _encode_cube(x: Array, y: Array, z: Array, _: dict[str, float]) -> tuple[Array, Array, Array]:
    ax, ay, az = np.abs(x), np.abs(y), np.abs(z)
    on_x = (ax >= ay) & (ax >= az)
    on_y = ~on_x & (ay >= az)
    conditions = [on_x & (x > 0), on_x, on_y & (y < 0), on_y, z > 0]
    p = np.select(conditions, [-z, z, x, x, x], -x)
    q = np.select(conditions, [y, y, z, -z, y], y)
    face = np.select(conditions, [0.0, 1.0, 2.0, 3.0, 4.0], 5.0)
    m = np.maximum(ax, np.maximum(ay, az))
    return p / m, q / m, face


def _encode_healpix(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    """Górski et al. 2005: the plane of (longitude, 3/8 π z), its caps drawn to points."""
    length = np.sqrt(x * x + y * y + z * z)
    h = np.hypot(x, y)
    east = 2 * np.arctan2(y, x) / _pi(x.dtype)
    a = np.where(h > 0, np.where(east < 0, east + 4, east), 0)
    a = np.where(a >= 4, 0, a)
    k = np.minimum(np.floor(a), 3)
    # Caps: the sides of the face that meet at the pole are σ times the parts of the quadrant away.
    sigma = h * np.sqrt(3 / (length * (length + np.abs(z))))
    west_side, east_side = (a - k) * sigma, (1 - (a - k)) * sigma
    north = z > 0
    cap_u = np.where(north, 1 - east_side, west_side)
    cap_v = np.where(north, 1 - west_side, east_side)
    # The belt: lines of constant u and of constant v go through its squares.
    falling, rising = a + 0.5 - 0.75 * z / length, a + 0.5 + 0.75 * z / length
    f, r = np.floor(falling), np.floor(rising)
    belt_face = np.where(f == r, 4 + f % 4, np.where(f < r, f, 8 + r))
    cap = 3 * np.abs(z) > 2 * length
    u = np.where(cap, cap_u, rising - r)
    v = np.where(cap, cap_v, 1 - (falling - f))
    return 2 * u - 1, 2 * v - 1, np.where(cap, np.where(north, k, 8 + k), belt_face)


def _encode_angular(
    x: Array, y: Array, z: Array, parameters: dict[str, float]
) -> tuple[Array, Array, Array]:
    fov = _radians(parameters.get("fov", 360.0), x.dtype)
    c, s, h = _azimuth(x, y)
    r = 2 * np.arctan2(h, z) / fov
    bad = r > 1 + 8 * np.finfo(x.dtype).eps
    return np.where(bad, np.nan, r * c), np.where(bad, np.nan, r * s), np.zeros_like(x)


def _l1(x: Array, y: Array, z: Array) -> tuple[Array, Array]:
    m = np.abs(x) + np.abs(y) + np.abs(z)
    return x / m, y / m


def _encode_octahedral(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    p, q = _l1(x, y, z)
    # 1 - |y| written without a subtraction: |x| + |z| over the L1 length.
    m = np.abs(x) + np.abs(y) + np.abs(z)
    fp = (np.abs(x) + np.abs(z)) / m * np.where(x >= 0, 1, -1)
    fq = (np.abs(y) + np.abs(z)) / m * np.where(y >= 0, 1, -1)
    return np.where(z < 0, fp, p), np.where(z < 0, fq, q), np.zeros_like(p)


def _encode_hemioctahedral(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    p, q = _l1(x, y, z)
    bad = z < 0
    return np.where(bad, np.nan, p + q), np.where(bad, np.nan, p - q), np.zeros_like(p)


def _encode_latlong(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    pi = _pi(x.dtype)
    pole = (x == 0) & (z == 0)
    p = np.where(pole, 0, np.arctan2(x, z) / pi)
    p = np.where((x == 0) & (z < 0), -1, p)  # the seam itself is u = 0
    _c, _s, h = _azimuth(x, z)
    return p, 2 * np.arctan2(h, -y) / pi - 1, np.zeros_like(p)


def _encode_perspective(
    x: Array, y: Array, z: Array, parameters: dict[str, float]
) -> tuple[Array, Array, Array]:
    half_p, half_q, cp, cq = _picture(parameters, x.dtype)
    p, q = x / z / half_p + cp, y / z / half_q + cq
    return *_within(p, q, z > 0), np.zeros_like(x)


def _encode_cylindrical(
    x: Array, y: Array, z: Array, parameters: dict[str, float]
) -> tuple[Array, Array, Array]:
    half, height = _cylinder(parameters, x.dtype)
    longitude = np.where((x == 0) & (z < 0), -_pi(x.dtype), np.arctan2(x, z))
    _c, _s, h = _azimuth(x, z)
    return *_within(longitude / half, y / h / height, h > 0), np.zeros_like(x)


def _encode_equisolid(
    x: Array, y: Array, z: Array, parameters: dict[str, float]
) -> tuple[Array, Array, Array]:
    p, q, f = _encode_sphere(x, y, z, parameters)
    rim = np.sin(_half(parameters, "equisolid", x.dtype) / 2)
    return *_fisheye(p / rim, q / rim), f


def _encode_stereographic(
    x: Array, y: Array, z: Array, parameters: dict[str, float]
) -> tuple[Array, Array, Array]:
    c, s, h = _azimuth(x, y)
    r = np.where(z >= 0, h / (1 + z), (1 - z) / h)
    r = r / np.tan(_half(parameters, "stereographic", x.dtype) / 2)
    return *_fisheye(r * c, r * s), np.zeros_like(x)


def _encode_orthographic(
    x: Array, y: Array, z: Array, parameters: dict[str, float]
) -> tuple[Array, Array, Array]:
    rim = np.sin(_half(parameters, "orthographic", x.dtype))
    p, q = _fisheye(x / rim, y / rim)
    return np.where(z < 0, np.nan, p), np.where(z < 0, np.nan, q), np.zeros_like(x)


def _encode_equal_area(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    # Clarberg's r = sqrt(1 - |z|), in a form that keeps its digits.
    r = np.sqrt((x * x + y * y) / (1 + np.abs(z)))
    b = r * np.arctan2(np.abs(y), np.abs(x)) * 2 / _pi(z.dtype)
    a = r - b
    a, b = np.where(z < 0, 1 - b, a), np.where(z < 0, 1 - a, b)
    return a * np.where(x < 0, -1, 1), b * np.where(y < 0, -1, 1), np.zeros_like(x)


def _encode_concentric(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    r = np.sqrt((x * x + y * y) / (1 + np.abs(z)))
    across = np.abs(x) >= np.abs(y)
    near, far = np.where(across, x, y), np.where(across, y, x)
    turn = r * np.arctan2(np.abs(far), np.abs(near)) * 4 / _pi(z.dtype)
    near, far = np.copysign(r, near), np.copysign(turn, far)
    p, q = np.where(across, near, far), np.where(across, far, near)
    return *_within(p, q, z >= 0), np.zeros_like(x)


def _encode_lambert_cylindrical(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    p, _q, f = _encode_latlong(x, y, z, _)
    # y itself, but near -1, where 1 + y keeps its digits only as a quotient.
    return p, np.where(y < 0, (x * x + z * z) / (1 - y) - 1, y), f


def _encode_equiangular(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    p, q, f = _encode_cube(x, y, z, _)
    scale = 4 / _pi(x.dtype)
    return np.arctan(p) * scale, np.arctan(q) * scale, f


def _encode_quadratic(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    def st(u: Array) -> Array:  # S2's UVtoST
        with np.errstate(invalid="ignore"):
            return np.where(u >= 0, np.sqrt(1 + 3 * u) / 2, 1 - np.sqrt(1 - 3 * u) / 2)

    p, q, f = _encode_cube(x, y, z, _)
    return 2 * st(p) - 1, 2 * st(q) - 1, f


def _encode_quadrilateralized(
    x: Array, y: Array, z: Array, _: dict[str, float]
) -> tuple[Array, Array, Array]:
    # PROJ's qsc, in its own letters.
    pi = _pi(x.dtype)
    r, s, f = _encode_cube(x, y, z, _)
    phi = np.arctan(np.hypot(r, s))
    across = np.abs(r) >= np.abs(s)
    near, far = np.where(across, r, s), np.where(across, s, r)
    theta = np.arctan2(np.abs(far), np.abs(near))
    mu = np.arctan(12 / pi * (theta + np.arccos(np.sin(theta) * np.cos(pi / 4)) - pi / 2))
    edge = 2 * np.sin(np.arctan(1 / np.cos(theta)) / 2) ** 2
    t = np.sqrt(2 * np.sin(phi / 2) ** 2 / np.cos(mu) ** 2 / edge)
    near, far = np.copysign(t * np.cos(mu), near), np.copysign(t * np.sin(mu), far)
    return np.where(across, near, far), np.where(across, far, near), f


def _fisheye(p: Array, q: Array) -> tuple[Array, Array]:
    _, ok = _disk(p, q)
    return np.where(ok, p, np.nan), np.where(ok, q, np.nan)


def _within(p: Array, q: Array, ok: Array) -> tuple[Array, Array]:
    edge = 1 + 8 * np.finfo(p.dtype).eps
    ok = ok & (np.abs(p) <= edge) & (np.abs(q) <= edge)
    return np.where(ok, np.clip(p, -1, 1), np.nan), np.where(ok, np.clip(q, -1, 1), np.nan)


def _half(parameters: dict[str, float], name: str, dtype: Any) -> Any:
    return _radians(parameters.get("fov", FISHEYES[name]), dtype) / 2


def _picture(parameters: dict[str, float], dtype: Any) -> tuple[Any, Any, Any, Any]:
    half = np.tan(_radians(parameters.get("fov", 90.0), dtype) / 2)
    cx, cy = (np.asarray(parameters.get(k, 0.0), dtype) for k in ("cx", "cy"))
    return half, half / parameters.get("aspect", 1.0), 2 * cx, 2 * cy


def _cylinder(parameters: dict[str, float], dtype: Any) -> tuple[Any, Any]:
    half = _radians(parameters.get("fov", 360.0), dtype) / 2
    return half, half / parameters.get("aspect", 4.0)


# --- decode: p, q, face -> unit vectors, NaN outside the valid image ------------------------


def _disk(p: Array, q: Array) -> tuple[Array, Array]:
    r2 = p * p + q * q
    with np.errstate(invalid="ignore"):
        return r2, r2 <= 1 + 8 * np.finfo(p.dtype).eps


def _decode_sphere(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    # r = 2 (n·z) n - z with n = (p, q, √c): twice the slope of the ball.
    r2, ok = _disk(p, q)
    c = np.maximum(1 - r2, 0)
    s = np.sqrt(c)
    return _mask(np.stack([2 * p * s, 2 * q * s, 2 * c - 1], -1), ok)


def _decode_matcap(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    r2, ok = _disk(p, q)
    return _mask(np.stack([p, q, np.sqrt(np.maximum(1 - r2, 0))], -1), ok)


def _decode_dual(p: Array, q: Array, f: Array, _: dict[str, float]) -> Array:
    r2, ok = _disk(p, q)
    z = np.maximum(1 - r2, 0) * np.where(f == 0, 1, -1)
    return _mask(np.stack([2 * p, 2 * q, z], -1), ok)


def decode_cube(p: Array, q: Array, f: Array, _: dict[str, float]) -> Array:
    one = np.ones_like(p)
    table = [(one, q, -p), (-one, q, p), (p, -one, q), (p, one, -q), (p, q, one), (-p, q, -one)]
    out = np.full((*p.shape, 3), np.nan, p.dtype)
    for i, v in enumerate(table):
        out = np.where((f == i)[..., None], np.stack(v, -1), out)
    return out


def _decode_healpix(p: Array, q: Array, f: Array, _: dict[str, float]) -> Array:
    u, v = (p + 1) / 2, (q + 1) / 2
    row, column = np.floor(f / 4), f % 4
    center = column + np.where(row == 1, 0, 0.5)
    # From the nearer pole, in rings of the whole face.
    sigma = np.where(row == 0, (1 - u) + (1 - v), u + v)
    cap = (row != 1) & (sigma < 1)
    a = center + (u - v) / 2 / np.where(cap & (sigma > 0), sigma, 1)
    z = np.where(cap, (1 - sigma**2 / 3) * np.where(row == 0, 1, -1), (u + v - row) * 2 / 3)
    sine = np.where(
        cap, sigma * np.sqrt((2 - sigma**2 / 3) / 3), np.sqrt(np.maximum((1 - z) * (1 + z), 0))
    )
    longitude = a * (_pi(p.dtype) / 2)
    return np.stack([sine * np.cos(longitude), sine * np.sin(longitude), z], -1)


def _decode_angular(p: Array, q: Array, _f: Array, parameters: dict[str, float]) -> Array:
    fov = _radians(parameters.get("fov", 360.0), p.dtype)
    c, s, r = _azimuth(p, q)
    _, ok = _disk(p, q)
    theta = np.minimum(r, 1) * fov / 2
    sin = np.sin(theta)
    return _mask(np.stack([c * sin, s * sin, np.cos(theta)], -1), ok)


def _decode_octahedral(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    ap, aq = np.abs(p), np.abs(q)
    z = 1 - ap - aq
    x = np.where(z < 0, (1 - aq) * np.where(p >= 0, 1, -1), p)
    y = np.where(z < 0, (1 - ap) * np.where(q >= 0, 1, -1), q)
    return np.stack([x, y, z], -1)


def _decode_hemioctahedral(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    x, y = (p + q) / 2, (p - q) / 2
    return np.stack([x, y, 1 - np.maximum(np.abs(p), np.abs(q))], -1)


def _decode_latlong(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    pi = _pi(p.dtype)
    theta, phi = (q + 1) / 2 * pi, p * pi
    sin = np.sin(theta)
    return np.stack([sin * np.sin(phi), -np.cos(theta), sin * np.cos(phi)], -1)


def _decode_perspective(p: Array, q: Array, _f: Array, parameters: dict[str, float]) -> Array:
    half_p, half_q, cp, cq = _picture(parameters, p.dtype)
    return np.stack([(p - cp) * half_p, (q - cq) * half_q, np.ones_like(p)], -1)


def _decode_cylindrical(p: Array, q: Array, _f: Array, parameters: dict[str, float]) -> Array:
    half, height = _cylinder(parameters, p.dtype)
    return np.stack([np.sin(p * half), q * height, np.cos(p * half)], -1)


def _decode_equisolid(p: Array, q: Array, f: Array, parameters: dict[str, float]) -> Array:
    rim = np.sin(_half(parameters, "equisolid", p.dtype) / 2)
    return _mask(_decode_sphere(p * rim, q * rim, f, parameters), _disk(p, q)[1])


def _decode_stereographic(p: Array, q: Array, _f: Array, parameters: dict[str, float]) -> Array:
    c, s, r = _azimuth(p, q)
    theta = 2 * np.arctan(r * np.tan(_half(parameters, "stereographic", p.dtype) / 2))
    sin = np.sin(theta)
    return _mask(np.stack([c * sin, s * sin, np.cos(theta)], -1), _disk(p, q)[1])


def _decode_orthographic(p: Array, q: Array, f: Array, parameters: dict[str, float]) -> Array:
    rim = np.sin(_half(parameters, "orthographic", p.dtype))
    return _mask(_decode_matcap(p * rim, q * rim, f, parameters), _disk(p, q)[1])


def _decode_equal_area(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    # pbrt-v4's EqualAreaSquareToSphere.
    pi = _pi(p.dtype)
    a, b = np.abs(p), np.abs(q)
    d = 1 - (a + b)
    r = 1 - np.abs(d)
    phi = np.where(r == 0, 1, (b - a) / np.where(r == 0, 1, r) + 1) * pi / 4
    z = np.copysign(1 - r * r, d)
    flat = r * np.sqrt(2 - r * r)
    cos, sin = np.copysign(np.cos(phi), p), np.copysign(np.sin(phi), q)
    return np.stack([cos * flat, sin * flat, z], -1)


def _decode_concentric(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    pi = _pi(p.dtype)
    across = np.abs(p) >= np.abs(q)
    r = np.where(across, p, q)
    safe = np.where(r == 0, 1, r)
    phi = np.where(across, pi / 4 * q / safe, pi / 2 - pi / 4 * p / safe)
    flat = r * np.sqrt(2 - r * r)
    return np.stack([np.cos(phi) * flat, np.sin(phi) * flat, 1 - r * r], -1)


def _decode_lambert_cylindrical(p: Array, q: Array, _f: Array, _: dict[str, float]) -> Array:
    pi = _pi(p.dtype)
    flat = np.sqrt(np.maximum((1 - q) * (1 + q), 0))
    return np.stack([flat * np.sin(p * pi), q, flat * np.cos(p * pi)], -1)


def _decode_equiangular(p: Array, q: Array, f: Array, _: dict[str, float]) -> Array:
    scale = _pi(p.dtype) / 4
    return decode_cube(np.tan(p * scale), np.tan(q * scale), f, _)


def _decode_quadratic(p: Array, q: Array, f: Array, _: dict[str, float]) -> Array:
    def uv(s: Array) -> Array:  # S2's STtoUV
        return np.where(s >= 0.5, (4 * s * s - 1) / 3, (1 - 4 * (1 - s) ** 2) / 3)

    return decode_cube(uv((p + 1) / 2), uv((q + 1) / 2), f, _)


def _decode_quadrilateralized(p: Array, q: Array, f: Array, _: dict[str, float]) -> Array:
    pi = _pi(p.dtype)
    across = np.abs(p) >= np.abs(q)
    near, far = np.where(across, p, q), np.where(across, q, p)
    ratio = np.abs(far) / np.where(near == 0, 1, np.abs(near))
    t = pi / 12 * ratio
    theta = np.arctan2(np.sin(t), np.cos(t) - 1 / np.sqrt(2 * np.ones((), p.dtype)))
    edge = 2 * np.sin(np.arctan(1 / np.cos(theta)) / 2) ** 2
    phi = 2 * np.arcsin(np.sqrt(near * near * edge / 2))
    a, b = np.sin(phi) * np.cos(theta), np.sin(phi) * np.sin(theta)
    a, b = np.copysign(a, near), np.copysign(b, far)
    m = np.cos(phi)
    return decode_cube(np.where(across, a, b) / m, np.where(across, b, a) / m, f, _)


def _mask(d: Array, ok: Array) -> Array:
    return np.where(ok[..., None], d, np.nan)


# --- density dω/(dp dq), four of which are one dω/(du dv) -----------------------------------


def _density_sphere(p: Array, q: Array, _: dict[str, float]) -> Array:
    return np.full_like(p, 4.0)


def _density_matcap(p: Array, q: Array, _: dict[str, float]) -> Array:
    with np.errstate(divide="ignore"):
        return 1 / np.sqrt(np.maximum(1 - p * p - q * q, 0))


def _density_dual(p: Array, q: Array, _: dict[str, float]) -> Array:
    return 4 / (1 + p * p + q * q) ** 2


def _density_cube(p: Array, q: Array, _: dict[str, float]) -> Array:
    return (1 + p * p + q * q) ** -1.5


def _density_healpix(p: Array, q: Array, _: dict[str, float]) -> Array:
    return np.full_like(p, _pi(p.dtype) / 12) + 0 * q


def _density_angular(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    half = _radians(parameters.get("fov", 360.0), p.dtype) / 2
    pi = _pi(p.dtype)
    return half * half * np.sinc(half * np.sqrt(p * p + q * q) / pi)


def _density_octahedral(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    d = _decode_octahedral(p, q, p, parameters)
    return np.sum(d * d, -1) ** -1.5


def _density_hemioctahedral(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    d = _decode_hemioctahedral(p, q, p, parameters)
    return np.sum(d * d, -1) ** -1.5 / 2


def _density_latlong(p: Array, q: Array, _: dict[str, float]) -> Array:
    pi = _pi(p.dtype)
    return pi * pi / 2 * np.sin((q + 1) / 2 * pi)


def _density_perspective(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    half_p, half_q, cp, cq = _picture(parameters, p.dtype)
    a, b = (p - cp) * half_p, (q - cq) * half_q
    return half_p * half_q * (1 + a * a + b * b) ** -1.5


def _density_cylindrical(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    half, height = _cylinder(parameters, p.dtype)
    return half * height * (1 + (q * height) ** 2) ** -1.5


def _density_equisolid(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    rim = np.sin(_half(parameters, "equisolid", p.dtype) / 2)
    return np.full_like(p, 4 * rim * rim)


def _density_stereographic(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    t = np.tan(_half(parameters, "stereographic", p.dtype) / 2)
    return 4 * t * t / (1 + t * t * (p * p + q * q)) ** 2


def _density_orthographic(p: Array, q: Array, parameters: dict[str, float]) -> Array:
    rim = np.sin(_half(parameters, "orthographic", p.dtype))
    return rim * rim * _density_matcap(p * rim, q * rim, parameters)


def _constant(steradians: float) -> Callable[..., Array]:
    def density(p: Array, q: Array, _: dict[str, float]) -> Array:
        return np.full_like(p, steradians / 4)

    return density


def _density_equiangular(p: Array, q: Array, _: dict[str, float]) -> Array:
    pi = _pi(p.dtype)
    a, b = np.tan(p * pi / 4), np.tan(q * pi / 4)
    return (pi / 4) ** 2 * (1 + a * a) * (1 + b * b) * (1 + a * a + b * b) ** -1.5


def _density_quadratic(p: Array, q: Array, _: dict[str, float]) -> Array:
    a, b = (np.abs(x) * (np.abs(x) + 2) / 3 for x in (p, q))
    slopes = (2 * np.abs(p) + 2) * (2 * np.abs(q) + 2) / 9
    return slopes * (1 + a * a + b * b) ** -1.5


def _pi(dtype: Any) -> Any:
    return np.arctan(np.ones((), dtype)) * 4


def _radians(degrees: float, dtype: Any) -> Any:
    return np.asarray(degrees, dtype) * _pi(dtype) / 180


@dataclass(frozen=True)
class Formulas:
    """What the reference knows of one projection."""

    encode: Callable[..., tuple[Array, Array, Array]]
    decode: Callable[..., Array]
    density: Callable[..., Array]


FORMULAS: dict[str, Formulas] = {
    "sphere": Formulas(_encode_sphere, _decode_sphere, _density_sphere),
    "matcap": Formulas(_encode_matcap, _decode_matcap, _density_matcap),
    "dual_paraboloid": Formulas(_encode_dual, _decode_dual, _density_dual),
    "cube": Formulas(_encode_cube, decode_cube, _density_cube),
    "angular": Formulas(_encode_angular, _decode_angular, _density_angular),
    "octahedral": Formulas(_encode_octahedral, _decode_octahedral, _density_octahedral),
    "hemioctahedral": Formulas(
        _encode_hemioctahedral, _decode_hemioctahedral, _density_hemioctahedral
    ),
    "latlong": Formulas(_encode_latlong, _decode_latlong, _density_latlong),
    "perspective": Formulas(_encode_perspective, _decode_perspective, _density_perspective),
    "cylindrical": Formulas(_encode_cylindrical, _decode_cylindrical, _density_cylindrical),
    "equisolid": Formulas(_encode_equisolid, _decode_equisolid, _density_equisolid),
    "stereographic": Formulas(_encode_stereographic, _decode_stereographic, _density_stereographic),
    "healpix": Formulas(_encode_healpix, _decode_healpix, _density_healpix),
    "orthographic": Formulas(_encode_orthographic, _decode_orthographic, _density_orthographic),
    "equal_area": Formulas(_encode_equal_area, _decode_equal_area, _constant(4 * math.pi)),
    "concentric": Formulas(_encode_concentric, _decode_concentric, _constant(2 * math.pi)),
    "lambert_cylindrical": Formulas(
        _encode_lambert_cylindrical, _decode_lambert_cylindrical, _constant(4 * math.pi)
    ),
    "cube_equiangular": Formulas(_encode_equiangular, _decode_equiangular, _density_equiangular),
    "cube_quadratic": Formulas(_encode_quadratic, _decode_quadratic, _density_quadratic),
    "cube_equal_area": Formulas(
        _encode_quadrilateralized, _decode_quadrilateralized, _constant(4 * math.pi / 6)
    ),
    "dual_fisheye": Formulas(
        atlas.encode_dual_fisheye,
        atlas.decode_dual_fisheye,
        atlas.density_dual_fisheye,
    ),
    "icosahedral": Formulas(
        atlas.encode_icosahedral,
        atlas.decode_icosahedral,
        atlas.density_icosahedral,
    ),
    **{name: Formulas(a.encode, a.decode, a.density) for name, a in LENSES.items()},
    **{name: Formulas(a.encode, a.decode, a.density) for name, a in WORLDS.items()},
}


def clipped(
    polygon: list[tuple[float, float]], line: tuple[float, float, float], side: int
) -> list[tuple[float, float]]:
    """Give the part of a convex polygon where side·(a p + b q + c) > 0."""
    a, b, c = line
    height = [side * (a * p + b * q + c) for p, q in polygon]
    out = []
    for k, (p, q) in enumerate(polygon):
        (r, s), h, g = polygon[k - 1], height[k], height[k - 1]
        if h * g < 0:
            t = g / (g - h)
            out.append((r + t * (p - r), s + t * (q - s)))
        if h >= 0:
            out.append((p, q))
    return out if max(height, default=0) > 0 else []


def polygon_solid_angle(corners: Array) -> float:
    """Van Oosterom and Strackee's formula over a fan of triangles."""
    a = corners[0]
    total = 0.0
    for b, c in pairwise(corners[1:]):
        # Edges, not corners: the determinant of three near vectors would cancel.
        volume = float(np.dot(a, np.cross(b - a, c - a)))
        total += 2 * math.atan2(volume, 1 + float(a @ b + b @ c + c @ a))
    return abs(total)


@dataclass(frozen=True)
class Reference:
    """One projection with its axes, grid, layout and parameters."""

    name: str
    axes: str
    grid: str = "centers"
    layout: str | None = None
    parameters: dict[str, float] = field(default_factory=dict)
    convention: str | None = None

    # -- shape of the uv space

    @property
    def faces(self) -> int:
        """Number of faces that uv carries a third coordinate for (1: none)."""
        return FACES[self.name] if self.layout == "faces" else 1

    @property
    def is_disk(self) -> bool:
        return self.name in DISKS

    @property
    def _atlas(self) -> tuple[int, int, list[tuple[int, int, bool]]] | None:
        if self.layout in (None, "faces"):
            return None
        rows, columns, cells = LAYOUTS[self.name][self.layout]
        if self.layout in IN_ORDER:
            cells = [cells[k] for k in self._stored]
        return rows, columns, cells

    @property
    def _stored(self) -> tuple[int, ...]:
        """The stored number of each face."""
        own = tuple(range(FACES[self.name]))
        return STORED.get((self.name, self.convention or ""), own)

    @property
    def used_part(self) -> float:
        """The share of the image that holds sphere, where its shape is not a layout's."""
        return {"sinusoidal": 2 / math.pi}.get(self.name, math.pi / 4 if self.is_disk else 1.0)

    @property
    def covered_solid_angle(self) -> float:
        if self.name in HEMISPHERES:
            return 2 * math.pi
        if self.name in FISHEYES:
            return 4 * math.pi * math.sin(float(_half(self.parameters, self.name, float)) / 2) ** 2
        if self.name in WORLDS:
            return WORLDS[self.name].covered(self.parameters)
        if self.name == "dual_fisheye":
            return 4 * math.pi * float(atlas.cap_dual_fisheye(1.0, self.parameters))
        if self.name == "cylindrical":
            half, height = _cylinder(self.parameters, float)
            return float(4 * half * height / math.hypot(1, height))
        if self.name == "perspective":
            # A rectangle from the axis to (a, b) spans atan(ab/√(1 + a² + b²)), signs kept.
            half_p, half_q, cp, cq = _picture(self.parameters, float)
            a, b = (half_p * (np.array([-1, 1]) - cp))[:, None], half_q * (np.array([-1, 1]) - cq)
            corner = np.arctan2(a * b, np.sqrt(1 + a * a + b * b))
            return float(corner[1, 1] - corner[0, 1] - corner[1, 0] + corner[0, 0])
        return 4 * math.pi

    def shape(self, size: int) -> tuple[int, ...]:
        if self.name == "latlong":
            return (size, 2 * size)
        if self.name == "lambert_cylindrical":
            return (size, max(1, math.floor(size * math.pi + 0.5)))
        if self.name in WORLDS:
            aspect = WORLDS[self.name].aspect(self.parameters)
            return (size, max(1, math.floor(size * aspect + 0.5)))
        if self.name in ("perspective", "cylindrical"):
            aspect = self.parameters.get("aspect", 4.0 if self.name == "cylindrical" else 1.0)
            return (size, max(1, math.floor(size * aspect + 0.5)))
        if self.layout == "faces":
            return (self.faces, size, size)
        if self._atlas is not None:
            rows, columns, _ = self._atlas
            return (rows * size, columns * size)
        return (size, size)

    # -- the map

    def encode(self, directions: Any) -> Array:
        """Directions (..., 3) to (..., 2), or (..., 3) with the face."""
        d = permute(self.axes, unit(directions), back=False)
        with np.errstate(all="ignore"):
            p, q, f = FORMULAS[self.name].encode(d[..., 0], d[..., 1], d[..., 2], self.parameters)
        bad = np.isnan(p) | np.isnan(q) | np.isnan(d[..., 0])
        u = np.where(bad, np.nan, np.clip((p + 1) / 2, 0, 1))
        v = np.where(bad, np.nan, np.clip((q + 1) / 2, 0, 1))
        f = np.where(bad, np.nan, f)
        if self.faces > 1:
            stored = np.select([f == k for k in range(self.faces)], self._stored, np.nan)
            return np.stack([u, v, stored], -1)
        if self._atlas is None:
            return np.stack([u, v], -1)
        rows, columns, cells = self._atlas
        ou, ov = np.full_like(u, np.nan), np.full_like(v, np.nan)
        for i, (row, column, turned) in enumerate(cells):
            here = f == i
            s, t = (1 - u, 1 - v) if turned else (u, v)
            ou = np.where(here, _inside_cell(s, column, columns), ou)
            ov = np.where(here, _inside_cell(t, row, rows), ov)
        return np.stack([ou, ov], -1)

    def local(self, uv: Any) -> tuple[Array, Array, Array]:
        """Give uv as (p, q, face) of its face; NaN outside [0, 1] and outside the cells."""
        uv = real(uv)
        u, v = uv[..., 0], uv[..., 1]
        with np.errstate(invalid="ignore"):
            inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        if self.faces > 1:
            f = uv[..., 2]
            with np.errstate(invalid="ignore"):
                inside = inside & (f >= 0) & (f < self.faces) & (np.floor(f) == f)
            f = np.select([f == k for k in self._stored], range(self.faces), np.nan)
            s, t = u, v
        elif self._atlas is None:
            f, s, t = np.zeros_like(u), u, v
        else:
            rows, columns, cells = self._atlas
            x, y = u * columns, v * rows
            with np.errstate(invalid="ignore"):
                i = np.clip(np.nan_to_num(np.floor(x), nan=-1), 0, columns - 1)
                j = np.clip(np.nan_to_num(np.floor(y), nan=-1), 0, rows - 1)
            f = np.full_like(u, np.nan)
            s, t = x - i, y - j
            for k, (row, column, turned) in enumerate(cells):
                here = (i == column) & (j == row)
                f = np.where(here, k, f)
                if turned:
                    s, t = np.where(here, 1 - s, s), np.where(here, 1 - t, t)
            inside = inside & ~np.isnan(f)
        p = np.where(inside, 2 * s - 1, np.nan)
        q = np.where(inside, 2 * t - 1, np.nan)
        return p, q, np.where(inside, f, np.nan)

    def decode(self, uv: Any) -> Array:
        p, q, f = self.local(uv)
        with np.errstate(all="ignore"):
            d = FORMULAS[self.name].decode(p, q, f, self.parameters)
        d = np.where(np.isnan(p)[..., None], np.nan, d)
        with np.errstate(all="ignore"):
            d = d / np.sqrt(dot(d, d))[..., None]
        return permute(self.axes, d, back=True)

    def valid(self, uv: Any) -> Array:
        return ~np.isnan(self.decode(uv)[..., 0])

    def covers(self, directions: Any) -> Array:
        return ~np.isnan(self.encode(directions)[..., 0])

    @property
    def stretch(self) -> float:
        """Radians that a fisheye moves for a change of u, where it moves fastest; 0 for others."""
        if self.name == "equisolid":
            half = float(_half(self.parameters, self.name, float)) / 2
            return 4 * math.tan(half)
        if self.name == "stereographic":
            return 4 * math.tan(float(_half(self.parameters, self.name, float)) / 2)
        if self.name in LENSES:
            return LENSES[self.name].stretch(self.parameters)
        return 8.0 if self.name == "hammer" else 0.0

    def clear_of_the_border(self, directions: Any, margin: float = 1e-6) -> Array:
        """Tell directions that rounding cannot move over the edge of the coverage."""
        if self.name not in BORDERED:
            return np.ones(np.shape(directions)[:-1], bool)
        view = permute(self.axes, unit(np.asarray(directions).astype(np.longdouble)), back=False)
        x, y, z = view[..., 0], view[..., 1], view[..., 2]
        fov = self.parameters.get("fov", FISHEYES.get(self.name))
        if self.name in HEMISPHERES:
            return z >= 0  # exact: a sign
        if self.name == "orthographic" and fov == 180:
            return z >= 0
        if self.name in FISHEYES and fov < 360:
            theta = np.arctan2(np.hypot(x, y), z)
            return theta < np.radians(fov) / 2 * (1 - margin)
        if self.name == "dual_fisheye" and self.parameters.get("fov", 180.0) < 180:
            theta = np.arctan2(np.hypot(x, y), np.abs(z))
            return theta < np.radians(self.parameters["fov"]) / 2 * (1 - margin)
        if self.name in ("perspective", "cylindrical", *WORLDS):
            with np.errstate(all="ignore"):
                p, q, _ = FORMULAS[self.name].encode(x, y, z, self.parameters)
                wraps = self.name in MAPS
                wraps |= self.name == "cylindrical" and self.parameters.get("fov", 360.0) == 360
                return (np.abs(q) < 1 - margin) & ((np.abs(p) < 1 - margin) | (wraps & (p == p)))
        return np.ones(z.shape, bool)

    def off_creases(self, p: Array, q: Array, margin: float) -> Array:
        """Tell places of a face farther than `margin` from the lines where the map has a kink."""
        ok = np.ones(np.shape(p), bool)
        lines = CREASES.get(self.name, frozenset())
        with np.errstate(invalid="ignore"):
            if "axes" in lines:
                ok &= (np.abs(p) > margin) & (np.abs(q) > margin)
            if "diamond" in lines:
                ok &= np.abs(np.abs(p) + np.abs(q) - 1) > margin
            if "diagonals" in lines:
                ok &= np.abs(np.abs(p) - np.abs(q)) > margin
            if "band" in lines:
                ok &= (np.abs(p) > margin) & (np.abs(np.abs(2 * p - q) - 1) > 2 * margin)
            for a, b in TIPS.get(self.name, ()):
                ok &= np.hypot(p - a, q - b) > min(16 * margin, 0.3)
            if self.name in POLES & ROOT_RIMS:
                ok &= np.abs(q) < 1 - 4 * margin
        return ok

    def density(self, uv: Any) -> Array:
        p, q, _f = self.local(uv)
        out = 4 * FORMULAS[self.name].density(p, q, self.parameters)
        if self._atlas is not None:
            out = out * (self._atlas[0] * self._atlas[1])
        if self.is_disk:
            out = np.where(_disk(p, q)[1], out, np.nan)
        return np.where(np.isnan(p), np.nan, out)

    def jacobian(self, uv: Any, step: float = 1e-4) -> Array:
        """∂d/∂(u, v) by a fourth-order central difference in longdouble: error about step⁴."""
        uv = np.asarray(uv).astype(np.longdouble)
        out = []
        for k in (0, 1):
            e = np.zeros(uv.shape[-1], np.longdouble)
            e[k] = step
            near = self.decode(uv + e) - self.decode(uv - e)
            far = self.decode(uv + 2 * e) - self.decode(uv - 2 * e)
            out.append((8 * near - far) / (12 * np.longdouble(step)))
        return np.stack(out, -1)

    # -- images

    def _coordinates(self, n: int, vertical: bool) -> Array:
        on_corners = self.grid == "corners" or (self.grid == "corners-v" and vertical)
        return np.arange(n) / (n - 1) if on_corners else (np.arange(n) + 0.5) / n

    def texel_uv(self, shape: tuple[int, ...]) -> Array:
        """Give uv of every texel center, shape (H, W, 2) or (F, H, W, 3)."""
        h, w = shape[-2:]
        rows, columns, _ = self._atlas or (1, 1, [])
        x, y = self._coordinates(w // columns, False), self._coordinates(h // rows, True)
        # Each face has a grid of its own: on corners, neighbors in a picture repeat an edge.
        u = ((np.arange(columns)[:, None] + x) / columns).ravel()
        v = ((np.arange(rows)[:, None] + y) / rows).ravel()
        v, u = np.meshgrid(v, u, indexing="ij")
        uv = np.stack([u, v], -1)
        if len(shape) == 2:
            return uv
        f = np.broadcast_to(np.arange(shape[0], dtype=float)[:, None, None, None], (*shape, 1))
        return np.concatenate([np.broadcast_to(uv, (*shape, 2)), f], -1)

    def directions(self, size: int) -> Array:
        return self.decode(self.texel_uv(self.shape(size)))

    def edges(self, n: int, vertical: bool) -> Array:
        """Boundaries of the n texel cells of one side, clipped to [0, 1]."""
        on_corners = self.grid == "corners" or (self.grid == "corners-v" and vertical)
        if on_corners:
            return np.clip((np.arange(n + 1) - 0.5) / (n - 1), 0, 1)
        return np.arange(n + 1) / n

    def solid_angle(self, shape: tuple[int, ...], order: int = 12) -> Array:
        """Solid angle of every texel by quadrature; for small sizes only."""
        h, w = shape[-2:]
        ue, ve = self.edges(w, False), self.edges(h, True)
        if self.faces > 1:
            one = self._face_solid_angle(2 * ue - 1, 2 * ve - 1, order)
            return np.broadcast_to(one, shape).copy()
        if self._atlas is None:
            return self._face_solid_angle(2 * ue - 1, 2 * ve - 1, order)
        rows, _, cells = self._atlas
        n = h // rows
        one = self._face_solid_angle(
            2 * self.edges(n, False) - 1, 2 * self.edges(n, True) - 1, order
        )
        out = np.zeros(shape)
        for row, column, turned in cells:
            block = one[::-1, ::-1] if turned else one
            out[row * n : (row + 1) * n, column * n : (column + 1) * n] = block
        return out

    def _face_solid_angle(self, pe: Array, qe: Array, order: int) -> Array:
        if self.is_disk:
            return np.array(
                [[self._disk_cell(a, b, c, d) for a, b in pairwise(pe)] for c, d in pairwise(qe)]
            )
        if self.name == "sinusoidal":
            return self._sine_cells(pe, qe)
        if self.name in GNOMONIC_PIECES:
            return self._flat_cells(pe, qe)
        return self._smooth_cells(pe, qe, order)

    def _smooth_cells(self, pe: Array, qe: Array, order: int) -> Array:
        """Tensor Gauss rules on parts of cells; in creased maps on four triangles of each."""
        creased = self.name in CREASES
        (pf, pi), (qf, qi) = _refine(pe, creased), _refine(qe, creased)
        (p0, p1), (q0, q1) = (pf[:-1], pf[1:]), (qf[:-1], qf[1:])
        cp, cq = (p0 + p1) / 2, (q0 + q1) / 2
        dp, dq = (p1 - p0) / 2, (q1 - q0) / 2
        nodes, weight = _in_triangles(order) if creased else _in_a_square(order)
        total = np.zeros((len(cq), len(cp)))
        for lp, lq in nodes:
            p = cp[None, :, None, None] + dp[None, :, None, None] * lp
            q = cq[:, None, None, None] + dq[:, None, None, None] * lq
            d = FORMULAS[self.name].density(p, q, self.parameters)
            total += np.sum(d * weight, axis=(-2, -1)) * dp[None, :] * dq[:, None]
        return np.add.reduceat(np.add.reduceat(total, qi, axis=0), pi, axis=1)

    def _flat_cells(self, pe: Array, qe: Array) -> Array:
        """Cells of flat pieces seen from the center: polygons of great circles."""
        out = np.zeros((len(qe) - 1, len(pe) - 1))
        for j, (c, d) in enumerate(pairwise(qe)):
            for i, (a, b) in enumerate(pairwise(pe)):
                parts = [[(a, c), (b, c), (b, d), (a, d)]]
                for line in GNOMONIC_PIECES[self.name]:
                    parts = [clipped(part, line, side) for part in parts for side in (1, -1)]
                for part in parts:
                    if len(part) > 2:
                        p, q = np.array(part).T
                        f = FORMULAS[self.name]
                        points = f.decode(p, q, np.zeros_like(p), self.parameters)
                        out[j, i] += polygon_solid_angle(unit(points))
        return out

    def _sine_cells(self, pe: Array, qe: Array) -> Array:
        """Cells under |p| = cos(πq/2): rows of Gauss, cut where the curve leaves a side."""
        out = np.zeros((len(qe) - 1, len(pe) - 1))
        x, w = (_GAUSS_X + 1) / 2, _GAUSS_W / 2
        for j, (c, d) in enumerate(pairwise(qe)):
            for i, (a, b) in enumerate(pairwise(pe)):
                cuts = {c, d, *([0.0] if c < 0 < d else [])}
                for side in (a, b):
                    at = 2 / math.pi * math.acos(min(abs(side), 1.0))
                    cuts |= {s * at for s in (1, -1) if c < s * at < d}
                for low, high in pairwise(sorted(cuts)):
                    half = np.cos(np.pi / 2 * (low + (high - low) * x))
                    wide = np.maximum(np.minimum(b, half) - np.maximum(a, -half), 0)
                    out[j, i] += (high - low) * float(np.sum(w * wide))
        return out * (math.pi**2 / 2)

    def _cap(self, r: Array) -> Array:
        """1 - cos θ(r): the solid angle inside radius r of the disk, over 2π."""
        r = np.minimum(r, 1)
        if self.name in ("sphere", "mollweide", "hammer"):
            return 2 * r * r
        if self.name == "matcap":
            return r * r / (1 + np.sqrt(1 - r * r))
        if self.name == "dual_paraboloid":
            return 2 * r * r / (1 + r * r)
        if self.name == "dual_fisheye":
            return atlas.cap_dual_fisheye(r, self.parameters)
        if self.name in LENSES:
            return LENSES[self.name].cap(r, self.parameters)
        half = float(_half(self.parameters, self.name, float))
        if self.name == "equisolid":
            return 2 * (r * np.sin(half / 2)) ** 2
        if self.name == "stereographic":
            t = (r * np.tan(half / 2)) ** 2
            return 2 * t / (1 + t)
        if self.name == "orthographic":
            t = (r * np.sin(half)) ** 2
            return t / (1 + np.sqrt(np.maximum(1 - t, 0)))
        return 2 * np.sin(half * r / 2) ** 2

    def _disk_cell(self, p0: float, p1: float, q0: float, q1: float) -> float:
        """Integrate [cap(r_out) - cap(r_in)] dφ around the cell, its rim part cut off."""
        if self.name == "dual_fisheye" and (grow := self.parameters.get("fov", 180.0) / 180) > 1:
            # Only the own hemisphere counts: the disk of a face of 180°, that much smaller.
            own = replace(self, parameters={"fov": 180.0})
            return own._disk_cell(*(min(max(x * grow, -1.0), 1.0) for x in (p0, p1, q0, q1)))
        if p0 < 0 < p1:
            return self._disk_cell(p0, 0.0, q0, q1) + self._disk_cell(0.0, p1, q0, q1)
        if q0 < 0 < q1:
            return self._disk_cell(p0, p1, q0, 0.0) + self._disk_cell(p0, p1, 0.0, q1)
        # One quadrant: mirror into the first.
        a, b = sorted((abs(p0), abs(p1)))
        c, d = sorted((abs(q0), abs(q1)))
        if a * a + c * c >= 1 or a == b or c == d:
            return 0.0
        cuts = {math.atan2(c, b), math.atan2(d, a), math.atan2(c, a), math.atan2(d, b)}
        for s in (a, b):
            if 0 < s < 1:
                cuts.add(math.acos(s))
        for s in (c, d):
            if 0 < s < 1:
                cuts.add(math.asin(s))
        lo, hi = math.atan2(c, b), math.atan2(d, a)
        points = sorted(x for x in cuts if lo <= x <= hi)
        # Not between cuts at one angle, but for the rounding of their arctangents.
        spans = [(x, y - x) for x, y in pairwise(points) if y - x >= 1e-15]
        start, span = np.array(spans).reshape(-1, 2, 1).swapaxes(0, 1)
        # φ = start + span sin²: takes the square root away at either end.
        psi = (_GAUSS_X + 1) * (math.pi / 4)
        phi = start + span * np.sin(psi) ** 2
        dphi = span * np.sin(2 * psi) * _GAUSS_W * (math.pi / 4)
        cos, sin = np.cos(phi), np.sin(phi)
        with np.errstate(divide="ignore"):
            inner = np.maximum(a / cos, c / sin)
            outer = np.minimum(b / cos, d / sin)
        inner = np.minimum(inner, 1)
        outer = np.maximum(np.minimum(outer, 1), inner)
        # Caps of all at once: those of lenses take time by the call, as they are inverted.
        below, above = self._cap(np.stack([inner, outer]))
        return float(np.sum((above - below) * dphi))

    def sample_interior(self, image: Array, directions: Any, filter: str) -> tuple[Array, Array]:
        """Filtered values in float64 of a one-face image, and where all four taps are plain."""
        uv = self.encode(directions)
        h, w = image.shape[:2]
        corner_u = self.grid == "corners"
        corner_v = self.grid in ("corners", "corners-v")
        x = uv[..., 0] * (w - 1) if corner_u else uv[..., 0] * w - 0.5
        y = uv[..., 1] * (h - 1) if corner_v else uv[..., 1] * h - 0.5
        bad = np.isnan(x)
        x, y = np.where(bad, 0, x), np.where(bad, 0, y)
        center_ok = self.valid(self.texel_uv((h, w)))
        i0, j0 = np.floor(x).astype(int), np.floor(y).astype(int)
        plain = ~bad & (i0 >= 0) & (j0 >= 0) & (i0 + 1 < w) & (j0 + 1 < h)
        i0, j0 = np.clip(i0, 0, w - 2), np.clip(j0, 0, h - 2)
        for dj in (0, 1):
            for di in (0, 1):
                plain = plain & center_ok[j0 + dj, i0 + di]
        fx, fy = x - i0, y - j0
        image = image.astype(np.float64)
        if filter == "nearest":
            i, j = i0 + (fx >= 0.5), j0 + (fy >= 0.5)
            # Left out: beside the middle between two texels the rounding of uv may decide.
            on_edge = (np.abs(fx - 0.5) < 1e-5) | (np.abs(fy - 0.5) < 1e-5)
            return image[j, i], plain & ~on_edge
        shape = fx.shape + (1,) * (image.ndim - 2)
        fx, fy = fx.reshape(shape), fy.reshape(shape)
        top = image[j0, i0] * (1 - fx) + image[j0, i0 + 1] * fx
        bottom = image[j0 + 1, i0] * (1 - fx) + image[j0 + 1, i0 + 1] * fx
        return top * (1 - fy) + bottom * fy, plain


_GAUSS_X, _GAUSS_W = gauss(48)


def _inside_cell(s: Array, k: int, n: int) -> Array:
    """(k + s)/n, kept where floor(n x) = k: a border belongs to the cell to its right or below."""
    x = (k + s) / n
    low, high = x.dtype.type(k) / n, x.dtype.type(k + 1) / n
    while low * n < k:
        low = np.nextafter(low, np.inf)
    if k + 1 < n:
        while np.floor(high * n) > k:
            high = np.nextafter(high, -np.inf)
    return np.clip(x, low, high)


def _in_a_square(order: int) -> tuple[list[tuple[Array, Array]], Array]:
    """Give Gauss nodes in the square from -1 to 1, and their weights."""
    x, wx = gauss(order)
    return [tuple(np.meshgrid(x, x, indexing="ij"))], np.outer(wx, wx)


def _in_triangles(order: int) -> tuple[list[tuple[Array, Array]], Array]:
    """Give those in four triangles about its middle, and the weights in each.

    Parts are whole fractions of a cell: then p = 0, q = 0 and the lines |p| ± |q| = 1, the creases,
    run along edges and diagonals of square parts. Only corners-v has oblong parts; there a crease
    crosses some of them, and the result is good to about 1e-6.
    """
    x, wx = gauss(order)
    x, wx = (x + 1) / 2, wx / 2
    r, t = np.meshgrid(x, x, indexing="ij")  # Duffy: r from the center out, t along an edge
    side = r * (2 * t - 1)
    return [(r, side), (-r, side), (side, r), (side, -r)], np.outer(wx * x, wx) * 2


def _refine(edges: Array, creased: bool) -> tuple[Array, Array]:
    """Split [-1, 1] evenly, keeping every edge; give the parts and the first part of each cell.

    Where there are creases, which run along 0, they are an even number.
    """
    step = float(np.min(np.diff(edges)))
    parts = round(2 / step)
    parts *= 2 * max(1, round(8 / parts)) if creased else max(1, round(24 / parts))
    fine = np.linspace(-1, 1, parts + 1)
    first = np.rint((edges[:-1] + 1) / 2 * parts).astype(int)
    # Rounding of fractions of 2; an edge that is none of them is off by a share of a part.
    assert np.allclose(fine[first], edges[:-1], rtol=0, atol=1e-12)
    return fine, first


def of(projection: Any) -> Reference:
    """Build the reference of any object with name, axes, grid, layout and parameters."""
    if projection.name not in FORMULAS:
        raise LookupError(
            f"projection {projection.name!r} is registered but tests/reference/maps.py has no "
            "formula for it: write one from its source"
        )
    return Reference(
        projection.name,
        projection.axes,
        projection.grid,
        projection.layout,
        dict(projection.parameters),
        projection.convention,
    )


def stored(projection: Any, face: int) -> int:
    """Give the number under which a map stores its face of this number, if it has several."""
    return of(projection)._stored[face] if projection.name in CUBES else face


def make(name: str, **options: Any) -> Reference:
    """Build the reference of a projection by name, with default axes and layout."""
    options.setdefault("axes", DEFAULT_AXES[name])
    if name in FACES:
        options.setdefault("layout", "faces")
    return Reference(name, **options)


def smooth_function(d: Array) -> Array:
    """Three low-order polynomials of direction, different everywhere, gradient below 2.9."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    return np.stack(
        [
            1 + x / 2 + y * z + z / 4,
            1 + y / 2 - x * y + (3 * z * z - 1) / 4,
            1 - z / 2 + x * z + x * y * z,
        ],
        -1,
    )
