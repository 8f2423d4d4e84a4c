"""What makes a command line pleasant: help, completion, any terminal, no option in vain."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import io
from spheremap.cli.app import COMMANDS
from terminals import needs_terminal, on_terminal
from test_cli import bad, good


def shell(*arguments: object, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-W", "error", "-m", "spheremap", *map(str, arguments)],
        capture_output=True,
        timeout=300,
        env={**os.environ, **environment},
        check=False,
    )


def test_the_package_is_the_command() -> None:
    done = shell("--version")
    assert (done.returncode, done.stdout) == (0, f"spheremap {sm.__version__}\n".encode())


@pytest.mark.parametrize("command", COMMANDS)
def test_short_help_has_examples_that_parse(command: str) -> None:
    text = good(command, "-h")
    assert text == good(command, "--help")
    assert "Usage" in text and "Examples:" in text
    for example in COMMANDS[command].examples:
        assert f"  {example}" in text.splitlines() or f"    {example}" in text.splitlines()
        program, subcommand, *words = example.split(">")[0].split()
        assert (program, subcommand) == ("spheremap", command)
        # An option that there is, unless it is a number below 0.
        assert all(word in text for word in words if word.startswith("--"))


def test_a_code_page_without_the_letters_spells_them(tmp_path: Path) -> None:
    io.write(tmp_path / "a.exr", np.ones((8, 16, 3), np.float32))
    done = shell("info", tmp_path / "a.exr", PYTHONIOENCODING="cp1252")
    assert done.returncode == 0, done.stderr
    assert "(integral of L domega)" in done.stdout.decode("cp1252")
    done = shell("info", tmp_path / "a.exr", PYTHONIOENCODING="utf-8")
    assert "(∫ L dω)" in done.stdout.decode()
    done = shell("info", "π.exr", PYTHONIOENCODING="ascii")
    assert done.returncode == 1 and b"Traceback" not in done.stderr


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize(
    ("words", "answers"),
    [
        (["con"], ["convert", "conventions"]),
        (["bake", "--dif"], ["--diffuse", "--diffuse-size"]),
        (["convert", "a.exr", "--to", "hemioct"], ["hemioctahedral"]),
        (["explain", "merc"], ["mercator"]),
        (["convert", "--filter", "catmull"], ["catmull-rom"]),
    ],
)
def test_bash_completes(words: list[str], answers: list[str], tmp_path: Path) -> None:
    (tmp_path / "script").write_text(good("completion", "bash"))
    line = " ".join(["spheremap", *words])
    ask = (
        f"source {tmp_path}/script; COMP_WORDS=({line}); COMP_CWORD={len(words)}; _spheremap; "
        'echo "${COMPREPLY[@]}"'
    )
    done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout.split() == answers


def test_zsh_and_fish_get_all_commands() -> None:
    for name in ("zsh", "fish"):
        text = good("completion", name)
        assert all(command in text for command in COMMANDS)
        assert "diffuse-size" in text and "octahedral" in text
    bad("completion", "tcsh", code=2, says="tcsh")


def test_options_that_would_do_nothing_are_errors(tmp_path: Path) -> None:
    sky = tmp_path / "sky.exr"
    io.write(sky, np.ones((8, 16, 3), np.float32))
    bake = ("bake", sky, tmp_path / "out")
    bad(*bake, "--sh", "--size", 64, code=2, says="--size does nothing without --specular")
    bad(*bake, "--specular", "--diffuse-size", 8, code=2, says="--diffuse-size does nothing")
    bad(*bake, "--diffuse", "--order", 2, code=2, says="--order does nothing without --sh")
    bad("demo", tmp_path / "d", "--from", "latlong", code=2, says="without --input")
    bad("demo", tmp_path / "d", "--input", sky, "--size", 64, code=2, says="--size does nothing")
    assert os.listdir(tmp_path) == ["sky.exr"]


@pytest.mark.parametrize("command", ["projections", "conventions"])
def test_lists_in_a_pipe_are_an_entry_a_line(command: str) -> None:
    first = (
        list(sm.projections())
        if command == "projections"
        else [f"{row['kind']}:{row['name']}" for row in sm.conventions()]
    )
    lines = good(command).splitlines()
    assert [line.split()[0] for line in lines[1 : len(first) + 1]] == first


@needs_terminal
@pytest.mark.parametrize("command", ["projections", "conventions"])
def test_a_narrow_terminal_cuts_no_name(command: str) -> None:
    text, _ = on_terminal(command, stream="stdout", term="dumb")
    names = (
        list(sm.projections())
        if command == "projections"
        else [f"{row['kind']}:{row['name']}" for row in sm.conventions()]
    )
    table, _, rest = text.partition("not shown, for want of width: ")
    lines = table.splitlines()
    assert [line.split()[0] for line in lines[1:]] == names
    assert max(map(len, lines)) <= 80
    assert "known by" in rest or "conventions" in rest


@needs_terminal
def test_a_terminal_sees_how_far_it_is_and_a_pipe_nothing(tmp_path: Path) -> None:
    names = [tmp_path / f"{k}.exr" for k in range(3)]
    for name in names:
        io.write(name, np.ones((64, 128, 3), np.float32))
    pattern = str(tmp_path / "{stem}_o.exr")
    arguments = [*map(str, names), "--from", "latlong", "--to", "octahedral", "-o", pattern]
    shown, said = on_terminal("convert", *arguments, stream="stderr", columns=120)
    assert "3/3" in shown
    assert "3 of 3 images converted" in said
    piped = shell("convert", *arguments)
    assert piped.stderr == b""


# What takes longest to import of what commands may need.
HEAVY = ("OpenImageIO", "scipy", "skimage", "matplotlib", "pydantic", "rich.console")


@some_fast(
    "words",
    ["--version", "-h", *(f"{command} -h" for command in COMMANDS)],
    ids=str,
    fast=("--version", "-h", "convert -h", "info -h"),
)
def test_help_waits_for_no_library(words: str) -> None:
    script = (
        "import sys\n"
        "from spheremap.cli import main\n"
        "try:\n"
        "    main(sys.argv[1:])\n"
        "finally:\n"
        f"    print([name for name in {HEAVY} if name in sys.modules], file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *words.split()],
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    assert done.stderr == "[]\n"
