"""What an image file says of itself, besides its texels."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from .opened import opened, part_names

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    Alpha: TypeAlias = Literal["none", "straight", "premultiplied"]

__all__ = ["Header", "header"]

# What a copy of an image says as well, and how many floats it is where it is no text.
TRAVELS = {
    "Artist": 0,
    "Copyright": 0,
    "ImageDescription": 0,
    "Make": 0,
    "Model": 0,
    "DateTime": 0,
    "Exif:DateTimeOriginal": 0,
    "Exif:OffsetTimeOriginal": 0,
    "whiteLuminance": 1,
    "chromaticities": 8,
}
# The dtypes of images, and OpenImageIO's words for them.
KINDS = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}
# Linear color spaces by their chromaticities: x and y of red, green, blue and white.
_PRIMARIES = {
    "lin_ap0_scene": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767),
    "lin_ap1_scene": (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767),
    "lin_rec2020_scene": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329),
    "lin_p3d65_scene": (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329),
}
# Formats of straight alpha whose readers do not say so.
_STRAIGHT = ("png", "bmp", "gif")
# Our own word for a projection, where a file can hold any.
PROJECTION = "spheremap:projection"


@dataclass(frozen=True)
class Header:
    """What `header` reads of an image file; hashable.

    Attributes
    ----------
    height, width : int
        Of the display window, upright: what `read` returns.
    channels : tuple of str
        Names of the channels, as ``("R", "G", "B")``.
    dtype : str
        What `read` returns: uint8, uint16, float16 or float32.
    color_space : str
        As OpenImageIO names it: ``"lin_rec709_scene"`` for linear light, ``"srgb_rec709_scene"``
        for sRGB. Where the file does not say, floats are linear, of the primaries that the
        chromaticities of an .exr are, and integers sRGB.
    alpha : {"none", "straight", "premultiplied"}
        How colors and alpha are stored.
    alpha_channel : int or None
        Which channel alpha is.
    parts : tuple of str
        Names of the parts of a file of several images.
    window : tuple of int
        The data window (top, left, bottom, right) in the display window, before it is turned
        upright; it may reach beyond it.
    orientation : int
        How the stored rows lie, as EXIF numbers it; 1 is upright.
    projection : str or None
        The projection that the file names: by its EXR ``envmap``, its GPano, or our own word. A
        cylinder of GPano is one of 360 degrees, as ``"cylindrical(aspect=16/5)"``.
    tilt : tuple of float
        How far the camera looked up at the middle of the panorama, and how far it was rolled: the
        pitch and roll of GPano's pose, in degrees. `read` turns nothing.
    metadata : mapping
        What travels with the image: Artist, Copyright, ImageDescription, dates, chromaticities,
        ICCProfile.
    """

    height: int
    width: int
    channels: tuple[str, ...]
    dtype: str
    color_space: str
    alpha: Alpha
    alpha_channel: int | None
    parts: tuple[str, ...]
    window: tuple[int, int, int, int]
    orientation: int
    projection: str | None
    tilt: tuple[float, float]
    metadata: Mapping[str, Any] = field(repr=False, hash=False)

    @property
    def linear(self) -> bool:
        """Whether the numbers are proportional to light."""
        return is_linear(self.color_space)


def is_linear(color_space: str) -> bool:
    """Tell whether the numbers of a color space are proportional to light."""
    return color_space.lower().startswith(("lin_", "linear", "scene_linear", "acescg", "aces2065"))


def header(path: str | os.PathLike[str], *, part: int | str | None = None) -> Header:
    """Read what an image file says of itself.

    Parameters
    ----------
    path : path-like
    part : int or str, optional
        Which image of a file of several: its number from 0, or its name.

    Returns
    -------
    header : Header

    Raises
    ------
    OSError
        For a file that is missing, that OpenImageIO cannot read, or that holds samples of several
        depths.
    ValueError
        For a file of several parts of which none is named, or not one that there is; for text that
        is no path.
    TypeError
        For what is no path.
    ImportError
        If OpenImageIO is missing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm, tempfile, pathlib
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "a.png"
    >>> sm.io.write(place, np.zeros((2, 4, 4), np.uint8))
    >>> found = sm.io.header(place)
    >>> found.channels, found.dtype, found.alpha, found.linear
    (('R', 'G', 'B', 'A'), 'uint8', 'straight', False)
    """
    with opened(path, part) as source:
        return header_of(source)


def header_of(source: Any) -> Header:
    """Return the header of an image that has been opened."""
    spec = source.spec()
    kind = str(spec.format)
    dtype = next((name for name, known in KINDS.items() if known == kind), "float32")
    window, (height, width) = _windows(spec)
    orientation = int(spec.get_int_attribute("Orientation", 1))
    if orientation >= 5:
        height, width = width, height
    alpha_channel = int(spec.alpha_channel)
    alpha: Alpha = "none"
    if alpha_channel >= 0:
        straight = source.format_name() in _STRAIGHT or spec.get_int_attribute(
            "oiio:UnassociatedAlpha"
        )
        alpha = "straight" if straight else "premultiplied"
    space = spec.get_string_attribute("oiio:ColorSpace")
    if not space:
        space = "srgb_rec709_scene" if dtype.startswith("uint") else _linear_space(spec)
    return Header(
        height=height,
        width=width,
        channels=tuple(spec.channelnames),
        dtype=dtype,
        color_space=space,
        alpha=alpha,
        alpha_channel=alpha_channel if alpha_channel >= 0 else None,
        parts=part_names(source),
        window=window,
        orientation=orientation if 1 <= orientation <= 8 else 1,
        projection=_projection(spec, height, width),
        tilt=(_degrees(spec, "PosePitch"), _degrees(spec, "PoseRoll")),
        metadata=_metadata(spec),
    )


def upright(image: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Return an image as EXIF says that it is to be seen."""
    turned: dict[int, Callable[[NDArray[Any]], NDArray[Any]]] = {
        2: lambda x: x[:, ::-1],
        3: lambda x: x[::-1, ::-1],
        4: lambda x: x[::-1],
        5: lambda x: x.swapaxes(0, 1),
        6: lambda x: np.rot90(x, -1),
        7: lambda x: x[::-1, ::-1].swapaxes(0, 1),
        8: lambda x: np.rot90(x),
    }
    return np.ascontiguousarray(turned[orientation](image)) if orientation in turned else image


def _windows(spec: Any) -> tuple[tuple[int, int, int, int], tuple[int, int]]:
    """Return the data window in the display window, and the size of that."""
    if spec.tile_width and _environment(spec) == "cubeface":
        # Of such files OpenImageIO gives one face's size as that of the display window.
        return (0, 0, spec.height, spec.width), (spec.height, spec.width)
    top, left = spec.y - spec.full_y, spec.x - spec.full_x
    height, width = spec.full_height, spec.full_width
    whole, from_top = _panorama_side(spec, "Height", "Top", spec.height)
    across, from_left = _panorama_side(spec, "Width", "Left", spec.width)
    is_plain = (height, width) == (spec.height, spec.width)
    if is_plain and whole >= spec.height and across >= spec.width:
        top, left, height, width = from_top, from_left, whole, across
    return (top, left, top + spec.height, left + spec.width), (height, width)


def _panorama_side(spec: Any, side: str, edge: str, texels: int) -> tuple[int, int]:
    """Return how long a side of the panorama is that an image is a part of, and where that begins.

    Telephones make such parts. They are told in texels that the image had before it was resized.
    """
    before = int(spec.get_int_attribute(f"GPano:CroppedAreaImage{side}Pixels"))
    if before <= 0:
        before = texels

    def resized(length: int) -> int:
        return (2 * length * texels + before) // (2 * before)

    start = spec.get_int_attribute(f"GPano:CroppedArea{edge}Pixels")
    return resized(spec.get_int_attribute(f"GPano:FullPano{side}Pixels")), resized(start)


def _degrees(spec: Any, name: str) -> float:
    value = float(spec.get_float_attribute(f"GPano:{name}Degrees", 0.0))
    return value if math.isfinite(value) else 0.0


def _projection(spec: Any, height: int, width: int) -> str | None:
    own = spec.get_string_attribute(PROJECTION)
    if own:
        return str(own)
    environment = _environment(spec)
    if environment == "latlong":
        # The textures of maketx lie on texel centers, unless they say that they do not.
        is_of_corners = spec.get_int_attribute("oiio:sampleborder")
        return "latlong:openexr" if is_of_corners else "latlong:openimageio"
    if environment == "cubeface":
        return "cube:openexr"
    panorama = spec.get_string_attribute("GPano:ProjectionType").lower()
    if panorama == "cylindrical":
        # All around, with square pixels: the height says how far it reaches up and down.
        return f"cylindrical(aspect={Fraction(width, height)})"
    return "latlong" if panorama == "equirectangular" else None


def _linear_space(spec: Any) -> str:
    """Return the color space of linear light by its primaries: sRGB's where none are known."""
    said = spec.get("chromaticities")
    for name, primaries in _PRIMARIES.items():
        if said is not None and np.allclose(said, primaries, rtol=0, atol=1e-3):
            return name
    return "lin_rec709_scene"


def _environment(spec: Any) -> str:
    """Return the first word of what kind of texture a file is, as ``"latlong"``."""
    return str(spec.get_string_attribute("textureformat")).lower().partition(" ")[0]


def _metadata(spec: Any) -> dict[str, Any]:
    found = {a.name: a.value for a in spec.extra_attribs}
    traveling = {name: found[name] for name in (*TRAVELS, "ICCProfile") if name in found}
    # An empty text says nothing.
    return {name: x for name, x in traveling.items() if not isinstance(x, str) or x}
