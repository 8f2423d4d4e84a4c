"""Longitude and latitude of directions, in any world."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .. import _core
from .._scalars import as_flag, as_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = ["directions_to_lonlat", "lonlat_to_directions"]


def directions_to_lonlat(
    directions: ArrayLike, /, *, world: str = "+x +y -z", degrees: bool = True
) -> NDArray[np.floating[Any]]:
    """Return the longitude and latitude of directions.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        World directions of any length.
    world : str
        Which axes point to the right, up and ahead, as for `projection`: by default those of plain
        names, +y up and -z ahead. ``"+y +z +x"`` is that of maps of the earth and the sky, with the
        longitude from +x toward +y about +z.
    degrees : bool
        Whether angles are in degrees, and not in radians.

    Returns
    -------
    lonlat : ndarray, shape (..., 2)
        The longitude is 0 ahead and grows to the right, from -180 to 180; the latitude is 0 at the
        horizon and 90 above. float32 for float16 and float32 input, else float64. NaN for a
        direction that is zero or not finite.

    Raises
    ------
    ValueError
        For a wrong shape, or a `world` that is none.
    TypeError
        For complex numbers and objects.

    See Also
    --------
    directions_to_pixels : Places in an image.

    Notes
    -----
    Both are arctangents, so that they are as exact at the poles as anywhere; at a pole itself the
    longitude is 0.

    Examples
    --------
    Ahead, to the right, and above:

    >>> import spheremap as sm
    >>> sm.directions_to_lonlat([[0, 0, -1], [1, 0, 0], [0, 2, -2]]).round(6).tolist()
    [[0.0, 0.0], [90.0, 0.0], [0.0, 45.0]]
    """
    return _core.directions_to_lonlat(directions, as_text(world, "world"), _half_turn(degrees))


def lonlat_to_directions(
    lonlat: ArrayLike, /, *, world: str = "+x +y -z", degrees: bool = True
) -> NDArray[np.floating[Any]]:
    """Return the directions of a longitude and latitude.

    Parameters
    ----------
    lonlat : array_like, shape (..., 2)
        Longitude and latitude, of any size: a longitude of 370° is 10°, and a latitude beyond ±90°
        goes on over the pole and down on the other side, so that (10°, 95°) is (-170°, 85°). From
        2⁵⁰ half turns on, where numbers are a quarter turn apart, they count as 0.
    world, degrees
        As for `directions_to_lonlat`.

    Returns
    -------
    directions : ndarray, shape (..., 3)
        Unit length; float32 for float16 and float32 input, else float64. NaN for angles that are
        not finite.

    Raises
    ------
    ValueError, TypeError
        As for `directions_to_lonlat`.

    Examples
    --------
    >>> import spheremap as sm
    >>> (sm.lonlat_to_directions([90, 0]).round(6) + 0.0).tolist()
    [1.0, 0.0, 0.0]
    >>> (sm.lonlat_to_directions([90, 0], world="+y +z +x").round(6) + 0.0).tolist()
    [0.0, 1.0, 0.0]

    Five degrees over the pole:

    >>> sm.directions_to_lonlat(sm.lonlat_to_directions([10, 95])).round(6).tolist()
    [-170.0, 85.0]
    """
    return _core.lonlat_to_directions(lonlat, as_text(world, "world"), _half_turn(degrees))


def _half_turn(degrees: bool) -> float:
    return 180.0 if as_flag(degrees, "degrees") else math.pi
