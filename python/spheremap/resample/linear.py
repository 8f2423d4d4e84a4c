"""What makes sums of an image's texels, as text, with the adjoint: for gradients.

Here an image has its channels last, batches among them: (H, W, channels), (F, N, N, channels).
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._arrays import spatial_axes
from .._threads import on_all_threads
from ..map.images import expect_aspect, target_shape
from ..map.named import resolve
from ..map.size import matching_size
from ..map.spec import map_of, spec_of
from .lookups import lookups
from .matrix import weights_of
from .padding import pad
from .plans import remap_plan
from .verbs import convert

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

    Reals = NDArray[np.floating[Any]]

# Rows of a matrix go to threads in so many parts, whatever the number of threads.
_PARTS = 16

# Matrices are large: so many are held at a time.
MATRICES = 16

# Where rows have no more weights, gathers are faster than a product.
_FEW = 8


class Matrix:
    """A sparse matrix of which the adjoint is wanted: each row is summed in one order."""

    def __init__(self, weights: Any) -> None:
        self.weights = weights
        self._held: dict[Any, Any] = {}

    def times(self, columns: Reals) -> Reals:
        """Return the matrix times columns (sources, channels)."""
        return self._product("forward", self.weights, columns)

    def adjoint(self, columns: Reals) -> Reals:
        """Return the transposed matrix times columns (targets, channels)."""
        return self._product("adjoint", self.weights.T, columns)

    def adjoint_of_planes(self, planes: Reals, faces: int) -> Reals | None:
        """Return the transposed matrix times images (N, F, C, texels), as (N, faces, C, texels).

        None where there is none, or where an image has more numbers than places in 32 bits.
        """
        _, own, channels, texels = planes.shape
        if not planes.size or own * channels * texels > np.iinfo(np.int32).max:
            return None
        key = ("planes", planes.dtype, channels)
        if key not in self._held:
            rows = self.weights.T.tocsr().astype(planes.dtype)
            # Weights of a row in the order of its columns: sums have one order.
            rows.sort_indices()
            skipped = rows.indices // texels * ((channels - 1) * texels)
            columns = (rows.indices + skipped).astype(np.int32)
            self._held[key] = (rows.indptr.astype(np.int32), columns, rows.data)
        ends, columns, weights = self._held[key]
        return _core.sums_of_planes(ends, columns, weights, planes, faces)

    def _product(self, way: str, weights: Any, given: Reals) -> Reals:
        columns = np.ascontiguousarray(given)
        parts = self._held.get((way, columns.dtype))
        if parts is None:
            rows = weights.tocsr().astype(columns.dtype)
            # Weights of a row in the order of its columns: sums have one order.
            rows.sort_indices()
            bounds = np.linspace(0, rows.shape[0], _PARTS + 1).astype(int)
            parts = [(a, b, rows[a:b]) for a, b in pairwise(bounds) if a < b]
            self._held[way, columns.dtype] = parts
        out = np.empty((weights.shape[0], columns.shape[1]), columns.dtype)

        def work(part: Any) -> None:
            first, last, rows = part
            out[first:last] = rows @ columns

        on_all_threads(work, parts)
        return out


@dataclass(frozen=True)
class Linear:
    """A verb that makes sums of an image's texels, for images of one shape."""

    key: str

    @cached_property
    def _given(self) -> dict[str, Any]:
        given: dict[str, Any] = json.loads(self.key)
        return given

    @property
    def source(self) -> tuple[int, ...]:
        """The shape of the images."""
        return tuple(self._given["source"])

    @property
    def target(self) -> tuple[int, ...]:
        """The shape of the results."""
        return tuple(self._given["target"])

    @property
    def fill(self) -> float:
        """What texels of the result are that see nothing."""
        return float(self._given.get("fill", 0.0))

    def run(self, image: NDArray[Any], *, filled: bool = True) -> NDArray[Any]:
        """Do it by the kernel."""
        given = self._given
        if given["verb"] == "pad":
            p = map_of(given["src"])
            found: NDArray[Any] = pad(image, p, given["n"], filter=given["filter"], any_aspect=True)
            return found
        return convert(
            image,
            map_of(given["src"]),
            map_of(given["dst"]),
            size=self.target,
            filter=given["filter"],
            fill=self.fill if filled else 0.0,
            antialias=given["antialias"],
            world=given["world"],
            any_aspect=True,
        )

    @cached_property
    def is_lookup(self) -> bool:
        """Whether it is one bilinear lookup for each texel of the result."""
        given = self._given
        return (
            given["verb"] == "convert" and given["filter"] == "bilinear" and not given["antialias"]
        )

    @cached_property
    def matrix(self) -> Matrix:
        """It as a matrix, to rounding."""
        from scipy.sparse import csr_matrix

        if self._given["filter"] == "mode":
            raise NotImplementedError("`convert` with filter='mode' has no gradient.")
        sources, targets = math.prod(self.source), math.prod(self.target)
        if self.is_lookup:
            return Matrix(lookups(self._given["src"], self.source).weights(self._directions()))

        def columns(channels: NDArray[np.float64]) -> NDArray[np.float64]:
            image = channels.reshape(*self.source, -1)
            return self.run(image, filled=False).reshape(targets, -1)

        found = weights_of(columns, self.source, targets)
        return Matrix(csr_matrix(found, shape=(targets, sources)))

    @property
    def has_matrix(self) -> bool:
        """Whether the matrix is found already."""
        return "matrix" in self.__dict__

    @cached_property
    def gathers(self) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
        """Texels and weights of each row of the matrix, (few, rows), 0 where a row has fewer.

        None where rows have many, or where finding the matrix takes longer than many calls.
        """
        if not (self.is_lookup or self._given["verb"] == "pad"):
            return None
        rows = self.matrix.weights.tocsr()
        counts = np.diff(rows.indptr)
        if counts.max(initial=1) > _FEW:
            return None
        shape = (counts.max(initial=1), len(counts))
        index, weights = np.zeros(shape, np.int64), np.zeros(shape)
        row = np.repeat(np.arange(len(counts)), counts)
        place = np.arange(len(row)) - rows.indptr[row]
        index[place, row], weights[place, row] = rows.indices, rows.data
        return index, weights

    def _directions(self) -> Reals:
        source, target = map_of(self._given["src"]), map_of(self._given["dst"])
        if self._given["world"] == "match":
            target = target.in_world_of(source)
        return target.directions(self.target).reshape(-1, 3)

    @cached_property
    def empty(self) -> NDArray[np.bool_]:
        """Which texels of the result are no sums, but `fill`."""
        ones = np.ones((*self.source, 1))
        none: NDArray[np.bool_] = self.run(ones, filled=False).reshape(-1) == 0
        return none


@lru_cache(MATRICES)
def linear_of(key: str) -> Linear:
    """Return what a key stands for, which holds what it has prepared."""
    return Linear(key)


def target_of(key: str) -> tuple[tuple[int, ...], float]:
    """Return the shape of what a key makes, and what its texels are that see nothing."""
    made = linear_of(key)
    return made.target, made.fill


def without_fill(key: str) -> str:
    """Return the key of the same without what is not linear."""
    given = json.loads(key)
    return json.dumps({**given, "fill": 0.0}) if given.get("fill", 0.0) != 0.0 else key


def conversion(
    shape: tuple[int, ...],
    src: ProjectionLike,
    dst: ProjectionLike,
    size: Size | None,
    rotation: Any | None,
    filter: str,
    fill: float,
    antialias: bool,
    world: str,
    any_aspect: bool,
) -> tuple[int, str, int]:
    """Return the axes of the source, the key of a conversion, and the axes of the result.

    `shape` is that of an image with its channels before the rows.
    """
    source, target = resolve(src), resolve(dst)
    axes = spatial_axes(source)
    sides = _sides(source, shape, axes, any_aspect)
    if size is None:
        size = matching_size(sides, source, target)
    made = target.shape(target_shape(target, size, any_aspect))
    # All that is wrong with options is said at once, of a plan that is not kept.
    options: dict[str, Any] = {"filter": filter, "fill": float(fill), "antialias": antialias}
    plan = remap_plan(
        source, target, size=made, world=world, any_aspect=True, rotation=rotation, **options
    )
    key = {
        "verb": "convert",
        "src": spec_of(plan.src),
        "dst": spec_of(target),
        "source": sides,
        "target": made,
        "world": world,
        **options,
    }
    return axes, json.dumps(key), len(made)


def border(
    shape: tuple[int, ...], projection: ProjectionLike, n: int, filter: str, any_aspect: bool
) -> tuple[int, str, int]:
    """Return the axes of an image, the key of its padding, and the axes of the result."""
    p = resolve(projection)
    axes = spatial_axes(p)
    sides = _sides(p, shape, axes, any_aspect)
    like = pad(np.zeros(sides, np.float32), p, n, filter=filter, any_aspect=True)
    key = {"verb": "pad", "src": spec_of(p), "source": sides, "target": like.shape}
    return axes, json.dumps({**key, "n": int(n), "filter": filter}), like.ndim


def image_axes(spec: str, shape: tuple[int, ...], any_aspect: bool) -> int:
    """Return how many axes an image of a map has without channels; its aspect is checked."""
    p = map_of(spec)
    axes = spatial_axes(p)
    _sides(p, shape, axes, any_aspect)
    return axes


def turned_grid(
    src: ProjectionLike,
    dst: ProjectionLike,
    size: Size | None,
    shape: tuple[int, ...],
    world: str,
    any_aspect: bool,
) -> tuple[str, Reals]:
    """Return the source, and the directions of the result's texels in its world."""
    source, target = resolve(src), resolve(dst)
    if size is None:
        sides = _sides(source, shape, spatial_axes(source), any_aspect)
        size = matching_size(sides, source, target)
    if world == "match":
        target = target.in_world_of(source)
    return spec_of(source), target.directions(target_shape(target, size, any_aspect))


def _sides(p: Projection, shape: tuple[int, ...], axes: int, any_aspect: bool) -> tuple[int, ...]:
    """Return the shape of an image without channels."""
    if not axes <= len(shape) <= axes + 2:
        raise ValueError(
            f"Expected `image` to have {axes} to {axes + 2} axes, channels before the rows, "
            f"got {shape}."
        )
    sides = shape[-2:]
    if axes == 3:
        # Faces lie before the channels, and a batch before them.
        sides = (shape[1 if len(shape) == 5 else 0], *sides)
    expect_aspect(p, sides, any_aspect)
    return sides
