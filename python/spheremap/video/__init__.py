"""Videos from one map to another, by PyAV: ``pip install spheremap[video]``."""

from .keyframes import Keyframes, read_keyframes
from .metadata import projection
from .verbs import Converted, convert

__all__ = ["Converted", "Keyframes", "convert", "projection", "read_keyframes"]


def __dir__() -> list[str]:
    return __all__
