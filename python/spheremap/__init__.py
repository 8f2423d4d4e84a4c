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
    mipmaps,
    projection,
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
from ._ball import (
    UnwrappedBall,
    render_ball,
    unwrap_ball,
)
from ._ball_find import (
    Ball,
    find_ball,
)
from ._ball_merge import (
    MergedBalls,
    merge_balls,
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
from ._matcap import (
    bake_matcap,
    shade_environment,
    shade_matcap,
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
from ._projections import (
    Projections,
    projections,
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
    "Ball",
    "Candidate",
    "Comparison",
    "Distribution",
    "Energy",
    "Identification",
    "Light",
    "Lights",
    "MergedBalls",
    "Packing",
    "Projection",
    "Projections",
    "RemapPlan",
    "Sun",
    "UnboundedPackingWarning",
    "UnwrappedBall",
    "__version__",
    "add_sun",
    "average_direction",
    "bake",
    "bake_matcap",
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
    "find_ball",
    "get_num_threads",
    "healpix",
    "identify",
    "integrate",
    "irradiance",
    "irradiance_at",
    "jacobian",
    "lights",
    "mean",
    "merge_balls",
    "mipmaps",
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
    "render_ball",
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
    "shade_environment",
    "shade_matcap",
    "simd_level",
    "solid_angle",
    "sun",
    "unpack",
    "unpack_frame",
    "unwrap_ball",
    "valid",
    "weights",
    "write_dds",
    "write_ktx2",
    "ws_psnr",
]
