"""Pages to look around in images, which `spheremap.view` makes."""

from .viewing import Viewer, view

__all__ = ["Viewer", "view"]


def __dir__() -> list[str]:
    return __all__
