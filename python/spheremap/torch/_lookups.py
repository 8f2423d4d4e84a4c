"""Which texels a bilinear lookup mixes, and by how much: its adjoint, its derivatives, any device.

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
import torch

from ..map.grid import on_corners, texel
from ..resample import pad, sample
from ..resample.matrix import weights_of
from ._specs import HELD, map_of, on_blocks
from ._verbs import encode

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from torch import Tensor

    from .._projection import Projection


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
    def places(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Factor and offset from u and v to texels, 0 at the center of the first."""
        corners_v, corners_u = on_corners(self.p)
        found = []
        for n, corners in ((self.shape[-1], corners_u), (self.shape[-2], corners_v)):
            first, last = texel(np.array([0.0, 1.0]), n, 1, corners).tolist()
            found.append((last - first, first))
        return found[0], found[1]

    @cached_property
    def padded(self) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor] | None]:
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
            return torch.from_numpy(index), None

        def border(channels: NDArray[np.float64]) -> NDArray[np.float64]:
            whole = pad(channels.reshape(*self.shape, -1), self.p, 1, any_aspect=True)
            return whole.reshape(len(own), -1)[mixed]

        weight, (row, column) = weights_of(border, self.shape, len(mixed))
        index[mixed] = self.texels + np.arange(len(mixed))
        rows = tuple(torch.from_numpy(part) for part in (row, column, weight))
        return torch.from_numpy(index), (rows[0], rows[1], rows[2])

    def four(self, directions: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return four texels of the padded image (4, n), and the places between them, x and y.

        The last are NaN where the image does not hold the direction.
        """
        uv = encode(directions, self.spec)
        (scale_u, offset_u), (scale_v, offset_v) = self.places
        height, width = self.shape[-2:]
        x, y = uv[..., 0] * scale_u + offset_u, uv[..., 1] * scale_v + offset_v
        column = x.nan_to_num(0.0).floor().clamp(-1, width - 1)
        row = y.nan_to_num(0.0).floor().clamp(-1, height - 1)
        across = width + 2
        first = (row.long() + 1) * across + column.long() + 1
        if uv.shape[-1] == 3:
            first += uv[..., 2].nan_to_num(0.0).long() * (across * (height + 2))
        steps = torch.tensor([0, 1, across, across + 1], device=first.device)
        return first + steps[:, None], x - column, y - row

    def mixed(self, directions: Tensor) -> tuple[Tensor, Tensor]:
        """Return four texels of the extended image for each direction, and their weights (4, n)."""
        four, x, y = self.four(directions)
        own = self.padded[0].to(four.device)
        index = own.index_select(0, four.flatten()).view_as(four)
        weights = _shares(x, y)
        return index, weights.nan_to_num(0.0)

    def extended(self, image: Tensor) -> Tensor:
        """Return an image (texels, channels) with what its border is made of at its end."""
        mixed = self.padded[1]
        if mixed is None:
            return image
        row, column, weight = (part.to(image.device) for part in mixed)
        rows = int(row.max()) + 1
        border = image.new_zeros((rows, image.shape[1]))
        border.index_add_(0, row, image[column] * weight.to(image.dtype)[:, None])
        return torch.cat([image, border])

    def looked_up(self, image: Tensor, directions: Tensor, fill: float) -> Tensor:
        """Return values of an image (texels, channels), on any device."""
        index, weights = self.mixed(directions)
        whole = self.extended(image)
        found = sum(w[:, None] * whole[i] for i, w in zip(index, weights, strict=True))
        covered = weights.sum(0) > 0
        return torch.where(covered[:, None], torch.as_tensor(found), fill)

    def slopes(self, image: Tensor, directions: Tensor) -> Tensor:
        """Return the derivatives (2, n, channels) of lookups by u and by v."""
        whole = self.extended(image)
        out = image.new_empty((2, len(directions), image.shape[1]))

        def work(block: slice) -> None:
            out[:, block] = self._slopes(whole, directions[block])

        on_blocks(work, len(directions))
        return out

    def _slopes(self, whole: Tensor, directions: Tensor) -> Tensor:
        if not self.is_whole:
            raise NotImplementedError(
                f"`sample` has no derivative by directions in images of '{self.p.name}', whose "
                "edges or rims are inside its image. `convert` it to 'latlong' or 'octahedral'."
            )
        four, x, y = self.four(directions)
        own = self.padded[0].to(four.device)
        a, b, c, d = (whole.index_select(0, own.index_select(0, one)) for one in four)
        x, y = x[:, None], y[:, None]
        (scale_u, _), (scale_v, _) = self.places
        by_u = ((b - a) * (1 - y) + (d - c) * y) * scale_u
        by_v = ((c - a) * (1 - x) + (d - b) * x) * scale_v
        # Nothing changes where everything is `fill`.
        return torch.stack([by_u, by_v]).nan_to_num(0.0)

    def weights(self, directions: Tensor) -> Any:
        """Return the lookups as a sparse matrix of SciPy, (directions, texels)."""
        from scipy.sparse import csr_matrix

        shape = (len(directions), self.texels)
        if self.is_whole:
            chosen = np.empty((shape[0], 4), np.int32)
            shares = np.empty((shape[0], 4), directions.numpy().dtype)

            def work(block: slice) -> None:
                index, weights = self.mixed(directions[block])
                chosen[block], shares[block] = index.numpy().T, weights.numpy().T

            on_blocks(work, shape[0])
            rows = np.arange(0, 4 * shape[0] + 1, 4, dtype=np.int32)
            parts = (shares.ravel(), chosen.ravel(), rows)
            mixed = self.padded[1]
            if mixed is None:
                return csr_matrix(parts, shape=shape)
            row, column, weight = (part.numpy() for part in mixed)
            count = int(row.max()) + 1
            whole = csr_matrix(parts, shape=(shape[0], self.texels + count))
            border = csr_matrix((weight, (row, column)), shape=(count, self.texels))
            return whole[:, : self.texels] + whole[:, self.texels :] @ border
        inner, numbers = self._inside(directions)
        rest = np.flatnonzero(~inner)
        some = directions.double().numpy()[rest]

        def seen(channels: NDArray[np.float64]) -> NDArray[np.float64]:
            image = channels.reshape(*self.shape, -1)
            return sample(image, some, self.p, any_aspect=True)

        weight, (row, column) = weights_of(seen, self.shape, len(rest))
        index, weights = numbers
        within = np.flatnonzero(inner)
        data = np.concatenate([weights[:, within].T.ravel(), weight])
        rows = np.concatenate([np.repeat(within, 4), rest[row]])
        columns = np.concatenate([index[:, within].T.ravel(), column])
        return csr_matrix((data, (rows, columns)), shape=shape)

    def nearest(self, directions: Tensor) -> Any:
        """Return lookups of the nearest texel as a sparse matrix."""
        from scipy.sparse import csr_matrix

        numbers = np.arange(float(self.texels)).reshape(self.shape)
        some = directions.double().numpy()
        options: dict[str, Any] = {"filter": "nearest", "fill": -1.0, "any_aspect": True}
        column = sample(numbers, some, self.p, **options).astype(np.int64)
        rows = np.flatnonzero(column >= 0)
        parts = (np.ones(len(rows)), (rows, column[rows]))
        return csr_matrix(parts, shape=(len(directions), self.texels))

    def _inside(
        self, directions: Tensor
    ) -> tuple[NDArray[np.bool_], tuple[NDArray[np.int64], NDArray[np.floating[Any]]]]:
        """Tell which lookups mix four texels that lie side by side in one face, and which."""
        if self.p.layout not in (None, "faces"):
            # Faces in one image: every lookup is looked at.
            none = np.zeros(len(directions), bool)
            empty = np.zeros((4, len(directions)))
            return none, (empty.astype(np.int64), empty)
        four, x, y = self.four(directions)
        height, width = self.shape[-2:]
        held = np.isfinite(self.p.directions(self.shape)[..., 0]).reshape(-1, height, width)
        numbers = np.where(held, np.arange(self.texels).reshape(held.shape), -1)
        numbers = np.pad(numbers, ((0, 0), (1, 1), (1, 1)), constant_values=-1)
        index = numbers.ravel()[four.numpy()]
        weights = _shares(x, y).numpy()
        # A direction that is not covered has no weights, as one inside that sees nothing.
        outside = np.isnan(weights[0])
        inner = (index >= 0).all(axis=0) | outside
        return inner, (np.where(index < 0, 0, index), np.where(outside, 0.0, weights))


def _shares(x: Tensor, y: Tensor) -> Tensor:
    """Return the weights of four texels (4, n) at places between them."""
    return torch.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y])


@lru_cache(HELD)
def lookups(spec: str, shape: tuple[int, ...]) -> Lookups:
    """Return the lookups in images of a map and a shape, which hold what they have prepared."""
    return Lookups(spec, shape)
