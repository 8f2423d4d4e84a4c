"""Lookups of directions in chunks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import dask
import dask.array as da
import numpy as np

from .. import resample
from .._arrays import as_array, expect_vectors, spatial_axes
from ..map.images import expect_aspect
from ..map.named import resolve

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from .._names import SampleFilter
    from ..map.named import ProjectionLike

__all__ = ["sample"]


def sample(
    image: ArrayLike,
    directions: da.Array,
    /,
    projection: ProjectionLike,
    *,
    filter: SampleFilter | str | None = None,
    axes: str | None = None,
    rotation: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    alpha: int | None = None,
    skipna: bool = False,
    any_aspect: bool = False,
) -> da.Array:
    """Look directions in chunks up in an image.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        One that fits into the memory of a worker, which holds it once.
    directions : dask.array.Array, shape (..., 3)
        World directions of any length. Chunks of the last axis are put together.
    projection, filter, axes, rotation, fill, alpha, skipna, any_aspect
        As for `spheremap.sample`; one rotation.

    Returns
    -------
    values : dask.array.Array, shape (...) or (..., C), of the image's dtype
        In the chunks of the directions.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sample`, at once.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap as sm, spheremap.dask
    >>> sky = sm.directions("latlong", 64)[..., 1]
    >>> up = da.from_array(np.tile([[0.0, 2.0, 0.0]], (1000, 1)), chunks=(300, 3))
    >>> values = spheremap.dask.sample(sky, up, "latlong")
    >>> values.chunks, round(float(values.mean()), 3)
    (((300, 300, 300, 100),), 1.0)
    """
    if not isinstance(directions, da.Array):
        raise TypeError(
            f"Expected `directions` to be an array of dask, got {type(directions).__name__}; "
            "dask.array.from_array makes one."
        )
    expect_vectors(directions.shape, "directions")
    pixels = as_array(image, "image")
    options: dict[str, Any] = {
        "filter": filter,
        "fill": fill,
        "alpha": alpha,
        "skipna": skipna,
        "any_aspect": any_aspect,
    }
    resolved = resolve(resolve(projection), axes, rotation)
    expect_aspect(resolved, pixels.shape, any_aspect)
    if pixels.ndim > spatial_axes(resolved) + 1:
        raise ValueError(f"Expected one `image`, got shape {pixels.shape}.")
    nowhere = np.empty((*[0] * (directions.ndim - 1), 3), directions.dtype)
    meta = resample.sample(pixels, nowhere, resolved, **options)
    whole = directions.rechunk({directions.ndim - 1: -1})
    last = directions.ndim - 1
    with_channels = meta.ndim == directions.ndim
    return da.map_blocks(
        _looked_up,
        whole,
        dask.delayed(pixels, pure=True),
        resolved,
        options,
        chunks=(*whole.chunks[:-1], *([meta.shape[-1:]] if with_channels else [])),
        drop_axis=() if with_channels else last,
        dtype=meta.dtype,
        meta=meta,
        name=None,
        token=None,
    )


def _looked_up(directions: Any, image: Any, projection: Any, options: Any) -> Any:
    return resample.sample(image, directions, projection, **options)
