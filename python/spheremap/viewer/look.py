"""How an image is looked at: what a person can set, checked."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import _core
from .._arrays import as_doubles
from .._scalars import as_flag, as_number, as_text
from ..io.tonemap import CURVES

__all__ = ["CHECKS", "FOV", "TISSOT", "as_direction", "as_side", "yaw_and_pitch"]

# Degrees across; beyond the widest perspective it is a little planet.
FOV = (15.0, 340.0)
_STOPS = 126.0
# Degrees: radius of the circles, and between their centers.
TISSOT = (5.0, 30.0)
# Sides of pictures and images, in texels.
_SIDES = (2, 16384)


def as_direction(value: object, name: str = "direction") -> tuple[float, float, float]:
    """Return a direction of unit length."""
    found = as_doubles(value, name)
    if found.shape != (3,):
        raise ValueError(f"Expected `{name}` to have shape (3,), got {found.shape}.")
    largest = float(np.abs(found).max())
    if not 0 < largest < math.inf:
        raise ValueError(f"Expected `{name}` to be a direction, got {found.tolist()}.")
    scaled = found / largest
    x, y, z = (scaled / np.linalg.norm(scaled)).tolist()
    return x, y, z


def as_side(value: int, name: str) -> int:
    """Return a number of texels."""
    low, high = _SIDES
    if not low <= value <= high:
        raise ValueError(f"Expected `{name}` to be from {low} to {high}, got {value}.")
    return value


def yaw_and_pitch(ahead: Any) -> tuple[float, float]:
    """Return the angles, in degrees, of the camera that looks along a direction of the page."""
    x, y, z = (float(c) for c in ahead)
    level = math.hypot(x, z)
    # Straight up there is no yaw.
    yaw = math.degrees(math.atan2(-x, -z)) if level > 1e-12 else 0.0
    return yaw, math.degrees(math.atan2(y, level))


def _within(low: float, high: float) -> Callable[[object, str], float]:
    def check(value: object, name: str) -> float:
        number = as_number(value, name)
        if not low <= number <= high:
            raise ValueError(f"Expected `{name}` to be from {low:g} to {high:g}, got {number:g}.")
        return number

    return check


def _curve(value: object, name: str) -> str:
    curve = as_text(value, name)
    _core.check_word(name, curve, list(CURVES))
    return curve


# What makes a value of each setting, or raises.
CHECKS: dict[str, Callable[[object, str], Any]] = {
    "direction": as_direction,
    "fov": _within(*FOV),
    "exposure": _within(-_STOPS, _STOPS),
    "curve": _curve,
    "false_color": as_flag,
    "isolines": as_flag,
    "clipping": as_flag,
    "graticule": _within(0.0, 90.0),
    "axes": as_flag,
    "valid": as_flag,
    "density": as_flag,
    "tissot": as_flag,
    "seams": as_flag,
}
