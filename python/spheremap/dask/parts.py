"""What a task does: a part of a result from what it sees of the chunks of a source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array
from ..resample.conversion import Conversion
from ..resample.parts import convert_seen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..resample.seen import Rectangle
    from .pieces import Piece

__all__ = ["Part"]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A task: it is called with the chunks of its pieces, in the order of their numbers.

    Its result has a window for each face.
    """

    conversion: Conversion
    windows: tuple[Rectangle, ...]
    pieces: tuple[Piece, ...]

    @property
    def chunks(self) -> list[int]:
        """The numbers of the chunks that it wants."""
        return sorted({piece.chunk for piece in self.pieces})

    def __call__(self, chunks: Sequence[Any]) -> NDArray[Any]:
        """Return a chunk of the result."""
        conversion = self.conversion
        numbered = zip(self.chunks, chunks, strict=True)
        given = {number: as_array(chunk, "image") for number, chunk in numbered}
        texels = [given[piece.chunk][piece.inner] for piece in self.pieces]
        options = conversion.options
        known = None
        if options["filter"] == "mode" and conversion.dtype.kind in "biu":
            known, texels, fill = _numbered(texels, options["fill"], conversion.dtype)
            options = {**options, "fill": fill}
        parts = [
            (piece.place, lambda seen=seen: seen)
            for piece, seen in zip(self.pieces, texels, strict=True)
        ]
        dtype = None if known is None else np.dtype(np.float64)
        windows = convert_seen(conversion, parts, self.windows, options, dtype)
        found = windows[0] if self.windows[0].face is None else np.stack(windows)
        return found if known is None else known[found.astype(np.intp)]


def _numbered(
    texels: Sequence[NDArray[Any]], fill: Any, dtype: np.dtype[Any]
) -> tuple[NDArray[Any], list[NDArray[Any]], Any]:
    """Return the labels that there are, texels and fill as places among them.

    Wide labels would be numbered among those of the whole source; the order is the same.
    """
    filling = np.asarray(fill).astype(dtype)
    known = np.unique(np.concatenate([*map(np.ravel, texels), filling.ravel()]))
    places = [np.searchsorted(known, some) for some in texels]
    return known, places, np.searchsorted(known, filling).tolist()
