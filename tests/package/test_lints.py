"""The lints of tools/ on made-up trees: each rule is broken, and each exemption tried."""

from __future__ import annotations

import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"


def tool(name: str) -> ModuleType:
    spec = spec_from_file_location(name, TOOLS / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[name] = module  # its dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module


floors = tool("lint_floors")
tree = tool("lint_tree")
spelling = tool("lint_spelling")
tolerances = tool("lint_tolerances")
licenses = tool("lint_licenses")


def grow(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


# Floors: Rust -------------------------------------------------------------------------------------

CRATE = [{"low": "a"}, {"left": "b", "right": "c"}, {"lib": "d"}]


def rust(root: Path, files: dict[str, str]) -> list[str]:
    base = {"lib.rs": "pub mod low;\npub mod left;\npub mod right;\n"}
    base |= {f"{name}/mod.rs": "" for name in ("low", "left", "right")}
    said = floors.check(grow(root, {**base, **files}), CRATE)
    return [line.replace(f"{root}/", "") for line in said]


def test_what_runs_down_is_fine(tmp_path):
    files = {
        "low/mod.rs": "pub mod real;\npub use real::Real;\n",
        "low/real.rs": "pub struct Real;\n",
        "left/mod.rs": "use crate::low::{Real, real::{self}};\nfn f(_: real::Real, _: Real) {}\n",
    }
    assert rust(tmp_path, files) == []


@pytest.mark.parametrize(
    "line",
    [
        "use crate::left::up::Up;",
        "pub use crate::left::Up;",
        "use crate::{left::{up::{Up as Other}}};",
        "use super::left::Up;",
        "fn f(_: crate::left::Up) {}",
        "fn f(_: super::left::up::Up) {}",
        "macro_rules! m { () => { $crate::left::Up } }",
        "mod inner { use super::super::left::Up; }",
        "use crate::left;\nfn f(_: left::Up) {}",
        "use crate::Up;",
        "use crate::left::*;",
    ],
)
def test_what_runs_up_is_found(tmp_path, line):
    files = {
        "lib.rs": "pub mod low;\npub mod left;\npub mod right;\npub use left::Up;\n",
        "left/mod.rs": "mod up;\npub use up::Up;\n",
        "left/up.rs": "pub struct Up;\n",
        "low/mod.rs": f"//! Essay.\n\n{line}\n",
    }
    said = rust(tmp_path, files)
    assert said and all("low imports left, which is above it" in x for x in said), said
    at = 3 + ("\nfn" in line)
    assert said[0].startswith(f"low/mod.rs:{at}: ")


def test_names_are_followed_to_the_file_that_defines_them(tmp_path):
    # `left` hands on what `low` defines: whoever takes it from there needs `left` no less.
    files = {
        "low/mod.rs": "pub struct Real;\n",
        "left/mod.rs": "pub use crate::low::Real;\n",
        "right/mod.rs": "use crate::left::Real;\n",
    }
    assert rust(tmp_path, files) == []
    assert rust(tmp_path, {**files, "left/mod.rs": "pub struct Real;\n"}) == [
        "right/mod.rs:1: right imports left, which is on the same floor (mod.rs)"
    ]


@pytest.mark.parametrize(
    "text",
    [
        "// use crate::left::Up;\n",
        "/* use crate::left::Up; /* nested */ crate::left::Up */\n",
        "//! [`crate::left::Up`]\n/// crate::left::Up\nstruct S;\n",
        'const S: &str = "use crate::left::Up;\\" crate::left::Up";\n',
        'const S: &str = r#"crate::left::"Up"#;\n',
        "fn f<'a>(c: &'a char) -> bool { *c == '\"' } // crate::left::Up \"\n",
        "pub(in crate::left) struct S;\npub(crate) use std::fmt;\n",
        "#[cfg(test)]\nmod tests {\n    use crate::left::Up;\n    fn f() { if true { } }\n}\n",
        "#[cfg(test)]\nuse crate::left::Up;\n",
        "#[cfg(test)]\nmod tests;\n",
        "struct S { #[cfg(test)] up: crate::left::Up, a: u8 }\n",
        "#[cfg(test)]\n#[allow(dead_code)]\nfn f<A, B>(_: A, _: B) { crate::left::f(); }\n",
    ],
)
def test_comments_strings_and_tests_are_no_imports(tmp_path, text):
    files = {"low/mod.rs": text, "low/tests.rs": "use crate::left::Up;\n"}
    if "mod tests;" not in text:
        files.pop("low/tests.rs")
    assert rust(tmp_path, files) == []


def test_a_line_after_a_string_is_still_read(tmp_path):
    text = 'const S: &str = "//";\nconst C: char = \'"\';\nuse crate::left::Up;\n'
    assert [x.split(": ")[0] for x in rust(tmp_path, {"low/mod.rs": text})] == ["low/mod.rs:3"]


def test_circles_of_files_are_found(tmp_path):
    files = {
        "low/mod.rs": "mod a;\nmod b;\nmod c;\npub use c::C;\n",
        "low/a.rs": "use super::b::B;\npub struct A;\n",
        "low/b.rs": "\nuse super::C;\npub struct B;\n",
        "low/c.rs": "pub struct C(super::a::A);\n",
    }
    said = rust(tmp_path, files)
    assert [x.split(": ")[0] for x in said] == ["low/a.rs:1", "low/b.rs:2", "low/c.rs:1"]
    assert all("part of the circle" in x for x in said)


def test_a_parent_may_declare_and_hand_on_but_not_use(tmp_path):
    child = "use super::Shared;\npub struct A(Shared);\n"
    hands_on = "mod a;\npub use a::A;\npub struct Shared;\n"
    registry = (
        "macro_rules! all { ($($m:ident::$n:ident),+) => { $(mod $m; pub use $m::$n;)+ } }\n"
        "all! { a::A }\npub struct Shared;\n"
    )
    table = (
        "mod a;\npub struct Shared;\n"
        "pub static ALL: &[&Shared] = &[\n    &a::ROW_2,\n    &a::B,\n];\n"
    )
    for text in (hands_on, registry, table):
        assert rust(tmp_path, {"low/mod.rs": text, "low/a.rs": child}) == []
    for line in ("fn f(_: a::A) {}", "fn f(_: A) {}", "const A: &[u8] = &[a::f()];"):
        said = rust(tmp_path, {"low/mod.rs": f"{hands_on}{line}\n", "low/a.rs": child})
        assert len(said) == 2 and all("circle" in x for x in said), line


def test_every_room_is_on_a_floor(tmp_path):
    said = rust(tmp_path, {"attic/mod.rs": ""})
    assert said == ["attic:1: this room is on no floor"]


# Floors: Python -----------------------------------------------------------------------------------

PACKAGE = [{"_arrays": "a"}, {"map": "b"}, {"light": "c"}, {"__init__": "d"}, {"cli": "e"}]


def python(root: Path, files: dict[str, str]) -> list[str]:
    root = root / "house"
    base = {
        "__init__.py": "from .map import encode\n",
        "_arrays.py": "",
        "map/__init__.py": "from .verbs import encode\n",
        "map/verbs.py": "from .._arrays import check\n",
        "light/__init__.py": "",
        "cli/__init__.py": "import house as sm\n",
    }
    said = floors.check(grow(root, {**base, **files}), PACKAGE)
    return [line.replace(f"{root}/", "") for line in said]


def test_packages_are_read(tmp_path):
    assert python(tmp_path, {}) == []


@pytest.mark.parametrize(
    "text",
    [
        "from ..light import integrate\n",
        "from .. import light\n",
        "import house.light\n",
        "from house.light import integrate\n",
        "from house import light\n",
        "def f():\n    from ..light import integrate\n",
        'def f():\n    importlib.import_module("house.light")\n',
        "if TYPE_CHECKING:\n    pass\nelse:\n    from ..light import integrate\n",
    ],
)
def test_imports_that_run_up_are_found(tmp_path, text):
    said = python(tmp_path, {"map/verbs.py": text})
    assert len(said) == 1 and "map imports light, which is above it" in said[0], said


@pytest.mark.parametrize(
    "text",
    [
        "if TYPE_CHECKING:\n    from ..light import integrate\n",
        "if typing.TYPE_CHECKING:\n    from ..light import integrate\n",
        '"""from ..light import integrate"""\n',
        "import light\nfrom light import integrate\n",
    ],
)
def test_imports_for_type_checkers_are_none(tmp_path, text):
    assert python(tmp_path, {"map/verbs.py": text}) == []


def test_the_roof_is_above_every_room(tmp_path):
    for text in ("import house as sm\n", "from house import encode\n", "from .. import encode\n"):
        said = python(tmp_path, {"light/sums.py": text})
        assert len(said) == 1 and "light imports __init__" in said[0], text


def test_circles_of_modules_are_found(tmp_path):
    files = {
        "map/__init__.py": "from .a import x\nfrom .b import y\n",
        "map/a.py": "from . import b\n",
        # Through the package: the name leads back to a.
        "map/b.py": "def f():\n    from ..map import x\n",
    }
    said = python(tmp_path, files)
    assert [x.split(": ")[0] for x in said] == ["map/a.py:1", "map/b.py:2"]


def test_the_picture_shows_every_room():
    drawing = floors.picture()
    for floor in floors.RUST + floors.PYTHON:
        for room in floor:
            assert f" {room} " in drawing
    assert len({len(line) for line in drawing.splitlines()}) == 1


# The tree -----------------------------------------------------------------------------------------

BLOCK = """\
src/          the core
  lib.rs      the face
  map/        verbs
    verbs.rs
docs/         prose
  images/     pictures
python/house/ the face
  __init__.py
"""
ROOTS = ("src", "docs", "python/house")
FILES = [
    "src/lib.rs",
    "src/map/verbs.rs",
    "docs/images/deep/a.png",
    "python/house/__init__.py",
    "README.md",
]


def told(block: str, files: list[str]) -> list[str]:
    return tree.complaints(tree.parsed(block), tree.Disk(files), ROOTS)


def test_a_tree_that_is_right_is_right():
    assert told(BLOCK, FILES) == []


def test_each_difference_is_told():
    assert told(BLOCK, [*FILES, "src/new.rs"]) == ["1: src/new.rs is missing"]
    assert told(BLOCK, [*FILES, "src/light/mod.rs"]) == ["1: src/light/ is missing"]
    assert told(BLOCK, [*FILES, "src/map/mod.rs"]) == ["3: src/map/mod.rs is missing"]
    assert told(BLOCK, [*FILES, "docs/images/b.png"]) == []  # its files are not listed
    assert told(BLOCK, FILES[1:]) == ["2: src/lib.rs is not on the disk"]
    assert told(BLOCK.replace("verbs\n ", "\n "), FILES) == [
        "3: src/map/ has no remark: what is it for?"
    ]


def test_writing_keeps_order_and_remarks():
    files = [*FILES[1:], "src/a.rs", "src/map/b.rs", "src/light/mod.rs"]
    made = tree.rendered(tree.true_tree(tree.parsed(BLOCK), tree.Disk(files), ROOTS))
    lines = [line.split() for line in made.splitlines()]
    assert lines[:6] == [
        ["src/", "the", "core"],
        ["map/", "verbs"],
        ["verbs.rs"],
        ["b.rs"],
        ["light/"],
        ["a.rs"],
    ]
    assert told(made, files) == ["5: src/light/ has no remark: what is it for?"]


# Spelling -----------------------------------------------------------------------------------------


BRITISH = """
    colour Colours neighbouring behaviour centre centred recentring kilometres normalise
    isNormalised COLOUR_SPACE vectorised parametrisation analyse analysing modelled unlabelled
    cancelling grey licence fulfil backwards artefact catalogue discretised
"""
AMERICAN = """
    color neighbor center centers recentering meter parameter normalize analyses analysis
    precise otherwise exercise raise noise wise revise comprise premise surprise promise
    fulfilling controlled rolled called filling install hours four pour tour contour detour
    source course our your metric fiber gray license backward modeling labeled isotropic arise
    rise paradise spectra theater acres genre ogre mediocre massacre metallic parallel
    parallelism crystallize totally equally really wobble expertise advertise franchise
    enterprise disguise devise excise realist socialist finalist specialist minimalist
"""


@pytest.mark.parametrize("word", BRITISH.split())
def test_british_words_are_found(word):
    assert spelling.british(f"see `{word}` there"), word


@pytest.mark.parametrize("text", AMERICAN.split())
def test_american_words_are_left_alone(text):
    assert spelling.british(text) == []


def test_phrases_are_found():
    assert spelling.british("half a per cent") == ["per cent"]
    assert spelling.british("percentile of a percent; once per center") == []


# Tolerances ---------------------------------------------------------------------------------------


def missing(root: Path, text: str, **others: str) -> list[int]:
    files = {"test_it.py": text} | {f"{k}.py": v for k, v in others.items()}
    paths = [grow(root, files) / name for name in files]
    found, _ = tolerances.Tests(paths).check(paths[0])
    return [place.line for place in found]


BARE = [
    "assert error < 1e-9",
    "assert 1e-9 > error",
    "assert error <= bound + 4 * 1e-16",
    "assert error < 2.0**-24 * scale",
    "assert error < max(1e-9, bound)",
    "np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)",
    "assert np.allclose(a, b)",
    "assert np.isclose(a, b, 0.02)",
    "assert a == pytest.approx(b, rel=0.5)",
    "assert a == pytest.approx(b)",
    "assert math.isclose(a, b, rel_tol=1e-6)",
]


@pytest.mark.parametrize("line", BARE)
def test_a_tolerance_needs_a_reason(tmp_path, line):
    function = "def test_it():\n    a = b = error = bound = scale = 0  # given\n\n"
    assert missing(tmp_path, f"{function}    {line}\n") == [4]
    assert missing(tmp_path, f"{function}    {line}  # rounding\n") == []
    assert missing(tmp_path, f"{function}    # Rounding.\n    {line}\n") == []
    assert missing(tmp_path, f"{function}    # Rounding.\n    assert a\n    {line}\n") == []
    # Comments about something else, tools' comments, and a docstring are no reason.
    assert missing(tmp_path, f"{function}    # Both.\n    c = 1\n    {line}\n") == [6]
    assert missing(tmp_path, f"{function}    {line}  # noqa: B015\n") == [4]
    assert missing(tmp_path, f"{function}    # Rounding.\n\n    {line}\n") == [6]
    assert missing(tmp_path, f'# Module.\ndef test_it():\n    """Doc."""\n    {line}\n') == [4]


@pytest.mark.parametrize(
    "line",
    [
        "assert error < 0.5",
        "assert error == 1e-9",
        "assert error < f(1e-9)",
        "assert image[1e-9] < 2",
        "assert error < 0",
        "np.testing.assert_allclose(a, b, rtol=0, atol=0)",
        "assert rng.random(3) < 0.002",
        "x = 1e-9",
    ],
)
def test_other_numbers_need_none(tmp_path, line):
    assert missing(tmp_path, f"def test_it():\n    {line}\n") == []


def test_a_name_counts_as_what_it_is_set_to(tmp_path):
    use = "def test_it():\n    assert error < SLACK\n    assert other < SLACK\n"
    assert missing(tmp_path, f"SLACK = 1e-9\n\n{use}") == [1]
    assert missing(tmp_path, f"SLACK = 1e-9  # rounding\n\n{use}") == []
    assert missing(tmp_path, f"# Rounding.\nSLACK = 1e-9\n\n{use}") == []
    assert missing(tmp_path, f"SLACK = 0.5\n\n{use}") == []
    table = use.replace("SLACK", "SLACK[name]")
    assert missing(tmp_path, f"SLACK = {{'a': 1e-9}}\n\n{table}") == [1]
    assert missing(tmp_path, f"SLACK = {{'a': 1e-9}}  # rounding\n\n{table}") == []
    local = "def test_it(wide):\n    slack = 1e-9 if wide else 1e-5{}\n    assert error < slack\n"
    assert missing(tmp_path, local.format("")) == [2]
    assert missing(tmp_path, local.format("  # rounding")) == []


def test_an_imported_name_is_looked_up_where_it_is_set(tmp_path):
    use = "from limits import SLACK\n\ndef test_it():\n    assert error < SLACK\n"
    assert missing(tmp_path, use, limits="SLACK = 1e-9\n") == [1]
    assert missing(tmp_path, use, limits="SLACK = 1e-9  # rounding\n") == []


def test_a_parameter_counts_as_what_it_is_given(tmp_path):
    text = (
        "{0}@pytest.mark.parametrize(\n"
        "    'name, slack',\n"
        "    [('a', 1e-9),{1} ('b', 1)],\n)\n"
        "def test_it(name, slack):\n    assert error < slack\n"
    ).replace(",{1} ", ",{1}\n     ")
    assert missing(tmp_path, text.format("", "")) == [3]
    assert missing(tmp_path, text.format("", "  # rounding")) == []
    assert missing(tmp_path, text.format("# Rounding.\n", "")) == []


# Licenses -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "expression, fits",
    [
        ("MIT", True),
        ("MIT OR GPL-3.0", True),
        ("MIT/Apache-2.0", True),
        ("MIT AND GPL-3.0", False),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", True),
        ("(MIT OR Apache-2.0) AND GPL-3.0", False),
        ("Apache-2.0 WITH LLVM-exception OR MIT", True),
        ("GPL-3.0-or-later", False),
        (None, False),
    ],
)
def test_licenses_are_read(expression, fits):
    assert licenses.allows(expression) is fits


def test_crates_from_elsewhere_and_those_of_tests():
    crate = {"name": "a", "version": "1", "license": "MIT", "source": "git+https://a"}
    assert len(licenses.complaints([crate])) == 1
    assert licenses.complaints([{**crate, "source": None}]) == []

    def needs(name, kind):
        return {"pkg": name, "dep_kinds": [{"kind": kind}]}

    nodes = [
        {"id": "root", "deps": [needs("a", None), needs("b", "dev"), needs("c", "build")]},
        *({"id": name, "deps": []} for name in "abc"),
    ]
    metadata = {
        "packages": [{"id": name} for name in ("root", "a", "b", "c")],
        "resolve": {"root": "root", "nodes": nodes},
    }
    assert [package["id"] for package in licenses.shipped(metadata)] == ["root", "a", "c"]


# Pages that name what is elsewhere ----------------------------------------------------------------


def test_the_tests_that_hold_the_invariants_exist():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("## Invariants")[2].partition("\n## ")[0]
    code = "".join(
        path.read_text(encoding="utf-8")
        for folder, suffix in (("tests", "*.py"), ("tests", "*.rs"), ("src", "*.rs"))
        for path in (ROOT / folder).rglob(suffix)
    )
    targets = (ROOT / "Makefile").read_text(encoding="utf-8")
    names = re.findall(r"`([^`]+)`", table)
    assert names
    for name in names:
        make, _, target = name.partition("make ")
        found = re.search(rf"^{target}:", targets, re.M) if target else None
        assert found or re.search(rf"\b(def|fn) {re.escape(make)}\(", code), name


def test_there_is_one_version():
    def stated(name: str, pattern: str) -> str:
        found = re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), re.M)
        assert found is not None, name
        return found[1]

    assert stated("CITATION.cff", r"^version: (.+)$") == stated("Cargo.toml", r'^version = "(.+)"$')
