"""Two maps or two images against each other: what differs, and which convention an image has."""

from .comparison import Comparison, compare
from .identification import Candidate, Identification, identify

__all__ = ["Candidate", "Comparison", "Identification", "compare", "identify"]


def __dir__() -> list[str]:
    return __all__
