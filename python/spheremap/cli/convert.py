"""The subcommand `spheremap convert`: images from one projection to another."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from spheremap import io
from spheremap.cli import files, sizes, targets
from spheremap.cli.conversion import Options, convert_file
from spheremap.cli.large import IDLE, as_bytes, convert_large
from spheremap.cli.options import (
    AnyAspect,
    ColorSpace,
    FromSaid,
    Height,
    Lookup,
    NoClobber,
    OneLookup,
    Part,
    Rotation,
    Size,
    Width,
    World,
    as_options,
    finite,
)
from spheremap.cli.terminal import (
    UsageError,
    as_usage,
    check_projection,
    progress,
    refuse,
)
from spheremap.io.images import STORED, TEXTURES
from spheremap.io.tonemap import Curve
from spheremap.map.flat import flat


def convert(
    context: typer.Context,
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="IN [OUT]", help="The image to read, and the one to write; with -o all are IN."
        ),
    ],
    to: Annotated[str, typer.Option("--to", metavar="NAME", help="Projection of OUT.")],
    from_: FromSaid = None,
    output: Annotated[
        str | None,
        typer.Option(
            "--output",
            "-o",
            metavar="PATTERN",
            help="Names of the results, as {stem}_cube.exr; - for standard output.",
        ),
    ] = None,
    format: Annotated[
        str | None, typer.Option("--format", metavar="NAME", help="Of standard output, as exr.")
    ] = None,
    height: Height = None,
    width: Width = None,
    size: Size = None,
    layout: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="How OUT lays out its faces; faces for a file each, as out_{face}.png. "
            "[default: cross or strip]",
        ),
    ] = None,
    from_layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How IN lays out its faces. [by default from its size]"),
    ] = None,
    face_names: Annotated[
        Literal["px", "posx", "0"],
        typer.Option(help="How {face} is written: px nx py ..., posx negx ..., or 0 1 2 ..."),
    ] = "px",
    rotate: Rotation = (0.0, 0.0, 0.0),
    world: World = "match",
    face_sun: Annotated[
        bool, typer.Option("--face-sun", help="Turn the sun to the center of OUT.")
    ] = False,
    filter: Lookup = "bilinear",
    fill: Annotated[float, typer.Option(metavar="X", help="Value where nothing is known.")] = 0.0,
    alias: OneLookup = False,
    alpha: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Weight colors by this channel, from 0; -1 for the last. "
            "[by default by straight alpha]",
        ),
    ] = None,
    skipna: Annotated[
        bool, typer.Option("--skipna", help="Leave NaN and infinite texels out of every mean.")
    ] = False,
    channels: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Keep these channels, as R,G,B.")
    ] = None,
    drop_alpha: Annotated[bool, typer.Option("--drop-alpha", help="Keep no alpha.")] = False,
    half: Annotated[bool, typer.Option("--half", help="Write half floats.")] = False,
    float_: Annotated[bool, typer.Option("--float", help="Write floats of 32 bits.")] = False,
    bits: Annotated[
        int | None, typer.Option(metavar="N", help="Write integers of 8 or 16 bits.")
    ] = None,
    colorspace: ColorSpace = None,
    tonemap: Annotated[
        Curve, typer.Option(help="How floats become integers; none cuts at 1.")
    ] = "none",
    exposure: Annotated[
        float,
        typer.Option(
            metavar="STOPS",
            callback=finite,
            help="Of the preview, and of floats in .png and .jpg.",
        ),
    ] = 0.0,
    preview: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Write a tone-mapped picture as well.")
    ] = None,
    compression: Annotated[
        str | None, typer.Option(metavar="NAME", help="As zip, piz or dwaa:45 for .exr.")
    ] = None,
    mips: Annotated[
        bool, typer.Option("--mips", help="Write all mips: .ktx2 and .dds hold them.")
    ] = False,
    part: Part = None,
    any_aspect: AnyAspect = False,
    no_clobber: NoClobber = False,
    memory: Annotated[
        str | None,
        typer.Option(
            metavar="N", help="Take so many bytes at most, as 512M: for files larger than that."
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="With --memory: go on where this was cut off.")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Say how long each step took.")
    ] = False,
) -> None:
    """Turn images from one projection into another.

    Integers keep their values among integers; as floats they are light, by the file's color space,
    and so are they the way back. Light above 1 is cut in .png and .jpg, or tone-mapped on request.
    """
    for name in (to, from_):
        if name is not None:
            check_projection(name)
    pairs = targets.pairs(paths, output, format)
    outputs = [out for _, out in pairs]
    textures = all(out.suffix.lower() in TEXTURES for out in outputs)
    with as_usage():
        whole = layout == "faces" or (textures and layout is None)
        dst = files.of_faces(to) if whole else flat(to, layout)
        if from_ is not None and from_layout is not None:
            flat(from_, from_layout)
        wanted = sizes.wanted(dst, height, width, size)
    _check_together(
        {"--half": half, "--float": float_, "--bits": bits is not None},
        {"--channels": channels is not None, "--drop-alpha": drop_alpha},
        {"--rotation": any(rotate), "--face-sun": face_sun},
        {"--tonemap": tonemap != "none", "--bits 16": bits == 16},
    )
    if bits not in (None, 8, 16):
        raise UsageError(f"--bits is 8 or 16, got {bits}")
    if memory is None:
        refuse(context, ["resume"], "without --memory")
    else:
        refuse(context, IDLE, "with --memory")
    _check_preview(preview, pairs)
    targets.check_outputs(outputs, layout, dst.faces)
    _refuse_idle(context, outputs, floats_only=textures or _holds_floats(outputs, bits, format))
    for out in outputs:
        if out.name != targets.STDOUT:
            io.check_target(out, compression=compression)

    options = Options(
        from_=from_, from_layout=from_layout, to=to, dst=dst, size=wanted, face_names=face_names,
        rotate=rotate, face_sun=face_sun, filter=filter, fill=fill, alias=alias, alpha=alpha,
        skipna=skipna, channels=channels.split(",") if channels else None, drop_alpha=drop_alpha,
        half=half, single=float_, bits=bits, color_space=colorspace, tonemap=tonemap,
        exposure=exposure, preview=preview, compression=compression, mips=mips, part=part,
        any_aspect=any_aspect, no_clobber=no_clobber, verbose=verbose, world=world,
        memory=None if memory is None else as_bytes(memory), resume=resume,
    )  # fmt: skip
    _all(context, pairs, options, stdout=f".{format}" if format else None)


def _all(
    context: typer.Context, pairs: list[tuple[Path, Path]], options: Options, *, stdout: str | None
) -> None:
    """Convert each file; of many, those that fail do not keep the others from it."""
    failures = 0
    work = convert_file if options.memory is None else convert_large
    with progress(len(pairs)) as step:
        for source, out in pairs:
            try:
                lines = work(source, out, options, step, stdout)
            except (OSError, ValueError, TypeError, MemoryError, UsageError) as error:
                if len(pairs) == 1:
                    raise
                failures += 1
                said = as_options(" ".join(str(error).split()), context.command.params)
                print(f"error: {source}: {said}", file=sys.stderr)
            else:
                print("\n".join(lines), file=sys.stderr if stdout else sys.stdout)
            step.done()
    if len(pairs) > 1:
        stream = sys.stderr if failures else sys.stdout
        print(f"{len(pairs) - failures} of {len(pairs)} images converted", file=stream)
    if failures:
        raise typer.Exit(1)


def _check_together(*groups: dict[str, bool]) -> None:
    """Raise a usage error where two options of a group are given."""
    for group in groups:
        given = [name for name, is_given in group.items() if is_given]
        if len(given) > 1:
            raise UsageError(f"give {given[0]} or {given[1]}, not both")


def _check_preview(preview: Path | None, pairs: list[tuple[Path, Path]]) -> None:
    if preview is None:
        return
    if STORED.get(preview.suffix.lower(), ("",))[0] != "uint8":
        raise UsageError(f"--preview is a .png or .jpg, got {str(preview)!r}")
    if len(pairs) > 1:
        raise UsageError("--preview is of one image")
    if preview.resolve() in [place.resolve() for place in pairs[0]]:
        raise UsageError(f"--preview would replace {str(preview)!r}, which is needed")
    io.check_target(preview)


def _holds_floats(outputs: list[Path], bits: int | None, format: str | None) -> bool:
    """Tell whether nothing but floats will be written, whatever the inputs are."""
    suffixes = [f".{format}"] if format else [out.suffix.lower() for out in outputs]
    kinds = [kind for suffix in suffixes for kind in STORED.get(suffix, ())]
    return bits is None and all(kind.startswith("float") for kind in kinds)


def _refuse_idle(context: typer.Context, outputs: list[Path], *, floats_only: bool) -> None:
    """Raise a usage error for an option that does nothing for these outputs."""
    textures = [out.suffix.lower() in TEXTURES for out in outputs]
    if floats_only:
        refuse(context, ["tonemap"], "where floats are written")
        if context.params["preview"] is None:
            refuse(context, ["exposure"], "where floats are written")
    if all(textures):
        why = "in .ktx2 and .dds, which hold half floats"
        refuse(context, ["compression", "half", "float_", "bits"], why)
    if not any(textures):
        refuse(context, ["mips"], "but in .ktx2 and .dds")
    if not any(targets.has_faces(out) for out in outputs):
        refuse(context, ["face_names"], "without {face} in the name of OUT")
