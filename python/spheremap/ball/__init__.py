"""Photos of mirrored balls: where the ball is, what it saw, several photos as one, and back.

`find` needs ``pip install spheremap[ball]``.
"""

from .finding import Ball, find_ball
from .merging import MergedBalls, merge_balls
from .rendering import render_ball
from .unwrapping import UnwrappedBall, unwrap_ball

__all__ = [
    "Ball",
    "MergedBalls",
    "UnwrappedBall",
    "find_ball",
    "merge_balls",
    "render_ball",
    "unwrap_ball",
]


def __dir__() -> list[str]:
    return __all__
