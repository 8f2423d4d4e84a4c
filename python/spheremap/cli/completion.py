"""The subcommand `spheremap completion`: what a shell needs to finish words after `spheremap`."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Annotated, Any, get_args

import typer

import spheremap as sm
from spheremap._names import ConvertFilter

# Options with a list of values, empty for the names of projections.
_VALUES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("--from", "--to", "--a", "--b"), ()),
    "--filter": get_args(ConvertFilter),
}
# Subcommands whose arguments are the names of projections.
_NAMED_ARGUMENTS = ("explain", "compare", "conventions", "code")


class Shell(StrEnum):
    """A shell that can complete."""

    bash = "bash"
    zsh = "zsh"
    fish = "fish"


def completion(
    shell: Annotated[Shell, typer.Argument(help="The shell that shall complete.")],
) -> None:
    """Print what a shell needs to complete commands, options and projections.

    It is a list that the shell reads once; to complete a word starts no Python.
    """
    from spheremap.cli.app import COMMANDS, parser_of

    parsers = parser_of(COMMANDS).commands
    commands = {name: _options(parser) for name, parser in parsers.items()}
    print((_fish if shell is Shell.fish else _bash)(commands, shell is Shell.zsh), end="")


def _options(command: Any) -> dict[str, str]:
    """Return the options of a subcommand, and what each is for."""
    options = {"--help": "Show this message and exit."}
    for parameter in command.params:
        if parameter.param_type_name == "option":
            options.update((word, parameter.help or "") for word in parameter.opts)
    return options


def _values(option: str) -> Sequence[str]:
    return _VALUES[option] or sm.projections()


def _bash(commands: dict[str, dict[str, str]], zsh: bool) -> str:
    names = " ".join(sm.projections())
    after = [f'        {option}) words="{" ".join(_values(option))}" ;;' for option in _VALUES]
    inside = []
    for command, options in commands.items():
        plain = names if command in _NAMED_ARGUMENTS else ""
        inside.append(f'        {command}) options="{" ".join(options)}"; words="{plain}" ;;')
    lines = [
        *(["autoload -U +X bashcompinit && bashcompinit"] if zsh else []),
        "_spheremap() {",
        '    local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}"',
        '    local options="--help --version" words=""',
        '    case "${COMP_WORDS[1]}" in',
        *inside,
        "    esac",
        f'    [ "$COMP_CWORD" -eq 1 ] && words="{" ".join(commands)}"',
        '    case "$before" in',
        *after,
        "    esac",
        '    case "$word" in -*) words="$options" ;; esac',
        '    COMPREPLY=($(compgen -W "$words" -- "$word"))',
        "}",
        "complete -o default -F _spheremap spheremap",
    ]
    return "\n".join(lines) + "\n"


def _fish(commands: dict[str, dict[str, str]], _: bool) -> str:
    names = " ".join(sm.projections())
    lines = [f'complete -c spheremap -n __fish_use_subcommand -a "{" ".join(commands)}"']
    for command, options in commands.items():
        start = f'complete -c spheremap -n "__fish_seen_subcommand_from {command}"'
        for option, what in options.items():
            taken = f' -x -a "{" ".join(_values(option))}"' if option in _VALUES else ""
            dash = "-l" if option.startswith("--") else "-s"
            quoted = what.replace("\\", "\\\\").replace("'", "\\'")
            lines.append(f"{start} {dash} {option.lstrip('-')}{taken} -d '{quoted}'")
        if command in _NAMED_ARGUMENTS:
            lines.append(f'{start} -f -a "{names}"')
    return "\n".join(lines) + "\n"
