"""What a caller is warned of: how far directions may be off, in degrees."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .camera import View

# Horizontal angles in degrees of long and wide lenses, 85 and 24 mm on 36.
_LONG, _WIDE = 24.0, 74.0


def warn_of_ideal_camera(ideal: View, stacklevel: int) -> None:
    """Warn that a camera is taken to be infinitely far away because nobody said where it was."""
    radius, width = ideal.outline.mean, ideal.size[1]
    least, most = (
        math.degrees(math.atan(2 * radius / width * math.tan(math.radians(fov) / 2)))
        for fov in (_LONG, _WIDE)
    )
    warnings.warn(
        "the camera is taken to be infinitely far away, as neither `fov` nor `distance` is given: "
        f"directions are off by up to asin(1/distance), {least:.0f}° if the photo spans "
        f"{_LONG:.0f}°, {most:.0f}° if {_WIDE:.0f}°. `distance` inf says that it is meant.",
        stacklevel=stacklevel + 1,
    )


def warn_of_unknown_distance(doubt: float) -> None:
    """Warn that photos do not tell how far the camera was; `doubt` is in radians."""
    off = f"{math.degrees(doubt):.0f}°" if math.isfinite(doubt) else "any angle"
    warnings.warn(
        "these photos do not tell how far the camera was: directions at the rim may be off by "
        f"{off}. Give `fov` or `distance`.",
        stacklevel=3,
    )
