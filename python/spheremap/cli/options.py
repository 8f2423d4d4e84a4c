"""Options that several subcommands have, and how messages name them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import MISSING, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Annotated, Any, Literal, get_type_hints

import typer

from spheremap._names import ConvertFilter

World = Annotated[
    Literal["match", "literal"],
    typer.Option(help="Keep up, ahead and right where the programs' worlds differ; or (x, y, z)."),
]
FromGuess = Annotated[
    str | None,
    typer.Option(
        "--from",
        metavar="NAME",
        help="Projection of the image; by default what it says, or its aspect suggests.",
        show_default=False,
    ),
]
FromSaid = Annotated[
    str | None,
    typer.Option("--from", metavar="NAME", help="Projection of IN. [default: what IN says]"),
]
Height = Annotated[
    str | None, typer.Option(metavar="N", help="Rows of OUT, as 1024 or 1k. [by default as IN]")
]
Width = Annotated[str | None, typer.Option(metavar="N", help="Columns of OUT, as 4k.")]
Size = Annotated[
    str | None, typer.Option(metavar="N", help="Height of a latlong, side of a square or face.")
]
Rotation = Annotated[
    tuple[float, float, float],
    typer.Option(
        "--rotation",
        metavar="YAW PITCH ROLL",
        help="Turn the content about +y, +x and +z of IN's world, in degrees.",
        show_default=False,
    ),
]
Lookup = Annotated[ConvertFilter, typer.Option(help="The lookup.")]
OneLookup = Annotated[
    bool,
    typer.Option("--no-antialias", help="One lookup a texel, also where OUT is coarser than IN."),
]
NoClobber = Annotated[bool, typer.Option("--no-clobber", help="Replace no file that is there.")]
Part = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Which image of a file of several, or its number."),
]
Memory = Annotated[
    str | None,
    typer.Option(
        metavar="N", help="Take so many bytes at most, as 512M: for files larger than that."
    ),
]
ColorSpace = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Of IN, whatever it says: sRGB, linear, ACEScg ..."),
]
AnyAspect = Annotated[
    bool, typer.Option("--any-aspect", help="Take an image of the wrong aspect as it is.")
]


def finite(value: float | None) -> float | None:
    """Return the number that an option has, or raise what says that it is none."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"{value} is no number to reckon with")
    return value


Exposure = Annotated[
    float, typer.Option(metavar="STOPS", callback=finite, help="How much brighter light is.")
]


def as_options(message: str, parameters: Iterable[Any]) -> str:
    """Return a message of the library with the command's options for arguments of their names."""
    options = {parameter.name.strip("_"): max(parameter.opts, key=len) for parameter in parameters}

    def option(found: re.Match[str]) -> str:
        name = options.get(found[1], "")
        return name if name.startswith("--") else found[0] if found[2] else found[1]

    return re.sub(r"`(\w+)(=True)?`", option, message)


def taking(kind: type[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the fields of a dataclass as options; it gets them together, as its last."""
    types = get_type_hints(kind, include_extras=True)
    names = [field.name for field in fields(kind)]
    options = [
        Parameter(
            field.name,
            Parameter.KEYWORD_ONLY,
            default=Parameter.empty if field.default is MISSING else field.default,
            annotation=types[field.name],
        )
        for field in fields(kind)
    ]

    def taken(command: Callable[..., None]) -> Callable[..., None]:
        own = [
            p for p in signature(command, eval_str=True).parameters.values() if p.name != "asked"
        ]

        @wraps(command)
        def run(**given: Any) -> None:
            asked = kind(**{name: given.pop(name) for name in names})
            command(**given, asked=asked)

        run.__signature__ = Signature([*own, *options])  # type: ignore[attr-defined]
        return run

    return taken
