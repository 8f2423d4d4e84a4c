"""A scene that looks different from everywhere."""

from __future__ import annotations

import numpy as np
import reference

# Direction, sharpness and brightness of lamps that no turn or mirror exchanges.
LAMPS = [
    ((1, 0.2, 0.3), 60, 20_000.0),
    ((-0.4, 0.5, 1), 12, 8.0),
    ((0.2, -0.7, -1), 25, 30.0),
    ((-1, 0.3, -0.5), 6, 3.0),
    ((0.1, 1, 0.4), 30, 60.0),
    ((0.5, -0.4, 0.8), 16, 5.0),
]


def scene(d: np.ndarray) -> np.ndarray:
    """Colored lamps over a gradient: high dynamic range, and nothing sharper than 10°."""
    d = np.nan_to_num(d, nan=0.5)
    value = reference.smooth_function(d)
    for k, (toward, sharpness, power) in enumerate(LAMPS):
        lamp = np.exp(sharpness * (reference.unit(d) @ reference.unit(toward) - 1))
        value = value + power * lamp[..., None] * np.roll([1, 0.7, 0.4], k)
    return value.astype(np.float32)
