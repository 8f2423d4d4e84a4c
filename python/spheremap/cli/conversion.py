"""One file of `spheremap convert`: read, turned into another projection, written."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import spheremap as sm
from spheremap import io
from spheremap.cli import existing, files, picture, targets
from spheremap.cli.picture import Picture
from spheremap.cli.steps import Step
from spheremap.cli.terminal import UsageError, tell_tilt, tell_worlds
from spheremap.io.images import STORED
from spheremap.map.size import matching_size

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from spheremap._names import ConvertFilter
    from spheremap.io.tonemap import Curve
    from spheremap.map.named import Worlds

_TEXTURE_WRITERS = {".ktx2": io.write_ktx2, ".dds": io.write_dds}


@dataclass(frozen=True)
class Options:
    """What the command line asks for, checked; see the options of the same names."""

    from_: str | None
    from_layout: str | None
    to: str
    dst: sm.Projection
    size: int | None
    face_names: str
    rotate: tuple[float, float, float]
    face_sun: bool
    filter: ConvertFilter
    fill: float
    alias: bool
    alpha: int | None
    skipna: bool
    channels: list[str] | None
    drop_alpha: bool
    half: bool
    single: bool
    bits: int | None
    color_space: str | None
    tonemap: Curve
    exposure: float
    compression: str | None
    mips: bool
    part: str | None
    any_aspect: bool
    no_clobber: bool
    world: Worlds
    preview: Path | None = None
    verbose: bool = False
    memory: int | None = None
    resume: bool = False


def convert_file(
    source: Path, out: Path, options: Options, step: Step, stdout: str | None
) -> list[str]:
    """Convert a file and return what there is to say of it."""
    dst, suffix = options.dst, stdout or out.suffix.lower()
    places = targets.places(out, dst, options.face_names)
    refuse_existing(places, options)
    clock = [time.perf_counter()]
    step(f"reading {source.name}")
    image, src, assumed = _loaded(source, options)
    clock.append(time.perf_counter())
    step(f"converting {source.name}: {files.described(src)} to {files.described(dst)}")
    depth = "float16" if suffix in _TEXTURE_WRITERS else depth_of(image, suffix, options)
    if becomes_light(image, depth, options):
        image = picture.as_light(image)
    rotation, turned = _rotation(image, src, options)
    result = _converted(image, src, rotation, options, step)
    clock.append(time.perf_counter())
    step(f"writing {out.name}")
    notes = [*assumed, *turned]
    tell_worlds(src, dst, options.world)
    if suffix in _TEXTURE_WRITERS:
        notes += _write_texture(out, result, options, step)
    else:
        stored = picture.as_stored(
            _tall(result), depth, suffix, tonemap=options.tonemap, exposure=options.exposure
        )
        write(places, stored, options, stdout)
    if options.preview is not None:
        _write_preview(options.preview, result, options)
    clock.append(time.perf_counter())
    shape = result.pixels.shape
    return [_report(out, dst, result.names, shape, depth, clock, options.verbose), *notes]


def becomes_light(image: Picture, depth: str, options: Options) -> bool:
    """Tell whether light is converted, and not integers as they are."""
    if depth.startswith("float") or image.is_light:
        return True
    if options.tonemap != "none" or (options.exposure and options.preview is None):
        raise UsageError("--tonemap and --exposure do nothing where integers stay integers")
    return False


def depth_of(image: Picture, suffix: str, options: Options) -> str:
    """Return the type that a file will hold: what is asked for, or the nearest to the image's."""
    kinds = STORED[suffix]
    asked = {
        "--half": "float16" if options.half else None,
        "--float": "float32" if options.single else None,
        f"--bits {options.bits}": f"uint{options.bits}" if options.bits else None,
    }
    for option, kind in asked.items():
        if kind is not None:
            if kind not in kinds:
                raise UsageError(f"{option} is none of {suffix}, which holds {', '.join(kinds)}")
            return kind
    own = image.pixels.dtype.name
    return own if own in kinds else "float32" if "float32" in kinds else "uint8"


def refuse_existing(places: list[Path], options: Options) -> None:
    """Raise where a file would be replaced that is to stay."""
    if options.no_clobber:
        existing.refuse_existing([*places, *([options.preview] if options.preview else [])])


def _loaded(source: Path, options: Options) -> tuple[Picture, sm.Projection, list[str]]:
    """Return an image, its projection, and what was taken for granted."""
    load = partial(
        picture.load, part=options.part, fill=options.fill, color_space=options.color_space
    )
    if targets.has_faces(source):
        src = map_of_faces(options)
        parts = [load(place) for place in targets.found_faces(source, src)]
        if len({part.pixels.shape for part in parts}) > 1:
            raise ValueError(f"the faces of {str(source)!r} differ in size")
        image = replace(parts[0], pixels=np.concatenate([part.pixels for part in parts]))
        return chosen(image, options), src, []
    head = io.header(source, part=options.part)
    image = load(source, head=head)
    src, assumed = map_of_file(source, head, options)
    return chosen(image, options), src, assumed


def map_of_faces(options: Options) -> sm.Projection:
    """Return the projection of files of a face each."""
    if options.from_ is None:
        raise UsageError("--from is needed: six files do not say what they are")
    return files.of_faces(options.from_)


def map_of_file(source: Path, head: io.Header, options: Options) -> tuple[sm.Projection, list[str]]:
    """Return the projection of a file that says so or not, and what was taken for granted."""
    name, assumed = options.from_, []
    if name is None:
        if head.projection is None:
            raise UsageError(f"--from is needed: {str(source)!r} does not say its projection")
        name = head.projection
        assumed = [f"{source}: taken as {name}, as it says"]
    src = files.of_file(
        name,
        options.from_layout,
        head.height,
        head.width,
        any_aspect=options.any_aspect,
        advice="--any-aspect takes it as it is",
    )
    if not any(options.rotate) and not options.face_sun:
        tell_tilt(source, head, name)
    return src, assumed


def chosen(image: Picture, options: Options) -> Picture:
    """Return a picture with the channels that are asked for."""
    if options.channels is not None:
        return picture.with_channels(image, options.channels)
    return picture.without_alpha(image) if options.drop_alpha else image


def _rotation(
    image: Picture, src: sm.Projection, options: Options
) -> tuple[NDArray[np.float64] | None, list[str]]:
    if not options.face_sun:
        return (sm.rotation(*options.rotate) if any(options.rotate) else None), []
    # Here, as most of what the room holds takes time to import.
    from spheremap.cli import radiance, sunward

    light = picture.as_light(image).pixels
    sun = radiance.energy(_faced(light[..., :3] if light.shape[-1] > 3 else light, src), src).sun
    if sun is None:
        raise ValueError("--face-sun: there is no sun in the image")
    dst = options.dst if options.world == "match" else options.dst._changed(world=src.world)
    angles = sunward.angles(sun.direction, src, dst)
    text = " ".join(f"{angle:.3f}" for angle in angles)
    return sm.rotation(*angles), [f"the sun is at the center by --rotation {text}"]


def _faced(pixels: NDArray[Any], projection: sm.Projection) -> NDArray[Any]:
    """Return faces that lie one below the other as an array of faces."""
    if projection.faces == 1:
        return pixels
    count, width, channels = projection.faces, *pixels.shape[1:]
    return pixels.reshape(count, len(pixels) // count, width, channels)


def _tall(image: Picture) -> Picture:
    """Return an array of faces as faces one below the other."""
    *_, width, channels = image.pixels.shape
    return replace(image, pixels=image.pixels.reshape(-1, width, channels))


def _converted(
    image: Picture,
    src: sm.Projection,
    rotation: NDArray[np.float64] | None,
    options: Options,
    step: Step,
) -> Picture:
    alpha = options.alpha
    if alpha is None and image.alpha == "straight":
        alpha = image.alpha_channel
    pixels = _faced(image.pixels, src)
    size = options.size or matching_size(pixels.shape, src, options.dst)
    result = np.empty((*options.dst.shape(size), pixels.shape[-1]), pixels.dtype)
    with step.listening():
        sm.convert(
            pixels,
            src,
            options.dst,
            size=size,
            rotation=rotation,
            filter=options.filter,
            fill=options.fill,
            out=result,
            antialias=not options.alias,
            alpha=alpha,
            skipna=options.skipna,
            world=options.world,
            # It was held to its aspect when it was read.
            any_aspect=True,
        )
    return replace(image, pixels=result)


def write(places: list[Path], image: Picture, options: Options, stdout: str | None) -> None:
    """Write an image, or faces that lie one below the other each to its place."""
    if len(places) > 1:
        for place, face in zip(places, np.split(image.pixels, len(places)), strict=True):
            _save(place, replace(image, pixels=face), None, options)
        return
    name = files.noted(options.to, options.dst)
    if stdout:
        targets.to_stdout(stdout, lambda place: _save(place, image, name, options))
    else:
        _save(places[0], image, name, options)


def _save(place: Path, image: Picture, projection: str | None, options: Options) -> None:
    suffix = place.suffix.lower()
    if image.alpha_channel is not None and STORED[suffix] in (("float32",), ("uint8",)):
        raise OSError(f"cannot write {str(place)!r}: {suffix} has no alpha: --drop-alpha")
    if suffix == ".hdr":
        image = picture.with_colors(image)
    picture.save(place, image, compression=options.compression, projection=projection)


def _write_preview(place: Path, result: Picture, options: Options) -> None:
    shown = picture.as_shown(_tall(result), place.suffix.lower(), exposure=options.exposure)
    io.write(place, shown)


def _write_texture(out: Path, result: Picture, options: Options, step: Step) -> list[str]:
    if result.alpha_channel is not None:
        # Of two channels a texture would take alpha for green.
        result = picture.with_colors(result)
    levels = [result.pixels]
    if options.mips:
        with step.listening():
            levels = sm.mipmaps(result.pixels.astype(np.float32), options.dst)
    clipped = _TEXTURE_WRITERS[out.suffix.lower()](out, levels)
    notes = [f"{out}: {len(levels)} mips"] if options.mips else []
    return notes + ([f"{out}: {clipped} values above 65504 clipped"] if clipped else [])


def _report(
    out: Path,
    dst: sm.Projection,
    names: tuple[str, ...],
    shape: tuple[int, ...],
    depth: str,
    clock: list[float],
    verbose: bool,
) -> str:
    reading, converting, writing = np.diff(clock)
    texels = int(np.prod(shape[:-1]))
    faces = f"{shape[0]} x " if len(shape) == 4 else ""
    said = (
        f"{out}: {files.described(dst)}, {faces}{shape[-2]} x {shape[-3]}, {', '.join(names)}, "
        f"{depth}; converted in {converting:.3f} s ({texels / converting / 1e6:.0f} Mtexel/s)"
    )
    if verbose:
        said += f"; read in {reading:.3f} s, written in {writing:.3f} s"
    return said
