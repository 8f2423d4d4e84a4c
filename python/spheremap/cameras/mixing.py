"""Views in one panorama by their weights, a few rows at a time.

A layer is a view in the panorama: its values times their weights, and the weights as one more
channel. Of a few rows two layers stay in a processor's cache; where all weighted pictures together
take more memory than two layers of the whole panorama, these are made instead, one view after the
other.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._progress import counted
from .pictures import exact

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ..resample.windows import Window

    # Writes a view's layer, of a window of the panorama or of all of it.
    Layer = Callable[[int, NDArray[Any], Window | None], object]

__all__ = ["by_rows", "divided", "mixed"]

# Numbers of a layer of a few rows.
FEW = 1 << 20
# Conversions work on squares of so many texels: a window that cuts them does more than it shows.
SQUARE = 64


def by_rows(pictures: list[tuple[int, int]], shape: tuple[int, ...]) -> bool:
    """Tell whether pictures of these sizes are held at once, and the panorama in parts."""
    sizes = [height * width for height, width in pictures]
    return sum(sizes) <= 2 * math.prod(shape) + max(sizes)


def mixed(
    shape: tuple[int, ...],
    unseen: NDArray[Any],
    count: int,
    layer: Layer,
    *,
    nearest: bool,
    parts: bool,
    with_weight: bool,
) -> tuple[NDArray[Any], NDArray[np.float32] | None]:
    """Return `count` views as one image, and if asked for the sums of their weights.

    `unseen` is a texel that no view sees, with the image's channels and dtype. `nearest` takes the
    view that counts for more than the others. With `parts` layers are asked for in windows of some
    rows each.
    """
    channels, dtype = len(unseen), unseen.dtype
    image = np.empty((*shape, channels), dtype)
    weights = np.empty(shape, np.float32) if with_weight else None
    width = shape[-1]
    windows = _windows(shape, channels + 1) if parts else [(slice(0, math.prod(shape[:-1])), None)]
    most = max(rows.stop - rows.start for rows, _ in windows)
    both = np.empty((min(count, 2), most, width, channels + 1), exact(dtype))
    for rows, window in counted(windows):
        total, more = (one[: rows.stop - rows.start] for one in (both[0], both[-1]))
        for k in range(count):
            to = more if k else total
            layer(k, to if window else to.reshape(*shape, channels + 1), window)
            if k:
                _core.add_layer(total, more, nearest)
        into = image.reshape(-1, width, channels)[rows]
        into[...] = divided(total, unseen)
        if weights is not None:
            weights.reshape(-1, width)[rows] = total[..., -1]
    return image, weights


def divided(total: NDArray[Any], unseen: NDArray[Any]) -> NDArray[Any]:
    """Return weighted sums by their weights, in the dtype of what no view sees."""
    found = _core.divide_layer(total, unseen[:0]).reshape(*total.shape[:-1], -1)
    # Its own for what has no weight: NaN in floats, and 0 in integers.
    found[~(total[..., -1] > 0)] = unseen
    return found


def _windows(shape: tuple[int, ...], numbers: int) -> list[tuple[slice, Window]]:
    """Return windows of some rows, of one face each, and where they lie among the rows of all."""
    *faces, height, width = shape
    step = max(1, FEW // (width * numbers * SQUARE)) * SQUARE
    everywhere = slice(None)
    found: list[tuple[slice, Window]] = []
    for face in range(faces[0] if faces else 1):
        for first in range(0, height, step):
            rows = slice(first, min(first + step, height))
            lines = slice(face * height + rows.start, face * height + rows.stop)
            found.append((lines, (rows, everywhere, face) if faces else (rows, everywhere)))
    return found
