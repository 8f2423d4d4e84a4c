"""One map of the sphere: its verbs, its names, its texels."""

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
    "conventions",
    "covers",
    "decode",
    "density",
    "directions",
    "directions_to_pixels",
    "encode",
    "explain",
    "jacobian",
    "pixels_to_directions",
    "projection",
    "projections",
    "reflect",
    "rotation",
    "solid_angle",
    "valid",
]
