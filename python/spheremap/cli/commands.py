"""The subcommands about maps: projections, explain, conventions, compare, identify, demo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import spheremap as sm
from spheremap.cli import files, picture
from spheremap.cli.options import FromGuess, Part
from spheremap.cli.tables import print_table
from spheremap.cli.terminal import as_usage, check_projection, progress, refuse
from spheremap.map.named import registered
from spheremap.map.table import HEAD, NOTE

Name = Annotated[
    str,
    typer.Argument(
        metavar="NAME", help="A projection, as latlong, latlong:mitsuba, perspective(fov=60)."
    ),
]


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
    heads = (*HEAD, "layouts", "conventions", "what")
    entries = {entry["name"]: entry for entry in registered()}
    rows = []
    for row in chosen.figures:
        entry = entries[row.name]
        rows.append(
            (
                *row.cells,
                ", ".join(entry["layouts"]),
                ", ".join(entry["conventions"]),
                entry["title"],
            )
        )
    print_table(heads, rows)
    print(NOTE)


def explain(name: Name) -> None:
    """Tell where ±x, ±y, ±z land in an image, which way is up, and more."""
    check_projection(name)
    print(sm.projection(name).explanation().rstrip("\n"))


def conventions(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="A projection, as latlong, or a program, as unity."),
    ] = None,
) -> None:
    """List how named programs lay out their maps."""
    with as_usage():
        rows = sm.conventions(name)
    table = []
    for row in rows:
        map_name = f"{row['kind']}:{row['name']}"
        mirrored = "yes" if sm.projection(map_name).mirrored else "no"
        up = row["up"] + (" (left-handed)" if row["left_handed"] else "")
        of_world = (row["axes"], mirrored, up, row["forward"])
        table.append((map_name, *of_world, row["grid"], row["layout"] or "", row["verified"]))
    head = ("name", "axes", "mirrored", "up", "ahead", "grid", "layout", "known by")
    print_table(head, table)


def compare(
    a: Annotated[str, typer.Argument(metavar="A", help="A projection, as latlong:mitsuba.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Another.")],
) -> None:
    """Tell what turns one convention into another."""
    check_projection(a)
    check_projection(b)
    print(sm.align.compare(a, b))


def identify(
    first: Annotated[Path, typer.Argument(metavar="A", help="An image whose map is known.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="The same scene, of another map.")],
    first_as: Annotated[
        str | None,
        typer.Option(
            "--a",
            metavar="NAME",
            help="Projection of A; by default what it says, or its aspect suggests.",
            show_default=False,
        ),
    ] = None,
    second_as: Annotated[
        str | None,
        typer.Option("--b", metavar="NAME", help="Projection of B.", show_default=False),
    ] = None,
    part: Part = None,
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
            loaded = picture.load(path, part=part)
            images.append(loaded.pixels)
            maps.append(files.taken(name, loaded.projection, *loaded.pixels.shape[:2]))
        step("comparing")
        with step.listening():
            found = sm.align.identify(images[0], images[1], maps[0], maps[1])
    print(f"A is taken as {files.described(maps[0])}, B as {files.described(maps[1])}")
    print(found)
    if not found.certain:
        raise typer.Exit(1)


def demo(
    context: typer.Context,
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where to put the pictures.")],
    input: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A real image instead of our own sky.")
    ] = None,
    from_: FromGuess = None,
    part: Part = None,
    size: Annotated[int, typer.Option(min=16, metavar="N", help="Rows of our own sky.")] = 1024,
) -> None:
    """Show a sky, or an image of yours, in every projection, and measure."""
    from spheremap.cli.demo import run as run_demo

    if input is None:
        refuse(context, ["from_", "part"], "without --input")
    else:
        refuse(context, ["size"], "with --input, whose size it is")
    if from_ is not None:
        check_projection(from_)
    with progress(len(sm.projections())) as step:
        report = run_demo(folder, input, from_, part, size, step)
    print(f"source    {report.source}")
    print_table(
        ("projection", "image", "covers", "convert", "encode", "round trip"),
        [
            (
                row.name,
                f"{row.width} x {row.height}",
                f"{row.covers:.0%}",
                f"{row.mtexels:.0f} Mtexel/s",
                f"{row.mdirections:.0f} Mdirection/s",
                f"{row.error:.2%}",
            )
            for row in report.rows
        ],
        numbers=True,
    )
    print("round trip: latlong to the projection and back, mean |error| / mean |value|")
    print("over what the projection covers")
    print(f"wrote     {report.sheet} and {len(report.rows)} .exr files beside it")
