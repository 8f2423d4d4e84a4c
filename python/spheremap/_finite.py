"""Texels that are no light: NaN, infinite and negative ones, told by number and place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ._arrays import as_image

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

# How many places a message names.
_PLACES = 3


def checked_image(
    image: ArrayLike,
    *,
    name: str = "image",
    skipna: bool = False,
    negative: Literal["keep", "raise"] = "keep",
) -> NDArray[Any]:
    """Return the image as a contiguous array of a supported dtype in which every value is finite.

    NaN and infinite values raise ValueError with their number and first places, or become 0 with
    `skipna`. So do negative ones where `negative` is "raise". The array given is never changed.
    """
    array = as_image(image, None)
    if array.dtype.kind != "f":
        return array
    # One pass and no mask of the image's size where all is well: a sum is finite only if every
    # value is. One that overflows merely asks for the closer look.
    with np.errstate(all="ignore"):
        suspicious = not np.isfinite(array.sum(dtype=np.float64))
    if suspicious:
        bad = ~np.isfinite(array)
        if bad.any():
            if not skipna:
                raise ValueError(
                    f"`{name}` has {_described(bad, 'NaN or infinite')}; "
                    "`skipna=True` counts them as 0."
                )
            array = np.where(bad, array.dtype.type(0), array)
    if negative == "raise" and array.size and array.min() < 0:
        raise ValueError(f"`{name}` has {_described(array < 0, 'negative')}.")
    return array


def _described(bad: NDArray[np.bool_], what: str) -> str:
    count = int(np.count_nonzero(bad))
    places = [
        str(tuple(int(i) for i in np.unravel_index(flat, bad.shape)))
        for flat in np.flatnonzero(bad)[:_PLACES]
    ]
    more = ", ..." if count > _PLACES else ""
    noun = "value" if count == 1 else "values"
    return f"{count} {what} {noun}, at {', '.join(places)}{more}"
