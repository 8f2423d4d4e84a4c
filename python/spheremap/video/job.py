"""The way of all frames of a video: read, converted, written, at the same time."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import nullcontext
from fractions import Fraction
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._progress import part
from ..map.named import resolve
from .display import display
from .library import reading
from .output import writing
from .pipeline import overlap
from .planes import planar, reformatted

if TYPE_CHECKING:
    from types import TracebackType

    from av.container import InputContainer
    from av.stream import Stream
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

    from .frames import FrameConversion
    from .output import AnyPacket, Output

__all__ = ["Job", "Source"]


class Item(NamedTuple):
    """A frame, and what the file holds before it of streams that are copied."""

    frame: VideoFrame | None
    packets: tuple[AnyPacket, ...]


class Source:
    """The frames of a video, and its other streams.

    Parameters
    ----------
    container : InputContainer
        Open.
    name : str
        What errors call it.
    audio : bool
        Whether other streams are wanted.

    Raises
    ------
    OSError
        Where it cannot be decoded.
    ValueError
        Where it has no frame, or one that is shown turned by no quarter turn.
    """

    def __init__(self, container: InputContainer, name: str, audio: bool) -> None:
        self._container, self._name = container, name
        self.video = container.streams.video[0]
        self.video.thread_type = "AUTO"
        kinds = ("audio", "subtitle") if audio else ()
        self.copied: list[Stream] = [s for s in container.streams if s.type in kinds]
        self.rate = self.video.average_rate or self.video.guessed_rate or Fraction(25)
        self._items = self._decoded()
        self._begun = next(self._items)
        if self._begun.frame is None:
            raise ValueError(f"{name!r} has no frame")
        self.first: VideoFrame = self._begun.frame
        self.display = display(self.first, name)

    def __enter__(self) -> Source:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._items.close()

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of frames as they are shown."""
        return self.display.shape((self.first.height, self.first.width))

    @property
    def total(self) -> int:
        """About how many frames there are; 0 where the file does not say."""
        seconds = (self._container.duration or 0) / 1_000_000
        return self.video.frames or round(seconds * self.rate)

    def items(self) -> chain[Item]:
        """Return frames, and packets of streams to copy, in the order of the file; once."""
        return chain([self._begun], self._items)

    def _decoded(self) -> Generator[Item, None, None]:
        waiting: list[AnyPacket] = []
        with reading(self._name):
            for packet in self._container.demux(self.video, *self.copied):
                if packet.stream_index != self.video.index:
                    if packet.dts is not None:
                        waiting.append(packet)
                    continue
                for frame in packet.decode():
                    yield Item(frame, tuple(waiting))  # type: ignore[arg-type]
                    waiting.clear()
        yield Item(None, tuple(waiting))


class Job:
    """The conversion of one video.

    Parameters
    ----------
    source : Source
        What is read.
    conversion : callable
        Gets the pixel format and the codec that are written, and returns the conversion of frames.
    rotation : callable or None
        Gets seconds from the first frame, and returns how it is turned.
    pixel_format : str or None
        As asked for.

    Attributes
    ----------
    frames : int
        How many were written.
    shape : (int, int)
        Their height and width.
    codec, pixel_format : str
        How.
    interrupted : bool
        Whether Ctrl-C ended it before there were no more.
    """

    def __init__(
        self,
        source: Source,
        conversion: Callable[[str, str], FrameConversion],
        rotation: Callable[[float], Any] | None,
        pixel_format: str | None,
    ) -> None:
        self._source, self._conversion, self._rotation = source, conversion, rotation
        own = source.first.format.name
        self._wanted = (planar(own), own) if pixel_format is None else (pixel_format,)
        self._begun = 0
        self.shape = source.shape
        self.frames, self.interrupted = 0, False
        self.codec = self.pixel_format = ""

    def run(self, output: Output) -> None:
        """Convert and write frames until there are no more, or Ctrl-C ends it.

        The file is whole then, and can be played; after an error it is not.
        """
        try:
            self.codec = output.video.codec_context.codec.name
            self.pixel_format = output.chosen(self._wanted)
            conversion = self._conversion(self.pixel_format, self.codec)
            self.shape = conversion.shape
            colors = reformatted(conversion.readable(self._source.first), self.pixel_format)
            output.prepare(colors, self.shape, self.pixel_format)

            def convert(item: Item) -> Item:
                return self._converted(item, conversion)

            def take(item: Item) -> None:
                with writing(output.name):
                    output.write(item.frame, item.packets)
                if item.frame is not None:
                    conversion.take_back(item.frame)

            try:
                overlap(self._source.items(), convert, take)
            except KeyboardInterrupt:
                if not output.frames:
                    raise
                self.interrupted = True
            with writing(output.name):
                output.finish()
            self.frames = output.frames
        except BaseException:
            output.abandon()
            raise

    def _converted(self, item: Item, conversion: FrameConversion) -> Item:
        if item.frame is None:
            return item
        frame, total = conversion.readable(item.frame), self._source.total
        k, self._begun = self._begun, self._begun + 1
        if frame.pts is None:
            # A stream without a container has no times.
            frame.pts, frame.time_base = k, 1 / self._source.rate
        with part(min(k / total, 1), min((k + 1) / total, 1)) if total else nullcontext():
            result = conversion(frame, self._turned(frame))
        return Item(reformatted(result, self.pixel_format), item.packets)

    def _turned(self, frame: VideoFrame) -> NDArray[np.float64] | None:
        if self._rotation is None:
            return None
        given = self._rotation((frame.time or 0.0) - (self._source.first.time or 0.0))
        # As every function takes a rotation, and checks it.
        pose = resolve("latlong", rotation=given).pose
        return None if pose is None else np.asarray(pose)
