"""The conversion of a frame: a plan for planes of each size, made once."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..resample.plans import RemapPlan, remap_plan
from .planes import Plane, described, reformatted, views
from .siting import cells, gathered, moved, offset, spread, turn

if TYPE_CHECKING:
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

    from .._projection import Projection
    from .display import Display

__all__ = ["FrameConversion"]

Shift = tuple[float, float]
# How many written frames an encoder may look at still.
_KEPT = 2


@dataclass(frozen=True)
class PlanesConversion:
    """The conversion of planes of one size, whose texels lie in the same places.

    The core computes where they lie once for all channels of an image: several planes are put into
    one and taken out of it.

    Attributes
    ----------
    source, target : Plane
        What each holds, and its result.
    plan : RemapPlan
        From texels at (i + ½)/n to texels at (i + ½)/n of the maps that it names.
    before, after : (float, float) or None
        Where texels of the source have to be fetched for that, and those of the result, in texels.
    spread : (float, float) or None
        Given, the plan is of luma's size: chroma of the source, which lies there, becomes as
        large, and each texel of the result is the first of those that it stands for; their mean
        where the source has more.
    """

    source: Plane
    target: Plane
    plan: RemapPlan
    before: Shift | None
    after: Shift | None
    spread: Shift | None = None

    def __call__(
        self,
        images: list[NDArray[Any]],
        outs: list[NDArray[Any]],
        rotation: NDArray[np.float64] | None,
    ) -> None:
        """Convert planes into others."""
        plan = self.plan
        if rotation is not None:
            plan = replace(plan, src=plan.src.turned(rotation))
        sited = [self._fetched(image) for image in images]
        is_as_stored = self.after is None and self.spread is None
        if len(images) > 1:
            results = plan(_stacked(sited))
            found = [results[..., k] for k in range(len(outs))]
        elif is_as_stored and outs[0].flags.c_contiguous:
            found = [plan(sited[0], out=outs[0])]
        else:
            found = [plan(sited[0])]
        for result, out in zip(found, outs, strict=True):
            self._put(result, out)

    def _fetched(self, image: NDArray[Any]) -> NDArray[Any]:
        faces = cells(self.plan.src)
        if self.spread is not None:
            return spread(image, self.source, self.spread, faces)
        return image if self.before is None else moved(image, self.before, faces, self.source.top)

    def _put(self, result: NDArray[Any], out: NDArray[Any]) -> None:
        top = self.target.top
        if self.spread is not None:
            result = gathered(result, self.target, _is_coarser(self.target, self.source))
        if self.after is not None:
            result = moved(result, self.after, cells(self.plan.dst), top)
        if top is not None and top < np.iinfo(out.dtype).max:
            # Filters that ring leave the ten bits of sixteen.
            np.minimum(result, top, out=out)
        elif result is not out:
            out[...] = result


def _stacked(images: list[NDArray[Any]]) -> NDArray[Any]:
    """Return planes as channels; two as three, of which the core has a faster loop."""
    channels = max(len(images), 3)
    together = np.zeros((*images[0].shape, channels), images[0].dtype)
    for k, image in enumerate(images):
        together[..., k] = image
    return together


class FrameConversion:
    """The conversion of frames of one format and size.

    Parameters
    ----------
    first : VideoFrame
        The others are as it is.
    formats : (str, str)
        What of frames is read, and what is made of it; see `between`.
    display : Display
        How frames are shown: what is shown is converted.
    src, dst : Projection
        Each a flat picture.
    shape : (int, int)
        Height and width of the result.
    sitings : (str, str)
        Where chroma lies in frames, and in the result.
    options : dict
        What else `remap_plan` takes.

    Raises
    ------
    ValueError
        For a size whose halves are no whole numbers where chroma is half as wide or high.
    """

    def __init__(
        self,
        first: VideoFrame,
        formats: tuple[str, str],
        display: Display,
        src: Projection,
        dst: Projection,
        shape: tuple[int, int],
        sitings: tuple[str, str],
        options: dict[str, Any],
    ) -> None:
        from av import VideoFormat

        read, self.name = formats
        self.shape, self._display = shape, display
        stored = first.height, first.width
        self._held = *stored, read
        self._spare: deque[VideoFrame] = deque()
        color_range = int(self.readable(first).color_range or 0)
        self.read = described(VideoFormat(read), color_range)
        self.planes = described(VideoFormat(self.name), color_range)
        _expect_whole("frames", stored, self.read, read)
        _expect_whole("`size`", shape, self.planes, self.name)
        self.source_shape = display.shape(stored)
        sitings = ("center", "center") if options["filter"] == "nearest" else sitings
        groups: dict[tuple[int, ...], list[int]] = {}
        for k, (plane, result) in enumerate(zip(self.read, self.planes, strict=True)):
            groups.setdefault((plane.across, plane.down, result.across, result.down), []).append(k)
        self.conversions = [
            (group, self._of(group, src, dst, sitings, options)) for group in groups.values()
        ]

    def _of(
        self,
        group: list[int],
        src: Projection,
        dst: Projection,
        sitings: tuple[str, str],
        options: dict[str, Any],
    ) -> PlanesConversion:
        stored, result = self.read[group[0]], self.planes[group[0]]
        plane = self._display.plane(stored)
        black = [self.planes[k].black for k in group]
        # Of the third channel of two planes nothing is kept.
        fill = [*black, *[0.0] * (3 - len(black))] if len(black) > 1 else black[0]
        options = options | {"fill": fill}
        at, goal = self._display.at(offset(stored, sitings[0])), offset(result, sitings[1])
        is_coarser = _is_coarser(result, plane)
        are_squares = plane.across == plane.down and result.across == result.down
        if not are_squares and (src.layout or dst.layout):
            # Faces are squares: those of such chroma are none.
            options |= {"source_shape": self.source_shape, "size": self.shape}
            if not is_coarser:
                first = (1 / result.across - 1) / 2, (1 / result.down - 1) / 2
                goal = goal[0] - first[0], goal[1] - first[1]
            plan = remap_plan(src, dst, **options)
            return PlanesConversion(plane, result, plan, None, goal if any(goal) else None, at)
        source, target = (
            (sides[0] // each.down, sides[1] // each.across)
            for sides, each in ((self.source_shape, plane), (self.shape, result))
        )
        # Luma has the aspect of the map; half as wide is as right. Chroma that loses texels has
        # patterns finer than those that are left.
        options |= {"source_shape": source, "size": target, "any_aspect": True}
        options["antialias"] |= is_coarser
        src, before = _sited(src, source, at)
        dst, after = _sited(dst, target, goal)
        if before is not None:
            before = -before[0], -before[1]
        return PlanesConversion(plane, result, remap_plan(src, dst, **options), before, after)

    def __call__(
        self, frame: VideoFrame, rotation: NDArray[np.float64] | None = None
    ) -> VideoFrame:
        """Return a frame's conversion: its colors, its time."""
        result = self.blank(frame)
        images = [self._display.picture(plane) for plane in views(frame, self.read)]
        outs = views(result, self.planes)
        for group, convert in self.conversions:
            convert([images[k] for k in group], [outs[k] for k in group], rotation)
        return result

    def readable(self, frame: VideoFrame) -> VideoFrame:
        """Return a frame of the format that is read: each kind of numbers is a plane of its own."""
        return reformatted(frame, self._held[2])

    def blank(self, frame: VideoFrame) -> VideoFrame:
        """Return a frame for the conversion of one: with its colors and its time, nothing in it."""
        import av

        held, wanted = (frame.height, frame.width, frame.format.name), self._held
        if held != wanted:
            raise ValueError(
                f"Expected all frames to be {wanted[1]} x {wanted[0]} of {wanted[2]!r}, "
                f"got {held[1]} x {held[0]} of {held[2]!r}."
            )
        if len(self._spare) > _KEPT:
            result = self._spare.popleft()
            # An encoder may look at it yet; then it is copied.
            result.make_writable()
        else:
            result = av.VideoFrame(self.shape[1], self.shape[0], self.name)
        for name in ("pts", "time_base", "duration", "color_range", "colorspace",
                     "color_primaries", "color_trc"):  # fmt: skip
            value = getattr(frame, name)
            if value is not None:
                setattr(result, name, value)
        return result

    def take_back(self, frame: VideoFrame) -> None:
        """Take a frame that was made here and is written: its memory serves another.

        New memory costs a quarter of a conversion: the system clears each of its pages.
        """
        if frame.format.name == self.name:
            self._spare.append(frame)


def _sited(p: Projection, shape: tuple[int, int], at: Shift) -> tuple[Projection, Shift | None]:
    """Return the map of chroma at an offset, and what of the offset no map has."""
    if not any(at) or p.grid != "centers":
        return p, None
    turned = turn(p, shape, (at[0], 0.0))
    rest = at if turned is None else (0.0, at[1])
    return p if turned is None else p.turned(turned), rest if any(rest) else None


def _is_coarser(plane: Plane, other: Plane) -> bool:
    return plane.across > other.across or plane.down > other.down


def _expect_whole(what: str, sides: tuple[int, int], planes: tuple[Plane, ...], name: str) -> None:
    down, across = max(p.down for p in planes), max(p.across for p in planes)
    if sides[0] % down or sides[1] % across:
        parts = [f"a width that is a multiple of {across}"] * (across > 1)
        parts += [f"a height that is a multiple of {down}"] * (down > 1)
        raise ValueError(
            f"Expected {what} to have {' and '.join(parts)}, for pixel format {name!r}, "
            f"got {sides[1]} x {sides[0]}."
        )
