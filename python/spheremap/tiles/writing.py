"""`write`, and what it asks of its arguments."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np

from .. import _core
from .._arrays import as_image, spatial_axes, spatial_shape
from .._scalars import as_flag, as_number, as_text, as_whole
from ..io.opened import library as images
from ..io.tonemap import CURVES, Curve
from ..io.whole import as_path
from ..map.images import channels_last, expect_aspect
from ..map.named import resolve
from . import fits
from .colors import Look, light, without_alpha
from .cubes import marzipano, pannellum
from .folder import Folder, empty_folder
from .hips import FRAMES, hips
from .job import Job
from .panoramas import deepzoom, photo_sphere_viewer
from .pyramid import Pyramid

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["Extension", "Format", "Frame", "write"]

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


def write(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    folder: str | os.PathLike[str],
    *,
    format: Format | str,
    size: int | None = None,
    tile_size: int = 512,
    extension: Extension | str | None = None,
    quality: int = 90,
    filter: ConvertFilter | str = "bilinear",
    rotation: Any | None = None,
    world: Worlds = "match",
    curve: Curve | str = "none",
    exposure: float = 0.0,
    title: str | None = None,
    frame: Frame | str = "equatorial",
    properties: Mapping[str, str] | None = None,
    page: bool = True,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> Pyramid:
    """Write an image as a pyramid of tiles for a viewer on the web.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Floats are linear light; uint8 and uint16 are pictures of sRGB. Of two channels the first is
        written, of more than three the first three.
    projection : Projection or str
        How the image maps the sphere.
    folder : path
        Where the files go: a new folder, or an empty one.
    format : {"pannellum", "marzipano", "photo-sphere-viewer", "deepzoom", "hips"}
        What the tiles are for. ``"pannellum"`` and ``"marzipano"`` are cubes,
        ``"photo-sphere-viewer"`` and ``"deepzoom"`` panoramas of longitude and latitude, and
        ``"hips"`` is HEALPix, as sky surveys are published.
    size : int, optional
        Of the largest level: the side of a face, or the height of a panorama. By default that at
        which nothing of the image is lost. It is rounded up to what the format can have: by a few
        texels, and with ``"hips"`` to a power of two times `tile_size`.
    tile_size : int
        The side of a tile, from 16 to 8192, for ``"hips"`` a power of two. ``"marzipano"`` and
        ``"photo-sphere-viewer"`` have tiles of equal size, which may be smaller.
    extension : {"jpg", "png", "fits"}, optional
        Of the tiles: ``"jpg"`` by default. ``"fits"`` is of ``"hips"`` with one channel, and keeps
        the numbers as float32.
    quality : int
        Of .jpg, from 1 to 100.
    filter, rotation, world
        As for `convert`, which makes the largest level.
    curve : {"none", "reinhard"}
        How light becomes 8 bits, as in `spheremap.io.tonemap`: ``"none"`` cuts it at 1.
    exposure : float
        In stops. Of floats, as is `curve`.
    title : str, optional
        What the image is called; the folder's name where nothing is said.
    frame : {"equatorial", "galactic", "ecliptic"}
        Of ``"hips"``: the frame of the sky in which the image's directions are, +z its north pole
        and +x longitude 0, as ``"latlong:healpy"`` and ``"healpix:healpy"`` have them. It says so,
        and turns nothing; ``rotation=healpix.frame_rotation("galactic", "icrs")`` does.
    properties : mapping of str, optional
        Of ``"hips"``: lines of its file ``properties``, as ``creator_did`` or ``obs_copyright``.
    page : bool
        Whether an ``index.html`` shows the tiles. It loads the viewer from a public server.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    Pyramid
        What was written.

    Raises
    ------
    ValueError, TypeError
        For a format that there is not, for settings that it cannot have, and as `convert` does.
    OSError
        Where nothing can be written, and for a folder in which something is.
    ImportError
        If OpenImageIO is missing, or astropy for FITS.
    MemoryError
        If the largest level is too large.

    Notes
    -----
    The largest level is what `convert` makes of the image, and each of the others has the mean
    light of the one before. Each file appears whole or not at all, and the one that a viewer is
    given appears last: where it is, all is there. The largest level is held in memory, and light
    takes 4 bytes a channel.

    The formats are those of Pannellum 2.5, Marzipano 0.10, Photo Sphere Viewer 5, Deep Zoom of 2009
    and HiPS 1.0 of the IVOA.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np, spheremap as sm
    >>> sky = np.ones((64, 128, 3), np.float32)
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "sky"
    >>> made = sm.tiles.write(sky, "latlong", place, format="pannellum", tile_size=32)
    >>> made.manifest.name, made.shape, made.levels, made.tiles
    ('config.json', (6, 42, 42), 2, 30)
    """
    words = _words(format, extension, curve, frame)
    p = resolve(projection, rotation=rotation)
    pixels = _pixels(image, p, any_aspect, channels_first, words["extension"])
    look = Look(words["curve"], _finite(exposure, "exposure"))
    if pixels.dtype.kind == "u" and look != Look("none", 0.0):
        raise ValueError(f"`curve` and `exposure` are for floats, got {pixels.dtype}.")
    if words["format"] == "hips" and pixels.dtype.kind == "u" and p.coverage != "sphere":
        # Where nothing is known there is NaN, which is none of integers.
        pixels = light(pixels)
    job = Job(
        image=pixels,
        src=p,
        folder=Folder(Path(), _within(quality, "quality", 1, 100)),
        size=None if size is None else _within(size, "size", 1, _LARGEST),
        tile_size=_tile_size(tile_size, words["format"]),
        extension=words["extension"],
        look=look,
        filter=filter,
        world=world,
        title=_line(_name(folder) if title is None else as_text(title, "title"), "title"),
        frame=words["frame"],
        properties=_properties(properties),
        page=as_flag(page, "page"),
    )
    if job.extension == "fits":
        fits.library()
    images()
    return _WRITERS[words["format"]](job.into(empty_folder(folder)))


def _words(format: object, extension: object, curve: object, frame: object) -> dict[str, str]:
    """Return the words that are asked for, each one that there is."""
    words = {
        "format": as_text(format, "format"),
        "extension": "jpg" if extension is None else as_text(extension, "extension"),
        "curve": as_text(curve, "curve"),
        "frame": as_text(frame, "frame"),
    }
    known = {"format": list(_WRITERS), "extension": list(get_args(Extension)),
             "curve": list(CURVES), "frame": list(FRAMES)}  # fmt: skip
    for name, word in words.items():
        _core.check_word(name, word, known[name])
    if words["extension"] == "fits" and words["format"] != "hips":
        raise ValueError(f"`extension` 'fits' is of 'hips' alone, got {words['format']!r}.")
    return words


def _pixels(
    image: ArrayLike, p: Projection, any_aspect: bool, channels_first: bool, extension: str
) -> NDArray[Any]:
    """Return the colors of an image, channels last."""
    pixels, axes = as_image(image, None), spatial_axes(p)
    if as_flag(channels_first, "channels_first"):
        pixels = channels_last(pixels, axes)
    if 0 in pixels.shape:
        raise ValueError(f"Expected `image` to have texels, got shape {pixels.shape}.")
    expect_aspect(p, pixels.shape, any_aspect)
    spatial_shape(pixels, p, "image")
    if pixels.ndim == axes:
        pixels = pixels[..., np.newaxis]
    pixels = without_alpha(pixels)
    if extension != "fits":
        return pixels
    if pixels.shape[-1] != 1:
        raise ValueError(f"FITS tiles hold one channel, `image` has {pixels.shape[-1]}.")
    # What float32 does not hold is infinite there.
    with np.errstate(over="ignore", invalid="ignore"):
        return pixels.astype(np.float32, copy=False)


def _within(value: object, name: str, least: int, most: int) -> int:
    number = as_whole(value, name)
    if not least <= number <= most:
        raise ValueError(f"`{name}` must be in [{least}, {most}], got {number}.")
    return number


def _tile_size(value: object, format: str) -> int:
    number = _within(value, "tile_size", *_TILE_SIZES)
    if format == "hips" and number & (number - 1):
        raise ValueError(f"`tile_size` of 'hips' must be a power of two, got {number}.")
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
