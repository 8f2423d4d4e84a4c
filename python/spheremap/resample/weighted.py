"""Lookups in which texels have weights of their own: alpha, and NaN that counts for nothing.

A weighted mean is the quotient of two plain ones: of the values times their weights, and of the
weights. So every filter can have weights, and knows its seams as without.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

__all__ = ["weighted"]

# Filters with negative weights: a quotient of two such sums may be anything.
_RINGING = frozenset({"bicubic", "catmull-rom", "mitchell", "lanczos3"})


class Look(Protocol):
    """A lookup in an image that gives NaN where the image holds nothing."""

    def __call__(self, image: NDArray[Any], filter: str, /) -> NDArray[Any]: ...


def weighted(
    image: ArrayLike,
    look: Look,
    *,
    spatial: int,
    filter: str,
    alpha: int | None,
    skipna: bool,
    fill: float | Sequence[float],
    out: NDArray[Any] | None,
) -> NDArray[Any]:
    """Return what `look` shows of an image whose texels have weights.

    `spatial` is the number of axes of the image before its channels.
    """
    pixels = np.asanyarray(image)
    dtype = pixels.dtype.newbyteorder("=")
    values = pixels.astype(np.float64 if dtype.itemsize == 8 else np.float32)
    flat = values.ndim == spatial
    if flat:
        values = values[..., None]
    weights = np.ones_like(values)
    if skipna:
        held = ~np.isnan(values)
        weights[~held] = 0
        values = np.where(held, values, 0)
    if alpha is not None:
        channel = _channel(alpha, values.shape, spatial)
        opacity = values[..., channel] * weights[..., channel]
        others = [c for c in range(values.shape[-1]) if c != channel]
        weights[..., others] *= opacity[..., None]
    result, share = _quotient(values, weights, look, filter)
    if skipna and filter in _RINGING:
        # Beside a hole, from the nearest texels alone.
        near, _ = _quotient(values, weights, look, "bilinear")
        touched = share != 1 if alpha is None else share[..., [channel]] != 1
        result = np.where(touched, near, result)
    outside = np.isnan(share)
    if alpha is not None:
        # What is transparent has no color; black is as good as any, and is not NaN.
        result[..., others] = np.where(share[..., others] > 0, result[..., others], 0)
        if skipna:
            result[np.broadcast_to(share[..., [channel]] <= 0, result.shape)] = np.nan
    result[outside] = np.broadcast_to(fill, result.shape)[outside]
    if flat:
        result = result[..., 0]
    return _stored(result, dtype, out)


def _quotient(
    values: NDArray[Any], weights: NDArray[Any], look: Look, filter: str
) -> tuple[NDArray[Any], NDArray[Any]]:
    product = np.where(weights == 0, 0, values * weights)
    both = look(np.ascontiguousarray(np.concatenate([product, weights], axis=-1)), filter)
    total, share = np.split(both, 2, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(share == 0, np.nan, total / share), share


def _channel(alpha: int, shape: tuple[int, ...], spatial: int) -> int:
    if len(shape) != spatial + 1 or not -shape[-1] <= alpha < shape[-1] or shape[-1] < 2:
        raise ValueError(
            f"Expected `alpha` to be the number of one of at least 2 channels, got {alpha} "
            f"for an image of shape {shape}."
        )
    return alpha % shape[-1]


def _stored(result: NDArray[Any], dtype: np.dtype[Any], out: NDArray[Any] | None) -> NDArray[Any]:
    if dtype.kind in "iu":
        largest = np.iinfo(dtype).max
        result = np.clip(np.rint(np.nan_to_num(result)), 0, largest)
    if out is None:
        return result.astype(dtype)
    if not isinstance(out, np.ndarray) or out.shape != result.shape or out.dtype != dtype:
        got = f"{out.dtype} {out.shape}" if isinstance(out, np.ndarray) else type(out).__name__
        raise ValueError(f"Expected `out` to be {dtype} of shape {result.shape}, got {got}.")
    if not out.flags.writeable:
        raise ValueError("Expected `out` to be writable.")
    out[...] = result
    return out
