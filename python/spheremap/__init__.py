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
from ._compare import Comparison, compare
from ._identify import Candidate, Identification, identify
from ._depth import convert_depth
from ._pad import pad
from ._plans import RemapPlan, remap_plan
from ._views import embed

__all__ = [
    "Candidate",
    "Comparison",
    "Identification",
from ._bake import (
    Bake,
    bake,
)
from ._light import (
    average_direction,
    convolve,
    integrate,
    irradiance,
    irradiance_at,
    mean,
    weights,
    ws_psnr,
)
from ._prefilter import (
    dfg,
    prefilter,
    prefilter_chain,
)
from ._sh import (
    sh_conventions,
    sh_convert,
    sh_convolve,
    sh_evaluate,
    sh_lobe,
    sh_project,
    sh_rotate,
    sh_window,
)
from ._textures import (
    write_dds,
    write_ktx2,
)

__all__ = [
    "Bake",
    "Projection",
    "RemapPlan",
    "__version__",
    "compare",
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
    "convert_depth",
    "average_direction",
    "bake",
from ._packing import (
    Packing,
    UnboundedPackingWarning,
    best_packing,
    canonical,
    pack,
    pack_frame,
    packing,
    packings,
    unpack,
    unpack_frame,
)

__all__ = [
    "Packing",
    "Projection",
    "UnboundedPackingWarning",
    "__version__",
    "best_packing",
    "canonical",
    "conventions",
    "convert",
    "convolve",
    "covers",
    "decode",
    "density",
    "dfg",
    "directions",
    "embed",
    "encode",
    "energy",
    "explain",
    "get_num_threads",
    "identify",
    "jacobian",
    "pad",
    "projection",
    "projections",
    "reflect",
    "remap_plan",
    "lights",
    "integrate",
    "irradiance",
    "irradiance_at",
    "jacobian",
    "mean",
    "prefilter",
    "prefilter_chain",
    "pack",
    "pack_frame",
    "packing",
    "packings",
    "projection",
    "projections",
    "reflect",
    "remove_sun",
    "rotation",
    "sample",
    "set_num_threads",
    "sh_conventions",
    "sh_convert",
    "sh_convolve",
    "sh_evaluate",
    "sh_lobe",
    "sh_project",
    "sh_rotate",
    "sh_window",
    "simd_level",
    "solid_angle",
    "sun",
    "unpack",
    "unpack_frame",
    "valid",
    "weights",
    "write_dds",
    "write_ktx2",
    "ws_psnr",
]
