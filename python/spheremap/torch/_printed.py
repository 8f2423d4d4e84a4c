"""Printed code of maps, compiled: what runs where there is no kernel, and second derivatives."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import torch

from ..map.compiled import VERBS, compiled

if TYPE_CHECKING:
    from torch import Tensor


@torch.compiler.allow_in_graph  # type: ignore[untyped-decorator]
def call(verb: str, spec: str, *given: Tensor) -> Any:
    """Call a verb. The compiler looks at what it does, and not at how it is found."""
    verbs = VERBS if verb in VERBS else (verb,)
    return compiled(spec, "torch", given[0].dtype == torch.float64, verbs)[verb](*given)


def run(verb: str, data: Tensor, spec: str) -> Tensor:
    """Return what a verb's kernel does, where there is none: on other devices than the CPU."""
    functions = compiled(spec, "torch", data.dtype == torch.float64)
    if verb == "encode":
        unit = unit_vectors(data)
        found = functions[verb](unit)
        return torch.where(unit.isfinite().all(-1, keepdim=True), found, torch.nan)
    found = functions[verb](data)
    valid = functions["valid"](data)
    for _ in range(found.ndim - valid.ndim):
        valid = valid.unsqueeze(-1)
    return torch.where(valid, found, torch.nan)


def unit_vectors(data: Tensor) -> Tensor:
    """Return directions of length 1, as printed code takes them; NaN of what has no direction."""
    # Squares of the largest and the smallest have no width.
    scaled = data / data.detach().abs().amax(-1, keepdim=True)
    return scaled / torch.linalg.vector_norm(scaled, dim=-1, keepdim=True)


def forward_of(function: Callable[[Tensor], Tensor], at: Tensor, along: Tensor) -> Tensor:
    """Return the forward derivative of a function, within an operator."""
    given = at.detach(), along.detach()

    def run() -> Tensor:
        with warnings.catch_warnings():
            # torch's own forward rules use what it has deprecated, and say so once.
            warnings.filterwarnings("ignore", ".*torch.jit.script")
            found: Tensor = torch.func.jvp(function, given[:1], given[1:])[1]
        return found

    return _apart(run)


def forward_of_smooth(function: Callable[[Tensor], Tensor], at: Tensor, along: Tensor) -> Tensor:
    """Return the forward derivative of a function without choices, within an operator.

    What flows back is linear in what flows in, and what flows back through that is the forward
    derivative. So it is one within forward derivatives too, which torch does not nest.
    """
    given, tangent = at.detach(), along.detach()

    def run() -> Tensor:
        value, pull = torch.func.vjp(function, given)
        _, push = torch.func.vjp(lambda g: pull(g)[0], torch.zeros_like(value))
        found: Tensor = push(tangent)[0]
        return found

    return _apart(run)


def _apart(run: Callable[[], Tensor]) -> Tensor:
    """Return what a function does in another thread.

    Within an operator torch has derivatives switched off; in another thread it has not.
    """
    with ThreadPoolExecutor(1) as apart:
        return apart.submit(run).result()


def by_place(verb: str, uv: Tensor, spec: str) -> Tensor:
    """Return the derivatives of a verb of places by u and by v, in the last axis.

    They are forward ones: a branch that is not taken leaves no NaN in the one that is.
    """
    function = compiled(spec, "torch", uv.dtype == torch.float64)[verb]

    def column(k: int) -> Tensor:
        along = torch.zeros_like(uv)
        along[..., k] = 1.0
        return forward_of(function, uv, along)

    return torch.stack([column(k) for k in range(2)], dim=-1)
