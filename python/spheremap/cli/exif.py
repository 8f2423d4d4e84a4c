"""The angle of a photo, from what its camera wrote into the file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from spheremap.io.opened import library

# The diagonal of 36 x 24 mm, by which CIPA's guideline DCG-001 defines equivalent focal lengths.
_DIAGONAL = math.hypot(36, 24)
# Exif's units of a sensor's resolution, in mm.
_UNITS = {2: 25.4, 3: 10.0, 4: 1.0, 5: 1e-3}


def fov(path: Path) -> float | None:
    """Return the horizontal angle in degrees; None if the file does not say.

    It says nothing of a picture that was cropped: its sides are not in the proportion of Exif's.
    """
    file = library().ImageInput.open(str(path))
    if file is None:
        return None
    try:
        return _fov(file.spec())
    finally:
        file.close()


def _fov(spec: Any) -> float | None:
    def number(name: str) -> float:
        value = spec.getattribute(f"Exif:{name}")
        known = isinstance(value, (int, float)) and math.isfinite(value) and value > 0
        return float(value) if known else 0.0

    width, height = spec.width, spec.height
    across, down = number("PixelXDimension"), number("PixelYDimension")
    if across and down and abs(width * down - height * across) > width * down * 0.01:
        return None
    equivalent, length = number("FocalLengthIn35mmFilm"), number("FocalLength")
    resolution = number("FocalPlaneXResolution")
    unit = _UNITS.get(int(number("FocalPlaneResolutionUnit")) or 2)
    if equivalent:
        focal = equivalent / _DIAGONAL * math.hypot(width, height)
    elif length and resolution and unit and across:
        focal = length * resolution / unit * width / across
    else:
        return None
    return math.degrees(2 * math.atan(width / 2 / focal))
