"""The accessor `sphere` of arrays with names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import xarray as xr

from .. import resample
from .._scalars import as_flag
from ..map.images import expect_aspect
from ..map.named import resolve
from .attributes import described, without
from .axes import (
    channels_of,
    expect_distinct,
    expect_rising,
    image_of,
    kept,
    own_coordinates,
    saying,
    texel_coordinates,
)
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
    faces in front, channels behind. Those named `face`, `v` and `u` are in these places, and their
    coordinates those of the texels; an array that says otherwise is an error.

    Which projection it is, its attributes say: `projection`, with its parameters; `axes`, `grid`;
    and `convention`, `layout`, `world` and `pose` where there are such. zarr and NetCDF keep them.

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
            With coordinates along its axes where these have none: those of an axis named `face`,
            `v` or `u` are replaced, latitudes and all others kept.

        Raises
        ------
        ValueError, TypeError
            For an unknown name, an array of an unfit shape, and coordinates `v`, `u` and `lat` that
            go the other way than those of the projection: rows begin at the top.
        """
        p, array = resolve(projection), self._array
        expect_aspect(p, array.shape, any_aspect)
        channels_of(array, p)
        expect_rising(array, p)
        known = texel_coordinates(p, array.shape, array.dims)
        replaced = own_coordinates(array, p)
        new = {k: at for k, at in known.items() if k not in array.coords or k in replaced}
        return array.assign_coords(new).assign_attrs(without(array.attrs)).pipe(saying, p)

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
            `rotation`, `filter`, `fill`, ..., as for `spheremap.convert`; one rotation, no
            `window`, and no `channels_first`: the channels come last, as in every image here.

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
        array, source, channels = self._image(options.get("rotation"))
        target = resolve(dst)
        if options.pop("window", None) is not None:
            raise ValueError(
                "Expected no `window`: a part of an image is none of its projection. .isel takes "
                "it of the result, which an array in chunks computes of it alone."
            )
        if as_flag(options.pop("channels_first", False), "channels_first"):
            raise ValueError(
                "Expected no `channels_first`: the channels are the axis behind the others, "
                f"got {array.dims}; .transpose moves it there before .assign."
            )
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
            `rotation`, `filter`, `fill`, ..., as for `spheremap.sample`; one rotation.

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
        array, p, channels = self._image(options.get("rotation"))
        rays = directions if isinstance(directions, xr.DataArray) else xr.DataArray(directions)
        options["any_aspect"] = any_aspect
        if rays.chunks is None:
            data = resample.sample(array.values, rays.values, p, **options)
        else:
            from .. import dask

            data = dask.sample(array.values, rays.data, p, **options)
        dims = (*rays.dims[:-1], *channels)
        expect_distinct(dims)
        coordinates = {**kept(array, channels), **kept(rays, rays.dims[:-1])}
        return xr.DataArray(data, coordinates, dims, array.name, without(array.attrs))
