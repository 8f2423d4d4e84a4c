"""The command and its subcommands, each imported when it is asked for."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import typer

import spheremap as sm
from spheremap.cli.options import as_options
from spheremap.cli.streams import print_anywhere
from spheremap.cli.terminal import UsageError


class Command(NamedTuple):
    """Where a subcommand is: its module in `spheremap.cli`, and examples for its help."""

    module: str
    examples: tuple[str, ...]


COMMANDS = {
    "convert": Command(
        "convert",
        (
            "spheremap convert sky.exr cube.exr --from latlong --to cube --size 512",
            "spheremap convert probe.hdr sky.exr --from angular --to latlong --rotation 90 0 0",
        ),
    ),
    "batch": Command(
        "batch",
        (
            "spheremap batch 'in/**/*.exr' -o 'out/{dir}/{stem}.ktx2' --from latlong --to cube",
            "spheremap batch '*.hdr' -o '{stem}.exr' --from angular --to latlong --jobs 4",
        ),
    ),
    "bake": Command(
        "bake",
        (
            "spheremap bake studio.exr baked",
            "spheremap bake probe.exr baked --from angular --specular --size 512",
        ),
    ),
    "ball": Command(
        "ball",
        (
            "spheremap ball a.exr b.exr -o sky.exr --fov 30 --distance 20",
            "spheremap ball ball.exr -o sky.exr --metal Cr --preview rims.png",
        ),
    ),
    "views": Command(
        "views",
        (
            "spheremap views panoramas -o scene --n 12 --size 1600 --masks --photographer 35",
            "spheremap views pano.jpg -o splats --fov 90 --format nerfstudio",
        ),
    ),
    "stitch": Command(
        "stitch",
        (
            "spheremap stitch raw.jpg -o pano.jpg --cameras 'dual_fisheye(fov=200)'",
            "spheremap stitch a.png b.png -o pano.png --cameras camchain.yaml --fov 195 "
            "--match-exposure",
            "spheremap stitch scene/images -o pano.jpg --cameras scene --blend bands",
        ),
    ),
    "view": Command(
        "view",
        (
            "spheremap view sky.exr",
            "spheremap view probe.exr --from angular -o look.html",
            "spheremap view before.exr after.exr -o both.html --open",
            "spheremap view sky.exr --overlay graticule,lights,sun -o look.html",
        ),
    ),
    "video": Command(
        "video",
        (
            "spheremap video in.mp4 out.mp4 --from 'dual_fisheye(fov=190)' --to latlong",
            "spheremap video sky.mp4 view.mp4 --to 'perspective(fov=90)' --keyframes turn.csv",
            "spheremap video sky.mp4 cube.mkv --to cube --codec libx265 --option crf=22",
        ),
    ),
    "tiles": Command(
        "tiles",
        (
            "spheremap tiles sky.exr web --format pannellum --tonemap reinhard",
            "spheremap tiles panorama.png web --format marzipano --size 4k",
            "spheremap tiles sky.exr survey --format hips --extension fits --channels G",
        ),
    ),
    "info": Command("info", ("spheremap info sky.exr", "spheremap info probe.exr --from angular")),
    "projections": Command(
        "commands",
        ("spheremap projections", "spheremap projections --coverage sphere --equal-area"),
    ),
    "explain": Command("commands", ("spheremap explain cube", "spheremap explain latlong:mitsuba")),
    "code": Command(
        "code",
        (
            "spheremap code cube:unreal hlsl",
            'spheremap code "angular(fov=180)" wgsl -o angular.wgsl',
            "spheremap code --list",
        ),
    ),
    "conventions": Command("commands", ("spheremap conventions latlong",)),
    "compare": Command("commands", ("spheremap compare latlong:mitsuba latlong:blender",)),
    "identify": Command("commands", ("spheremap identify known.exr unknown.exr --a latlong",)),
    "demo": Command("commands", ("spheremap demo pictures --input sky.exr",)),
    "completion": Command(
        "completion",
        (
            "spheremap completion bash > ~/.local/share/bash-completion/completions/spheremap",
            "spheremap completion zsh >> ~/.zshrc",
            "spheremap completion fish > ~/.config/fish/completions/spheremap.fish",
        ),
    ),
}


def run(arguments: Sequence[str]) -> int:
    """Run the command and return its exit code; every failure is one line on stderr."""
    print_anywhere()
    # The parser's checks need none, and a look for some through all that is installed takes long.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    parameters: list[Any] = []
    try:
        parser, program, words = _parser(list(arguments))
        parameters = parser.params
        result = parser.main(words, prog_name=program, standalone_mode=False)
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
        return _fail(as_options(str(error), parameters) or "out of memory", 1)
    except (OSError, ValueError, TypeError, ImportError, ArithmeticError) as error:
        return _fail(as_options(str(error), parameters), 1)
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


def _parser(arguments: list[str]) -> tuple[Any, str, list[str]]:
    """Return the parser: of a subcommand alone where the first word is one; and what it parses."""
    if arguments and arguments[0] in COMMANDS:
        # The parser of all would look at its own options first, for which it loads its checks.
        name, *rest = arguments
        return parser_of([name]).commands[name], f"spheremap {name}", rest
    return parser_of(COMMANDS), "spheremap", arguments


def parser_of(names: Iterable[str]) -> Any:
    """Return the parser of the command with these subcommands, which are imported for it."""
    settings = {"help_option_names": ["-h", "--help"], "max_content_width": 100}
    app = typer.Typer(
        name="spheremap",
        add_completion=False,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings=settings,
        help="Environment maps, light probes and 360° images from one projection to another.",
        epilog="spheremap COMMAND --help has examples of each.",
    )
    app.callback()(_root)
    for name in names:
        module, examples = COMMANDS[name]
        # \b keeps the lines that follow from being filled.
        epilog = "\b\nExamples:\n" + "\n".join(f"  {example}" for example in examples)
        function = getattr(import_module(f"spheremap.cli.{module}"), name)
        app.command(name, epilog=epilog, context_settings=settings)(function)
    return typer.main.get_command(app)


def _fail(message: str, code: int) -> int:
    print("error: " + " ".join(message.split()), file=sys.stderr)
    return code


def _version(asked: bool) -> None:
    if asked:
        print(f"spheremap {sm.__version__}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    pass
