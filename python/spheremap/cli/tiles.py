"""The subcommand `spheremap tiles`: an image as a pyramid of tiles for the web."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import spheremap as sm
from spheremap.cli import files, lengths
from spheremap.cli.options import (
    AnyAspect,
    ColorSpace,
    Exposure,
    FromGuess,
    Lookup,
    Memory,
    Part,
    Rotation,
    World,
)
from spheremap.cli.pairs import named_values
from spheremap.cli.shown import Shown
from spheremap.cli.terminal import (
    UsageError,
    check_projection,
    progress,
    refuse,
    tell_tilt,
    tell_worlds,
)
from spheremap.io.tonemap import Curve
from spheremap.map.named import resolve
from spheremap.tiles.asked import Extension, Format, Frame, Kind, written
from spheremap.tiles.folder import empty_folder
from spheremap.tiles.held import HeldImage
from spheremap.tiles.large import file_image

if TYPE_CHECKING:
    from spheremap.tiles.level import Image


def tiles(
    context: typer.Context,
    source: Annotated[Path, typer.Argument(metavar="IN", help="The image to read.")],
    folder: Annotated[
        Path, typer.Argument(metavar="OUT", help="The folder to write to, new or empty.")
    ],
    format: Annotated[Format, typer.Option("--format", help="What the tiles are for.")],
    from_: FromGuess = None,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="N",
            help="Side of a face, or height of a panorama, of the largest level, as 4k. "
            "[by default nothing of IN is lost]",
        ),
    ] = None,
    tile_size: Annotated[
        int, typer.Option(metavar="N", min=16, max=8192, help="Side of a tile.")
    ] = 512,
    extension: Annotated[
        Extension, typer.Option(help="Of the tiles; fits, of hips alone, keeps the numbers.")
    ] = "jpg",
    quality: Annotated[int, typer.Option(metavar="N", min=1, max=100, help="Of .jpg.")] = 90,
    filter: Lookup = "bilinear",
    rotate: Rotation = (0.0, 0.0, 0.0),
    world: World = "match",
    curve: Annotated[
        Curve, typer.Option("--tonemap", help="How light becomes 8 bits; none cuts at 1.")
    ] = "none",
    exposure: Exposure = 0.0,
    channels: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Keep these channels, as R,G,B.")
    ] = None,
    title: Annotated[
        str | None, typer.Option(metavar="TEXT", help="What it is called. [default: name of IN]")
    ] = None,
    frame: Annotated[
        Frame, typer.Option(help="Of hips: the frame of the sky that IN is in.")
    ] = "equatorial",
    properties: Annotated[
        list[str] | None,
        typer.Option(
            "--property", metavar="NAME=VALUE", help="Of hips: a line of its file properties."
        ),
    ] = None,
    no_page: Annotated[
        bool, typer.Option("--no-page", help="Write no index.html that shows the tiles.")
    ] = False,
    part: Part = None,
    colorspace: ColorSpace = None,
    any_aspect: AnyAspect = False,
    memory: Memory = None,
) -> None:
    """Write an image as a pyramid of tiles for a viewer on the web.

    Light above 1 is cut in .jpg and .png, or tone-mapped on request; alpha becomes black.
    """
    if from_ is not None:
        check_projection(from_)
    if format != "hips":
        refuse(context, ["frame"], "but of hips")
        if properties:
            raise UsageError("--property does nothing but of hips")
        if extension == "fits":
            raise UsageError(f"--extension fits is of hips alone, got {format}")
    if extension != "jpg":
        refuse(context, ["quality"], f"in .{extension}")
    if extension == "fits":
        refuse(context, ["curve", "exposure"], "where floats are written")
    if format == "hips" and tile_size & (tile_size - 1):
        raise UsageError(f"--tile-size of hips is a power of two, got {tile_size}")
    most = None if memory is None else lengths.as_bytes("--memory", memory)
    empty_folder(folder)
    start = time.perf_counter()
    with progress() as step:
        step(f"reading {source.name}")
        shown = Shown(source, part, colorspace, channels)
        src = shown.map(from_, any_aspect)
        if not any(rotate):
            tell_tilt(source, shown.head, from_)
        if not shown.is_light and (curve != "none" or exposure):
            raise UsageError("--tonemap and --exposure do nothing where integers stay integers")
        turned = resolve(src, rotation=sm.rotation(*rotate) if any(rotate) else None)
        kind = Kind.of(format, extension, curve, exposure, turned)
        image: Image
        if most is None:
            image = HeldImage(kind.taken(shown.whole()))
        else:
            image = file_image(shown.parts(), shown.shape, kind, tile_size=tile_size, memory=most)
        step(f"writing {folder.name}")
        with step.listening():
            made = written(
                image,
                kind,
                folder,
                size=lengths.texels("--size", size) if size else None,
                tile_size=tile_size,
                quality=quality,
                filter=filter,
                world=world,
                title=source.stem if title is None else title,
                frame=frame,
                properties=named_values("--property", properties, "obs_title=Sky"),
                page=not no_page,
            )
    # Viewers have no world but up and ahead; a survey has that of the sky.
    sky = sm.projection("healpix:healpy" if format == "hips" else "latlong")
    tell_worlds(src, sky, world)
    shape = " x ".join(map(str, made.shape))
    levels = "1 level" if made.levels == 1 else f"{made.levels} levels"
    seconds = time.perf_counter() - start
    print(
        f"{made.manifest}: {files.described(src)} as {format}, {shape}, {levels}, "
        f"{made.tiles} tiles in {seconds:.1f} s"
    )
    if shown.is_light and extension != "fits" and curve == "none":
        _tell_cut(shown.largest, exposure)


def _tell_cut(largest: float, exposure: float) -> None:
    """Say what the tiles do not show."""
    brightest = largest * 2.0**exposure
    if brightest > 1:
        print(
            f"light up to {brightest:.3g} is cut at 1; --tonemap reinhard compresses it, and "
            "hips with --extension fits keeps it"
        )
