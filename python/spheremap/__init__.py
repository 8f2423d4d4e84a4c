"""Directions on the unit sphere to flat images and back, at memory speed.

>>> import spheremap as sm
>>> sm.encode([0.0, 0.0, 1.0], "octahedral").tolist()
[0.5, 0.5]
"""

from . import healpix
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
from ._bake import (
    Bake,
    bake,
)
from ._compare import (
    Comparison,
    compare,
)
from ._depth import (
    convert_depth,
)
from ._distribution import (
    Distribution,
)
from ._energy import (
    Energy,
    energy,
)
from ._identify import (
    Candidate,
    Identification,
    identify,
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
from ._lights import (
    Light,
    Lights,
    Sun,
    add_sun,
    lights,
    remove_sun,
    sun,
)
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
from ._pad import (
    pad,
)
from ._plans import (
    RemapPlan,
    remap_plan,
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
from ._views import (
    embed,
)

__all__ = [
    "Bake",
    "Candidate",
    "Comparison",
    "Distribution",
    "Energy",
    "Identification",
    "Light",
    "Lights",
    "Packing",
    "Projection",
    "RemapPlan",
    "Sun",
    "UnboundedPackingWarning",
    "__version__",
    "add_sun",
    "average_direction",
    "bake",
    "best_packing",
    "canonical",
    "compare",
    "conventions",
    "convert",
    "convert_depth",
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
    "healpix",
    "identify",
    "integrate",
    "irradiance",
    "irradiance_at",
    "jacobian",
    "lights",
    "mean",
    "pack",
    "pack_frame",
    "packing",
    "packings",
    "pad",
    "prefilter",
    "prefilter_chain",
    "projection",
    "projections",
    "reflect",
    "remap_plan",
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
