"""Real spherical harmonics of images, and the orders and signs of other programs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _core
from ._arrays import as_real, as_rotation, as_unit_vectors, checked_image, has_channels
from .map.named import resolve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .map.named import ProjectionLike

__all__ = [
    "conventions",
    "convert",
    "convolve",
    "evaluate",
    "lobe",
    "project",
    "rotate",
    "window",
]


def __dir__() -> list[str]:
    return __all__


def project(
    image: ArrayLike, projection: ProjectionLike, /, *, order: int, skipna: bool = False
) -> NDArray[np.float64]:
    """Return the spherical harmonic coefficients of an image.

    Parameters
    ----------
    image, projection, skipna
        As for `light.integrate`.
    order : int
        The highest degree l, from 0 to 64: order 2 has 9 coefficients.

    Returns
    -------
    coefficients : ndarray of float64, shape ((order + 1)²,) or ((order + 1)², C)
        c[l² + l + m] = ∫ L Y_lm dω, with Y real, orthonormal, without the Condon-Shortley phase
        and with +z of the world as its axis: Y_1,-1, Y_1,0 and Y_1,1 are √(3/4π) times y, z and x.
        `sh.convert` makes other conventions of it.

    Raises
    ------
    ValueError
        As for `light.integrate`, and for an order that is above 64 or that the image cannot hold.
    TypeError
        As for `light.integrate`.

    Notes
    -----
    An image that holds no more than `order` gives its coefficients to rounding (1e-12), on every
    projection of the whole sphere: no degree leaks into another. Where texels lie on rings, as in a
    latlong, sums use Fejér's first rule (Clenshaw and Curtis's where rows lie on the poles), which
    is exact for all products of degrees below the number of rows. Elsewhere the coefficients are
    those of the least squares fit of two degrees more. What a partial coverage does not hold is
    black, and sums are plain.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> up = sm.directions("cube", 16)[..., 1]
    >>> (np.round(sm.sh.project(up, "cube", order=1), 6) + 0.0).tolist()
    [0.0, 2.046653, 0.0, 0.0]
    """
    resolved = resolve(projection)
    pixels = checked_image(image, skipna=skipna)
    found = _core.sh_project(pixels, resolved, _order(order))
    return found if has_channels(pixels, resolved) else found[:, 0]


def evaluate(coefficients: ArrayLike, directions: ArrayLike, /) -> NDArray[np.float64]:
    """Return the function that coefficients describe, in given directions.

    Parameters
    ----------
    coefficients : array_like, shape ((order + 1)²,) or ((order + 1)², C)
        As `project` returns.
    directions : array_like, shape (..., 3)
        World directions of any length.

    Returns
    -------
    values : ndarray of float64, shape (...) or (..., C)
        NaN for a direction that is zero or not finite.

    Raises
    ------
    ValueError, TypeError
        For a wrong shape, or numbers that are not real.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.sh.evaluate([0, 0, 0, 1], [[2, 0, 0], [0, 1, 0]]), 6).tolist()
    [0.488603, 0.0]
    """
    rows, _, channels = _rows(coefficients)
    unit, leading = as_unit_vectors(directions, "directions")
    return _core.sh_evaluate(rows, unit).reshape(*leading, *channels)


def rotate(coefficients: ArrayLike, rotation: Any, /) -> NDArray[np.float64]:
    """Turn the function that coefficients describe: f'(R d) = f(d).

    Parameters
    ----------
    coefficients : array_like, shape ((order + 1)²,) or ((order + 1)², C)
        As `project` returns.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``
        As for `convert`: it turns the content in the world.

    Returns
    -------
    coefficients : ndarray of float64, of the same shape

    Raises
    ------
    ValueError, TypeError
        For a wrong shape, or a matrix that is no rotation.

    Notes
    -----
    The function is evaluated on a turned grid that determines it, and analyzed again: exact to
    rounding for every rotation and order (1e-12 at order 64).

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> turned = sm.sh.rotate([0, 0, 1, 0], sm.rotation(90, 0, 0))
    >>> (np.round(turned, 6) + 0.0).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    rows, shape, _ = _rows(coefficients)
    matrix = as_rotation(rotation)
    # The core's own check, and its message.
    _core.projection("latlong").encode(np.zeros((0, 3)), rotation=matrix)
    return _core.sh_rotate(rows, matrix).reshape(shape)


def lobe(
    lobe: Literal["cosine", "cone", "phong", "vmf"],
    order: int,
    /,
    *,
    half_angle: float = 90.0,
    exponent: float = 1.0,
    kappa: float = 1.0,
) -> NDArray[np.float64]:
    """Return by what a lobe multiplies each degree: A_l = 2π ∫ K(t) P_l(t) dt.

    Parameters
    ----------
    lobe : {"cosine", "cone", "phong", "vmf"}
        As for `light.convolve`, and ``"cosine"``: max(0, cos), which makes irradiance of radiance.
    order : int
        The highest degree.
    half_angle, exponent, kappa : float
        Of the cone (degrees), of Phong's lobe, of von Mises and Fisher's.

    Returns
    -------
    factors : ndarray of float64, shape (order + 1,)
        π, 2π/3, π/4, 0, -π/24, ... for the cosine; the others are normalized and begin with 1.

    Raises
    ------
    ValueError
        For an unknown lobe, or a parameter out of range.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.sh.lobe("cosine", 4) / np.pi, 6).tolist()
    [1.0, 0.666667, 0.25, 0.0, -0.041667]
    """
    return _lobe(lobe, order, half_angle=half_angle, exponent=exponent, kappa=kappa)


def convolve(
    coefficients: ArrayLike, lobe: str | ArrayLike, /, **parameters: float
) -> NDArray[np.float64]:
    """Convolve with a lobe that is round about its axis (Funk and Hecke): degree by degree.

    Parameters
    ----------
    coefficients : array_like, shape ((order + 1)²,) or ((order + 1)², C)
        As `project` returns.
    lobe : str or array_like, shape (order + 1,)
        A name for `lobe`, or the factors themselves.
    **parameters : float
        Of the named lobe.

    Returns
    -------
    coefficients : ndarray of float64, of the same shape

    Raises
    ------
    ValueError, TypeError
        As for `lobe` and `evaluate`.

    Examples
    --------
    Irradiance over π:

    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.sh.convolve([1, 0, 3, 0], "cosine") / np.pi, 6).tolist()
    [1.0, 0.0, 2.0, 0.0]
    """
    rows, shape, _ = _rows(coefficients)
    order = math.isqrt(len(rows)) - 1
    if isinstance(lobe, str):
        factors = _lobe(lobe, order, **parameters)
    else:
        factors = np.asarray(lobe, dtype=np.float64)
        if parameters:
            raise ValueError(f"factors take no `{next(iter(parameters))}`.")
        if factors.shape != (order + 1,):
            raise ValueError(f"Expected `lobe` to have shape ({order + 1},), got {factors.shape}.")
    return (rows * factors[_degrees(order)][:, np.newaxis]).reshape(shape)


def window(
    coefficients: ArrayLike,
    window: Literal["hann", "lanczos", "gauss"] = "hann",
    /,
    *,
    width: float | None = None,
) -> NDArray[np.float64]:
    """Fade high degrees out, so that a bright light does not ring.

    Parameters
    ----------
    coefficients : array_like, shape ((order + 1)²,) or ((order + 1)², C)
        As `project` returns.
    window : {"hann", "lanczos", "gauss"}
        (1 + cos(π l/width))/2 and sin(π l/width)/(π l/width), both 0 from l = width on, or
        exp(-(π l/width)²/12), which has the width of the second and is never negative in space.
    width : float, optional
        By default order + 1, the mildest that acts on all degrees.

    Returns
    -------
    coefficients : ndarray of float64, of the same shape

    Raises
    ------
    ValueError, TypeError
        For a wrong shape, an unknown window, or a width that is not positive.

    Notes
    -----
    Sloan 2008, Stupid Spherical Harmonics Tricks. Degree 0, the mean, stays.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.sh.window([1, 1, 1, 1], "hann"), 6).tolist()
    [1.0, 0.5, 0.5, 0.5]
    """
    rows, shape, _ = _rows(coefficients)
    order = math.isqrt(len(rows)) - 1
    wide = float(order + 1 if width is None else width)
    if not wide > 0:
        raise ValueError(f"`width` must be positive, got {width}.")
    x = np.arange(order + 1) / wide
    if window == "hann":
        factors = np.where(x < 1, 0.5 * (1 + np.cos(np.pi * x)), 0.0)
    elif window == "lanczos":
        factors = np.where(x < 1, np.sinc(x), 0.0)
    elif window == "gauss":
        factors = np.exp(-np.square(np.pi * x) / 12)
    else:
        raise ValueError(f"unknown window {window!r}; there are hann, lanczos, gauss")
    return (rows * factors[_degrees(order)][:, np.newaxis]).reshape(shape)


@dataclass(frozen=True)
class _Convention:
    """How a program writes coefficients."""

    phase: bool = False
    """Condon-Shortley: the sign (-1)^m."""
    scale: float = 1.0
    """What a coefficient is multiplied by: the inverse of its basis' factor."""
    by_degree: bool = False
    """Its basis is divided by √(2l + 1) as well."""
    y_polar: bool = False
    """The axis is y: its (x, y, z) stand where others have (y, z, x)."""
    note: str = ""
    source: str = ""


_ROOT_4PI = math.sqrt(4 * math.pi)

_CONVENTIONS: dict[str, _Convention] = {
    "orthonormal": _Convention(
        note="this library's own: real, orthonormal, no phase, index l² + l + m",
        source="Ramamoorthi & Hanrahan 2001",
    ),
    "graphics": _Convention(
        note="the same: Y_1 = 0.488603 (y, z, x)", source="Ramamoorthi & Hanrahan 2001"
    ),
    "condon-shortley": _Convention(
        phase=True,
        note="real, orthonormal, with (-1)^m: Y_1 = 0.488603 (-y, z, -x)",
        source="Sloan 2008, D3DXSHEvalDirection",
    ),
    "3dgs": _Convention(
        phase=True,
        note="Condon-Shortley; a color is the sum + 0.5, which is no part of the coefficients",
        source="Kerbl et al. 2023, sh_utils.eval_sh",
    ),
    "threejs": _Convention(
        note="SphericalHarmonics3: radiance, nine coefficients; getIrradianceAt convolves",
        source="three.js math/SphericalHarmonics3.js",
    ),
    "e3nn": _Convention(
        y_polar=True,
        note="normalization='integral': orthonormal about y, degree 1 in the order x, y, z",
        source="e3nn o3.spherical_harmonics",
    ),
    "e3nn-component": _Convention(
        y_polar=True,
        scale=1 / _ROOT_4PI,
        note="normalization='component': the basis times √4π",
        source="e3nn o3.spherical_harmonics",
    ),
    "e3nn-norm": _Convention(
        y_polar=True,
        scale=1 / _ROOT_4PI,
        by_degree=True,
        note="normalization='norm': the basis times √(4π/(2l + 1))",
        source="e3nn o3.spherical_harmonics",
    ),
    "pyshtools": _Convention(
        scale=1 / _ROOT_4PI,
        note="4π-normalized, no phase; an array (2, order + 1, order + 1): cosines, sines",
        source="pyshtools SHCoeffs, normalization='4pi', csphase=1",
    ),
    "healpy": _Convention(
        note="complex a_lm of m ≥ 0 with the phase, in the order of Alm.getidx",
        source="healpy.map2alm",
    ),
    "filament-irradiance": _Convention(
        note="order 2: convolved with the cosine, over π, times the basis' constants",
        source="Filament libs/ibl CubemapSH, computeIrradianceSH3Bands",
    ),
}

# Filament's shader multiplies by 1, y, z, x, yx, yz, 3z² - 1, zx, x² - y².
_FILAMENT = np.array(
    [math.sqrt(1 / (4 * math.pi))]
    + [math.sqrt(3 / (4 * math.pi))] * 3
    + [math.sqrt(15 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi))]
    + [math.sqrt(5 / (16 * math.pi)), math.sqrt(15 / (4 * math.pi))]
    + [math.sqrt(15 / (16 * math.pi))]
)


def conventions() -> list[dict[str, str]]:
    """Return the conventions of coefficients: one row for each name.

    Returns
    -------
    rows : list of dict
        With ``name``, ``note`` and ``source``.

    Examples
    --------
    >>> import spheremap as sm
    >>> [row["name"] for row in sm.sh.conventions()][:3]
    ['orthonormal', 'graphics', 'condon-shortley']
    """
    return [
        {"name": name, "note": row.note, "source": row.source} for name, row in _CONVENTIONS.items()
    ]


def convert(
    coefficients: ArrayLike, /, *, src: str = "orthonormal", dst: str = "orthonormal"
) -> NDArray[Any]:
    """Rewrite coefficients of one program for another: the function stays the same.

    Parameters
    ----------
    coefficients : array_like
        As `src` has them: ((order + 1)²,) or ((order + 1)², C); for ``"pyshtools"``
        (2, order + 1, order + 1) and for ``"healpy"`` complex ((order + 1)(order + 2)/2,), both
        with channels last, if any.
    src, dst : str
        Names that `sh.conventions` lists. ``"filament-irradiance"`` holds irradiance, order 2 is
        all it has, and it takes what is above it off.

    Returns
    -------
    coefficients : ndarray
        As `dst` has them.

    Raises
    ------
    ValueError
        For an unknown name, or a shape that `src` cannot have.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sm.sh.convert([1, 2, 3, 4], dst="3dgs").tolist()
    [1.0, -2.0, 3.0, -4.0]
    >>> (np.round(sm.sh.convert([1, 2, 3, 4], dst="e3nn"), 6) + 0.0).tolist()
    [1.0, 4.0, 2.0, 3.0]
    """
    return _to(_from(coefficients, _convention(src), src), _convention(dst), dst)


def _from(coefficients: ArrayLike, row: _Convention, name: str) -> NDArray[np.float64]:
    """Return orthonormal coefficients, one row each."""
    if name == "pyshtools":
        both = np.asarray(coefficients, dtype=np.float64)
        n = both.shape[1] if both.ndim > 2 else 0
        if both.ndim not in (3, 4) or both.shape[0] != 2 or both.shape[2] != n or n == 0:
            raise ValueError(
                "Expected `coefficients` of 'pyshtools' to have shape (2, N, N) or (2, N, N, C), "
                f"got {both.shape}."
            )
        flat = np.zeros((n * n, *both.shape[3:]))
        for l_, m, place in _places(n - 1):
            flat[place] = both[int(m < 0), l_, abs(m)]
    elif name == "healpy":
        complex_ = np.asarray(coefficients, dtype=np.complex128)
        n = (math.isqrt(8 * len(complex_) + 1) - 1) // 2 if complex_.ndim else 0
        if complex_.ndim not in (1, 2) or n * (n + 1) // 2 != len(complex_) or n == 0:
            raise ValueError(
                "Expected `coefficients` of 'healpy' to have shape (N (N + 1)/2,) or "
                f"(N (N + 1)/2, C), got {complex_.shape}."
            )
        flat = np.zeros((n * n, *complex_.shape[1:]))
        for l_, m, place in _places(n - 1):
            a = complex_[abs(m) * (2 * n - abs(m) - 1) // 2 + l_]
            sign = (-1) ** abs(m) * math.sqrt(2)
            flat[place] = a.real if m == 0 else sign * (a.real if m > 0 else -a.imag)
    else:
        rows, shape, _ = _rows(coefficients)
        flat = rows.reshape(shape)
    order = math.isqrt(len(flat)) - 1
    flat = flat * _column(_factors(row, order), flat.ndim) ** -1
    if name == "filament-irradiance":
        if order != 2:
            raise ValueError(f"'{name}' has 9 coefficients, got {len(flat)}.")
        flat = flat / _column(_FILAMENT * lobe("cosine", 2)[_degrees(2)] / math.pi, flat.ndim)
    if row.y_polar:
        flat = _turned(flat, _Y_POLAR.T)
    return flat


def _to(flat: NDArray[np.float64], row: _Convention, name: str) -> NDArray[Any]:
    if row.y_polar:
        flat = _turned(flat, _Y_POLAR)
    if name == "filament-irradiance":
        if len(flat) < 9:
            raise ValueError(f"'{name}' needs order 2, got order {math.isqrt(len(flat)) - 1}.")
        cosine = lobe("cosine", 2)[_degrees(2)] / math.pi
        flat = flat[:9] * _column(_FILAMENT * cosine, flat.ndim)
    order = math.isqrt(len(flat)) - 1
    flat = flat * _column(_factors(row, order), flat.ndim)
    n = order + 1
    if name == "pyshtools":
        both = np.zeros((2, n, n, *flat.shape[1:]))
        for l_, m, place in _places(order):
            both[int(m < 0), l_, abs(m)] = flat[place]
        return both
    if name == "healpy":
        complex_ = np.zeros((n * (n + 1) // 2, *flat.shape[1:]), np.complex128)
        for l_, m, place in _places(order):
            at = abs(m) * (2 * n - abs(m) - 1) // 2 + l_
            sign = (-1) ** abs(m) / math.sqrt(2)
            complex_[at] += flat[place] if m == 0 else sign * flat[place] * (1 if m > 0 else -1j)
        return complex_
    return flat


# Its x, y and z stand where this library has y, z and x: rows are its axes' (x, y, z).
_Y_POLAR = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def _turned(flat: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    rows = np.ascontiguousarray(flat.reshape(len(flat), -1))
    return _core.sh_rotate(rows, np.ascontiguousarray(matrix)).reshape(flat.shape)


def _factors(row: _Convention, order: int) -> NDArray[np.float64]:
    factors = np.full((order + 1) ** 2, row.scale)
    for l_, m, place in _places(order):
        if row.phase and m % 2:
            factors[place] *= -1
        if row.by_degree:
            factors[place] *= math.sqrt(2 * l_ + 1)
    return factors


def _convention(name: str) -> _Convention:
    try:
        return _CONVENTIONS[name]
    except KeyError:
        names = ", ".join(_CONVENTIONS)
        raise ValueError(f"unknown convention {name!r}; there are {names}") from None


def _places(order: int) -> list[tuple[int, int, int]]:
    return [(l_, m, l_ * l_ + l_ + m) for l_ in range(order + 1) for m in range(-l_, l_ + 1)]


def _degrees(order: int) -> NDArray[np.intp]:
    return np.repeat(np.arange(order + 1), 2 * np.arange(order + 1) + 1)


def _column(values: NDArray[np.float64], ndim: int) -> NDArray[np.float64]:
    return values.reshape(-1, *[1] * (ndim - 1))


def _rows(
    coefficients: ArrayLike,
) -> tuple[NDArray[np.float64], tuple[int, ...], tuple[int, ...]]:
    """Return coefficients as ((order + 1)², C), their shape, and that of their channels."""
    array = as_real(coefficients, "coefficients").astype(np.float64, copy=False)
    n = len(array) if array.ndim else 0
    if array.ndim not in (1, 2) or n == 0 or math.isqrt(n) ** 2 != n or 0 in array.shape:
        raise ValueError(
            "Expected `coefficients` to have shape ((order + 1)²,) or ((order + 1)², C), "
            f"got {array.shape}."
        )
    return np.ascontiguousarray(array.reshape(n, -1)), array.shape, array.shape[1:]


def _order(order: int, *, highest: int = 64) -> int:
    number = int(order)
    if number != order or not 0 <= number <= highest:
        raise ValueError(f"Expected `order` to be a whole number from 0 to {highest}, got {order}.")
    return number


def _lobe(
    name: str, order: int, *, half_angle: float = 90.0, exponent: float = 1.0, kappa: float = 1.0
) -> NDArray[np.float64]:
    order = _order(order, highest=10_000)
    if name == "cosine":
        return math.pi * _phong(1.0, order)
    if name == "phong":
        if not (math.isfinite(exponent) and exponent >= 0):
            raise ValueError(f"`exponent` must be at least 0 and finite, got {exponent}.")
        return _phong(exponent, order)
    if name == "cone":
        if not 0 < half_angle <= 180:
            raise ValueError(f"`half_angle` must be in (0, 180], got {half_angle}.")
        return _cone(math.radians(half_angle), order)
    if name == "vmf":
        if not (math.isfinite(kappa) and kappa >= 0):
            raise ValueError(f"`kappa` must be at least 0 and finite, got {kappa}.")
        return _vmf(kappa, order)
    raise ValueError(f"unknown lobe {name!r}; there are cosine, cone, phong, vmf")


def _phong(exponent: float, order: int) -> NDArray[np.float64]:
    factors = np.zeros(order + 1)
    factors[0] = 1.0
    if order > 0:
        factors[1] = (exponent + 1) / (exponent + 2)
    for l_ in range(2, order + 1):
        factors[l_] = factors[l_ - 2] * (exponent - l_ + 2) / (exponent + l_ + 1)
    return factors


def _cone(angle: float, order: int) -> NDArray[np.float64]:
    cos, half = math.cos(angle), 2 * math.sin(angle / 2) ** 2
    # ∫ P_l over the cone = (P_l-1 - P_l+1)/(2l + 1), divided by its size 1 - cos. Differences
    # D_l = P_l - P_l+1 keep the digits of small cones that P_l-1 - P_l+1 loses.
    legendre, difference = 1.0, half
    factors = np.ones(order + 1)
    for l_ in range(1, order + 1):
        before = difference
        # (l + 1) D_l = l D_l-1 + (2l + 1)(1 - cos) P_l
        legendre -= before
        difference = (l_ * before + (2 * l_ + 1) * half * legendre) / (l_ + 1)
        factors[l_] = (before + difference) / ((2 * l_ + 1) * half)
    return factors if cos < 1 else np.ones(order + 1)


def _vmf(kappa: float, order: int) -> NDArray[np.float64]:
    # Ratios of modified spherical Bessel functions, downward (Miller).
    factors = np.zeros(order + 1)
    factors[0] = 1.0
    if kappa == 0:
        return factors
    start = order + 20 + int(math.sqrt(40 * (order + 1)) + min(kappa, 1e6) ** 0.5 * 12)
    ratio = 0.0
    ratios = np.zeros(order + 2)
    for l_ in range(start, 0, -1):
        ratio = 1.0 / ((2 * l_ + 1) / kappa + ratio)
        if l_ <= order:
            ratios[l_] = ratio
    for l_ in range(1, order + 1):
        factors[l_] = factors[l_ - 1] * ratios[l_]
    return factors
