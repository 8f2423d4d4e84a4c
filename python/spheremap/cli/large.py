"""One file of `spheremap convert --memory`: part by part, in the memory that it is given."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import spheremap as sm
from spheremap import io
from spheremap.cli import files, picture, targets
from spheremap.cli.conversion import (
    Options,
    becomes_light,
    chosen,
    convert_file,
    depth_of,
    map_of_faces,
    map_of_file,
    refuse_existing,
    write,
)
from spheremap.cli.picture import Picture
from spheremap.cli.steps import Step
from spheremap.cli.terminal import UsageError, tell_worlds
from spheremap.io.images import STORED
from spheremap.io.large import expect_plain
from spheremap.io.opened import opened
from spheremap.io.parts import convert_parts
from spheremap.io.reading import Source
from spheremap.map.named import resolve
from spheremap.map.size import matching_size
from spheremap.resample.conversion import Conversion

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from spheremap.io import Header

__all__ = ["IDLE", "convert_any"]

# Options that need the whole image at once.
IDLE = ("face_sun", "preview", "mips")


def convert_any(
    source: Path, out: Path, options: Options, step: Step, stdout: str | None
) -> list[str]:
    """Convert a file, in parts where memory is said, and return what there is to say of it."""
    work = convert_file if options.memory is None else _convert_large
    return work(source, out, options, step, stdout)


def _convert_large(
    source: Path, out: Path, options: Options, step: Step, stdout: str | None
) -> list[str]:
    suffix, dst = out.suffix.lower(), options.dst
    if stdout or suffix not in STORED:
        raise UsageError("--memory is for image files, from one to another")
    places = targets.places(out, dst, options.face_names)
    refuse_existing(places, options)
    names, head, src, assumed = _found(source, options)
    dtype, channels = np.dtype(head.dtype), len(head.channels)

    def taken(texels: NDArray[Any]) -> Picture:
        known = picture.described(texels, head, color_space=options.color_space)
        image = chosen(known, options)
        depth = depth_of(image, suffix, options)
        return picture.as_light(image) if becomes_light(image, depth, options) else image

    one = np.zeros((1, 1, channels), dtype)
    depth = depth_of(chosen(picture.described(one, head), options), suffix, options)
    image = taken(one)
    alpha = options.alpha
    if alpha is None and image.alpha == "straight":
        alpha = image.alpha_channel

    def stored(texels: NDArray[Any]) -> Picture:
        part = replace(image, pixels=texels)
        kept = picture.as_stored(
            part, depth, suffix, tonemap=options.tonemap, exposure=options.exposure
        )
        return picture.with_colors(kept) if suffix == ".hdr" else kept

    written = stored(image.pixels)

    def put(texels: NDArray[Any]) -> None:
        tall = texels.reshape(-1, *texels.shape[-2:])
        write(places, replace(written, pixels=tall), options, None)

    shape = (*([src.faces] if targets.has_faces(source) else []), head.height, head.width)
    size = dst.shape(options.size or matching_size(shape, src, dst))
    rotation = sm.rotation(*options.rotate) if any(options.rotate) else None
    conversion = Conversion(
        resolve(src, rotation=rotation),
        dst,
        (*shape, len(image.names)),
        image.pixels.dtype,
        size,
        {
            "filter": options.filter,
            "fill": options.fill,
            "skipna": options.skipna,
            "alpha": alpha,
            "antialias": not options.alias,
            "world": options.world,
            "any_aspect": True,
        },
    )
    with opened(names[0], options.part) as handle:
        part = handle.current_subimage()
    step(f"converting {source.name}: {files.described(src)} to {files.described(dst)}")
    tell_worlds(src, dst, options.world)
    start = time.perf_counter()
    with step.listening():
        convert_parts(
            Source(names, part, dtype, channels, lambda texels: taken(texels).pixels),
            Path(os.path.realpath(out)),
            conversion,
            lambda texels: stored(texels).pixels,
            put,
            memory=options.memory or 0,
            keep=options.resume,
            said=repr(replace(options, resume=False)),
        )
    faces = f"{size[0]} x " if len(size) == 3 else ""
    said = (
        f"{out}: {files.described(dst)}, {faces}{size[-1]} x {size[-2]}, "
        f"{', '.join(written.names)}, {depth}; in {time.perf_counter() - start:.1f} s"
    )
    return [said, *assumed]


def _found(source: Path, options: Options) -> tuple[list[str], Header, sm.Projection, list[str]]:
    """Return the files of an image, what the first says, their map, and what was assumed."""
    if not targets.has_faces(source):
        head = io.header(source, part=options.part)
        src, assumed = map_of_file(source, head, options)
        expect_plain(head, source)
        return [str(source)], head, src, assumed
    src = map_of_faces(options)
    places = targets.found_faces(source, src)
    heads = [io.header(place, part=options.part) for place in places]
    for place, head in zip(places, heads, strict=True):
        expect_plain(head, place)
    said = {(head.height, head.width, head.channels, head.dtype) for head in heads}
    if len(said) > 1:
        raise ValueError(f"the faces of {str(source)!r} differ in size or in what they hold")
    return [str(place) for place in places], heads[0], src, []
