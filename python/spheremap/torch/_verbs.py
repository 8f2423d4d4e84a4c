"""The verbs of one map as operators, and how each changes with what it is given.

First derivatives are those of `jacobian`, which the kernels compute. Only what `jacobian` and
`density` change by is derived from printed code.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from ._operators import define
from ._printed import by_place, run
from ._specs import map_of

if TYPE_CHECKING:
    from torch import Tensor

    from .._projection import Projection


def _kernel(verb: str) -> Callable[[Tensor, str], Tensor]:
    def kernel(data: Tensor, spec: str) -> Tensor:
        if data.device.type != "cpu":
            return run(verb, data, spec)
        # NumPy shares the tensor's memory, and torch that of the result.
        return torch.from_numpy(np.asarray(getattr(map_of(spec), verb)(data.detach().numpy())))

    return kernel


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


def _times(matrix: Tensor, gradient: Tensor) -> Tensor:
    """Return the gradient that flows back through a matrix (..., m, n), none of it where none came.

    A direction outside the coverage has NaN for a matrix: it spoils no sum that leaves it out.
    """
    rows = gradient.unsqueeze(-1)
    return torch.where(rows == 0, 0.0, rows * matrix).sum(-2)


def _in_image(numbers: Tensor) -> Tensor:
    """Return u and v of places, without the face."""
    # A slice that is the whole is no view that the older vmap of `torch.autograd` knows.
    return numbers if numbers.shape[-1] == 2 else numbers[..., :2]


def _padded(columns: Tensor, uv: Tensor) -> Tensor:
    """Return derivatives by u and v as those by all numbers of a place: faces do not change."""
    missing = uv.shape[-1] - columns.shape[-1]
    return torch.nn.functional.pad(columns, (0, missing))


def _of_encode(directions: Tensor, uv: Tensor, spec: str) -> Tensor:
    """Return the derivatives (..., 2, 3) of u and v by a direction: the inverse of `jacobian`.

    Of its two columns the products make a 2x2 matrix, whose inverse takes them to two rows that are
    tangent to the sphere.
    """
    columns = jacobian(uv, spec)
    along_u, along_v = columns[..., 0], columns[..., 1]
    a = (along_u * along_u).sum(-1, keepdim=True)
    b = (along_u * along_v).sum(-1, keepdim=True)
    c = (along_v * along_v).sum(-1, keepdim=True)
    rows = torch.stack([c * along_u - b * along_v, a * along_v - b * along_u], dim=-2)
    length = torch.linalg.vector_norm(directions, dim=-1, keepdim=True)
    return rows / ((a * c - b * b) * length).unsqueeze(-1)


def encode_gradient(directions: Tensor, spec: str, gradient: Tensor) -> Tensor:
    """Return the gradient of directions, from that of their u and v."""
    return _times(_of_encode(directions, encode(directions, spec), spec), gradient)


def encode_tangent(directions: Tensor, spec: str, tangent: Tensor) -> Tensor:
    """Return how u and v change with directions."""
    rows = _of_encode(directions, encode(directions, spec), spec)
    return (rows * tangent.unsqueeze(-2)).sum(-1)


def _encode_reverse(
    wanted: Any, directions: Tensor, spec: str, uv: Tensor, gradient: Tensor
) -> tuple[Tensor]:
    return (_times(_of_encode(directions, uv, spec), _in_image(gradient)),)


def _encode_forward(directions: Tensor, spec: str, uv: Tensor, tangent: Tensor) -> Tensor:
    rows = _of_encode(directions, uv, spec)
    return _padded((rows * tangent.unsqueeze(-2)).sum(-1), uv)


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
        for _ in range(axes - 1):
            of, last = of.flatten(-3, -2), last.flatten(-2, -1)
        if axes == 0:
            of, last = of.unsqueeze(-2), last.unsqueeze(-1)
        return (_padded(_times(of, last), uv),)

    def forward(uv: Tensor, spec: str, result: Tensor, tangent: Tensor) -> Tensor:
        along = _in_image(tangent)
        for _ in range(axes):
            along = along.unsqueeze(-2)
        return (slope(uv, spec) * along).sum(-1)

    return reverse, forward


jacobian_slope = define(
    "jacobian_slope(Tensor uv, str spec) -> Tensor",
    kernel=_derived("jacobian"),
    fake=_fake(lambda _: (3, 2, 2)),
    batched=_batched("jacobian_slope"),
)
density_slope = define(
    "density_slope(Tensor uv, str spec) -> Tensor",
    kernel=_derived("density"),
    fake=_fake(lambda _: (2,)),
    batched=_batched("density_slope"),
)
_reverse, _forward = _place_rules(jacobian_slope, 2)
jacobian = define(
    "jacobian(Tensor uv, str spec) -> Tensor",
    kernel=_kernel("jacobian"),
    fake=_fake(lambda _: (3, 2)),
    batched=_batched("jacobian"),
    reverse=_reverse,
    forward=_forward,
)
_reverse, _forward = _place_rules(density_slope, 0)
density = define(
    "density(Tensor uv, str spec) -> Tensor",
    kernel=_kernel("density"),
    fake=_fake(lambda _: ()),
    batched=_batched("density"),
    reverse=_reverse,
    forward=_forward,
)
_reverse, _forward = _place_rules(jacobian, 1)
decode = define(
    "decode(Tensor uv, str spec) -> Tensor",
    kernel=_kernel("decode"),
    fake=_fake(lambda _: (3,)),
    batched=_batched("decode"),
    reverse=_reverse,
    forward=_forward,
)
encode = define(
    "encode(Tensor directions, str spec) -> Tensor",
    kernel=_kernel("encode"),
    fake=_fake(lambda width: (width,)),
    batched=_batched("encode"),
    reverse=_encode_reverse,
    forward=_encode_forward,
)
