"""The page as a widget: what is set here is seen there, and the other way round."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from .._scalars import as_flag
from .answers import picked, sharper
from .look import CHECKS
from .page import source

if TYPE_CHECKING:
    from .viewing import Viewer

__all__ = ["widget"]

# Settings that both sides change.
SHARED = tuple(CHECKS)


def widget(viewer: Viewer) -> Any:
    """Return a widget of a viewer, with a trait for each setting and two for what was picked."""
    look = {name: getattr(viewer, name) for name in SHARED}
    look["direction"] = list(viewer.direction)
    made = _made()(scene=viewer._shown_in_widget(), **look)
    made._viewer = viewer
    made.on_msg(_answer)
    return made


def _show(self: Any, image: Any, projection: Any = None, **options: Any) -> None:
    """Put an image in the place of the first."""
    self._viewer._replace(image, projection, options)
    self.scene = self._viewer._shown_in_widget()


def _answer(self: Any, asked: Any, _: Any) -> None:
    """Do what the page asks for. It is none of ours what else is said on that way."""
    images = self._viewer._images
    kind = asked.get("kind") if isinstance(asked, dict) else None
    if kind == "see":
        for k in asked["images"]:
            screen = self._viewer._screen_named(asked["screen"])
            found = sharper(images[k], asked, screen) if 0 <= k < len(images) else None
            if found is not None:
                record, words = found
                self.send({"kind": "detail", "image": k, **record}, [words])
        # It may ask again.
        self.send({"kind": "seen"})
    elif kind == "pick" and 0 <= asked["image"] < len(images):
        here = picked(images[asked["image"]], images[0].projection, asked["direction"])
        setattr(self, "clicked" if asked.get("clicked") else "picked", here)


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
        "clicked": traitlets.Dict().tag(sync=True),
        "show": _show,
    }
    for name in SHARED:
        kind = kinds.get(name)
        if kind is None:
            kind = traitlets.Bool(False) if CHECKS[name] is as_flag else traitlets.Float(0.0)
        members[name] = kind.tag(sync=True)
    return type("ViewerWidget", (anywidget.AnyWidget,), members)
