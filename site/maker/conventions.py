"""A page for each program: how it lays out every map that it has, from docs/conventions.md."""

from __future__ import annotations

import re

from spheremap import _core

from .projections import explained, program
from .source import Source, toctree

FOLDER = "docs/conventions"
KIND = re.compile(r"^## `(\w+)`\n\n((?:\|.*\n)+)", re.MULTILINE)
HEAD = ["name", "picture", "axes", "mirrored", "grid", "world", "note", "known by"]


def cells(line: str) -> list[str]:
    """Return the cells of a row of a table."""
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def rows(text: str) -> dict[tuple[str, str], dict[str, str]]:
    """Return the rows of all tables of docs/conventions.md, by projection and name."""
    found = {}
    for kind, table in KIND.findall(text):
        head, _, *body = map(cells, table.strip().splitlines())
        if head != HEAD:
            raise SystemExit(f"docs/conventions.md has another table for {kind}: {head}")
        for row in body:
            named = dict(zip(head, row, strict=True))
            found[kind, named["name"].strip("`")] = named
    return found


def section(kind: str, name: str, row: dict[str, str]) -> str:
    """Return what a page says of one row."""
    spec = f"{kind}:{name}"
    drawn = row["picture"].removeprefix("![](").removesuffix(")")
    picture = f"![A lettered sphere as {spec} stores it](../{drawn})"
    axes, _, laid = row["axes"].partition("<br>")
    facts = [
        f"- Axes (right, down, forward): {axes}",
        *([f"- Layout, parameters: {laid}"] if laid else []),
        "- Seen from inside a right-handed world: "
        + ("mirrored" if row["mirrored"] == "mirrored" else "not mirrored"),
        f"- Texels: {row['grid']}",
        f"- World: {row['world']}",
        f"- Known by: {row['known by']}",
    ]
    return "\n\n".join(
        [
            f"## `{spec}`",
            picture,
            row["note"],
            "\n".join(facts),
            f"The map: [{kind}](../projections/{kind}.md)",
            f'```python\n>>> sm.explain("{spec}")\n{explained(spec)}\n```',
        ]
    )


def make(source: Source) -> None:
    """Write the pages, and hang them below docs/conventions.md."""
    text = (source.folder / "docs" / "conventions.md").read_text(encoding="utf-8")
    found = rows(text)
    programs: dict[str, list[str]] = {}
    for convention in _core.convention_table():
        key = convention["kind"], convention["name"]
        programs.setdefault(program(convention["name"]), []).append(section(*key, found[key]))
    for name, sections in programs.items():
        head = (
            f"# {name}\n\nHow {name} lays out its maps. Put the name behind a colon, wherever a "
            "projection is asked for; [what the words mean](../conventions.md)."
        )
        source.write(f"{FOLDER}/{name}.md", "\n\n".join([head, *sections]) + "\n")
    names = sorted(programs)
    links = ", ".join(f"[{name}](conventions/{name}.md)" for name in names)
    before, mark, after = text.partition("\n## Worlds\n")
    text = f"{before}\n**A page for each program**: {links}.\n{mark}{after}"
    tree = toctree([f"{name} <conventions/{name}>" for name in names])
    source.write("docs/conventions.md", text + "\n" + tree)
