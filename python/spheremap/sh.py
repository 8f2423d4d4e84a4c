"""Real spherical harmonics of images, and the orders and signs of other programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _core
from ._arrays import as_array, as_doubles, as_unit_vectors, checked_image, has_channels
from ._scalars import as_number, as_text, as_whole
from ._show import Rows
from .map.images import images
from .map.named import resolve

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from ._names import Language
    from .map.named import ProjectionLike

__all__ = [
    "code",
    "conventions",
    "convert",
    "convolve",
    "evaluate",
    "lobe",
    "project",
    "rotate",
    "window",
]


# The parameter that each lobe has.
LOBES = {"cosine": None, "cone": "half_angle", "phong": "exponent", "vmf": "kappa"}


def __dir__() -> list[str]:
    return __all__


def project(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    order: int,
    texels: Literal["means", "points"] = "means",
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.float64]:
    """Return the spherical harmonic coefficients of an image.

    Parameters
    ----------
    image, projection, skipna, any_aspect, channels_first
        As for `light.integrate`.
    order : int
        The highest degree l, from 0 to 64: order 2 has 9 coefficients.
    texels : {"means", "points"}
        What a texel is: the mean over its solid angle, as in photos, renderings and what
        ``convert(filter="area")`` writes, or the value at its center, as `evaluate` gives.
    axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`.

    Returns
    -------
    coefficients : ndarray of float64, shape ((order + 1)²,) or ((order + 1)², C)
        Of a batch, (N, (order + 1)², C).
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
    Coefficients are those of the least squares fit of two degrees more, each texel with its exact
    solid angle. Of means, order 0 is the integral of the image over √4π, to rounding: no light is
    lost, wherever it is. Of points, an image that holds no more than `order` gives its coefficients
    to rounding (1e-12), on every projection of the whole sphere: no degree leaks into another.
    Where texels lie on rings, as in a latlong, their sums then use Fejér's first rule (Clenshaw and
    Curtis's where rows lie on the poles), which is exact for all products of degrees below the
    number of rows. The two differ in order 0 alone by what degree 2 leaks into the sum of means:
    0.92/H² of it at most for a latlong of H rows. What a partial coverage does not hold is black,
    and sums are plain.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> up = sm.directions("cube", 16)[..., 1]
    >>> (np.round(sm.sh.project(up, "cube", order=1), 6) + 0.0).tolist()
    [0.0, 2.046653, 0.0, 0.0]
    """
    resolved = resolve(projection, axes)
    several = images(
        image, resolved, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(project, locals(), "numbers")
    resolved = resolve(resolved, rotation=rotation)
    pixels = checked_image(image, resolved, skipna=skipna)
    if as_text(texels, "texels") not in ("means", "points"):
        raise ValueError(f"Expected `texels` to be 'means' or 'points', got {texels!r}.")
    found = _core.sh_project(pixels, resolved, as_order(order), texels == "points")
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
    return _core.sh_evaluate(rows, unit).reshape((*leading, *channels))


def code(
    coefficients: ArrayLike,
    language: Language | str,
    /,
    *,
    name: str = "sh",
    dtype: str = "float32",
) -> str:
    """Return `evaluate` as source text of another language, with coefficients folded in.

    Parameters
    ----------
    coefficients : array_like, shape ((order + 1)²,), ((order + 1)², 1) or ((order + 1)², 3)
        As `project` returns, of order 8 at most; with any number of channels for NumPy, PyTorch,
        JAX and the array API. For irradiance they are convolved with the lobe
        "cosine", and order 2 is enough.
    language : str
        As for `spheremap.code`.
    name : str
        What names begin with: the function is ``sh_evaluate``, from a unit direction in the world
        to a number or three.
    dtype : {"float32", "float64"}
        The width of numbers; float64 in languages that have it.

    Returns
    -------
    str
        Source text.

    Raises
    ------
    ValueError, TypeError
        For a wrong shape, numbers that are not finite, and options that the language does not have.

    Notes
    -----
    The sum is that of `evaluate`, term by term. It is a polynomial: there is no singular point.

    Source: Ramamoorthi and Hanrahan 2001, An Efficient Representation for Irradiance Environment
    Maps.

    Examples
    --------
    >>> import spheremap as sm
    >>> text = sm.sh.code([1.0, 0.0, 0.5, 0.0], "glsl", name="sky")
    >>> [line for line in text.splitlines() if line.endswith("{")]
    ['float sky_evaluate(vec3 d) {']
    """
    rows, *_ = _rows(coefficients)
    _core.check_word("dtype", as_text(dtype, "dtype"), ["float32", "float64"])
    return _core.sh_code(
        rows, as_text(language, "language"), as_text(name, "name"), dtype == "float64"
    )


def rotate(coefficients: ArrayLike, /, rotation: Any) -> NDArray[np.float64]:
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
    # Checked as that of any other verb is.
    pose = resolve("latlong", rotation=rotation).pose
    matrix = np.eye(3) if pose is None else pose
    return _core.sh_rotate(rows, matrix).reshape(shape)


def lobe(
    lobe: Literal["cosine", "cone", "phong", "vmf"],
    /,
    *,
    order: int,
    half_angle: float | None = None,
    exponent: float | None = None,
    kappa: float | None = None,
) -> NDArray[np.float64]:
    """Return by what a lobe multiplies each degree: A_l = 2π ∫ K(t) P_l(t) dt.

    Parameters
    ----------
    lobe : {"cosine", "cone", "phong", "vmf"}
        As for `light.convolve`, and ``"cosine"``: max(0, cos), which makes irradiance of radiance.
    order : int
        The highest degree.
    half_angle, exponent, kappa : float
        Of the cone (degrees), of Phong's lobe, of von Mises and Fisher's: that of `lobe` and no
        other.

    Returns
    -------
    factors : ndarray of float64, shape (order + 1,)
        π, 2π/3, π/4, 0, -π/24, ... for the cosine; the others are normalized and begin with 1.

    Raises
    ------
    ValueError, TypeError
        For an unknown lobe, and for a parameter that is missing, out of range or of another lobe.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.sh.lobe("cosine", order=4) / np.pi, 6).tolist()
    [1.0, 0.666667, 0.25, 0.0, -0.041667]
    """
    return _factors(lobe, order, {"half_angle": half_angle, "exponent": exponent, "kappa": kappa})


def _factors(lobe: str, order: int, parameters: Mapping[str, float | None]) -> NDArray[np.float64]:
    parameter = lobe_parameter(lobe, LOBES, parameters)
    return _core.sh_lobe(lobe, parameter, as_order(order, highest=10_000))


def lobe_parameter(
    lobe: object, lobes: Mapping[str, str | None], given: Mapping[str, float | None]
) -> float:
    """Return the parameter of one of some lobes, or raise unless it is given, and no other's."""
    name = as_text(lobe, "lobe")
    _core.check_word("lobe", name, list(lobes))
    wanted = lobes[name]
    surplus = next((key for key, x in given.items() if x is not None and key != wanted), None)
    if surplus is not None:
        own = "no parameter" if wanted is None else f"`{wanted}`"
        raise ValueError(f"lobe {name!r} takes {own}, got `{surplus}`.")
    if wanted is None:
        return 0.0
    if given.get(wanted) is None:
        raise ValueError(f"lobe {name!r} needs `{wanted}`.")
    return as_number(given[wanted], wanted)


def convolve(
    coefficients: ArrayLike, /, *, lobe: str | ArrayLike, **parameters: float
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
    >>> np.round(sm.sh.convolve([1, 0, 3, 0], lobe="cosine") / np.pi, 6).tolist()
    [1.0, 0.0, 2.0, 0.0]
    """
    rows, shape, _ = _rows(coefficients)
    order = math.isqrt(len(rows)) - 1
    if isinstance(lobe, str):
        factors = _factors(lobe, order, parameters)
    else:
        factors = as_doubles(lobe, "lobe")
        expect_factors(factors.shape, order, parameters)
    return _core.sh_scale_degrees(rows, np.ascontiguousarray(factors)).reshape(shape)


def expect_factors(shape: tuple[int, ...], order: int, parameters: Mapping[str, Any]) -> None:
    """Raise ValueError unless factors of this shape are one for each degree, and stand alone."""
    if parameters:
        raise ValueError(f"factors take no `{next(iter(parameters))}`.")
    if shape != (order + 1,):
        raise ValueError(f"Expected `lobe` to have shape ({order + 1},), got {shape}.")


def window(
    coefficients: ArrayLike,
    /,
    *,
    window: Literal["hann", "lanczos", "gauss"] = "hann",
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
    >>> np.round(sm.sh.window([1, 1, 1, 1], window="hann"), 6).tolist()
    [1.0, 0.5, 0.5, 0.5]
    """
    rows, shape, _ = _rows(coefficients)
    order = math.isqrt(len(rows)) - 1
    name = as_text(window, "window")
    factors = _core.sh_window(name, None if width is None else as_number(width, "width"), order)
    return _core.sh_scale_degrees(rows, factors).reshape(shape)


class Conventions(Rows):
    """Rows of the table of conventions: a list of dicts that prints as a table."""

    HEAD = ("name", "note", "source")


def conventions() -> Conventions:
    """Return the conventions of coefficients: one row for each name.

    Returns
    -------
    rows : list of dict
        With ``name``, ``note`` and ``source``; prints as a table.

    Examples
    --------
    >>> import spheremap as sm
    >>> [row["name"] for row in sm.sh.conventions()][:3]
    ['orthonormal', 'graphics', 'condon-shortley']
    """
    rows = _core.sh_convention_table()
    return Conventions(dict(zip(Conventions.HEAD, row, strict=True)) for row in rows)


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
    TypeError
        For names that are no strings, and numbers that `src` does not have.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sm.sh.convert([1, 2, 3, 4], dst="3dgs").tolist()
    [1.0, -2.0, 3.0, -4.0]
    >>> (np.round(sm.sh.convert([1, 2, 3, 4], dst="e3nn"), 6) + 0.0).tolist()
    [1.0, 4.0, 2.0, 3.0]
    """
    src, dst = as_text(src, "src"), as_text(dst, "dst")
    stored, channels = _stored(coefficients, _core.sh_storage(src))
    storage = _core.sh_storage(dst)
    found: NDArray[Any] = _core.sh_convert(stored, src, dst)
    if storage == "complex":
        return found.view(np.complex128).reshape(len(found), *channels)
    n = math.isqrt(len(found) // 2)
    return found.reshape(*((2, n, n) if storage == "squares" else (len(found),)), *channels)


def _stored(coefficients: ArrayLike, storage: str) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Return coefficients as (N, C) real numbers, or (N, C, 2), and the shape of their channels."""
    if storage == "squares":
        both = as_doubles(coefficients, "coefficients")
        n = both.shape[1] if both.ndim > 2 else 0
        if both.ndim not in (3, 4) or both.shape[:3] != (2, n, n) or 0 in both.shape:
            raise ValueError(
                "Expected `coefficients` of 'pyshtools' to have shape (2, N, N) or (2, N, N, C), "
                f"got {both.shape}."
            )
        return np.ascontiguousarray(both.reshape(2 * n * n, -1)), both.shape[3:]
    if storage == "complex":
        given = as_array(coefficients, "coefficients")
        if given.dtype.kind not in "fiubc":
            raise TypeError(f"Expected `coefficients` to be numbers, got dtype {given.dtype}.")
        array = given.astype(np.complex128, copy=False)
        n = (math.isqrt(8 * len(array) + 1) - 1) // 2 if array.ndim else 0
        if array.ndim not in (1, 2) or n * (n + 1) // 2 != len(array) or 0 in array.shape:
            raise ValueError(
                "Expected `coefficients` of 'healpy' to have shape (N (N + 1)/2,) or "
                f"(N (N + 1)/2, C), got {array.shape}."
            )
        pairs = np.ascontiguousarray(array.reshape(len(array), -1))
        return pairs.view(np.float64).reshape(*pairs.shape, 2), array.shape[1:]
    rows, _, channels = _rows(coefficients)
    return rows, channels


def _rows(
    coefficients: ArrayLike,
) -> tuple[NDArray[np.float64], tuple[int, ...], tuple[int, ...]]:
    """Return coefficients as ((order + 1)², C), their shape, and that of their channels."""
    array = as_doubles(coefficients, "coefficients")
    n = len(array) if array.ndim else 0
    if array.ndim not in (1, 2) or n == 0 or math.isqrt(n) ** 2 != n or 0 in array.shape:
        raise ValueError(
            "Expected `coefficients` to have shape ((order + 1)²,) or ((order + 1)², C), "
            f"got {array.shape}."
        )
    return np.ascontiguousarray(array.reshape(n, -1)), array.shape, array.shape[1:]


def as_order(order: int, *, highest: int = 64) -> int:
    """Return an order as an int, or raise for what is none."""
    number = as_whole(order, "order")
    if not 0 <= number <= highest:
        raise ValueError(f"Expected `order` to be a whole number from 0 to {highest}, got {order}.")
    return number
