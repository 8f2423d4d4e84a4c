"""The conversion of a frame: a plan for each plane, made once."""

from __future__ import annotations

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


@dataclass(frozen=True)
class PlaneConversion:
    """The conversion of one plane.

    Attributes
    ----------
    plane : Plane
        What it holds.
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
        self, image: NDArray[Any], out: NDArray[Any], rotation: NDArray[np.float64] | None
    ) -> None:
        """Convert a plane into another."""
        plan, top = self.plan, self.plane.top
        if rotation is not None:
            plan = replace(plan, src=plan.src.turned(rotation))
        if self.spread is not None:
            image = spread(image, self.plane, self.spread, cells(plan.src))
        elif self.before is not None:
            image = moved(image, self.before, cells(plan.src), top)
        in_place = self.after is None and self.spread is None and out.flags.c_contiguous
        result = plan(image, out=out if in_place else None)
        if self.spread is not None:
            result = result[:: self.plane.down, :: self.plane.across]
        if self.after is not None:
            result = moved(result, self.after, cells(plan.dst), top)
        if top is not None and top < np.iinfo(result.dtype).max:
            # Filters that ring leave the ten bits of sixteen.
            np.minimum(result, top, out=result)
        if not in_place:
            out[...] = result


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
        self.planes = described(pixel_format, color_range)
        self.source_shape = pixel_format.height, pixel_format.width
        for what, sides in (("frames", self.source_shape), ("`size`", shape)):
            _expect_whole(what, sides, self.planes, self.name)
        self.conversions = [
            self._of(plane, src, dst, "center" if options["filter"] == "nearest" else siting,
                     options)
            for plane in self.planes
        ]  # fmt: skip

    def _of(
        self, plane: Plane, src: Projection, dst: Projection, siting: str, options: dict[str, Any]
    ) -> PlaneConversion:
        options = options | {"fill": plane.black}
        at = offset(plane, siting)
        if plane.across != plane.down and (src.layout or dst.layout):
            # Faces are squares: those of such chroma are none.
            options |= {"source_shape": self.source_shape, "size": self.shape}
            first = (1 / plane.across - 1) / 2, (1 / plane.down - 1) / 2
            rest = at[0] - first[0], at[1] - first[1]
            plan = remap_plan(src, dst, **options)
            return PlaneConversion(plane, plan, None, rest if any(rest) else None, at)
        source, target = (
            (sides[0] // plane.down, sides[1] // plane.across)
            for sides in (self.source_shape, self.shape)
        )
        # Luma has the aspect of the map; half as wide is as right.
        options |= {"source_shape": source, "size": target, "any_aspect": True}
        before = after = None
        if any(at) and src.grid == "centers":
            turned = turn(src, source, at)
            src, before = (src, (-at[0], -at[1])) if turned is None else (src.turned(turned), None)
        if any(at) and dst.grid == "centers":
            turned = turn(dst, target, at)
            dst, after = (dst, at) if turned is None else (dst.turned(turned), None)
        return PlaneConversion(plane, remap_plan(src, dst, **options), before, after)

    def __call__(
        self, frame: VideoFrame, rotation: NDArray[np.float64] | None = None
    ) -> VideoFrame:
        """Return a frame's conversion: its colors, its time."""
        result = self.blank(frame)
        images, outs = views(frame, self.planes), views(result, self.planes)
        for convert, image, out in zip(self.conversions, images, outs, strict=True):
            convert(image, out, rotation)
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
        height, width = self.shape
        result = av.VideoFrame(width, height, self.name)
        for name in ("pts", "time_base", "duration", "color_range", "colorspace",
                     "color_primaries", "color_trc"):  # fmt: skip
            value = getattr(frame, name)
            if value is not None:
                setattr(result, name, value)
        return result


def _expect_whole(what: str, sides: tuple[int, int], planes: tuple[Plane, ...], name: str) -> None:
    down, across = max(p.down for p in planes), max(p.across for p in planes)
    if sides[0] % down or sides[1] % across:
        parts = [f"a width that {across} divides"] * (across > 1)
        parts += [f"a height that {down} divides"] * (down > 1)
        raise ValueError(
            f"Expected {what} of pixel format {name!r} to have {' and '.join(parts)}, "
            f"got {sides[1]} x {sides[0]}."
        )
