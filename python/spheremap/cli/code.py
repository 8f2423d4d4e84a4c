"""The subcommand that prints maps in other languages."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Literal

import typer

import spheremap as sm
from spheremap import _core
from spheremap.cli.tables import print_table
from spheremap.cli.terminal import UsageError, as_usage, check_projection
from spheremap.io.whole import write_bytes
from spheremap.map.effects import EFFECTS


def code(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="A projection, as latlong, cube:unreal, angular(fov=180), or a packing, as oct16; "
            f"with --effect a whole lookup: {', '.join(EFFECTS)}.",
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
        str | None,
        typer.Option(
            metavar="VERBS",
            help=f"The functions: {', '.join(_core.code_verbs())}; of a packing pack, unpack. "
            "The first two where nothing is said.",
            show_default=False,
        ),
    ] = None,
    prefix: Annotated[
        str | None,
        typer.Option("--name", metavar="NAME", help="What names begin with.", show_default=False),
    ] = None,
    native: Annotated[
        bool,
        typer.Option("--native", help="The language's own sines and arctangents, not ours."),
    ] = False,
    double: Annotated[bool, typer.Option("--double", help="Numbers of 64 bits.")] = False,
    rounding: Annotated[
        str,
        typer.Option(metavar="ROUNDING", help="How a packing rounds: precise, nearest, hex."),
    ] = "precise",
    rotation: Annotated[
        tuple[float, float, float],
        typer.Option(metavar="YAW PITCH ROLL", help="Turn the map in the world, in degrees."),
    ] = (0.0, 0.0, 0.0),
    effect: Annotated[
        bool,
        typer.Option("--effect", help="NAME is that of a whole lookup, with its textures."),
    ] = False,
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
    of_packing = not effect and _is_packing(name)
    if not of_packing and not effect:
        check_projection(name)
    asked = verbs or ("pack,unpack" if of_packing else "encode,decode")
    words = [verb.strip() for verb in asked.split(",") if verb.strip()]
    precision: Literal["exact", "native"] = "native" if native else "exact"
    dtype = "float64" if double else "float32"
    turned = rotation != (0.0, 0.0, 0.0)
    if of_packing and turned:
        raise UsageError("a packing is not turned; leave out --rotation")
    if not of_packing and rounding != "precise":
        raise UsageError(
            f"{'an effect' if effect else 'a map'} does not round; leave out --rounding"
        )
    if effect:
        given = {"--verbs": verbs, "--double": double, "--rotation": turned}
        for option in (option for option, value in given.items() if value):
            raise UsageError(
                f"an effect has maps, verbs and numbers of its own; leave out {option}"
            )
    with as_usage(), _in_words_of_the_command():
        if effect:
            text = sm.effect(name, language, name=prefix, precision=precision)
        elif of_packing:
            text = sm.packing.code(
                name,
                language,
                verbs=words,
                rounding=rounding,
                name=prefix,
                precision=precision,
                dtype=dtype,
            )
        else:
            text = sm.code(
                name,
                language,
                verbs=words,
                name=prefix,
                precision=precision,
                dtype=dtype,
                rotation=sm.rotation(*rotation) if turned else None,
            )
    if output is None:
        print(text, end="")
    else:
        write_bytes(output, text.encode())


def _is_packing(name: str) -> bool:
    try:
        sm.packing.packing(name)
    except ValueError:
        return False
    return True


@contextmanager
def _in_words_of_the_command() -> Iterator[None]:
    """Name options as they are called here."""
    try:
        yield
    except ValueError as error:
        raise ValueError(str(error).replace('dtype="float64"', "--double")) from None
