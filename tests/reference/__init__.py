"""What the library computes, once more: plainly, in long double where it matters, without it.

`maps` has the projections, and what is here; `area`, `atlas`, `light`, `packing` and `sampler` have
the rest.
"""

from .maps import (
    CREASES,
    CUBES,
    DEFAULT_AXES,
    DISKS,
    FACES,
    FORMULAS,
    LAYOUTS,
    POLES,
    ROOT_RIMS,
    STORED,
    TURNED,
    Reference,
    angle,
    axes_matrix,
    decode_cube,
    make,
    of,
    permute,
    smooth_function,
    stored,
    unit,
)

__all__ = [
    "CREASES",
    "CUBES",
    "DEFAULT_AXES",
    "DISKS",
    "FACES",
    "FORMULAS",
    "LAYOUTS",
    "POLES",
    "ROOT_RIMS",
    "STORED",
    "TURNED",
    "Reference",
    "angle",
    "axes_matrix",
    "decode_cube",
    "make",
    "of",
    "permute",
    "smooth_function",
    "stored",
    "unit",
]
