"""A part of a result from the parts of a source that it sees: for files and for chunks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._arrays import spatial_axes
from .sparse import sparse_zeros

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from .conversion import Conversion
    from .seen import Rectangle

    Part = tuple[Any, Callable[[], NDArray[Any]]]

__all__ = ["convert_seen", "weighs"]


def weighs(conversion: Conversion) -> bool:
    """Tell whether texels may be weighed before they are looked up, which takes floats of them."""
    options = conversion.options
    filter = _filter(options)
    if filter["takes_labels"]:
        return False
    if options.get("alpha") is not None:
        return True
    # A mean over areas leaves out what is not finite as it goes.
    floats = conversion.dtype.kind == "f"
    return bool(options.get("skipna")) and floats and filter["method"] != "area"


def convert_seen(
    conversion: Conversion,
    parts: Sequence[Part],
    windows: Sequence[Rectangle],
    options: dict[str, Any] | None = None,
    dtype: np.dtype[Any] | None = None,
    source: NDArray[Any] | None = None,
) -> list[NDArray[Any]]:
    """Return parts of the result from the parts of the source that they see.

    Parameters
    ----------
    conversion : Conversion
    parts : sequence of (index, callable)
        Where each part of the source lies, and what returns its texels: more than once if texels
        are weighed.
    windows : sequence of Rectangle
    options, dtype
        Those of the conversion, unless others are given.
    source : ndarray, optional
        What holds the parts at their places already, of a conversion that weighs nothing.

    Returns
    -------
    texels : list of ndarray
        With the bits of the whole.
    """
    options = conversion.options if options is None else options
    channels = conversion.channels
    count = channels[0] if channels else 1
    skipna, alpha = bool(options.get("skipna")), options.get("alpha")
    alpha = None if alpha is None else alpha % count
    weights = None
    if weighs(conversion):
        weights = _weights(conversion, parts, count, alpha, skipna)
        # Where all is finite, this has the same bits.
        options = {**options, "skipna": False}
    if weights is None:
        if source is None:
            source = sparse_zeros(conversion.shape, conversion.dtype if dtype is None else dtype)
            for index, texels in parts:
                source[index] = texels()
        return [conversion.window(source, window.window, options) for window in windows]

    width, holes = weights
    given = (count, alpha, width, holes)
    space = conversion.shape[: spatial_axes(conversion.src)]
    wide = np.float64 if conversion.dtype.itemsize == 8 else np.float32
    source = sparse_zeros((*space, width), wide)
    for index, texels in parts:
        part = texels()
        shape = part.shape[:-1] if channels else part.shape
        # Whatever it says of channels: weighed texels have others.
        source[index[: len(space)]] = _core.weigh(part, *given).reshape(*shape, width)
    plain = {**options, "skipna": False, "alpha": None, "fill": np.nan}
    like = np.empty(0, conversion.dtype)
    found = []
    for window in windows:
        seen = conversion.window(source, window.window, plain)
        near = None
        if holes and _filter(options)["ringing"]:
            near = conversion.window(source, window.window, {**plain, "filter": "bilinear"})
        mean = _core.weighted_mean(like, *given, seen, near, options.get("fill", 0.0))
        found.append(mean.reshape(*seen.shape[:-1], *channels))
    return found


def _weights(
    conversion: Conversion,
    parts: Sequence[Part],
    count: int,
    alpha: int | None,
    skipna: bool,
) -> tuple[int, bool] | None:
    """Return how texels of all parts are weighed alike; none where all of them weigh the same."""
    plain = None if alpha is None else (count, False)
    if conversion.dtype.kind != "f":
        return plain
    each = [_core.weights(texels(), count, alpha, skipna) for _, texels in parts]
    known = [one for one in each if one is not None]
    if any(holes for _, holes in known):
        return 2 * count, True
    return (max(width for width, _ in known), False) if known else plain


def _filter(options: dict[str, Any]) -> Any:
    name = options["filter"]
    return next(f for f in _core.filters() if name == f["name"] or name in f["also"])
