"""The verbs of one map, of tensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch

from ..map import verbs
from . import _moving, _verbs
from ._moving import Moving
from ._operators import in_float, power_of_two, product
from ._printed import call
from ._specs import map_of, one_rotation, spec_of, split_rotation, turned_back, whole

if TYPE_CHECKING:
    from torch import Tensor

    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["decode", "density", "directions", "encode", "jacobian", "projection", "reflect"]


def projection(name: ProjectionLike, /, **parameters: Any) -> Projection | Moving:
    """Return a projection whose parameters may be tensors, to which gradients flow.

    Parameters
    ----------
    name : str or Projection
        As for `spheremap.projection`. A Projection keeps its axes, grid and world.
    **parameters : float or Tensor
        The projection's own parameters, as ``fov`` (degrees) of ``"perspective"`` or ``k1`` of
        ``"camera_kannala_brandt"``: numbers, and tensors of one float without axes. With a name
        also ``axes`` and the other options of `spheremap.projection`.

    Returns
    -------
    projection
        What `encode`, `decode`, `directions`, `sample` and `convert` take where they take a
        projection; a plain Projection where no parameter is a tensor.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.projection`; ValueError for a tensor that is not one float.

    Notes
    -----
    The derivatives by parameters are differences of the kernels in float64, of fourth order,
    within some 1e-9 of a derivative; there are no second ones. They cost four calls of `decode` for
    each parameter, on the CPU.

    Where `torch.func.vmap` or the compiler hides a number, `directions` and `convert` want a `size`
    with all its sides if that number changes them, and `sample` an image of the aspect that `name`
    has by itself, or ``any_aspect=True``.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> fov = torch.tensor(90.0, requires_grad=True)
    >>> uv = smt.encode(torch.tensor([0.5, 0.0, -1.0]), smt.projection("perspective", fov=fov))
    >>> uv[0].backward()
    >>> uv.tolist(), round(fov.grad.item(), 6)
    ([0.75, 0.5], -0.004363)
    """
    return _moving.projection(name, **parameters)


def encode(
    directions: Tensor,
    /,
    projection: ProjectionLike | Moving,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> Tensor:
    """Map directions to image coordinates.

    Parameters
    ----------
    directions : Tensor, shape (..., 3)
        World directions of any length, of floats. float16 and bfloat16 are computed in float32.
    projection, axes
        As for `spheremap.encode`.
    rotation : Tensor, array_like or an object with ``.as_matrix()``, optional
        As for `spheremap.encode`. A tensor of shape (..., 3, 3), to which gradients flow, is
        multiplied as it is, unchecked; its leading axes broadcast against those of `directions`.

    Returns
    -------
    uv : Tensor, shape (..., 2), or (..., 3) for a projection of several faces
        As of `spheremap.encode`, of the dtype and on the device of `directions`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.encode`; TypeError for what is no tensor of floats.

    Notes
    -----
    The gradient is the inverse of `jacobian`, over the length of the direction. It has second
    derivatives, and forward ones. At a pole it is not finite, on a crease it is that of the side
    that `encode` takes. Outside the coverage it is NaN, but zero where no gradient comes in: what a
    `torch.where` leaves out does not spoil the rest. The number of a face has none.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> d = torch.tensor([0.0, 0.0, -2.0], requires_grad=True)
    >>> uv = spheremap.torch.encode(d, "latlong")
    >>> uv[0].backward()
    >>> uv.tolist(), (d.grad * 4 * torch.pi + 0.0).tolist()
    ([0.5, 0.5], [1.0, 0.0, 0.0])
    """
    turn, fixed = split_rotation(rotation)
    data = _with_axis(in_float(directions, "directions"), 3, "directions")
    if turn is not None:
        data = turned_back(data, turn)
    if isinstance(projection, Moving):
        return projection.seen(axes, fixed).encode(data).to(directions.dtype)
    return _verbs.encode(data, spec_of(projection, axes, fixed)).to(directions.dtype)


def decode(
    uv: Tensor,
    /,
    projection: ProjectionLike | Moving,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> Tensor:
    """Map image coordinates to directions: the inverse of `encode`.

    Parameters
    ----------
    uv : Tensor, shape (..., 2), or (..., 3) for a projection of several faces
        As `encode` returns.
    projection, axes, rotation
        As for `encode`.

    Returns
    -------
    directions : Tensor, shape (..., 3)
        World directions of unit length; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The gradient is `jacobian`. It has second derivatives, and forward ones.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> uv = torch.tensor([0.5, 0.5])
    >>> (spheremap.torch.decode(uv, "octahedral") + 0.0).tolist()
    [0.0, 0.0, 1.0]
    """
    turn, fixed = split_rotation(rotation)
    if isinstance(projection, Moving):
        moving = projection.seen(axes, fixed)
        found = moving.decode(_with_axis(in_float(uv, "uv"), moving.numbers, "uv"))
    else:
        spec = spec_of(projection, axes, fixed)
        found = _verbs.decode(_of_places(uv, spec), spec)
    if turn is not None:
        found = product(turn.to(found.dtype), found.unsqueeze(-1)).squeeze(-1)
    return found.to(uv.dtype)


def jacobian(
    uv: Tensor,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
) -> Tensor:
    """Return the derivative of the direction by the image coordinates.

    Parameters
    ----------
    uv : Tensor, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection, axes, rotation
        As for `encode`.

    Returns
    -------
    jacobian : Tensor, shape (..., 3, 2)
        As of `spheremap.jacobian`.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The gradient is derived from printed code (`spheremap.code`); it has no second one.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> found = spheremap.torch.jacobian(torch.tensor([0.5, 0.5]), "latlong")
    >>> (found + 0.0).tolist()  # doctest: +ELLIPSIS
    [[6.28318..., 0.0], [0.0, -3.14159...], [0.0, 0.0]]
    """
    _expect_still(projection)
    turn, fixed = split_rotation(rotation)
    spec = spec_of(projection, axes, fixed)
    found = _verbs.jacobian(_of_places(uv, spec), spec)
    if turn is not None:
        found = product(turn.to(found.dtype), found)
    return found.to(uv.dtype)


def density(uv: Tensor, /, projection: ProjectionLike) -> Tensor:
    """Return the solid angle per unit of image area, dω/(du dv).

    Parameters
    ----------
    uv : Tensor, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection : Projection or str
        As for `encode`.

    Returns
    -------
    density : Tensor, shape (...)
        Steradians per unit of uv area; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The gradient is that of `jacobian`: from printed code, and once.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> spheremap.torch.density(torch.tensor([0.5, 0.5]), "sphere").round(decimals=4).item()
    16.0
    """
    _expect_still(projection)
    spec = spec_of(projection)
    return _verbs.density(_of_places(uv, spec), spec).to(uv.dtype)


def directions(
    projection: ProjectionLike | Moving,
    size: Size,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
    any_aspect: bool = False,
) -> Tensor:
    """Return the direction of every texel.

    Parameters
    ----------
    projection, axes, rotation
        As for `encode`; a tensor of rotations has shape (3, 3).
    size : int or tuple of int
        As for `spheremap.directions`.
    dtype : torch.dtype
        Of the result, any of floats.
    device : torch.device or str, optional
        Of the result; by default that of a tensor `rotation`, else the CPU.
    any_aspect : bool
        As for `spheremap.directions`.

    Returns
    -------
    directions : Tensor, the image's shape + (3,)
        Unit length; NaN for texels whose center lies outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.directions`; ValueError for a `size` of one number where a parameter that
        is hidden changes the shape that it stands for.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> spheremap.torch.directions("cube", 16).shape
    torch.Size([6, 16, 16, 3])
    """
    turn, fixed = split_rotation(rotation)
    if device is None and turn is not None:
        device = turn.device
    is_double = dtype == torch.float64
    if isinstance(projection, Moving):
        moving = projection.seen(axes, fixed)
        moving.expect_shape(size)
        shape = whole(_moving.shape_of(moving.spec, size, any_aspect))
        texels = _moving.texels(moving.spec, shape)
        width = torch.float64 if is_double else torch.float32
        found = moving.decode(texels.to(device or moving.together().device, width))
    else:
        found = _grid(projection, size, axes, fixed, any_aspect, is_double).to(device)
    if turn is not None:
        found = product(found, one_rotation(turn).to(found.dtype).mT)
    return found.to(dtype)


def reflect(view: Tensor, normal: Tensor, /) -> Tensor:
    """Reflect view vectors about normals: r = 2(v·n)n/(n·n) - v.

    Parameters
    ----------
    view : Tensor, shape (..., 3)
        From the surface toward the eye; the result keeps its length.
    normal : Tensor, shape (..., 3)
        Of any length. The two broadcast.

    Returns
    -------
    reflected : Tensor, shape (..., 3)
        The direction to look up in an environment map.

    Raises
    ------
    ValueError, TypeError
        For what is not (..., 3), or no tensor of floats.

    Notes
    -----
    It is printed code (`spheremap.code`), with all derivatives. Where there is no normal, or a
    number is not finite, the result is NaN and no gradient flows.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> view, normal = torch.tensor([[1.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
    >>> spheremap.torch.reflect(view, normal).tolist()
    [-1.0, 1.0, 0.0]
    """
    v = _with_axis(in_float(view, "view"), 3, "view")
    n = _with_axis(in_float(normal, "normal"), 3, "normal")
    wide = torch.promote_types(v.dtype, n.dtype)
    v, n = torch.broadcast_tensors(v.to(wide), n.to(wide))
    known = v.isfinite().all(-1, keepdim=True) & n.isfinite().all(-1, keepdim=True)
    known = known & (n != 0).any(-1, keepdim=True)
    # What is left out below would spoil the gradient of the rest, and the length of a normal has no
    # say.
    v, n = torch.where(known, v, 0.0), torch.where(known, n, 1.0)
    size = power_of_two(v)
    found: Tensor = call("reflect", "latlong", v / size, n / power_of_two(n)) * size
    return torch.where(known, found, torch.nan).to(torch.promote_types(view.dtype, normal.dtype))


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _grid(
    projection: ProjectionLike,
    size: Size,
    axes: str | None,
    rotation: Any | None,
    any_aspect: bool,
    double: bool,
) -> Tensor:
    found = verbs.directions(
        projection,
        size,
        axes=axes,
        rotation=rotation,
        dtype="float64" if double else "float32",
        any_aspect=any_aspect,
    )
    return torch.from_numpy(found)


def _of_places(uv: Tensor, spec: str) -> Tensor:
    return _with_axis(in_float(uv, "uv"), _numbers(spec), "uv")


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _numbers(spec: str) -> int:
    """Return how many numbers a place of a map has."""
    return _verbs.width(map_of(spec))


def _expect_still(projection: object) -> None:
    if isinstance(projection, Moving):
        raise TypeError(
            "`jacobian` and `density` have no derivative by parameters: give the projection with "
            "numbers, as spheremap.projection makes it."
        )


def _with_axis(data: Tensor, length: int, name: str) -> Tensor:
    if data.ndim == 0 or data.shape[-1] != length:
        raise ValueError(f"Expected `{name}` to be (..., {length}), got {tuple(data.shape)}.")
    return data
