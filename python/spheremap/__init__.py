"""Directions on the unit sphere to flat images and back, at memory speed.

>>> import spheremap as sm
>>> sm.encode([0.0, 0.0, 1.0], "octahedral").tolist()
[0.5, 0.5]
"""

from ._api import (
    Projection,
    __version__,
    conventions,
    convert,
    covers,
    decode,
    density,
    directions,
    encode,
    explain,
    get_num_threads,
    jacobian,
    projection,
    projections,
    reflect,
    rotation,
    sample,
    set_num_threads,
    simd_level,
    solid_angle,
    valid,
)
from ._distribution import Distribution
from ._energy import Energy, energy
from ._lights import Light, Lights, Sun, add_sun, lights, remove_sun, sun

__all__ = [
    "Distribution",
    "Energy",
    "Light",
    "Lights",
    "Projection",
    "Sun",
    "__version__",
    "add_sun",
    "conventions",
    "convert",
    "covers",
    "decode",
    "density",
    "directions",
    "encode",
    "energy",
    "explain",
    "get_num_threads",
    "jacobian",
    "lights",
    "projection",
    "projections",
    "reflect",
    "remove_sun",
    "rotation",
    "sample",
    "set_num_threads",
    "simd_level",
    "solid_angle",
    "sun",
    "valid",
]
