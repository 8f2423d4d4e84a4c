"""Images in and out, textures for renderers, and the way from light to a picture on a screen.

What reads and writes images needs ``pip install spheremap[cli]``.
"""

from .color import from_linear, to_linear
from .header import Header, header
from .images import channel_names, check_target, read, write
from .large import convert_file
from .textures import write_dds, write_ktx2
from .tonemap import tonemap

__all__ = [
    "Header",
    "channel_names",
    "check_target",
    "convert_file",
    "from_linear",
    "header",
    "read",
    "to_linear",
    "tonemap",
    "write",
    "write_dds",
    "write_ktx2",
]


def __dir__() -> list[str]:
    return __all__
