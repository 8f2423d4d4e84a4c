"""Parts of the sky: the numbers of some pixels with a value for each, and maps that hold them.

It is how healpy writes a map of a part (``write_map(..., partial=True)``, "explicit indexing").
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import BLOCK, expect_room
from .._scalars import as_number
from .maps import UNSEEN, as_map, as_part, is_unseen
from .numbers import as_nside, nside2npix

if TYPE_CHECKING:
    from typing import SupportsIndex

    from numpy.typing import ArrayLike, NDArray

    from .numbers import Pixels


def whole_map(
    nside: SupportsIndex,
    pixels: ArrayLike,
    values: ArrayLike,
    /,
    *,
    unseen: float = UNSEEN,
) -> NDArray[Any]:
    """Return the whole map of which some pixels are seen.

    Parameters
    ----------
    nside : int
        Pixels along the side of a face, 1 to 2²⁹.
    pixels : array_like of int, shape (K,)
        Their numbers, each once, in any order; ring or nested, as the map shall be.
    values : array_like, shape (K, ...)
        A value, or several, for each.
    unseen : float
        What all other pixels have: by default what healpy's ``UNSEEN`` is. It is missing to every
        function here, as NaN is.

    Returns
    -------
    values : ndarray, shape (12 * nside², ...), of the dtype of `values`
        Of a masked array, one in which the other pixels are masked.

    Raises
    ------
    ValueError
        For an `nside` that does not exist, pixels that it does not have or that come twice, and
        another number of values.
    TypeError
        For pixels that are no integers, and a dtype that does not hold `unseen`.

    See Also
    --------
    seen_pixels : The way back.
    to_image : Of a part without its whole map.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.whole_map(1, [4, 7], [0.5, 2.0]).tolist()[3:6]
    [-1.6375e+30, 0.5, -1.6375e+30]
    >>> pixels, values = healpix.seen_pixels(healpix.whole_map(1, [4, 7], [0.5, 2.0]))
    >>> pixels.tolist(), values.tolist()
    ([4, 7], [0.5, 2.0])
    """
    n = as_nside(nside)
    numbers, array = as_part(n, pixels, values)
    rest = as_number(unseen, "unseen")
    # Beyond float16 there is infinity; NaN is any integer.
    with np.errstate(all="ignore"):
        held = np.array(rest).astype(array.dtype)
    kind = array.dtype.kind
    is_held = kind in "fc" and np.isfinite(held) == np.isfinite(rest)
    if not (is_held or (kind in "biu" and held.item() == rest)):
        raise TypeError(
            f"Values of dtype {array.dtype} do not hold {rest:g}, what is not seen: pass floats "
            "(`values.astype(float)`) or another `unseen`."
        )
    shape = (nside2npix(n), *array.shape[1:])
    expect_room(shape, array.dtype)
    out = np.full(shape, held)
    out[numbers] = array
    if isinstance(values, np.ma.MaskedArray):
        mask = np.ones(shape, np.bool_)
        mask[numbers] = np.ma.getmaskarray(values)
        return np.ma.masked_array(out, mask)
    return out


def seen_pixels(values: ArrayLike, /) -> tuple[Pixels, NDArray[Any]]:
    """Return the pixels of a whole map that are seen, and what they have.

    Parameters
    ----------
    values : array_like, shape (12 * nside², ...)
        A value, or several, for each pixel, in either order.

    Returns
    -------
    pixels : ndarray of int64, shape (K,)
        In ascending order, those with a value that is neither NaN nor healpy's ``UNSEEN`` nor
        masked.
    values : ndarray, shape (K, ...), of the dtype of `values`
        Theirs; of a masked array, one.

    Raises
    ------
    ValueError
        For a length that is not 12 nside².

    See Also
    --------
    whole_map : The way back.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap import healpix
    >>> pixels, values = healpix.seen_pixels(np.where(np.arange(48) % 20 == 7, 1.5, np.nan))
    >>> pixels.tolist(), values.tolist()
    ([7, 27, 47], [1.5, 1.5, 1.5])
    """
    array, _ = as_map(values)
    given: NDArray[Any] = values if isinstance(values, np.ma.MaskedArray) else array
    found = []
    # Piece by piece: a whole map is large.
    for first in range(0, len(array), BLOCK):
        piece = slice(first, first + BLOCK)
        known = ~is_unseen(array[piece]) & ~np.ma.getmaskarray(given[piece])
        found.append(first + np.flatnonzero(known.reshape(len(known), -1).any(axis=1)))
    pixels = np.concatenate(found).astype(np.int64, copy=False)
    return pixels, given[pixels]
