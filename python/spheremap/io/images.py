"""Images in and out, by OpenImageIO: `pip install spheremap[cli]`."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array, as_doubles, expect_room
from .._scalars import as_items, as_number, as_text
from .header import KINDS, PROJECTION, TRAVELS, header_of, upright
from .noted import as_noted, expect_color_space
from .opened import (
    TEXTURES,
    expect_complete,
    expect_whole_room,
    library,
    one_line,
    opened,
    said_by,
)
from .packets import with_panorama
from .whole import as_path, check_place, written_among, written_whole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection

__all__ = [
    "TEXTURES",
    "as_stored",
    "channel_names",
    "check_target",
    "read",
    "write",
    "write_among",
    "write_copy",
]

# What each format stores, the widest last. A float image must not pass for 8 bits unnoticed.
STORED: dict[str, tuple[str, ...]] = {
    ".exr": ("float16", "float32"),
    ".hdr": ("float32",),
    ".tif": ("uint8", "uint16", "float32"),
    ".tiff": ("uint8", "uint16", "float32"),
    ".png": ("uint8", "uint16"),
    ".jpg": ("uint8",),
    ".jpeg": ("uint8",),
}
# How each may be compressed; OpenImageIO takes another word for its default.
_COMPRESSIONS: dict[str, tuple[str, ...]] = {
    ".exr": ("none", "rle", "zip", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"),
    ".tif": ("none", "lzw", "zip", "packbits"),
    ".tiff": ("none", "lzw", "zip", "packbits"),
    ".jpg": ("jpeg",),
    ".jpeg": ("jpeg",),
}
_MOST_CHANNELS = {".hdr": 3, ".png": 4, ".jpg": 3, ".jpeg": 3}


def read(
    path: str | os.PathLike[str],
    *,
    part: int | str | None = None,
    fill: float | Sequence[float] = 0.0,
) -> NDArray[Any]:
    """Read an image file.

    Parameters
    ----------
    path : path-like
    part : int or str, optional
        Which image of a file of several: its number from 0, or its name.
    fill : float or sequence of float
        What the image has outside the file's data window; one number for each channel, or one.

    Returns
    -------
    image : ndarray, shape (H, W, C)
        The display window, upright. uint8, uint16, float16 or float32, as the file has it: no tone
        mapping, no change of color space, alpha neither multiplied in nor divided out.

    Raises
    ------
    OSError, ValueError, TypeError, ImportError
        As for `header`, and for a `fill` that is no number, or one that the file's dtype lacks.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "a.png"
    >>> sm.io.write(place, np.full((2, 4), 7, np.uint8))
    >>> sm.io.read(place)[..., 0].tolist()
    [[7, 7, 7, 7], [7, 7, 7, 7]]
    """
    with opened(path, part) as source:
        spec, head = source.spec(), header_of(source)
        expect_whole_room(spec, os.fspath(path))
        image = source.read_image(
            source.current_subimage(), 0, 0, spec.nchannels, KINDS[head.dtype]
        )
        if image is None:
            raise OSError(f"cannot read {os.fspath(path)!r}: {said_by(source)}")
        expect_complete(source, os.fspath(path))
        pixels: NDArray[Any] = image.reshape(spec.height, spec.width, spec.nchannels)
    size = (head.height, head.width) if head.orientation < 5 else (head.width, head.height)
    return upright(_placed(pixels, head.window, size, fill), head.orientation)


def _placed(
    pixels: NDArray[Any],
    window: tuple[int, int, int, int],
    size: tuple[int, int],
    fill: float | Sequence[float],
) -> NDArray[Any]:
    """Return a display window with the texels of a data window in it."""
    top, left, bottom, right = window
    height, width = size
    if (top, left, bottom, right) == (0, 0, height, width):
        return pixels
    image = np.empty((height, width, pixels.shape[-1]), pixels.dtype)
    image[...] = _filling(fill, pixels)
    rows = slice(max(top, 0), max(0, min(bottom, height)))
    columns = slice(max(left, 0), max(0, min(right, width)))
    held = pixels[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    image[rows, columns] = held
    return image


def _filling(fill: float | Sequence[float], pixels: NDArray[Any]) -> NDArray[Any]:
    """Return one number, or one for each channel, that the dtype of an image holds."""
    values, count = as_doubles(fill, "fill"), pixels.shape[-1]
    if values.shape not in ((), (1,), (count,)):
        raise ValueError(f"Expected `fill` to be one number or {count}, got shape {values.shape}.")
    if pixels.dtype.kind == "u":
        held = (values >= 0) & (values <= np.iinfo(pixels.dtype).max)
        if not held.all():
            raise ValueError(f"`fill` {values[~held].flat[0]:g} is no value of {pixels.dtype}.")
    # What half floats do not hold becomes infinite.
    with np.errstate(over="ignore"):
        return values.astype(pixels.dtype)


def channel_names(
    path: str | os.PathLike[str], *, part: int | str | None = None
) -> tuple[str, ...]:
    """Read the names of the channels of an image file, as ``("R", "G", "B")``.

    Parameters
    ----------
    path, part
        As for `read`.

    Returns
    -------
    names : tuple of str

    Raises
    ------
    OSError, ValueError, TypeError, ImportError
        As for `header`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "a.exr"
    >>> sm.io.write(place, np.zeros((2, 4, 2), np.float32), channels=["Y", "Z"])
    >>> sm.io.channel_names(place)
    ('Y', 'Z')
    """
    with opened(path, part) as source:
        return tuple(source.spec().channelnames)


def write(
    path: str | os.PathLike[str],
    image: ArrayLike,
    *,
    compression: str | None = None,
    channels: Sequence[str] | None = None,
    color_space: str | None = None,
    projection: Projection | str | None = None,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    """Write an image file: whole or not at all.

    The file is written beside its place and then renamed, so that whatever stood there stays
    until the new one is complete.

    Parameters
    ----------
    path : path-like
        Ending in .exr, .hdr, .tif, .png or .jpg.
    image : array_like, shape (H, W) or (H, W, C)
        Floats stay floats: they go to .exr, .hdr and .tif alone (use `tonemap` for the others).
        .exr keeps float16, all else becomes float32. Integers keep their bits where the format
        has them; .exr and .hdr get them as fractions of the largest, .jpg gets 8 bits.
        .hdr has no negative values: they become 0.
    compression : str, optional
        As OpenImageIO names it: ``"zip"``, ``"piz"``, ``"dwaa:45"``, ``"jpeg:90"`` ...
    channels : sequence of str, optional
        Names of the channels, for formats that keep them.
    color_space : str, optional
        Of the colors, as `Header` or OpenImageIO's ``ColorConfig`` names it. It is noted, nothing
        is changed.
    projection : Projection or str, optional
        How the image maps the sphere, as ``"latlong"``: noted where the format can say it, as
        GPano for ``"latlong"`` in .jpg and .png, as ``envmap`` for ``"latlong:openexr"`` and
        ``"cube:openexr"`` in .exr, and in our own words in .exr and .png.
    metadata : mapping, optional
        As `Header` has it. What the format cannot say, and other names, are left out.

    Raises
    ------
    OSError
        For a place that cannot be written, an unknown format, or more channels than it holds.
    ValueError
        For a shape that is no image, floats for a format of integers, a compression that the
        format does not have, an unknown projection or color space, or a projection without a name:
        one whose axes, grid, world or pose were changed, or in a layout that its image's size does
        not tell.
    ImportError
        If OpenImageIO is missing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "sky.exr"
    >>> sm.io.write(place, np.ones((4, 8, 3), np.float32), compression="piz", projection="latlong")
    >>> sm.io.read(place).shape, sm.io.header(place).projection
    ((4, 8, 3), 'latlong')
    """
    if color_space is not None:
        expect_color_space(color_space)
    write_copy(
        path,
        image,
        compression=compression,
        channels=channels,
        color_space=color_space,
        projection=None if projection is None else as_noted(projection),
        metadata=metadata,
    )


def write_copy(
    path: str | os.PathLike[str], image: ArrayLike, *, compression: str | None, **said: Any
) -> None:
    """Do as `write` with what another file says, whose color space may have a name of its own."""
    _write(path, image, written_whole, compression, **said)


def write_among(
    path: str | os.PathLike[str], image: ArrayLike, *, compression: str | None = None
) -> None:
    """Do as `write` for one of many images in a new folder, which `bring_to_disk` is for."""
    _write(path, image, written_among, compression)


def _write(
    path: str | os.PathLike[str],
    image: ArrayLike,
    put: Callable[[Path, Callable[[Path], None]], None],
    compression: str | None,
    *,
    channels: Sequence[str] | None = None,
    color_space: str | None = None,
    projection: str | None = None,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    oiio = library()
    # A rename would replace a symbolic link, where the caller means the file behind it.
    name = as_path(path)
    target = Path(os.path.realpath(name))
    extension = target.suffix.lower()
    pixels = as_stored(as_array(image, "image"), extension, name)
    check_place(target, name)

    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, KINDS[pixels.dtype.name])
    spec.attribute("oiio:UnassociatedAlpha", 1)
    if compression is not None:
        _check_compression(compression, extension)
        spec.attribute("compression", compression)
    if channels is not None:
        names = tuple(as_text(x, "channels") for x in as_items(channels, "channels", "names"))
        if len(names) != count:
            raise ValueError(f"Expected `channels` to name {count} channels, got {len(names)}.")
        spec.channelnames = names
    _note(oiio, spec, extension, color_space, projection, metadata or {})

    def write_to(place: Path) -> None:
        _write_pixels(oiio, place, spec, pixels, name)
        if projection == "latlong":
            try:
                with_panorama(place, width, height)
            except OSError as error:
                raise OSError(f"cannot write {name!r}: {error.strerror}") from None

    put(target, write_to)


def _note(
    oiio: Any,
    spec: Any,
    extension: str,
    color_space: str | None,
    projection: str | None,
    metadata: Mapping[str, Any],
) -> None:
    """Put into a file's header what it says besides its texels."""
    if not isinstance(metadata, Mapping):
        raise TypeError(f"Expected `metadata` to be a mapping, got {type(metadata).__name__}.")
    for name, value in metadata.items():
        floats = TRAVELS.get(name)
        if floats:
            items = as_items(value, name, "numbers") if floats > 1 else [value]
            numbers = tuple(as_number(x, name) for x in items)
            if len(numbers) != floats:
                raise ValueError(f"Expected `{name}` to be {floats} numbers, got {len(numbers)}.")
            spec.attribute(
                name, oiio.TypeDesc(f"float[{floats}]" if floats > 1 else "float"), numbers
            )
        elif name == "ICCProfile":
            if not isinstance(value, bytes | np.ndarray):
                raise TypeError(f"Expected `{name}` to be bytes, got {type(value).__name__}.")
            profile = np.frombuffer(bytes(value), np.uint8)
            spec.attribute(name, oiio.TypeDesc(f"uint8[{len(profile)}]"), profile)
        elif floats == 0:
            spec.attribute(name, str(value))
    if color_space is not None:
        spec.attribute("oiio:ColorSpace", as_text(color_space, "color_space"))
    if projection is not None:
        spec.attribute(PROJECTION, projection)
        environment = {"latlong:openexr": "LatLong", "cube:openexr": "CubeFace"}.get(projection)
        if extension == ".exr" and environment:
            spec.attribute("textureformat", f"{environment} Environment")


def check_target(path: str | os.PathLike[str], *, compression: str | None = None) -> None:
    """Raise the error that writing to this place would raise, before any work is done.

    Parameters
    ----------
    path : path-like
    compression : str, optional
        As for `write`.

    Raises
    ------
    OSError
        For a place that cannot be written, or an unknown format.
    ValueError
        For a compression that the format does not have.

    Examples
    --------
    >>> import spheremap as sm, tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> sm.io.check_target(folder / "a.exr", compression="zip")
    >>> sm.io.check_target(folder / "a.png", compression="zip")
    Traceback (most recent call last):
    ValueError: .png has no choice of `compression`, got 'zip'.
    """
    name = as_path(path)
    target = Path(os.path.realpath(name))
    _check_format(target.suffix.lower(), name, (*STORED, *TEXTURES))
    if compression is not None:
        _check_compression(compression, target.suffix.lower())
    check_place(target, name)


def _check_compression(compression: str, extension: str) -> None:
    known = _COMPRESSIONS.get(extension, ())
    if as_text(compression, "compression").partition(":")[0] not in known:
        raise ValueError(
            f"Expected `compression` of {extension} to be one of {', '.join(known)}, "
            f"got {compression!r}."
            if known
            else f"{extension} has no choice of `compression`, got {compression!r}."
        )


def as_stored(image: NDArray[Any], extension: str, name: str) -> NDArray[Any]:
    """Return the image as (H, W, C) in the dtype that the format will hold."""
    _check_format(extension, name, tuple(STORED))
    if image.ndim not in (2, 3) or 0 in image.shape:
        raise ValueError(f"Expected `image` to have shape (H, W) or (H, W, C), got {image.shape}.")
    pixels = image if image.ndim == 3 else image[..., np.newaxis]
    most = _MOST_CHANNELS.get(extension, pixels.shape[-1])
    if pixels.shape[-1] > most or (extension == ".hdr" and pixels.shape[-1] != most):
        raise OSError(
            f"cannot write {name!r}: {extension} holds {most} channels, "
            f"the image has {pixels.shape[-1]}"
        )
    kinds, dtype = STORED[extension], pixels.dtype.name
    if dtype in kinds:
        return np.ascontiguousarray(pixels)
    if dtype in ("float16", "float32", "float64"):
        if "float32" not in kinds:
            raise ValueError(
                f"{extension} holds integers and the image holds {dtype}: "
                "make a picture of it with spheremap.io.tonemap"
            )
        # What float32 does not hold becomes infinite.
        with np.errstate(over="ignore", invalid="ignore"):
            return np.ascontiguousarray(pixels, dtype=np.float32)
    if dtype not in ("uint8", "uint16"):
        raise ValueError(f"Expected `image` to be uint8, uint16 or floats, got {dtype}.")
    if "float32" in kinds:
        expect_room(pixels.shape, np.dtype(np.float32))
        return np.ascontiguousarray(pixels / np.float32(np.iinfo(pixels.dtype).max))
    return np.ascontiguousarray((pixels.astype(np.uint32) + 128) // 257, dtype=np.uint8)


def _check_format(extension: str, name: str, known: Sequence[str]) -> None:
    if extension not in known:
        raise OSError(
            f"cannot write {name!r}: unknown format {extension!r}; use one of {', '.join(known)}"
        )


# Their libraries end the process, or say that all is well, where a disk is full.
_IN_MEMORY = (".png", ".jpg", ".jpeg")


def _write_pixels(oiio: Any, place: Path, spec: Any, pixels: NDArray[Any], name: str) -> None:
    """Write an image file, and believe nobody that it is complete."""
    if place.suffix.lower() in _IN_MEMORY and hasattr(os, "memfd_create"):
        held = os.memfd_create("spheremap")
        try:
            _put_pixels(oiio, Path(f"/proc/self/fd/{held}"), place.suffix, spec, pixels, name)
            size = os.fstat(held).st_size
            with open(place, "wb") as file:
                os.lseek(held, 0, os.SEEK_SET)
                while size > 0:
                    part = os.read(held, 1 << 20)
                    file.write(part)
                    size -= len(part)
        except OSError as error:
            if error.errno is None:
                raise
            raise OSError(f"cannot write {name!r}: {error.strerror}") from None
        finally:
            os.close(held)
    else:
        _put_pixels(oiio, place, place.suffix, spec, pixels, name)
    _check_last_row(oiio, place, name)


def _check_last_row(oiio: Any, place: Path, name: str) -> None:
    source = oiio.ImageInput.open(str(place))
    if source is None:
        raise OSError(f"cannot write {name!r}: {one_line(oiio.geterror())}")
    try:
        last = source.spec().height - 1
        if source.read_scanline(last, 0) is None:
            reason = said_by(source)
            raise OSError(f"cannot write {name!r}: what was written is not whole: {reason}")
    finally:
        source.close()


def _put_pixels(
    oiio: Any, place: Path, extension: str, spec: Any, pixels: NDArray[Any], name: str
) -> None:
    sink = oiio.ImageOutput.create(extension.lstrip("."))
    if sink is None:
        raise OSError(f"cannot write {name!r}: {one_line(oiio.geterror())}")
    good = sink.open(str(place), spec) and sink.write_image(pixels)
    reason = "" if good else said_by(sink)
    # The last bytes go out on closing: a full disk may show only here.
    if not sink.close() and not reason:
        reason = said_by(sink)
        good = False
    if not good:
        raise OSError(f"cannot write {name!r}: {reason.replace(str(place), name)}")
