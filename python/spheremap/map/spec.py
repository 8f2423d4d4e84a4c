"""Maps as text: what compilers of graphs take for a constant, and caches for a key."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from .. import _core
from .named import resolve

if TYPE_CHECKING:
    from .._projection import Projection
    from .named import ProjectionLike

# So many maps, or what is prepared for images of a map and a shape, are held at a time.
HELD = 128


def spec_of(
    projection: ProjectionLike, axes: str | None = None, rotation: Any | None = None
) -> str:
    """Return the text that stands for a map; a name stands for itself."""
    p = resolve(projection, axes, rotation)
    if isinstance(projection, str) and axes is None and rotation is None:
        return projection
    _, (_, name, options) = p.__reduce__()
    return json.dumps([name, options])


@lru_cache(HELD)
def map_of(spec: str) -> Projection:
    """Return the map that a text stands for."""
    if not spec.startswith("["):
        return resolve(spec)
    name, options = json.loads(spec)
    made: Projection = _core._rebuild(type(resolve("latlong")), name, options)
    return made
