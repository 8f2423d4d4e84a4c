"""Labels: numbers of types that filters do not compute in, taken whole or counted.

The core knows five texel types. What is only moved, by ``"nearest"``, is moved as the bits that it
has, in unsigned texels. What is counted, by ``"mode"``, is counted as numbers that the core holds
exactly and that are in the same order, because of equals it takes the smallest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .._arrays import as_array, expect_apart

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["labeled"]

# Of an image, a fill and an `out`.
Verb: TypeAlias = Callable[[Any, Any, Any], Any]


def labeled(
    image: Any, axes: int, filter: object, fill: Any, out: Any, alpha: object, verb: Verb
) -> NDArray[Any] | None:
    """Return what a verb makes of an image of labels, in its own dtype; None of any other image.

    The image has so many axes without its channels.
    """
    array = image if isinstance(image, np.ndarray) else as_array(image, "image")
    kind, width = array.dtype.kind, array.dtype.itemsize
    # uint8 and uint16 are texels as they are.
    if kind not in "biu" or (kind == "u" and width < 4) or array.ndim not in (axes, axes + 1):
        return None
    filter = "bilinear" if filter is None else filter
    if not isinstance(filter, str):
        # What verbs say of it themselves.
        return None
    if filter not in ("nearest", "mode"):
        raise TypeError(
            f"Expected `filter` of an `image` of dtype {array.dtype} to be 'nearest', or 'mode' "
            f"where there is one, as labels are not mixed; got {filter!r}. Filters that mix take "
            "uint8, uint16, float16, float32 and float64."
        )
    if alpha is not None:
        raise ValueError("Labels have no opacity: `alpha` goes with filters that mix.")
    dtype = array.dtype.newbyteorder("=")
    texels = np.ascontiguousarray(array, dtype)
    is_gray = array.ndim == axes
    if is_gray:
        texels = texels[..., None]
    filling = np.ascontiguousarray(_filling(fill, dtype, texels.shape[-1:]))
    into = None
    if out is not None:
        expect_apart(array, out)
        into = _checked(out, dtype)[..., None] if is_gray else _checked(out, dtype)
    found = (_moved if filter == "nearest" else _counted)(texels, filling, into, verb)
    if out is not None:
        return out  # type: ignore[no-any-return]
    return found[..., 0] if is_gray else found


def _moved(
    texels: NDArray[Any], fill: NDArray[Any], out: NDArray[Any] | None, verb: Verb
) -> NDArray[Any]:
    """Return what a verb makes of the bits: a wide number is several channels of 16."""
    part = np.uint8 if texels.dtype.itemsize == 1 else np.uint16
    into = None if out is None else out.view(part)
    found: NDArray[Any] = verb(texels.view(part), fill.view(part).tolist(), into)
    return found.view(texels.dtype)


def _counted(
    texels: NDArray[Any], fill: NDArray[Any], out: NDArray[Any] | None, verb: Verb
) -> NDArray[Any]:
    """Return what a verb makes of numbers in the place of labels."""
    dtype = texels.dtype
    found: NDArray[Any]
    if dtype.itemsize <= 2:
        unsigned = np.dtype(f"u{dtype.itemsize}")
        # With the sign turned around, negative numbers are the smaller ones.
        sign = unsigned.type(1 << (8 * dtype.itemsize - 1) if dtype.kind == "i" else 0)
        codes = verb(texels.view(unsigned) ^ sign, (fill.view(unsigned) ^ sign).tolist(), None)
        found = (codes ^ sign).view(dtype)
    elif dtype.itemsize == 4:
        found = verb(texels.astype(np.float64), fill.tolist(), None).astype(dtype)
    else:
        # No float holds them all: each is its place among those that there are.
        known = np.unique(np.concatenate([texels.ravel(), fill]))
        places = np.searchsorted(known, texels).astype(np.float64)
        codes = verb(places, np.searchsorted(known, fill).tolist(), None)
        found = known[codes.astype(np.intp)]
    if out is not None:
        if out.shape != found.shape:
            raise ValueError(f"Expected `out` to have shape {found.shape}, got {out.shape}.")
        out[...] = found
    return found


def _filling(fill: Any, dtype: np.dtype[Any], channels: tuple[int, ...]) -> NDArray[Any]:
    """Return what is outside as labels, one a channel."""
    given = as_array(fill, "fill")
    if given.dtype.kind not in "biuf":
        raise TypeError(f"Expected `fill` to be a number or one number a channel, got {fill!r}.")
    with np.errstate(invalid="ignore"):
        found = given.astype(dtype)
    if not np.array_equal(found, given):
        raise ValueError(f"Expected `fill` to be of dtype {dtype}, as the labels, got {fill!r}.")
    if given.shape not in ((), channels):
        raise ValueError(f"Expected `fill` to be one number or {channels[0]}, got {fill!r}.")
    return np.broadcast_to(found, channels)


def _checked(out: object, dtype: np.dtype[Any]) -> NDArray[Any]:
    if not isinstance(out, np.ndarray) or out.dtype != dtype:
        got = getattr(out, "dtype", type(out).__name__)
        raise TypeError(f"Expected `out` to be an array of {dtype}, got {got}.")
    if not (out.flags.c_contiguous and out.flags.writeable):
        raise ValueError("Expected `out` to be C-contiguous and writable.")
    return out
