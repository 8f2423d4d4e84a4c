"""Colors that the page and stills share, of sRGB, from 0 to 1."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..light.image import REC709

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["MISSING", "OUTSIDE", "RAMP", "falsely", "ramped"]

# What holds no sphere, and NaN.
OUTSIDE = (0.5, 0.5, 0.5)
MISSING = (1.0, 0.0, 1.0)

# Luminance of -8 to 8 stops, one color a stop: Turbo, Mikhailov 2019, at sixteenths.
RAMP = (
    (0.190, 0.072, 0.232),
    (0.251, 0.252, 0.634),
    (0.276, 0.421, 0.891),
    (0.259, 0.580, 0.999),
    (0.158, 0.736, 0.923),
    (0.093, 0.866, 0.762),
    (0.197, 0.949, 0.595),
    (0.428, 0.994, 0.386),
    (0.644, 0.990, 0.234),
    (0.805, 0.925, 0.205),
    (0.933, 0.812, 0.227),
    (0.993, 0.674, 0.203),
    (0.984, 0.493, 0.128),
    (0.921, 0.315, 0.055),
    (0.816, 0.185, 0.018),
    (0.664, 0.084, 0.004),
    (0.480, 0.016, 0.011),
)
_STOPS = 8


def falsely(light: NDArray[np.float32], exposure: float) -> NDArray[np.uint8]:
    """Return the colors of luminance in stops of 1, at an exposure."""
    luminance = np.clip(np.nan_to_num(light, nan=0.0) @ np.array(REC709), 1e-12, 1e30)
    return np.asarray(np.rint(ramped(np.log2(luminance) + exposure) * 255), dtype=np.uint8)


def ramped(stops: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return the colors of stops; beyond its ends a ramp is its ends."""
    places = np.arange(-_STOPS, _STOPS + 1)
    colors = [np.interp(stops, places, channel) for channel in zip(*RAMP, strict=True)]
    return np.stack(colors, axis=-1)
