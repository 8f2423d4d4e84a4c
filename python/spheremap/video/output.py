"""The file that is written: the encoder of its frames, what is copied beside them."""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from av.container import InputContainer
    from av.packet import Packet
    from av.stream import Stream

    AnyPacket: TypeAlias = Packet[Any]
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

__all__ = ["Output", "writing"]

# Encoders, of those that several can write.
_ENCODERS = {"h264": "libx264", "hevc": "libx265", "av1": "libsvtav1", "vp9": "libvpx-vp9"}
# Quality by which a second encoding is hardly seen, where nothing is said of it.
_QUALITY: dict[str, dict[str, str]] = {
    "libx264": {"crf": "18"},
    "libx265": {"crf": "20"},
    "libsvtav1": {"crf": "25"},
    "libvpx-vp9": {"crf": "24", "b": "0"},
}
_SAYS_QUALITY = {"crf", "qp", "b", "q", "global_quality"}
# They would write to the terminal what they do: one has an option against it, one a variable.
_QUIET = {"libx265": {"x265-params": "log-level=none"}}
_QUIET_BY = {"libsvtav1": ("SVT_LOG", "1")}


@contextmanager
def writing(name: str) -> Iterator[None]:
    """Turn PyAV's errors into those of a file that cannot be written."""
    from av.error import FFmpegError

    try:
        yield
    except FFmpegError as error:
        raise OSError(f"cannot write {name!r}: {error.strerror or error}") from None


class Output:
    """A video being written, and streams that go with it as they are.

    Parameters
    ----------
    place : Path
        Where to.
    name : str
        What errors call it.
    source : InputContainer
        Whose words are copied.
    video : VideoStream
        Of the source: times and speed are its own.
    copied : sequence of Stream
        What is copied beside it.
    codec : str or None
        The encoder; None for the source's codec.
    options : dict of str
        What the encoder is told.

    Raises
    ------
    ValueError
        For an unknown encoder, or one that the container does not hold.
    """

    def __init__(
        self,
        place: Path,
        name: str,
        source: InputContainer,
        video: VideoStream,
        copied: Sequence[Stream],
        codec: str | None,
        options: dict[str, str],
    ) -> None:
        import av

        self.name, self.frames = name, 0
        encoder = _encoder(codec, video)
        try:
            self.container = av.open(str(place), "w")
        except ValueError:
            raise ValueError(f"{name!r}: no kind of video has this ending") from None
        try:
            rate = video.average_rate or video.guessed_rate or Fraction(25)
            if codec is None and video.codec_context.name not in self.container.supported_codecs:
                encoder = self.container.default_video_codec
            self.video = self._added(encoder, rate, options)
            self.video.codec_context.time_base = _unit(encoder, video.time_base or 1 / rate, rate)
            self.copies = {stream.index: self._copied(stream) for stream in copied}
            self.container.metadata.update(_words(source))
        except BaseException:
            self.abandon()
            raise

    def _added(self, encoder: str, rate: Fraction, options: dict[str, str]) -> VideoStream:
        told = {**_QUIET.get(encoder, {})}
        if encoder in _QUIET_BY:
            os.environ.setdefault(*_QUIET_BY[encoder])
        if not _SAYS_QUALITY & set(options):
            told |= _QUALITY.get(encoder, {})
        try:
            stream: Any = self.container.add_stream(encoder, rate, options=told | options)
        except ValueError as error:
            raise ValueError(f"{self.name!r}: the {error}") from None
        context = stream.codec_context
        context.thread_type = "AUTO"
        listed = context.supported_options
        known = {option.name for option in (*listed.generic, *listed.private)}
        for key in options:
            # It would be passed over in silence.
            if key not in known:
                raise ValueError(f"encoder {encoder!r} has no option {key!r} (`options`)")
        return stream  # type: ignore[no-any-return]

    def _copied(self, stream: Stream) -> Stream | None:
        """Return the copy of a stream; None for subtitles that the container does not hold."""
        codec = stream.codec_context.codec.canonical_name if stream.codec_context else "data"
        try:
            copy = self.container.add_stream_from_template(stream, opaque=True)
        except ValueError:
            if stream.type != "audio":
                return None
            raise ValueError(
                f"{self.name!r} cannot hold the audio as it is ({codec}): write .mkv or .mov, or "
                "no audio"
            ) from None
        copy.metadata.update(stream.metadata)
        return copy

    def chosen(self, formats: Sequence[str]) -> str:
        """Return the first of these pixel formats that the encoder takes; ValueError for none."""
        context = self.video.codec_context
        known = [found.name for found in context.codec.video_formats or ()]
        pixel_format = next((name for name in formats if name in known or not known), None)
        if pixel_format is None:
            raise ValueError(
                f"encoder {context.name!r} takes no {formats[0]!r}; give `pixel_format`, as one of "
                f"{', '.join(known[:12])}"
            )
        return pixel_format

    def prepare(self, colors: VideoFrame, shape: tuple[int, int], pixel_format: str) -> None:
        """Tell the encoder of frames with the colors of one; ValueError where it takes none."""
        from av.error import FFmpegError

        context = self.video.codec_context
        context.height, context.width = shape
        context.pix_fmt = pixel_format
        for name in ("color_range", "colorspace", "color_primaries", "color_trc"):
            value = getattr(colors, name)
            if value is not None:
                setattr(context, name, value)
        told = dict(context.options)
        try:
            context.open(strict=False)
        except FFmpegError as error:
            raise ValueError(
                f"Expected `size`, `pixel_format` and `options` to be what encoder "
                f"{context.name!r} takes, got {shape[1]} x {shape[0]}, {pixel_format!r} and "
                f"{told} ({error.strerror})."
            ) from None

    def write(self, frame: VideoFrame | None, packets: Sequence[AnyPacket]) -> None:
        """Write packets of streams that are copied, and a frame."""
        for packet in packets:
            copy = self.copies.get(packet.stream_index)
            if copy is not None:
                packet.stream = copy
                self.container.mux(packet)
        if frame is not None:
            self.container.mux(self.video.encode(frame))
            self.frames += 1

    def finish(self) -> None:
        """Write what the encoder still holds, and the index."""
        self.container.mux(self.video.encode(None))
        self.container.close()

    def abandon(self) -> None:
        """Let go of a file that will not be kept."""
        with suppress(Exception):
            self.container.close()


def _encoder(codec: str | None, video: VideoStream) -> str:
    from av.codec import Codec

    wanted = codec if codec is not None else video.codec_context.codec.canonical_name
    wanted = _ENCODERS.get(wanted, wanted)
    try:
        found = Codec(wanted, "w")
    except ValueError:
        if codec is not None:
            raise ValueError(f"unknown `codec` {codec!r}: PyAV has no such encoder") from None
        return "libx264"
    if found.type != "video":
        raise ValueError(f"`codec` {codec!r} is none of video")
    return found.name


def _unit(encoder: str, unit: Fraction, rate: Fraction) -> Fraction:
    """Return in which unit an encoder counts time: the source's, but where it can only frames."""
    by_frames = encoder in ("mpeg1video", "mpeg2video")
    return 1 / rate if by_frames or (encoder == "mpeg4" and unit.denominator > 65535) else unit


def _words(source: InputContainer) -> dict[str, str]:
    # What says how the file was written is not so of this one.
    own = {"major_brand", "minor_version", "compatible_brands", "encoder"}
    return {key: value for key, value in source.metadata.items() if key.lower() not in own}
