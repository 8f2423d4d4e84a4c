"""The reference: a page for each public function and class, and a table for each subject.

Functions are documented by Sphinx from their docstrings. `spheremap.torch` and `spheremap.jax` need
what is too large to install for a site: of these the files are read, and nothing is imported.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

import spheremap as sm
from numpydoc.docscrape_sphinx import SphinxDocString

from .source import ROOT, Source, toctree

FOLDER = "api"
PACKAGE = ROOT / "python" / "spheremap"
# Those that `spheremap` imports when they are first used, and those that nobody imports for you.
SUBJECTS = tuple(name for name in sm.__all__ if isinstance(getattr(sm, name), ModuleType))
ASKED_FOR = ("xarray", "dask")
# Whose methods no page repeats.
PLAIN = "tuple, list, dict, str, Warning"
Definition = ast.FunctionDef | ast.ClassDef


@dataclass
class Item:
    """A public name: what its page holds, and its line in a table."""

    name: str
    summary: str
    body: str


def summary(doc: str | None, name: str) -> str:
    """Return the first sentence of a docstring."""
    lines = inspect.cleandoc(doc or "").split("\n\n")[0].split("\n")
    if not lines[0]:
        raise SystemExit(f"{name} has no docstring")
    return " ".join(lines)


def page(module: str, item: Item) -> str:
    """Return the page of a name."""
    whole = f"{module}.{item.name}"
    title = whole.replace("_", r"\_")
    line = "=" * len(title)
    return f"{title}\n{line}\n\n{item.body}\n"


def imported(module: str) -> tuple[str, list[Item]]:
    """Return the docstring of a module, and its names."""
    loaded = import_module(module)
    items = []
    for name in sorted(loaded.__all__):
        value = getattr(loaded, name)
        if isinstance(value, ModuleType):
            continue
        whole = f"{module}.{name}"
        if inspect.isclass(value):
            body = f".. autoclass:: {whole}\n   :members:\n   :inherited-members: {PLAIN}\n"
        elif callable(value):
            body = f".. autofunction:: {whole}\n"
        else:
            body = f".. py:data:: {name}\n   :module: {module}\n   :value: {value!r}\n"
            items.append(Item(name, type(value).__name__, body))
            continue
        items.append(Item(name, summary(value.__doc__, whole), body))
    return loaded.__doc__ or "", items


def file_of(module: str) -> Path:
    """Return the file of a module below `spheremap`."""
    path = PACKAGE.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def public(tree: ast.Module) -> list[str]:
    """Return a module's `__all__`."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return list(ast.literal_eval(node.value))
    return []


def with_parts(module: str) -> list[str]:
    """Return a module, and those of its names that are modules."""
    names = public(ast.parse(file_of(module).read_text(encoding="utf-8")))
    parts = (f"{module}.{name}" for name in names)
    return [module, *(part for part in parts if file_of(part).exists())]


READ = (*with_parts("torch"), *with_parts("jax"))


def read(module: str) -> tuple[str, list[Item]]:
    """Return what the file of a module says: its docstring, and its names, in files beside it."""
    path = file_of(module)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    defined: dict[str, Definition] = {}
    for node in tree.body:
        if isinstance(node, Definition):
            defined[node.name] = node
        elif isinstance(node, ast.ImportFrom) and node.level == 1 and node.module:
            beside = ast.parse((path.parent / f"{node.module}.py").read_text(encoding="utf-8"))
            functions = {f.name: f for f in beside.body if isinstance(f, Definition)}
            for alias in node.names:
                if alias.name in functions:
                    defined[alias.asname or alias.name] = functions[alias.name]
    items = []
    for name in sorted(public(tree)):
        if f"{module}.{name}" not in READ:
            node = defined[name]
            said = summary(ast.get_docstring(node), name)
            items.append(Item(name, said, described(node, module)))
    return ast.get_docstring(tree) or "", items


def described(node: Definition, module: str) -> str:
    """Return a function, or a class with its methods, as Sphinx's directives."""
    doc = str(SphinxDocString(ast.get_docstring(node) or "")).strip()
    if isinstance(node, ast.FunctionDef):
        plain = any(ast.unparse(mark) == "property" for mark in node.decorator_list)
        head = f"property:: {node.name}" if plain else f"function:: {node.name}({bare(node.args)})"
        return directive(head, module, doc)
    made = [x for x in node.body if isinstance(x, ast.FunctionDef)]
    given = next((bare(x.args, method=True) for x in made if x.name == "__init__"), "")
    parts = [doc]
    for method in made:
        if not method.name.startswith("_"):
            if method.args.args and not method.decorator_list:
                method.args.args.pop(0)
            parts.append(described(method, "").replace(".. py:function::", ".. py:method::"))
    return directive(f"class:: {node.name}({given})", module, "\n\n".join(parts))


def bare(arguments: ast.arguments, *, method: bool = False) -> str:
    """Return the arguments of a function without their types."""
    for argument in ast.walk(arguments):
        if isinstance(argument, ast.arg):
            argument.annotation = None
    if method:
        (arguments.posonlyargs or arguments.args).pop(0)
    return ast.unparse(arguments)


def directive(head: str, module: str, body: str) -> str:
    """Return a directive of Sphinx's for Python."""
    options = f"   :module: spheremap.{module}\n" if module else ""
    return f".. py:{head}\n{options}\n{textwrap.indent(body, '   ')}\n"


def subject(source: Source, module: str, doc: str, items: list[Item]) -> str:
    """Write the pages of a module, and return the place of the one with its table."""
    prefix = "" if module == "spheremap" else module.removeprefix("spheremap.") + "."
    lines = [module, "=" * len(module), "", inspect.cleandoc(doc), ""]
    lines += [".. list-table::", "   :widths: 30 70", "   :class: names", ""]
    for item in items:
        whole = f"{module}.{item.name}"
        lines += [f"   * - :py:obj:`{prefix}{item.name} <{whole}>`", f"     - {item.summary}"]
        source.write(f"{FOLDER}/{whole}.rst", page(module, item))
    lines += ["", ".. toctree::", "   :hidden:", ""]
    lines += [f"   {item.name} <{module}.{item.name}>" for item in items]
    place = "core" if module == "spheremap" else module
    source.write(f"{FOLDER}/{place}.rst", "\n".join(lines) + "\n")
    return place


HEAD = """\
# Reference

Every public name, from its docstring, whose examples the tests run. The rules that all signatures
follow are in [architecture](../docs/architecture.md#rules-of-the-python-api). `sm` is
`import spheremap as sm`.

| module | what it is for |
| --- | --- |
"""


def make(source: Source) -> None:
    """Write the pages of all modules, and one that lists them."""
    rows, places = [], []
    for name in ("", *sorted(SUBJECTS), *ASKED_FOR, *READ):
        module = f"spheremap.{name}".rstrip(".")
        doc, items = read(name) if name in READ else imported(module)
        place = subject(source, module, doc, items)
        rows.append(f"| [`{module}`]({place}.rst) | {summary(doc, module)} |")
        places.append(f"{module} <{place}>")
    tree = toctree(places)
    source.write(f"{FOLDER}/index.md", HEAD + "\n".join(rows) + "\n\n" + tree)
