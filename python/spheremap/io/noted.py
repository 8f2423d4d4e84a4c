"""What an image file may say of itself, checked before it is written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._scalars import as_text
from ..map.flat import layouts
from ..map.named import made, resolve
from .color import is_color_space

if TYPE_CHECKING:
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["as_noted", "expect_color_space"]

# Large enough that every aspect comes out whole.
_UNIT = 64


def as_noted(projection: ProjectionLike) -> str:
    """Return the name by which a file says how its image maps the sphere, or raise."""
    p = resolve(projection)
    if isinstance(projection, str):
        return projection
    parameters = ", ".join(f"{name}={value!r}" for name, value in p.parameters.items())
    convention = f":{p.convention}" if p.convention else ""
    for options in ("", f"({parameters})"):
        name = f"{p.name}{options}{convention}"
        if _means(name, p):
            return name
    raise ValueError(f"Expected `projection` to be a map that has a name, got {p!r}.")


def _means(name: str, p: Projection) -> bool:
    """Tell whether a reader of an image in `p` takes a name for it."""
    plain = resolve(name)
    if plain.layout != "faces" or p.layout == "faces":
        return plain == p
    # Of faces in one image it takes the first layout of the image's aspect.
    shape = p.shape(_UNIT)
    candidates = (made(name, layout=layout) for layout in layouts(p.name))
    return next(each for each in candidates if _takes(each, shape)) == p


def _takes(p: Projection, shape: tuple[int, ...]) -> bool:
    try:
        p.shape(shape)
    except ValueError:
        return False
    return True


def expect_color_space(name: object) -> None:
    """Raise for a color space that OpenImageIO does not know."""
    if not is_color_space(as_text(name, "color_space")):
        raise ValueError(
            f"unknown color space {name!r}; there are 'srgb_rec709_scene', 'lin_rec709_scene' and "
            "what else OpenImageIO's `ColorConfig` lists"
        )
