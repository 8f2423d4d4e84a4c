"""Image files, opened by OpenImageIO: which part, and what is none of its images."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from .whole import as_path

__all__ = [
    "TEXTURES",
    "expect_complete",
    "expect_whole_room",
    "library",
    "one_line",
    "opened",
    "part_names",
    "said_by",
]

# What `write_ktx2` and `write_dds` write.
TEXTURES = (".ktx2", ".dds")


def library() -> Any:
    """Return OpenImageIO, or raise what says how to install it."""
    try:
        import OpenImageIO
    except ImportError:
        raise ImportError(
            "images need OpenImageIO: pip install spheremap[cli]", name="OpenImageIO"
        ) from None
    _most()
    return OpenImageIO


@cache
def _most() -> int:
    """Return the bytes of an image that OpenImageIO would open, and let it open any.

    By itself it opens none that is larger than the machine's memory, not even to read a tile.
    """
    import OpenImageIO as oiio

    megabytes: int = oiio.get_int_attribute("limits:imagesize_MB", 0)
    oiio.attribute("limits:imagesize_MB", 0)
    return megabytes << 20


def expect_whole_room(spec: Any, name: str) -> None:
    """Raise where an image is too large to be read as a whole."""
    length = spec.image_bytes(True)
    if 0 < _most() < length:
        raise OSError(
            f"cannot read {name!r}: its texels take {length / 1e9:.1f} GB, more than the "
            f"{_most() / 1e9:.1f} that there may be at once; io.convert_file, and `spheremap "
            "convert --memory`, read part by part"
        )


def expect_complete(handle: Any, name: str) -> None:
    """Raise where a reader filled up what an image lacks: of a .jpg it only warns."""
    said = handle.geterror()
    if "premature end" in said.lower():
        # Its name follows.
        raise OSError(f"cannot read {name!r}: {one_line(said.partition(' (')[0])}")


@contextmanager
def opened(path: str | os.PathLike[str], part: int | str | None = None) -> Iterator[Any]:
    """Open an image file at one of its parts, and close it in the end."""
    oiio = library()
    name = as_path(path)
    if not os.path.exists(name):
        raise FileNotFoundError(f"no such file: {name!r}")
    if os.path.isdir(name):
        raise IsADirectoryError(f"cannot read {name!r}: it is a folder")
    # Multiplying alpha in would lose the color of transparent texels.
    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(name, wish)
    if source is None:
        said = one_line(oiio.geterror())
        if os.path.splitext(name)[1].lower() in TEXTURES:
            said = f"textures are written and not read ({said})"
        raise OSError(f"cannot read {name!r}: {said}")
    try:
        _seek(source, name, part)
        if source.spec().deep:
            raise OSError(
                f"cannot read {name!r}: it holds samples of several depths; "
                "flatten it first, as by oiiotool --flatten"
            )
        yield source
    finally:
        source.close()


def part_names(source: Any) -> tuple[str, ...]:
    """Return the names of the images of an open file, or their numbers."""
    here = source.current_subimage()
    names: list[str] = []
    while source.seek_subimage(len(names), 0):
        spec = source.spec()
        names.append(
            spec.get_string_attribute("oiio:subimagename")
            or spec.get_string_attribute("name")
            or str(len(names))
        )
    source.geterror()
    source.seek_subimage(here, 0)
    return tuple(names)


def _seek(source: Any, name: str, part: int | str | None) -> None:
    names = part_names(source)
    if part is None and len(names) == 1:
        return
    listed = ", ".join(f"{k} ({word})" if word != str(k) else word for k, word in enumerate(names))
    if part is None:
        raise ValueError(f"{name!r} has {len(names)} parts: {listed}; say which `part` to read")
    is_name = isinstance(part, str) and part in names
    number = names.index(part) if is_name else _number(part)
    if not 0 <= number < len(names):
        raise ValueError(f"{name!r} has no part {part!r}; it has {listed}")
    source.seek_subimage(number, 0)


def _number(part: int | str) -> int:
    try:
        return int(part)
    except (TypeError, ValueError):
        return -1


def said_by(handle: Any) -> str:
    """Return why a reader or a writer failed."""
    return one_line(handle.geterror() or library().geterror())


def one_line(text: str) -> str:
    """Return a message of a library as one line."""
    return " ".join(text.split()) or "unknown error"
