"""Derivatives of bilinear lookups by directions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import torch

from ..resample import lookups as held
from ._specs import HELD, on_blocks
from ._verbs import encode

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True)
class Lookups:
    """Bilinear lookups in images of one map and shape."""

    taps: held.Lookups

    def four(self, directions: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return four texels of the padded image (4, n), and the places between them, x and y.

        The last are NaN where the image does not hold the direction.
        """
        uv = encode(directions, self.taps.spec)
        column, row, x, y = held.between(torch, uv, self.taps.places, self.taps.shape)
        face = uv[..., 2].nan_to_num(0.0).long() if uv.shape[-1] == 3 else 0
        first = held.number(self.taps.shape, column.long(), row.long(), face)
        steps = torch.tensor(held.steps(self.taps.shape), device=first.device)
        return first + steps[:, None], x, y

    def _own(self, four: Tensor) -> Tensor:
        return torch.from_numpy(self.taps.padded[0]).to(four.device)

    def extended(self, image: Tensor) -> Tensor:
        """Return an image (texels, channels) with what its border is made of at its end."""
        mixed = self.taps.padded[1]
        if mixed is None:
            return image
        row, column, weight = (torch.from_numpy(part).to(image.device) for part in mixed)
        border = image.new_zeros((self.taps.mixes, image.shape[1]))
        border.index_add_(0, row, image[column] * weight.to(image.dtype)[:, None])
        return torch.cat([image, border])

    def slopes(self, image: Tensor, directions: Tensor) -> Tensor:
        """Return the derivatives (2, n, channels) of lookups by u and by v."""
        if not self.taps.is_whole:
            given = image.detach().cpu().numpy(), directions.detach().cpu().numpy()
            return torch.from_numpy(self.taps.slopes(*given)).to(image.device)
        whole = self.extended(image)
        out = image.new_empty((2, len(directions), image.shape[1]))

        def work(block: slice) -> None:
            out[:, block] = self._slopes(whole, directions[block])

        on_blocks(work, len(directions))
        return out

    def _slopes(self, whole: Tensor, directions: Tensor) -> Tensor:
        four, x, y = self.four(directions)
        own = self._own(four)
        a, b, c, d = (whole.index_select(0, own.index_select(0, one)) for one in four)
        x, y = x[:, None], y[:, None]
        (scale_u, _), (scale_v, _) = self.taps.places
        by_u = ((b - a) * (1 - y) + (d - c) * y) * scale_u
        by_v = ((c - a) * (1 - x) + (d - b) * x) * scale_v
        # Nothing changes where everything is `fill`.
        return torch.stack([by_u, by_v]).nan_to_num(0.0)


@lru_cache(HELD)
def lookups(spec: str, shape: tuple[int, ...]) -> Lookups:
    """Return the lookups in images of a map and a shape."""
    return Lookups(held.lookups(spec, shape))
