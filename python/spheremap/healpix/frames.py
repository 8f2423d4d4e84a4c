"""Turns between the frames in which directions of the sky are given."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

from .._scalars import as_text

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_MAS = math.radians(1 / 3_600_000)


def frame_rotation(
    src: Literal["icrs", "galactic", "ecliptic"],
    dst: Literal["icrs", "galactic", "ecliptic"],
    /,
) -> Floats:
    """Return the rotation that takes directions from one frame of the sky to another.

    Parameters
    ----------
    src, dst : {"icrs", "galactic", "ecliptic"}
        The frames: ICRS, galactic as astropy's ``Galactic``, and the mean ecliptic and equinox of
        J2000.0 as its ``BarycentricMeanEcliptic``.

    Returns
    -------
    rotation : ndarray, shape (3, 3)
        ``directions @ rotation.T`` are those of `dst`. As ``rotation=`` of `convert` it makes of a
        map in `src` one in `dst`.

    Raises
    ------
    ValueError, TypeError
        For another frame.

    Notes
    -----
    All three are centered on the barycenter of the solar system, so that for stars and maps there
    is nothing but the turn; it agrees with astropy to 1e-12. The galactic pole of 1958 is carried
    over to J2000 [1]_, and FK5 to ICRS by Hipparcos [2]_; the obliquity is that of IAU 2006 [3]_.

    References
    ----------
    .. [1] A. Blaauw et al., "The new IAU system of galactic coordinates", Monthly Notices of the
       Royal Astronomical Society 121, 123, 1960; its pole in FK5 at J2000.
    .. [2] F. Mignard, M. Froeschlé, "Linking the FK5 to the ICRF", Astronomy and Astrophysics 354,
       732, 2000.
    .. [3] N. Capitaine, P. T. Wallace, J. Chapront, "Expressions for IAU 2000 precession
       quantities", Astronomy and Astrophysics 412, 567, 2003.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap import healpix
    >>> center = healpix.frame_rotation("galactic", "icrs") @ [1, 0, 0]
    >>> np.degrees(np.arctan2(center[1], center[0]) % (2 * np.pi)).round(4)
    np.float64(266.405)
    """
    return np.asarray(_from_icrs(dst, "dst") @ _from_icrs(src, "src").T)


def _about(axis: int, angle: float) -> Floats:
    """Return the matrix that gives coordinates in axes turned about one of them."""
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i] = matrix[j, j] = math.cos(angle)
    matrix[i, j], matrix[j, i] = math.sin(angle), -math.sin(angle)
    return matrix


def _from_icrs(frame: str, name: str) -> Floats:
    match as_text(frame, name):
        case "icrs":
            return np.eye(3)
        case "galactic":
            fk5 = _about(2, -22.9 * _MAS) @ _about(1, 9.1 * _MAS) @ _about(0, 19.9 * _MAS)
            pole = np.radians([192.8594812065348, 27.12825118085622])
            node = math.radians(122.9319185680026)
            turn = _about(2, math.pi - node) @ _about(1, math.pi / 2 - pole[1]) @ _about(2, pole[0])
            return np.asarray(turn @ fk5)
        case "ecliptic":
            bias = _about(0, 6.8192 * _MAS) @ _about(1, -16.617 * _MAS) @ _about(2, -14.6 * _MAS)
            return np.asarray(_about(0, math.radians(84381.406 / 3600)) @ bias)
    raise ValueError(f"`{name}` must be 'icrs', 'galactic' or 'ecliptic', got {frame!r:.40}.")
