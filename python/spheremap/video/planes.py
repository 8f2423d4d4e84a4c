"""The planes of a frame as arrays, and what their numbers stand for.

Frames are converted plane by plane, as they are stored: no color is computed, so that none is
rounded twice. That is exact for lookups and means: they are linear, and so is the way from R'G'B'
to Y'CbCr.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from av.video.format import VideoFormat
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

__all__ = ["Plane", "between", "described", "planar", "ratio", "reformatted", "views"]

# What holds the same numbers, each kind in a plane of its own.
_PLANAR = {
    "nv12": "yuv420p", "nv21": "yuv420p", "nv16": "yuv422p", "nv24": "yuv444p", "nv42": "yuv444p",
    "yuyv422": "yuv422p", "uyvy422": "yuv422p", "yvyu422": "yuv422p",
    "p010le": "yuv420p10le", "p012le": "yuv420p12le", "p016le": "yuv420p16le",
    "p210le": "yuv422p10le", "p212le": "yuv422p12le", "p216le": "yuv422p16le",
    "p410le": "yuv444p10le", "p412le": "yuv444p12le", "p416le": "yuv444p16le",
    "nv20le": "yuv422p10le", "y210le": "yuv422p10le",
    "rgb24": "gbrp", "bgr24": "gbrp", "rgb0": "gbrp", "bgr0": "gbrp", "0rgb": "gbrp",
    "0bgr": "gbrp", "rgba": "gbrap", "bgra": "gbrap", "argb": "gbrap", "abgr": "gbrap",
    "rgb48le": "gbrp16le", "bgr48le": "gbrp16le", "rgba64le": "gbrap16le", "bgra64le": "gbrap16le",
}  # fmt: skip
# How the names of formats say how many texels of luma one of chroma stands for, across and down.
_RATIOS = {
    (1, 1): "444", (2, 1): "422", (2, 2): "420", (1, 2): "440", (4, 1): "411", (4, 4): "410",
}  # fmt: skip
_SAYS_RATIO = re.compile(r"(?<=^yuv)4\d\d|(?<=^yuv[aj])4\d\d")
# FFmpeg's numbers of ranges, and of matrices.
_LIMITED_RANGE, _FULL_RANGE = 1, 2
_RGB, _UNSPECIFIED, _BT601 = 0, 2, 6


@dataclass(frozen=True)
class Plane:
    """What a plane of a format holds.

    Attributes
    ----------
    dtype : dtype
        uint8, uint16 or float32.
    top : int or None
        The largest number that its bits hold; None of floats.
    black : float
        Its number where nothing is known.
    across, down : int
        How many texels of luma one of its own stands for.
    """

    dtype: np.dtype[Any]
    top: int | None
    black: float
    across: int
    down: int

    @property
    def is_smaller(self) -> bool:
        """Whether it has fewer texels than luma."""
        return self.across > 1 or self.down > 1


def planar(name: str) -> str:
    """Return the name of a format with the same numbers in planes of the machine's bytes."""
    name = name[:-2] + "le" if name.endswith("be") else name
    return _PLANAR.get(name, name)


def described(pixel_format: VideoFormat, color_range: int) -> tuple[Plane, ...]:
    """Return what the planes of a format hold, in their order.

    Raises
    ------
    ValueError
        For a format that keeps several numbers of a texel in one plane, or a palette.
    """
    name, parts = pixel_format.name, pixel_format.components
    numbers = sorted(part.plane for part in parts)
    bits = {part.bits for part in parts}
    known = bits <= {8, *range(9, 17), 32} and not (32 in bits) ^ ("f32" in name)
    if pixel_format.has_palette or numbers != list(range(len(parts))) or not known:
        raise ValueError(f"frames of pixel format {name!r} are not supported")
    is_gray = len(parts) == 1
    is_full = pixel_format.is_rgb or name.startswith("yuvj") or color_range == _FULL_RANGE
    # Gray that says nothing is a picture's, not a broadcast's.
    is_full |= is_gray and color_range == 0

    def plane(k: int) -> Plane:
        index, part = next((i, part) for i, part in enumerate(parts) if part.plane == k)
        depth = part.bits
        is_chroma = not pixel_format.is_rgb and index in (1, 2) and len(parts) > 2
        if depth == 32:
            return Plane(np.dtype(np.float32), None, 0.0, 1, 1)
        black = 0 if is_full or part.is_alpha else 16 << (depth - 8)
        if is_chroma:
            black = 1 << (depth - 1)
        dtype = np.dtype(np.uint8 if depth == 8 else np.uint16)
        across, down = ratio(name) if is_chroma else (1, 1)
        return Plane(dtype, (1 << depth) - 1, black, across, down)

    return tuple(plane(k) for k in range(len(parts)))


def ratio(name: str) -> tuple[int, int]:
    """Return how many texels of luma one of chroma stands for, across and down."""
    from av import VideoFormat

    large = VideoFormat(name, 64, 64)
    chroma = large.components[min(1, len(large.components) - 1)]
    return 64 // chroma.width, 64 // chroma.height


def between(source: str, wanted: str) -> tuple[str, str]:
    """Return the formats that a conversion reads and writes, which differ in the size of chroma.

    FFmpeg makes the first of the source's and the wanted one of the second, without a change of
    that size: it knows of no siting.

    Raises
    ------
    ValueError
        Where there are no such formats.
    """
    from av import VideoFormat

    own, goal = planar(source), planar(wanted)
    here, there = ratio(own), ratio(goal)
    is_gray = min(len(VideoFormat(name).components) for name in (own, goal)) < 3
    if here == there or is_gray:
        return own, own
    for read, made in ((own, _with_ratio(own, there)), (_with_ratio(goal, here), goal)):
        if read and made:
            return read, made
    raise ValueError(
        f"Expected `pixel_format` to be one that {source!r} can become, got {wanted!r}."
    )


def _with_ratio(name: str, wanted: tuple[int, int]) -> str:
    """Return the format that differs in the size of chroma alone; none where it has no chroma."""
    from av import VideoFormat

    found = _SAYS_RATIO.sub(_RATIOS[wanted], name)
    with suppress(ValueError):
        if ratio(found) == wanted:
            return VideoFormat(found).name
    return ""


def reformatted(frame: VideoFrame, name: str) -> VideoFrame:
    """Return a frame in another format; what it says of its colors is so then."""
    from av import VideoFormat

    if frame.format.name == name:
        return frame
    of_rgb, to_rgb = frame.format.is_rgb, VideoFormat(name).is_rgb
    to_gray = name.startswith("gray") and not frame.format.name.startswith("gray")
    color_range = _FULL_RANGE if to_rgb or to_gray or name.startswith("yuvj") else None
    if of_rgb and color_range is None:
        color_range = _LIMITED_RANGE
    result = frame.reformat(format=name, dst_color_range=color_range)
    if to_rgb:
        result.colorspace = _RGB
    elif of_rgb and frame.colorspace in (_RGB, _UNSPECIFIED):
        # What FFmpeg takes where it is told of none.
        result.colorspace = _BT601
    return result


def views(frame: VideoFrame, planes: tuple[Plane, ...]) -> list[NDArray[Any]]:
    """Return the planes of a frame as arrays of its own memory, shape (H, W) each.

    Rows may be longer in memory than they are wide.
    """
    arrays = []
    for plane, held in zip(planes, frame.planes, strict=True):
        flat = np.frombuffer(held, plane.dtype)  # type: ignore[call-overload]
        stride = held.line_size // plane.dtype.itemsize
        rows = flat[: stride * held.height].reshape(held.height, stride)
        arrays.append(rows[:, : held.width])
    return arrays
