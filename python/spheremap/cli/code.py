"""The subcommand that prints maps in other languages."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import spheremap as sm
from spheremap import _core
from spheremap.cli.tables import print_table
from spheremap.cli.terminal import UsageError, as_usage, check_projection
from spheremap.io.whole import write_bytes


def code(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="A projection, as latlong, cube:unreal, angular(fov=180)."
        ),
    ] = None,
    language: Annotated[
        str | None, typer.Argument(metavar="LANGUAGE", help="One of those that --list shows.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="Where to, instead of the terminal."),
    ] = None,
    verbs: Annotated[
        str,
        typer.Option(
            metavar="VERBS", help="The functions: encode, decode, density, jacobian, valid."
        ),
    ] = "encode,decode",
    prefix: Annotated[
        str | None,
        typer.Option("--name", metavar="NAME", help="What names begin with.", show_default=False),
    ] = None,
    native: Annotated[
        bool,
        typer.Option("--native", help="The language's own sines and arctangents, not ours."),
    ] = False,
    double: Annotated[bool, typer.Option("--double", help="Numbers of 64 bits.")] = False,
    rotation: Annotated[
        tuple[float, float, float],
        typer.Option(metavar="YAW PITCH ROLL", help="Turn the map in the world, in degrees."),
    ] = (0.0, 0.0, 0.0),
    list_: Annotated[bool, typer.Option("--list", help="List the languages.")] = False,
) -> None:
    """Print encode, decode and more of a map as GLSL, HLSL, WGSL, C, CUDA, NumPy and others."""
    if list_:
        rows = [
            (entry["name"], entry["title"], f".{entry['extension']}", entry["promise"])
            for entry in _core.code_languages()
        ]
        print_table(("name", "language", "files", "bits"), rows)
        return
    if name is None or language is None:
        raise UsageError("give NAME and LANGUAGE, as in: spheremap code cube:unreal hlsl")
    check_projection(name)
    with as_usage():
        text = sm.code(
            name,
            language,
            verbs=[verb.strip() for verb in verbs.split(",") if verb.strip()],
            name=prefix,
            precision="native" if native else "exact",
            dtype="float64" if double else "float32",
            rotation=None if rotation == (0.0, 0.0, 0.0) else sm.rotation(*rotation),
        )
    if output is None:
        print(text, end="")
    else:
        write_bytes(output, text.encode())
