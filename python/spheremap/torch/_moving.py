"""The verbs of maps whose parameters are tensors, as operators.

Parameters are one tensor of float64; `spec` is the map without them, `names` says which they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from ..map import moving
from ..map.spec import spec_of
from ._operators import define
from ._specs import map_of
from ._verbs import in_image, padded_places, times, width

if TYPE_CHECKING:
    from torch import Tensor

    from .._projection import Projection
    from ..map.named import ProjectionLike


@dataclass(frozen=True)
class Moving:
    """A map with parameters that are tensors."""

    # The text of the map as it is now.
    spec: str
    parameters: dict[str, Tensor]

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={tensor!r}" for name, tensor in self.parameters.items())
        return f"projection({map_of(self.spec)!r}, {given})"

    @property
    def names(self) -> str:
        """The names of the tensors."""
        return ",".join(self.parameters)

    @property
    def numbers(self) -> int:
        """How many numbers a place has."""
        count: int = _numbers(self.spec)
        return count

    @property
    def wants_gradient(self) -> bool:
        """Whether a gradient may be asked for."""
        return torch.is_grad_enabled() and any(t.requires_grad for t in self.parameters.values())

    def together(self) -> Tensor:
        """Return the parameters as one tensor."""
        given = list(self.parameters.values())
        return torch.stack([one.to(given[0].device, torch.float64) for one in given])

    def seen(self, axes: str | None, rotation: Any | None) -> Moving:
        """Return it with other axes, and its world turned."""
        return Moving(_seen(self.spec, axes, rotation), self.parameters)

    def in_world_of(self, other: str) -> Moving:
        """Return it with its directions in the world of the map of a text."""
        return Moving(_in_world_of(self.spec, other), self.parameters)

    def encode(self, directions: Tensor) -> Tensor:
        """Return places."""
        spec = _without(self.spec, self.names)
        return encode(directions, self.together(), spec, self.names, self.numbers)

    def decode(self, uv: Tensor) -> Tensor:
        """Return directions."""
        return decode(uv, self.together(), _without(self.spec, self.names), self.names)

    def rest(self) -> str:
        """Return the text of a map that stands still, in which the same images are looked up."""
        spec: str = _at_rest(self.spec, self.names)
        return spec


# torch's compiler takes what these return as constants.


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _seen(spec: str, axes: str | None, rotation: Any | None) -> str:
    return spec if axes is None and rotation is None else spec_of(map_of(spec), axes, rotation)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _in_world_of(spec: str, other: str) -> str:
    return spec_of(map_of(spec).in_world_of(map_of(other)))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _without(spec: str, names: str) -> str:
    return moving.spec_without(map_of(spec), names.split(","))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _at_rest(spec: str, names: str) -> str:
    return spec_of(moving.at_rest(map_of(spec), names.split(",")))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _numbers(spec: str) -> int:
    return width(map_of(spec))


def now(projection: ProjectionLike | Moving) -> ProjectionLike:
    """Return a map with the numbers that its parameters are."""
    return map_of(projection.spec) if isinstance(projection, Moving) else projection


def projection(name: ProjectionLike, /, **parameters: Any) -> Projection | Moving:
    """Return a projection with parameters that are tensors; see `spheremap.torch.projection`."""
    tensors = {key: value for key, value in parameters.items() if isinstance(value, torch.Tensor)}
    numbers = {key: value for key, value in parameters.items() if key not in tensors}
    if not tensors:
        return moving.made(name, numbers)
    for key, tensor in tensors.items():
        if tensor.ndim != 0 or not tensor.dtype.is_floating_point:
            raise ValueError(
                f"Expected `{key}` to be one float, a tensor without axes, got {tensor.dtype} of "
                f"shape {tuple(tensor.shape)}."
            )
    return Moving(_now(name, numbers, {key: _value(one) for key, one in tensors.items()}), tensors)


def _value(tensor: Tensor) -> float | None:
    """Return the number in a tensor; None where a transform or the compiler hides it."""
    if torch.compiler.is_compiling():
        return None
    try:
        return float(tensor.detach())
    except RuntimeError:
        return None


_now = torch.compiler.assume_constant_result(moving.now)


# Operators ----------------------------------------------------------------------------------------


def _given(parameters: Tensor, spec: str, names: str) -> tuple[str, tuple[str, ...], Any]:
    return spec, tuple(names.split(",")), tuple(parameters.detach().cpu().tolist())


def _value_of(verb: str) -> Callable[..., Tensor]:
    def kernel(data: Tensor, parameters: Tensor, spec: str, names: str, *_: int) -> Tensor:
        p = moving.moved(*_given(parameters, spec, names))
        # NumPy shares the tensor's memory, and torch that of the result.
        found = getattr(p, verb)(data.detach().cpu().numpy())
        return torch.from_numpy(np.asarray(found)).to(data.device)

    return kernel


def _slopes_of(function: Callable[..., Any]) -> Callable[..., Tensor]:
    def kernel(data: Tensor, parameters: Tensor, spec: str, names: str) -> Tensor:
        found = function(*_given(parameters, spec, names), data.detach().cpu().numpy())
        return torch.from_numpy(found).to(data.device, data.dtype)

    return kernel


def _count(names: str) -> int:
    return names.count(",") + 1


def _batched(operator: str) -> Callable[..., tuple[Tensor, int]]:
    """Return a rule: leading axes are alike, and each parameter has a map of its own."""

    def batched(in_dims: tuple[Any, ...], *given: Any) -> tuple[Tensor, int]:
        verb = getattr(torch.ops.spheremap, operator)
        data, parameters, *rest = given
        of_data, of_parameters = in_dims[:2]
        if of_parameters is None:
            return verb(data.movedim(of_data, 0), parameters, *rest), 0
        each = [
            verb(data if of_data is None else data.select(of_data, k), one, *rest)
            for k, one in enumerate(parameters.unbind(of_parameters))
        ]
        return torch.stack(each), 0

    return batched


def _back(slopes: Tensor, gradient: Tensor, places: int) -> tuple[Tensor, Tensor]:
    """Return what flows back to what was mapped and to the parameters, which are all in one."""
    found = times(slopes, gradient)
    of_parameters = found[..., places:].double()
    return found[..., :places], of_parameters.reshape(-1, of_parameters.shape[-1]).sum(0)


def _along(
    slopes: Tensor, places: int, of_data: Tensor | None, of_parameters: Tensor | None
) -> Tensor:
    """Return how the result changes."""
    found = torch.zeros_like(slopes[..., 0])
    if of_data is not None:
        found = found + (slopes[..., :places] * of_data.unsqueeze(-2)).sum(-1)
    if of_parameters is not None:
        found = found + (slopes[..., places:] * of_parameters.to(slopes.dtype)).sum(-1)
    return found


def _encode_reverse(
    wanted: Any,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    count: int,
    uv: Tensor,
    gradient: Tensor,
) -> tuple[Tensor, Tensor]:
    return _back(encode_slopes(directions, parameters, spec, names), in_image(gradient), 3)


def _encode_forward(
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    count: int,
    uv: Tensor,
    of_directions: Tensor | None,
    of_parameters: Tensor | None,
) -> Tensor:
    slopes = encode_slopes(directions, parameters, spec, names)
    return padded_places(_along(slopes, 3, of_directions, of_parameters), uv)


def _decode_reverse(
    wanted: Any,
    uv: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    directions: Tensor,
    gradient: Tensor,
) -> tuple[Tensor, Tensor]:
    of_uv, of_parameters = _back(decode_slopes(uv, parameters, spec, names), gradient, 2)
    return padded_places(of_uv, uv), of_parameters


def _decode_forward(
    uv: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    directions: Tensor,
    of_uv: Tensor | None,
    of_parameters: Tensor | None,
) -> Tensor:
    slopes = decode_slopes(uv, parameters, spec, names)
    return _along(slopes, 2, None if of_uv is None else in_image(of_uv), of_parameters)


encode_slopes: Callable[..., Tensor] = define(
    "moving_encode_slopes(Tensor directions, Tensor parameters, str spec, str names) -> Tensor",
    kernel=_slopes_of(moving.encode_slopes),
    fake=lambda d, _, spec, names: d.new_empty((*d.shape[:-1], 2, 3 + _count(names))),
    batched=_batched("moving_encode_slopes"),
)
decode_slopes: Callable[..., Tensor] = define(
    "moving_decode_slopes(Tensor uv, Tensor parameters, str spec, str names) -> Tensor",
    kernel=_slopes_of(moving.decode_slopes),
    fake=lambda uv, _, spec, names: uv.new_empty((*uv.shape[:-1], 3, 2 + _count(names))),
    batched=_batched("moving_decode_slopes"),
)
encode: Callable[..., Tensor] = define(
    "moving_encode(Tensor directions, Tensor parameters, str spec, str names, int count) -> Tensor",
    kernel=_value_of("encode"),
    fake=lambda d, _, spec, names, count: d.new_empty((*d.shape[:-1], count)),
    batched=_batched("moving_encode"),
    reverse=_encode_reverse,
    forward=_encode_forward,
)
decode: Callable[..., Tensor] = define(
    "moving_decode(Tensor uv, Tensor parameters, str spec, str names) -> Tensor",
    kernel=_value_of("decode"),
    fake=lambda uv, _, spec, names: uv.new_empty((*uv.shape[:-1], 3)),
    batched=_batched("moving_decode"),
    reverse=_decode_reverse,
    forward=_decode_forward,
)
