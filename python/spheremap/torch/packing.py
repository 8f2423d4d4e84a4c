"""Packing directions of tensors, with a gradient that passes straight through."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import packing
from ._operators import define, in_float, power_of_two

if TYPE_CHECKING:
    from torch import Tensor

    from ..packing import Packing

__all__ = ["pack", "quantize", "unpack"]


def pack(
    directions: Tensor,
    name: str | Packing,
    /,
    rounding: str = "precise",
    *,
    invalid: str = "raise",
) -> Tensor:
    """Pack directions into a few bits each.

    Parameters
    ----------
    directions : Tensor, shape (..., 3)
        Directions of any length.
    name, rounding, invalid
        As for `spheremap.packing.pack`.

    Returns
    -------
    codes : Tensor, shape (...) or (..., k)
        Of the integer dtype that `spheremap.packing.packing` says, on the device of the directions.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.pack`.

    Notes
    -----
    Integers have no gradient: `quantize` has one. The kernels of the CPU do it.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> hex(smt.packing.pack(torch.tensor([1.0, 0.0, 0.0]), "oct16").item())
    '0x7f'
    """
    given = in_float(directions, "directions").detach().cpu().numpy()
    codes = packing.pack(given, name, rounding, invalid=invalid)
    return torch.from_numpy(np.asarray(codes)).to(directions.device)


def unpack(codes: Tensor, name: str | Packing, /, *, dtype: torch.dtype = torch.float32) -> Tensor:
    """Unpack codes to unit vectors.

    Parameters
    ----------
    codes : Tensor of integers, shape (...) or (..., k)
        As `pack` returns them.
    name : Packing or str
        The scheme.
    dtype : torch.dtype
        Of the result, any of floats.

    Returns
    -------
    directions : Tensor, shape (..., 3)
        Unit vectors.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.unpack`.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> smt.packing.unpack(torch.tensor([0x7F7F, 0x7F]), "oct16").tolist()
    [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]
    """
    if not isinstance(codes, torch.Tensor):
        raise TypeError(f"Expected `codes` to be a tensor, got {type(codes).__name__}.")
    width: Any = np.float64 if dtype == torch.float64 else np.float32
    found = packing.unpack(codes.detach().cpu().numpy(), name, dtype=width)
    return torch.from_numpy(np.asarray(found)).to(codes.device, dtype)


def quantize(directions: Tensor, name: str | Packing, /, rounding: str = "precise") -> Tensor:
    """Return directions as they come back from codes, with the gradient of no packing.

    Parameters
    ----------
    directions : Tensor, shape (..., 3)
        Directions of any length.
    name, rounding
        As for `pack`.

    Returns
    -------
    directions : Tensor, shape (..., 3)
        Unit vectors: those of ``unpack(pack(directions))``, of the dtype of `directions`. NaN for a
        direction that is zero or not finite.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.packing.pack`.

    Notes
    -----
    The gradient is straight through (Bengio, Léonard and Courville 2013, Estimating or Propagating
    Gradients Through Stochastic Neurons): that of ``d/|d|``, which is what is packed. The true one
    is zero almost everywhere.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> d = torch.tensor([3.0, 4.0, 0.0], requires_grad=True)
    >>> packed = smt.packing.quantize(d, "oct16")
    >>> packed[0].backward()
    >>> [round(x, 4) for x in packed.tolist()], [round(x, 4) for x in d.grad.tolist()]
    ([0.5947, 0.8039, 0.0], [0.128, -0.096, 0.0])
    """
    data = in_float(directions, "directions")
    if data.ndim == 0 or data.shape[-1] != 3:
        raise ValueError(f"Expected `directions` to be (..., 3), got {tuple(data.shape)}.")
    known = data.isfinite().all(-1, keepdim=True) & (data != 0).any(-1, keepdim=True)
    # What is none would spoil the gradient of the rest.
    safe = torch.where(known, data, 1.0)
    unit = torch.nn.functional.normalize(safe / power_of_two(safe), dim=-1)
    found = _quantized(unit, _name(name), rounding)
    return torch.where(known, found, torch.nan).to(directions.dtype)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _name(scheme: str | Packing) -> str:
    return packing.packing(scheme).name


def _kernel(unit: Tensor, name: str, rounding: str) -> Tensor:
    given = unit.detach().cpu().numpy()
    found = packing.unpack(packing.pack(given, name, rounding), name, dtype=given.dtype)
    return torch.from_numpy(np.asarray(found)).to(unit.device)


def _batched(
    in_dims: tuple[int | None, ...], unit: Tensor, name: str, rounding: str
) -> tuple[Tensor, int]:
    axis = in_dims[0]
    assert axis is not None
    return _quantized(unit.movedim(axis, 0), name, rounding), 0


_quantized = define(
    "quantized(Tensor unit, str name, str rounding) -> Tensor",
    kernel=_kernel,
    fake=lambda unit, name, rounding: unit.new_empty(unit.shape),
    batched=_batched,
    reverse=lambda wanted, unit, name, rounding, result, gradient: (gradient.clone(),),
    forward=lambda unit, name, rounding, result, tangent: tangent.clone(),
)
