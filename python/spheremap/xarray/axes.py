"""The axes of images with names: which are of space, and where their texels lie."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from .._arrays import spatial_axes
from ..map.grid import cells, centers, on_corners
from .attributes import attributes, without

if TYPE_CHECKING:
    from .._projection import Projection

__all__ = ["channels_of", "image_of", "kept", "saying", "texel_coordinates"]


def image_of(
    data: Any, p: Projection, channels: tuple[Any, ...], source: xr.DataArray, said: dict[Any, Any]
) -> xr.DataArray:
    """Return an image of a projection, whose channels are those of another, and attributes."""
    dims = (*(["face"] if spatial_axes(p) == 3 else []), "v", "u", *channels)
    coordinates = {**kept(source, channels), **texel_coordinates(p, data.shape, dims)}
    return saying(xr.DataArray(data, coordinates, dims, source.name, said), p)


def kept(array: xr.DataArray, dims: tuple[Any, ...]) -> dict[Any, Any]:
    """Return the coordinates that belong to no other axes than these."""
    return {name: at for name, at in array.coords.items() if set(at.dims) <= set(dims)}


def saying(array: xr.DataArray, p: Projection) -> xr.DataArray:
    """Return an array with the attributes of a projection and no others of the kind."""
    made = array.copy(deep=False)
    made.attrs = without(array.attrs) | attributes(p)
    return made


def channels_of(array: xr.DataArray, p: Projection) -> tuple[Any, ...]:
    """Return the names of axes that are of no space: that of the channels, or none."""
    axes = spatial_axes(p)
    if array.ndim not in (axes, axes + 1):
        raise ValueError(
            f"Expected an array of {axes} axes, or {axes + 1} with channels, got "
            f"{array.dims}; .isel takes one image of many."
        )
    return tuple(array.dims[axes:])


def texel_coordinates(p: Projection, shape: tuple[int, ...], dims: Any) -> dict[Any, Any]:
    """Return the image coordinates of an image's axes, by their names."""
    axes = spatial_axes(p)
    *faces, rows, columns = shape[:axes]
    sides = [
        centers(n, c, k) for n, c, k in zip((rows, columns), cells(p), on_corners(p), strict=True)
    ]
    return dict(zip(dims, [*map(np.arange, faces), *sides], strict=False))
