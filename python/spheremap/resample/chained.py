"""A conversion by a mip chain of which no level is there as a whole: levels are made by windows.

First each level is made of the one before, window by window. Then the result is looked up, window
by window, in the texels of the image that it sees, and in the levels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._arrays import spatial_axes
from .seen import Rectangle
from .windows import stored_part

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .._projection import Projection
    from .conversion import Conversion

__all__ = ["Chained"]

# One of so many rows of a window tells what it sees: neighbors see the same but at corners.
_EVERY = 8


@dataclass(frozen=True, eq=False)
class Chained:
    """What there is to know of a conversion by levels before any is made."""

    conversion: Conversion

    @cached_property
    def weights(self) -> tuple[int, int | None, int, bool] | None:
        """How texels are weighed: as they would be if one of them had what is not finite.

        Where none has, that gives the same bits.
        """
        conversion, options = self.conversion, self.conversion.options
        count = conversion.channels[0] if conversion.channels else 1
        floats = conversion.dtype.kind == "f"
        alpha, holes = options.get("alpha"), bool(options.get("skipna")) and floats
        if alpha is None and not holes:
            return None
        width = 2 * count if holes else count + floats
        return count, None if alpha is None else alpha % count, width, holes

    @cached_property
    def floats(self) -> np.dtype[Any]:
        """What levels are filtered in, and hold."""
        return np.dtype(np.float64 if self.conversion.dtype.itemsize == 8 else np.float32)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Of the image whose chain it is, weighed or as it is, with channels."""
        conversion = self.conversion
        channels = conversion.channels or (1,)
        return (*self._space, *(channels if self.weights is None else self.weights[2:3]))

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of that image."""
        return self.conversion.dtype if self.weights is None else self.floats

    @cached_property
    def shapes(self) -> list[tuple[int, ...]]:
        """Of the other levels, with channels."""
        found = _core.level_shapes(self.conversion.src, self._space)
        return [(*shape, self.shape[-1]) for shape in found]

    @property
    def _space(self) -> tuple[int, ...]:
        return self.conversion.shape[: spatial_axes(self.conversion.src)]

    def weighed(self, texels: NDArray[Any]) -> NDArray[Any]:
        """Return texels (..., C) of the source as the chain's image has them."""
        if self.weights is None:
            return texels
        found: NDArray[Any] = _core.weigh(np.ascontiguousarray(texels), *self.weights)
        return found.reshape(*texels.shape[:-1], -1)

    def before(self, level: int) -> tuple[int, ...]:
        """Return the shape, without channels, of what a level is made of: the first is 0."""
        return self.shapes[level - 1][:-1] if level else self._space

    def needed(self, level: int, window: Rectangle) -> Rectangle:
        """Return the part of the level before that a window of a level is made of."""
        src, before = self.conversion.src, self.before(level)
        stored = stored_part(window.window, self.shapes[level][:-1])
        return _rectangle(_halving(src, before).needs(stored), before)

    def halved(
        self, level: int, window: Rectangle, needed: Rectangle, texels: NDArray[Any]
    ) -> NDArray[Any]:
        """Return a window of a level from texels (H, W, C) of what is needed."""
        src, before = self.conversion.src, self.before(level)
        return _halving(src, before).window(
            np.ascontiguousarray(texels),
            stored_part(needed.window, before),
            stored_part(window.window, self.shapes[level][:-1]),
        )

    def seen(self, window: Rectangle, tile: tuple[int, int]) -> list[Rectangle]:
        """Return the tiles of the image itself that a window of the result sees, nearly all.

        Rows are left out. Which tiles all of them saw, `window` tells.
        """
        conversion = self.conversion
        found = _core.tiles_of_window(
            conversion.src,
            self._space,
            1 + len(self.shapes),
            conversion.dst,
            conversion.size,
            tile,
            _EVERY,
            window=stored_part(window.window, conversion.size),
            **self._way,
        )
        return [_rectangle(part, self._space) for part in found]

    def window(
        self,
        image: NDArray[Any],
        levels: Sequence[NDArray[Any]],
        window: Rectangle,
        tile: tuple[int, int],
    ) -> tuple[NDArray[Any], list[Rectangle]]:
        """Return a window of the result, and the tiles of the image itself that it saw.

        It is right where these are there.
        """
        conversion = self.conversion
        fill = conversion.options.get("fill", 0.0)
        found, seen = _core.convert_levels(
            image,
            levels,
            conversion.src,
            conversion.dst,
            conversion.size,
            tile,
            fill=fill if self.weights is None else np.nan,
            window=stored_part(window.window, conversion.size),
            **self._way,
        )
        if self.weights is not None:
            like = np.empty(0, conversion.dtype)
            mean = _core.weighted_mean(like, *self.weights, found, None, fill)
            found = mean.reshape(*found.shape[:-1], -1)
        texels = found.reshape(*found.shape[:-1], *conversion.channels)
        return texels, [_rectangle(part, self._space) for part in seen]

    @property
    def _way(self) -> dict[str, Any]:
        options = self.conversion.options
        return {"filter": options["filter"], "world": options["world"]}


# The last two: what is made of one level, and of the next one.
@lru_cache(maxsize=2)
def _halving(src: Projection, shape: tuple[int, ...]) -> _core.Halving:
    """Return how a level becomes the next one, which takes a look at all of its rim."""
    return _core.Halving(src, shape)


def _rectangle(part: Sequence[int], space: tuple[int, ...]) -> Rectangle:
    """Return a part, whose rows are those of all faces, as one of its face."""
    top, bottom, left, right = part
    if len(space) == 2:
        return Rectangle(top, bottom, left, right)
    face, top = divmod(top, space[1])
    return Rectangle(top, bottom - face * space[1], left, right, face)
