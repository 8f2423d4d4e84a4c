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
from dask.base import compute_as_if_collection, tokenize
from dask.highlevelgraph import HighLevelGraph

from .._arrays import checked_image, spatial_axes
from ..light.sheets import sheet_places
from ..map.images import expect_aspect
from ..resample.sparse import sparse_zeros

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .._projection import Projection
    from ..light.sheets import Place

__all__ = ["Sum", "computed", "expect_image", "summed"]

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
            # `checked_image` has to see masks, which `asarray` would drop.
            image[common] = checked_image(np.asanyarray(chunk)[own], origin=origin, **self.checks)
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
    name = f"spheremap-sum-{tokenize(image.name, sum, shape, checks)}"
    end = (0,) * len(shape)
    if prod(image.shape[: spatial_axes(projection)]) <= _SMALL:
        kind = checked_image(np.zeros((1,) * image.ndim, image.dtype), **checks).dtype
        everything = tuple(slice(0, n) for n in image.shape)
        index, places = _seen(everything, [np.cumsum([0, *k]) for k in image.chunks])
        own = _Part(sum, image.shape, kind, checks, everything, places, None)
        whole = {(name, *end): (own, [(image.name, *i) for i in index])}
        graph = HighLevelGraph.from_collections(name, whole, dependencies=[image])
    else:
        tasks = _tasks(image, projection, sum, checks)
        sheets = next(iter(tasks))[0]
        below = HighLevelGraph.from_collections(sheets, tasks, dependencies=[image])
        last = {(name, *end): (_Result(sum), list(tasks))}
        graph = HighLevelGraph({**below.layers, name: last}, {**below.dependencies, name: {sheets}})
    meta = np.empty((0,) * len(shape), dtype)
    return da.Array(graph, name, tuple((n,) for n in shape), meta=meta)


def computed(
    image: da.Array,
    projection: Projection,
    sum: Any,
    numbers: Sequence[int],
    **checks: Any,
) -> list[NDArray[Any]]:
    """Return what some sheets give, at once."""
    tasks = _tasks(image, projection, sum, checks)
    all_keys = list(tasks)
    some = {key: tasks[key] for key in (all_keys[k] for k in numbers)}
    keys = list(some)
    graph = HighLevelGraph.from_collections(keys[0][0], some, dependencies=[image])
    return list(compute_as_if_collection(da.Array, graph, keys))


def _tasks(
    image: da.Array, projection: Projection, sum: Any, checks: dict[str, Any]
) -> dict[tuple[str, int], Any]:
    """Return a task for each sheet, with the chunks that hold it."""
    kind = checked_image(np.zeros((1,) * image.ndim, image.dtype), **checks).dtype
    starts = [np.cumsum([0, *lengths]) for lengths in image.chunks]
    name = f"spheremap-sheets-{tokenize(image.name, sum, checks)}"
    tasks = {}
    for number, part in enumerate(sheet_places(projection, image.shape)):
        index, places = _seen(part, starts)
        own = _Part(sum, image.shape, kind, checks, part, places, number)
        tasks[(name, number)] = (own, [(image.name, *i) for i in index])
    return tasks


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
