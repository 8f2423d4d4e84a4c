"""Sums over images with names: what `spheremap.light` and `spheremap.sh` make of arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from .. import light, sh
from ..map.named import resolve
from .attributes import described, without
from .axes import (
    channels_of,
    expect_distinct,
    expect_one_rotation,
    expect_own_coordinates,
    image_of,
    kept,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from numpy.typing import ArrayLike

    from .._arrays import Negative, Size
    from .._projection import Projection
    from ..light.report import Energy
    from ..map.named import ProjectionLike, Worlds

__all__ = ["Sums"]


class Sums:
    """Verbs of `spheremap.light` and `spheremap.sh` for an array that says its projection.

    In chunks, and not yet computed, where the array is; of the same bits. Attributes other than the
    projection stay where a result has the unit of the image.
    """

    def __init__(self, array: xr.DataArray) -> None:
        self._array = array

    def _image(
        self, rotation: Any | None = None
    ) -> tuple[xr.DataArray, Projection, tuple[Hashable, ...]]:
        """Return the array, its projection, and the names of axes of channels, or raise."""
        p = described(self._array.attrs)
        channels = channels_of(self._array, p)
        expect_own_coordinates(self._array, p)
        expect_one_rotation(rotation)
        return self._array, p, channels

    def integrate(
        self, *, skipna: bool = False, negative: Negative = "keep", any_aspect: bool = False
    ) -> xr.DataArray:
        """Return the integral over the sphere, ∫ L dω, of each channel.

        Parameters
        ----------
        skipna, negative, any_aspect
            As for `spheremap.light.integrate`.

        Returns
        -------
        integral : DataArray of float64
            With the axis of channels, if there is one.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.integrate`, and for an array that does not say its projection,
            or whose coordinates `face`, `v` or `u` are not those of its texels.

        Examples
        --------
        >>> import numpy as np, spheremap.xarray, xarray as xr
        >>> white = xr.DataArray(np.ones((8, 16)), dims=("v", "u")).sphere.assign("latlong")
        >>> round(float(white.sphere.integrate() / np.pi), 12)
        4.0
        """
        checks = {"skipna": skipna, "negative": negative, "any_aspect": any_aspect}
        array, p, channels = self._image()
        data = _verb(array, light, "integrate")(array.data, p, **checks)
        return xr.DataArray(data, kept(array, channels), channels, array.name)

    def mean(
        self, *, skipna: bool = False, negative: Negative = "keep", any_aspect: bool = False
    ) -> xr.DataArray:
        """Return the mean over the sphere of each channel: texels weigh what they see.

        Parameters
        ----------
        skipna, negative, any_aspect
            As for `spheremap.light.mean`.

        Returns
        -------
        mean : DataArray of float64
            With the axis of channels, if there is one.

        Raises
        ------
        ValueError, TypeError
            As for `integrate`.

        Examples
        --------
        >>> import spheremap as sm, spheremap.xarray, xarray as xr
        >>> height = sm.directions("latlong", 64)[..., 1] + 1
        >>> sky = xr.DataArray(height, dims=("v", "u")).sphere.assign("latlong")
        >>> round(float(sky.sphere.mean()), 12)
        1.0
        """
        checks = {"skipna": skipna, "negative": negative, "any_aspect": any_aspect}
        array, p, channels = self._image()
        data = _verb(array, light, "mean")(array.data, p, **checks)
        said = without(array.attrs)
        return xr.DataArray(data, kept(array, channels), channels, array.name, said)

    def irradiance(
        self,
        dst: ProjectionLike,
        *,
        size: Size = 32,
        rotation: Any | None = None,
        method: Literal["exact", "sh"] = "exact",
        order: int = 8,
        skipna: bool = False,
        world: Worlds = "match",
        negative: Negative = "keep",
        any_aspect: bool = False,
    ) -> xr.DataArray:
        """Return the irradiance of a surface for every normal.

        Parameters
        ----------
        dst, size, rotation, method, order, skipna, world, negative, any_aspect
            As for `spheremap.light.irradiance`; one rotation.

        Returns
        -------
        irradiance : DataArray
            With the axes `face`, `v` and `u`, their coordinates, and the channels of the image.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.irradiance`, and for an array that does not say its projection.

        Examples
        --------
        >>> import numpy as np, spheremap.xarray, xarray as xr
        >>> white = xr.DataArray(np.ones((64, 128)), dims=("v", "u")).sphere.assign("latlong")
        >>> E = white.sphere.irradiance("cube", size=4, method="sh")
        >>> E.dims, round(float(E[0, 0, 0] / np.pi), 6)
        (('face', 'v', 'u'), 1.0)
        """
        array, p, channels = self._image(rotation)
        target = resolve(dst)
        data = _verb(array, light, "irradiance")(
            array.data,
            p,
            target,
            size=size,
            rotation=rotation,
            method=method,
            order=order,
            skipna=skipna,
            world=world,
            negative=negative,
            any_aspect=any_aspect,
        )
        return image_of(data, target, channels, array, {})

    def sh(
        self,
        *,
        order: int,
        texels: Literal["means", "points"] = "means",
        axes: str | None = None,
        rotation: Any | None = None,
        skipna: bool = False,
        any_aspect: bool = False,
    ) -> xr.DataArray:
        """Return the coefficients of real spherical harmonics.

        Parameters
        ----------
        order, texels, axes, rotation, skipna, any_aspect
            As for `spheremap.sh.project`; one rotation.

        Returns
        -------
        coefficients : DataArray of float64
            With the axis `coefficient`, which has the coordinates `l` and `m`, and that of
            channels, if there is one.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.sh.project`, and for an array that does not say its projection.

        Examples
        --------
        >>> import spheremap as sm, spheremap.xarray, xarray as xr
        >>> height = sm.directions("latlong", 64)[..., 1]
        >>> sky = xr.DataArray(height, dims=("v", "u")).sphere.assign("latlong")
        >>> found = sky.sphere.sh(order=1)
        >>> found.l.values.tolist(), found.m.values.tolist()
        ([0, 1, 1, 1], [0, -1, 0, 1])
        >>> (found.round(3) + 0.0).values.tolist()  # y
        [0.0, 2.047, 0.0, 0.0]
        """
        array, p, channels = self._image(rotation)
        options = {"texels": texels, "axes": axes, "rotation": rotation}
        checks = {"skipna": skipna, "any_aspect": any_aspect}
        data = _verb(array, sh, "project")(array.data, p, order=order, **options, **checks)
        expect_distinct(("coefficient", "l", "m", *channels))
        numbers = np.arange(data.shape[0])
        degree = np.repeat(np.arange(order + 1), 2 * np.arange(order + 1) + 1)
        coordinates = {
            **kept(array, channels),
            "l": ("coefficient", degree),
            "m": ("coefficient", numbers - degree * (degree + 1)),
        }
        return xr.DataArray(data, coordinates, ("coefficient", *channels), array.name)

    def energy(
        self,
        *,
        axes: str | None = None,
        rotation: Any | None = None,
        luminance: ArrayLike | None = None,
        skipna: bool = False,
        negative: Negative = "keep",
        any_aspect: bool = False,
    ) -> Energy:
        """Report the light of the image: how much, how unevenly, and where a sun is.

        Parameters
        ----------
        axes, rotation, luminance, skipna, negative, any_aspect
            As for `spheremap.light.energy`; one rotation.

        Returns
        -------
        report : Energy
            Computed by the call, of an array in chunks as well.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.energy`, and for an array that does not say its projection.

        Examples
        --------
        >>> import numpy as np, spheremap.xarray, xarray as xr
        >>> white = xr.DataArray(np.ones((8, 16)), dims=("v", "u")).sphere.assign("latlong")
        >>> white.sphere.energy().peak
        1.0
        """
        array, p, _ = self._image(rotation)
        report: Energy = _verb(array, light, "energy")(
            array.data,
            p,
            axes=axes,
            rotation=rotation,
            luminance=luminance,
            skipna=skipna,
            negative=negative,
            any_aspect=any_aspect,
        )
        return report


def _verb(array: xr.DataArray, subject: Any, name: str) -> Callable[..., Any]:
    """Return a verb of a subject for arrays as they are, or for those in chunks."""
    if array.chunks is None:
        found: Callable[..., Any] = getattr(subject, name)
        return found
    from .. import dask

    in_chunks = dask.light if subject is light else dask.sh
    return getattr(in_chunks, name)  # type: ignore[no-any-return]
