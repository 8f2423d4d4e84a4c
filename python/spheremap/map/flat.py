"""Maps of several faces as one image."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from .named import projection, registered

if TYPE_CHECKING:
    from .._projection import Projection

__all__ = ["flat", "layouts", "legible"]

# Of the layouts that make one image, those a person sees most in; else it is the last one.
_LEGIBLE = ("cross", "strip")


@cache
def layouts(name: str) -> tuple[str, ...]:
    """Return the layouts of a projection that make one image of its faces."""
    (entry,) = (entry for entry in registered() if entry["name"] == name)
    return tuple(layout for layout in entry["layouts"] if layout != "faces")


def flat(name: str, layout: str | None = None) -> Projection:
    """Return the named projection as one image: a cube as a cross, two disks as a strip."""
    plain = projection(name, layout=layout)
    if plain.faces == 1:
        return plain
    if layout is not None:
        raise ValueError(
            f"a file holds one image: the layout is one of {', '.join(layouts(plain.name))}"
        )
    return projection(name, layout=legible(plain.name))


def legible(name: str) -> str:
    """Return the layout of a projection of several faces that people know best."""
    own = layouts(name)
    return next((layout for layout in _LEGIBLE if layout in own), own[-1])
