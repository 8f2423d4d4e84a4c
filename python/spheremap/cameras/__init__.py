"""Calibrated cameras in rigs, and the files of calibration programs."""

from .covering import rig
from .files import read, write
from .views import Rig, View

__all__ = ["Rig", "View", "read", "rig", "write"]


def __dir__() -> list[str]:
    return __all__
