"""What files say of how their frames map the sphere.

There are two notations, both Google's [1]_: the first writes XML into a box of its own, the second
boxes into the description of samples. FFmpeg reads both, and Matroska's, and hands them on with
frames, so that reading is the same for all. Of what PyAV encodes it writes none: PyAV has no way to
say it. So they are put into the finished file here.

.. [1] https://github.com/google/spatial-media/tree/master/docs
"""

from __future__ import annotations

import os
import struct
import uuid
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from ..io.whole import as_path
from ..map.named import projection as named
from .boxes import add, box, full_box
from .library import opened, reading

if TYPE_CHECKING:
    from av.video.frame import VideoFrame

    from .._projection import Projection

__all__ = ["CONTAINERS", "METADATA", "Metadata", "can_say", "projection", "said", "say"]

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
            return said(frame, name)
    return None


def said(frame: VideoFrame, name: str) -> Projection | None:
    """Return the map that a frame of a file says it is of, or None; see `projection`."""
    mapping, stereo = _side_data(frame, "SPHERICAL"), _side_data(frame, "STEREO3D")
    if mapping is None:
        return None
    kind, yaw, pitch, roll, *bounds, _ = struct.unpack_from(_MAPPING, mapping)
    what = _PROJECTIONS[kind] if kind < len(_PROJECTIONS) else "unknown"
    eyes = struct.unpack_from("=i", stereo)[0] if stereo is not None else 0
    if eyes:
        way = _STEREO[eyes] if eyes < len(_STEREO) else "in another way"
        raise ValueError(f"{name!r} says that it is of two eyes, {way}: `src` is needed")
    if kind != 0 or any(bounds):
        raise ValueError(f"{name!r} says that it is {what}, which is not known: `src` is needed")
    if yaw or pitch or roll:
        angles = ", ".join(f"{angle / 65536:g}" for angle in (yaw, pitch, roll))
        raise ValueError(
            f"{name!r} says that it is turned by {angles}: `src` is needed, and `rotation`"
        )
    return named("latlong")


def _side_data(frame: VideoFrame, name: str) -> bytes | None:
    from av.sidedata.sidedata import Type

    try:
        found: Any = frame.side_data.get(getattr(Type, name))
    except ValueError:
        # Of what FFmpeg knows, PyAV has no word for some, and then none for the rest.
        return None
    return None if found is None else bytes(found)


def can_say(dst: Projection) -> bool:
    """Tell whether the notations have a word for a map: a whole latlong, not mirrored."""
    if dst.name != "latlong" or dst.grid != "centers":
        return False
    own = dst.in_world_of("latlong")
    corners = np.array([[0.5, 0.5], [0.75, 0.5], [0.5, 0.25]])
    ahead, right, up = own.decode(corners)
    # Right of what is in the middle, seen from inside; a picture that is turned is a panorama too.
    return bool(np.cross(ahead, up + 1e-3 * right) @ right > 0)


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
