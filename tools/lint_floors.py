"""Hold the floors of the house: no import runs upward, and there is no circle.

python tools/lint_floors.py            fail at each arrow that should not be
python tools/lint_floors.py --write    draw the floors into docs/architecture.md

An arrow is a `use` or a path in Rust, an import in Python, lazy ones in functions included. No
arrow are: comments, strings, tests inside the crate, imports for type checkers, a parent that
declares its children or hands their names on (a name that it also uses itself is one), and the
lines of a registry: a macro called with braces in the file that defines it, or a constant list of
constants of children. Names are followed through re-exports to the file that defines them. Single
files, too, have no circle.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
BEGIN = "<!-- floors: written by tools/lint_floors.py -->"
END = "<!-- end of floors -->"

Floors = list[dict[str, str]]

# The floors, lowest first, and what each room is for. A room may import from the floors below it.
# Rooms that share a floor do not import from each other.
RUST: Floors = [
    {"error": "one error type"},
    {"number": "what a formula is written in: real, math, dual, trace"},
    {"geometry": "vectors, axes and areas on the sphere"},
    {"kernel": "a formula over an array: SIMD levels, memory, threads"},
    {"projections": "the registry; one file a map"},
    {"map": "a projection with axes, grid and layout; conventions"},
    {
        "image": "texel types, rasters, whose texel it is",
        "code": "source text",
    },
    {"resample": "one image into another"},
    {
        "light": "sums over the sphere",
        "pack": "directions in a few bits",
        "healpix": "pixel numbers",
    },
    {"prelude": "what most programs import", "shared": "compiled once for all examples"},
    {"lib": "the crate's face"},
    {"py": "parse, match the dtype, release the lock, call"},
]
PYTHON: Floors = [
    {"_core": "the compiled py", "_names": "names as types, generated"},
    {
        "_scalars": "numbers, words, flags of inputs, once",
        "_show": "values as text",
        "_srgb": "a curve",
    },
    {
        "_arrays": "shapes and dtypes of inputs, once",
        "_progress": "how far a call is",
    },
    {"_threads": "work on blocks, by all threads"},
    {"map": "behind the core verbs that take directions"},
    {"resample": "behind the core verbs that take images"},
    {
        "sh": "harmonics",
        "packing": "codes",
        "healpix": "pixel numbers",
        "align": "which map is it",
    },
    {"io": "image files"},
    {
        "light": "what a renderer needs",
        "ball": "photos of mirror balls",
        "cameras": "calibrations",
    },
    {
        "plot": "figures",
        "viewer": "pages",
        "tiles": "pyramids",
        "video": "videos",
        "jax": "arrays of JAX",
        "torch": "tensors",
    },
    {"dask": "arrays in chunks"},
    {"xarray": "arrays with names"},
    {"_projection": "the class that people see, a method a verb; generated"},
    {"__init__": "the names a person sees"},
    {"cli": "the command line"},
    {"__main__": "python -m spheremap"},
]


@dataclass(frozen=True)
class Arrow:
    """One file needs another; `line` is where it says so."""

    source: Path
    line: int
    target: Path


# Rust ---------------------------------------------------------------------------------------------

NOT_CODE = re.compile(
    r"""//[^\n]*
    |/\*
    |\b(?:b|c)?r(?P<hashes>\#*)"(?s:.*?)"(?P=hashes)
    |(?:\b[bc])?"(?s:[^"\\]|\\.)*"
    |\bb?'(?:[^'\\\n]|\\[^\n])[^'\n]*?'(?!\w)""",
    re.VERBOSE,
)
TEST_ONLY = re.compile(r"#\[cfg\((?:test|all\(test\b[^\]]*)\)\]")
ITEM = re.compile(
    r"(?:\b(?:fn|struct|enum|union|trait|type|const|static|mod)\s+|macro_rules!\s*)(?:mut\s+)?(\w+)"
)
MODULE = re.compile(r"\bmod\s+(\w+)\s*(;|\{)")
USE = re.compile(r"(?P<public>\bpub(?:\s*\([^)]*\))?\s+)?\buse\s+(?P<tree>[^;]+);")
REGISTRY = re.compile(
    r"\b(?:static|const)\s+\w+\s*:[^=;]*=\s*&?\["
    r"(?P<rows>(?:\s*&?[a-z_]\w*::[A-Z][A-Z0-9_]*\s*,?)+\s*)\]\s*;"
)
PATH = re.compile(r"(?<![\w:.$])(\$?crate|super|self|[A-Za-z_]\w*)((?:\s*::\s*\w+)+)")


def blank(text: str) -> str:
    """Return the text with everything but line breaks replaced by spaces."""
    return re.sub(r"[^\n]", " ", text)


def closing(text: str, start: int) -> int:
    """Return the index after the bracket that closes the one at `start`."""
    depth = 0
    for k in range(start, len(text)):
        if text[k] in "([{":
            depth += 1
        elif text[k] in ")]}":
            depth -= 1
            if depth == 0:
                return k + 1
    return len(text)


def without_comments(text: str) -> str:
    """Blank comments (block comments nest), strings, characters, visibilities; offsets stay."""
    out, at = [], 0
    while found := NOT_CODE.search(text, at):
        end = found.end()
        if found.group() == "/*":
            depth = 1
            while depth and (mark := re.compile(r"/\*|\*/").search(text, end)):
                depth += 1 if mark.group() == "/*" else -1
                end = mark.end()
            end = len(text) if depth else end
        out += [text[at : found.start()], blank(text[found.start() : end])]
        at = end
    code = "".join([*out, text[at:]])
    # Who may see an item is no import either.
    return re.sub(r"(?<=\bpub)\s*\((?:in\b[^)]*|crate|super|self)\)", lambda m: blank(m[0]), code)


def item_end(text: str, start: int) -> int:
    """Return where the item, field or statement at `start` ends."""
    keyword = re.compile(
        r"\s*(?:pub\b(?:\s*\([^)]*\))?\s*)?(?:(?:unsafe|const|async|extern)\s+)*"
        r"(?:fn|mod|use|impl|struct|enum|union|trait|type|const|static|macro_rules)\b"
    )
    whole = keyword.match(text, start) is not None
    k = start
    while k < len(text):
        if text[k] in "([":
            k = closing(text, k)
        elif text[k] == "{":
            return closing(text, k)
        elif text[k] == ";" or (text[k] == "," and not whole):
            return k + 1
        elif text[k] == "}":
            return k
        else:
            k += 1
    return k


def without_tests(text: str) -> tuple[str, set[str]]:
    """Blank what is compiled for tests alone, and return the names of modules among it."""
    modules: set[str] = set()
    while found := TEST_ONLY.search(text):
        start = found.end()
        while attribute := re.compile(r"\s*#\[").match(text, start):
            start = closing(text, attribute.end() - 1)
        end = item_end(text, start)
        if declared := re.compile(r"\s*(?:pub\s+)?mod\s+(\w+)\s*;").match(text, start):
            modules.add(declared[1])
        text = text[: found.start()] + blank(text[found.start() : end]) + text[end:]
    return text, modules


def without_registries(text: str) -> str:
    """Blank registries: calls, with braces, of macros that the file itself defines; constant lists
    of children's constants, and nothing else in them."""
    for name in set(re.findall(r"\bmacro_rules!\s*(\w+)", text)):
        for call in re.finditer(rf"(?<!\w){name}!\s*\{{", text):
            end = closing(text, call.end() - 1)
            text = text[: call.end()] + blank(text[call.end() : end - 1]) + text[end - 1 :]
    for table in REGISTRY.finditer(text):
        text = text[: table.start("rows")] + blank(table["rows"]) + text[table.end("rows") :]
    return text


def leaves(tree: str, before: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the path and the local name of each leaf of a use tree; a glob's name is '*'."""
    tree = tree.strip()
    head, brace, _ = tree.partition("{")
    if brace:
        inner, depth, start = tree[len(head) + 1 : closing(tree, len(head)) - 1], 0, 0
        names = tuple(x.strip() for x in head.split("::") if x.strip())
        for k, letter in enumerate([*inner, ","]):
            depth += (letter == "{") - (letter == "}")
            if letter == "," and depth == 0:
                if inner[start:k].strip():
                    yield from leaves(inner[start:k], before + names)
                start = k + 1
        return
    path, _, alias = (x.strip() for x in re.sub(r"\s+as\s+", " @ ", tree).partition("@"))
    names = before + tuple(x.strip() for x in path.split("::") if x.strip())
    if names[-1] == "self" and len(names) > 1:
        names = names[:-1]
    yield names, alias or names[-1]


@dataclass
class Use:
    """One leaf of a `use`: in which module, what, by which name, handed on or not, and where."""

    scope: tuple[str, ...]
    path: tuple[str, ...]
    name: str
    public: bool
    at: int


@dataclass
class Source:
    """What is known of one Rust file."""

    path: Path
    module: tuple[str, ...]
    text: str
    inline: list[tuple[int, int, tuple[str, ...]]] = field(default_factory=list)
    children: set[tuple[str, ...]] = field(default_factory=set)
    uses: list[Use] = field(default_factory=list)
    defined: set[str] = field(default_factory=set)

    def scope(self, at: int) -> tuple[str, ...]:
        """Return the module that the text at this offset belongs to."""
        inside = [m for start, end, m in self.inline if start <= at < end]
        return max(inside, key=len, default=self.module)

    def line(self, at: int) -> int:
        return self.text.count("\n", 0, at) + 1


class Crate:
    """The files of a crate and what their paths mean."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.files: dict[tuple[str, ...], Source] = {}
        self.exported: dict[str, Source] = {}
        tests: set[tuple[str, ...]] = set()
        for path in sorted(root.rglob("*.rs")):
            names = path.relative_to(root).with_suffix("").parts
            module = names[:-1] if names[-1] in ("mod", "lib") else names
            text, skipped = without_tests(without_comments(path.read_text(encoding="utf-8")))
            tests |= {(*module, name) for name in skipped}
            for macro in re.findall(r"#\[macro_export\]\s*macro_rules!\s*(\w+)", text):
                self.exported[macro] = Source(path, module, text)
            self.files[module] = Source(path, module, without_registries(text))
        for module in list(self.files):
            if any(module[: len(test)] == test for test in tests):
                del self.files[module]
        self.modules = dict(self.files)
        for source in self.files.values():
            self.read(source)

    def read(self, source: Source) -> None:
        opened = [m for m in MODULE.finditer(source.text) if m[2] == "{"]
        for found in opened:
            end = closing(source.text, found.end() - 1)
            outer = source.scope(found.start())
            source.inline.append((found.end(), end, (*outer, found[1])))
            self.modules.setdefault((*outer, found[1]), source)
        for found in MODULE.finditer(source.text):
            source.children.add((*source.scope(found.start()), found[1]))
        source.defined = set(ITEM.findall(source.text))
        for found in USE.finditer(source.text):
            scope = source.scope(found.start())
            for path, name in leaves(found["tree"]):
                use = Use(scope, path, name, bool(found["public"]), found.start("tree"))
                source.uses.append(use)

    def absolute(
        self, scope: tuple[str, ...], path: tuple[str, ...], seen: int = 0
    ) -> tuple[str, ...] | None:
        """Return a path from the crate's root, or None for what belongs to another crate."""
        first, rest = path[0], path[1:]
        if first in ("crate", "$crate"):
            return rest
        if first == "self":
            return scope + rest
        if first == "super":
            while rest and rest[0] == "super":
                scope, rest = scope[:-1], rest[1:]
            return scope[:-1] + rest
        source = self.modules.get(scope)
        if source is None or seen > 8:
            return None
        if (*scope, first) in source.children:
            return scope + path
        for use in source.uses:
            if use.scope == scope and use.name == first and use.path != path[: len(use.path)]:
                base = self.absolute(scope, use.path, seen + 1)
                return None if base is None else base + rest
        return None

    def home(self, path: tuple[str, ...], seen: int = 0) -> Source | None:
        """Return the file that defines what an absolute path means."""
        here: tuple[str, ...] = ()
        for name in path:
            if (*here, name) not in self.modules:
                return self.item(here, name, seen)
            here = (*here, name)
        return self.modules.get(here)

    def item(self, module: tuple[str, ...], name: str, seen: int = 0) -> Source | None:
        """Return the file that defines an item which this module has or hands on."""
        source = self.modules.get(module)
        if source is None or seen > 8:
            return source
        for use in source.uses:
            if use.scope == module and use.name == name != "*":
                path = self.absolute(module, use.path)
                if path is not None and path != (*module, name):
                    return self.home(path, seen + 1)
        if name in source.defined:
            return source
        for use in source.uses:
            if use.scope == module and use.name == "*":
                path = self.absolute(module, use.path[:-1])
                inner = self.modules.get(path) if path is not None else None
                if inner is not None and inner is not source and path is not None:
                    found = self.item(path, name, seen + 1)
                    if found is not None and name in found.defined:
                        return found
        return self.exported.get(name, source) if not module else source

    def arrows(self) -> Iterator[Arrow]:
        for source in self.files.values():
            rest = source.text
            for found in USE.finditer(source.text):
                rest = rest[: found.start()] + blank(found.group()) + rest[found.end() :]
            modules: dict[tuple[tuple[str, ...], str], Use] = {}
            used: set[tuple[tuple[str, ...], str]] = set()
            wanted: list[tuple[int, tuple[str, ...]]] = []
            for use in source.uses:
                glob = use.name == "*"
                path = self.absolute(use.scope, use.path[:-1] if glob else use.path)
                if path is None:
                    continue
                child = path[: len(use.scope)] == use.scope and len(path) > len(use.scope)
                needed = (
                    re.search(rf"(?<![\w.]){re.escape(use.name)}\b", rest) if not glob else None
                )
                if use.public and child and not needed:
                    continue
                if path in self.modules and not glob and not use.public:
                    modules[use.scope, use.name] = use
                else:
                    wanted.append((use.at, path))
            for found in PATH.finditer(rest):
                names = (found[1], *(x.strip() for x in found[2].split("::") if x.strip()))
                scope = source.scope(found.start())
                if (scope, found[1]) in modules:
                    used.add((scope, found[1]))
                path = self.absolute(scope, names)
                if path is not None:
                    wanted.append((found.start(), path))
            # A module that is imported and never written in a path is needed as such.
            for key, use in modules.items():
                if key not in used:
                    path = self.absolute(use.scope, use.path)
                    wanted += [(use.at, path)] if path is not None else []
            for at, path in wanted:
                target = self.home(path)
                if target is not None and target.path != source.path:
                    yield Arrow(source.path, source.line(at), target.path)


# Python -------------------------------------------------------------------------------------------


class Package:
    """The files of a package and what their imports mean."""

    def __init__(self, root: Path) -> None:
        self.root, self.name = root, root.name
        self.files: dict[tuple[str, ...], Path] = {}
        for path in sorted([*root.rglob("*.pyi"), *root.rglob("*.py")]):
            names = path.relative_to(root).with_suffix("").parts
            self.files[names[:-1] if names[-1] == "__init__" else names] = path
        self.trees = {
            module: ast.parse(path.read_text(encoding="utf-8"))
            for module, path in self.files.items()
        }
        self.handed_on: dict[tuple[str, ...], dict[str, tuple[str, ...]]] = {}
        for module, path in self.files.items():
            table: dict[str, tuple[str, ...]] = {}
            if path.stem == "__init__" and module:
                for node in ast.walk(self.trees[module]):
                    if isinstance(node, ast.ImportFrom):
                        base = self.base(module, node)
                        for alias in node.names if base is not None else ():
                            table[alias.asname or alias.name] = (*(base or ()), alias.name)
            self.handed_on[module] = table

    def base(self, module: tuple[str, ...], node: ast.ImportFrom) -> tuple[str, ...] | None:
        """Return the module that a `from` names, or None if it is another package's."""
        names = tuple((node.module or "").split(".")) if node.module else ()
        if node.level == 0:
            return names[1:] if names[:1] == (self.name,) else None
        package = module if self.files[module].stem == "__init__" else module[:-1]
        return package[: len(package) - (node.level - 1)] + names

    def home(self, path: tuple[str, ...], seen: int = 0) -> Path | None:
        """Return the file that a dotted path leads to, through what packages hand on."""
        if path in self.files:
            return self.files[path]
        if not path or seen > 8:
            return None
        further = self.handed_on.get(path[:-1], {}).get(path[-1])
        if further is not None and further != path:
            return self.home(further, seen + 1)
        return self.home(path[:-1], seen + 1)

    def imports(self, module: tuple[str, ...]) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Yield the line and the path of each import, those for type checkers left out."""
        stack: list[ast.AST] = [self.trees[module]]
        while stack:
            node = stack.pop()
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
                stack += node.orelse
                continue
            stack += ast.iter_child_nodes(node)
            if isinstance(node, ast.Import):
                for alias in node.names:
                    first, *rest = alias.name.split(".")
                    if first == self.name:
                        yield node.lineno, tuple(rest)
            elif isinstance(node, ast.ImportFrom):
                base = self.base(module, node)
                if base is not None:
                    for alias in node.names:
                        yield node.lineno, base if alias.name == "*" else (*base, alias.name)
            elif isinstance(node, ast.Call) and node.args:
                called = node.func
                name = getattr(called, "attr", getattr(called, "id", ""))
                given = node.args[0]
                if name in ("import_module", "__import__") and isinstance(given, ast.Constant):
                    text = str(given.value)
                    level = len(text) - len(text.lstrip("."))
                    made = ast.ImportFrom(module=text.lstrip(".") or None, names=[], level=level)
                    base = self.base(module, made)
                    if base is not None:
                        yield node.lineno, base

    def arrows(self) -> Iterator[Arrow]:
        for module, path in self.files.items():
            if path.suffix == ".pyi":
                continue  # a stub imports for type checkers alone
            parent = path.stem == "__init__"
            for line, wanted in self.imports(module):
                target = self.home(wanted)
                child = wanted[: len(module)] == module and len(wanted) > len(module)
                if target is None or target == path or (parent and child):
                    continue
                yield Arrow(path, line, target)


# Both ---------------------------------------------------------------------------------------------


def room(path: Path, root: Path) -> str:
    """Return the room that a file belongs to: its first folder, or its own name."""
    first = path.relative_to(root).parts[0]
    return first.split(".")[0]


def upward(arrows: Iterable[Arrow], root: Path, floors: Floors) -> list[str]:
    """Return a line for each arrow that does not run down to a lower floor."""
    height = {name: k for k, floor in enumerate(floors) for name in floor}
    said = []
    for arrow in arrows:
        source, target = room(arrow.source, root), room(arrow.target, root)
        if source == target:
            continue
        unknown = [name for name in (source, target) if name not in height]
        if unknown:
            what = f"{unknown[0]} is on no floor"
        elif height[target] > height[source]:
            what = f"{source} imports {target}, which is above it"
        elif height[target] == height[source]:
            what = f"{source} imports {target}, which is on the same floor"
        else:
            continue
        said.append(f"{arrow.source}:{arrow.line}: {what} ({arrow.target.name})")
    return said


def circles(arrows: Iterable[Arrow]) -> list[list[Arrow]]:
    """Return the shortest circle through each file that is on one, each circle once."""
    out: dict[Path, dict[Path, Arrow]] = {}
    for arrow in arrows:
        out.setdefault(arrow.source, {}).setdefault(arrow.target, arrow)
    found: dict[frozenset[Path], list[Arrow]] = {}
    for start in sorted(out):
        way: dict[Path, Arrow] = {}
        queue = deque([start])
        while queue and start not in way:
            here = queue.popleft()
            for target, arrow in out.get(here, {}).items():
                if target not in way:
                    way[target] = arrow
                    queue.append(target)
        if start in way:
            circle = [way[start]]
            while circle[-1].source != start:
                circle.append(way[circle[-1].source])
            found.setdefault(frozenset(a.source for a in circle), circle[::-1])
    return list(found.values())


def complaints(arrows: Iterable[Arrow], root: Path, floors: Floors) -> list[str]:
    """Return what is wrong with these arrows, as lines that begin with file:line."""
    arrows = sorted(set(arrows), key=lambda a: (a.source, a.line, a.target))
    said = upward(arrows, root, floors)
    for circle in circles(arrows):
        files = " -> ".join(str(a.source.relative_to(root)) for a in circle)
        said += [f"{a.source}:{a.line}: part of the circle {files} -> …" for a in circle]
    return said


def check(root: Path, floors: Floors) -> list[str]:
    """Return what is wrong with a crate or a package."""
    house = Package(root) if (root / "__init__.py").exists() else Crate(root)
    files = (
        [x.path for x in house.files.values()] if isinstance(house, Crate) else house.files.values()
    )
    here = {room(path, root) for path in files}
    known = {name for floor in floors for name in floor}
    said = [f"{root}/{name}:1: this room is on no floor" for name in sorted(here - known)]
    return said + complaints(house.arrows(), root, floors)


def picture() -> str:
    """Return the floors as a drawing, the highest on top."""
    lines: list[str] = []
    width = 108
    for title, floors in (("python/spheremap", PYTHON), ("src", RUST)):
        lines.append(f"┌─ {title} ".ljust(width, "─") + "┐")
        for floor in reversed(floors):
            names, purposes = " │ ".join(floor), "; ".join(floor.values())
            lines.append(f"│ {names.ljust(41)} {purposes}".ljust(width) + "│")
        lines.append("└".ljust(width, "─") + "┘")
    return "\n".join(lines)


def drawn(text: str) -> str:
    """Return a page's text with the picture brought up to date."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise SystemExit(f"{PAGE.name} lacks the marks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n```text\n{picture()}\n```\n{END}{after}"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help="draw the picture instead of checking")
    write = parser.parse_args().write
    text = PAGE.read_text(encoding="utf-8")
    if write:
        PAGE.write_text(drawn(text), encoding="utf-8")
        return 0
    said = check(ROOT / "src", RUST) + check(ROOT / "python" / "spheremap", PYTHON)
    if drawn(text) != text:
        said.append(
            f"{PAGE}:1: the floors are out of date: run python tools/lint_floors.py --write"
        )
    for line in said:
        print(line.replace(f"{ROOT}/", ""), file=sys.stderr)
    return 1 if said else 0


if __name__ == "__main__":
    raise SystemExit(main())
