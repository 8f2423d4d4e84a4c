"""Whole maps: in the other order, as images, with other pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .._arrays import as_array, expect_room
from .._scalars import as_flag, as_text
from .numbers import as_nside, npix2nside

if TYPE_CHECKING:
    from typing import SupportsIndex

    from numpy.typing import ArrayLike, NDArray


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
    array, nside = _map(values)
    out = _arranged(array, nside, was, becomes)
    if isinstance(values, np.ma.MaskedArray):
        mask = _arranged(np.ma.getmaskarray(values), nside, was, becomes)
        return np.ma.masked_array(out, mask)
    return out


def to_image(values: ArrayLike, /, nest: bool = False) -> NDArray[Any]:
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
        The twelve faces, for `sample`, `convert` and every other verb; NaN where values are masked,
        or healpy's ``UNSEEN``. ``convert(..., skipna=True)`` gives those no weight. The world of
        HEALPix has +z up, which ``"healpix:healpy"`` says.

    Raises
    ------
    ValueError
        For a length that is not 12 nside².
    TypeError
        For masked integers, among which there is no NaN.

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
    """
    nest = as_flag(nest, "nest")
    array, nside = _map(_filled(values))
    return _faces(array, nside, nest)


def from_image(image: ArrayLike, /, nest: bool = False) -> NDArray[Any]:
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
        A value, or several channels, for each pixel. NaN stays NaN; healpy's functions want
        ``np.where(np.isnan(values), healpy.UNSEEN, values)``.

    Raises
    ------
    ValueError
        For another shape.
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
    array = as_array(_filled(image), "image")
    if array.ndim not in (3, 4) or array.shape[0] != 12 or array.shape[1] != array.shape[2]:
        raise ValueError(
            "Expected `image` to have shape (12, nside, nside) or (12, nside, nside, C), "
            f"got {array.shape}."
        )
    nside = as_nside(array.shape[1])
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
        For a length that is not 12 n², an `nside` that is neither divisor nor multiple, and shares
        of integers.
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
    array, n = _map(_filled(values))
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
            sum_ = row.sum(axis=(0, 2), dtype=sums)
            into[...] = sum_ if total else _rounded(sum_, times**2)
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


def _rounded(sums: NDArray[Any], count: int) -> NDArray[Any]:
    """Return quotients of integers rounded to the nearest, halves to even, exactly."""
    whole, rest = np.divmod(sums, count)
    up = (2 * rest > count) | ((2 * rest == count) & (whole % 2 == 1))
    return np.asarray(whole + up.astype(whole.dtype))


def _order(nest: bool) -> str:
    return "nested" if nest else "ring"


def _faces(array: NDArray[Any], nside: int, nest: bool) -> NDArray[Any]:
    unseen = array.dtype.kind == "f" and array.dtype.itemsize in (4, 8)
    faces = _arranged(array, nside, _order(nest), "faces", unseen=unseen)
    return faces.reshape(12, nside, nside, *array.shape[1:])


def _filled(values: ArrayLike) -> ArrayLike:
    """Return masked floats with NaN for what is masked."""
    if not isinstance(values, np.ma.MaskedArray) or not np.ma.is_masked(values):
        return values
    if values.dtype.kind != "f":
        raise TypeError(
            f"Masked values of dtype {values.dtype} have no NaN to become: pass floats "
            "(`values.astype(float)`) or what stands for them (`values.filled(...)`)."
        )
    return values.filled(np.nan)


def _map(values: ArrayLike) -> tuple[NDArray[Any], int]:
    array = as_array(values, "values")
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
