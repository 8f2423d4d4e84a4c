"""Directions on the unit sphere to flat images and back, at memory speed.

>>> import spheremap as sm
>>> sm.encode([0.0, 0.0, 1.0], "octahedral").tolist()
[0.5, 0.5]

The verbs of maps and images are here. What belongs to a subject is in the subject's own module,
which is imported when it is first used: `light`, `sh`, `packing`, `healpix`, `ball`, `cameras`,
`align`, `tiles`, `io`, `plot` and `video`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._core import __version__
from ._projection import Projection
from ._threads import get_num_threads, set_num_threads, simd_level
from .map import (
    Projections,
    camera,
    code,
    conventions,
    covers,
    decode,
    density,
    directions,
    directions_to_lonlat,
    directions_to_pixels,
    effect,
    encode,
    explain,
    jacobian,
    lonlat_to_directions,
    pixels_to_directions,
    projection,
    projections,
    reflect,
    rotation,
    solid_angle,
    valid,
)
from .map.named import use_class
from .resample import (
    RemapPlan,
    convert,
    convert_depth,
    depth_to_points,
    embed,
    mipmaps,
    pad,
    points_to_depth,
    remap_plan,
    sample,
    sample_uv,
    weights_matrix,
)

use_class(Projection)

if TYPE_CHECKING:
    from . import align, ball, cameras, healpix, io, light, packing, plot, sh, tiles, video
    from .viewer import view

__all__ = [
    "Projection",
    "Projections",
    "RemapPlan",
    "__version__",
    "align",
    "ball",
    "camera",
    "cameras",
    "code",
    "conventions",
    "convert",
    "convert_depth",
    "covers",
    "decode",
    "density",
    "depth_to_points",
    "directions",
    "directions_to_lonlat",
    "directions_to_pixels",
    "effect",
    "embed",
    "encode",
    "explain",
    "get_num_threads",
    "healpix",
    "io",
    "jacobian",
    "light",
    "lonlat_to_directions",
    "mipmaps",
    "packing",
    "pad",
    "pixels_to_directions",
    "plot",
    "points_to_depth",
    "projection",
    "projections",
    "reflect",
    "remap_plan",
    "rotation",
    "sample",
    "sample_uv",
    "set_num_threads",
    "sh",
    "simd_level",
    "solid_angle",
    "tiles",
    "valid",
    "video",
    "view",
    "weights_matrix",
]

_SUBJECTS = frozenset(
    {
        "align",
        "ball",
        "cameras",
        "healpix",
        "io",
        "light",
        "packing",
        "plot",
        "sh",
        "tiles",
        "video",
    }
)

# Hidden from type checkers, which would take every misspelled name for one that it returns.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name in _SUBJECTS:
            return import_module(f".{name}", __name__)
        if name == "view":
            # With its page, which nobody needs who computes.
            return import_module(".viewer", __name__).view
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
