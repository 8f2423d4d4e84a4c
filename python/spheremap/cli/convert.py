"""The subcommand `spheremap convert`: images from one projection to another."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from spheremap import io
from spheremap.cli import inputs, targets
from spheremap.cli.asked import Asked
from spheremap.cli.conversion import Options
from spheremap.cli.large import convert_any
from spheremap.cli.options import as_options, taking
from spheremap.cli.terminal import UsageError, progress
from spheremap.io.images import STORED


@taking(Asked)
def convert(
    context: typer.Context,
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="IN [OUT]", help="The image to read, and the one to write; with -o all are IN."
        ),
    ],
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
    preview: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Write a tone-mapped picture as well.")
    ] = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Say how long each step took.")
    ] = False,
    *,
    asked: Asked,
) -> None:
    """Turn images from one projection into another.

    Integers keep their values among integers; as floats they are light, by the file's color space,
    and so are they the way back. Light above 1 is cut in .png and .jpg, or tone-mapped on request.
    """
    asked.check_names()
    pairs = inputs.pairs(paths, output, format)
    _check_preview(preview, pairs)
    outputs = [out for _, out in pairs]
    stdout = f".{format}" if format else None
    options = asked.options(context, outputs, stdout=stdout, preview=preview, verbose=verbose)
    for out in outputs:
        if out.name != targets.STDOUT:
            io.check_target(out, compression=asked.compression)
    _all(context, pairs, options, stdout=stdout)


def _all(
    context: typer.Context, pairs: list[tuple[Path, Path]], options: Options, *, stdout: str | None
) -> None:
    """Convert each file; of many, those that fail do not keep the others from it."""
    failures = 0
    with progress(len(pairs)) as step:
        for source, out in pairs:
            try:
                lines = convert_any(source, out, options, step, stdout)
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
