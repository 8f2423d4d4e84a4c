"""The subcommand `spheremap video`: videos from one projection to another."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import spheremap as sm
from spheremap._names import ConvertFilter
from spheremap.cli import files, sizes
from spheremap.cli.options import AnyAspect, World
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
    src: Annotated[
        str | None,
        typer.Option("--from", metavar="NAME", help="Projection of IN. [default: what IN says]"),
    ] = None,
    layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How OUT lays out its faces. [default: cross or strip]"),
    ] = None,
    height: Annotated[
        str | None, typer.Option(metavar="N", help="Rows of OUT, as 1920. [by default as IN]")
    ] = None,
    width: Annotated[str | None, typer.Option(metavar="N", help="Columns of OUT, as 4k.")] = None,
    size: Annotated[
        str | None, typer.Option(metavar="N", help="Height of a latlong, side of a square or face.")
    ] = None,
    rotate: Annotated[
        tuple[float, float, float],
        typer.Option(
            "--rotation",
            metavar="YAW PITCH ROLL",
            help="Turn the content about +y, +x and +z of IN's world, in degrees.",
            show_default=False,
        ),
    ] = (0.0, 0.0, 0.0),
    keyframes: Annotated[
        Path | None,
        typer.Option(
            metavar="CSV", help="Turn it over time: lines of seconds, yaw, pitch and roll."
        ),
    ] = None,
    world: World = "match",
    filter: Annotated[ConvertFilter, typer.Option(help="The lookup.")] = "bilinear",
    alias: Annotated[
        bool,
        typer.Option(
            "--no-antialias", help="One lookup a texel, also where OUT is coarser than IN."
        ),
    ] = False,
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
    no_clobber: Annotated[
        bool, typer.Option("--no-clobber", help="Replace no file that is there.")
    ] = False,
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
    if no_clobber and target.exists():
        raise FileExistsError(f"{str(target)!r} is there, and --no-clobber keeps it")
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
                options=_options(options or []),
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


def _options(given: list[str]) -> dict[str, str]:
    """Return what the encoder is told."""
    told = {}
    for text in given:
        name, sign, value = text.partition("=")
        if not sign or not name:
            raise UsageError(f"--option is a NAME=VALUE, as crf=20; got {text!r}")
        told[name] = value
    return told
