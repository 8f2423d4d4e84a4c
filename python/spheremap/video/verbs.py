"""Videos from one map to another."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._scalars import as_flag, as_text
from ..io.whole import as_path, check_place, written_whole
from ..map.named import resolve
from .frames import FrameConversion
from .job import Job, Source
from .library import opened, require
from .maps import size_of, source_of, target_of
from .metadata import CONTAINERS, METADATA, expect_one_eye, no_word_for, said, say
from .output import Output
from .planes import between, ratio
from .siting import SITINGS, usual

if TYPE_CHECKING:
    from .._arrays import Size
    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds
    from .metadata import Metadata
    from .siting import Siting

__all__ = ["Converted", "convert"]


@dataclass(frozen=True)
class Converted:
    """What `convert` wrote.

    Attributes
    ----------
    src, dst : Projection
        The maps of the frames, as pictures: with their layouts.
    shape : (int, int)
        Height and width of the frames.
    frames : int
        How many were written.
    codec, pixel_format : str
        How.
    metadata : {"both", "v1", "v2", "none"}
        By which notations the file says its map.
    """

    src: Projection
    dst: Projection
    shape: tuple[int, int]
    frames: int
    codec: str
    pixel_format: str
    metadata: str


def convert(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    /,
    src: ProjectionLike | None,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    rotation: Any | Callable[[float], Any] | None = None,
    filter: ConvertFilter | str = "bilinear",
    antialias: bool = True,
    world: Worlds = "match",
    any_aspect: bool = False,
    codec: str | None = None,
    pixel_format: str | None = None,
    options: Mapping[str, str] | None = None,
    siting: Siting | None = None,
    audio: bool = True,
    metadata: Metadata | None = None,
) -> Converted:
    """Turn a video from one projection into another.

    Parameters
    ----------
    source, target : str or path
        The file to read, and the one to write; its ending says the container. It appears when it
        is whole.
    src : Projection or str or None
        The projection of the frames; None for what the file says, see `projection`. Of several
        faces, as ``"dual_fisheye(fov=190)"``, the layout that fits the frames.
    dst : Projection or str
        The projection of the result. Several faces lie as a cross or a strip, unless it says how.
    size : int or tuple of int, optional
        As for `spheremap.convert`.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, or callable, optional
        Turns the content in the world of `src`. What is called with the seconds from the first
        frame gives a rotation for each frame: `Keyframes`, or scipy's ``Slerp``.
    filter, antialias, world, any_aspect
        As for `spheremap.convert`.
    codec : str, optional
        The name of an encoder of FFmpeg, as ``"libx265"`` or ``"ffv1"``. By default that of the
        source, where the container holds it.
    pixel_format : str, optional
        How the result keeps its colors, as ``"yuv420p10le"``. By default as the source. Chroma of
        another size lies as it is sited in each.
    options : mapping of str to str, optional
        What the encoder is told, as ``{"crf": "23", "preset": "fast"}``. x264, x265, VP9 and AV1
        have a quality at which a loss is hardly seen, where it says nothing of quality.
    siting : {"left", "center", "top-left"}, optional
        Where texels of chroma lie among those of luma that they stand for, in both files. By
        default in each by its own format: left, and center in JPEG's and MPEG-1.
    audio : bool
        Whether audio and subtitles are copied, bit for bit.
    metadata : {"both", "v1", "v2", "none"}, optional
        By which notations .mp4 and .mov say that frames are panoramas: the box of XML, those of the
        second version. By default both where `dst` is a latlong.

    Returns
    -------
    converted : Converted
        What was written.

    Raises
    ------
    OSError
        Where a file cannot be read or written.
    ValueError, TypeError
        As for `spheremap.convert`; for a file without a video, one that says that it is of two
        eyes or shown turned by no quarter turn, a map that the file does not say, an unknown
        encoder or what it does not take, sides that are odd where chroma is half as wide or high.
    ImportError
        Without PyAV: ``pip install spheremap[video]``.
    KeyboardInterrupt
        After Ctrl-C: what was converted until then is a whole file, at its place.

    Notes
    -----
    Each plane is converted as it is stored, with its own plan: Y' as wide as the frame, Cb and Cr
    as they are sited, of 8 to 16 bits. Frames keep their times. Decoding, conversion and encoding
    run at the same time. What is converted are frames as they are shown: turned and mirrored as
    the file says.

    Where chroma is not sited in the center of what it stands for, the plan's latlong or cylinder is
    turned by that much, which is exact; planes of other maps are moved by four taps. The filter
    ``"nearest"`` mixes nothing, and takes chroma as if it were centered.

    Examples
    --------
    >>> import av, numpy as np, spheremap as sm, tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> with av.open(str(folder / "sky.mkv"), "w") as file:
    ...     stream = file.add_stream("ffv1", rate=25, width=128, height=64)
    ...     for shade in (20, 90, 200):
    ...         frame = av.VideoFrame.from_ndarray(np.full((64, 128, 3), shade, np.uint8))
    ...         file.mux(stream.encode(frame.reformat(format="yuv420p")))
    ...     file.mux(stream.encode(None))
    >>> done = sm.video.convert(folder / "sky.mkv", folder / "cube.mkv", "latlong", "cube", size=16)
    >>> done.frames, done.shape, done.codec
    (3, (48, 64), 'ffv1')
    """
    name, goal = as_path(source), as_path(target)
    _check_words(siting=(siting, SITINGS), metadata=(metadata, METADATA))
    for flag, value in (("any_aspect", any_aspect), ("antialias", antialias), ("audio", audio)):
        as_flag(value, flag)
    for word, given in (("codec", codec), ("pixel_format", pixel_format)):
        if given is not None:
            as_text(given, word)
    told = _told(options)
    flat = target_of(dst)
    if src is not None:
        resolve(src)
    require()
    place = Path(os.path.realpath(goal))
    check_place(place, goal)
    notation = _notation(metadata, flat, place)
    over_time = rotation if callable(rotation) and not hasattr(rotation, "as_matrix") else None

    with opened(source) as container, Source(container, name, audio) as read:
        expect_one_eye(read.first, name)
        own = said(read.first, name) if src is None else src
        if own is None:
            raise ValueError(f"{name!r} does not say its projection: `src` is needed")
        map_ = source_of(own, read.shape, any_aspect)

        how = {"filter": filter, "antialias": antialias, "world": world, "any_aspect": any_aspect}

        def conversion(wanted: str, encoder: str) -> FrameConversion:
            stored = read.first.format.name
            sitings = usual(stored, read.video.codec_context.name), usual(wanted, encoder)
            formats = between(stored, wanted)
            parts = ratio(formats[1])[::-1]
            return FrameConversion(
                read.first,
                formats,
                read.display,
                map_ if over_time else resolve(map_, rotation=rotation),
                flat,
                size_of(size, read.shape, map_, flat, parts, any_aspect),
                sitings if siting is None else (siting, siting),
                how,
            )

        job = Job(read, conversion, over_time, pixel_format)

        def write(beside: Path) -> None:
            job.run(Output(beside, goal, container, read.video, read.copied, codec, told))
            if notation != "none":
                say(beside, notation)

        written_whole(place, write)
    if job.interrupted:
        raise KeyboardInterrupt
    return Converted(map_, flat, job.shape, job.frames, job.codec, job.pixel_format, notation)


def _check_words(**given: tuple[str | None, tuple[str, ...]]) -> None:
    for name, (value, words) in given.items():
        if value is not None and as_text(value, name) not in words:
            wanted = ", ".join(map(repr, words))
            raise ValueError(f"Expected `{name}` to be one of {wanted}, got {value!r}.")


def _told(options: Mapping[str, str] | None) -> dict[str, str]:
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise TypeError(f"Expected `options` to be a mapping, got {type(options).__name__}.")
    return {as_text(key, "options"): str(value) for key, value in options.items()}


def _notation(metadata: str | None, dst: Projection, place: Path) -> str:
    holds, lack = place.suffix.lower() in CONTAINERS, no_word_for(dst)
    if metadata is None:
        return "both" if holds and lack is None else "none"
    if metadata != "none" and lack is not None:
        raise ValueError(
            f"Expected `metadata` to be 'none' for {str(dst)!r}, {lack}, got {metadata!r}."
        )
    if metadata != "none" and not holds:
        raise ValueError(f"`metadata` is written into {', '.join(CONTAINERS)} alone")
    return metadata
