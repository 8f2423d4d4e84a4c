"""Calibrated cameras in rigs, and the files of calibration programs."""

from .covering import rig
from .exposure import gains
from .files import read, write
from .lenses import back_to_back
from .masking import masks
from .stitching import stitch
from .tracks import gopro
from .views import Rig, View

__all__ = [
    "Rig",
    "View",
    "back_to_back",
    "gains",
    "gopro",
    "masks",
    "read",
    "rig",
    "stitch",
    "write",
]


def __dir__() -> list[str]:
    return __all__
