"""The accessor `sphere` of arrays with names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import xarray as xr

from .. import resample
from ..map.images import expect_aspect
from ..map.named import resolve
from .attributes import described, without
from .axes import channels_of, image_of, kept, saying, texel_coordinates
from .sums import Sums

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["Sphere"]


@xr.register_dataarray_accessor("sphere")
class Sphere(Sums):
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
        channels_of(array, p)
        known = texel_coordinates(p, array.shape, array.dims)
        missing = {name: at for name, at in known.items() if name not in array.coords}
        return array.assign_coords(missing).assign_attrs(without(array.attrs)).pipe(saying, p)

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
        channels = channels_of(array, source)
        options |= {"size": size, "any_aspect": any_aspect}
        if array.chunks is None:
            data = resample.convert(array.data, source, target, **options)
        else:
            from .. import dask

            data = dask.convert(array.data, source, target, chunks=chunks, **options)
        return image_of(data, target, channels, array, without(array.attrs))

    def sample(
        self,
        directions: ArrayLike | xr.DataArray,
        /,
        *,
        any_aspect: bool = False,
        **options: Any,
    ) -> xr.DataArray:
        """Look directions up in the image.

        Parameters
        ----------
        directions : DataArray or array_like, shape (..., 3)
            World directions of any length; the last axis is that of x, y and z, of any name.
        any_aspect
            As for `spheremap.sample`.
        **options
            `rotation`, `filter`, `fill`, ..., as for `spheremap.sample`.

        Returns
        -------
        values : DataArray
            With the axes and coordinates of the directions, and the channels of the image. In
            chunks, and not yet computed, where the directions are. The image is held whole.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.sample`, and for an array that does not say its projection.

        Examples
        --------
        >>> import spheremap.xarray, xarray as xr
        >>> gray = xr.DataArray([[0.5] * 16] * 8, dims=("lat", "lon")).sphere.assign("latlong")
        >>> rays = xr.DataArray([[0.0, 1.0, 0.0]] * 2, dims=("star", "xyz"))
        >>> gray.sphere.sample(rays).dims
        ('star',)
        """
        array, p = self._array, self.projection
        channels = channels_of(array, p)
        rays = directions if isinstance(directions, xr.DataArray) else xr.DataArray(directions)
        options["any_aspect"] = any_aspect
        if rays.chunks is None:
            data = resample.sample(array.values, rays.values, p, **options)
        else:
            from .. import dask

            data = dask.sample(array.values, rays.data, p, **options)
        dims = (*rays.dims[:-1], *channels)
        coordinates = {**kept(array, channels), **kept(rays, rays.dims[:-1])}
        return xr.DataArray(data, coordinates, dims, array.name, without(array.attrs))
