"""Pictures of projections, images and light, by matplotlib: `pip install spheremap[plot]`.

A function of one picture draws into `ax`, or into new axes of pyplot, and returns the axes; one of
several draws into `figure`, or into a new one, and returns a list of axes.
"""

from .codes import packing_error
from .comparison import compare
from .distortion import density_map, tissot
from .footprint import footprints
from .harmonics import sh
from .image import show
from .levels import chain
from .sources import lights

__all__ = [
    "chain",
    "compare",
    "density_map",
    "footprints",
    "lights",
    "packing_error",
    "sh",
    "show",
    "tissot",
]


def __dir__() -> list[str]:
    return __all__
