"""Images in and out, textures for renderers, and the way from light to a picture on a screen.

`read`, `channel_names` and `write` need ``pip install spheremap[cli]``.
"""

from .images import channel_names, check_target, read, tonemap, write
from .textures import write_dds, write_ktx2

__all__ = [
    "channel_names",
    "check_target",
    "read",
    "tonemap",
    "write",
    "write_dds",
    "write_ktx2",
]


def __dir__() -> list[str]:
    return __all__
