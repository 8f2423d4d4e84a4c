"""The verbs of images as operators: lookups, and what is linear in an image, with adjoints.

Here an image has its channels last, batches among them: (H, W, channels), (F, N, N, channels).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import resample
from ..resample.linear import linear_of, without_fill
from . import _verbs
from ._lookups import lookups
from ._operators import define
from ._specs import map_of

if TYPE_CHECKING:
    from torch import Tensor


def _flat(image: Tensor, axes: int) -> Tensor:
    return image.reshape(math.prod(image.shape[:axes]), image.shape[-1])


def _by_channels(name: str) -> Callable[..., tuple[Tensor, int]]:
    """Return a rule for what treats channels alike: more of the first tensor's are more channels.

    Where other tensors have the axis it is done one by one.
    """

    def batched(in_dims: tuple[int | None, ...], *given: Any) -> tuple[Tensor, int]:
        operator = getattr(torch.ops.spheremap, name)
        first = in_dims[0]
        if first is not None and not any(isinstance(axis, int) for axis in in_dims[1:]):
            image = given[0].movedim(first, -1)
            found = operator(image.flatten(-2), *given[1:])
            return found.unflatten(-1, image.shape[-2:]), found.ndim
        pairs = list(zip(given, in_dims, strict=True))
        count = next(t.shape[k] for t, k in pairs if isinstance(k, int))
        each = [
            operator(*(t.select(k, n) if isinstance(k, int) else t for t, k in pairs))
            for n in range(count)
        ]
        return torch.stack(each), 0

    return batched


# What is linear -----------------------------------------------------------------------------------


def _linear(image: Tensor, key: str) -> Tensor:
    made = linear_of(key)
    if image.device.type == "cpu":
        return torch.from_numpy(made.run(image.detach().numpy()))
    columns = _flat(image, len(made.source))
    found = torch.sparse.mm(_on(columns, made.matrix.weights), columns)
    if made.fill != 0.0:
        found[torch.from_numpy(made.empty).to(image.device)] = made.fill
    return found.reshape(*made.target, -1)


def _linear_adjoint(gradient: Tensor, key: str) -> Tensor:
    made = linear_of(key)
    columns = _flat(gradient, len(made.target))
    if gradient.device.type == "cpu":
        found = torch.from_numpy(made.matrix.adjoint(columns.detach().numpy()))
    else:
        found = torch.sparse.mm(_on(columns, made.matrix.weights.T), columns)
    return found.reshape(*made.source, -1)


def _on(given: Tensor, weights: Any) -> Tensor:
    """Return a sparse matrix where a tensor is."""
    held = weights.tocoo()
    index = torch.from_numpy(np.stack([held.row, held.col]).astype(np.int64))
    values = torch.from_numpy(held.data).to(given.dtype)
    made = torch.sparse_coo_tensor(index, values, held.shape, check_invariants=False)
    return made.to(given.device)


def _linear_reverse(
    wanted: Any, image: Tensor, key: str, result: Tensor, gradient: Tensor
) -> tuple[Tensor]:
    return (linear_adjoint(gradient, key),)


def _linear_forward(image: Tensor, key: str, result: Tensor, tangent: Tensor) -> Tensor:
    return linear(tangent, without_fill(key))


def _linear_adjoint_reverse(
    wanted: Any, gradient: Tensor, key: str, result: Tensor, again: Tensor
) -> tuple[Tensor]:
    return (linear(again, without_fill(key)),)


def _linear_adjoint_forward(gradient: Tensor, key: str, result: Tensor, tangent: Tensor) -> Tensor:
    return linear_adjoint(tangent, key)


linear_adjoint: Callable[..., Tensor] = define(
    "linear_adjoint(Tensor gradient, str key) -> Tensor",
    kernel=_linear_adjoint,
    fake=lambda g, key: g.new_empty((*linear_of(key).source, g.shape[-1])),
    batched=_by_channels("linear_adjoint"),
    reverse=_linear_adjoint_reverse,
    forward=_linear_adjoint_forward,
)
linear: Callable[..., Tensor] = define(
    "linear(Tensor image, str key) -> Tensor",
    kernel=_linear,
    fake=lambda image, key: image.new_empty((*linear_of(key).target, image.shape[-1])),
    batched=_by_channels("linear"),
    reverse=_linear_reverse,
    forward=_linear_forward,
)

# Lookups ------------------------------------------------------------------------------------------


def _sample(image: Tensor, directions: Tensor, spec: str, filter: str, fill: float) -> Tensor:
    if image.device.type == "cpu":
        found = resample.sample(
            image.detach().numpy(),
            directions.detach().numpy(),
            map_of(spec),
            filter=filter,
            fill=fill,
            any_aspect=True,
        )
        return torch.from_numpy(found)
    made = lookups(spec, tuple(image.shape[:-1]))
    if filter != "bilinear" or not made.taps.is_whole:
        raise NotImplementedError(
            "Where there are no kernels `sample` is bilinear, in images without rims and faces."
        )
    found = made.looked_up(_flat(image, image.ndim - 1), directions.reshape(-1, 3), fill)
    return found.reshape(*directions.shape[:-1], -1)


def _sample_adjoint(
    gradient: Tensor, directions: Tensor, spec: str, filter: str, shape: list[int]
) -> Tensor:
    made = lookups(spec, tuple(shape))
    columns = gradient.reshape(-1, gradient.shape[-1])
    flat = directions.reshape(-1, 3)
    if gradient.device.type != "cpu":
        index, weights = made.mixed(flat)
        if made.taps.padded[1] is not None or not made.taps.is_whole:
            raise NotImplementedError(f"No gradient of lookups in '{made.taps.p.name}' there yet.")
        out = gradient.new_zeros((made.taps.texels, columns.shape[1]))
        for i, w in zip(index, weights, strict=True):
            out.index_add_(0, i, columns * w.to(columns.dtype)[:, None])
        return out.reshape(*shape, -1)
    found = made.taps.adjoint(columns.detach().numpy(), flat.detach().numpy(), filter)
    return torch.from_numpy(found).reshape(*shape, -1)


def _sample_slopes(image: Tensor, directions: Tensor, spec: str, filter: str) -> Tensor:
    if filter != "bilinear":
        raise NotImplementedError(
            f"`sample` with filter={filter!r} has no derivative by directions; 'bilinear' has."
        )
    made = lookups(spec, tuple(image.shape[:-1]))
    found = made.slopes(_flat(image, image.ndim - 1), directions.reshape(-1, 3))
    return found.reshape(2, *directions.shape[:-1], -1)


def _sample_reverse(
    wanted: Any,
    image: Tensor,
    directions: Tensor,
    spec: str,
    filter: str,
    fill: float,
    result: Tensor,
    gradient: Tensor,
) -> tuple[Tensor | None, Tensor | None]:
    of_image = of_directions = None
    if wanted[0]:
        shape = list(image.shape[:-1])
        of_image = sample_adjoint(gradient, directions, spec, filter, shape)
    if wanted[1]:
        slopes = sample_slopes(image, directions, spec, filter)
        of_uv = (slopes * gradient).sum(-1).movedim(0, -1)
        of_directions = _verbs.encode_gradient(directions, of_uv, spec)
    return of_image, of_directions


def _sample_forward(
    image: Tensor,
    directions: Tensor,
    spec: str,
    filter: str,
    fill: float,
    result: Tensor,
    of_image: Tensor | None,
    of_directions: Tensor | None,
) -> Tensor:
    found = torch.zeros_like(result)
    if of_image is not None:
        found = found + sample(of_image, directions, spec, filter, 0.0)
    if of_directions is not None:
        slopes = sample_slopes(image, directions, spec, filter)
        along = _verbs.encode_tangent(directions, spec, of_directions)
        found = found + slopes[0] * along[..., :1] + slopes[1] * along[..., 1:2]
    return found


def _adjoint_reverse(
    wanted: Any,
    gradient: Tensor,
    directions: Tensor,
    spec: str,
    filter: str,
    shape: list[int],
    result: Tensor,
    again: Tensor,
) -> tuple[Tensor | None, None]:
    if wanted[1]:
        raise NotImplementedError("`sample` has no second derivative by directions.")
    return sample(again, directions, spec, filter, 0.0), None


sample_slopes = define(
    "sample_slopes(Tensor image, Tensor directions, str spec, str filter) -> Tensor",
    kernel=_sample_slopes,
    fake=lambda image, d, spec, filter: image.new_empty((2, *d.shape[:-1], image.shape[-1])),
    batched=_by_channels("sample_slopes"),
)
sample_adjoint = define(
    "sample_adjoint(Tensor gradient, Tensor directions, str spec, str filter, SymInt[] shape)"
    " -> Tensor",
    kernel=_sample_adjoint,
    fake=lambda g, d, spec, filter, shape: g.new_empty((*shape, g.shape[-1])),
    batched=_by_channels("sample_adjoint"),
    reverse=_adjoint_reverse,
)
sample = define(
    "sample(Tensor image, Tensor directions, str spec, str filter, float fill) -> Tensor",
    kernel=_sample,
    fake=lambda image, d, spec, filter, fill: image.new_empty((*d.shape[:-1], image.shape[-1])),
    batched=_by_channels("sample"),
    reverse=_sample_reverse,
    forward=_sample_forward,
)
