"""How to turn a panorama so that a direction comes to its center."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

import spheremap as sm
from spheremap.map.variants import axes_matrix

if TYPE_CHECKING:
    from numpy.typing import NDArray


def azimuth_elevation(
    direction: NDArray[np.float64], projection: sm.Projection
) -> tuple[float, float]:
    """Return degrees to the right of what is ahead in the map's world, and above the horizon."""
    azimuth, elevation = sm.directions_to_lonlat(direction, world=projection.world)
    return float(azimuth), float(elevation)


def angles(
    direction: NDArray[np.float64], src: sm.Projection, dst: sm.Projection
) -> tuple[float, float, float]:
    """Return yaw, pitch and roll, as `rotation` takes them, that bring a direction to the center.

    The shortest way there: first about the vertical of the world of `src`, then up or down.
    """
    center = _center(dst.in_world_of(src))
    person = axes_matrix(src.world)
    level = _turn(*azimuth_elevation(direction, src)).T
    there = _turn(*azimuth_elevation(center, src))
    matrix = person.T @ there @ level @ person
    # matrix = Ry(yaw) Rx(pitch) Rz(roll), written out.
    pitch = np.arcsin(np.clip(-matrix[1, 2], -1, 1))
    yaw = np.arctan2(matrix[0, 2], matrix[2, 2])
    roll = np.arctan2(matrix[1, 0], matrix[1, 1])
    return tuple(float(x) + 0.0 for x in np.degrees([yaw, pitch, roll]))  # type: ignore[return-value]


def _turn(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """Return what takes ahead to a direction; of a person's right, up and ahead."""
    (c, s), (d, t) = ((np.cos(a), np.sin(a)) for a in np.radians([azimuth, elevation]))
    lifted = np.array([[1, 0, 0], [0, d, t], [0, -t, d]])
    return np.asarray(np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ lifted)


def _center(projection: sm.Projection) -> NDArray[np.float64]:
    """Return the direction at the center of an image, of a cube what is ahead."""
    ahead: NDArray[np.float64] = axes_matrix(projection.world)[2]
    if projection.faces > 1 or projection.layout:
        return ahead
    found = np.asarray(projection.decode(np.array([0.5, 0.5])), np.float64)
    return found if np.isfinite(found).all() else ahead
