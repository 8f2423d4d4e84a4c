"""A page for each projection: its section of docs/projections.md, its essay, its code, its rows."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import spheremap as sm
from PIL import Image
from spheremap import _core

from .source import ROOT, Source, toctree

FOLDER = "docs/projections"
SECTION = re.compile(r"^## `(\w+)`: (.+)\n\n((?:(?!^## ).*\n)+)", re.MULTILINE)


def essay(name: str) -> str:
    """Return what the file of a projection in Rust says at its top: formula, domain, pitfalls."""
    text = (ROOT / "src" / "projections" / f"{name}.rs").read_text(encoding="utf-8")
    said = [line[3:].strip() for line in text.splitlines() if line.startswith("//!")]
    text = "\n".join(said)
    # A link to an item of the crate, whose pages are elsewhere.
    text = re.sub(r"\[(`[^`]+`)\](\([^)]*\))?", r"\1", text)
    return text.replace("*", r"\*")


def explained(spec: str) -> str:
    """Return what `sm.explain` prints."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        sm.explain(spec)
    return said.getvalue().rstrip()


def deeper(text: str) -> str:
    """Return a section of docs/projections.md as a page one folder down has it."""
    return text.replace("](images/", "](../images/").strip()


def page(entry: dict, title: str, section: str) -> str:
    """Return the page of one projection."""
    name = entry["name"]
    p = sm.projection(name)
    parts = [
        f"# `{name}`: {title}",
        deeper(section),
        "## Look around in it",
        f'<iframe class="look" src="../../_static/look/{name}.html" loading="lazy" '
        f'title="A sky as {name}, to look around in" allow="fullscreen"></iframe>',
        "Drag to turn, roll the wheel to zoom; `b` shows the flat map beside the view.",
        f'<a href="../../_static/look/{name}.html">The page alone</a> is one file, made by '
        f'`sm.view(image, "{name}").save(...)`; [what else it does](../view.md).',
        "## Where things land",
        f'```python\n>>> sm.explain("{name}")\n{explained(name)}\n```',
        "## Formula",
        essay(name),
        "Numbers in a formula are those of the *view frame*: x to the right, y down, z into the "
        f"middle of the image. The axes `{p.axes}` say which axes of the world these are.",
    ]
    code = sm.code(name, "glsl", verbs=["encode", "decode"])
    parts += [
        "::::{dropdown} The same as code, as the library computes it: GLSL",
        f"```glsl\n{code.rstrip()}\n```",
        f'Printed by `sm.code("{name}", "glsl")`; [ten other languages](../languages.md).',
        "::::",
    ]
    if entry["conventions"]:
        rows = [
            f"- [{convention}](../conventions/{program(convention)}.md)"
            for convention in entry["conventions"]
        ]
        parts += ["## Who has it how", "\n".join(rows)]
    return "\n\n".join(parts) + "\n"


def program(convention: str) -> str:
    """Return whose a convention is: rows of one program in other layouts go by its name."""
    return convention if convention.endswith("z-up") else convention.split("-")[0]


def short(source: Source, name: str) -> str:
    """Return what the list has of a projection that has a page of its own: a small picture."""
    small = io.BytesIO()
    with Image.open(ROOT / "docs" / "images" / f"projection-{name}.png") as picture:
        picture.reduce(2).save(small, "PNG")
    source.write(f"docs/images/small-{name}.png", small.getvalue())
    return (
        f"![The same sky as {name}, small](images/small-{name}.png)\n\n"
        f"[Its page](projections/{name}.md)\n\n"
    )


def make(source: Source) -> None:
    """Write the pages, and hang them below docs/projections.md."""
    path = Path(source.folder / "docs" / "projections.md")
    text = path.read_text(encoding="utf-8")
    sections = {name: (title, body) for name, title, body in SECTION.findall(text)}
    registry = _core.registry()
    for entry in registry:
        title, body = sections[entry["name"]]
        source.write(f"{FOLDER}/{entry['name']}.md", page(entry, title, body))
        text = text.replace(body, short(source, entry["name"]))
    names = [entry["name"] for entry in registry]
    for name in names:
        text = text.replace(f"\n| `{name}` |", f"\n| [`{name}`](projections/{name}.md) |")
    tree = toctree([f"{name} <projections/{name}>" for name in names])
    source.write("docs/projections.md", text + "\n" + tree)
