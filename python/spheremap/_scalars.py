"""Numbers, words and flags of what callers give, checked once.

Each says which argument is wrong, what was expected and what came, where Python's own conversions
name neither or let too much through.
"""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator


def as_number(value: object, name: str) -> float:
    """Return a real number as a float; NaN and infinity are numbers here."""
    if isinstance(value, np.ndarray | np.generic):
        fits = value is not np.ma.masked and value.ndim == 0 and value.dtype.kind in "fiub"
    else:
        fits = hasattr(type(value), "__float__") or hasattr(type(value), "__index__")
    if not fits:
        raise TypeError(f"Expected `{name}` to be a number, got {kind_of(value)}.")
    try:
        return float(value)  # type: ignore[arg-type]
    except OverflowError:
        raise ValueError(f"Expected `{name}` to be a number that a float can hold.") from None


def as_whole(value: object, name: str) -> int:
    """Return a whole number as an int; a bool is none, though Python counts with it."""
    try:
        if not isinstance(value, bool):
            return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        pass
    raise TypeError(f"Expected `{name}` to be a whole number, got {kind_of(value)}.")


def as_flag(value: object, name: str) -> bool:
    """Return a bool."""
    if isinstance(value, bool):
        return value
    if not isinstance(value, np.bool_):
        raise TypeError(f"Expected `{name}` to be a bool, got {kind_of(value)}.")
    return bool(value)


def as_text(value: object, name: str) -> str:
    """Return a str."""
    if not isinstance(value, str):
        raise TypeError(f"Expected `{name}` to be a str, got {kind_of(value)}.")
    return value


def as_items(value: Any, name: str, of: str) -> Iterator[Any]:
    """Return an iterator over a sequence of something."""
    try:
        return iter(value)
    # Views of memory with several axes are not there yet, in their words.
    except (TypeError, NotImplementedError):
        raise TypeError(
            f"Expected `{name}` to be a sequence of {of}, got {kind_of(value)}."
        ) from None


def as_float_dtype(value: Any) -> np.dtype[Any]:
    """Return float32 or float64."""
    try:
        dtype: np.dtype[Any] = np.dtype(value)
    except TypeError:
        raise TypeError(f"Expected `dtype` to be float32 or float64, got {value!r:.40}.") from None
    if dtype not in (np.float32, np.float64):
        raise TypeError(f"Expected `dtype` to be float32 or float64, got {dtype}.")
    return dtype


def kind_of(value: object) -> str:
    """Return what a value is, for a message."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and dtype {value.dtype}"
    return type(value).__name__
