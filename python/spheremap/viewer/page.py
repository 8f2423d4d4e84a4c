"""The page: one file that holds the program, the maps, and the images."""

from __future__ import annotations

import html
import json
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from ..io.tonemap import CURVES, WHITE
from . import shaders
from .colors import MISSING, OUTSIDE, RAMP
from .look import TISSOT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["iframe", "page", "scene"]

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>
html, body {{ height: 100%; margin: 0; }}
{css}</style>
</head>
<body>
<main id="view"></main>
<script id="scene" type="application/json">{scene}</script>
<script type="module" async>
{js}
const read = (name) => JSON.parse(document.getElementById(name).textContent);
const view = mount(document.getElementById("view"), read("scene"));
// What comes after this script is read while a first picture is seen.
const loaded = new Promise((done) => {{
    if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", done);
    else done();
}});
const whole = Promise.all([view.ready, loaded]).then(() => {{
    const images = read("whole");
    return images && view.swap({{ images }});
}});
window.spheremap = {{ ...view, first: view.ready, ready: whole }};
// A page of its own listens to keys at once; a frame in a notebook would take them from the reader.
if (window.parent === window) document.querySelector("#view canvas").focus();
</script>
<script id="whole" type="application/json">{whole}</script>
</body>
</html>
"""


@cache
def source(name: str) -> str:
    """Return a file of the page as text."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def scene(
    title: str,
    look: dict[str, Any],
    images: Sequence[dict[str, Any]],
    screens: dict[str, dict[str, Any]],
    world: NDArray[Any],
    overlays: dict[str, Any],
) -> dict[str, Any]:
    """Return what `mount` takes: `world` takes the page's directions to the reader's."""
    return {
        "title": title,
        "look": look,
        "images": images,
        "screens": screens,
        "world": world.tolist(),
        **overlays,
        "tissot": TISSOT,
        "globe": shaders.globe(),
        # Printed for those who can ask for sharper pictures: widgets.
        "detail": "",
        "body": source("viewer.glsl"),
        "curves": CURVES,
        "white": WHITE,
        "ramp": RAMP,
        "outside": OUTSIDE,
        "missing": MISSING,
    }


def page(made: dict[str, Any], whole: Sequence[dict[str, Any]] | None = None) -> str:
    """Return a scene as HTML that is complete in itself.

    `whole` are images that take the place of the scene's when they are read, which takes a while.
    """
    return _PAGE.format(
        title=html.escape(made["title"]),
        css=source("viewer.css"),
        scene=_data(made),
        js=source("viewer.js"),
        whole=_data(whole),
    )


def _data(value: Any) -> str:
    # A closing tag in a string would end the script.
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def iframe(text: str) -> str:
    """Return a page as a frame of a notebook's output."""
    return (
        f'<iframe srcdoc="{html.escape(text)}" title="spheremap" allow="fullscreen" '
        'style="width:100%;height:520px;border:0"></iframe>'
    )
