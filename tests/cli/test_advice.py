"""Every option that a message names is one of the command that says it."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from other_files import put_parts
from spheremap import cli, io
from spheremap.cli.app import COMMANDS, parser_of
from spheremap.cli.options import as_options
from test_cli import bad, good, run

FOLDER = Path(cli.__file__).parent
# These hold the words of all commands.
OF_ALL = ("app", "completion", "options")
OPTION = re.compile(r"(\w+ )?(?<![\w-])(--[a-z][a-z-]*)")


@cache
def options(command: str) -> set[str]:
    parameters = parser_of([command]).commands[command].params
    return {"--help"} | {word for parameter in parameters for word in parameter.opts}


@cache
def tree(module: str) -> ast.Module:
    return ast.parse((FOLDER / f"{module}.py").read_text(encoding="utf-8"))


def imported(node: ast.AST) -> set[str]:
    found = set()
    for each in ast.walk(node):
        if isinstance(each, ast.ImportFrom) and each.module == "spheremap.cli":
            found |= {name.name for name in each.names}
        elif isinstance(each, ast.ImportFrom) and (each.module or "").startswith("spheremap.cli."):
            found.add((each.module or "").removeprefix("spheremap.cli."))
    return found


def named(node: ast.AST) -> set[str]:
    """Give the options that texts name as the command's own: not as those of another program."""
    found = set()
    for each in ast.walk(node):
        if isinstance(each, ast.Constant) and isinstance(each.value, str):
            for before, option in OPTION.findall(each.value):
                if before.strip() not in COMMANDS:
                    found.add(option)
                else:
                    assert option in options(before.strip()), each.value
    return found


def said_by(command: str) -> dict[str, set[str]]:
    """Give what a command's function and the modules that it can reach name."""
    module = COMMANDS[command].module
    function = next(
        node
        for node in tree(module).body
        if isinstance(node, ast.FunctionDef) and node.name == command
    )
    several = sum(entry.module == module for entry in COMMANDS.values()) > 1
    start: ast.AST = function if several else tree(module)
    found, waiting = {module: named(start)}, imported(start)
    if several:
        # What the function uses of what its module imports.
        used = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
        for node in tree(module).body:
            if isinstance(node, ast.ImportFrom):
                names = {name.asname or name.name for name in node.names}
                waiting |= imported(node) & names & used
                waiting |= imported(node) if (node.module or "") != "spheremap.cli" else set()
    while waiting:
        one = waiting.pop()
        if one not in found and one not in OF_ALL:
            found[one] = named(tree(one))
            waiting |= imported(tree(one))
    return found


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_that_a_text_names_is_there(command: str) -> None:
    if COMMANDS[command].module in OF_ALL:
        return
    for module, names in said_by(command).items():
        assert names <= options(command), (command, module)


def test_the_walk_sees_what_it_is_for() -> None:
    assert "--any-aspect" in said_by("bake")["bake"]
    assert {"--half", "--bits"} <= said_by("convert")["conversion"]
    assert "files" in said_by("identify") and "picture" in said_by("demo")


def test_an_odd_image_is_baked_on_request(tmp_path: Path) -> None:
    odd, out = tmp_path / "odd.exr", tmp_path / "out"
    io.write(odd, np.ones((30, 50, 3), np.float32))
    line = bad("bake", odd, out, code=1, says="50 x 30")
    assert "--any-aspect takes it as it is" in line
    good("bake", odd, out, "--any-aspect", "--sh")
    assert (out / "sh.json").exists()
    for command in (("identify", odd, odd), ("demo", out, "--input", odd)):
        assert "--" not in bad(*command, code=1, says="50 x 30")


def test_arguments_of_the_library_are_named_as_options(tmp_path: Path) -> None:
    image = np.ones((16, 32, 3), np.float32)
    image[2, 3] = np.nan
    io.write(tmp_path / "a.exr", image)
    bake = ("bake", tmp_path / "a.exr", tmp_path / "out", "--sh")
    bad(*bake, code=1, says="--skipna counts them as 0")
    good(*bake, "--skipna")
    bad(
        "ball", tmp_path / "a.exr", "-o", tmp_path / "b.exr",
        code=1, says="no ball found in the photo; give its --rim",
    )  # fmt: skip
    done = run("ball", tmp_path / "a.exr", "-o", tmp_path / "b.exr", "--rim", "16,8,7")
    assert "neither --fov nor --distance is given" in done.stderr


@pytest.mark.parametrize("command", ["convert", "video"])
def test_the_way_out_of_an_aspect_is_an_option(command: str) -> None:
    with pytest.raises(ValueError) as caught:
        sm.convert(np.zeros((8, 8)), "latlong", "cube")
    said = as_options(str(caught.value), parser_of([command]).commands[command].params)
    assert said.endswith(" --any-aspect takes it as it is, stretched.")


@pytest.mark.parametrize("command", ["convert", "info", "bake", "ball", "identify", "demo"])
def test_parts_are_asked_for_by_an_option(command: str, tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    put_parts(path, {"left": 0.0, "right": 1.0})
    arguments = {
        "convert": (path, tmp_path / "b.exr", "--from", "latlong", "--to", "cube"),
        "info": (path,),
        "bake": (path, tmp_path / "out"),
        "ball": (path, "-o", tmp_path / "b.exr"),
        "identify": (path, path),
        "demo": (tmp_path / "out", "--input", path),
    }[command]
    bad(command, *arguments, code=1, says="0 (left), 1 (right); say which --part to read")
    line = bad(command, *arguments, "--part", "middle", code=1, says="no part 'middle'")
    assert "`" not in line
