"""One image into another: conversions, lookups, mipmaps, borders, views and plans."""

from .depth import convert_depth
from .matrix import weights_matrix
from .padding import pad
from .pictures import sample_uv
from .plans import RemapPlan, remap_plan
from .points import depth_to_points, points_to_depth
from .verbs import convert, mipmaps, sample
from .views import embed

__all__ = [
    "RemapPlan",
    "convert",
    "convert_depth",
    "depth_to_points",
    "embed",
    "mipmaps",
    "pad",
    "points_to_depth",
    "remap_plan",
    "sample",
    "sample_uv",
    "weights_matrix",
]
