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
from ..map.grid import places
from ..map.images import target_shape
from . import _images
from ._operators import alike, define, is_hidden, is_moving
from ._specs import map_of, spec_of
from ._verbs import in_image, padded_places, times, width

if TYPE_CHECKING:
    from torch import Tensor

    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike


# An image whose shape tells aspects apart that differ by a hundredth.
_FINE = 4096

_NO_SECOND = "Maps with parameters that are tensors have no second derivative."


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
    def is_moving(self) -> bool:
        """Whether what is made with it must follow the tensors."""
        return any(is_moving(one) for one in self.parameters.values())

    @property
    def is_hidden(self) -> bool:
        """Whether a transform or the compiler hides a number."""
        return any(is_hidden(one) for one in self.parameters.values())

    def expect_shape(self, size: Size | None) -> None:
        """Expect a size that is one shape, whatever the hidden numbers are."""
        if not self.is_hidden:
            return
        if size is None or (isinstance(size, int) and _changes_shape(self.spec, self.names)):
            raise ValueError(
                "Expected `size` as all sides, rows and columns, since the parameters of a map are "
                "not known here."
            )

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

    def sample(self, image: Tensor, directions: Tensor, filter: str, fill: float) -> Tensor:
        """Return values (..., channels) of an image, channels last, in directions."""
        spec = _without(self.spec, self.names)
        return sample(image, directions, self.together(), spec, self.names, filter, fill)


# torch's compiler takes what these return as constants.


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _seen(spec: str, axes: str | None, rotation: Any | None) -> str:
    if axes is None and rotation is None:
        return spec
    found: str = spec_of(map_of(spec), axes, rotation)
    return found


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _in_world_of(spec: str, other: str) -> str:
    found: str = spec_of(map_of(spec).in_world_of(map_of(other)))
    return found


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _without(spec: str, names: str) -> str:
    return moving.spec_without(map_of(spec), names.split(","))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _changes_shape(spec: str, names: str) -> bool:
    """Tell whether parameters change the shape that a size of one number stands for."""
    p = map_of(spec)
    rest = moving.spec_without(p, names.split(","))
    values = {name: p.parameters[name] for name in names.split(",")}

    def shape(**changed: float) -> tuple[int, ...]:
        given = values | changed
        return moving.moved(rest, tuple(given), tuple(given.values())).shape(_FINE)

    # A little less of each: ranges may end where a number is.
    return any(shape(**{name: 0.98 * one - 0.01}) != shape() for name, one in values.items())


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def texels(spec: str, shape: tuple[int, ...]) -> Tensor:
    """Return the places of an image's texels, also of those that a map holds with other numbers."""
    return torch.from_numpy(places(map_of(spec), shape))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def shape_of(spec: str, size: Size, any_aspect: bool) -> tuple[int, ...]:
    """Return the shape that a size stands for."""
    p = map_of(spec)
    return p.shape(target_shape(p, size, any_aspect))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _numbers(spec: str) -> int:
    return width(map_of(spec))


def text_of(projection: ProjectionLike | Moving) -> str:
    """Return the text of a map, with the numbers that its parameters are where they are known."""
    spec: str = projection.spec if isinstance(projection, Moving) else spec_of(projection)
    return spec


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
    return None if is_hidden(tensor) else float(tensor.detach())


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
    none=_NO_SECOND,
)
decode_slopes: Callable[..., Tensor] = define(
    "moving_decode_slopes(Tensor uv, Tensor parameters, str spec, str names) -> Tensor",
    kernel=_slopes_of(moving.decode_slopes),
    fake=lambda uv, _, spec, names: uv.new_empty((*uv.shape[:-1], 3, 2 + _count(names))),
    batched=_batched("moving_decode_slopes"),
    none=_NO_SECOND,
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

# Lookups ------------------------------------------------------------------------------------------


def _standing(spec: str, names: str, directions: Tensor, parameters: Tensor) -> tuple[str, Tensor]:
    """Return a map that stands still and what directions are in it: images are looked up alike.

    So what is prepared for lookups serves all steps of a search.
    """
    given = _given(parameters, spec, names)
    p = moving.moved(*given)
    rest = moving.at_rest(p, given[1])
    looked = rest.decode(p.encode(directions.detach().cpu().numpy()))
    return spec_of(rest), torch.from_numpy(looked).to(directions.device)


def _sample(
    image: Tensor,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
    fill: float,
) -> Tensor:
    rest, looked = _standing(spec, names, directions, parameters)
    return _images.sample(image, looked, rest, filter, fill)


def _adjoint(
    gradient: Tensor,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
    shape: list[int],
) -> Tensor:
    rest, looked = _standing(spec, names, directions, parameters)
    return _images.sample_adjoint(gradient, looked, rest, filter, shape)


def _places(
    image: Tensor,
    directions: Tensor,
    gradient: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
) -> Tensor:
    rest, looked = _standing(spec, names, directions, parameters)
    return _images.sample_places(image, looked, gradient, rest, filter)


def _slopes(
    image: Tensor, directions: Tensor, parameters: Tensor, spec: str, names: str, filter: str
) -> Tensor:
    rest, looked = _standing(spec, names, directions, parameters)
    return _images.sample_slopes(image, looked, rest, filter)


def _places_batched(in_dims: tuple[Any, ...], *given: Any) -> tuple[Tensor, int]:
    each = zip(*alike(in_dims, *given[:4]), strict=True)
    return torch.stack([sample_places(*one, *given[4:]) for one in each]), 0


def _sample_reverse(
    wanted: Any,
    image: Tensor,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
    fill: float,
    result: Tensor,
    gradient: Tensor,
) -> tuple[Tensor | None, Tensor | None, Tensor | None]:
    of_image = of_directions = of_parameters = None
    given = directions, parameters, spec, names
    if wanted[0]:
        of_image = sample_adjoint(gradient, *given, filter, list(image.shape[:-1]))
    if wanted[1] or wanted[2]:
        of_uv = sample_places(image, directions, gradient, parameters, spec, names, filter)
        of_directions, of_parameters = _back(encode_slopes(*given), of_uv, 3)
    return of_image, of_directions, of_parameters


def _sample_forward(
    image: Tensor,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
    fill: float,
    result: Tensor,
    of_image: Tensor | None,
    of_directions: Tensor | None,
    of_parameters: Tensor | None,
) -> Tensor:
    found = torch.zeros_like(result)
    given = directions, parameters, spec, names
    if of_image is not None:
        found = found + sample(of_image, *given, filter, 0.0)
    if of_directions is not None or of_parameters is not None:
        along = _along(encode_slopes(*given), 3, of_directions, of_parameters)
        found = found + _images.along_slopes(sample_slopes(image, *given, filter), along)
    return found


def _adjoint_reverse(
    wanted: Any,
    gradient: Tensor,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
    shape: list[int],
    result: Tensor,
    again: Tensor,
) -> tuple[Tensor, None, None]:
    if wanted[1] or wanted[2]:
        raise NotImplementedError(_images.NO_SECOND)
    return sample(again, directions, parameters, spec, names, filter, 0.0), None, None


def _adjoint_forward(
    gradient: Tensor,
    directions: Tensor,
    parameters: Tensor,
    spec: str,
    names: str,
    filter: str,
    shape: list[int],
    result: Tensor,
    *tangents: Tensor | None,
) -> Tensor:
    of_gradient, *others = tangents
    if of_gradient is None or any(one is not None for one in others):
        raise NotImplementedError(_images.NO_SECOND)
    return sample_adjoint(of_gradient, directions, parameters, spec, names, filter, shape)


sample_places: Callable[..., Tensor] = define(
    "moving_sample_places(Tensor image, Tensor directions, Tensor gradient, Tensor parameters,"
    " str spec, str names, str filter) -> Tensor",
    kernel=_places,
    fake=lambda image, d, *_: image.new_empty((*d.shape[:-1], 2)),
    batched=_places_batched,
    none=_images.NO_SECOND,
)
sample_slopes: Callable[..., Tensor] = define(
    "moving_sample_slopes(Tensor image, Tensor directions, Tensor parameters, str spec, str names,"
    " str filter) -> Tensor",
    kernel=_slopes,
    fake=lambda image, d, *_: image.new_empty((2, *d.shape[:-1], image.shape[-1])),
    batched=_images.by_channels("moving_sample_slopes"),
    none=_images.NO_SECOND,
)
sample_adjoint: Callable[..., Tensor] = define(
    "moving_sample_adjoint(Tensor gradient, Tensor directions, Tensor parameters, str spec,"
    " str names, str filter, SymInt[] shape) -> Tensor",
    kernel=_adjoint,
    fake=lambda g, d, parameters, spec, names, filter, shape: g.new_empty((*shape, g.shape[-1])),
    batched=_images.by_channels("moving_sample_adjoint"),
    reverse=_adjoint_reverse,
    forward=_adjoint_forward,
)
sample: Callable[..., Tensor] = define(
    "moving_sample(Tensor image, Tensor directions, Tensor parameters, str spec, str names,"
    " str filter, float fill) -> Tensor",
    kernel=_sample,
    fake=lambda image, d, *_: image.new_empty((*d.shape[:-1], image.shape[-1])),
    batched=_images.by_channels("moving_sample"),
    reverse=_sample_reverse,
    forward=_sample_forward,
)
