"""The subcommand `spheremap bake`: what a renderer needs of an environment."""

from __future__ import annotations

import time
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated

import typer

import spheremap as sm
from spheremap.cli import files, picture
from spheremap.cli.options import AnyAspect, ColorSpace, Part, World
from spheremap.cli.terminal import (
    UsageError,
    check_projection,
    progress,
    refuse,
    tell_worlds,
)


def bake(
    context: typer.Context,
    source: Annotated[Path, typer.Argument(metavar="IN", help="The environment to read.")],
    folder: Annotated[Path, typer.Argument(metavar="OUT", help="The folder to write to.")],
    from_: Annotated[
        str | None,
        typer.Option(
            "--from", metavar="NAME", help="Projection of IN. [default: what IN says, or latlong]"
        ),
    ] = None,
    diffuse: Annotated[bool, typer.Option("--diffuse", help="Irradiance over π.")] = False,
    specular: Annotated[
        bool, typer.Option("--specular", help="GGX reflections as a mip chain, and their table.")
    ] = False,
    sh: Annotated[bool, typer.Option("--sh", help="Spherical harmonics.")] = False,
    size: Annotated[int, typer.Option(min=1, metavar="N", help="Face of the specular cube.")] = 256,
    levels: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Its mips: 6, or as many as the size has."),
    ] = None,
    diffuse_size: Annotated[
        int, typer.Option(min=1, metavar="N", help="Face of the diffuse cube.")
    ] = 32,
    order: Annotated[
        int, typer.Option(min=0, max=64, metavar="L", help="Of the spherical harmonics.")
    ] = 2,
    samples: Annotated[
        int, typer.Option(min=1, metavar="N", help="Lookups a texel of the specular cube.")
    ] = 1024,
    part: Part = None,
    colorspace: ColorSpace = None,
    any_aspect: AnyAspect = False,
    skipna: Annotated[
        bool, typer.Option("--skipna", help="Count NaN and infinite texels as 0.")
    ] = False,
    world: World = "match",
) -> None:
    """Make what a renderer needs of an environment: cube maps as KTX2 and DDS, harmonics as JSON.

    Without --diffuse, --specular and --sh it makes all three.
    """
    if from_ is not None:
        check_projection(from_)
    everything = not (diffuse or specular or sh)
    if not (specular or everything):
        refuse(context, ["size", "levels", "samples"], "without --specular")
    if not (diffuse or everything):
        refuse(context, ["diffuse_size"], "without --diffuse")
    if not (sh or everything):
        refuse(context, ["order"], "without --sh")
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"cannot write {str(folder)!r}: it is no folder")
    if levels is not None and size >> (levels - 1) < 1:
        raise UsageError(f"--size {size} has at most {size.bit_length()} levels, got {levels}")
    with progress() as step:
        step(f"reading {source.name}")
        # Alpha is no light.
        loaded = picture.load(source, part=part, color_space=colorspace)
        loaded = picture.without_alpha(picture.as_light(loaded))
        image = loaded.pixels
        src = files.taken(
            from_,
            loaded.projection or "latlong",
            *image.shape[:2],
            any_aspect=any_aspect,
            advice="--any-aspect takes it as it is",
        )
        start = time.perf_counter()
        light = image[..., :3] if image.shape[-1] > 3 else image
        baked = sm.light.Bake(None, None, None, None)
        for kind, wanted, what in (
            ("diffuse", diffuse, "the diffuse cube"),
            ("specular", specular, "reflections"),
            ("sh", sh, "harmonics"),
        ):
            if not (wanted or everything):
                continue
            # One after the other, to say which.
            step(f"baking {what}")
            with step.listening():
                made = sm.light.bake(
                    light,
                    src,
                    diffuse=kind == "diffuse",
                    specular=kind == "specular",
                    sh=kind == "sh",
                    size=size,
                    levels=levels,
                    diffuse_size=diffuse_size,
                    order=order,
                    samples=samples,
                    skipna=skipna,
                    world=world,
                    # It was held to its aspect when it was read.
                    any_aspect=True,
                )
            parts = {field.name: getattr(made, field.name) for field in fields(made)}
            baked = replace(baked, **{k: x for k, x in parts.items() if x is not None})
        tell_worlds(src, sm.projection("cube"), world)
        seconds = time.perf_counter() - start
        step(f"writing {folder.name}")
        written = baked.write(folder)
    print(f"{source}: {files.described(src)}, baked in {seconds:.3f} s")
    for place, what in written:
        print(f"{place}: {what}, {place.stat().st_size} bytes")
