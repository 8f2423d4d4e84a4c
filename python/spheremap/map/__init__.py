"""One map of the sphere: its verbs, its names, its texels."""

from .named import conventions, projection
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
    "encode",
    "explain",
    "jacobian",
    "projection",
    "projections",
    "reflect",
    "rotation",
    "solid_angle",
    "valid",
]
