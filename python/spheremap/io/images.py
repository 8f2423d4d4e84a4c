"""Images in and out, by OpenImageIO, and the way from light to a picture on a screen.

Reading and writing need `pip install spheremap[cli]`; `tonemap` does not.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .whole import written_whole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["channel_names", "check_target", "read", "tonemap", "write"]

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
_MOST_CHANNELS = {".hdr": 3, ".png": 4, ".jpg": 3, ".jpeg": 3}


def read(path: str | os.PathLike[str]) -> NDArray[Any]:
    """Read an image file.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    image : ndarray, shape (H, W, C)
        uint8, uint16, float16 or float32, as the file has it: no tone mapping, no change of
        color space, alpha not multiplied in.

    Raises
    ------
    OSError
        For a file that is missing or that OpenImageIO cannot read.
    ImportError
        If OpenImageIO is missing.
    """
    oiio = _oiio()
    source = _open(path)
    try:
        spec = source.spec()
        kept = {"uint8": "uint8", "uint16": "uint16", "half": "half"}
        image = source.read_image(0, 0, 0, spec.nchannels, kept.get(str(spec.format), "float"))
        if image is None:
            raise OSError(f"cannot read {os.fspath(path)!r}: {_reason(source, oiio)}")
        pixels: NDArray[Any] = image
        return pixels.reshape(spec.height, spec.width, spec.nchannels)
    finally:
        source.close()


def channel_names(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Read the names of the channels of an image file, as ``("R", "G", "B")``.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    names : tuple of str

    Raises
    ------
    OSError, ImportError
        As for `read`.
    """
    source = _open(path)
    try:
        return tuple(source.spec().channelnames)
    finally:
        source.close()


def write(
    path: str | os.PathLike[str],
    image: ArrayLike,
    *,
    compression: str | None = None,
    channels: Sequence[str] | None = None,
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

    Raises
    ------
    OSError
        For a place that cannot be written, an unknown format, or more channels than it holds.
    ValueError
        For a shape that is no image, or floats for a format of integers.
    ImportError
        If OpenImageIO is missing.
    """
    oiio = _oiio()
    # A rename would replace a symbolic link, where the caller means the file behind it.
    target = Path(os.path.realpath(path))
    extension = target.suffix.lower()
    pixels = _stored(np.asarray(image), extension, os.fspath(path))
    _check_place(target, os.fspath(path))

    height, width, count = pixels.shape
    spec = oiio.ImageSpec(width, height, count, _OIIO_TYPE[pixels.dtype.name])
    spec.attribute("oiio:UnassociatedAlpha", 1)
    if compression is not None:
        spec.attribute("compression", compression)
    if channels is not None:
        if len(channels) != count:
            raise ValueError(f"Expected `channels` to name {count} channels, got {len(channels)}.")
        spec.channelnames = tuple(channels)

    def put(place: Path) -> None:
        _write_pixels(oiio, place, spec, pixels, os.fspath(path))

    written_whole(target, put)


def check_target(path: str | os.PathLike[str]) -> None:
    """Raise the error that `write` would raise for this place, before any work is done.

    Parameters
    ----------
    path : path-like

    Raises
    ------
    OSError
        For a place that cannot be written, or an unknown format.
    """
    name = os.fspath(path)
    target = Path(os.path.realpath(path))
    _check_format(target.suffix.lower(), name)
    _check_place(target, name)


def tonemap(image: ArrayLike, *, exposure: float | None = 0.0) -> NDArray[np.uint8]:
    """Turn linear light into an 8-bit picture for a screen.

    The curve is Reinhard's with a white point: y = x (1 + x/w²)/(1 + x) with w = 4, of each
    channel, then the sRGB transfer function.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C)
        Linear light. Of two channels the first is taken, of more than three the first three.
    exposure : float or None
        In stops: the light is multiplied by 2^exposure. None puts the geometric mean of the
        luminance at 0.18.

    Returns
    -------
    picture : ndarray of uint8, shape (H, W), (H, W, 1) or (H, W, 3)
        NaN and negative values are black, infinity is white.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap.io import tonemap
    >>> tonemap(np.array([[0.0, 0.18, 4.0, np.inf]])).tolist()
    [[0, 109, 255, 255]]
    """
    light = np.asarray(image, dtype=np.float32)
    if light.ndim == 3 and light.shape[-1] != 1:
        light = light[..., : 3 if light.shape[-1] >= 3 else 1]
    # Beyond this the curve is white whatever the exposure; it keeps infinity out of inf/inf.
    light = np.clip(np.nan_to_num(light, nan=0.0, posinf=1e12, neginf=0.0), 0.0, 1e12)
    stops = _automatic_exposure(light) if exposure is None else exposure
    light = np.minimum(light * np.float32(2.0**stops), 1e12)
    white = 4.0
    curve = np.minimum(light * (1.0 + light / white**2) / (1.0 + light), 1.0)
    encoded = np.where(curve <= 0.0031308, 12.92 * curve, 1.055 * curve ** (1 / 2.4) - 0.055)
    return np.asarray(np.rint(encoded * 255.0), dtype=np.uint8)


def _automatic_exposure(light: NDArray[np.float32]) -> float:
    brightness = light if light.ndim == 2 else light.mean(axis=-1)
    lit = brightness[brightness > 0]
    if lit.size == 0:
        return 0.0
    return float(np.log2(0.18) - np.mean(np.log2(lit), dtype=np.float64))


_OIIO_TYPE = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}


def _oiio() -> Any:
    try:
        import OpenImageIO
    except ImportError:
        raise ImportError(
            "images need OpenImageIO: pip install spheremap[cli]", name="OpenImageIO"
        ) from None
    return OpenImageIO


def _open(path: str | os.PathLike[str]) -> Any:
    oiio = _oiio()
    name = os.fspath(path)
    if not os.path.exists(name):
        raise FileNotFoundError(f"no such file: {name!r}")
    # Multiplying alpha in would lose the color of transparent texels.
    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(name, wish)
    if source is None:
        raise OSError(f"cannot read {name!r}: {_one_line(oiio.geterror())}")
    return source


def _stored(image: NDArray[Any], extension: str, name: str) -> NDArray[Any]:
    """Return the image as (H, W, C) in the dtype that the format will hold."""
    _check_format(extension, name)
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
        return np.ascontiguousarray(pixels, dtype=np.float32)
    if dtype not in ("uint8", "uint16"):
        raise ValueError(f"Expected `image` to be uint8, uint16 or floats, got {dtype}.")
    if "float32" in kinds:
        return np.ascontiguousarray(pixels / np.float32(np.iinfo(pixels.dtype).max))
    return np.ascontiguousarray((pixels.astype(np.uint32) + 128) // 257, dtype=np.uint8)


def _check_format(extension: str, name: str) -> None:
    if extension not in STORED:
        raise OSError(
            f"cannot write {name!r}: unknown format {extension!r}; use one of {', '.join(STORED)}"
        )


def _check_place(target: Path, name: str) -> None:
    if target.is_dir():
        raise IsADirectoryError(f"cannot write {name!r}: it is a folder")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"cannot write {name!r}: no folder {str(target.parent)!r}")
    # The rename asks the folder alone; a file that its owner protected must stay as well.
    for place in (target.parent, target):
        if place.exists() and not os.access(place, os.W_OK):
            raise PermissionError(f"cannot write {name!r}: no permission to write {str(place)!r}")


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
        raise OSError(f"cannot write {name!r}: {_one_line(oiio.geterror())}")
    try:
        last = source.spec().height - 1
        if source.read_scanline(last, 0) is None:
            reason = _reason(source, oiio)
            raise OSError(f"cannot write {name!r}: what was written is not whole: {reason}")
    finally:
        source.close()


def _put_pixels(
    oiio: Any, place: Path, extension: str, spec: Any, pixels: NDArray[Any], name: str
) -> None:
    sink = oiio.ImageOutput.create(extension.lstrip("."))
    if sink is None:
        raise OSError(f"cannot write {name!r}: {_one_line(oiio.geterror())}")
    good = sink.open(str(place), spec) and sink.write_image(pixels)
    reason = "" if good else _reason(sink, oiio)
    # The last bytes go out on closing: a full disk may show only here.
    if not sink.close() and not reason:
        reason = _reason(sink, oiio)
        good = False
    if not good:
        raise OSError(f"cannot write {name!r}: {reason.replace(str(place), name)}")


def _reason(handle: Any, oiio: Any) -> str:
    return _one_line(handle.geterror() or oiio.geterror())


def _one_line(text: str) -> str:
    return " ".join(text.split()) or "unknown error"
