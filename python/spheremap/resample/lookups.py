"""Which texels a bilinear lookup mixes, and by how much: for gradients, and for other devices.

Where an image is a whole rectangle, each texel beyond an edge is a sum of texels, whichever lookup
asks for it: `pad` gives it. So a lookup is a mix of four texels of the padded image. At rims and at
the edges of faces a lookup has rules of its own; there its weights are found by looking up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._threads import on_all_threads
from ..map.grid import on_corners, texel
from ..map.spec import HELD, map_of
from .matrix import weights_of
from .padding import pad
from .verbs import sample

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

    Floats = NDArray[np.floating[Any]]
    Places = NDArray[np.int64]
    # Factor and offset of u, and those of v.
    Scales = tuple[tuple[float, float], tuple[float, float]]

# Lookups whose numbers stay in a core's cache.
_BLOCK = 1 << 15

# How far apart two lookups are whose difference is a slope, in texels: its square, and what is
# rounded over it, are both near 1e-11.
_STEP = 1e-5


@dataclass(frozen=True)
class Lookups:
    """Bilinear lookups in images of one map and shape."""

    spec: str
    shape: tuple[int, ...]

    @property
    def p(self) -> Projection:
        """The map."""
        return map_of(self.spec)

    @property
    def texels(self) -> int:
        """How many texels the image has."""
        return math.prod(self.shape)

    @cached_property
    def is_whole(self) -> bool:
        """Whether the image is a rectangle, all of which is valid."""
        return self.p.layout is None and self.p.used_part == 1.0

    @cached_property
    def places(self) -> Scales:
        """Factor and offset from u and v to texels, 0 at the center of the first."""
        corners_v, corners_u = on_corners(self.p)
        found = []
        for n, corners in ((self.shape[-1], corners_u), (self.shape[-2], corners_v)):
            first, last = texel(np.array([0.0, 1.0]), n, 1, corners).tolist()
            found.append((last - first, first))
        return found[0], found[1]

    @cached_property
    def padded(self) -> tuple[Places, tuple[Places, Places, NDArray[np.float64]] | None]:
        """Which texel each of the padded image is, and what those are that are no single one.

        The latter count on from the last texel; their weights are rows, columns and values.
        """
        numbers = np.arange(float(self.texels)).reshape(self.shape)
        marks = np.random.default_rng(0).random(self.texels)
        own = pad(numbers, self.p, 1, any_aspect=True).ravel()
        image = marks.reshape(self.shape)
        there = pad(image, self.p, 1, any_aspect=True).ravel()
        index = np.rint(own).astype(np.int64)
        mixed = np.flatnonzero(marks[index] != there)
        if not len(mixed):
            return index, None

        def border(channels: NDArray[np.float64]) -> NDArray[np.float64]:
            whole = pad(channels.reshape(*self.shape, -1), self.p, 1, any_aspect=True)
            return whole.reshape(len(own), -1)[mixed]

        weight, (row, column) = weights_of(border, self.shape, len(mixed))
        index[mixed] = self.texels + np.arange(len(mixed))
        return index, (row, column, weight)

    @property
    def mixes(self) -> int:
        """How many texels of the padded image are no single one."""
        return 0 if self.padded[1] is None else int(self.padded[1][0].max()) + 1

    def _four(self, directions: Floats) -> tuple[Places, Floats, Floats]:
        """Return four texels of the padded image (4, n), and the places between them, x and y."""
        uv: Floats = type(self.p).encode(self.p, directions)
        column, row, x, y = between(np, uv, self.places, self.shape)
        # Where there are no faces the third is none.
        face = np.nan_to_num(uv[..., 2]).astype(np.int64) if uv.shape[-1] == 3 else 0
        first = number(self.shape, column.astype(np.int64), row.astype(np.int64), face)
        return first + np.array(steps(self.shape))[:, None], x, y

    def weights(self, directions: Floats) -> Any:
        """Return the lookups as a sparse matrix of SciPy, (directions, texels)."""
        from scipy.sparse import csr_matrix

        shape = (len(directions), self.texels)
        if self.is_whole:
            own, mixed = self.padded
            chosen = np.empty((shape[0], 4), np.int32)
            mix = np.empty((shape[0], 4), directions.dtype)

            def work(block: slice) -> None:
                four, x, y = self._four(directions[block])
                chosen[block] = own[four].T
                mix[block] = np.nan_to_num(shares(np, x, y)).T

            blocks = [slice(k, k + _BLOCK) for k in range(0, shape[0], _BLOCK)]
            on_all_threads(work, blocks)
            rows = np.arange(0, 4 * shape[0] + 1, 4, dtype=np.int32)
            parts = (mix.ravel(), chosen.ravel(), rows)
            if mixed is None:
                return csr_matrix(parts, shape=shape)
            row, column, weight = mixed
            whole = csr_matrix(parts, shape=(shape[0], self.texels + self.mixes))
            border = csr_matrix((weight, (row, column)), shape=(self.mixes, self.texels))
            return whole[:, : self.texels] + whole[:, self.texels :] @ border
        inner, index, weights = self._inside(directions)
        rest = np.flatnonzero(~inner)
        some = directions.astype(np.float64)[rest]

        def seen(channels: NDArray[np.float64]) -> NDArray[np.float64]:
            image = channels.reshape(*self.shape, -1)
            return sample(image, some, self.p, any_aspect=True)

        weight, (row, column) = weights_of(seen, self.shape, len(rest))
        within = np.flatnonzero(inner)
        data = np.concatenate([weights[:, within].T.ravel(), weight])
        rows = np.concatenate([np.repeat(within, 4), rest[row]])
        columns = np.concatenate([index[:, within].T.ravel(), column])
        return csr_matrix((data, (rows, columns)), shape=shape)

    def adjoint(self, gradient: Floats, directions: Floats, filter: str) -> Floats:
        """Return what flows back to the texels (texels, channels), from lookups (n, channels)."""
        looked = np.ascontiguousarray(directions, gradient.dtype)
        columns = np.ascontiguousarray(gradient)
        found = _core.sample_adjoint(self.p, self.shape, filter, looked, columns)
        return found.reshape(self.texels, -1)

    def pulled(self, image: Floats, directions: Floats, gradient: Floats) -> Floats:
        """Return what flows back to u and v (n, 2) from lookups, whose gradient is (n, channels).

        At rims and at the edges of faces, where lookups have rules of their own, of differences.
        """
        texels = np.ascontiguousarray(image).reshape(*self.shape, -1)
        looked = np.ascontiguousarray(directions, image.dtype)
        columns = np.ascontiguousarray(gradient, image.dtype)
        if self.p.layout in (None, "faces"):
            found = _core.sample_slopes(self.p, texels, looked, columns)
        else:
            # Faces in one image: its u and v are not those of a face.
            found = np.full((len(looked), 2), np.nan, image.dtype)
        rest = np.flatnonzero(np.isnan(found[:, 0]))
        if len(rest):
            slopes = np.nan_to_num(self._differences(image, looked[rest]))
            found[rest] = np.einsum("knc,nc->nk", slopes, columns[rest])
        return found

    def slopes(self, image: Floats, directions: Floats) -> Floats:
        """Return the derivatives (2, n, channels) of lookups in texels (texels, channels).

        They are by u and by v of the place of each direction. At rims and at the edges of faces,
        where lookups have rules of their own, they are differences of two lookups.
        """
        out = np.zeros((2, len(directions), image.shape[1]), image.dtype)
        inner, index, _ = self._inside(directions)
        within = np.flatnonzero(inner)
        if len(within):
            _, x, y = self._four(directions[within])
            a, b, c, d = image[index[:, within]]
            x, y = x[:, None], y[:, None]
            (scale_u, _), (scale_v, _) = self.places
            out[0, within] = ((b - a) * (1 - y) + (d - c) * y) * scale_u
            out[1, within] = ((c - a) * (1 - x) + (d - b) * x) * scale_v
        rest = np.flatnonzero(~inner)
        if len(rest):
            out[:, rest] = self._differences(image, directions[rest])
        # Nothing changes where everything is `fill`.
        return np.nan_to_num(out, copy=False)

    def _differences(self, image: Floats, directions: Floats) -> NDArray[np.float64]:
        """Return what `slopes` does, of lookups to both sides along two tangents."""
        d = directions.astype(np.float64)
        d /= np.linalg.norm(d, axis=-1, keepdims=True)
        # Any vector that is not along the direction.
        other = np.eye(3)[np.abs(np.nan_to_num(d)).argmin(axis=-1)]
        first = np.cross(d, other)
        first /= np.linalg.norm(first, axis=-1, keepdims=True)
        second = np.cross(d, first)
        step = _STEP / max(self.shape[-2:])
        around = [d, *(d + sign * step * t for t in (first, second) for sign in (1, -1))]
        texels = image.astype(np.float64).reshape(*self.shape, -1)
        options: dict[str, Any] = {"fill": np.nan, "any_aspect": True}
        here, *seen = sample(texels, np.stack(around), self.p, **options)
        columns = type(self.p).jacobian(self.p, type(self.p).encode(self.p, d))
        found = np.zeros((2, *here.shape))
        for tangent, ahead, behind in ((first, *seen[:2]), (second, *seen[2:])):
            central = (ahead - behind) / (2 * step)
            # Beside the end of the coverage there is one side.
            sided = np.where(np.isnan(ahead), here - behind, ahead - here) / step
            slope = np.where(np.isnan(central), sided, central)
            found += slope * np.einsum("nk,nkj->jn", tangent, columns)[..., None]
        return found

    def _inside(self, directions: Floats) -> tuple[NDArray[np.bool_], Places, Floats]:
        """Tell which lookups mix four texels that lie side by side in one face, and which."""
        if self.p.layout not in (None, "faces"):
            # Faces in one image: every lookup is looked at.
            empty = np.zeros((4, len(directions)))
            return np.zeros(len(directions), bool), empty.astype(np.int64), empty
        four, x, y = self._four(directions)
        height, width = self.shape[-2:]
        held = np.isfinite(self.p.directions(self.shape)[..., 0]).reshape(-1, height, width)
        numbers = np.where(held, np.arange(self.texels).reshape(held.shape), -1)
        numbers = np.pad(numbers, ((0, 0), (1, 1), (1, 1)), constant_values=-1)
        index = numbers.ravel()[four]
        weights = shares(np, x, y)
        # A direction that is not covered has no weights, as one inside that sees nothing.
        outside = np.isnan(weights[0])
        inner = (index >= 0).all(axis=0) | outside
        return inner, np.where(index < 0, 0, index), np.where(outside, 0.0, weights)


def between(xp: Any, uv: Any, places: Scales, shape: tuple[int, ...]) -> tuple[Any, Any, Any, Any]:
    """Return the column and the row of the first of four texels, and the place between them.

    `xp` is the module of the arrays. Columns and rows are whole numbers as floats, -1 before the
    first; places are NaN where u and v are.
    """
    found = []
    for k, (scale, offset) in enumerate(places):
        at = uv[..., k] * scale + offset
        known = xp.where(xp.isnan(at), 0.0, at)
        first = xp.clip(xp.floor(known), -1, shape[-1 - k] - 1)
        found.append((first, at - first))
    (column, x), (row, y) = found
    return column, row, x, y


def number(shape: tuple[int, ...], column: Any, row: Any, face: Any = 0) -> Any:
    """Return the number of a texel of the padded image, from integers."""
    height, width = shape[-2:]
    return (face * (height + 2) + row + 1) * (width + 2) + column + 1


def steps(shape: tuple[int, ...]) -> list[int]:
    """Return how far four texels of the padded image are from the first."""
    across = shape[-1] + 2
    return [0, 1, across, across + 1]


def shares(xp: Any, x: Any, y: Any) -> Any:
    """Return the weights of four texels (4, n) at places between them."""
    return xp.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y])


@lru_cache(HELD)
def lookups(spec: str, shape: tuple[int, ...]) -> Lookups:
    """Return the lookups in images of a map and a shape, which hold what they have prepared."""
    return Lookups(spec, shape)
