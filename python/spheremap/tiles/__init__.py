"""Pyramids of tiles, as viewers on the web load them: only what is seen, as sharp as it is seen.

What writes them needs ``pip install spheremap[cli]``; FITS tiles need ``spheremap[hips]``.
"""

from .large import write_file
from .pyramid import Pyramid
from .writing import write

__all__ = ["Pyramid", "write", "write_file"]


def __dir__() -> list[str]:
    return __all__
