"""The subcommands of `spheremap`: they parse, report and leave the work to the library."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

import spheremap as sm
from spheremap import _core, io
from spheremap._names import ConvertFilter
from spheremap.cli import files
from spheremap.cli.ball import ball
from spheremap.cli.demo import run as run_demo
from spheremap.cli.terminal import (
    UsageError,
    as_usage,
    check_projection,
    progress,
    read,
    table_console,
    write,
)
from spheremap.io.images import STORED
from spheremap.map.table import HEAD, NOTE

app = typer.Typer(
    name="spheremap",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Environment maps, light probes and 360° images from one projection to another.",
)


FileIn = Annotated[Path, typer.Argument(metavar="FILE", help="An image file.")]
Name = Annotated[
    str, typer.Argument(metavar="NAME", help="A projection, as latlong or latlong:mitsuba.")
]


def run(arguments: Sequence[str]) -> int:
    """Run the command and return its exit code; every failure is one line on stderr."""
    command = typer.main.get_command(app)
    try:
        result = command.main(list(arguments), prog_name="spheremap", standalone_mode=False)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except BrokenPipeError:
        # Whoever read our output has left, as `head` does; the flush at exit must not complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (KeyboardInterrupt, typer.Abort):
        return _fail("interrupted", 130)
    except UsageError as error:
        return _fail(str(error), 2)
    except MemoryError as error:
        return _fail(str(error) or "out of memory", 1)
    except (OSError, ValueError, TypeError, ImportError, ArithmeticError) as error:
        return _fail(str(error), 1)
    except Exception as error:
        # The parser's own exceptions; typer keeps their class in different places by version.
        message = getattr(error, "format_message", None)
        if message is None:
            raise
        text = message()
        # Without arguments it says "help" by way of an exception with the whole help in it.
        if type(error).__name__ == "NoArgsIsHelpError":
            print(text, file=sys.stderr)
            return 2
        return _fail(text, 2)


def _fail(message: str, code: int) -> int:
    print("error: " + " ".join(message.split()), file=sys.stderr)
    return code


def _version(asked: bool) -> None:
    if asked:
        print(f"spheremap {sm.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    pass


@app.command()
def convert(
    source: Annotated[Path, typer.Argument(metavar="IN", help="The image to read.")],
    target: Annotated[Path, typer.Argument(metavar="OUT", help="The image to write.")],
    from_: Annotated[str, typer.Option("--from", metavar="NAME", help="Projection of IN.")],
    to: Annotated[str, typer.Option("--to", metavar="NAME", help="Projection of OUT.")],
    height: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Rows of OUT. [by default as IN]")
    ] = None,
    size: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Height of a latlong, side of a square or face."),
    ] = None,
    layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How OUT lays out its faces. [default: cross or strip]"),
    ] = None,
    from_layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How IN lays out its faces. [by default from its size]"),
    ] = None,
    rotate: Annotated[
        tuple[float, float, float],
        typer.Option(
            metavar="YAW PITCH ROLL",
            help="Turn the content about +y, +x and +z, in degrees.",
            show_default=False,
        ),
    ] = (0.0, 0.0, 0.0),
    filter: Annotated[ConvertFilter, typer.Option(help="The lookup.")] = "bilinear",
    fill: Annotated[float, typer.Option(metavar="X", help="Value where nothing is known.")] = 0.0,
    alias: Annotated[
        bool,
        typer.Option("--alias", help="One lookup a texel, also where OUT is coarser than IN."),
    ] = False,
    alpha: Annotated[
        int | None,
        typer.Option(metavar="N", help="Weight colors by this channel, from 0; -1 for the last."),
    ] = None,
    skipna: Annotated[
        bool, typer.Option("--skipna", help="Leave NaN and infinite texels out of every mean.")
    ] = False,
    preview: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Write a tone-mapped picture as well.")
    ] = None,
    exposure: Annotated[
        float, typer.Option(metavar="STOPS", help="Of the preview, and of floats in .png and .jpg.")
    ] = 0.0,
    compression: Annotated[
        str | None, typer.Option(metavar="NAME", help="As zip, piz or dwaa:45 for .exr.")
    ] = None,
    any_aspect: Annotated[
        bool, typer.Option("--any-aspect", help="Take an image of the wrong aspect as it is.")
    ] = False,
) -> None:
    """Turn an image from one projection into another.

    Floats stay floats. For .png and .jpg they are tone-mapped; integers keep their values.
    """
    check_projection(from_)
    check_projection(to)
    if height is not None and size is not None:
        raise UsageError("give --height or --size, not both")
    with as_usage():
        dst = files.flat(to, layout)
        if from_layout is not None:
            files.flat(from_, from_layout)
        wanted = size if height is None else files.size_of_height(dst, height)
    if preview is not None and STORED.get(preview.suffix.lower(), ("",))[0] != "uint8":
        raise UsageError(f"--preview is a .png or .jpg, got {str(preview)!r}")
    for place in (target, preview):
        if place is not None:
            io.check_target(place)

    with progress() as step:
        step(f"reading {source.name}")
        image = read(source)
        names = io.channel_names(source)
        src = files.of_file(from_, from_layout, *image.shape[:2], any_aspect=any_aspect)
        step(f"converting {files.described(src)} to {files.described(dst)}")
        start = time.perf_counter()
        result = sm.convert(
            image,
            src,
            dst,
            size=wanted,
            rotation=None if not any(rotate) else sm.rotation(*rotate),
            filter=filter,
            fill=fill,
            antialias=not alias,
            alpha=alpha,
            skipna=skipna,
        )
        seconds = time.perf_counter() - start
        step(f"writing {target.name}")
        write(target, result, exposure, compression, names)
        if preview is not None:
            step(f"writing {preview.name}")
            write(preview, result, exposure, None, names)
    texels = result.shape[0] * result.shape[1]
    print(
        f"{target}: {files.described(dst)}, {result.shape[1]} x {result.shape[0]}, "
        f"{', '.join(names)}, {result.dtype}; converted in {seconds:.3f} s "
        f"({texels / seconds / 1e6:.0f} Mtexel/s)"
    )


@app.command()
def bake(
    source: Annotated[Path, typer.Argument(metavar="IN", help="The environment to read.")],
    folder: Annotated[Path, typer.Argument(metavar="OUT", help="The folder to write to.")],
    from_: Annotated[
        str, typer.Option("--from", metavar="NAME", help="Projection of IN.")
    ] = "latlong",
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
    skipna: Annotated[
        bool, typer.Option("--skipna", help="Count NaN and infinite texels as 0.")
    ] = False,
) -> None:
    """Make what a renderer needs of an environment: cube maps as KTX2 and DDS, harmonics as JSON.

    Without --diffuse, --specular and --sh it makes all three.
    """
    check_projection(from_)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"cannot write {str(folder)!r}: it is no folder")
    if levels is not None and size >> (levels - 1) < 1:
        raise UsageError(f"--size {size} has at most {size.bit_length()} levels, got {levels}")
    everything = not (diffuse or specular or sh)
    with progress() as step:
        step(f"reading {source.name}")
        image = read(source)
        src = files.of_file(from_, None, *image.shape[:2], any_aspect=False)
        step(f"baking {files.described(src)}")
        start = time.perf_counter()
        # Alpha is no light.
        baked = sm.light.bake(
            image[..., :3] if image.shape[-1] > 3 else image,
            src,
            diffuse=diffuse or everything,
            specular=specular or everything,
            sh=sh or everything,
            size=size,
            levels=levels,
            diffuse_size=diffuse_size,
            order=order,
            samples=samples,
            skipna=skipna,
        )
        seconds = time.perf_counter() - start
        step(f"writing {folder.name}")
        written = baked.write(folder)
    print(f"{source}: {files.described(src)}, baked in {seconds:.3f} s")
    for place, what in written:
        print(f"{place}: {what}, {place.stat().st_size} bytes")


app.command()(ball)


@app.command()
def info(
    file: FileIn,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help="Projection for the light report; by default what its aspect suggests.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Tell what an image holds, which projections it may be, and its light."""
    if from_ is not None:
        check_projection(from_)
    with progress() as step:
        step(f"reading {file.name}")
        image = read(file)
        names = io.channel_names(file)
        height, width, count = image.shape
        heads = "channel", "min", "max", "mean", "NaN", "infinite", "negative"
        table = Table(*heads, box=SIMPLE_HEAD)
        for column in table.columns[1:]:
            column.justify = "right"
        for name, values in zip(names, np.moveaxis(image, -1, 0), strict=True):
            finite = values[np.isfinite(values)]
            numbers = (
                [f"{finite.min():g}", f"{finite.max():g}", f"{finite.mean(dtype=np.float64):.6g}"]
                if finite.size
                else ["-"] * 3
            )
            counts = [np.isnan(values), np.isinf(values), values < 0]
            table.add_row(escape(name), *numbers, *(str(np.count_nonzero(c)) for c in counts))
        step("adding up its light")
        light = _light(image, from_)
    console = table_console()
    print(file)
    print(f"  size      {width} x {height}")
    print(f"  channels  {count} ({', '.join(names)})")
    print(f"  dtype     {image.dtype}")
    print(f"  fits      {', '.join(files.fitting(height, width)) or 'no projection as it is'}")
    console.print(table)
    if light is not None:
        print(light)


def _light(image: np.ndarray[Any, Any], name: str | None) -> str | None:
    """Return the energy report of an image, unless there is no saying what it is."""
    height, width, count = image.shape
    if name is None and (count not in (1, 3, 4) or not files.fitting(height, width)):
        return None
    name = name or files.likely(height, width)
    p = files.of_file(name, None, height, width, any_aspect=False)
    lines = str(sm.light.energy(image, p, skipna=True)).splitlines()
    return "\n  ".join([f"  light     as {files.described(p)}", *lines])


@app.command()
def projections(
    coverage: Annotated[
        str | None,
        typer.Option(help="Those that hold this part of the sphere: sphere, hemisphere ..."),
    ] = None,
    equal_area: Annotated[bool, typer.Option("--equal-area", help="Those of even texels.")] = False,
    conformal: Annotated[
        bool, typer.Option("--conformal", help="Those that keep small circles round.")
    ] = False,
) -> None:
    """List the projections, with what there is to choose one by."""
    with as_usage():
        chosen = sm.projections(
            coverage=coverage, equal_area=equal_area or None, conformal=conformal or None
        )
    head = ("name", "what", *HEAD[1:], "layouts", "conventions")
    table = Table(*head, box=SIMPLE_HEAD)
    entries = {entry["name"]: entry for entry in _core.registry()}
    for row in chosen.figures:
        entry = entries[row.name]
        table.add_row(
            f"[bold]{escape(row.name)}[/]",
            escape(entry["title"]),
            *row.cells[1:],
            ", ".join(entry["layouts"]),
            ", ".join(entry["conventions"]),
        )
    table_console().print(table)
    print(NOTE)


@app.command()
def explain(name: Name) -> None:
    """Tell where ±x, ±y, ±z land in an image, which way is up, and more."""
    check_projection(name)
    print(sm.projection(name).explanation().rstrip("\n"))


@app.command()
def conventions(
    kind: Annotated[
        str | None, typer.Argument(metavar="[KIND]", help="A projection, as latlong.")
    ] = None,
) -> None:
    """List how named programs lay out their maps."""
    with as_usage():
        rows = sm.conventions(kind)
    table = Table("name", "axes", "mirrored", "grid", "layout", "known by", box=SIMPLE_HEAD)
    for row in rows:
        name = f"{row['kind']}:{row['name']}"
        table.add_row(
            f"[bold]{escape(name)}[/]",
            row["axes"],
            "yes" if sm.projection(name).mirrored else "no",
            row["grid"],
            row["layout"] or "",
            row["verified"],
        )
    table_console().print(table)


@app.command()
def compare(
    a: Annotated[str, typer.Argument(metavar="A", help="A projection, as latlong:mitsuba.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Another.")],
) -> None:
    """Tell what turns one convention into another."""
    check_projection(a)
    check_projection(b)
    print(sm.align.compare(a, b))


@app.command()
def identify(
    first: Annotated[Path, typer.Argument(metavar="A", help="An image whose map is known.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="The same scene, of another map.")],
    first_as: Annotated[
        str | None, typer.Option("--a", metavar="NAME", help="Map of A. [by default from its size]")
    ] = None,
    second_as: Annotated[
        str | None,
        typer.Option("--b", metavar="NAME", help="Projection of B. [by default from its size]"),
    ] = None,
) -> None:
    """Find the axes and the yaw that relate two images of one scene.

    The exit code is 1 where it cannot tell.
    """
    images, maps = [], []
    with progress() as step:
        for path, name in ((first, first_as), (second, second_as)):
            step(f"reading {path.name}")
            if name is not None:
                check_projection(name)
            image = read(path)
            height, width = image.shape[:2]
            images.append(image)
            name = name or files.likely(height, width)
            maps.append(files.of_file(name, None, height, width, any_aspect=False))
        step("comparing")
        found = sm.align.identify(images[0], images[1], maps[0], maps[1])
    print(f"A is taken as {files.described(maps[0])}, B as {files.described(maps[1])}")
    print(found)
    if not found.certain:
        raise typer.Exit(1)


@app.command()
def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where to put the pictures.")],
    input: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A real image instead of our own sky.")
    ] = None,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help="Projection of the input; by default what its aspect suggests.",
            show_default=False,
        ),
    ] = None,
    size: Annotated[int, typer.Option(min=16, metavar="N", help="Rows of our own sky.")] = 1024,
) -> None:
    """Show a sky, or an image of yours, in every projection, and measure."""
    if from_ is not None:
        check_projection(from_)
    with progress() as step:
        report = run_demo(folder, input, from_, size, step)
    table = Table(
        "projection", "image", "covers", "convert", "encode", "round trip", box=SIMPLE_HEAD
    )
    for column in table.columns[1:]:
        column.justify = "right"
    for row in report.rows:
        table.add_row(
            row.name,
            f"{row.width} x {row.height}",
            f"{row.covers:.0%}",
            f"{row.mtexels:.0f} Mtexel/s",
            f"{row.mdirections:.0f} Mdirection/s",
            f"{row.error:.2%}",
        )
    console = table_console()
    print(f"source    {report.source}")
    console.print(table)
    print("round trip: latlong to the projection and back, mean |error| / mean |value|")
    print("over what the projection covers")
    print(f"wrote     {report.sheet} and {len(report.rows)} .exr files beside it")
