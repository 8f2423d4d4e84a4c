"""The verbs of images, of arrays of JAX with channels before the rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp

from .. import light
from ..map.grid import places
from ..map.spec import map_of, spec_of
from ..resample import linear
from . import _images, _sums
from ._given import in_float, one_rotation, split_rotation, turned_back, vectors
from ._moving import Moving, now, seen

if TYPE_CHECKING:
    from .._arrays import Size
    from .._names import ConvertFilter, Filter
    from ..map.named import ProjectionLike, Worlds

__all__ = ["convert", "integrate", "pad", "sample"]


def sample(
    image: Any,
    directions: Any,
    /,
    projection: ProjectionLike | Moving,
    *,
    filter: str = "bilinear",
    axes: str | None = None,
    rotation: Any | None = None,
    fill: float = 0.0,
    any_aspect: bool = False,
) -> jax.Array:
    """Look directions up in an image.

    Parameters
    ----------
    image : Array, shape (H, W), (C, H, W) or (N, C, H, W)
        With faces (F, S, S), (F, C, S, S) or (N, F, C, S, S). Of floats.
    directions : Array, shape (..., 3)
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
    values : Array, shape (...), (C, ...) or (N, C, ...)
        Of the image's dtype.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sample`.
    NotImplementedError
        For a gradient, when it is asked for, that there is none of.

    Notes
    -----
    Bilinear lookups in maps of one rectangular image (latlong, octahedral, equal_area, perspective,
    ...) are gathers, with gradients of the image and of directions; the latter are constant along
    each axis between four texels, and of one side on the lines between centers. Lookups in faces
    and disks, and by other filters, are the library's own, called from the compiled program: their
    gradient of the image is the exact adjoint. Bilinear ones have that of directions too; at rims
    and at the edges of faces it is a difference of lookups.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, spheremap.jax
    >>> def red(image):
    ...     return spheremap.jax.sample(image, jnp.array([0.0, 0.0, -1.0]), "latlong")[0]
    >>> slope = jax.grad(red)(jnp.zeros((3, 32, 64)))
    >>> slope.shape, round(slope.sum().item(), 6)
    ((3, 32, 64), 1.0)
    """
    turn, fixed = split_rotation(rotation)
    spec, moving = seen(projection, axes, fixed)
    return _looked_up(image, directions, spec, turn, filter, float(fill), any_aspect, moving)


def convert(
    image: Any,
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
) -> jax.Array:
    """Turn an image from one projection into another.

    Parameters
    ----------
    image : Array
        As for `sample`.
    src, dst, size, filter, antialias, world, any_aspect
        As for `spheremap.convert`.
    rotation : Array, array_like or an object with ``.as_matrix()``, optional
        As for `spheremap.convert`, of shape (3, 3). An array of JAX is one that gradients flow to,
        as are the parameters of `src` and `dst` that are, with ``filter="bilinear",
        antialias=False``; other filters want arrays of NumPy, and numbers.
    fill : float
        As for `spheremap.convert`.

    Returns
    -------
    image : Array
        With the batch, channels and dtype of the image.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.convert`; ValueError for an array of JAX as `rotation` or as a parameter
        with other filters, and without a `size` where a transform hides a parameter.

    Notes
    -----
    On the CPU it is the library's own, called from the compiled program; elsewhere a sparse matrix.
    The gradient is the exact adjoint, with every filter that adds texels up: all but ``"mode"``.
    The matrix is found when it is first wanted and held. With ``filter="bilinear",
    antialias=False``, from a rectangular image, that takes no longer than a call; with others as
    long as `weights_matrix` does, seconds for images of a hundred rows and minutes for 512.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, spheremap.jax
    >>> def total(batch):
    ...     return spheremap.jax.convert(batch, "latlong", "cube", size=16, antialias=False).sum()
    >>> round(jax.jit(jax.grad(total))(jnp.ones((2, 3, 32, 64))).sum().item())
    9216
    """
    turn, fixed = split_rotation(rotation)
    data = in_float(image, "image")
    if turn is not None:
        turn = one_rotation(turn)
    if turn is not None or isinstance(src, Moving) or isinstance(dst, Moving):
        if filter != "bilinear" or antialias:
            raise ValueError(
                "An array of JAX as `rotation`, or as a parameter of a map, wants "
                "filter='bilinear' and antialias=False; give others as one of NumPy, and as a "
                "number."
            )
        return _moved(image, src, dst, size, turn, fixed, float(fill), world, any_aspect)
    held, key, made = linear.conversion(
        data.shape, src, dst, size, fixed, filter, fill, antialias, world, any_aspect
    )
    return _summed(image, data, held, key, made)


def pad(
    image: Any,
    /,
    projection: ProjectionLike,
    n: int,
    *,
    filter: Filter | str = "bilinear",
    any_aspect: bool = False,
) -> jax.Array:
    """Put a border of `n` texels around each face that continues the image over its seams.

    Parameters
    ----------
    image : Array
        As for `sample`.
    projection, n, filter, any_aspect
        As for `spheremap.pad`.

    Returns
    -------
    padded : Array, shape (..., H + 2n, W + 2n)
        As of `spheremap.pad`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.pad`.

    Notes
    -----
    As `convert`: the gradient is the exact adjoint.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> spheremap.jax.pad(jnp.zeros((8, 3, 32, 64)), "latlong", 1).shape
    (8, 3, 34, 66)
    """
    data = in_float(image, "image")
    held, key, made = linear.border(data.shape, projection, n, filter, any_aspect)
    return _summed(image, data, held, key, made)


def integrate(image: Any, /, projection: ProjectionLike, *, any_aspect: bool = False) -> jax.Array:
    """Integrate an image over the sphere: ∫ L dω.

    Parameters
    ----------
    image : Array
        As for `sample`.
    projection, any_aspect
        As for `light.integrate`.

    Returns
    -------
    integral : Array, shape (), (C,) or (N, C)
        Of the image's dtype, and summed in it. NaN spreads.

    Raises
    ------
    ValueError, TypeError
        As for `light.integrate`.

    Notes
    -----
    The gradient is the solid angle of each texel, `light.weights`.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax
    >>> round(float(spheremap.jax.integrate(jnp.ones((64, 128)), "latlong") / jnp.pi), 5)
    4.0
    """
    data = in_float(image, "image")
    spec = spec_of(projection)
    held = linear.image_axes(spec, data.shape, any_aspect)
    texels, back = channels_last(data, held)
    weights = light.weights(map_of(spec), texels.shape[:-1], any_aspect=True)
    columns = jnp.asarray(weights, data.dtype).reshape(-1, 1)
    # Texels without a part in the sphere hold no value: whatever is there does not count.
    values = jnp.where(columns == 0, 0.0, _images.flat(texels))
    total = jnp.sum(values * columns, axis=0)
    return back(total).astype(jnp.asarray(image).dtype)


def _moved(
    image: Any,
    src: ProjectionLike | Moving,
    dst: ProjectionLike | Moving,
    size: Size | None,
    turn: jax.Array | None,
    fixed: Any | None,
    fill: float,
    world: Worlds,
    any_aspect: bool,
) -> jax.Array:
    """Return a conversion by bilinear lookups, whose places are no constants."""
    if size is None and not all(p.is_known for p in (src, dst) if isinstance(p, Moving)):
        raise ValueError("Expected `size`, since the parameters of a map are not known here.")
    data = in_float(image, "image")
    spec, moving = seen(src, None, fixed)
    source, grid = linear.turned_grid(map_of(spec), now(dst), size, data.shape, world, any_aspect)
    directions = jnp.asarray(grid, data.dtype)
    if isinstance(dst, Moving):
        target = dst.in_world_of(source) if world == "match" else dst
        directions = target.decode(
            jnp.asarray(places(map_of(target.spec), grid.shape[:-1]), data.dtype)
        )
    found = _looked_up(image, directions, source, turn, "bilinear", fill, any_aspect, moving)
    # (channels, faces, rows, columns), as values of directions come.
    extra = data.ndim - linear.image_axes(source, data.shape, any_aspect)
    faces = extra > 0 and grid.ndim == 4
    return jnp.moveaxis(found, extra - 1, -3) if faces else found


def _looked_up(
    image: Any,
    directions: Any,
    spec: str,
    turn: jax.Array | None,
    filter: str,
    fill: float,
    any_aspect: bool,
    moving: Moving | None = None,
) -> jax.Array:
    data = in_float(image, "image")
    looked = vectors(directions, 3, "directions").astype(data.dtype)
    if turn is not None:
        looked = turned_back(turn, looked)
    texels, back = channels_last(data, linear.image_axes(spec, data.shape, any_aspect))
    if moving is None:
        found = _images.sample(texels, looked, spec, filter, fill)
    else:
        found = moving.sample(texels, looked, filter, fill)
    # (..., channels) becomes (N, C, ...).
    return back(jnp.moveaxis(found, -1, 0)).astype(jnp.asarray(image).dtype)


def _summed(image: Any, data: jax.Array, axes: int, key: str, made: int) -> jax.Array:
    """Return what a key stands for of an image, whose result has so many axes."""
    texels, back = channels_last(data, axes)
    found = _sums.apply(_images.Conversion(key), texels)
    many = back(jnp.moveaxis(found, -1, 0))
    extra = many.ndim - made
    if made != 2 and extra:
        # With faces, channels lie between them and the rows.
        many = jnp.moveaxis(many, extra - 1, -3)
    return many.astype(jnp.asarray(image).dtype)


def channels_last(
    image: jax.Array, axes: int
) -> tuple[jax.Array, Callable[[jax.Array], jax.Array]]:
    """Return an image with all its channels last, and what gives (channels, ...) its batch back.

    `axes` is how many axes an image has without channels.
    """
    extra = image.ndim - axes
    if extra == 0:
        return image[..., None], lambda made: made[0]
    last = jnp.moveaxis(image, -3, -1)
    if extra == 1:
        return last, lambda made: made
    lead = (image.shape[0], last.shape[-1])
    merged = jnp.moveaxis(last, 0, -2).reshape(*last.shape[1:-1], -1)
    return merged, lambda made: made.reshape(*lead, *made.shape[1:])
