"""The verbs of images, of tensors as torch has them: channels before the rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import torch

from .. import light
from ..resample import linear
from . import _gathers, _images, _planes
from ._moving import Moving, texels, text_of
from ._operators import has_kernel, in_float, is_hidden, is_moving
from ._specs import as_fixed, map_of, one_rotation, spec_of, split_rotation, turned_back, whole

if TYPE_CHECKING:
    from torch import Tensor

    from .._arrays import Size
    from .._names import ConvertFilter, Filter
    from ..map.named import ProjectionLike, Worlds

__all__ = ["convert", "integrate", "pad", "sample"]


def sample(
    image: Tensor,
    directions: Tensor,
    /,
    projection: ProjectionLike | Moving,
    *,
    filter: str = "bilinear",
    axes: str | None = None,
    rotation: Any | None = None,
    fill: float = 0.0,
    any_aspect: bool = False,
) -> Tensor:
    """Look directions up in an image.

    Parameters
    ----------
    image : Tensor, shape (H, W), (C, H, W) or (N, C, H, W)
        With faces (F, S, S), (F, C, S, S) or (N, F, C, S, S). Of floats.
    directions : Tensor, shape (..., 3)
        World directions of any length; the same are looked up in each image.
    projection, axes, rotation
        As for `encode`: how the image maps the sphere.
    filter : {"bilinear", "nearest"} or str
        As for `spheremap.sample`. Gradients of directions are those of bilinear lookups: of others
        they are an error.
    fill : float
        As for `spheremap.sample`.
    any_aspect : bool
        As for `spheremap.sample`.

    Returns
    -------
    values : Tensor, shape (...), (C, ...) or (N, C, ...)
        Of the image's dtype.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sample`.
    NotImplementedError
        For a gradient, when it is asked for, that there is none of.

    Notes
    -----
    The gradient of the image is the exact adjoint, summed in the order of the directions: the same
    bits with any number of threads.

    The gradient of directions is that of bilinear lookups: constant along each axis between four
    texels, and of one side on the lines between centers. At rims and at the edges of faces, where
    a lookup has rules of its own, it is a difference of lookups. Outside the coverage nothing
    changes: it is zero.

    On other devices than the CPU bilinear lookups are gathers. Those in cubes mix what graphics
    hardware mixes beside edges, and have a gradient of directions too.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> image = torch.zeros(3, 32, 64, requires_grad=True)
    >>> values = spheremap.torch.sample(image, torch.tensor([[0.0, 0.0, -1.0]]), "latlong")
    >>> values.sum().backward()
    >>> values.shape, round(image.grad.sum().item(), 6)
    (torch.Size([3, 1]), 3.0)
    """
    turn, fixed = split_rotation(rotation)
    moving = projection.seen(axes, fixed) if isinstance(projection, Moving) else None
    spec = spec_of(projection, axes, fixed) if moving is None else moving.spec
    return _looked_up(image, directions, spec, turn, filter, float(fill), any_aspect, moving)


def convert(
    image: Tensor,
    /,
    src: ProjectionLike | Moving,
    dst: ProjectionLike | Moving,
    *,
    size: Size | None = None,
    rotation: Any | None = None,
    filter: ConvertFilter | str = "bilinear",
    fill: float = 0.0,
    antialias: bool = True,
    world: Worlds = "match",
    any_aspect: bool = False,
) -> Tensor:
    """Turn an image from one projection into another.

    Parameters
    ----------
    image : Tensor
        As for `sample`.
    src, dst, size, filter, antialias, world, any_aspect
        As for `spheremap.convert`.
    rotation : Tensor, array_like or an object with ``.as_matrix()``, optional
        As for `spheremap.convert`, of shape (3, 3). Gradients flow to a tensor, and
        to the parameters of `src` and `dst` that are tensors, with ``filter="bilinear",
        antialias=False``; with others a tensor that wants one is an error, and one whose numbers
        `torch.func.vmap` or the compiler hides. With these a tensor is multiplied as it is; with
        others, and in an array, it must be a rotation.
    fill : float
        As for `spheremap.convert`.

    Returns
    -------
    image : Tensor
        With the batch, channels and dtype of the image, and its memory format.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.convert`; ValueError without a `size` where parameters are hidden, and
        for a `size` of one number where they change the shape of an image that it stands for.

    Notes
    -----
    The gradient of the image is the exact adjoint, with every filter that adds texels up: all but
    ``"mode"``. The matrix is found when it is first wanted and held for the next calls. With
    ``filter="bilinear", antialias=False``, from a rectangular image, that takes no longer than a
    call; with others as long as `weights_matrix` does, seconds for images of a hundred rows and
    minutes for 512.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> batch = torch.ones(2, 3, 32, 64, requires_grad=True)
    >>> cubes = spheremap.torch.convert(batch, "latlong", "cube", size=16, antialias=False)
    >>> cubes.sum().backward()
    >>> cubes.shape, round(batch.grad.sum().item())
    (torch.Size([2, 6, 3, 16, 16]), 9216)
    """
    turn, fixed = split_rotation(rotation)
    in_float(image, "image")
    moves = [one for one in (src, dst) if isinstance(one, Moving)]
    follows = any(one.is_moving for one in moves)
    is_lookup = filter == "bilinear" and not antialias
    if turn is not None:
        fixed = as_fixed(one_rotation(turn))
        if is_moving(turn) or (fixed is None and is_lookup):
            follows = True
        elif fixed is None:
            # It is no rotation, which is said below.
            fixed = turn.detach().cpu().numpy()
    if follows:
        if not is_lookup:
            hidden = any(one.is_hidden for one in moves) or (turn is not None and is_hidden(turn))
            raise ValueError(
                "Gradients flow to `rotation` and to parameters of maps with filter='bilinear' and "
                "antialias=False alone."
                + (" So do numbers that `vmap` or the compiler hides." if hidden else "")
            )
        if turn is not None:
            fixed = None
        return _moved(image, src, dst, size, turn, fixed, float(fill), world, any_aspect)
    return _linear(
        image,
        *_conversion(
            whole(image.shape),
            text_of(src),
            text_of(dst),
            size,
            fixed,
            filter,
            fill,
            antialias,
            world,
            any_aspect,
        ),
    )


def pad(
    image: Tensor,
    /,
    projection: ProjectionLike,
    n: int,
    *,
    filter: Filter | str = "bilinear",
    any_aspect: bool = False,
) -> Tensor:
    """Put a border of `n` texels around each face that continues the image over its seams.

    Parameters
    ----------
    image : Tensor
        As for `sample`.
    projection, n, filter, any_aspect
        As for `spheremap.pad`.

    Returns
    -------
    padded : Tensor, shape (..., H + 2n, W + 2n)
        As of `spheremap.pad`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.pad`.

    Notes
    -----
    The gradient is the exact adjoint; its matrix is found when it is first wanted, and held.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> spheremap.torch.pad(torch.zeros(8, 3, 32, 64), "latlong", 1).shape
    torch.Size([8, 3, 34, 66])
    """
    in_float(image, "image")
    return _linear(image, *_border(whole(image.shape), projection, n, filter, any_aspect))


def integrate(image: Tensor, /, projection: ProjectionLike, *, any_aspect: bool = False) -> Tensor:
    """Integrate an image over the sphere: ∫ L dω.

    Parameters
    ----------
    image : Tensor
        As for `sample`.
    projection, any_aspect
        As for `light.integrate`.

    Returns
    -------
    integral : Tensor, shape (), (C,) or (N, C)
        Summed in float64, of the image's dtype. NaN spreads.

    Raises
    ------
    ValueError, TypeError
        As for `light.integrate`.

    Notes
    -----
    The gradient is the solid angle of each texel, `light.weights`.

    Examples
    --------
    >>> import torch, spheremap.torch
    >>> float(spheremap.torch.integrate(torch.ones(64, 128), "latlong") / torch.pi)
    4.0
    """
    data = in_float(image, "image")
    spec = spec_of(projection)
    held = _axes(spec, whole(image.shape), any_aspect)
    weights = _weights(spec, whole(_first(data, held).shape[-held:])).to(image.device)
    # Texels without a part in the sphere hold no value: whatever is there does not count.
    held_here = torch.where(weights.flatten() == 0, 0.0, _flat(data, held).double())
    total = (held_here * weights.flatten()).sum(1)
    return _back(image, held)(total).to(image.dtype)


def _moved(
    image: Tensor,
    src: ProjectionLike | Moving,
    dst: ProjectionLike | Moving,
    size: Size | None,
    turn: Tensor | None,
    fixed: Any | None,
    fill: float,
    world: Worlds,
    any_aspect: bool,
) -> Tensor:
    """Return a conversion by bilinear lookups, whose places are no constants."""
    for one in (src, dst):
        if isinstance(one, Moving):
            one.expect_shape(size)
    data = in_float(image, "image")
    moving = src.seen(None, fixed) if isinstance(src, Moving) else None
    seen = spec_of(src, None, fixed) if moving is None else moving.spec
    source, grid = turned_grid(seen, text_of(dst), size, whole(image.shape), world, any_aspect)
    directions = grid.to(device=data.device, dtype=data.dtype)
    if isinstance(dst, Moving):
        target = dst.in_world_of(source) if world == "match" else dst
        at = texels(target.spec, whole(grid.shape[:-1])).to(data.device, data.dtype)
        directions = target.decode(at)
    found = _looked_up(image, directions, source, turn, "bilinear", fill, any_aspect, moving)
    # (channels, faces, rows, columns), as values of directions come.
    extra = image.ndim - _axes(source, whole(image.shape), any_aspect)
    faces = extra > 0 and grid.ndim == 4
    return (found.movedim(extra - 1, -3) if faces else found).contiguous()


def _looked_up(
    image: Tensor,
    directions: Tensor,
    spec: str,
    turn: Tensor | None,
    filter: str,
    fill: float,
    any_aspect: bool,
    moving: Moving | None = None,
) -> Tensor:
    data = in_float(image, "image")
    looked = in_float(directions, "directions").to(data.dtype)
    if looked.ndim == 0 or looked.shape[-1] != 3:
        raise ValueError(f"Expected `directions` to be (..., 3), got {tuple(looked.shape)}.")
    if turn is not None:
        looked = turned_back(looked, turn)
    axes = _axes(spec, whole(image.shape), any_aspect)
    if moving is not None:
        seen = moving.sample(_last(data, axes), looked, filter, fill)
        return _back(image, axes)(seen.movedim(-1, 0)).to(image.dtype)
    shape = whole(_first(data, axes).shape[-axes:])
    rule = None if has_kernel(data) or filter != "bilinear" else _gathers.rule(spec, shape)
    if rule == "rectangle":
        table = _gathers.table(spec, shape, str(data.device))
        found = _gathers.in_rectangle(_flat(data, axes), looked, spec, shape, table, fill)
    elif rule == "taps":
        found = _gathers.by_taps(_flat(data, axes), looked, spec, shape, fill)
    else:
        # (..., channels) becomes (channels, ...).
        found = _images.sample(_last(data, axes), looked, spec, filter, fill).movedim(-1, 0)
    return _back(image, axes)(found).to(image.dtype)


def _linear(image: Tensor, axes: int, key: str, made: int) -> Tensor:
    """Return what a key makes of an image, which has so many axes without channels, the result so.

    Of a result the channels are where torch has them.
    """
    data = in_float(image, "image")
    if has_kernel(data) and _planes.are_planes(data):
        return _of_planes(data, axes, key).to(image.dtype)
    gathers = None if has_kernel(data) else _gathers.gathers_of(key, str(data.device))
    if gathers is None:
        found = _images.linear(_last(data, axes), key).movedim(-1, 0)
    else:
        target, fill = _target(key)
        found = _gathers.gathered(_flat(data, axes), gathers, fill).unflatten(1, target)
    return _as_before(with_channels(_back(image, axes)(found), made), image)


def _of_planes(data: Tensor, axes: int, key: str) -> Tensor:
    """Return what a key makes of an image that lies in memory as torch has it."""
    extra = data.ndim - axes
    one = data if extra else data.unsqueeze(-3)
    found = _planes.linear(one if extra == 2 else one.unsqueeze(0), key)
    few = found if extra == 2 else found.squeeze(0)
    return few if extra else few.squeeze(-3)


def channels_first(
    image: Tensor, spec: str, any_aspect: bool
) -> tuple[Tensor, Callable[[Tensor], Tensor]]:
    """Return an image, all its channels first, and what gives those of a result its batch back."""
    axes = _axes(spec, whole(image.shape), any_aspect)
    first = _first(image, axes)
    several = first if first.ndim == axes + 1 else first.flatten(0, 1)
    return several, _back(image, axes)


def _back(image: Tensor, axes: int) -> Callable[[Tensor], Tensor]:
    """Return what gives the channels of a result their batch back, or takes away the only one.

    `axes` is how many axes an image has without channels.
    """
    if image.ndim == axes:
        return lambda made: made.squeeze(0)
    if image.ndim == axes + 1:
        return lambda made: made
    lead = tuple(_first(image, axes).shape[:2])
    return lambda made: made.unflatten(0, lead)


def _flat(image: Tensor, axes: int) -> Tensor:
    """Return an image as (channels, texels)."""
    first = _first(image, axes)
    return first.flatten(first.ndim - axes).flatten(0, -2)


def _last(image: Tensor, axes: int) -> Tensor:
    """Return an image with all its channels last, as the kernels take it; copied once at most."""
    first = _first(image, axes)
    several = range(first.ndim - axes)
    last = first.movedim([*several], [k - len(several) for k in several])
    return last.flatten(axes).contiguous()


def _first(image: Tensor, axes: int) -> Tensor:
    """Return an image with batch and channels before all else; one channel if it has none."""
    extra = image.ndim - axes
    if extra == 0:
        return image.unsqueeze(0)
    # With faces, channels lie between them and the rows.
    return image if axes == 2 else image.movedim(extra, extra - 1)


def with_channels(made: Tensor, axes: int) -> Tensor:
    """Return an image with its channels where torch has them: between faces and rows."""
    extra = made.ndim - axes
    return made if axes == 2 or extra == 0 else made.movedim(extra - 1, -3)


def _as_before(made: Tensor, image: Tensor) -> Tensor:
    """Return a result with the dtype and the memory format of what it was made of."""
    kept = made.ndim == 4 and image.ndim == 4
    is_last = kept and image.is_contiguous(memory_format=torch.channels_last)
    if is_last and not image.is_contiguous():
        return made.to(image.dtype).contiguous(memory_format=torch.channels_last)
    return made.to(image.dtype).contiguous()


_axes = torch.compiler.assume_constant_result(linear.image_axes)
_border = torch.compiler.assume_constant_result(linear.border)
_target = torch.compiler.assume_constant_result(linear.target_of)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _conversion(shape: tuple[int, ...], src: str, dst: str, *given: Any) -> tuple[int, str, int]:
    """Return the axes of the source, the key of a conversion, and the axes of the result."""
    return linear.conversion(shape, map_of(src), map_of(dst), *given)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def turned_grid(src: str, dst: str, *given: Any) -> tuple[str, Tensor]:
    """Return the source, and the directions of the result's texels in its world."""
    source, grid = linear.turned_grid(map_of(src), map_of(dst), *given)
    return source, torch.from_numpy(grid)


@torch.compiler.assume_constant_result  # type: ignore[untyped-decorator]
def _weights(spec: str, shape: tuple[int, ...]) -> Tensor:
    return torch.from_numpy(light.weights(map_of(spec), shape, any_aspect=True))
