"""The accessor `sphere` of arrays with names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from .. import resample
from .._arrays import spatial_axes
from ..map.grid import cells, centers, on_corners
from ..map.images import expect_aspect
from ..map.named import resolve
from .attributes import attributes, described, without

if TYPE_CHECKING:
    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["Sphere"]


@xr.register_dataarray_accessor("sphere")
class Sphere:
    """An image of the sphere: the accessor `sphere` of a `DataArray`.

    Its axes are those of images elsewhere, by their places and with any names: rows and columns,
    faces in front, channels behind. Which projection it is, its attributes say: `projection`, with
    its parameters; `axes`, `grid`; and `convention`, `layout`, `world` and `pose` where there are
    such. zarr and NetCDF keep them.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, spheremap.xarray, xarray as xr
    >>> height = sm.directions("latlong", 64)[..., 1].astype(np.float32)
    >>> sky = xr.DataArray(height, dims=("v", "u"), name="sky").sphere.assign("latlong")
    >>> cube = sky.sphere.convert("cube", size=16)
    >>> cube.dims, cube.attrs["projection"], cube.sphere.projection == sm.projection("cube")
    (('face', 'v', 'u'), 'cube', True)
    >>> round(float(cube.sel(face=2).sel(u=0.5, v=0.5, method="nearest")), 1)  # up
    1.0
    """

    def __init__(self, array: xr.DataArray) -> None:
        self._array = array

    @property
    def projection(self) -> Projection:
        """The projection that the attributes say; a ValueError where they say none."""
        return described(self._array.attrs)

    def assign(self, projection: ProjectionLike, /, *, any_aspect: bool = False) -> xr.DataArray:
        """Return the same image, which says that it is of a projection.

        Parameters
        ----------
        projection : Projection or str
            What replaces that which the attributes said.
        any_aspect : bool
            As for `spheremap.convert`.

        Returns
        -------
        image : DataArray
            With coordinates `face`, `v` and `u` along its axes where these have no others.

        Raises
        ------
        ValueError, TypeError
            For an unknown name, and an array of an unfit shape.
        """
        p, array = resolve(projection), self._array
        expect_aspect(p, array.shape, any_aspect)
        _channels(array, p)
        known = _coordinates(p, array.shape, array.dims)
        missing = {name: at for name, at in known.items() if name not in array.coords}
        return array.assign_coords(missing).assign_attrs(without(array.attrs)).pipe(_saying, p)

    def convert(
        self,
        dst: ProjectionLike,
        *,
        size: Size | None = None,
        chunks: Any = "auto",
        any_aspect: bool = False,
        **options: Any,
    ) -> xr.DataArray:
        """Turn the image into another projection.

        Parameters
        ----------
        dst, size, any_aspect
            As for `spheremap.convert`.
        chunks
            As for `spheremap.dask.convert`, of an array in chunks; others are not looked at.
        **options
            `rotation`, `filter`, `fill`, ..., as for `spheremap.convert`.

        Returns
        -------
        image : DataArray
            With the axes `face`, `v` and `u`, their coordinates, and the channels as they were. In
            chunks, and not yet computed, where the array is.

        Raises
        ------
        ValueError, TypeError, NotImplementedError
            As for `spheremap.convert` and `spheremap.dask.convert`, and for an array that does not
            say its projection.

        Examples
        --------
        >>> import spheremap.xarray, xarray as xr
        >>> gray = xr.DataArray([[0.5] * 16] * 8, dims=("lat", "lon")).sphere.assign("latlong")
        >>> gray.sphere.convert("angular", size=4, fill=-1).dims
        ('v', 'u')
        """
        array, source, target = self._array, self.projection, resolve(dst)
        channels = _channels(array, source)
        options |= {"size": size, "any_aspect": any_aspect}
        if array.chunks is None:
            data = resample.convert(array.data, source, target, **options)
        else:
            from .. import dask

            data = dask.convert(array.data, source, target, chunks=chunks, **options)
        dims = (*(["face"] if spatial_axes(target) == 3 else []), "v", "u", *channels)
        kept = {name: at for name, at in array.coords.items() if set(at.dims) <= set(channels)}
        coordinates = {**kept, **_coordinates(target, data.shape, dims)}
        made = xr.DataArray(data, coordinates, dims, array.name, without(array.attrs))
        return _saying(made, target)


def _saying(array: xr.DataArray, p: Projection) -> xr.DataArray:
    """Return an array with the attributes of a projection and no others of the kind."""
    made = array.copy(deep=False)
    made.attrs = without(array.attrs) | attributes(p)
    return made


def _channels(array: xr.DataArray, p: Projection) -> tuple[Any, ...]:
    """Return the names of axes that are of no space: that of the channels, or none."""
    axes = spatial_axes(p)
    if array.ndim not in (axes, axes + 1):
        raise ValueError(
            f"Expected an array of {axes} axes, or {axes + 1} with channels, got "
            f"{array.dims}; .isel takes one image of many."
        )
    return tuple(array.dims[axes:])


def _coordinates(p: Projection, shape: tuple[int, ...], dims: Any) -> dict[Any, Any]:
    """Return the image coordinates of an image's axes, by their names."""
    axes = spatial_axes(p)
    *faces, rows, columns = shape[:axes]
    sides = [
        centers(n, c, k) for n, c, k in zip((rows, columns), cells(p), on_corners(p), strict=True)
    ]
    return dict(zip(dims, [*map(np.arange, faces), *sides], strict=False))
