"""Imports of the package run downward, and none runs in a circle."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
import spheremap

PACKAGE = Path(spheremap.__file__).parent
# From the ground up: what stands in a room may import from its own and from those before it.
FLOORS = (
    "_core",
    "_names",
    "_arrays",
    "io",
    "map",
    "resample",
    "sh",
    "light",
    "packing",
    "healpix",
    "align",
    "ball",
    "plot",
    "spheremap",  # the namespace itself
    "cli",
)
FILES = sorted(PACKAGE.rglob("*.py"))


def name_of(file: Path) -> str:
    """Return a module's name below the package, "" for the package itself."""
    parts = file.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(file) for file in FILES} | {"_core"}


def room(module: str) -> str:
    return module.split(".")[0] or "spheremap"


def imports(file: Path) -> set[str]:
    """Return the modules of the package that a file imports, for type checkers alone too."""
    here = name_of(file).split(".") if name_of(file) else []
    package = here if file.stem == "__init__" else here[:-1]
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            named = [alias.name.split(".") for alias in node.names]
            found |= {".".join(words[1:]) for words in named if words[0] == "spheremap"}
        elif isinstance(node, ast.ImportFrom):
            base = (node.module or "").split(".") if node.module else []
            if node.level:
                base = [*package[: len(package) - node.level + 1], *base]
            elif base[:1] == ["spheremap"]:
                base = base[1:]
            else:
                continue
            for alias in node.names:
                whole = ".".join([*base, alias.name])
                found.add(whole if whole in MODULES else ".".join(base))
    return found


def test_imports_are_seen() -> None:
    assert {"sh", "map.named"} < imports(PACKAGE / "light" / "lobes.py")
    assert {"_core", "map", "resample", "light"} < imports(PACKAGE / "__init__.py")
    assert {"", "cli.terminal"} < imports(PACKAGE / "cli" / "commands.py")


def test_every_room_has_its_floor() -> None:
    assert {room(module) for module in MODULES} == set(FLOORS)


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_imports_run_downward(file: Path) -> None:
    own = FLOORS.index(room(name_of(file)))
    for module in imports(file):
        assert FLOORS.index(room(module)) <= own, f"{name_of(file)} imports {module}"


def test_no_circle() -> None:
    graph = {name_of(file): imports(file) for file in FILES}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_no_import_hides_in_a_function(file: Path) -> None:
    """It would break a circle, not mend it. The command looks for its extra first."""
    if name_of(file) == "cli":
        return
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            for inner in ast.walk(node):
                if isinstance(inner, ast.ImportFrom):
                    words = (inner.module or "").split(".")
                    assert not inner.level and words[0] != "spheremap", ast.unparse(inner)
