"""One map of the sphere: its verbs, its names, its texels."""

from .cameras import camera
from .coding import code
from .effects import effect
from .lonlat import directions_to_lonlat, lonlat_to_directions
from .named import conventions, projection
from .pixels import directions_to_pixels, pixels_to_directions
from .table import Projections, projections
from .verbs import (
    covers,
    decode,
    density,
    directions,
    encode,
    explain,
    jacobian,
    reflect,
    rotation,
    solid_angle,
    valid,
)

__all__ = [
    "Projections",
    "camera",
    "code",
    "conventions",
    "covers",
    "decode",
    "density",
    "directions",
    "directions_to_lonlat",
    "directions_to_pixels",
    "effect",
    "encode",
    "explain",
    "jacobian",
    "lonlat_to_directions",
    "pixels_to_directions",
    "projection",
    "projections",
    "reflect",
    "rotation",
    "solid_angle",
    "valid",
]
