"""Parts of images: which texels are asked for."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

__all__ = ["Window", "stored_part"]

Window: TypeAlias = tuple[slice, slice] | tuple[slice, slice, int]


def stored_part(window: Window, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return the first row, the one after the last, and so the columns, of an image of this shape.

    Rows of faces follow each other.
    """
    *faces, rows, columns = shape
    wanted = "(rows, columns)" if not faces else "(rows, columns, face)"
    if not isinstance(window, tuple) or len(window) != len(shape):
        raise TypeError(
            f"Expected `window` to be {wanted} for an image of shape {shape}, got {window!r}."
        )
    top, bottom = _range(window[0], rows, "rows")
    left, right = _range(window[1], columns, "columns")
    if not faces:
        return top, bottom, left, right
    face = window[2]  # type: ignore[misc]
    if isinstance(face, bool) or not isinstance(face, int | np.integer):
        raise TypeError(f"Expected the face of `window` to be a whole number, got {face!r}.")
    if not -faces[0] <= face < faces[0]:
        raise ValueError(f"Expected the face of `window` to be below {faces[0]}, got {face}.")
    first = int(face) % faces[0] * rows
    return first + top, first + bottom, left, right


def _range(part: object, length: int, name: str) -> tuple[int, int]:
    """Return where a slice begins and ends, as indexing has it."""
    if not isinstance(part, slice):
        raise TypeError(f"Expected the {name} of `window` to be a slice, got {part!r}.")
    try:
        start, stop, step = part.indices(length)
    except (TypeError, ValueError) as error:
        raise TypeError(f"Expected the {name} of `window` to be a slice, got {part!r}.") from error
    if step != 1:
        raise ValueError(f"Expected the {name} of `window` to follow each other, got {part!r}.")
    return start, max(start, stop)
