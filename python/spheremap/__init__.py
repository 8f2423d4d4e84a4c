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
from ._depth import convert_depth
from ._pad import pad
from ._plans import RemapPlan, remap_plan
from ._views import embed

__all__ = [
    "Projection",
    "RemapPlan",
    "__version__",
    "conventions",
    "convert",
    "convert_depth",
    "covers",
    "decode",
    "density",
    "directions",
    "embed",
    "encode",
    "explain",
    "get_num_threads",
    "jacobian",
    "pad",
    "projection",
    "projections",
    "reflect",
    "remap_plan",
    "rotation",
    "sample",
    "set_num_threads",
    "simd_level",
    "solid_angle",
    "valid",
]
