"""Whole maps: in the other order, as images, with other pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .._arrays import as_array, as_integers, expect_room
from .._scalars import as_flag, as_text
from .numbers import as_nside, cells, npix2nside, nside2npix

if TYPE_CHECKING:
    from typing import SupportsIndex

    from numpy.typing import ArrayLike, NDArray

# What healpy has where nothing was seen.
UNSEEN = -1.6375e30


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
        Of the same shape and dtype; of a masked array, one.

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
    was, becomes = ("nested", "ring") if as_flag(nest, "nest") else ("ring", "nested")
    array, nside = as_map(values)
    out = _arranged(array, nside, was, becomes)
    if isinstance(values, np.ma.MaskedArray):
        mask = _arranged(np.ma.getmaskarray(values), nside, was, becomes)
        return np.ma.masked_array(out, mask)
    return out


def to_image(
    values: ArrayLike,
    /,
    nest: bool = False,
    *,
    pixels: ArrayLike | None = None,
    nside: SupportsIndex | None = None,
) -> NDArray[Any]:
    """Return a map, or a part of one, as an image of the projection ``"healpix"``.

    Parameters
    ----------
    values : array_like, shape (12 * nside²,) or (12 * nside², C)
        A value, or several channels, for each pixel, any nside. With `pixels`, of shape (K,) or
        (K, C).
    nest : bool
        They are in nested order; else in ring order.
    pixels : array_like of int, shape (K,), optional
        The numbers of the pixels that are seen, where the values are those of a part of the sky.
    nside : int, optional
        That of a part; a whole map has one by its length.

    Returns
    -------
    image : ndarray, shape (12, nside, nside) or (12, nside, nside, C)
        The twelve faces, for `sample`, `convert` and every other verb; NaN where values are masked,
        or healpy's ``UNSEEN``. ``convert(..., skipna=True)`` gives those no weight. The world of
        HEALPix has +z up, which ``"healpix:healpy"`` says.

    Raises
    ------
    ValueError
        For a length that is not 12 nside²; for a part as for `whole_map`.
    TypeError
        For masked integers, and those of a part: there is no NaN among them.

    Notes
    -----
    It takes the memory of the map and of the image, and no more.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> from spheremap import healpix
    >>> z = healpix.pix2vec(16, np.arange(12 * 16**2))[:, 2]
    >>> picture = sm.convert(healpix.to_image(z), "healpix:healpy", "latlong", size=32)
    >>> picture.shape, bool(picture[0].min() > 0.99)
    ((32, 64), True)

    Of a part of the sky, as in a file of explicit indexing:

    >>> disc = healpix.query_disc(16, [0, 0, 1], 0.4)
    >>> image = healpix.to_image(np.ones(len(disc)), pixels=disc, nside=16)
    >>> int((image == 1).sum()) == len(disc), int(np.isnan(image).sum()) + len(disc)
    (True, 3072)
    """
    nest = as_flag(nest, "nest")
    if pixels is None:
        if nside is not None:
            raise TypeError("`nside` is that of `pixels`: a whole map has one by its length.")
        array, n = as_map(as_array(values, "values"))
        return _faces(array, n, nest)
    if nside is None:
        raise TypeError("Expected the `nside` of `pixels`.")
    n = as_nside(nside)
    numbers, array = as_part(n, pixels, as_array(values, "values"))
    if array.dtype.kind not in "fc":
        raise TypeError(
            f"Values of dtype {array.dtype} have no NaN for what is not seen: pass floats "
            "(`values.astype(float)`)."
        )
    shape = (12, n, n, *array.shape[1:])
    expect_room(shape, array.dtype)
    image = np.full(shape, np.nan, array.dtype)
    image[_places(n, numbers, nest)] = np.where(is_unseen(array), array.dtype.type(np.nan), array)
    return image


def from_image(
    image: ArrayLike, /, nest: bool = False, *, pixels: ArrayLike | None = None
) -> NDArray[Any]:
    """Return an image of the projection ``"healpix"`` as a map, or a part of it.

    Parameters
    ----------
    image : array_like, shape (12, nside, nside) or (12, nside, nside, C)
        Twelve faces, as `to_image` makes them.
    nest : bool
        The map shall be in nested order; else in ring order.
    pixels : array_like of int, shape (K,), optional
        The numbers of the only pixels that are wanted, in that order.

    Returns
    -------
    values : ndarray, shape (12 * nside²,) or (12 * nside², C)
        A value, or several channels, for each pixel; with `pixels` of shape (K,) or (K, C). NaN
        stays NaN; healpy's functions want ``np.where(np.isnan(values), healpy.UNSEEN, values)``.

    Raises
    ------
    ValueError
        For another shape, or a number that no pixel has.
    TypeError
        As for `to_image`.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap import healpix
    >>> values = np.arange(12 * 3**2)
    >>> bool((healpix.from_image(healpix.to_image(values)) == values).all())
    True
    """
    nest = as_flag(nest, "nest")
    array = as_array(image, "image")
    if array.ndim not in (3, 4) or array.shape[0] != 12 or array.shape[1] != array.shape[2]:
        raise ValueError(
            "Expected `image` to have shape (12, nside, nside) or (12, nside, nside, C), "
            f"got {array.shape}."
        )
    nside = as_nside(array.shape[1])
    if pixels is not None:
        return np.asarray(array[_places(nside, as_pixels(nside, pixels), nest)])
    flat = array.reshape(12 * nside * nside, *array.shape[3:])
    return _arranged(flat, nside, "faces", _order(nest))


def ud_grade(
    values: ArrayLike,
    nside: SupportsIndex,
    /,
    nest: bool = False,
    *,
    statistic: Literal["mean", "sum"] = "mean",
    pess: bool = False,
) -> NDArray[Any]:
    """Return a whole map with larger or smaller pixels.

    Parameters
    ----------
    values : array_like, shape (12 * n²,) or (12 * n², C)
        A value, or several, for each pixel.
    nside : int
        Of the result: a divisor of n, or a multiple.
    nest : bool
        The map is in nested order, and so is the result; else both are in ring order.
    statistic : {"mean", "sum"}
        What a larger pixel has of those in it, all of which have the same area: their mean, for
        brightness and temperature, or their sum, for counts. A smaller pixel has the value of the
        one that it lies in, or its share of that.
    pess : bool
        A pixel is missing if one of those in it is; else if all of them are.

    Returns
    -------
    values : ndarray, shape (12 * nside²,) or (12 * nside², C)
        Of floats in their dtype, NaN where missing; of a masked array, one. Means of integers are
        rounded once, halves to even, and keep the dtype; sums of them are int64 or uint64.

    Raises
    ------
    ValueError
        For a length that is not 12 n², an `nside` that is neither divisor nor multiple, shares of
        integers, and sums that their dtype does not hold.
    TypeError
        For values that are not real numbers, and for masked integers.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap import healpix
    >>> counts = np.arange(48)
    >>> healpix.ud_grade(counts, 1, nest=True, statistic="sum").tolist()[:3]
    [6, 22, 38]
    >>> healpix.ud_grade(counts, 1, nest=True).tolist()[:3]
    [2, 6, 10]
    """
    nest, pess = as_flag(nest, "nest"), as_flag(pess, "pess")
    if as_text(statistic, "statistic") not in ("mean", "sum"):
        raise ValueError(f"`statistic` must be 'mean' or 'sum', got {statistic!r:.40}.")
    array, n = as_map(as_array(values, "values"))
    if array.dtype.kind not in "fiub":
        raise TypeError(f"Expected `values` to be real numbers, got dtype {array.dtype}.")
    m = as_nside(nside)
    if n % m and m % n:
        raise ValueError(f"`nside` must be a divisor or a multiple of {n}, got {m}.")
    total = statistic == "sum"
    if array.dtype.kind == "b":
        array = array.astype(np.int64 if total else np.float64)
    faces = _faces(array, n, nest)
    graded = _finer(faces, m // n, total) if m > n else _coarser(faces, n // m, total, pess)
    out = _arranged(graded.reshape(12 * m * m, *array.shape[1:]), m, "faces", _order(nest))
    if isinstance(values, np.ma.MaskedArray):
        return np.ma.masked_array(out, np.isnan(out) if out.dtype.kind == "f" else False)
    return out


def _finer(faces: NDArray[Any], times: int, total: bool) -> NDArray[Any]:
    if total and faces.dtype.kind != "f":
        raise ValueError("Shares of integers are no integers: pass floats for smaller pixels.")
    _, n, _, *rest = faces.shape
    shares = faces / faces.dtype.type(times**2) if total else faces
    whole = (12, n, times, n, times, *rest)
    expect_room(whole, faces.dtype)
    return np.broadcast_to(shares[:, :, None, :, None], whole)


def _coarser(faces: NDArray[Any], times: int, total: bool, pess: bool) -> NDArray[Any]:
    _, n, _, *rest = faces.shape
    m = n // times
    dtype, kind = faces.dtype, faces.dtype.kind
    sums = dtype if kind == "f" else np.dtype(np.uint64 if kind == "u" else np.int64)
    out = np.empty((12, m, m, *rest), sums if total else dtype)
    # A row of large pixels at a time: no copy of the map.
    rows = faces.reshape(12 * m, times, m, times, *rest)
    for row, into in zip(rows, out.reshape(12 * m, m, *rest), strict=True):
        if kind == "f":
            into[...] = _of_floats(row, total, pess)
        else:
            into[...] = _of_integers(row, total, sums)
    return out


def _of_floats(row: NDArray[Any], total: bool, pess: bool) -> NDArray[Any]:
    with np.errstate(invalid="ignore", over="ignore"):
        sums = row.sum(axis=(0, 2), dtype=np.float64)
        if np.isnan(sums).any():
            known = ~np.isnan(row)
            count = known.sum(axis=(0, 2))
            sums = np.where(known, row, 0).sum(axis=(0, 2), dtype=np.float64)
            missing = count < (row.shape[0] * row.shape[2] if pess else 1)
            sums = np.where(missing, np.nan, sums)
            return np.asarray(sums if total else sums / np.maximum(count, 1))
        return np.asarray(sums if total else sums / (row.shape[0] * row.shape[2]))


def _of_integers(row: NDArray[Any], total: bool, sums: np.dtype[Any]) -> NDArray[Any]:
    """Return sums, or means rounded to the nearest, halves to even, exactly."""
    count = sums.type(row.shape[0] * row.shape[2])
    found = row.sum(axis=(0, 2), dtype=sums)
    whole, rest = np.divmod(found, count)
    largest = max(-int(row.min(initial=0)), int(row.max(initial=0)))
    if largest * int(count) > np.iinfo(sums).max:
        # Sums may leave the dtype. Means do not: of each number there is a quotient and a rest.
        parts = row // count
        over = (row - parts * count).sum(axis=(0, 2), dtype=sums)
        quotient = parts.sum(axis=(0, 2), dtype=sums) + over // count
        if total and (quotient != whole).any():
            raise ValueError(f"Sums of `values` do not fit in {sums}: pass floats.")
        whole, rest = quotient, over % count
    if total:
        return np.asarray(found)
    up = (2 * rest > count) | ((2 * rest == count) & (whole % 2 == 1))
    return np.asarray(whole + up.astype(whole.dtype))


def _order(nest: bool) -> str:
    return "nested" if nest else "ring"


def _faces(array: NDArray[Any], nside: int, nest: bool) -> NDArray[Any]:
    unseen = array.dtype.kind == "f" and array.dtype.itemsize in (4, 8)
    faces = _arranged(array, nside, _order(nest), "faces", unseen=unseen)
    return faces.reshape(12, nside, nside, *array.shape[1:])


def _data(values: ArrayLike) -> ArrayLike:
    """Return what lies under a mask as well: of maps of labels the mask goes along by itself."""
    return values.data if isinstance(values, np.ma.MaskedArray) else values


def as_map(values: ArrayLike) -> tuple[NDArray[Any], int]:
    """Return a whole map as an array, and its nside, or raise."""
    array = as_array(_data(values), "values")
    if array.ndim == 0:
        raise ValueError("Expected `values` to have shape (12 nside², ...), got ().")
    try:
        return array, npix2nside(len(array))
    except ValueError:
        if array.ndim != 2 or not _is_map(array.shape[1]):
            raise
    raise ValueError(
        f"Expected `values` to have shape (12 nside², C), got {array.shape}: channels come last "
        "here, so pass `values.T`."
    )


def as_pixels(nside: int, pixels: ArrayLike) -> NDArray[np.int64]:
    """Return the numbers of pixels, (K,), or raise where there is no such pixel."""
    numbers = as_integers(pixels, "pixels")
    if numbers.ndim != 1:
        raise ValueError(f"Expected `pixels` to have shape (K,), got {numbers.shape}.")
    count = nside2npix(nside)
    wrong = (numbers < 0) | (numbers >= count)
    if wrong.any():
        raise ValueError(
            f"Pixels of nside {nside} have numbers from 0 to {count - 1}, got "
            f"{np.asarray(pixels)[wrong][0]}."
        )
    return numbers


def as_part(
    nside: int, pixels: ArrayLike, values: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[Any]]:
    """Return the numbers of pixels, each once, and as many values in native byte order."""
    numbers, array = as_pixels(nside, pixels), as_array(_data(values), "values")
    if array.shape[:1] != numbers.shape:
        raise ValueError(
            f"Expected `values` to have shape ({len(numbers)}, ...), one for each of `pixels`, "
            f"got {array.shape}."
        )
    found, times = np.unique(numbers, return_counts=True)
    if len(found) != len(numbers):
        raise ValueError(f"Expected each pixel once, got {found[times > 1][0]} twice.")
    return numbers, array.astype(array.dtype.newbyteorder("="), copy=False)


def is_unseen(array: NDArray[Any]) -> NDArray[np.bool_]:
    """Tell what is NaN, or what healpy takes for ``UNSEEN``."""
    if array.dtype.kind not in "fc":
        return np.zeros(array.shape, np.bool_)
    # The core's rule, and healpy's: the mark may have been through float32.
    with np.errstate(all="ignore"):
        return np.asarray(np.isnan(array) | (np.abs(array - UNSEEN) <= -1e-5 * UNSEEN))


def _places(nside: int, pixels: NDArray[np.int64], nest: bool) -> tuple[NDArray[np.intp], ...]:
    """Return where pixels are in an image: their faces, rows and columns."""
    face, cell, _ = cells(nside, pixels, nest)
    return face.astype(np.intp), cell[:, 1].astype(np.intp), cell[:, 0].astype(np.intp)


def _is_map(count: int) -> bool:
    try:
        return bool(npix2nside(count))
    except ValueError:
        return False


def _arranged(
    array: NDArray[Any], nside: int, was: str, becomes: str, *, unseen: bool = False
) -> NDArray[Any]:
    """Return a map in another arrangement, with NaN for ``UNSEEN`` if that is asked for."""
    dtype = array.dtype.newbyteorder("=") if unseen else array.dtype
    if dtype.hasobject or not array.nbytes:
        numbers = _arranged(np.arange(len(array)), nside, was, becomes)
        return np.asarray(array[numbers])
    expect_room(array.shape, dtype)
    array = np.require(array, dtype, "C")
    out = np.empty(array.shape, dtype)
    _core.healpix_arrange(
        nside,
        array.nbytes // len(array),
        array.reshape(-1).view(np.uint8),
        was,
        out.reshape(-1).view(np.uint8),
        becomes,
        dtype.itemsize if unseen else 0,
    )
    return out
