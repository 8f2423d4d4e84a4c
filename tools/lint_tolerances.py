"""Hold the tests to giving a reason beside every tolerance.

python tools/lint_tolerances.py [FILE...]    fail at each tolerance without a reason
python tools/lint_tolerances.py --count      say how many there are

A tolerance is a positive number below 1e-2 in a comparison, what is passed as `atol`, `rtol`,
`rel_tol`, `abs_tol`, `rel`, `abs` or `decimal`, and what `allclose`, `isclose`, `approx` and the
asserts of NumPy take without being told. A name counts as what it was set to: in the function, in
the module, in a `parametrize` above the function, in the test module that it is imported from.

A reason is a comment in the statement's own lines or directly above it; above a run of asserts it
holds for all of them. A named constant that has a reason where it is set needs none where it is
used, and without one is reported there, once.
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TESTS = ROOT / "tests"

# Below this a number in a comparison is a tolerance and not a property of what is tested.
SMALL = 1e-2
KEYWORDS = {"atol", "rtol", "rel_tol", "abs_tol", "rel", "abs", "decimal", "delta", "maxulp"}
# Functions that compare, the places of their tolerances, and the keywords they would go by.
COMPARE: dict[str, tuple[int, int]] = {
    "allclose": (2, 4),
    "isclose": (2, 4),
    "assert_allclose": (2, 4),
    "approx": (1, 3),
    "assert_almost_equal": (2, 3),
    "assert_array_almost_equal": (2, 3),
    "assert_array_max_ulp": (2, 3),
}
# Comments that are for tools.
PRAGMA = re.compile(r"#\s*(noqa|type:|pragma|fmt:|mypy:|ruff:|!)")

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Place:
    """Where a tolerance is, and what it says there."""

    path: Path
    line: int
    text: str


def number(node: ast.AST) -> float | None:
    """Return the value of an expression of literals, or None."""
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, (int, float)):
            return None
        return float(node.value)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        inner = number(node.operand)
        return None if inner is None else -inner
    if isinstance(node, ast.BinOp):
        left, right = number(node.left), number(node.right)
        if left is None or right is None:
            return None
        try:
            if isinstance(node.op, ast.Mult):
                return left * right
            if isinstance(node.op, ast.Div):
                return left / right
            if isinstance(node.op, ast.Pow):
                return float(left**right)
            if isinstance(node.op, ast.Add):
                return left + right
            if isinstance(node.op, ast.Sub):
                return left - right
        except (ArithmeticError, TypeError):
            return None
    return None


def calls(node: ast.Call) -> str:
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


def parts(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the largest literal expressions and the names of an expression.

    What is compared may hold a call or an index; their arguments are not tolerances.
    """
    if number(node) is not None or isinstance(node, ast.Name):
        yield node
    elif isinstance(node, ast.Subscript):
        yield from parts(node.value)
    elif isinstance(node, (ast.Call, ast.Lambda)):
        # np.maximum(1e-6, ...) is one, f(x, 1e-6) is not.
        if isinstance(node, ast.Call) and calls(node) in ("max", "min", "maximum", "minimum"):
            for argument in node.args:
                yield from parts(argument)
    elif isinstance(node, (ast.BinOp, ast.UnaryOp, ast.IfExp)):
        for child in ast.iter_child_nodes(node):
            if not (isinstance(node, ast.IfExp) and child is node.test):
                yield from parts(child)


def small(node: ast.AST, limit: float = SMALL) -> bool:
    """Tell whether an expression, or an entry of a table, is or holds a small number."""
    if isinstance(node, ast.Dict):
        return any(small(value, limit) for value in node.values)
    if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
        return any(small(value, limit) for value in node.elts)
    found = [number(part) for part in parts(node)]
    return any(value is not None and 0 < value < limit for value in found)


def comments(text: str) -> tuple[set[int], set[int]]:
    """Return the lines that hold a comment for people, and those that hold nothing else."""
    any_, alone = set(), set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and not PRAGMA.match(token.string):
            any_.add(token.start[0])
            if not token.line[: token.start[1]].strip():
                alone.add(token.start[0])
    return any_, alone


@dataclass
class Module:
    """A test file: its statements, its comments and what its names are set to."""

    path: Path
    tree: ast.Module
    lines: list[str]
    commented: set[int]
    alone: set[int]
    parent: dict[ast.AST, ast.AST] = field(default_factory=dict)
    asserts: set[int] = field(default_factory=set)

    @classmethod
    def read(cls, path: Path) -> Module:
        text = path.read_text(encoding="utf-8")
        commented, alone = comments(text)
        module = cls(path, ast.parse(text), text.splitlines(), commented, alone)
        for node in ast.walk(module.tree):
            for child in ast.iter_child_nodes(node):
                module.parent[child] = node
            if isinstance(node, ast.Assert) or (
                isinstance(node, ast.Expr)
                and isinstance(node.value, ast.Call)
                and calls(node.value).startswith("assert_")
            ):
                module.asserts |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
        return module

    def statement(self, node: ast.AST) -> ast.stmt:
        while not isinstance(node, ast.stmt):
            node = self.parent[node]
        return node

    def functions(self, node: ast.AST) -> Iterator[Function]:
        """Yield the functions around a node, the innermost first."""
        while node in self.parent:
            node = self.parent[node]
            if isinstance(node, Function):
                yield node

    def span(self, statement: ast.stmt) -> tuple[int, int]:
        """Return the lines of a statement; of a compound one, those of its head."""
        first = statement.lineno
        if isinstance(statement, (Function, ast.ClassDef)):
            first = min([first, *(d.lineno for d in statement.decorator_list)])
        body = getattr(statement, "body", None)
        if isinstance(body, list) and body:
            return first, max(first, body[0].lineno - 1)
        return first, statement.end_lineno or first

    def reasoned(self, first: int, last: int) -> bool:
        """Tell whether there is a comment in these lines, or above their block of statements."""
        if any(line in self.commented for line in range(first, last + 1)):
            return True
        indent = len(self.lines[first - 1]) - len(self.lines[first - 1].lstrip())
        line = first - 1
        while line >= 1:
            text = self.lines[line - 1]
            depth = len(text) - len(text.lstrip())
            if line in self.alone:
                return depth == indent
            if line not in self.asserts:
                return False
            line -= 1
        return False


class Tests:
    """All test modules, and the tolerances in them."""

    def __init__(self, paths: list[Path]) -> None:
        self.modules = {path: Module.read(path) for path in paths}
        self.named = {path.stem: module for path, module in self.modules.items()}

    def set_to(
        self, module: Module, name: str, node: ast.AST
    ) -> tuple[Module, ast.AST, bool] | None:
        """Return where a name was last set to a small number, and whether that is a constant's.

        The node returned is the value, or the decorator of a `parametrize`.
        """
        for function in module.functions(node):
            for inner in ast.walk(function):
                if isinstance(inner, (ast.Assign, ast.AnnAssign)) and inner.value is not None:
                    for target in (
                        inner.targets if isinstance(inner, ast.Assign) else [inner.target]
                    ):
                        found = self.unpacked(target, inner.value, name)
                        if found is not None and small(found):
                            return module, found, False
            for decorator in function.decorator_list:
                if isinstance(decorator, ast.Call) and calls(decorator) == "parametrize":
                    for value in self.column(decorator, name):
                        if small(value):
                            return module, value, False
            arguments = [*function.args.args, *function.args.kwonlyargs]
            if name in {a.arg for a in arguments}:
                return None
        for statement in module.tree.body:
            if isinstance(statement, (ast.Assign, ast.AnnAssign)) and statement.value is not None:
                targets = (
                    statement.targets if isinstance(statement, ast.Assign) else [statement.target]
                )
                for target in targets:
                    found = self.unpacked(target, statement.value, name)
                    if found is not None and small(found):
                        return module, found, True
            if isinstance(statement, ast.ImportFrom) and statement.module:
                other = self.named.get(statement.module.split(".")[-1])
                for alias in statement.names if other not in (None, module) else ():
                    if other is not None and (alias.asname or alias.name) == name:
                        return self.set_to(other, alias.name, other.tree)
        return None

    @staticmethod
    def unpacked(target: ast.AST, value: ast.expr, name: str) -> ast.expr | None:
        if isinstance(target, ast.Name):
            return value if target.id == name else None
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for left, right in zip(target.elts, value.elts, strict=False):
                if isinstance(left, ast.Name) and left.id == name:
                    return right
        return None

    @staticmethod
    def column(decorator: ast.Call, name: str) -> Iterator[ast.expr]:
        """Yield the values that a parametrize gives to one of its names."""
        if len(decorator.args) < 2:
            return
        first, rows = decorator.args[:2]
        names = []
        if isinstance(first, ast.Constant) and isinstance(first.value, str):
            names = [x.strip() for x in first.value.split(",")]
        elif isinstance(first, (ast.Tuple, ast.List)):
            names = [str(x.value) for x in first.elts if isinstance(x, ast.Constant)]
        if name not in names or not isinstance(rows, (ast.List, ast.Tuple)):
            return
        for row in rows.elts:
            given = row.args if isinstance(row, ast.Call) else getattr(row, "elts", [row])
            if len(names) == 1 and not isinstance(row, ast.Call):
                yield row
            elif len(given) > names.index(name):
                yield given[names.index(name)]

    def tolerances(self, module: Module) -> Iterator[tuple[ast.AST, ast.AST]]:
        """Yield the node of each tolerance and the comparison or call that it stands in."""
        for node in ast.walk(module.tree):
            if isinstance(node, ast.Compare):
                order = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
                sides = [node.left, *node.comparators]
                # A share of random numbers is no tolerance.
                drawn = any(isinstance(x, ast.Call) and calls(x) == "random" for x in sides)
                if any(isinstance(op, order) for op in node.ops) and not drawn:
                    for side in sides:
                        for part in parts(side):
                            if isinstance(part, ast.Name) or small(part):
                                yield part, node
            elif isinstance(node, ast.Call):
                given = [k.value for k in node.keywords if k.arg in KEYWORDS]
                if calls(node) in COMPARE:
                    first, last = COMPARE[calls(node)]
                    given += node.args[first:last]
                    if not given:
                        yield node, node
                for value in given:
                    for part in parts(value):
                        exact = number(part)
                        if isinstance(part, ast.Name) or (exact is not None and exact != 0):
                            yield part, node

    def check(self, path: Path) -> tuple[list[Place], int]:
        """Return the tolerances of a file that have no reason, and how many there are in all."""
        module = self.modules[path]
        missing: dict[tuple[Path, int], Place] = {}
        many: set[tuple[Path, int]] = set()
        for part, where in self.tolerances(module):
            home, value = module, part
            if isinstance(part, ast.Name):
                found = self.set_to(module, part.id, where)
                if found is None:
                    continue
                home, value, _ = found
            line = getattr(value, "lineno", 0)
            key = home.path, line
            many.add(key)
            used = module.span(module.statement(where))
            first, last = home.span(home.statement(value))
            if isinstance(home.statement(value), Function):
                # In a decorator, the line of the value itself or the lines above the decorators.
                reasoned = home.reasoned(line, line) or home.reasoned(first, first)
            else:
                reasoned = home.reasoned(first, last)
            if reasoned or module.reasoned(*used):
                continue
            text = home.lines[line - 1].strip()
            missing[key] = Place(home.path, line, text)
        return sorted(missing.values(), key=lambda place: (place.path, place.line)), len(many)


def python_files() -> list[Path]:
    return sorted(TESTS.rglob("*.py"))


def main() -> int:
    arguments = [a for a in sys.argv[1:] if not a.startswith("-")]
    paths = python_files()
    tests = Tests(paths)
    wanted = [Path(a).resolve() for a in arguments] or paths
    places: dict[tuple[Path, int], Place] = {}
    total = 0
    for path in wanted:
        found, many = tests.check(path)
        total += many
        places |= {(place.path, place.line): place for place in found}
    for place in places.values():
        print(f"{place.path.relative_to(ROOT)}:{place.line}: {place.text}", file=sys.stderr)
    if "--count" in sys.argv:
        print(f"{total} tolerances, {len(places)} without a reason")
    return 1 if places else 0


if __name__ == "__main__":
    raise SystemExit(main())
