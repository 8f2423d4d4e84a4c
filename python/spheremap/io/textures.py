"""Textures as renderers load them: KTX2 and DDS, half float, with all faces and mips."""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array
from .._scalars import as_items
from .whole import as_path, write_bytes

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["write_dds", "write_ktx2"]

_LARGEST_HALF = 65504.0


def write_ktx2(path: str | os.PathLike[str], levels: Sequence[NDArray[Any]]) -> int:
    """Write a cube map or a flat texture as .ktx2, in RGBA half floats, uncompressed.

    Parameters
    ----------
    path : path-like
        Ending in .ktx2.
    levels : sequence of ndarray, shape (6, N, N, C) or (H, W, C)
        The mips, the largest first, of up to four channels. Missing colors are 0 (one channel is
        gray), a missing alpha is 1. uint8 and uint16 become fractions of the largest, as by
        `write`. Faces are in the order +x -x +y -y +z -z of OpenGL, Direct3D and Vulkan, each with
        its first row on top.

    Returns
    -------
    clipped : int
        How many values lay outside what half floats hold, ±65504, and were set to that.

    Raises
    ------
    ValueError, TypeError
        For levels that make no texture, or of other integers.
    OSError
        For a place that cannot be written, or another format.

    Notes
    -----
    KTX File Format Specification 2.0: VK_FORMAT_R16G16B16A16_SFLOAT, levels stored smallest first.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "white.ktx2"
    >>> sm.io.write_ktx2(place, [np.ones((6, 4, 4, 3)), np.ones((6, 2, 2, 3))])
    0
    >>> place.stat().st_size
    1232
    """
    _expect_suffix(path, ".ktx2")
    mips, clipped = _halves(levels)
    faces, height, width, _ = mips[0].shape
    # Basic data format descriptor: linear RGBA, BT.709, one signed float sample a channel.
    samples = b"".join(
        struct.pack("<HBBIII", 16 * k, 15, channel | 0xC0, 0, 0xBF800000, 0x3F800000)
        for k, channel in enumerate((0, 1, 2, 15))
    )
    block = 24 + len(samples)
    descriptor = struct.pack(
        "<IIHHBBBB4B8B", 4 + block, 0, 2, block, 1, 1, 1, 0, *[0] * 4, 8, *[0] * 7
    )
    descriptor += samples
    values = b""
    for key, text in (("KTXorientation", "rd"), ("KTXwriter", "spheremap")):
        entry = key.encode() + b"\0" + text.encode() + b"\0"
        values += struct.pack("<I", len(entry)) + entry + b"\0" * (-len(entry) % 4)
    index = 80
    start = index + 24 * len(mips)
    header = b"\xabKTX 20\xbb\r\n\x1a\n"
    header += struct.pack("<9I", 97, 2, width, height, 0, 0, faces, len(mips), 0)
    header += struct.pack("<4I", start, len(descriptor), start + len(descriptor), len(values))
    header += struct.pack("<2Q", 0, 0)
    body = descriptor + values
    places = []
    for mip in reversed(mips):
        body += b"\0" * (-(start + len(body)) % 8)
        places.append((start + len(body), mip.nbytes))
        body += mip.tobytes()
    for place, size in reversed(places):
        header += struct.pack("<3Q", place, size, size)
    write_bytes(path, header + body)
    return clipped


def write_dds(path: str | os.PathLike[str], levels: Sequence[NDArray[Any]]) -> int:
    """Write a cube map or a flat texture as .dds, in RGBA half floats, uncompressed.

    Parameters
    ----------
    path : path-like
        Ending in .dds.
    levels
        As for `write_ktx2`.

    Returns
    -------
    clipped : int
        As for `write_ktx2`.

    Raises
    ------
    ValueError, TypeError, OSError
        As for `write_ktx2`.

    Notes
    -----
    Microsoft's DDS programming guide: the format is D3DFMT_A16B16G16R16F (113), which readers of
    Direct3D 9 and of later ones know (OpenImageIO 3.2 does not); faces one after the other, each
    with all of its mips.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "white.dds"
    >>> sm.io.write_dds(place, [np.ones((6, 4, 4, 3)), np.ones((6, 2, 2, 3))])
    0
    >>> place.stat().st_size == 128 + 6 * (16 + 4) * 8
    True
    """
    _expect_suffix(path, ".dds")
    mips, clipped = _halves(levels)
    faces, height, width, _ = mips[0].shape
    # Caps, height, width, pixel format and pitch are always there.
    flags = 0x1 | 0x2 | 0x4 | 0x8 | 0x1000 | (0x20000 if len(mips) > 1 else 0)
    caps = 0x1000 | (0x400008 if len(mips) > 1 else 0) | (0x8 if faces == 6 else 0)
    header = b"DDS " + struct.pack(
        "<7I44x", 124, flags, height, width, 8 * width, 0, len(mips) if len(mips) > 1 else 0
    )
    header += struct.pack("<8I", 32, 0x4, 113, 0, 0, 0, 0, 0)
    header += struct.pack("<5I", caps, 0xFE00 if faces == 6 else 0, 0, 0, 0)
    body = b"".join(mip[face].tobytes() for face in range(faces) for mip in mips)
    write_bytes(path, header + body)
    return clipped


def _expect_suffix(path: str | os.PathLike[str], suffix: str) -> None:
    """Raise for a name whose readers would expect another format."""
    name = as_path(path)
    # A symbolic link is the file behind it.
    got = Path(os.path.realpath(name)).suffix
    if got.lower() != suffix:
        raise OSError(f"cannot write {name!r}: it ends in {got!r}; use {suffix}")


def _halves(levels: Sequence[NDArray[Any]]) -> tuple[list[NDArray[np.float16]], int]:
    """Return the levels as (faces, H, W, 4) half floats, and how many values were too large."""
    given = [as_array(level, "levels") for level in as_items(levels, "levels", "arrays")]
    if not given:
        raise ValueError("Expected at least one level.")
    mips: list[NDArray[np.float16]] = []
    clipped = 0
    for k, level in enumerate(given):
        if level.dtype.kind != "f" and level.dtype not in (np.uint8, np.uint16):
            raise TypeError(
                f"Expected `levels` to be uint8, uint16 or floats, got dtype {level.dtype}."
            )
        array = level[np.newaxis] if level.ndim == 3 else level
        if array.ndim != 4:
            raise ValueError(
                f"Expected each level to have shape (H, W, C) or (6, N, N, C), got {level.shape}."
            )
        first = mips[0].shape if mips else array.shape
        wanted = (first[0], max(first[1] >> k, 1), max(first[2] >> k, 1))
        fits = array.shape[:3] == wanted and 1 <= array.shape[3] <= 4
        if not fits or array.shape[0] not in (1, 6) or 0 in array.shape:
            raise ValueError(
                f"Expected level {k} to have shape {wanted[1:]} or (6, N, N), each half of the one "
                f"before, with 1 to 4 channels, got {level.shape}."
            )
        if array.dtype.kind == "u":
            array = array / np.float32(np.iinfo(array.dtype).max)
        channels = array.shape[-1]
        wide = np.zeros((*array.shape[:3], 4), np.result_type(array.dtype, np.float32))
        wide[..., 3] = 1.0
        wide[..., :channels] = array
        if channels == 1:
            wide[..., 1:3] = array
        clipped += int(np.count_nonzero(np.abs(wide) > _LARGEST_HALF))
        mips.append(np.clip(wide, -_LARGEST_HALF, _LARGEST_HALF).astype("<f2"))
    return mips, clipped
