"""The subcommand `spheremap views`: panoramas as views of a rig, for structure from motion."""

from __future__ import annotations

import math
import re
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer

import spheremap as sm
from spheremap.cli import existing, files, picture
from spheremap.cli.lengths import texels
from spheremap.cli.options import (
    AnyAspect,
    ColorSpace,
    Exposure,
    FromGuess,
    Lookup,
    NoClobber,
    OneLookup,
    Part,
    Rotation,
)
from spheremap.cli.picture import Picture
from spheremap.cli.terminal import UsageError, as_usage, check_projection, progress
from spheremap.io.images import STORED
from spheremap.io.tonemap import Curve
from spheremap.map.size import matching_size

# So many views where nothing is said.
_VIEWS = 12


def views(
    sources: Annotated[
        list[Path], typer.Argument(metavar="IN...", help="Panoramas, or folders of them.")
    ],
    folder: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="The folder to write to.")
    ],
    from_: FromGuess = None,
    n: Annotated[
        int | None,
        typer.Option("--n", metavar="N", help=f"At most so many views. [default: {_VIEWS}]"),
    ] = None,
    fov: Annotated[
        float | None,
        typer.Option(metavar="DEG", help="How wide a view is, instead of how many there are."),
    ] = None,
    overlap: Annotated[
        float, typer.Option(metavar="X", help="The part of a view that neighbors see as well.")
    ] = 0.2,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="N",
            help="Side of a view, as 1600, or its width and height, as 1920x1080. "
            "[by default nothing of IN is lost]",
        ),
    ] = None,
    format: Annotated[
        Literal["colmap", "nerfstudio"], typer.Option(help="What the cameras are written for.")
    ] = "colmap",
    nearest: Annotated[
        bool,
        typer.Option("--masks", help="Write masks by which each direction counts in one view."),
    ] = False,
    photographer: Annotated[
        float | None,
        typer.Option(metavar="DEG", help="Write masks without what is so near to straight down."),
    ] = None,
    extension: Annotated[
        Literal["jpg", "png", "exr"] | None,
        typer.Option(help="Of the views. [default: jpg for .jpg, else png]"),
    ] = None,
    rotate: Rotation = (0.0, 0.0, 0.0),
    filter: Lookup = "bilinear",
    alias: OneLookup = False,
    tonemap: Annotated[
        Curve, typer.Option(help="How light becomes integers; none cuts at 1.")
    ] = "none",
    exposure: Exposure = 0.0,
    part: Part = None,
    colorspace: ColorSpace = None,
    any_aspect: AnyAspect = False,
    no_clobber: NoClobber = False,
) -> None:
    """Cut panoramas into views of pinhole cameras, for structure from motion or splats.

    Views go to DIR/images, one folder a camera, masks to DIR/masks, and the cameras are written
    beside them: of one panorama with poses, of several as COLMAP's rig alone.
    """
    if from_ is not None:
        check_projection(from_)
    if n is not None and fov is not None:
        raise UsageError("give --n or --fov, not both")
    paths = _panoramas(sources)
    if format == "nerfstudio" and len(paths) > 1:
        raise UsageError(
            f"--format nerfstudio is of one panorama, got {len(paths)}: its file says where each "
            "picture was taken"
        )
    frames = _frames(paths, extension)
    count = _VIEWS if n is None and fov is None else n
    start = time.perf_counter()
    with progress(len(paths)) as step:
        step("placing cameras")
        with as_usage():
            rig = sm.cameras.rig(_sides(size) or 256, n=count, fov=fov, overlap=overlap)
        for k, (path, frame) in enumerate(zip(paths, frames, strict=True)):
            step(f"reading {path.name}")
            image, src = _read(path, from_, part, colorspace, any_aspect)
            depth = _depth(image, Path(frame).suffix)
            if depth.startswith("float"):
                image = picture.as_light(image)
            elif not image.is_light and (tonemap != "none" or exposure):
                raise UsageError("--tonemap and --exposure do nothing where integers stay integers")
            if k == 0:
                if size is None:
                    side = matching_size(_faced(image.pixels, src).shape, src, rig[0].camera)
                    rig = sm.cameras.rig(side, n=count, fov=fov, overlap=overlap)
                _write_cameras(rig, folder, format, frames, nearest, photographer, no_clobber)
            step(f"cutting {path.name}")
            with step.listening():
                cut = rig.convert(
                    _faced(image.pixels, src),
                    src,
                    rotation=sm.rotation(*rotate) if any(rotate) else None,
                    filter=filter,
                    antialias=not alias,
                    # It was held to its aspect when it was read.
                    any_aspect=True,
                )
            step(f"writing {frame}")
            places = [folder / "images" / view.name / frame for view in rig]
            _save(places, cut, image, depth, tonemap, exposure)
            step.done()
    height, width = rig[0].size
    across = math.degrees(2 * math.atan(0.5 / rig[0].camera.parameters["fx"]))
    panoramas = f"{len(paths)} panorama{'s' if len(paths) > 1 else ''}"
    print(
        f"{folder}: {len(rig)} views of {width} x {height}, {across:.1f} degrees across, "
        f"of {panoramas} in {time.perf_counter() - start:.1f} s"
    )


def _panoramas(sources: list[Path]) -> list[Path]:
    """Return the files, and those of folders."""
    found = []
    for source in sources:
        if not source.is_dir():
            found.append(source)
            continue
        inside = sorted(path for path in source.iterdir() if path.suffix.lower() in STORED)
        if not inside:
            raise FileNotFoundError(f"no image is in {str(source)!r}")
        found += inside
    return found


def _frames(paths: list[Path], extension: str | None) -> list[str]:
    """Return the file name that each panorama's views have."""
    frames = []
    for path in paths:
        own = "jpg" if path.suffix.lower() in (".jpg", ".jpeg") else "png"
        frames.append(f"{path.stem}.{extension or own}")
    twice = {frame for frame in frames if frames.count(frame) > 1}
    if twice:
        raise UsageError(f"several panoramas would be {min(twice)!r}; give them names of their own")
    return frames


def _sides(size: str | None) -> int | tuple[int, int] | None:
    """Return 1600 of "1600" and (1080, 1920) of "1920x1080"."""
    if size is None:
        return None
    both = re.fullmatch(r"(\d+)\s*[x×]\s*(\d+)", size)
    if both:
        return int(both[2]), int(both[1])
    return texels("--size", size)


def _read(
    path: Path, name: str | None, part: str | None, color_space: str | None, any_aspect: bool
) -> tuple[Picture, sm.Projection]:
    loaded = picture.load(path, part=part, color_space=color_space)
    shape = loaded.pixels.shape[:2]
    advice = "--any-aspect takes it as it is"
    src = files.taken(name, loaded.projection, *shape, any_aspect=any_aspect, advice=advice)
    return picture.without_alpha(loaded), src


def _faced(pixels: np.ndarray[Any, Any], src: sm.Projection) -> np.ndarray[Any, Any]:
    """Return faces that lie one below the other as an array of faces, where they are one."""
    if src.faces == 1:
        return pixels
    return pixels.reshape(src.faces, -1, *pixels.shape[1:])


def _depth(image: Picture, suffix: str) -> str:
    kinds, own = STORED[suffix], image.pixels.dtype.name
    return own if own in kinds else kinds[0]


def _write_cameras(
    rig: sm.cameras.Rig,
    folder: Path,
    format: Literal["colmap", "nerfstudio"],
    frames: list[str],
    nearest: bool,
    photographer: float | None,
    no_clobber: bool,
) -> None:
    if no_clobber:
        existing.refuse_existing(
            [folder / "images" / view.name / frame for view in rig for frame in frames]
        )
    masks = None
    if nearest or photographer is not None:
        masks = sm.cameras.masks(rig, nearest=nearest, photographer=photographer)
    sm.cameras.write(rig, folder, format=format, frame=frames, masks=masks)


def _save(
    places: list[Path],
    cut: list[np.ndarray[Any, Any]],
    image: Picture,
    depth: str,
    tonemap: Curve,
    exposure: float,
) -> None:
    """Write the views of a panorama, several at a time: compressing takes longer than cutting."""

    def save(place: Path, pixels: np.ndarray[Any, Any]) -> None:
        place.parent.mkdir(parents=True, exist_ok=True)
        stored = picture.as_stored(
            replace(image, pixels=pixels), depth, place.suffix, tonemap=tonemap, exposure=exposure
        )
        picture.save(place, stored, compression=None)

    with ThreadPoolExecutor(sm.get_num_threads()) as pool:
        for _ in pool.map(save, places, cut):
            pass
