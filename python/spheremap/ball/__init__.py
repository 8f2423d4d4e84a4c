"""Photos of mirrored balls: where the ball is, what it saw, several photos as one, and back.

`find` needs ``pip install spheremap[ball]``.
"""

from .finding import Ball, find
from .merging import MergedBalls, merge
from .rendering import render
from .unwrapping import UnwrappedBall, unwrap

__all__ = [
    "Ball",
    "MergedBalls",
    "UnwrappedBall",
    "find",
    "merge",
    "render",
    "unwrap",
]


def __dir__() -> list[str]:
    return __all__
