"""HEALPix pixel numbers, and HEALPix maps as images.

The sphere is 12 faces of nside² pixels of equal area. In *ring* order pixels are counted along
rings of equal latitude from the north, in *nested* order face by face along a Z-order curve [1]_.
z points to the north pole, x to longitude 0 and y to longitude 90° east, as in healpy.

All functions take arrays of any shape and run on threads. Numbers are int64; -1 is the pixel of
what has none.

Notes
-----
Indices equal healpy's. A direction within 4e-15 rad of a border between pixels, which is what
rounding moves it by, may be given to either of them, here as there. At a pole itself the pixel is
that of longitude 0, whatever the signs of zeros.

References
----------
.. [1] K. M. Górski et al., "HEALPix: A Framework for High-Resolution Discretization and Fast
   Analysis of Data Distributed on the Sphere", Astrophysical Journal 622, 759, 2005.

Examples
--------
>>> from spheremap import healpix
>>> int(healpix.vec2pix(64, [0.0, 0.0, 1.0])), int(healpix.vec2pix(64, [0.0, 0.0, 1.0], nest=True))
(0, 4095)
"""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._arrays import as_doubles, common_shape
from ._scalars import as_flag, as_whole
from .map.named import resolve

if TYPE_CHECKING:
    from typing import SupportsIndex

    from numpy.typing import ArrayLike, NDArray

    Pixels = NDArray[np.int64]

__all__ = [
    "ang2pix",
    "boundaries",
    "from_image",
    "nest2ring",
    "npix2nside",
    "nside2npix",
    "nside2pixarea",
    "nside2resol",
    "pix2ang",
    "pix2vec",
    "reorder",
    "ring2nest",
    "to_image",
    "vec2pix",
]


def __dir__() -> list[str]:
    return __all__


MAX_NSIDE = 1 << 29


def vec2pix(
    nside: SupportsIndex,
    directions: ArrayLike,
    /,
    *,
    nest: bool = False,
    out: Pixels | None = None,
) -> Pixels:
    """Return the pixels that directions fall into.

    Parameters
    ----------
    nside : int
        Pixels along the side of a face, 1 to 2²⁹; a power of two in nested order.
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
    return _core.healpix_vec2pix(_nside(nside), directions, nest=nest, out=out)


def pix2vec(
    nside: SupportsIndex,
    pixels: ArrayLike,
    /,
    *,
    nest: bool = False,
    out: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Return the unit vectors to the centers of pixels.

    Parameters
    ----------
    nside : int
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
    return _core.healpix_pix2vec(_nside(nside), pixels, nest=nest, out=out)


def ang2pix(
    nside: SupportsIndex,
    theta: ArrayLike,
    phi: ArrayLike,
    /,
    *,
    nest: bool = False,
    lonlat: bool = False,
) -> Pixels:
    """Return the pixels that directions given by two angles fall into.

    Parameters
    ----------
    nside : int
        As for `vec2pix`.
    theta, phi : array_like
        The angle from the north pole, 0 to π, and the longitude, in radians; they are broadcast.
        With `lonlat`, the longitude and the latitude, -90 to 90, in degrees.
    nest, lonlat : bool
        Nested order; longitude and latitude in degrees.

    Returns
    -------
    pixels : ndarray of int64
        -1 where an angle is out of its range or not finite.

    Raises
    ------
    ValueError, TypeError
        As for `vec2pix`.

    Examples
    --------
    >>> from spheremap import healpix
    >>> int(healpix.ang2pix(16, 30.0, 60.0, lonlat=True)), int(healpix.ang2pix(16, 1.0, 1.0))
    (183, 682)
    """
    a, b = (_real(x, name) for x, name in ((theta, "theta"), (phi, "phi")))
    angles = np.empty((*common_shape(a.shape, b.shape), 2))
    angles[..., 0], angles[..., 1] = a, b
    return _core.healpix_ang2pix(_nside(nside), angles, nest=nest, lonlat=lonlat)


def pix2ang(
    nside: SupportsIndex, pixels: ArrayLike, /, *, nest: bool = False, lonlat: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two angles of the centers of pixels.

    Parameters
    ----------
    nside : int
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
    angles = _core.healpix_pix2ang(_nside(nside), pixels, nest=nest, lonlat=lonlat)
    return angles[..., 0], angles[..., 1]


def nest2ring(nside: SupportsIndex, pixels: ArrayLike, /, *, out: Pixels | None = None) -> Pixels:
    """Return the ring numbers of nested pixels.

    Parameters
    ----------
    nside : int
        A power of two, up to 2²⁹.
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
    return _core.healpix_reorder(_nside(nside), pixels, nest=True, out=out)


def ring2nest(nside: SupportsIndex, pixels: ArrayLike, /, *, out: Pixels | None = None) -> Pixels:
    """Return the nested numbers of ring pixels.

    Parameters
    ----------
    nside : int
        A power of two, up to 2²⁹.
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
    return _core.healpix_reorder(_nside(nside), pixels, nest=False, out=out)


def nside2npix(nside: SupportsIndex, /) -> int:
    """Return how many pixels there are: 12 nside².

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.nside2npix(64)
    49152
    """
    return 12 * _nside(nside) ** 2


def npix2nside(npix: SupportsIndex, /) -> int:
    """Return the nside of a map of so many pixels.

    Raises
    ------
    ValueError
        For a number that is not 12 nside².

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.npix2nside(49152)
    64
    """
    count = as_whole(npix, "npix")
    nside = math.isqrt(max(count, 0) // 12)
    if nside < 1 or 12 * nside * nside != count:
        raise ValueError(f"A map has 12 nside² pixels, got {count}.")
    return nside


def nside2pixarea(nside: SupportsIndex, /) -> float:
    """Return the solid angle of each pixel, in steradians.

    Examples
    --------
    >>> from spheremap import healpix
    >>> round(healpix.nside2pixarea(1), 6)
    1.047198
    """
    return 4 * math.pi / nside2npix(nside)


def nside2resol(nside: SupportsIndex, /) -> float:
    """Return the root of a pixel's solid angle, in radians: about the distance between centers.

    Examples
    --------
    >>> from spheremap import healpix
    >>> round(healpix.nside2resol(128), 6)
    0.007995
    """
    return math.sqrt(nside2pixarea(nside))


def boundaries(
    nside: SupportsIndex, pixels: ArrayLike, /, *, step: int = 1, nest: bool = False
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
    n, count = _nside(nside), as_whole(step, "step")
    if not 1 <= count <= MAX_NSIDE:
        raise ValueError(f"`step` must be from 1 to {MAX_NSIDE}, got {count}.")
    centers = pix2vec(n, pixels, nest=nest)
    uv = resolve("healpix").encode(np.nan_to_num(centers, nan=1.0))
    cell = np.floor(uv[..., None, :2] * n)
    share = np.arange(count) / count
    ends = np.array([[1.0, 1], [0, 1], [0, 0], [1, 0]])
    corners = ends[:, None] + share[:, None] * (np.roll(ends, -1, axis=0) - ends)[:, None]
    place = (cell + corners.reshape(-1, 2)) / n
    face = np.broadcast_to(uv[..., None, 2:], (*place.shape[:-1], 1))
    out = resolve("healpix").decode(np.concatenate([place, face], -1))
    return np.asarray(np.where(np.isnan(centers[..., None, :]), np.nan, out))


def reorder(values: ArrayLike, /, *, nest: bool) -> NDArray[Any]:
    """Return a whole map in the other order.

    Parameters
    ----------
    values : array_like, shape (12 * nside², ...)
        A value, or several, for each pixel; nside a power of two.
    nest : bool
        They are in nested order, and become ring order; else the other way round.

    Returns
    -------
    values : ndarray
        Of the same shape and dtype.

    Raises
    ------
    ValueError
        For a length that is not 12 nside², nside a power of two.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap import healpix
    >>> ring = np.arange(48)
    >>> bool((healpix.reorder(healpix.reorder(ring, nest=False), nest=True) == ring).all())
    True
    """
    nest = as_flag(nest, "nest")
    array, nside = _map(values)
    # Where each pixel of the result is in the map.
    source = np.arange(len(array))
    source = ring2nest(nside, source) if nest else nest2ring(nside, source)
    return np.asarray(array[source])


def to_image(values: ArrayLike, /, *, nest: bool = False) -> NDArray[Any]:
    """Return a whole map as an image of the projection ``"healpix"``.

    Parameters
    ----------
    values : array_like, shape (12 * nside²,) or (12 * nside², C)
        A value, or several channels, for each pixel, any nside.
    nest : bool
        They are in nested order; else in ring order.

    Returns
    -------
    image : ndarray, shape (12, nside, nside) or (12, nside, nside, C)
        The twelve faces, for `sample`, `convert` and every other verb. The world of HEALPix has +z
        up: the latlong with north on top and longitude 0 in the middle has axes ``"-y -z +x"``.

    Raises
    ------
    ValueError
        For a length that is not 12 nside².

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> from spheremap import healpix
    >>> z = healpix.pix2vec(16, np.arange(12 * 16**2))[:, 2]
    >>> sky = sm.projection("latlong", axes="-y -z +x")
    >>> picture = sm.convert(healpix.to_image(z), "healpix", sky, size=32)
    >>> picture.shape, bool(picture[0].min() > 0.99)
    ((32, 64), True)
    """
    array, nside = _map(values)
    return np.asarray(array[_pixels_of_faces(nside, nest)])


def from_image(image: ArrayLike, /, *, nest: bool = False) -> NDArray[Any]:
    """Return an image of the projection ``"healpix"`` as a map.

    Parameters
    ----------
    image : array_like, shape (12, nside, nside) or (12, nside, nside, C)
        Twelve faces, as `to_image` makes them.
    nest : bool
        The map shall be in nested order; else in ring order.

    Returns
    -------
    values : ndarray, shape (12 * nside²,) or (12 * nside², C)
        A value, or several channels, for each pixel.

    Raises
    ------
    ValueError
        For another shape.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap import healpix
    >>> values = np.arange(12 * 3**2)
    >>> bool((healpix.from_image(healpix.to_image(values)) == values).all())
    True
    """
    array = np.asarray(image)
    if array.ndim not in (3, 4) or array.shape[0] != 12 or array.shape[1] != array.shape[2]:
        raise ValueError(
            "Expected `image` to have shape (12, nside, nside) or (12, nside, nside, C), "
            f"got {array.shape}."
        )
    nside = _nside(array.shape[1])
    out = np.empty((12 * nside * nside, *array.shape[3:]), array.dtype)
    out[_pixels_of_faces(nside, nest)] = array
    return out


def _pixels_of_faces(nside: int, nest: bool) -> Pixels:
    """Return the pixel of each texel, face by face."""
    centers = (np.arange(nside) + 0.5) / nside
    face, v, u = np.meshgrid(np.arange(12.0), centers, centers, indexing="ij")
    uv = np.stack([u, v, face], -1)
    return vec2pix(nside, resolve("healpix").decode(uv), nest=nest)


def _map(values: ArrayLike) -> tuple[NDArray[Any], int]:
    array = np.asarray(values)
    if array.ndim == 0:
        raise ValueError("Expected `values` to have shape (12 nside², ...), got ().")
    return array, npix2nside(len(array))


def _nside(nside: SupportsIndex) -> int:
    try:
        number = operator.index(nside)
    except TypeError:
        kind = type(nside).__name__
        raise TypeError(f"`nside` must be an integer, got {kind}.") from None
    if not 1 <= number <= MAX_NSIDE:
        raise ValueError(f"`nside` must be from 1 to {MAX_NSIDE}, got {number}.")
    return number


def _real(angle: ArrayLike, name: str) -> NDArray[np.float64]:
    return as_doubles(angle, name)
