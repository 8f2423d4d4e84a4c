"""The axes of images with names: which are of space, and where their texels lie."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from .._arrays import as_array, spatial_axes
from ..map.grid import cells, centers, on_corners
from ..map.lonlat import directions_to_lonlat
from .attributes import attributes, without

if TYPE_CHECKING:
    from collections.abc import Hashable

    from .._projection import Projection

__all__ = [
    "channels_of",
    "expect_distinct",
    "expect_one_rotation",
    "expect_own_coordinates",
    "expect_rising",
    "image_of",
    "kept",
    "own_coordinates",
    "saying",
    "texel_coordinates",
]

# Coordinates that files keep in float32 are known to so much.
_ROUNDING = np.finfo(np.float32).eps


def image_of(
    data: Any, p: Projection, channels: tuple[Any, ...], source: xr.DataArray, said: dict[Any, Any]
) -> xr.DataArray:
    """Return an image of a projection, whose channels are those of another, and attributes."""
    dims = (*_names(p), *channels)
    expect_distinct(dims)
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


def channels_of(array: xr.DataArray, p: Projection) -> tuple[Hashable, ...]:
    """Return the names of axes that are of no space, or raise for axes that are no image's."""
    names, dims = _names(p), array.dims
    axes = len(names)
    misplaced = any(name in dims and dims.index(name) != k for k, name in enumerate(names))
    if array.ndim not in (axes, axes + 1) or misplaced:
        way = ""
        if array.ndim > axes + 1:
            way = "; .isel takes one image of many"
        elif set(names) <= set(dims):
            way = f"; .transpose({', '.join(map(repr, names))}, ...) puts them in order"
        elif "face" in names and "face" not in dims:
            way = "; a face by itself, as of .isel(face=0), is no image of the sphere"
        elif set(dims[axes:]) & set(names):
            way = f"; .rename gives the channels another name than {dims[-1]!r}"
        raise ValueError(
            f"Expected an array of {axes} axes, in the order of {names}, or {axes + 1} with "
            f"channels behind, got {dims}{way}."
        )
    if axes == 2:
        _expect_latitudes(array, p)
    return tuple(dims[axes:])


def _expect_latitudes(array: xr.DataArray, p: Projection) -> None:
    """Raise for an image whose rows have latitudes that go the other way than its map's."""
    rows = array.dims[0]
    for name in ("lat", "latitude"):
        own = _numbers(array, name)
        if not own.size or array.coords[name].dims != (rows,):
            continue
        _, top = directions_to_lonlat(p.decode([0.5, 0.0]), world=p.world)
        if own[0] * own[-1] < 0 and own[0] * top < 0:
            ends = ("north", "south") if top > 0 else ("south", "north")
            raise ValueError(
                f"Expected `{name}` of '{p.name}' to go from {' to '.join(ends)}, got {own[0]:g} "
                f"to {own[-1]:g}; .isel({rows}=slice(None, None, -1)) turns the rows around."
            )


def own_coordinates(array: xr.DataArray, p: Projection) -> dict[str, Any]:
    """Return the numbers that an array has for axes of space named as this library names them."""
    own = {name: _numbers(array, name) for name in _names(p) if name in array.dims}
    return {name: numbers for name, numbers in own.items() if numbers.size}


def expect_rising(array: xr.DataArray, p: Projection) -> None:
    """Raise for own coordinates that go the other way than those of texels."""
    for name, own in own_coordinates(array, p).items():
        if own[0] > own[-1]:
            raise ValueError(
                f"Expected `{name}` to rise along its axis, got {own[0]:g} to {own[-1]:g}; "
                f".isel({name}=slice(None, None, -1)) turns the image around, .drop_vars({name!r}) "
                "takes it as it lies."
            )


def expect_own_coordinates(array: xr.DataArray, p: Projection) -> None:
    """Raise for own coordinates that are not those of the texels."""
    own = own_coordinates(array, p)
    known = texel_coordinates(p, array.shape, array.dims) if own else {}
    for name, found in own.items():
        expected = known[name]
        if not np.allclose(found, expected, rtol=0, atol=_ROUNDING):
            raise ValueError(
                f"Expected `{name}` to be the coordinates of {len(expected)} texels of "
                f"'{p.name}', {expected[0]:g} to {expected[-1]:g}, got {found[0]:g} to "
                f"{found[-1]:g}; .sortby({name!r}) puts what was turned around in order, "
                f".drop_vars({name!r}) takes the image as it lies."
            )


def expect_distinct(dims: tuple[Any, ...]) -> None:
    """Raise for axes of one name."""
    for name in dims:
        if dims.count(name) > 1:
            raise ValueError(
                f"Expected axes of different names, got {dims}; .rename gives the channels, or "
                f"directions, another name than {name!r}."
            )


def expect_one_rotation(rotation: Any) -> None:
    """Raise for several rotations."""
    as_matrix = getattr(rotation, "as_matrix", None)
    shape = as_array(as_matrix() if callable(as_matrix) else rotation, "rotation").shape
    if len(shape) > 2:
        raise ValueError(
            f"Expected `rotation` to be one rotation, of shape (3, 3), got {shape}; of several, "
            "xarray.concat puts the results together."
        )


def texel_coordinates(p: Projection, shape: tuple[int, ...], dims: Any) -> dict[Any, Any]:
    """Return the image coordinates of an image's axes, by their names."""
    axes = spatial_axes(p)
    *faces, rows, columns = shape[:axes]
    sides = [
        centers(n, c, k) for n, c, k in zip((rows, columns), cells(p), on_corners(p), strict=True)
    ]
    return dict(zip(dims, [*map(np.arange, faces), *sides], strict=False))


def _names(p: Projection) -> tuple[str, ...]:
    """Return the names of the axes of space of images that this library makes."""
    return ("face", "v", "u")[-spatial_axes(p) :]


def _numbers(array: xr.DataArray, name: Hashable) -> Any:
    """Return coordinates along an axis in float64, none where they are no numbers."""
    # An axis without coordinates gives its numbers, were it asked for them.
    if name not in array.coords or array.coords[name].ndim != 1:
        return np.empty(0)
    own = array.coords[name].values
    return own.astype(np.float64) if own.dtype.kind in "iuf" else np.empty(0)
