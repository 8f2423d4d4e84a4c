"""Write what README and docs/ have of the registry: a list, tables, and two whole pages.

All of it comes from the core's tables.

python tools/generate_docs.py            write them
python tools/generate_docs.py --check    fail if one is out of date
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from pathlib import Path
from textwrap import wrap

import spheremap as sm
from spheremap import _core
from spheremap.map.table import HEAD, NOTE, figures

ROOT = Path(__file__).resolve().parents[1]
BEGIN = "<!-- projections: written by tools/generate_docs.py -->"
END = "<!-- end of projections -->"
FILTERS_BEGIN = "<!-- filters: written by tools/generate_docs.py -->"
FILTERS_END = "<!-- end of filters -->"
LANGUAGES_BEGIN = "<!-- languages: written by tools/generate_docs.py -->"
LANGUAGES_END = "<!-- end of languages -->"
RAN_BEGIN = "<!-- ran: written by tools/generate_docs.py from tests/languages/ran.json -->"
RAN_END = "<!-- end of ran -->"


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
        f"`{p['name']}` in ({p['minimum']:g}, {p['maximum']:g}]{unit}, default {p['default']:g}: "
        f"{p['doc']}"
    )


def heading(entry: dict) -> str:
    return f"`{entry['name']}`: {entry['title']}"


def anchor(entry: dict) -> str:
    """Return the name of a heading's place on its page, as GitHub makes it."""
    kept = re.sub(r"[^\w\- ]", "", heading(entry).lower())
    return kept.replace(" ", "-")


def names(registry: list[dict]) -> str:
    """Return a line of links to all projections."""
    links = [f"[`{e['name']}`](docs/projections.md#{anchor(e)})" for e in registry]
    return "\n".join(wrap(", ".join(links), 128, break_long_words=False, break_on_hyphens=False))


def registry_table(registry: list[dict]) -> str:
    rows = [
        [f"`{e['name']}`", e["summary"], e["coverage"], image(e), even(e), properties(e)]
        for e in registry
    ]
    return table(["name", "what it is", "covers", "image", "area of texels, max/min", "also"], rows)


# What the names of one map have to do with each other, which no entry can say by itself.
KIN = """## Lambert's azimuthal map has three names

`sphere`, `equisolid` and what cartographers call Lambert's azimuthal equal-area map are one
formula, r ∝ sin(θ/2). `sphere` is the whole of it as OpenGL and a photo of a mirror ball have it,
with z toward the viewer; `equisolid` is the part within `fov` of the axis, as fisheye lenses have
it, and at 360° the whole; PROJ's `laea` is either, with axes to match. Its hemisphere (`equisolid`
at 180°) made a square is `concentric`, and both hemispheres folded into one are `equal_area`."""


def chooser(registry: list[dict]) -> str:
    rows = [list(figures(e["name"]).cells) for e in registry]
    rows = [[f"`{row[0]}`", *row[1:]] for row in rows]
    return f"## Which one\n\n{NOTE}\n\n{table(list(HEAD), rows)}"


def page(registry: list[dict]) -> str:
    parts = [
        "# Projections",
        "Written by `tools/generate_docs.py` from the registry; do not edit.\n"
        "Words are those of [architecture.md](architecture.md#glossary). The image coordinates are "
        "(u, v) in [0, 1]², v runs down from row 0.",
        registry_table(registry),
        chooser(registry),
        KIN,
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
            *([f"- Elsewhere called {', '.join(e['known_as'])}"] if e["known_as"] else []),
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
        parts += [f"## {heading(e)}", e["summary"], "\n".join(facts)]

    link = "[conventions.md](conventions.md)"
    parts.append(f"## Conventions\n\nWhat other programs do is a table of its own: {link}.")
    return "\n\n".join(parts) + "\n"


CONVENTIONS = """\
# Conventions

Written by `tools/generate_docs.py` from the table in `src/map/conventions`; do not edit.

Everybody lays out the same maps differently. Each row below says how one program does it. Use it
as `sm.projection("latlong", convention="blender")`, or wherever a projection is asked for as
`"latlong:blender"`:

    cube = sm.convert(panorama, "latlong:blender", "cube:opengl")
    print(sm.align.compare("latlong:blender", "latlong:threejs"))
    sm.explain("cube:openexr")
    print(sm.align.identify(photo, render))        # which of all these is it?

`convert` knows what up means to each: blender's +z goes to opengl's +y ([worlds](#worlds)).

**How to read it.** *Axes* are the world axes that point right, down and forward (into the middle
of the image). *Mirrored* is as seen from inside a right-handed world; a program with a
left-handed world sees the opposite, and the world's column says which those are. *Grid* is where
texels lie: `centers` at (i + 1/2)/n, `corners` at i/(n - 1), `corners-v` corners along v alone.
*Known by*: "run against" means that a test of this project runs that version of the program and
compares; "read from source" means that the formula was read there, and that a test holds the row
to it.

**The pictures** show one sphere as each program stores it, row 0 at the top. The letters are
painted on the sphere, upright and readable from inside in a right-handed world: in a mirrored
image they are mirrored. A stack of faces is shown side by side.

## Worlds

Programs do not agree what is up, what lies ahead, and whether x, y, z are a left hand or a right
one. `convert`, plans, `embed`, the lights of one map in another, `bake` and the command line match
worlds: up to up, ahead to ahead, right to right, as a person sees them who stands there. So nothing
is tilted or mirrored that was not, whatever becomes of (x, y, z). `world="literal"`
(`--world literal`) keeps (x, y, z) instead. `encode`, `decode` and `sample` speak of one map, in
the directions of its own program; `p.in_world_of(q)` is p in the directions of q's.

*Ahead* is what a camera of the program looks along that nobody has turned. Where a program has no
camera it is what the middle column of its panoramas shows. One that only turns pictures into
pictures has the hand in which its own are not mirrored. Names without a program have +y up, -z
ahead, and are right-handed.
"""

NOT_YET = """\
## What has no row, and why

- **skylibs `skylatlong`** is the upper half of a panorama over the whole height of the image. A
  latlong has no parameter for a part of the sphere.
- **three.js MatCap** is looked up at 0.495 of the radius instead of 0.5. A matcap has no
  parameter for a margin.
- **HDRShop**: no source and no specification of its axes could be found, only files that other
  programs call compatible. Use `align.identify` on an image of yours.
- **pyequilib** is read and not run in the tests: it imports PyTorch, several gigabytes, on every
  start. Run once by hand with PyTorch left out, its NumPy code agreed with its rows to 3e-15.
- **Draco** has its row from its source: the directions that it gives back lie on the same grid
  whichever axis is the pole.
- **OpenEXR's exrenvmap** comes in no Python wheel. Its rows are tested on the two images of one
  scene that the OpenEXR project publishes, one per kind.
- **three.js** computes in shaders, which need a graphics card; its formulas are read.
- **Unreal's importer** of panoramas reads texel i at u = i/W. That is no grid here: it lies half
  a texel beside the row. So does Babylon.js.
- **USD's other formats** of a dome light, **glTF's image-based lights**, Arnold, Cycles through
  Hydra, Substance, Marmoset, Houdini, Nuke and PTGui:
  [what was looked for](decisions/conventions.md#which-programs-have-no-row).
"""


def worlds_table(conventions: list[dict]) -> str:
    programs: dict[tuple[str, ...], list[str]] = {}
    for c in conventions:
        world = (c["up"], c["forward"], hand(c), c["ahead"])
        names = programs.setdefault(world, [])
        # Rows that are the same program in other layouts go by its name alone.
        program = c["name"] if c["name"].endswith("z-up") else c["name"].split("-")[0]
        if program not in names:
            names.append(program)
    rows = [
        [", ".join(f"`{name}`" for name in sorted(names)), *world]
        for world, names in sorted(programs.items(), key=lambda entry: entry[0][:3])
    ]
    return table(["program", "up", "ahead", "hand", "ahead is"], rows)


def hand(c: dict) -> str:
    return "left-handed" if c["left_handed"] else "right-handed"


def conventions_page(registry: list[dict], conventions: list[dict]) -> str:
    parts = [CONVENTIONS.rstrip(), worlds_table(conventions)]
    for entry in registry:
        rows = [c for c in conventions if c["kind"] == entry["name"]]
        if not rows:
            continue
        body = []
        for c in rows:
            p = sm.projection(c["kind"], convention=c["name"])
            values = ", ".join(f"{k} = {v:g}" for k, v in c["parameters"].items())
            laid = " ".join(x for x in (c["layout"], values) if x)
            picture = f"images/conventions/{c['kind']}-{c['name']}.png"
            body.append(
                [
                    f"`{c['name']}`",
                    f"![]({picture})",
                    f"`{c['axes']}`" + ("<br>" + laid if laid else ""),
                    "mirrored" if p.mirrored else "no",
                    c["grid"],
                    f"{c['up']} up, {c['forward']} ahead, {hand(c)}",
                    c["note"],
                    f"{c['source']} ({c['version']}): {c['verified']}",
                ]
            )
        head = ["name", "picture", "axes", "mirrored", "grid", "world", "note", "known by"]
        parts += [f"## `{entry['name']}`", table(head, body)]
    return "\n\n".join([*parts, NOT_YET.rstrip()]) + "\n"


# Which verbs take filters of each method.
TAKEN_BY = {
    "lookup": "`sample`, `sample_uv`, `convert`",
    "mipmapped": "`sample` and `sample_uv` with `lod` or `derivatives`, `convert`",
    "area": "`convert`",
}


def filter_table(filters: list[dict]) -> str:
    rows = [
        [
            ", ".join(f"`{name}`" for name in (e["name"], *e["also"])),
            e["takes"],
            e["summary"],
            "–" if e["support"] is None else f"{e['support']:g}",
            "yes" if e["ringing"] else "no",
            TAKEN_BY[e["method"]],
        ]
        for e in filters
    ]
    head = ["filter", "what it takes", "for", "support, texels", "rings", "in"]
    return table(head, rows)


def language_table() -> str:
    rows = [
        [
            f"`{e['name']}`",
            e["title"],
            f"`.{e['extension']}`",
            "32, 64" if e["double"] else "32",
            e["promise"],
        ]
        for e in _core.code_languages()
    ]
    head = ["name", "language", "files", "bits of a number", "`exact`"]
    return table(head, rows)


# What writes it: the tests, told --record-languages.
RAN = ROOT / "tests" / "languages" / "ran.json"


def counted(done: dict | None) -> str:
    """Return how many of a subject ran, and of how many every number was the library's."""
    if done is None:
        return "–"
    return f"{done['run']}" if "same" not in done else f"{done['run']} ({done['same']})"


def ran_table() -> str:
    """Return what the tests recorded of each language, a row a runtime, width and precision."""
    record = json.loads(RAN.read_text(encoding="utf-8"))
    rows = []
    for language in _core.code_languages():
        name = f"`{language['name']}`"
        of_language = [row for row in record if row["language"] == language["name"]]
        if not of_language:
            rows.append([name, "not run", *["–"] * 8])
        for row in of_language:
            maps = row.get("maps", {})
            apart = maps.get("apart")
            rows.append(
                [
                    name,
                    row["runtime"],
                    f"`{row['precision']}`",
                    str(row["bits"]),
                    counted(row.get("maps")),
                    f"{len(maps['verbs'])}" if maps else "–",
                    f"{maps['directions']:,}" if "directions" in maps else "–",
                    "–" if apart is None else f"{apart:.0e}" if apart else "0",
                    counted(row.get("packings")),
                    row["date"],
                ]
            )
    head = ["name", "ran by", "precision", "bits", "maps (same)", "verbs", "directions"]
    return table([*head, "apart, rad", "packings (same)", "on"], rows)


def between(path: Path, begin: str, end: str, body: str) -> str:
    """Return a file's text with what stands between two marks brought up to date."""
    return replaced(path.read_text(encoding="utf-8"), path.name, begin, end, body)


def replaced(text: str, name: str, begin: str, end: str, body: str) -> str:
    """Return a text with what stands between two marks brought up to date."""
    before, _, rest = text.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise SystemExit(f"{name} lacks the marks {begin} and {end}")
    return f"{before}{begin}\n{body}\n{end}{after}"


def languages_page(path: Path) -> str:
    """Return the page of languages with both of its tables."""
    text = path.read_text(encoding="utf-8")
    text = replaced(text, path.name, LANGUAGES_BEGIN, LANGUAGES_END, language_table())
    return replaced(text, path.name, RAN_BEGIN, RAN_END, ran_table())


def render() -> dict[Path, str]:
    """Return the text that each generated file should have."""
    registry = _core.registry()
    readme = ROOT / "README.md"
    resampling = ROOT / "docs" / "resampling.md"
    languages = ROOT / "docs" / "languages.md"
    filters = filter_table(_core.filters())
    return {
        readme: between(readme, BEGIN, END, names(registry)),
        resampling: between(resampling, FILTERS_BEGIN, FILTERS_END, filters),
        languages: languages_page(languages),
        ROOT / "docs" / "projections.md": page(registry),
        ROOT / "docs" / "conventions.md": conventions_page(registry, _core.convention_table()),
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
