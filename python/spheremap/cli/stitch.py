"""The subcommand `spheremap stitch`: views, or both lenses of a 360 camera, as one panorama."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import typer

import spheremap as sm
from spheremap import io
from spheremap.cli import existing, files, picture
from spheremap.cli.lengths import texels
from spheremap.cli.options import (
    AnyAspect,
    ColorSpace,
    Exposure,
    NoClobber,
    Rotation,
    World,
)
from spheremap.cli.picture import Picture
from spheremap.cli.terminal import UsageError, as_usage, check_projection, progress
from spheremap.io.images import STORED, TEXTURES
from spheremap.io.tonemap import Curve
from spheremap.map.flat import flat

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray


def stitch(
    sources: Annotated[
        list[Path], typer.Argument(metavar="IN...", help="The pictures, or a folder of them.")
    ],
    target: Annotated[Path, typer.Option("--output", "-o", metavar="OUT", help="The panorama.")],
    cameras: Annotated[
        str,
        typer.Option(
            "--cameras",
            metavar="NAME|FILE",
            help="The lens, as 'dual_fisheye(fov=200)' or 'angular(fov=200)', or the file of a "
            "calibration program, or the folder of COLMAP's.",
        ),
    ],
    to: Annotated[str, typer.Option("--to", metavar="NAME", help="Projection of OUT.")] = "latlong",
    size: Annotated[
        str | None,
        typer.Option(metavar="N", help="Height of a latlong, side of a square or face, as 2k."),
    ] = None,
    blend: Annotated[
        Literal["feather", "bands", "nearest"],
        typer.Option(help="How pictures go over into each other."),
    ] = "feather",
    match_exposure: Annotated[
        bool, typer.Option("--match-exposure", help="Make all as bright where they overlap.")
    ] = False,
    fov: Annotated[
        float | None,
        typer.Option(metavar="DEG", help="How wide the lens of a calibration sees, across."),
    ] = None,
    mask: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE", help="One for each picture; black does not count."),
    ] = None,
    rotate: Rotation = (0.0, 0.0, 0.0),
    world: World = "match",
    tonemap: Annotated[
        Curve, typer.Option(help="How light becomes integers; none cuts at 1.")
    ] = "none",
    exposure: Exposure = 0.0,
    colorspace: ColorSpace = None,
    any_aspect: AnyAspect = False,
    no_clobber: NoClobber = False,
) -> None:
    """Join views, or the pictures of a 360 camera's lenses, into one panorama.

    Of two pictures and one lens the second looks backward. Pictures are those of the views of a
    file by their names, or by their order where no name is that of a view.
    """
    check_projection(to)
    if target.suffix.lower() in TEXTURES:
        raise UsageError(f"--output is an image, got {str(target)!r}")
    with as_usage():
        dst = flat(to)
    io.check_target(target)
    if no_clobber:
        existing.refuse_existing([target])
    seen, paths = _matched(cameras, sources)
    if target.resolve() in [path.resolve() for path in [*paths, *(mask or ())]]:
        raise UsageError(f"--output would replace {str(target)!r}, which is needed")
    if mask and len(mask) != len(paths):
        raise UsageError(f"--mask is needed once for each of {len(paths)} pictures")
    start = time.perf_counter()
    with progress() as step:
        loaded = []
        for path in paths:
            step(f"reading {path.name}")
            loaded.append(picture.without_alpha(picture.load(path, color_space=colorspace)))
        masks = [_counts(picture.load(path)) for path in mask or ()]
        suffix = target.suffix.lower()
        kinds, own = STORED[suffix], loaded[0].pixels.dtype.name
        depth = own if own in kinds else "float32" if "float32" in kinds else "uint8"
        if _are_light(loaded, depth):
            loaded = [picture.as_light(one) for one in loaded]
        elif tonemap != "none" or exposure:
            raise UsageError("--tonemap and --exposure do nothing where integers stay integers")
        images: Any = [one.pixels for one in loaded]
        step("stitching")
        with step.listening():
            image, weight = sm.cameras.stitch(
                images[0] if isinstance(seen, sm.Projection) else images,
                seen,
                dst,
                size=texels("--size", size) if size else None,
                blend=blend,
                exposure="match" if match_exposure else None,
                masks=masks or None,
                fov=fov,
                rotation=sm.rotation(*rotate) if any(rotate) else None,
                world=world,
                any_aspect=any_aspect,
                return_weight=True,
            )
        step(f"writing {target.name}")
        joined = replace(loaded[0], pixels=image, metadata={})
        stored = picture.as_stored(joined, depth, suffix, tonemap=tonemap, exposure=exposure)
        picture.save(target, stored, compression=None, projection=files.noted(to, dst))
    height, width = image.shape[:2]
    count = f"{len(paths)} picture{'s' if len(paths) > 1 else ''}"
    print(
        f"{target}: {files.described(dst)}, {width} x {height}, "
        f"covers {_covered(weight, dst):.1%}; {count} in {time.perf_counter() - start:.1f} s"
    )


def _matched(cameras: str, sources: list[Path]) -> tuple[Any, list[Path]]:
    """Return the cameras as `stitch` takes them, and the picture of each."""
    if not Path(cameras).exists():
        if "/" in cameras or Path(cameras).suffix.lower() in (".txt", ".bin", ".json", ".yaml"):
            raise FileNotFoundError(f"no such file: {cameras!r}")
        check_projection(cameras)
        lens = sm.projection(cameras)
        if len(sources) == 1:
            return (lens if lens.name == "dual_fisheye" else [lens]), sources
        if len(sources) > 2 or lens.name == "dual_fisheye":
            raise UsageError(f"--cameras {cameras!r} is of one picture, got {len(sources)}")
        return sm.cameras.back_to_back(lens), sources
    rig = sm.cameras.read(cameras)
    paths = _pictures(rig, sources)
    if all(view.pose is not None for view in rig):
        return rig, paths
    if len(rig) > 2 or len(paths) != 2:
        raise UsageError(f"{cameras!r} does not say where its cameras look")
    return sm.cameras.back_to_back(*(view.camera for view in rig)), paths


def _pictures(rig: sm.cameras.Rig, sources: list[Path]) -> list[Path]:
    """Return the pictures of a rig's views in their order."""
    if len(sources) == 1 and sources[0].is_dir():
        places = [[sources[0].joinpath(*name) for name in names] for names in _names(rig)]
        best = max(places, key=lambda paths: sum(path.is_file() for path in paths))
        for path in best:
            if not path.is_file():
                raise FileNotFoundError(f"no such file: {str(path)!r}, a view of the cameras")
        return best
    for names in _names(rig):
        found = _by_name(names, sources)
        if not any(found):
            continue
        for view, paths in zip(rig, found, strict=True):
            if len(paths) > 1:
                raise UsageError(f"{view.name!r} is the name of {len(paths)} pictures")
        missing = [view.name for view, paths in zip(rig, found, strict=True) if not paths]
        if missing:
            shown = ", ".join(map(repr, missing[:4])) + (", ..." if len(missing) > 4 else "")
            raise UsageError(f"pictures have the names of some cameras, and none that of {shown}")
        return [path for (path,) in found]
    if len(sources) not in (len(rig), 2 if len(rig) == 1 else len(rig)):
        raise UsageError(f"there are {len(rig)} cameras and {len(sources)} pictures")
    return sources


def _names(rig: sm.cameras.Rig) -> Iterator[list[tuple[str, ...]]]:
    """Yield the parts of the views' names, then fewer as long as they differ.

    Names are relative to a folder that IN need not be: nerfstudio's begin with "images".
    """
    whole = [PurePosixPath(view.name).parts for view in rig]
    for k in range(max(1, min(map(len, whole), default=0))):
        names = [parts[k:] for parts in whole]
        if k and len(set(names)) < len(names):
            return
        yield names


def _by_name(names: list[tuple[str, ...]], sources: list[Path]) -> list[list[Path]]:
    """Return the pictures of each name: a picture is of the longest with which its path ends."""
    found: dict[tuple[str, ...], list[Path]] = {name: [] for name in names}
    for path in sources:
        parts = path.absolute().parts
        ends = [name for name in names if parts[-len(name) :] == name]
        if ends:
            found[max(ends, key=len)].append(path)
    return [found[name] for name in names]


def _are_light(loaded: list[Picture], depth: str) -> bool:
    """Tell whether pictures are to be mixed as light."""
    if depth.startswith("float") or any(one.is_light for one in loaded):
        return True
    return any(one.color_space != picture.SRGB for one in loaded)


def _counts(mask: Picture) -> NDArray[np.bool_]:
    pixels = picture.without_alpha(mask).pixels
    most = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1.0
    return np.asarray(pixels.mean(-1) > 0.5 * most)


def _covered(weight: NDArray[np.float32], dst: sm.Projection) -> float:
    """Return the part of what OUT holds that some picture shows."""
    area = sm.solid_angle(dst, weight.shape, any_aspect=True)
    return float(area[weight > 0].sum() / area.sum())
