"""Write README's table of projections and docs/projections.md from the registry of the core.

python tools/generate_docs.py            write them
python tools/generate_docs.py --check    fail if one is out of date
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

from spheremap import _core

ROOT = Path(__file__).resolve().parents[1]
BEGIN = "<!-- projections: written by tools/generate_docs.py -->"
END = "<!-- end of projections -->"


def table(head: list[str], rows: list[list[str]]) -> str:
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(x.replace("|", "\\|") for x in row) + " |" for row in cells)


def number(x: float) -> str:
    """Return a short text of a number, with π where it is a simple multiple of a power of it."""
    if math.isinf(x):
        return "∞"
    for power, name in ((0, ""), (1, "π"), (2, "π²")):
        for divisor in (1, 2, 3):
            k = x / math.pi**power * divisor
            if abs(k - round(k)) < 1e-9 and 0 < round(k) <= 64:
                factor = str(round(k)) if round(k) != 1 or not name else ""
                return factor + name + (f"/{divisor}" if divisor > 1 else "")
    return f"{x:.4g}"


def density(entry: dict) -> str:
    low, high = entry["density_range"]
    return number(low) if low == high else f"{number(low)} … {number(high)}"


def even(entry: dict) -> str:
    """Return the ratio of the largest to the smallest area that one texel can cover."""
    low, high = entry["density_range"]
    return "∞" if low == 0 or math.isinf(high) else f"{high / low:.4g}"


def properties(entry: dict) -> str:
    claims = [name for name in ("equal_area", "conformal") if entry[name]]
    return ", ".join(name.replace("_", "-") for name in claims) or "–"


def image(entry: dict) -> str:
    width, height = entry["aspect"]
    faces = f"{entry['faces']} × " if entry["faces"] > 1 else ""
    return f"{faces}{width:g}:{height:g}"


def parameter(p: dict) -> str:
    unit = f" {p['unit']}" if p["unit"] else ""
    return (
        f"`{p['name']}` ({p['minimum']:g} … {p['maximum']:g}{unit}, default {p['default']:g}): "
        f"{p['doc']}"
    )


def readme_table(registry: list[dict]) -> str:
    rows = [
        [f"`{e['name']}`", e["summary"], e["coverage"], image(e), even(e), properties(e)]
        for e in registry
    ]
    return table(["name", "what it is", "covers", "image", "area of texels, max/min", "also"], rows)


def page(registry: list[dict], conventions: list[dict]) -> str:
    parts = [
        "# Projections",
        "Written by `tools/generate_docs.py` from the registry; do not edit.\n"
        "Words are those of [design.md](design.md#vocabulary). The image coordinates are (u, v) in "
        "[0, 1]², v runs down from row 0.",
        readme_table(registry),
    ]
    for e in registry:
        name = e["name"]
        facts = [
            f"- Axes (right, down, forward): `{e['axes']}`",
            f"- Covers: {e['coverage']}; image {image(e)} (width:height)",
            f"- Density dω/(du dv): {density(e)}; {properties(e)}"
            if properties(e) != "–"
            else f"- Density dω/(du dv): {density(e)}",
            f"- Singular: {e['singular']}",
        ]
        if e["layouts"]:
            facts.insert(1, f"- Layouts: {', '.join(f'`{x}`' for x in e['layouts'])}")
        facts += [f"- Parameter {parameter(p)}" for p in e["parameters"]]
        if e["conventions"]:
            facts.append(f"- Conventions: {', '.join(f'`{x}`' for x in e['conventions'])}")
        facts.append(f"- Source: {e['source']}")
        picture = f"images/projection-{name}.png"
        if (ROOT / "docs" / picture).exists():
            facts.insert(0, f"![The same sky as {name}]({picture})\n")
        parts += [f"## `{name}`: {e['title']}", e["summary"], "\n".join(facts)]

    rows = []
    for c in sorted(conventions, key=lambda c: c["kind"]):
        values = ", ".join(f"{k}={v:g}" for k, v in c["parameters"].items())
        shape = " ".join(x for x in (c["layout"], values) if x) or "–"
        version = f" ({c['version']})" if c["version"] else ""
        state = "tested" if c["verified"] else "read"
        call = f"`{c['kind']}:{c['name']}`"
        rows.append(
            [call, f"`{c['axes']}`", c["grid"], shape, c["note"], c["source"] + version, state]
        )
    parts += [
        "## Conventions",
        "What other programs do, as `sm.projection(kind, convention=name)` or the name "
        '`"kind:name"` gives it. *tested*: a test holds it against the program or its published '
        "formula; *read*: taken from its source or manual.",
        table(["name", "axes", "grid", "layout", "note", "source", "known by"], rows),
    ]
    return "\n\n".join(parts) + "\n"


def readme(text: str, registry: list[dict]) -> str:
    """Return README's text with the table between the two marks brought up to date."""
    before, _, rest = text.partition(BEGIN)
    _, found, after = rest.partition(END)
    if not found:
        raise SystemExit(f"README.md lacks the marks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n{readme_table(registry)}\n{END}{after}"


def render() -> dict[Path, str]:
    """Return the text that each generated file should have."""
    registry = _core.registry()
    readme_path = ROOT / "README.md"
    return {
        readme_path: readme(readme_path.read_text(encoding="utf-8"), registry),
        ROOT / "docs" / "projections.md": page(registry, _core.convention_table()),
    }


def stale() -> list[Path]:
    """Return the files whose text is not what it should be."""
    return [
        path
        for path, text in render().items()
        if not path.exists() or path.read_text(encoding="utf-8") != text
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only compare")
    check = parser.parse_args().check
    old = stale()
    texts = render()
    for path in old:
        if check:
            where = path.relative_to(ROOT)
            print(f"{where} is out of date: run python tools/generate_docs.py", file=sys.stderr)
        else:
            path.write_text(texts[path], encoding="utf-8")
    return 1 if check and old else 0


if __name__ == "__main__":
    raise SystemExit(main())
