"""What is asked of a pyramid, checked: the same for images in memory and in files."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np

from .. import _core
from .._scalars import as_flag, as_number, as_text, as_whole
from ..io.opened import library as images
from ..io.tonemap import CURVES
from ..io.whole import as_path
from . import fits
from .colors import Look, light, without_alpha
from .cubes import marzipano, pannellum
from .folder import Folder, empty_folder
from .hips import FRAMES, hips
from .job import Job
from .panoramas import deepzoom, photo_sphere_viewer
from .pyramid import Pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import Worlds
    from .level import Image

__all__ = ["Extension", "Format", "Frame", "Kind", "as_tile_size", "written"]

Format: TypeAlias = Literal["pannellum", "marzipano", "photo-sphere-viewer", "deepzoom", "hips"]
Extension: TypeAlias = Literal["jpg", "png", "fits"]
Frame: TypeAlias = Literal["equatorial", "galactic", "ecliptic"]

_WRITERS: dict[str, Callable[[Job], Pyramid]] = {
    "pannellum": pannellum,
    "marzipano": marzipano,
    "photo-sphere-viewer": photo_sphere_viewer,
    "deepzoom": deepzoom,
    "hips": hips,
}
# Smaller ones are more files than anybody wants, and larger ones no graphics card takes.
_TILE_SIZES = (16, 8192)
_LARGEST = 1 << 29


@dataclass(frozen=True)
class Kind:
    """What tiles are for, of which files they are, what they look like, and the image's map."""

    format: str
    extension: str
    look: Look
    src: Projection

    @classmethod
    def of(
        cls, format: object, extension: object, curve: object, exposure: object, src: Projection
    ) -> Kind:
        """Return what is asked for, where it is there."""
        name = _word("format", format, list(_WRITERS))
        suffix = "jpg" if extension is None else extension
        suffix = _word("extension", suffix, list(get_args(Extension)))
        if suffix == "fits" and name != "hips":
            raise ValueError(f"`extension` 'fits' is of 'hips' alone, got {name!r}.")
        look = Look(_word("curve", curve, list(CURVES)), _finite(exposure, "exposure"))
        return cls(name, suffix, look, src)

    def taken(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """Return texels (..., C), each by itself, as they are converted."""
        pixels = without_alpha(pixels)
        if self.extension == "fits":
            if pixels.shape[-1] != 1:
                raise ValueError(f"FITS tiles hold one channel, `image` has {pixels.shape[-1]}.")
            # What float32 does not hold is infinite there.
            with np.errstate(over="ignore", invalid="ignore"):
                return pixels.astype(np.float32, copy=False)
        if pixels.dtype.kind == "f":
            return pixels
        if self.look != Look("none", 0.0):
            raise ValueError(f"`curve` and `exposure` are for floats, got {pixels.dtype}.")
        # Where nothing is known there is NaN, which is none of integers.
        has_missing = self.format == "hips" and self.src.coverage != "sphere"
        return light(pixels) if has_missing else pixels


def written(
    image: Image,
    kind: Kind,
    folder: str | os.PathLike[str],
    *,
    size: int | None,
    tile_size: int,
    quality: int,
    filter: ConvertFilter | str,
    world: Worlds,
    title: str | None,
    frame: str,
    properties: Mapping[str, str] | None,
    page: bool,
) -> Pyramid:
    """Write a pyramid of what was taken of an image; see `spheremap.tiles.write`."""
    frame, lines = _word("frame", frame, list(FRAMES)), _properties(properties)
    if kind.format != "hips" and (lines or frame != "equatorial"):
        name = "properties" if lines else "frame"
        raise ValueError(f"`{name}` is of 'hips' alone, got {kind.format!r}.")
    job = Job(
        image=image,
        src=kind.src,
        folder=Folder(Path(), _within(quality, "quality", 1, 100)),
        size=None if size is None else _within(size, "size", 1, _LARGEST),
        tile_size=as_tile_size(tile_size, kind.format),
        extension=kind.extension,
        look=kind.look,
        filter=filter,
        world=world,
        title=_line(_name(folder) if title is None else as_text(title, "title"), "title"),
        frame=frame,
        properties=lines,
        page=as_flag(page, "page"),
    )
    if job.extension == "fits":
        fits.library()
    images()
    return _WRITERS[kind.format](job.into(empty_folder(folder)))


def as_tile_size(value: object, format: str) -> int:
    """Return the side of a tile, where a format has such."""
    number = _within(value, "tile_size", *_TILE_SIZES)
    if format == "hips" and number & (number - 1):
        raise ValueError(f"`tile_size` of 'hips' must be a power of two, got {number}.")
    return number


def _word(name: str, value: object, known: list[str]) -> str:
    """Return one of the words that there are."""
    word = as_text(value, name)
    _core.check_word(name, word, known)
    return word


def _within(value: object, name: str, least: int, most: int) -> int:
    number = as_whole(value, name)
    if not least <= number <= most:
        raise ValueError(f"`{name}` must be in [{least}, {most}], got {number}.")
    return number


def _finite(value: object, name: str) -> float:
    number = as_number(value, name)
    if not math.isfinite(number):
        raise ValueError(f"`{name}` must be finite, got {number}.")
    return number


def _name(folder: object) -> str:
    # Of "." and "out/.." as well.
    return Path(os.path.realpath(as_path(folder))).name or "sky"


def _line(text: str, name: str) -> str:
    if any(c in "\r\n" or "\ud800" <= c <= "\udfff" for c in text):
        raise ValueError(f"Expected `{name}` to be a line of text, got {text!r:.80}.")
    return text


def _properties(given: object) -> dict[str, str]:
    """Return lines of a file of ``name = value``."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(f"Expected `properties` to be a mapping, got {type(given).__name__}.")
    out = {}
    for name, value in given.items():
        word = _line(as_text(name, "properties"), "properties")
        if not word or "=" in word or word.split() != [word] or word.startswith("#"):
            raise ValueError(f"`properties` has no name {word!r:.80}: it is one word without '='.")
        out[word] = _line(as_text(value, "properties"), "properties")
    return out
