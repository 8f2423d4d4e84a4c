"""The conversion of a frame: a plan for planes of each size, made once."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..resample.plans import RemapPlan, remap_plan
from .planes import Plane, described, views
from .siting import cells, moved, offset, spread, turn

if TYPE_CHECKING:
    from av.video.format import VideoFormat
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

    from .._projection import Projection

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
    plane : Plane
        What each holds.
    plan : RemapPlan
        From texels at (i + ½)/n to texels at (i + ½)/n of the maps that it names.
    before, after : (float, float) or None
        Where texels of the source have to be fetched for that, and those of the result, in texels.
    spread : (float, float) or None
        Given, the plan is of luma's size: chroma of the source, which lies there, becomes as
        large, and each texel of the result is the first of those that it stands for.
    """

    plane: Plane
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
            return spread(image, self.plane, self.spread, faces)
        return image if self.before is None else moved(image, self.before, faces, self.plane.top)

    def _put(self, result: NDArray[Any], out: NDArray[Any]) -> None:
        top = self.plane.top
        if self.spread is not None:
            result = result[:: self.plane.down, :: self.plane.across]
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
    pixel_format : VideoFormat
        Of the frames, with their size; planar.
    color_range : int
        As PyAV numbers it: what black is follows from it.
    src, dst : Projection
        Each a flat picture.
    shape : (int, int)
        Height and width of the result.
    siting : str
        Where chroma lies, in both.
    options : dict
        What else `remap_plan` takes.

    Raises
    ------
    ValueError
        For a size whose halves are no whole numbers where chroma is half as wide or high.
    """

    def __init__(
        self,
        pixel_format: VideoFormat,
        color_range: int,
        src: Projection,
        dst: Projection,
        shape: tuple[int, int],
        siting: str,
        options: dict[str, Any],
    ) -> None:
        self.name, self.shape = pixel_format.name, shape
        self._spare: deque[VideoFrame] = deque()
        self.planes = described(pixel_format, color_range)
        self.source_shape = pixel_format.height, pixel_format.width
        for what, sides in (("frames", self.source_shape), ("`size`", shape)):
            _expect_whole(what, sides, self.planes, self.name)
        siting = "center" if options["filter"] == "nearest" else siting
        groups: dict[tuple[int, int], list[int]] = {}
        for k, plane in enumerate(self.planes):
            groups.setdefault((plane.across, plane.down), []).append(k)
        self.conversions = [
            (group, self._of([self.planes[k] for k in group], src, dst, siting, options))
            for group in groups.values()
        ]

    def _of(
        self,
        planes: list[Plane],
        src: Projection,
        dst: Projection,
        siting: str,
        options: dict[str, Any],
    ) -> PlanesConversion:
        plane, *others = planes
        black = [each.black for each in planes]
        # Of the third channel of two planes nothing is kept.
        options = options | {"fill": [*black, *[0.0] * (3 - len(planes))] if others else black[0]}
        at = offset(plane, siting)
        if plane.across != plane.down and (src.layout or dst.layout):
            # Faces are squares: those of such chroma are none.
            options |= {"source_shape": self.source_shape, "size": self.shape}
            first = (1 / plane.across - 1) / 2, (1 / plane.down - 1) / 2
            rest = at[0] - first[0], at[1] - first[1]
            plan = remap_plan(src, dst, **options)
            return PlanesConversion(plane, plan, None, rest if any(rest) else None, at)
        source, target = (
            (sides[0] // plane.down, sides[1] // plane.across)
            for sides in (self.source_shape, self.shape)
        )
        # Luma has the aspect of the map; half as wide is as right.
        options |= {"source_shape": source, "size": target, "any_aspect": True}
        src, before = _sited(src, source, at)
        dst, after = _sited(dst, target, at)
        if before is not None:
            before = -before[0], -before[1]
        return PlanesConversion(plane, remap_plan(src, dst, **options), before, after)

    def __call__(
        self, frame: VideoFrame, rotation: NDArray[np.float64] | None = None
    ) -> VideoFrame:
        """Return a frame's conversion: its colors, its time."""
        result = self.blank(frame)
        images, outs = views(frame, self.planes), views(result, self.planes)
        for group, convert in self.conversions:
            convert([images[k] for k in group], [outs[k] for k in group], rotation)
        return result

    def blank(self, frame: VideoFrame) -> VideoFrame:
        """Return a frame for the conversion of one: with its colors and its time, nothing in it."""
        import av

        held = frame.height, frame.width, frame.format.name
        if held != (*self.source_shape, self.name):
            raise ValueError(
                f"Expected all frames to be {self.source_shape[1]} x {self.source_shape[0]} of "
                f"{self.name!r}, got {held[1]} x {held[0]} of {held[2]!r}."
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


def _expect_whole(what: str, sides: tuple[int, int], planes: tuple[Plane, ...], name: str) -> None:
    down, across = max(p.down for p in planes), max(p.across for p in planes)
    if sides[0] % down or sides[1] % across:
        parts = [f"a width that {across} divides"] * (across > 1)
        parts += [f"a height that {down} divides"] * (down > 1)
        raise ValueError(
            f"Expected {what} of pixel format {name!r} to have {' and '.join(parts)}, "
            f"got {sides[1]} x {sides[0]}."
        )
