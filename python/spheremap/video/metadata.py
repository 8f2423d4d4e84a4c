"""What files say of how their frames map the sphere.

There are two notations, both Google's [1]_: the first writes XML into a box of its own, the second
boxes into the description of samples. FFmpeg reads both, and Matroska's, and hands them on with
frames, so that reading is the same for all. Of what PyAV encodes it writes none: PyAV has no way to
say it. So they are put into the finished file here.

.. [1] https://github.com/google/spatial-media/tree/master/docs
"""

from __future__ import annotations

import os
import re
import struct
import uuid
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from ..io.whole import as_path
from ..map.named import projection as named
from .boxes import add, box, full_box, identified
from .library import opened, reading

if TYPE_CHECKING:
    from av.video.frame import VideoFrame

    from .._projection import Projection

__all__ = [
    "CONTAINERS",
    "METADATA",
    "Metadata",
    "expect_one_eye",
    "no_word_for",
    "projection",
    "said",
    "say",
    "side_data",
]

Metadata: TypeAlias = Literal["both", "v1", "v2", "none"]
METADATA = ("both", "v1", "v2", "none")
# Those whose boxes we write.
CONTAINERS = (".mp4", ".mov", ".m4v")

_V1 = uuid.UUID("ffcc8263-f855-4a93-8814-587a02521fdd")
_XML = """<?xml version="1.0"?>
<rdf:SphericalVideo
xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"
xmlns:GSpherical="http://ns.google.com/videos/1.0/spherical/">
<GSpherical:Spherical>true</GSpherical:Spherical>
<GSpherical:Stitched>true</GSpherical:Stitched>
<GSpherical:StitchingSoftware>spheremap</GSpherical:StitchingSoftware>
<GSpherical:ProjectionType>equirectangular</GSpherical:ProjectionType>
</rdf:SphericalVideo>
"""
# A word of the XML, and its number.
_WORD = re.compile(r"<GSpherical:(\w+)>\s*(\d+)")
# FFmpeg's AVSphericalMapping, its numbers of projections, and those of AVStereo3D's types.
_MAPPING = "=i3i5I"
_PROJECTIONS = (
    "equirectangular", "cubemap", "a part of an equirectangular", "half an equirectangular",
    "rectilinear", "fisheye",
)  # fmt: skip
_STEREO = ("2D", "side by side", "top and bottom", "frame by frame", "checkered",
           "side by side", "line by line", "column by column")  # fmt: skip


def projection(path: str | os.PathLike[str], /) -> Projection | None:
    """Return the map that a video says it is of.

    Parameters
    ----------
    path : str or path
        Of a video with spherical metadata, of the first or second version, or Matroska's.

    Returns
    -------
    projection : Projection or None
        A latlong; None where the file says nothing.

    Raises
    ------
    OSError
        Where the file cannot be read.
    ValueError
        For a file without a video, or that says what no map here is: a cube of version 2, whose
        faces may lie in any way, a part of a panorama, a tilted one, or two pictures for two eyes.
    ImportError
        Without PyAV: ``pip install spheremap[video]``.

    Examples
    --------
    >>> import av, numpy as np, spheremap as sm, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "gray.mkv"
    >>> with av.open(str(path), "w") as file:
    ...     stream = file.add_stream("ffv1", rate=25, width=128, height=64)
    ...     frame = av.VideoFrame.from_ndarray(np.full((64, 128, 3), 99, np.uint8))
    ...     file.mux([*stream.encode(frame.reformat(format="yuv420p")), *stream.encode(None)])
    >>> sm.video.projection(path) is None
    True
    """
    name = as_path(path)
    with opened(path) as container, reading(name):
        for frame in container.decode(video=0):
            expect_one_eye(frame, name)
            return said(frame, name)
    return None


def said(frame: VideoFrame, name: str) -> Projection | None:
    """Return the map that a frame of a file says it is of, or None; see `projection`."""
    mapping = side_data(frame, "SPHERICAL")
    if mapping is None:
        return None
    kind, yaw, pitch, roll, *bounds, _ = struct.unpack_from(_MAPPING, mapping)
    if kind == 0 and _is_cropped(name):
        # FFmpeg passes over these words of the first version.
        kind = _PROJECTIONS.index("a part of an equirectangular")
    what = _PROJECTIONS[kind] if kind < len(_PROJECTIONS) else "unknown"
    if kind != 0 or any(bounds):
        raise ValueError(f"{name!r} says that it is {what}, which is not known: `src` is needed")
    if yaw or pitch or roll:
        angles = ", ".join(f"{angle / 65536:g}" for angle in (yaw, pitch, roll))
        raise ValueError(
            f"{name!r} says that it is turned by {angles}: `src` is needed, and `rotation`"
        )
    return named("latlong")


def expect_one_eye(frame: VideoFrame, name: str) -> None:
    """Raise a ValueError where a file says that frames are pictures for two eyes."""
    stereo = side_data(frame, "STEREO3D")
    eyes = struct.unpack_from("=i", stereo)[0] if stereo is not None else 0
    # Of what lies in no known way, as the layers of HEVC, FFmpeg decodes one eye.
    if 0 < eyes < len(_STEREO):
        raise ValueError(
            f"{name!r} says that it is of two eyes, {_STEREO[eyes]}, which is not supported: "
            "convert a file of each"
        )


def _is_cropped(name: str) -> bool:
    """Tell whether XML of the first version says that frames are a part of a panorama."""
    text = identified(name, _V1.bytes).decode(errors="replace")
    words = {key: int(number) for key, number in _WORD.findall(text)}
    for side, edge in (("Width", "Left"), ("Height", "Top")):
        whole = words.get(f"FullPano{side}Pixels")
        # Where it does not say how large a part it is of, it is all of it.
        part = words.get(f"CroppedAreaImage{side}Pixels", whole)
        if words.get(f"CroppedArea{edge}Pixels") or (whole is not None and part != whole):
            return True
    return False


def side_data(frame: VideoFrame, name: str) -> bytes | None:
    """Return what comes with a frame, by PyAV's name; None where nothing of it does."""
    from av.sidedata.sidedata import Type

    try:
        found: Any = frame.side_data.get(getattr(Type, name))
    except ValueError:
        # Of what FFmpeg knows, PyAV has no word for some, and then none for the rest.
        return None
    return None if found is None else bytes(found)


def no_word_for(dst: Projection) -> str | None:
    """Return why the notations have no word for a map; None for a whole latlong, not mirrored."""
    if dst.name != "latlong":
        return "which is no latlong"
    if dst.grid != "centers":
        return f"whose grid is {dst.grid!r} and not 'centers'"
    own = dst.in_world_of("latlong")
    corners = np.array([[0.5, 0.5], [0.75, 0.5], [0.5, 0.25]])
    ahead, right, up = own.decode(corners)
    # Right of what is in the middle, seen from inside; a picture that is turned is a panorama too.
    is_mirrored = np.cross(ahead, up + 1e-3 * right) @ right <= 0
    return "which is mirrored" if is_mirrored else None


def say(path: Path, metadata: str) -> None:
    """Write into a finished file that its frames are whole panoramas, by one notation or both."""
    v1 = v2 = b""
    if metadata in ("both", "v1"):
        v1 = box(b"uuid", _V1.bytes, _XML.encode())
    if metadata in ("both", "v2"):
        v2 = full_box(b"st3d", bytes(1)) + box(
            b"sv3d",
            full_box(b"svhd", b"spheremap\0"),
            # Not turned, and nothing cut off.
            box(b"proj", full_box(b"prhd", bytes(12)), full_box(b"equi", bytes(16))),
        )
    if v1 or v2:
        add(path, v1, v2)
