"""Light of arrays of JAX: irradiance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp

from ..map.spec import map_of
from ..resample import linear
from . import sh
from ._given import in_float

if TYPE_CHECKING:
    from .._arrays import Size
    from ..map.named import ProjectionLike

__all__ = ["irradiance"]


def irradiance(
    image: Any,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size = 32,
    rotation: Any | None = None,
    order: int = 8,
    world: str = "match",
    any_aspect: bool = False,
) -> jax.Array:
    """Return the irradiance of a surface for every normal, by spherical harmonics.

    Parameters
    ----------
    image : Array
        Radiance, as for `spheremap.jax.sample`.
    src, dst, size, world, any_aspect
        As for `spheremap.light.irradiance`.
    rotation : Array, array_like or an object with ``.as_matrix()``, optional
        Turns the content in the world. Gradients flow to an array of JAX.
    order : int
        The highest degree. The bound of the error is that of ``method="sh"`` there.

    Returns
    -------
    irradiance : Array
        With the batch, channels and dtype of the image. 0 outside the valid image of `dst`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.light.irradiance`.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax as smj
    >>> e = smj.light.irradiance(jnp.ones((3, 32, 64)), "latlong", "cube", size=8)
    >>> e.shape, round(float(e.mean() / jnp.pi), 5)
    ((6, 3, 8, 8), 1.0)
    """
    data = in_float(image, "image")
    source, grid = linear.turned_grid(src, dst, size, data.shape, world, any_aspect)
    found = sh.project(data, map_of(source), order=order, rotation=rotation, any_aspect=any_aspect)
    d = jnp.asarray(grid, data.dtype)
    values = sh.evaluate(sh.convolve(found, lobe="cosine"), d)
    # Normals that there are none of.
    kept = jnp.where(jnp.isnan(d).any(-1), 0.0, values)
    extra = kept.ndim - grid.ndim + 1
    made = jnp.moveaxis(kept, extra - 1, -3) if extra and grid.ndim == 4 else kept
    return made.astype(jnp.asarray(image).dtype)
