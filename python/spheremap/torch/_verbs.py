"""The verbs of one map as operators, and how each changes with what it is given.

First derivatives are those of `jacobian`, which the kernels compute. Only what `jacobian` and
`density` change by is derived from printed code.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import _core
from ._operators import alike, define, has_kernel, power_of_two
from ._printed import by_place, run
from ._specs import map_of

if TYPE_CHECKING:
    from torch import Tensor

    from .._projection import Projection


def _kernel(verb: str) -> Callable[[Tensor, str], Tensor]:
    def kernel(data: Tensor, spec: str) -> Tensor:
        if not has_kernel(data):
            return run(verb, data, spec)
        # NumPy shares the tensor's memory, and torch that of the result.
        return torch.from_numpy(np.asarray(getattr(map_of(spec), verb)(data.detach().numpy())))

    return kernel


def _by_printed_code(verb: str) -> Callable[[Tensor, str], Tensor]:
    return lambda data, spec: run(verb, data, spec)


def _derived(verb: str) -> Callable[[Tensor, str], Tensor]:
    def kernel(uv: Tensor, spec: str) -> Tensor:
        return by_place(verb, uv, spec)

    return kernel


def _fake(tail: Callable[[int], tuple[int, ...]]) -> Callable[[Tensor, str], Tensor]:
    def fake(data: Tensor, spec: str) -> Tensor:
        return data.new_empty((*data.shape[:-1], *tail(width(map_of(spec)))))

    return fake


def width(p: Projection) -> int:
    """Return how many numbers a place of a map has: that of the face is the third."""
    return 3 if p.layout == "faces" else 2


def _batched(operator: str) -> Callable[..., tuple[Tensor, int]]:
    """Return a rule for what works on all leading axes alike."""

    def batched(in_dims: tuple[int | None, ...], data: Tensor, spec: str) -> tuple[Tensor, int]:
        axis = in_dims[0]
        assert axis is not None
        found: Tensor = getattr(torch.ops.spheremap, operator)(data.movedim(axis, 0), spec)
        return found, 0

    return batched


def times(matrix: Tensor, gradient: Tensor) -> Tensor:
    """Return the gradient that flows back through a matrix (..., m, n), none of it where none came.

    A place outside the valid image has NaN for a matrix.
    """
    rows = gradient.unsqueeze(-1)
    return torch.where(rows == 0, 0.0, rows * matrix).sum(-2)


def in_image(numbers: Tensor) -> Tensor:
    """Return u and v of places, without the face."""
    # A slice that is the whole is no view that the older vmap of `torch.autograd` knows.
    return numbers if numbers.shape[-1] == 2 else numbers[..., :2]


def padded_places(columns: Tensor, uv: Tensor) -> Tensor:
    """Return derivatives by u and v as those by all numbers of a place: faces do not change."""
    missing = uv.shape[-1] - columns.shape[-1]
    return torch.nn.functional.pad(columns, (0, missing))


class _Inverse:
    """The derivatives of u and v by a direction: the inverse of `jacobian`.

    Of its two columns the products make a 2x2 matrix, whose inverse takes them to two rows that are
    tangent to the sphere. All is written in components, which torch is fastest with.
    """

    def __init__(self, directions: Tensor, uv: Tensor, spec: str) -> None:
        # Squares of the largest and the smallest have no width.
        size = directions.detach().abs().amax(-1, keepdim=True)
        columns = jacobian(uv, spec)
        self._u, self._v = (columns[..., k].unbind(-1) for k in range(2))
        self._a, self._b = _dot(self._u, self._u), _dot(self._u, self._v)
        self._c = _dot(self._v, self._v)
        length = torch.linalg.vector_norm(directions / size, dim=-1)
        self._over = 1.0 / ((self._a * self._c - self._b * self._b) * length) / size.squeeze(-1)

    def _solved(self, u: Tensor, v: Tensor) -> tuple[Tensor, Tensor]:
        first = (self._c * u - self._b * v) * self._over
        return first, (self._a * v - self._b * u) * self._over

    def gradient(self, of_uv: Tensor) -> Tensor:
        """Return what flows back to directions, none of it where none came.

        A direction outside the coverage has NaN for an inverse: it spoils no sum that leaves it
        out.
        """
        u, v = of_uv.unbind(-1)
        first, second = self._solved(u, v)
        pairs = zip(self._u, self._v, strict=True)
        found = torch.stack([p * first + q * second for p, q in pairs], dim=-1)
        return torch.where(((u == 0) & (v == 0)).unsqueeze(-1), 0.0, found)

    def tangent(self, of_directions: Tensor) -> Tensor:
        """Return how u and v change."""
        along = of_directions.unbind(-1)
        return torch.stack(self._solved(_dot(self._u, along), _dot(self._v, along)), dim=-1)


def _dot(a: Sequence[Tensor], b: Sequence[Tensor]) -> Tensor:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _composed(directions: Tensor, gradient: Tensor, spec: str) -> Tensor:
    """Return the gradient of directions, from that of their u and v."""
    return _Inverse(directions, encode(directions, spec), spec).gradient(gradient)


def _encode_gradient(directions: Tensor, gradient: Tensor, spec: str) -> Tensor:
    if not has_kernel(directions):
        return _composed(directions, gradient, spec)
    flat, of_uv = directions.reshape(-1, 3).contiguous(), gradient.reshape(-1, 2).contiguous()
    size = None if _has_squares(flat) else power_of_two(flat)
    given = flat if size is None else (flat / size).contiguous()
    found = torch.from_numpy(
        _core.encode_gradient(map_of(spec), given.detach().numpy(), of_uv.detach().numpy())
    )
    return (found if size is None else found / size).reshape(directions.shape)


def _has_squares(directions: Tensor) -> bool:
    """Tell whether all directions are of a length that has a square in their width."""
    about = torch.finfo(directions.dtype)
    low, high = math.sqrt(about.tiny) / about.eps, math.sqrt(about.max) / 4
    if directions.numel() == 0:
        return True
    largest = directions.detach().abs().amax(-1)
    smallest, greatest = torch.aminmax(largest)
    return bool(smallest > low) and bool(greatest < high)


def _again_reverse(
    wanted: Any, directions: Tensor, gradient: Tensor, spec: str, result: Tensor, again: Tensor
) -> tuple[Tensor, Tensor]:
    _, pull = torch.func.vjp(lambda d, g: _composed(d, g, spec), directions, gradient)
    found: tuple[Tensor, Tensor] = pull(again)
    return found


def _again_batched(
    in_dims: tuple[int | None, ...], directions: Tensor, gradient: Tensor, spec: str
) -> tuple[Tensor, int]:
    return encode_gradient(*alike(in_dims, directions, gradient), spec), 0


def encode_tangent(directions: Tensor, spec: str, tangent: Tensor) -> Tensor:
    """Return how u and v change with directions; it is NaN outside the coverage."""
    return _Inverse(directions, encode(directions, spec), spec).tangent(tangent)


def _encode_reverse(
    wanted: Any, directions: Tensor, spec: str, uv: Tensor, gradient: Tensor
) -> tuple[Tensor]:
    return (encode_gradient(directions, in_image(gradient), spec),)


def _encode_forward(directions: Tensor, spec: str, uv: Tensor, tangent: Tensor) -> Tensor:
    return padded_places(_Inverse(directions, uv, spec).tangent(tangent), uv)


def _place_rules(
    slope: Callable[[Tensor, str], Tensor], axes: int
) -> tuple[Callable[..., tuple[Tensor]], Callable[..., Tensor]]:
    """Return the rules of a verb of places, from its derivatives by u and v in a last axis.

    The result has so many axes of its own.
    """

    def reverse(
        wanted: Any, uv: Tensor, spec: str, result: Tensor, gradient: Tensor
    ) -> tuple[Tensor]:
        of, last = slope(uv, spec), gradient
        if axes == 1:
            parts = gradient.unbind(-1)
            pair = [_dot(of[..., k].unbind(-1), parts) for k in range(2)]
            none = (gradient == 0).all(-1, keepdim=True)
            return (padded_places(torch.where(none, 0.0, torch.stack(pair, dim=-1)), uv),)
        for _ in range(axes - 1):
            # Whole shapes: the older vmap of `torch.autograd` has no rule for `flatten`.
            of = of.reshape(*of.shape[:-3], of.shape[-3] * of.shape[-2], of.shape[-1])
            last = last.reshape(*last.shape[:-2], last.shape[-2] * last.shape[-1])
        if axes == 0:
            of, last = of.unsqueeze(-2), last.unsqueeze(-1)
        return (padded_places(times(of, last), uv),)

    def forward(uv: Tensor, spec: str, result: Tensor, tangent: Tensor) -> Tensor:
        along = in_image(tangent)
        for _ in range(axes):
            along = along.unsqueeze(-2)
        return (slope(uv, spec) * along).sum(-1)

    return reverse, forward


encode_gradient: Callable[..., Tensor] = define(
    "encode_gradient(Tensor directions, Tensor gradient, str spec) -> Tensor",
    kernel=_encode_gradient,
    fake=lambda directions, gradient, spec: directions.new_empty(directions.shape),
    batched=_again_batched,
    written=_composed,
    reverse=_again_reverse,
    none="The gradient of `encode` has reverse derivatives alone.",
)
jacobian_slope = define(
    "jacobian_slope(Tensor uv, str spec) -> Tensor",
    kernel=_derived("jacobian"),
    fake=_fake(lambda _: (3, 2, 2)),
    batched=_batched("jacobian_slope"),
    none="`jacobian` has no second derivative.",
)
density_slope = define(
    "density_slope(Tensor uv, str spec) -> Tensor",
    kernel=_derived("density"),
    fake=_fake(lambda _: (2,)),
    batched=_batched("density_slope"),
    none="`density` has no second derivative.",
)
_reverse, _forward = _place_rules(jacobian_slope, 2)
jacobian = define(
    "jacobian(Tensor uv, str spec) -> Tensor",
    kernel=_kernel("jacobian"),
    fake=_fake(lambda _: (3, 2)),
    batched=_batched("jacobian"),
    written=_by_printed_code("jacobian"),
    reverse=_reverse,
    forward=_forward,
)
_reverse, _forward = _place_rules(density_slope, 0)
density = define(
    "density(Tensor uv, str spec) -> Tensor",
    kernel=_kernel("density"),
    fake=_fake(lambda _: ()),
    batched=_batched("density"),
    written=_by_printed_code("density"),
    reverse=_reverse,
    forward=_forward,
)
_reverse, _forward = _place_rules(jacobian, 1)
decode = define(
    "decode(Tensor uv, str spec) -> Tensor",
    kernel=_kernel("decode"),
    fake=_fake(lambda _: (3,)),
    batched=_batched("decode"),
    written=_by_printed_code("decode"),
    reverse=_reverse,
    forward=_forward,
)
encode = define(
    "encode(Tensor directions, str spec) -> Tensor",
    kernel=_kernel("encode"),
    fake=_fake(lambda width: (width,)),
    batched=_batched("encode"),
    written=_by_printed_code("encode"),
    reverse=_encode_reverse,
    forward=_encode_forward,
)
