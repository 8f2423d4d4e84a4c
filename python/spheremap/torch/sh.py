"""Spherical harmonics of tensors, with gradients.

Coefficients are along the last axis, (..., (order + 1)²), and channels and batches before it.
"""

from __future__ import annotations

import math
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import sh
from . import _harmonics
from ._operators import has_kernel, in_float, product
from ._specs import as_fixed, one_rotation, spec_of, split_rotation, turned_back, whole
from .images import channels_first
from .maps import directions as directions_of

if TYPE_CHECKING:
    from torch import Tensor

    from ..map.named import ProjectionLike

__all__ = ["convolve", "evaluate", "project", "rotate"]


def project(
    image: Tensor,
    /,
    projection: ProjectionLike,
    *,
    order: int,
    texels: str = "means",
    axes: str | None = None,
    rotation: Any | None = None,
    any_aspect: bool = False,
) -> Tensor:
    """Return the spherical harmonic coefficients of an image.

    Parameters
    ----------
    image : Tensor
        As for `spheremap.torch.sample`.
    projection, order, texels, axes, any_aspect
        As for `spheremap.sh.project`.
    rotation : Tensor, array_like or an object with ``.as_matrix()``, optional
        As for `spheremap.sh.project`, of shape (3, 3). Gradients flow to a tensor.

    Returns
    -------
    coefficients : Tensor, shape ((order + 1)²,), (C, (order + 1)²) or (N, C, (order + 1)²)
        As of `spheremap.sh.project`, found in float64, of the image's dtype.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.project`.

    Notes
    -----
    The gradient is the exact adjoint of the least squares fit.

    Examples
    --------
    >>> import spheremap.torch as smt
    >>> up = smt.directions("cube", 16)[..., 1].requires_grad_()
    >>> c = smt.sh.project(up, "cube", order=1)
    >>> c[1].backward()
    >>> round(c[1].item(), 4), up.grad.shape
    (2.0467, torch.Size([6, 16, 16]))
    """
    turn, fixed = split_rotation(rotation)
    return projected(image, spec_of(projection, axes, fixed), turn, order, texels, any_aspect)


def projected(
    image: Tensor, spec: str, turn: Tensor | None, order: int, texels: str, any_aspect: bool
) -> Tensor:
    """Return the coefficients of an image of the map that a text stands for, turned."""
    data = in_float(image, "image")
    several, back = channels_first(data, spec, any_aspect)
    if has_kernel(data):
        last = several.movedim(0, -1).contiguous()
        found = _harmonics.project(last, spec, order, texels).mT
    else:
        shape = whole(several.shape[1:])
        held = _harmonics.matrix(spec, shape, order, texels, str(data.device))
        found = product(several.flatten(1).double(), held)
    made = back(found.to(data.dtype))
    return (made if turn is None else rotate(made, turn)).to(image.dtype)


def evaluate(coefficients: Tensor, directions: Tensor, /) -> Tensor:
    """Return the functions that coefficients describe, in given directions.

    Parameters
    ----------
    coefficients : Tensor, shape (..., (order + 1)²)
        As `project` returns.
    directions : Tensor, shape (..., 3)
        World directions of any length; the same for each function.

    Returns
    -------
    values : Tensor
        The leading axes of the coefficients and those of the directions, as `sample` returns them.
        NaN for a direction that is zero or not finite.

    Raises
    ------
    ValueError, TypeError
        For a wrong shape, or what is no tensor of floats.
    NotImplementedError
        For a gradient of directions above order 8, when it is asked for.

    Notes
    -----
    Gradients flow to both, to directions by printed code (`spheremap.sh.code`), second ones too.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> along_x = torch.tensor([0.0, 0.0, 0.0, 1.0])
    >>> smt.sh.evaluate(along_x, torch.tensor([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    tensor([0.4886, 0.0000])
    """
    c, d = in_float(coefficients, "coefficients"), in_float(directions, "directions")
    if d.ndim == 0 or d.shape[-1] != 3:
        raise ValueError(f"Expected `directions` to be (..., 3), got {tuple(d.shape)}.")
    wide = torch.promote_types(c.dtype, d.dtype)
    basis = _harmonics.basis(d.to(wide), _order(c))
    lead, own = whole(c.shape[:-1]), whole(d.shape[:-1])
    # What is no direction has no harmonics, and would spoil the gradient of all coefficients.
    rows = basis.reshape(math.prod(own), basis.shape[-1])
    known = rows.isfinite().all(-1)
    columns = c.to(wide).reshape(math.prod(lead), c.shape[-1])
    found = product(columns, torch.where(known[:, None], rows, 0.0).mT)
    return torch.where(known, found, torch.nan).reshape((*lead, *own)).to(coefficients.dtype)


def rotate(coefficients: Tensor, /, rotation: Any) -> Tensor:
    """Turn the functions that coefficients describe: f'(R d) = f(d).

    Parameters
    ----------
    coefficients : Tensor, shape (..., (order + 1)²)
        As `project` returns.
    rotation : Tensor, array_like or an object with ``.as_matrix()``
        Of shape (3, 3). Gradients flow to a tensor, up to order 8.

    Returns
    -------
    coefficients : Tensor, of the same shape

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.rotate`.

    Examples
    --------
    >>> import torch, spheremap as sm, spheremap.torch as smt
    >>> turned = smt.sh.rotate(torch.tensor([0.0, 0.0, 1.0, 0.0]), sm.rotation(90, 0, 0))
    >>> turned.round(decimals=4).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    c = in_float(coefficients, "coefficients")
    order = _order(c)
    turn, fixed = split_rotation(rotation)
    if turn is not None:
        fixed = as_fixed(one_rotation(turn))
    if turn is None or fixed is not None:
        made = _turned(order, fixed)
        return product(c, made.mT.to(c.device, c.dtype)).to(coefficients.dtype)
    # A grid that determines the function: its values, turned, are those of the result.
    grid = directions_of("latlong", 2 * order + 2, dtype=c.dtype, device=c.device)
    values = evaluate(c, turned_back(grid, turn))
    flat = values.reshape(-1, *grid.shape[:-1])
    found = project(flat, "latlong", order=order, texels="points")
    return found.reshape(c.shape).to(coefficients.dtype)


def convolve(coefficients: Tensor, /, *, lobe: str | Tensor | Any, **parameters: float) -> Tensor:
    """Convolve with a lobe that is round about its axis, degree by degree.

    Parameters
    ----------
    coefficients : Tensor, shape (..., (order + 1)²)
        As `project` returns.
    lobe : str, array_like or Tensor, shape (order + 1,)
        A name for `spheremap.sh.lobe`, or the factors themselves, to which gradients flow.
    **parameters : float
        Of the named lobe.

    Returns
    -------
    coefficients : Tensor, of the same shape

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.convolve`.

    Examples
    --------
    Irradiance over π:

    >>> import torch, spheremap.torch as smt
    >>> c = torch.tensor([1.0, 0.0, 3.0, 0.0])
    >>> (smt.sh.convolve(c, lobe="cosine") / torch.pi).round(decimals=4).tolist()
    [1.0, 0.0, 2.0, 0.0]
    """
    c = in_float(coefficients, "coefficients")
    order = _order(c)
    if isinstance(lobe, str):
        lobe, parameters = _factors(lobe, order, tuple(parameters.items())), {}
    factors = torch.as_tensor(lobe, dtype=c.dtype, device=c.device)
    sh.expect_factors(tuple(factors.shape), order, parameters)
    degrees = [degree for degree in range(order + 1) for _ in range(2 * degree + 1)]
    return (c * factors[torch.tensor(degrees, device=c.device)]).to(coefficients.dtype)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _turned(order: int, rotation: Any) -> Tensor:
    """Return what coefficients are multiplied by for a rotation."""
    return torch.from_numpy(sh.rotate(np.eye((order + 1) ** 2), rotation))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _factors(lobe: Any, order: int, parameters: tuple[tuple[str, float], ...]) -> Tensor:
    return torch.from_numpy(sh.lobe(lobe, order=order, **dict(parameters)))


def _order(coefficients: Tensor) -> int:
    if coefficients.ndim == 0:
        raise ValueError("Expected `coefficients` to be (..., (order + 1)²), got a number.")
    return _harmonics.order_of(index(coefficients.shape[-1]))
