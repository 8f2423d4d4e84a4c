"""The page as a widget: what is set here is seen there, and the other way round."""

from __future__ import annotations

from functools import cache
from typing import Any

from .._scalars import as_flag
from .look import CHECKS
from .page import source

__all__ = ["widget"]

# Settings that both sides change.
SHARED = tuple(CHECKS)


def widget(scene: dict[str, Any], look: dict[str, Any]) -> Any:
    """Return a widget of a scene, with a trait for each setting and one for what was picked."""
    return _made()(scene=scene, **look)


@cache
def _made() -> Any:
    """Return the class, whose libraries are imported when the first widget is made."""
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise ImportError(
            "widgets need anywidget: pip install spheremap[view]", name="anywidget"
        ) from None

    def checked(self: Any, proposal: dict[str, Any]) -> Any:
        name = proposal["trait"].name
        value = CHECKS[name](proposal["value"], name)
        return list(value) if isinstance(value, tuple) else value

    kinds: dict[str, Any] = {
        "direction": traitlets.List(traitlets.Float(), [0.0, 0.0, -1.0]),
        "curve": traitlets.Unicode("reinhard"),
        "fov": traitlets.Float(90.0),
    }
    members: dict[str, Any] = {
        "__doc__": "An image to look around in; see `Viewer.widget`.",
        "_esm": source("viewer.js"),
        "_css": source("viewer.css"),
        "_check": traitlets.validate(*SHARED)(checked),
        "scene": traitlets.Dict().tag(sync=True),
        "picked": traitlets.Dict().tag(sync=True),
    }
    for name in SHARED:
        kind = kinds.get(name)
        if kind is None:
            kind = traitlets.Bool(False) if CHECKS[name] is as_flag else traitlets.Float(0.0)
        members[name] = kind.tag(sync=True)
    return type("ViewerWidget", (anywidget.AnyWidget,), members)
