"""One image into another: conversions, lookups, mipmaps, borders, views and plans."""

from .depth import convert_depth
from .padding import pad
from .pictures import sample_uv
from .plans import RemapPlan, remap_plan
from .verbs import convert, mipmaps, sample
from .views import embed

__all__ = [
    "RemapPlan",
    "convert",
    "convert_depth",
    "embed",
    "mipmaps",
    "pad",
    "remap_plan",
    "sample",
    "sample_uv",
]
