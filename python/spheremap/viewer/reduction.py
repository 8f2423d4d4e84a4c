"""Large images made smaller, quickly: what a page holds, or sees from afar.

Where every texel holds sphere, blocks of texels are averaged, rows first, which reads the image
once and keeps no copy of it. Elsewhere levels of `mipmaps` know what a rim cuts. What is then still
larger than asked for is converted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import spatial_axes
from .._threads import on_all_threads
from ..map.grid import cells
from ..resample.verbs import convert, mipmaps

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["reduced"]

# Of the size that is asked for; means that are smaller would show less than they could.
_ENOUGH = 0.9
# Rows of a result that a thread makes at a time.
_ROWS = 8


def reduced(pixels: NDArray[Any], p: Projection, max_size: int) -> NDArray[Any]:
    """Return an image, channels last, whose faces have sides of no more than `max_size`."""
    axes = spatial_axes(p)
    rows, columns = cells(p)
    longest = max(pixels.shape[axes - 2] // rows, pixels.shape[axes - 1] // columns)
    if longest <= max_size:
        return pixels
    count = math.ceil(longest / max_size)
    if longest / count < _ENOUGH * max_size:
        count = longest // max_size
    if count > 1:
        if _has_blocks(pixels.shape[axes - 2 : axes], p, count):
            pixels = _means(pixels, axes, count)
        elif longest >= 2 * max_size:
            pixels = _level(pixels, p, longest / max_size)
    height, width = pixels.shape[axes - 2 : axes]
    longest = max(height // rows, width // columns)
    if longest <= max_size:
        return pixels
    scale = max_size / longest
    sides = (
        max(2, math.floor(height // rows * scale)) * rows,
        max(2, math.floor(width // columns * scale)) * columns,
    )
    size = (p.faces, *sides) if axes == 3 else sides
    return convert(pixels, p, p, size=size, any_aspect=True)


def _has_blocks(sides: tuple[int, ...], p: Projection, count: int) -> bool:
    """Whether blocks of `count` texels a side fill every face and hold nothing but sphere."""
    whole = all(n % (count * each) == 0 for n, each in zip(sides, cells(p), strict=True))
    return whole and p.grid == "centers" and p.used_part == 1.0


def _level(pixels: NDArray[Any], p: Projection, factor: float) -> NDArray[Any]:
    """Return the smallest level of a mip chain that is no smaller than asked for."""
    chain = mipmaps(pixels, p, any_aspect=True)
    return chain[min(int(math.log2(factor)), len(chain) - 1)]


def _means(pixels: NDArray[Any], axes: int, count: int) -> NDArray[Any]:
    """Return means of blocks of `count` × `count` texels, integers rounded."""
    height, width = (n // count for n in pixels.shape[axes - 2 : axes])
    channels = pixels.shape[axes] if pixels.ndim > axes else 1
    faces = pixels.reshape(-1, *pixels.shape[axes - 2 : axes], channels)
    kind: Any = {"u": np.uint32, "f": np.promote_types(pixels.dtype, np.float32)}[pixels.dtype.kind]
    result = pixels.dtype if pixels.dtype.kind == "u" else kind
    made = np.empty((len(faces), height, width, channels), result)

    def work(block: tuple[int, int]) -> None:
        face, top = block
        some = faces[face, top * count : (top + _ROWS) * count]
        lines = some.reshape(-1, count, width * count * channels)
        with np.errstate(invalid="ignore", over="ignore"):
            sums = lines.sum(axis=1, dtype=kind).reshape(len(lines), -1)
            for channel in range(channels):
                # One stride from end to end: an axis of three channels would be a loop of three.
                total = sums[:, channel :: count * channels].copy()
                for k in range(1, count):
                    total += sums[:, k * channels + channel :: count * channels]
                if result is kind:
                    total /= count * count
                else:
                    total += count * count // 2
                    total //= count * count
                made[face, top : top + _ROWS, :, channel] = total

    on_all_threads(work, [(f, top) for f in range(len(faces)) for top in range(0, height, _ROWS)])
    return made.reshape(*pixels.shape[: axes - 2], height, width, *pixels.shape[axes:])
