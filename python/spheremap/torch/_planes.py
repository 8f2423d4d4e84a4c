"""What is linear in an image, of images as torch has them in memory: planes, one for each channel.

Kernels take channels last. To turn a whole image takes longer than to convert it; so these
operators take planes, of which a few images at a time are turned in blocks that stay in a core's
cache. What flows back is summed in the planes themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import _core
from ..resample.linear import Linear, linear_of, without_fill
from ._images import derived
from ._operators import define

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from torch import Tensor

    Floats = NDArray[np.floating[Any]]
    # Images in one, their faces, channels, texels of a face.
    Planes = NDArray[np.floating[Any]]

# Images of so many channels are turned together.
_CHANNELS = 24


def are_planes(image: Tensor) -> bool:
    """Tell whether an image lies in memory plane by plane."""
    found: bool = image.is_contiguous()
    return found


def _shape(sides: tuple[int, ...], like: Tensor) -> tuple[int, ...]:
    """Return the shape of images (N, C, H, W) or (N, F, C, H, W) of these sides."""
    return (like.shape[0], *sides[:-2], like.shape[-3], *sides[-2:])


def _planes(images: Tensor) -> Planes:
    found: Planes = images.numpy()
    count, channels = found.shape[0], found.shape[-3]
    faces = math.prod(found.shape[1:-3])
    return found.reshape(count, faces, channels, math.prod(found.shape[-2:]))


def _by_few(run: Callable[[Floats], Floats], images: Tensor, target: tuple[int, ...]) -> Tensor:
    given = images.detach().contiguous()
    if given.shape[0] == 0 or given.shape[-3] == 0:
        # No images, or none of a channel.
        return given.new_zeros(_shape(target, given))
    source = _planes(given)
    # NumPy asks for large pages, and torch does not: half of the time goes into touching new ones.
    out = np.empty(_shape(target, given), source.dtype)
    made = _planes(torch.from_numpy(out))
    each = max(1, _CHANNELS // max(given.shape[-3], 1))
    for first in range(0, given.shape[0], each):
        some = slice(first, first + each)
        found = np.ascontiguousarray(run(_core.texels_of_planes(source[some])))
        _core.planes_of_texels(found, made[some])
    return torch.from_numpy(out)


def _linear(images: Tensor, key: str) -> Tensor:
    made: Linear = linear_of(key)

    def run(columns: Floats) -> Floats:
        return made.run(columns.reshape(*made.source, columns.shape[-1]))

    return _by_few(run, images, made.target)


def _adjoint(gradient: Tensor, key: str) -> Tensor:
    made = linear_of(key)
    given = gradient.detach().contiguous()
    faces = math.prod(made.source[:-2])
    found = made.matrix.adjoint_of_planes(_planes(given), faces)
    if found is None:
        return _by_few(made.matrix.adjoint, gradient, made.source)
    return torch.from_numpy(found.reshape(_shape(made.source, given)))


def _batched(operator: str) -> Callable[..., tuple[Tensor, int]]:
    """Return a rule: more images."""

    def batched(in_dims: tuple[int | None, ...], images: Tensor, key: str) -> tuple[Tensor, int]:
        assert in_dims[0] is not None
        several = images.movedim(in_dims[0], 0)
        found = getattr(torch.ops.spheremap, operator)(several.flatten(0, 1), key)
        return found.unflatten(0, several.shape[:2]), 0

    return batched


linear: Callable[..., Tensor] = define(
    "linear_planes(Tensor images, str key) -> Tensor",
    kernel=_linear,
    fake=lambda images, key: images.new_empty(_shape(linear_of(key).target, images)),
    batched=_batched("linear_planes"),
    reverse=lambda wanted, images, key, result, gradient: (adjoint(gradient, key),),
    forward=lambda images, key, result, tangent: linear(tangent, derived(key)),
)
adjoint: Callable[..., Tensor] = define(
    "linear_planes_adjoint(Tensor gradient, str key) -> Tensor",
    kernel=_adjoint,
    fake=lambda gradient, key: gradient.new_empty(_shape(linear_of(key).source, gradient)),
    batched=_batched("linear_planes_adjoint"),
    reverse=lambda wanted, gradient, key, result, again: (linear(again, without_fill(key)),),
    forward=lambda gradient, key, result, tangent: adjoint(tangent, key),
)
