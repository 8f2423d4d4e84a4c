"""Texels that are no light: NaN, infinities and, where a density is wanted, negative numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SHOWN = 3


def checked_image(
    image: NDArray[Any],
    *,
    name: str = "image",
    skipna: bool = False,
    negative: Literal["keep", "raise"] = "keep",
) -> NDArray[Any]:
    """Return `image` if all of its numbers are finite, else raise; `skipna` puts 0 for the others.

    The error counts them and names the first positions. With ``negative="raise"`` the same goes for
    negative numbers.
    """
    if image.dtype.kind != "f":
        return image
    unfit = ~np.isfinite(image)
    if unfit.any():
        if not skipna:
            raise ValueError(
                f"Expected `{name}` to be finite: {_described(unfit, image, 'NaN or infinite')}; "
                "`skipna=True` takes them for 0."
            )
        image = np.where(unfit, image.dtype.type(0), image)
    if negative == "raise":
        unfit = image < 0
        if unfit.any():
            raise ValueError(
                f"Expected `{name}` not to be negative: {_described(unfit, image, 'negative')}; "
                "np.maximum(image, 0) takes them for 0."
            )
    return image


def _described(unfit: NDArray[np.bool_], image: NDArray[Any], what: str) -> str:
    count = int(np.count_nonzero(unfit))
    first = np.argwhere(unfit)[:_SHOWN]
    shown = ", ".join(f"{image[tuple(p)]:g} at {tuple(p.tolist())}" for p in first)
    numbers = "number" if count == 1 else "numbers"
    more = ", ..." if count > _SHOWN else ""
    return f"{count} {what} {numbers} ({shown}{more})"
