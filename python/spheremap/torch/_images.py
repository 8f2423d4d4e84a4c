"""The verbs of images as operators: lookups, and what is linear in an image, with adjoints.

Here an image has its channels last, batches among them: (H, W, channels), (F, N, N, channels).
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import torch

from .. import resample
from ..resample.linear import MATRICES, linear_of, without_fill
from . import _verbs
from ._lookups import lookups
from ._operators import alike, define, has_kernel, product
from ._specs import map_of

if TYPE_CHECKING:
    from torch import Tensor


def _flat(image: Tensor, axes: int) -> Tensor:
    return image.reshape(math.prod(image.shape[:axes]), image.shape[-1])


def nothing(kernel: Callable[..., Tensor], shape: Callable[..., tuple[int, ...]]) -> Any:
    """Return a kernel that makes nothing of an image without channels, which those of NumPy refuse.

    `shape` takes its arguments and returns the shape of the result but for the channels.
    """

    def checked(image: Tensor, *given: Any) -> Tensor:
        if image.shape[-1] == 0:
            return image.new_zeros((*shape(image, *given), 0))
        return kernel(image, *given)

    return checked


def by_channels(name: str) -> Callable[..., tuple[Tensor, int]]:
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
    if has_kernel(image):
        return torch.from_numpy(made.run(image.detach().numpy()))
    if not made.has_matrix:
        # Finding it takes longer than many calls.
        return torch.from_numpy(made.run(image.detach().cpu().numpy())).to(image.device)
    columns = _flat(image, len(made.source))
    found = product(held_matrix(key, False, image.device, image.dtype), columns)
    if made.fill != 0.0:
        found[torch.from_numpy(made.empty).to(image.device)] = made.fill
    return found.reshape(*made.target, -1)


def _linear_adjoint(gradient: Tensor, key: str) -> Tensor:
    made = linear_of(key)
    columns = _flat(gradient, len(made.target))
    if has_kernel(gradient):
        found = torch.from_numpy(made.matrix.adjoint(columns.detach().numpy()))
    else:
        found = product(held_matrix(key, True, gradient.device, gradient.dtype), columns)
    return found.reshape(*made.source, -1)


@lru_cache(MATRICES)
def held_matrix(key: str, is_adjoint: bool, device: torch.device, dtype: torch.dtype) -> Tensor:
    """Return the matrix of a key on a device."""
    weights = linear_of(key).matrix.weights
    rows = (weights.T if is_adjoint else weights).tocsr()
    parts = [torch.from_numpy(part) for part in (rows.indptr, rows.indices, rows.data)]
    with warnings.catch_warnings():
        # torch says once that its sparse matrices may change, and once that it does not check them.
        warnings.filterwarnings("ignore", "Sparse ")
        made = torch.sparse_csr_tensor(*parts, rows.shape, check_invariants=False)
    return made.to(device=device, dtype=dtype)


def _linear_reverse(
    wanted: Any, image: Tensor, key: str, result: Tensor, gradient: Tensor
) -> tuple[Tensor]:
    return (linear_adjoint(gradient, key),)


def derived(key: str) -> str:
    """Return the key of the derivative of what a key makes: the same but for what is no sum."""
    if json.loads(key)["filter"] == "mode":
        raise NotImplementedError("`convert` with filter='mode' has no gradient.")
    return without_fill(key)


def _linear_forward(image: Tensor, key: str, result: Tensor, tangent: Tensor) -> Tensor:
    return linear(tangent, derived(key))


def _linear_adjoint_reverse(
    wanted: Any, gradient: Tensor, key: str, result: Tensor, again: Tensor
) -> tuple[Tensor]:
    return (linear(again, without_fill(key)),)


def _linear_adjoint_forward(gradient: Tensor, key: str, result: Tensor, tangent: Tensor) -> Tensor:
    return linear_adjoint(tangent, key)


linear_adjoint: Callable[..., Tensor] = define(
    "linear_adjoint(Tensor gradient, str key) -> Tensor",
    kernel=nothing(_linear_adjoint, lambda g, key: linear_of(key).source),
    fake=lambda g, key: g.new_empty((*linear_of(key).source, g.shape[-1])),
    batched=by_channels("linear_adjoint"),
    reverse=_linear_adjoint_reverse,
    forward=_linear_adjoint_forward,
)
linear: Callable[..., Tensor] = define(
    "linear(Tensor image, str key) -> Tensor",
    kernel=nothing(_linear, lambda image, key: linear_of(key).target),
    fake=lambda image, key: image.new_empty((*linear_of(key).target, image.shape[-1])),
    batched=by_channels("linear"),
    reverse=_linear_reverse,
    forward=_linear_forward,
)

# Lookups ------------------------------------------------------------------------------------------


def _sample(image: Tensor, directions: Tensor, spec: str, filter: str, fill: float) -> Tensor:
    found = resample.sample(
        image.detach().cpu().numpy(),
        directions.detach().cpu().numpy(),
        map_of(spec),
        filter=filter,
        fill=fill,
        any_aspect=True,
    )
    return torch.from_numpy(found).to(image.device)


def _sample_adjoint(
    gradient: Tensor, directions: Tensor, spec: str, filter: str, shape: list[int]
) -> Tensor:
    made = lookups(spec, tuple(shape))
    columns = gradient.reshape(-1, gradient.shape[-1])
    flat = directions.reshape(-1, 3)
    found = made.taps.adjoint(columns.detach().cpu().numpy(), flat.detach().cpu().numpy(), filter)
    return torch.from_numpy(found).reshape(*shape, -1).to(gradient.device)


def _expect_bilinear(filter: str) -> None:
    if filter != "bilinear":
        raise NotImplementedError(
            f"`sample` with filter={filter!r} has no derivative by directions; 'bilinear' has."
        )


def _sample_places(
    image: Tensor, directions: Tensor, gradient: Tensor, spec: str, filter: str
) -> Tensor:
    _expect_bilinear(filter)
    if image.shape[-1] == 0:
        return image.new_zeros((*directions.shape[:-1], 2))
    made = lookups(spec, tuple(image.shape[:-1]))
    texels = _flat(image, image.ndim - 1).detach().cpu().numpy()
    columns = gradient.reshape(-1, gradient.shape[-1]).detach().cpu().numpy()
    looked = directions.reshape(-1, 3).detach().cpu().numpy()
    found = torch.from_numpy(made.taps.pulled(texels, looked, columns))
    return found.reshape(*directions.shape[:-1], 2).to(image.device)


def _places_batched(in_dims: tuple[int | None, ...], *given: Any) -> tuple[Tensor, int]:
    image, directions, gradient = alike(in_dims, *given[:3])
    each = zip(image, directions, gradient, strict=True)
    return torch.stack([sample_places(*one, *given[3:]) for one in each]), 0


def _sample_slopes(image: Tensor, directions: Tensor, spec: str, filter: str) -> Tensor:
    _expect_bilinear(filter)
    made = lookups(spec, tuple(image.shape[:-1]))
    found = made.slopes(_flat(image, image.ndim - 1), directions.reshape(-1, 3))
    return found.reshape(2, *directions.shape[:-1], image.shape[-1])


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
        of_uv = sample_places(image, directions, gradient, spec, filter)
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
        found = found + along_slopes(slopes, along)
    return found


def along_slopes(slopes: Tensor, of_uv: Tensor) -> Tensor:
    """Return how lookups change with the places that they are at.

    Where nothing changes between texels, as outside the coverage, a place that has no derivative
    spoils nothing.
    """
    terms = slopes * of_uv[..., :2].movedim(-1, 0).unsqueeze(-1)
    return torch.where(slopes == 0, 0.0, terms).sum(0)


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
        raise NotImplementedError(NO_SECOND)
    return sample(again, directions, spec, filter, 0.0), None


def _adjoint_forward(
    gradient: Tensor,
    directions: Tensor,
    spec: str,
    filter: str,
    shape: list[int],
    result: Tensor,
    of_gradient: Tensor | None,
    of_directions: Tensor | None,
) -> Tensor:
    if of_directions is not None or of_gradient is None:
        raise NotImplementedError(NO_SECOND)
    return sample_adjoint(of_gradient, directions, spec, filter, shape)


NO_SECOND = "`sample` has no second derivative by directions."

sample_places = define(
    "sample_places(Tensor image, Tensor directions, Tensor gradient, str spec, str filter)"
    " -> Tensor",
    kernel=_sample_places,
    fake=lambda image, d, gradient, spec, filter: image.new_empty((*d.shape[:-1], 2)),
    batched=_places_batched,
    none=NO_SECOND,
)
sample_slopes = define(
    "sample_slopes(Tensor image, Tensor directions, str spec, str filter) -> Tensor",
    kernel=nothing(_sample_slopes, lambda image, d, *_: (2, *d.shape[:-1])),
    fake=lambda image, d, spec, filter: image.new_empty((2, *d.shape[:-1], image.shape[-1])),
    batched=by_channels("sample_slopes"),
    none=NO_SECOND,
)
sample_adjoint = define(
    "sample_adjoint(Tensor gradient, Tensor directions, str spec, str filter, SymInt[] shape)"
    " -> Tensor",
    kernel=nothing(_sample_adjoint, lambda g, d, spec, filter, shape: tuple(shape)),
    fake=lambda g, d, spec, filter, shape: g.new_empty((*shape, g.shape[-1])),
    batched=by_channels("sample_adjoint"),
    reverse=_adjoint_reverse,
    forward=_adjoint_forward,
)
sample = define(
    "sample(Tensor image, Tensor directions, str spec, str filter, float fill) -> Tensor",
    kernel=nothing(_sample, lambda image, d, *_: tuple(d.shape[:-1])),
    fake=lambda image, d, spec, filter, fill: image.new_empty((*d.shape[:-1], image.shape[-1])),
    batched=by_channels("sample"),
    reverse=_sample_reverse,
    forward=_sample_forward,
)
