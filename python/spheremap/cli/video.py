"""The subcommand `spheremap video`: videos from one projection to another."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import spheremap as sm
from spheremap.cli import existing, files, sizes
from spheremap.cli.options import (
    AnyAspect,
    FromSaid,
    Height,
    Lookup,
    NoClobber,
    OneLookup,
    Rotation,
    Size,
    Width,
    World,
)
from spheremap.cli.pairs import named_values
from spheremap.cli.terminal import (
    UsageError,
    as_usage,
    check_projection,
    progress,
    tell_worlds,
    was_given,
)
from spheremap.map.flat import flat


def video(
    context: typer.Context,
    source: Annotated[Path, typer.Argument(metavar="IN", help="The video to read.")],
    target: Annotated[Path, typer.Argument(metavar="OUT", help="The video to write.")],
    dst: Annotated[str, typer.Option("--to", metavar="NAME", help="Projection of OUT.")],
    src: FromSaid = None,
    layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How OUT lays out its faces. [default: cross or strip]"),
    ] = None,
    height: Height = None,
    width: Width = None,
    size: Size = None,
    rotate: Rotation = (0.0, 0.0, 0.0),
    keyframes: Annotated[
        Path | None,
        typer.Option(
            metavar="CSV", help="Turn it over time: lines of seconds, yaw, pitch and roll."
        ),
    ] = None,
    world: World = "match",
    filter: Lookup = "bilinear",
    alias: OneLookup = False,
    siting: Annotated[
        Literal["left", "center", "top-left"] | None,
        typer.Option(help="Where chroma lies. [default: left, in JPEG's formats center]"),
    ] = None,
    codec: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="The encoder, as libx265. [default: as IN]"),
    ] = None,
    options: Annotated[
        list[str] | None,
        typer.Option(
            "--option", metavar="NAME=VALUE", help="What the encoder is told, as crf=20; many."
        ),
    ] = None,
    pixel_format: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Of OUT, as yuv420p10le. [default: as IN]"),
    ] = None,
    metadata: Annotated[
        Literal["both", "v1", "v2", "none"] | None,
        typer.Option(help="How OUT says that it is a panorama. [default: both, of a latlong]"),
    ] = None,
    silent: Annotated[
        bool, typer.Option("--no-audio", help="Copy neither audio nor subtitles.")
    ] = False,
    any_aspect: AnyAspect = False,
    no_clobber: NoClobber = False,
) -> None:
    """Turn a video from one projection into another; audio and times stay.

    Ctrl-C ends it early: OUT is what was converted until then.
    """
    for name in (dst, src):
        if name is not None:
            check_projection(name)
    with as_usage():
        map_ = flat(dst, layout)
        wanted = sizes.wanted(map_, height, width, size)
    if was_given(context, "rotate") and keyframes is not None:
        raise UsageError("give --rotation or --keyframes, not both")
    if no_clobber:
        existing.refuse_existing([target])
    rotation: Any = sm.rotation(*rotate) if any(rotate) else None
    if keyframes is not None:
        rotation = sm.video.read_keyframes(keyframes)

    start = time.perf_counter()
    with progress() as step:
        step(f"converting {source.name}")
        with step.listening():
            done = sm.video.convert(
                source,
                target,
                src,
                map_,
                size=wanted,
                rotation=rotation,
                filter=filter,
                antialias=not alias,
                world=world,
                any_aspect=any_aspect,
                codec=codec,
                pixel_format=pixel_format,
                options=named_values("--option", options, "crf=20"),
                siting=siting,
                audio=not silent,
                metadata=metadata,
            )
    seconds = time.perf_counter() - start
    tell_worlds(done.src, done.dst, world)
    rows, columns = done.shape
    print(
        f"{target}: {files.described(done.dst)}, {columns} x {rows}, {done.codec}, "
        f"{done.pixel_format}; {done.frames} frames in {seconds:.1f} s "
        f"({done.frames / seconds:.1f} a second)"
    )
    if src is None:
        print(f"{source}: taken as {done.src.name}, as it says")
