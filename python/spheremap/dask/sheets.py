"""Sums over the sphere: each sheet of an image by itself, from the chunks that hold it.

A sheet is a square of texels of one face whose size follows from nothing: sums of whole images are
sums of the same sheets in the same order, so that chunks, workers and their order show in no bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import prod
from typing import TYPE_CHECKING, Any, Protocol

import dask.array as da
import numpy as np
from dask.base import tokenize
from dask.highlevelgraph import HighLevelGraph

from .. import _core
from .._arrays import checked_image, spatial_axes
from ..map.images import expect_aspect
from ..resample.sparse import sparse_zeros

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Sum", "expect_image", "summed"]

Place = tuple[slice, ...]

# Images of at most so many texels are summed whole: all of one is no more than a sheet.
_SMALL = 1 << 18


class Sum(Protocol):
    """What is summed over an image."""

    def whole(self, image: NDArray[Any]) -> NDArray[Any]:
        """Return the result, of an image that is small."""

    def part(self, image: NDArray[Any], number: int) -> NDArray[np.float64]:
        """Return what a sheet gives, the only part of the image that is there."""

    def result(self, parts: Sequence[NDArray[np.float64]]) -> NDArray[Any]:
        """Return the result, from what all sheets give."""


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A task: it is called with the chunks at `places`, which hold what lies at `part`."""

    sum: Sum
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    checks: dict[str, Any]
    part: Place
    places: tuple[Place, ...]
    # The number of the sheet; none of an image that is summed whole.
    number: int | None

    def __call__(self, chunks: Sequence[Any]) -> NDArray[Any]:
        image = sparse_zeros(self.shape, self.dtype)
        for place, chunk in zip(self.places, chunks, strict=True):
            common = _common(place, self.part)
            own = tuple(
                slice(a.start - b.start, a.stop - b.start)
                for a, b in zip(common, place, strict=True)
            )
            origin = tuple(a.start for a in common)
            image[common] = checked_image(np.asarray(chunk)[own], origin=origin, **self.checks)
        return self.sum.whole(image) if self.number is None else self.sum.part(image, self.number)


@dataclass(frozen=True, slots=True, eq=False)
class _Result:
    """The last task: it is called with what all sheets give."""

    sum: Sum

    def __call__(self, parts: Sequence[NDArray[np.float64]]) -> NDArray[Any]:
        return self.sum.result(parts)


def expect_image(image: Any, projection: Projection, any_aspect: object) -> da.Array:
    """Return an image with its channels in one chunk, or raise for what is none."""
    if not isinstance(image, da.Array):
        raise TypeError(
            f"Expected `image` to be an array of dask, got {type(image).__name__}; "
            "dask.array.from_array makes one."
        )
    if any(np.isnan(length) for length in image.shape):
        raise ValueError(
            "Expected `image` to have chunks of known sizes; compute_chunk_sizes() finds them."
        )
    axes = spatial_axes(projection)
    if image.ndim not in (axes, axes + 1):
        raise ValueError(
            f"Expected `image` to have {axes} axes, or {axes + 1} with channels, got shape "
            f"{image.shape}; images of a batch are taken one by one."
        )
    expect_aspect(projection, image.shape, any_aspect)
    projection.shape(image.shape[:axes])
    if image.ndim > axes and image.shape[-1] == 0:
        raise ValueError("Expected an image with at least one channel, got 0.")
    return image.rechunk({axes: -1}) if image.ndim > axes else image


def summed(
    image: da.Array,
    projection: Projection,
    sum: Sum,
    shape: tuple[int, ...],
    dtype: Any,
    **checks: Any,
) -> da.Array:
    """Return a sum over an image, of this shape, as an array in one chunk.

    `checks` are what `checked_image` is told.
    """
    kind = checked_image(np.zeros((1,) * image.ndim, image.dtype), **checks).dtype
    axes = spatial_axes(projection)
    small = prod(image.shape[:axes]) <= _SMALL
    everything = tuple(slice(0, n) for n in image.shape)
    parts = [everything] if small else _sheets(projection, image.shape, axes)
    starts = [np.cumsum([0, *lengths]) for lengths in image.chunks]

    token = tokenize(image.name, sum, shape, checks)
    name, of_parts = f"spheremap-sum-{token}", f"spheremap-sheets-{token}"
    tasks = {}
    for number, part in enumerate(parts):
        index, places = _seen(part, starts)
        own = _Part(sum, image.shape, kind, checks, part, places, None if small else number)
        tasks[(of_parts, number)] = (own, [(image.name, *i) for i in index])
    end = (0,) * len(shape)
    if small:
        graph = HighLevelGraph.from_collections(
            name, {(name, *end): tasks[(of_parts, 0)]}, dependencies=[image]
        )
    else:
        last = {(name, *end): (_Result(sum), [(of_parts, k) for k in range(len(parts))])}
        below = HighLevelGraph.from_collections(of_parts, tasks, dependencies=[image])
        graph = HighLevelGraph(
            {**below.layers, name: last}, {**below.dependencies, name: {of_parts}}
        )
    meta = np.empty((0,) * len(shape), dtype)
    return da.Array(graph, name, tuple((n,) for n in shape), meta=meta)


def _sheets(projection: Projection, shape: tuple[int, ...], axes: int) -> list[Place]:
    """Return where the sheets of an image lie in it."""
    rest = tuple(slice(0, n) for n in shape[axes:])
    rows = shape[axes - 2]
    found = []
    for top, bottom, left, right in _core.sheets(projection, shape[:axes]):
        columns = slice(left, right)
        if axes == 2:
            found.append((slice(top, bottom), columns, *rest))
        else:
            face = top // rows
            within = slice(top - face * rows, bottom - face * rows)
            found.append((slice(face, face + 1), within, columns, *rest))
    return found


def _seen(
    part: Place, starts: Sequence[NDArray[np.intp]]
) -> tuple[list[tuple[int, ...]], tuple[Place, ...]]:
    """Return which chunks hold a part of an image, and where they lie."""
    sides = []
    for side, start in zip(part, starts, strict=True):
        # Chunks without length hold nothing.
        spans = enumerate(pairwise(start.tolist()))
        first = max(0, int(np.searchsorted(start, side.start, "right")) - 1)
        last = int(np.searchsorted(start, side.stop, "left"))
        sides.append([(k, slice(a, b)) for k, (a, b) in spans if first <= k < last and a < b])
    chosen: list[list[tuple[int, slice]]] = [[]]
    for some in sides:
        chosen = [[*before, one] for before in chosen for one in some]
    return (
        [tuple(k for k, _ in one) for one in chosen],
        tuple(tuple(side for _, side in one) for one in chosen),
    )


def _common(a: Place, b: Place) -> Place:
    """Return what two places have in common."""
    return tuple(
        slice(max(x.start, y.start), min(x.stop, y.stop)) for x, y in zip(a, b, strict=True)
    )
