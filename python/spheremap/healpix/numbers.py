"""HEALPix pixel numbers: of directions, of angles, in both orders."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .. import _core
from .._arrays import as_array, as_doubles, common_shape, expect_room, expect_vectors
from .._scalars import as_flag, as_whole
from ..map.named import resolve

if TYPE_CHECKING:
    from typing import SupportsIndex

    from numpy.typing import ArrayLike, NDArray

    Pixels: TypeAlias = NDArray[np.int64]
    Nside: TypeAlias = SupportsIndex | ArrayLike

MAX_NSIDE = 1 << 29

# Rounding of float32 takes an angle at the end of its range so far beyond, in radians, or less.
_SLACK = 1e-5


def vec2pix(
    nside: Nside,
    directions: ArrayLike,
    /,
    nest: bool = False,
    *,
    out: Pixels | None = None,
) -> Pixels:
    """Return the pixels that directions fall into.

    Parameters
    ----------
    nside : int or array_like of int
        Pixels along the side of a face, 1 to 2²⁹; a power of two in nested order. An array of them
        is broadcast against what follows.
    directions : array_like, shape (..., 3)
        Directions of any length.
    nest : bool
        Nested order instead of ring order.
    out : ndarray, optional
        An int64 array for the result.

    Returns
    -------
    pixels : ndarray of int64, shape (...)
        -1 for a direction that is zero or not finite.

    Raises
    ------
    ValueError
        For an `nside` that does not exist, or directions of another shape.
    TypeError
        For input that is not real numbers.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.vec2pix(1, [[1, 0, 0], [0, 1, 0], [0, 0, -1], [0, 0, 0]]).tolist()
    [4, 5, 8, -1]
    """
    nest = as_flag(nest, "nest")
    if _is_one(nside):
        return _core.healpix_vec2pix(as_nside(nside), directions, nest=nest, out=out)
    array = as_array(directions, "directions")
    expect_vectors(array.shape, "directions")
    return _by_nside(
        lambda n, d: _core.healpix_vec2pix(n, d, nest=nest),
        nside,
        ("directions", array, 1),
        (np.int64, ()),
        out,
    )


def pix2vec(
    nside: Nside,
    pixels: ArrayLike,
    /,
    nest: bool = False,
    *,
    out: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Return the unit vectors to the centers of pixels.

    Parameters
    ----------
    nside : int or array_like of int
        As for `vec2pix`.
    pixels : array_like of int, shape (...)
        Pixel numbers.
    nest : bool
        They are in nested order.
    out : ndarray, optional
        A float64 array for the result.

    Returns
    -------
    directions : ndarray of float64, shape (..., 3)
        NaN for a number that no pixel has. Off by at most 2e-15.

    Raises
    ------
    ValueError, TypeError
        As for `vec2pix`; TypeError for numbers that are not integers.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.pix2vec(1, 4).tolist()
    [1.0, 0.0, 0.0]
    """
    nest = as_flag(nest, "nest")
    if _is_one(nside):
        return _core.healpix_pix2vec(as_nside(nside), pixels, nest=nest, out=out)
    return _by_nside(
        lambda n, p: _core.healpix_pix2vec(n, p, nest=nest),
        nside,
        ("pixels", as_array(pixels, "pixels"), 0),
        (np.float64, (3,)),
        out,
    )


def ang2pix(
    nside: Nside,
    theta: ArrayLike,
    phi: ArrayLike,
    /,
    nest: bool = False,
    lonlat: bool = False,
) -> Pixels:
    """Return the pixels that directions given by two angles fall into.

    Parameters
    ----------
    nside : int or array_like of int
        As for `vec2pix`.
    theta, phi : array_like
        The angle from the north pole, 0 to π, and the longitude, in radians; they are broadcast.
        With `lonlat`, the longitude and the latitude, -90 to 90, in degrees.
    nest, lonlat : bool
        Nested order; longitude and latitude in degrees.

    Returns
    -------
    pixels : ndarray of int64
        -1 where an angle is not finite.

    Raises
    ------
    ValueError, TypeError
        As for `vec2pix`; ValueError for a polar angle out of its range by more than 1e-5 rad. What
        is so by less, as π in float32, counts as the pole.

    Examples
    --------
    >>> from spheremap import healpix
    >>> int(healpix.ang2pix(16, 30.0, 60.0, lonlat=True)), int(healpix.ang2pix(16, 1.0, 1.0))
    (183, 682)
    """
    nest, lonlat = as_flag(nest, "nest"), as_flag(lonlat, "lonlat")
    angles = as_angles(theta, phi)

    def numbers(angles: NDArray[np.float64]) -> Pixels:
        if _is_one(nside):
            n = as_nside(nside)
            return _core.healpix_ang2pix(n, angles, nest=nest, lonlat=lonlat)
        return _by_nside(
            lambda n, x: _core.healpix_ang2pix(n, x, nest=nest, lonlat=lonlat),
            nside,
            ("theta", angles, 1),
            (np.int64, ()),
        )

    pixels = numbers(angles)
    if np.min(pixels, initial=0) < 0 and bring_into_range(angles, lonlat):
        return numbers(angles)
    return pixels


def as_angles(theta: ArrayLike, phi: ArrayLike) -> NDArray[np.float64]:
    """Return two angles, broadcast, as an array of their own of shape (..., 2)."""
    a, b = as_doubles(theta, "theta"), as_doubles(phi, "phi")
    angles = np.empty((*common_shape(("theta", a.shape), ("phi", b.shape)), 2))
    angles[..., 0], angles[..., 1] = a, b
    return angles


def bring_into_range(angles: NDArray[np.float64], lonlat: bool) -> bool:
    """Raise for a polar angle out of its range; round one that is so by rounding, and say so."""
    tilt = angles[..., 1] if lonlat else angles[..., 0]
    name, least, most = ("latitude", -90.0, 90.0) if lonlat else ("theta", 0.0, math.pi)
    slack = math.degrees(_SLACK) if lonlat else _SLACK
    beyond = np.isfinite(tilt) & ((tilt < least) | (tilt > most))
    wrong = beyond & ((tilt < least - slack) | (tilt > most + slack))
    if wrong.any():
        ends = "-90 to 90 degrees" if lonlat else "0 to π"
        raise ValueError(f"`{name}` must be from {ends}, got {tilt[wrong].flat[0]:g}.")
    np.clip(tilt, least, most, out=tilt)
    return bool(beyond.any())


def pix2ang(
    nside: Nside, pixels: ArrayLike, /, nest: bool = False, lonlat: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two angles of the centers of pixels.

    Parameters
    ----------
    nside : int or array_like of int
        As for `vec2pix`.
    pixels : array_like of int
        Pixel numbers.
    nest, lonlat : bool
        As for `ang2pix`.

    Returns
    -------
    theta, phi : ndarray of float64
        As `ang2pix` takes them, the longitude from 0 on; NaN for a number that no pixel has.

    Raises
    ------
    ValueError, TypeError
        As for `pix2vec`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> lon, lat = healpix.pix2ang(1, [0, 4, 11], lonlat=True)
    >>> lon.tolist(), lat.round(6).tolist()
    ([45.0, 0.0, 315.0], [41.810315, 0.0, -41.810315])
    """
    nest, lonlat = as_flag(nest, "nest"), as_flag(lonlat, "lonlat")
    if _is_one(nside):
        angles = _core.healpix_pix2ang(as_nside(nside), pixels, nest=nest, lonlat=lonlat)
    else:
        angles = _by_nside(
            lambda n, p: _core.healpix_pix2ang(n, p, nest=nest, lonlat=lonlat),
            nside,
            ("pixels", as_array(pixels, "pixels"), 0),
            (np.float64, (2,)),
        )
    return angles[..., 0], angles[..., 1]


def nest2ring(nside: Nside, pixels: ArrayLike, /, *, out: Pixels | None = None) -> Pixels:
    """Return the ring numbers of nested pixels.

    Parameters
    ----------
    nside : int or array_like of int
        A power of two, up to 2²⁹; an array is broadcast.
    pixels : array_like of int
        Nested numbers.
    out : ndarray, optional
        An int64 array for the result.

    Returns
    -------
    pixels : ndarray of int64
        Ring numbers; -1 for a number that no pixel has.

    Raises
    ------
    ValueError, TypeError
        As for `pix2vec`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.nest2ring(2, [0, 1, 2, 3]).tolist()
    [13, 5, 4, 0]
    """
    return _reordered(nside, pixels, True, out)


def ring2nest(nside: Nside, pixels: ArrayLike, /, *, out: Pixels | None = None) -> Pixels:
    """Return the nested numbers of ring pixels.

    Parameters
    ----------
    nside : int or array_like of int
        A power of two, up to 2²⁹; an array is broadcast.
    pixels : array_like of int
        Ring numbers.
    out : ndarray, optional
        An int64 array for the result.

    Returns
    -------
    pixels : ndarray of int64
        Nested numbers; -1 for a number that no pixel has.

    Raises
    ------
    ValueError, TypeError
        As for `pix2vec`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.ring2nest(2, [13, 5, 4, 0]).tolist()
    [0, 1, 2, 3]
    """
    return _reordered(nside, pixels, False, out)


def _reordered(nside: Nside, pixels: ArrayLike, nest: bool, out: Pixels | None) -> Pixels:
    if _is_one(nside):
        return _core.healpix_reorder(as_nside(nside), pixels, nest=nest, out=out)
    return _by_nside(
        lambda n, p: _core.healpix_reorder(n, p, nest=nest),
        nside,
        ("pixels", as_array(pixels, "pixels"), 0),
        (np.int64, ()),
        out,
    )


def nside2npix(nside: Nside, /) -> Any:
    """Return how many pixels there are: 12 nside².

    Parameters
    ----------
    nside : int or array_like of int
        Pixels along the side of a face, 1 to 2²⁹.

    Returns
    -------
    npix : int or ndarray of int64

    Raises
    ------
    ValueError, TypeError
        For an `nside` that does not exist, or is no integer.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.nside2npix(64), healpix.nside2npix([1, 2]).tolist()
    (49152, [12, 48])
    """
    return 12 * _sides(nside) ** 2


def npix2nside(npix: SupportsIndex | ArrayLike, /) -> Any:
    """Return the nside of a map of so many pixels.

    Parameters
    ----------
    npix : int or array_like of int
        Numbers of pixels.

    Returns
    -------
    nside : int or ndarray of int64

    Raises
    ------
    ValueError, TypeError
        For a number that is not 12 nside², or no integer.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.npix2nside(49152)
    64
    """
    if _is_one(npix):
        return _side_of(as_whole(npix, "npix"))
    counts = _integers(npix, "npix")
    sides = [_side_of(int(count)) for count in counts.ravel()]
    return np.array(sides, np.int64).reshape(counts.shape)


def _side_of(count: int) -> int:
    nside = math.isqrt(max(count, 0) // 12)
    if nside < 1 or 12 * nside * nside != count:
        raise ValueError(f"A map has 12 nside² pixels, got {count}.")
    return nside


def nside2pixarea(nside: Nside, /, degrees: bool = False) -> Any:
    """Return the solid angle of each pixel.

    Parameters
    ----------
    nside : int or array_like of int
        As for `nside2npix`.
    degrees : bool
        In square degrees; else in steradians.

    Returns
    -------
    area : float or ndarray of float64

    Raises
    ------
    ValueError, TypeError
        As for `nside2npix`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> round(healpix.nside2pixarea(1), 6), round(healpix.nside2pixarea(1, degrees=True), 3)
    (1.047198, 3437.747)
    """
    area = 4 * math.pi / nside2npix(nside)
    return area * math.degrees(1) ** 2 if as_flag(degrees, "degrees") else area


def nside2resol(nside: Nside, /, arcmin: bool = False) -> Any:
    """Return the root of a pixel's solid angle: about the distance between centers.

    Parameters
    ----------
    nside : int or array_like of int
        As for `nside2npix`.
    arcmin : bool
        In minutes of arc; else in radians.

    Returns
    -------
    resolution : float or ndarray of float64

    Raises
    ------
    ValueError, TypeError
        As for `nside2npix`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> round(healpix.nside2resol(128), 6), round(healpix.nside2resol(128, arcmin=True), 4)
    (0.007995, 27.4839)
    """
    area = nside2pixarea(nside)
    resolution = math.sqrt(area) if isinstance(area, float) else np.sqrt(area)
    return resolution * (60 * math.degrees(1)) if as_flag(arcmin, "arcmin") else resolution


def boundaries(
    nside: SupportsIndex, pixels: ArrayLike, /, step: int = 1, nest: bool = False
) -> NDArray[np.float64]:
    """Return points on the borders of pixels.

    Parameters
    ----------
    nside : int
        As for `vec2pix`.
    pixels : array_like of int, shape (...)
        Pixel numbers.
    step : int
        Points a side, each side with its first corner.
    nest : bool
        The numbers are in nested order.

    Returns
    -------
    directions : ndarray of float64, shape (..., 4 * step, 3)
        From the northern corner over the western, southern and eastern ones; NaN for a number
        that no pixel has.

    Raises
    ------
    ValueError, TypeError
        As for `pix2vec`; ValueError for a `step` below 1.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.boundaries(1, 4)[0].round(6).tolist()
    [0.745356, 0.0, 0.666667]
    """
    n, count = as_nside(nside), as_whole(step, "step")
    if not 1 <= count <= MAX_NSIDE:
        raise ValueError(f"`step` must be from 1 to {MAX_NSIDE}, got {count}.")
    face, cell, is_pixel = cells(n, pixels, nest)
    share = np.arange(count) / count
    ends = np.array([[1.0, 1], [0, 1], [0, 0], [1, 0]])
    corners = ends[:, None] + share[:, None] * (np.roll(ends, -1, axis=0) - ends)[:, None]
    place = (cell[..., None, :] + corners.reshape(-1, 2)) / n
    face = np.broadcast_to(face[..., None, None], (*place.shape[:-1], 1))
    out = resolve("healpix").decode(np.concatenate([place, face], -1))
    return np.asarray(np.where(is_pixel[..., None, None], out, np.nan))


def neighbors(nside: SupportsIndex, pixels: ArrayLike, /, nest: bool = False) -> Pixels:
    """Return the eight pixels around each.

    Parameters
    ----------
    nside : int
        As for `vec2pix`.
    pixels : array_like of int, shape (...)
        Pixel numbers.
    nest : bool
        They are in nested order.

    Returns
    -------
    pixels : ndarray of int64, shape (..., 8)
        To the south-west, west, north-west, north, north-east, east, south-east and south. -1 where
        only three faces meet and there is none, and around a number that no pixel has.

    Raises
    ------
    ValueError, TypeError
        As for `pix2vec`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.neighbors(4, 0).tolist()
    [4, 11, 3, 2, 1, 6, 5, 13]
    """
    return _core.healpix_neighbors(as_nside(nside), pixels, nest=as_flag(nest, "nest"))


def cells(
    n: int, pixels: ArrayLike, nest: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return the faces of pixels, (..., 2) their columns and rows there, and which are pixels."""
    centers = pix2vec(n, pixels, nest=nest)
    is_pixel = ~np.isnan(centers[..., 0])
    uv = resolve("healpix").encode(np.nan_to_num(centers, nan=1.0))
    cell: NDArray[np.float64] = np.floor(uv[..., :2] * n)
    return np.asarray(uv[..., 2], np.float64), cell, is_pixel


def as_nside(nside: object) -> int:
    """Return an nside as an int, or raise."""
    try:
        number = operator.index(nside)  # type: ignore[arg-type]
    except TypeError:
        kind = type(nside).__name__
        raise TypeError(f"`nside` must be an integer, got {kind}.") from None
    if not 1 <= number <= MAX_NSIDE:
        raise ValueError(f"`nside` must be from 1 to {MAX_NSIDE}, got {number}.")
    return number


def _is_one(value: object) -> bool:
    """Tell a number from an array of them."""
    # A list, ragged ones too, is none; whoever reads it says what is wrong.
    return not isinstance(value, list | tuple | np.ndarray) or (
        isinstance(value, np.ndarray) and value.ndim == 0
    )


def _sides(nside: Nside) -> Any:
    """Return one nside as an int, or an array of them as int64."""
    if _is_one(nside):
        return as_nside(nside)
    sides = _integers(nside, "nside")
    expect_room(sides.shape, np.dtype(np.int64))
    for end in (sides.min(initial=1), sides.max(initial=1)):
        as_nside(end)
    return sides.astype(np.int64)


def _integers(values: object, name: str) -> NDArray[Any]:
    array = as_array(values, name)
    if array.dtype.kind not in "iu" and array.size:
        raise TypeError(f"Expected `{name}` to be integers, got dtype {array.dtype}.")
    return array


def _by_nside(
    call: Callable[..., Any],
    nside: Nside,
    given: tuple[str, NDArray[Any], int],
    result: tuple[type, tuple[int, ...]],
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """Return what a call with one nside gives, for an array of them.

    What is given has a name and so many last axes that are no places, the result a dtype and last
    axes.
    """
    if out is not None:
        raise ValueError("`out` needs one `nside`, not an array of them.")
    sides = _sides(nside)
    name, array, last = given
    places, rest = array.shape[: array.ndim - last], array.shape[array.ndim - last :]
    shape = common_shape(("nside", sides.shape), (name, places))
    sides = np.broadcast_to(sides, shape).ravel()
    array = np.broadcast_to(array, (*shape, *rest)).reshape(-1, *rest)
    dtype, tail = result
    found: NDArray[Any] = np.empty((sides.size, *tail), dtype)
    # Those of one nside together, however many there are of them.
    order = np.argsort(sides, kind="stable")
    values, first = np.unique(sides[order], return_index=True)
    for n, here in zip(values.tolist(), np.split(order, first[1:]), strict=False):
        found[here] = call(n, array[here])
    return found.reshape(*shape, *tail)
