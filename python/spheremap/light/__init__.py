"""Images as light: sums, irradiance, prefiltering, lights, sampling and shading.

>>> import numpy as np, spheremap as sm
>>> bool(np.isclose(sm.light.integrate(np.ones((64, 128)), "latlong"), 4 * np.pi))
True
"""

from .baking import Bake, bake
from .distribution import Distribution
from .files import energy_file
from .lobes import convolve, irradiance, irradiance_at
from .report import Energy, energy
from .shading import bake_matcap, shade_environment, shade_matcap
from .sources import Light, Lights, Sun, add_sun, lights, remove_sun, sun
from .specular import dfg, prefilter, prefilter_chain
from .sums import average_direction, integrate, mean, weights, ws_psnr

__all__ = [
    "Bake",
    "Distribution",
    "Energy",
    "Light",
    "Lights",
    "Sun",
    "add_sun",
    "average_direction",
    "bake",
    "bake_matcap",
    "convolve",
    "dfg",
    "energy",
    "energy_file",
    "integrate",
    "irradiance",
    "irradiance_at",
    "lights",
    "mean",
    "prefilter",
    "prefilter_chain",
    "remove_sun",
    "shade_environment",
    "shade_matcap",
    "sun",
    "weights",
    "ws_psnr",
]


def __dir__() -> list[str]:
    return __all__
