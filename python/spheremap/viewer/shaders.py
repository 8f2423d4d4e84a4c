"""Maps as the page's shaders have them: printed, and no formula written by hand.

An image is looked up by `encode` of its own map; a screen, which is what the picture plane shows,
asks `decode` for the direction that a pixel sees. All are in one world, x right, y up, -z ahead.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any

from ..map.coding import code
from ..map.flat import flat
from ..map.named import registered, resolve
from .texels import own_faces

if TYPE_CHECKING:
    from .._projection import Projection

__all__ = ["LENSES", "detail", "globe", "image", "screen", "screens"]

_LANGUAGE = "glsl_es"
# Whose world all are printed in.
_HOME = "latlong"

# Screens whose field of view is the camera's, and the widest that is printed: a narrower one is a
# part of it. Beyond a disk `decode` goes on, so that a picture is filled to its corners.
LENSES = {"perspective": 172.0, "stereographic": 344.0}


def image(p: Projection) -> dict[str, Any]:
    """Return what looks an image up: `image_place` for texels, `own_place` for what a person reads.

    The two differ where faces lie in one image: texels are sent with their faces apart.
    """
    there = p.in_world_of(_HOME)
    apart = own_faces(there)
    return {
        # The name of a function has the number of the image, which the page gives.
        "lookup": code(apart, _LANGUAGE, verbs=["encode"], name="imageN"),
        "lookup_faces": apart.faces,
        "own": code(there, _LANGUAGE, verbs=["encode", "density"], name="own"),
        "own_faces": there.faces,
    }


def screen(p: Projection) -> dict[str, Any]:
    """Return what a screen is drawn by: `screen_decode`, `screen_valid`, `screen_encode`."""
    there = p.in_world_of(_HOME)
    rows, columns = there.shape(64)
    verbs = ["encode", "decode", "valid"]
    text = code(there, _LANGUAGE, verbs=verbs, name="screen")
    return {"text": text, "aspect": columns / rows, "edge": 0.0, "turns": 0.0}


@cache
def screens() -> dict[str, dict[str, Any]]:
    """Return the screens of every page: the two lenses, and each map in one image.

    Calibrated cameras are none: an image of one shows what it holds by its own.
    """
    found = {}
    for name, widest in LENSES.items():
        # The picture plane's half width at half the field of view: tan(fov/2), or tan(fov/4).
        turns = 2.0 if name == "perspective" else 4.0
        lens = screen(resolve(f"{name}(fov={widest:g})"))
        edge = math.tan(math.radians(widest) / turns)
        found[name] = lens | {"edge": edge, "turns": turns}
    for entry in registered():
        name = entry["name"]
        if name not in found and not name.startswith("camera_"):
            found[name] = screen(flat(name))
    return found


def detail() -> str:
    """Return `detail_encode`: the widest perspective, of which a sharper picture is a part."""
    lens = resolve(f"perspective(fov={LENSES['perspective']:g})").in_world_of(_HOME)
    return code(lens, _LANGUAGE, verbs=["encode"], name="detail")


def globe() -> str:
    """Return `globe_encode`: longitude and latitude, of which the graticule is made."""
    return code(_HOME, _LANGUAGE, verbs=["encode"], name="globe")
