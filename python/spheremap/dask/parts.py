"""What a task does: a part of a result from the chunks of a source that it sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..resample.conversion import Conversion
from ..resample.parts import convert_seen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..resample.seen import Rectangle

__all__ = ["Part"]

# What indexes an array by one of its chunks.
Place = tuple[slice, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A task: it is called with the chunks that lie at `places`.

    Its result has a window for each face.
    """

    conversion: Conversion
    windows: tuple[Rectangle, ...]
    places: tuple[Place, ...]

    def __call__(self, chunks: Sequence[Any]) -> NDArray[Any]:
        """Return a chunk of the result."""
        conversion = self.conversion
        chunks = [np.asarray(chunk) for chunk in chunks]
        options = conversion.options
        known = None
        if options["filter"] == "mode" and conversion.dtype.kind in "biu":
            known, chunks, fill = _numbered(chunks, options["fill"], conversion.dtype)
            options = {**options, "fill": fill}
        parts = [
            (place, lambda chunk=chunk: chunk)
            for place, chunk in zip(self.places, chunks, strict=True)
        ]
        dtype = None if known is None else np.dtype(np.float64)
        windows = convert_seen(conversion, parts, self.windows, options, dtype)
        found = windows[0] if self.windows[0].face is None else np.stack(windows)
        return found if known is None else known[found.astype(np.intp)]


def _numbered(
    chunks: Sequence[NDArray[Any]], fill: Any, dtype: np.dtype[Any]
) -> tuple[NDArray[Any], list[NDArray[Any]], Any]:
    """Return the labels that there are, chunks and fill as places among them.

    Wide labels would be numbered among those of the whole source; the order is the same.
    """
    filling = np.asarray(fill).astype(dtype)
    known = np.unique(np.concatenate([*map(np.ravel, chunks), filling.ravel()]))
    places = [np.searchsorted(known, chunk) for chunk in chunks]
    return known, places, np.searchsorted(known, filling).tolist()
