"""Which kinds an image might be instead of the one it is taken for.

An image's shape says how many faces it has and how wide it is for its height, and so do kinds.
Those that agree are candidates: a latlong might be a Mollweide map, a cube's faces equiangular.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..map.named import projection
from ..map.table import projections

if TYPE_CHECKING:
    from .._projection import Projection

__all__ = ["alike"]


def alike(p: Projection) -> list[Projection]:
    """Return the maps of other kinds, by their defaults, whose images have this one's shape."""
    found = []
    for name in projections():
        if name == p.name:
            continue
        try:
            q = projection(name, layout=p.layout, grid=p.grid, axes=p.axes, world=p.world)
        except ValueError:
            continue
        # Twice, for one size may fit by rounding.
        if q.faces == p.faces and all(q.shape(n) == p.shape(n) for n in (8, 30)):
            found.append(q)
    return found
