"""Charts of BENCHMARKS.md: drawn from its tables, so that nothing is typed twice."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from .conventions import cells
from .source import ROOT, Source, toctree

PAGE = ROOT / "BENCHMARKS.md"
OURS, OTHERS = "#1f6fb4", ("#c9772b", "#5b8c3e", "#8a5fa8", "#7a7a7a", "#b94a5c", "#3f9a9a")
# Ids of an SVG are random otherwise, and each build would differ.
mpl.rcParams["svg.hashsalt"] = "spheremap"


@dataclass
class Table:
    """A table of the page: what stands in which column."""

    head: list[str]
    rows: list[list[str]]

    def column(self, name: str) -> list[str]:
        """Return the cells of a column."""
        return [row[self.head.index(name)] for row in self.rows]

    def numbers(self, name: str) -> np.ndarray:
        """Return a column as numbers; what is none is NaN."""
        return np.array([number(cell) for cell in self.column(name)])

    def pairs(self, first: str, second: str) -> list[str]:
        """Return two columns as one."""
        both = zip(self.column(first), self.column(second), strict=True)
        return [f"{plain(a)}, {plain(b)}" for a, b in both]

    def where(self, **wanted: str) -> Table:
        """Return the rows whose cells are these; a blank of a column's name is an underscore."""
        at = {self.head.index(name.replace("_", " ")): cell for name, cell in wanted.items()}
        kept = [row for row in self.rows if all(row[k] == cell for k, cell in at.items())]
        if not kept:
            raise SystemExit(f"BENCHMARKS.md has no row with {wanted}")
        return Table(self.head, kept)


def number(cell: str) -> float:
    """Return a cell as a number, NaN where it is none."""
    try:
        return float(cell.replace(",", "").rstrip("×"))
    except ValueError:
        return float("nan")


def tables(text: str) -> dict[str, list[Table]]:
    """Return the tables of the page, by the heading that they stand under."""
    found: dict[str, list[Table]] = {}
    for part in re.split(r"^#+ ", text, flags=re.MULTILINE)[1:]:
        title, _, body = part.partition("\n")
        for block in re.findall(r"(?:^\|.*\n)+", body, re.MULTILINE):
            head, _, *rows = map(cells, block.strip().splitlines())
            found.setdefault(title.strip(), []).append(Table(head, rows))
    return found


@dataclass
class Chart:
    """One chart: bars for each row of a table, one for each of its columns."""

    name: str
    title: str
    section: str
    says: str
    rows: list[str]
    values: dict[str, np.ndarray]
    unit: str
    line: float | None = None
    line_says: str = ""
    logarithmic: bool = False


def plain(text: str) -> str:
    """Return a cell without its marks."""
    return text.replace("`", "").replace("**", "")


def charts(found: dict[str, list[Table]]) -> list[Chart]:
    """Return all charts, in the order of the page."""
    memory = found["With `out=`, against a memcpy of the same bytes"][0]
    best = memory.head[memory.head.index("memcpy, ms") + 1]
    floats = {way: memory.where(type="f32", way=way) for way in ("encode", "decode")}
    peers = found["Against other libraries"][0]
    times = found["Times"][0]
    quality = found["Quality"][0]
    shrunk = quality.where(work="latlong 512×256 → cube 6×16×16", picture="grace_probe.hdr")
    pixels = found["HEALPix"][0]
    packing = found["Packing unit vectors"][0]
    printed = found["Printed code"][0]
    some = ["C loop", "ours, `out=`", "ours, fresh", "DrJit", "numba", "numpy"]
    healpix = ["ours, `out=`", "healpy", "cdshealpix"]
    programs = ["ours, ms", "cv2.remap", "py360convert", "ffmpeg v360", "skylibs"]
    return [
        Chart(
            "peers",
            "Directions to coordinates and back",
            "Against other libraries",
            "Millions of float32 directions a second, by those who have the map; more is better.",
            peers.pairs("map", "way"),
            {plain(name): peers.numbers(name) for name in some},
            "million directions a second",
        ),
        Chart(
            "memory",
            "Every map against the speed of memory",
            "With `out=`, against a memcpy of the same bytes",
            f"Time of a memcpy of the same bytes over ours, float32, {best}; more is better.",
            floats["encode"].column("map"),
            {way: table.numbers(best) for way, table in floats.items()},
            "memcpy's time over ours",
            line=1.0,
            line_says="memcpy",
        ),
        Chart(
            "convert",
            "Conversions of images",
            "Times",
            "Milliseconds of a conversion of RGB texels, by a logarithmic scale; less is better. "
            "cv2.remap has its coordinates ready made, which the others compute.",
            times.pairs("work", "filter"),
            {plain(name).removesuffix(", ms"): times.numbers(name) for name in programs},
            "milliseconds",
            logarithmic=True,
        ),
        Chart(
            "quality",
            "An HDRI made smaller",
            "Quality",
            "Error of a real light probe, 512×256, as a cube of 16²: percent of the truth's root "
            "mean square, by a logarithmic scale; less is better.",
            shrunk.column("program, filter"),
            {"error": shrunk.numbers("RMSE, %")},
            "root mean square error, %",
            logarithmic=True,
        ),
        Chart(
            "healpix",
            "HEALPix",
            "HEALPix",
            "Millions of pixels a second; more is better. healpy has one thread.",
            pixels.column("work"),
            {plain(name): pixels.numbers(name) for name in healpix},
            "million a second",
        ),
        Chart(
            "packing",
            "Packing unit vectors",
            "Packing unit vectors",
            "Millions of vectors a second, to two 16-bit integers and back; more is better.",
            packing.pairs("way", "who"),
            {"vectors": packing.numbers("million/s")},
            "million a second",
        ),
        Chart(
            "printed",
            "Printed code",
            "Printed code",
            "Nanoseconds a direction, one thread: the library's kernel, and the C that it prints, "
            "compiled; less is better.",
            printed.pairs("map", "verb"),
            {"kernel": printed.numbers("kernel, ns"), "printed C": printed.numbers("C, ns")},
            "nanoseconds",
        ),
    ]


def draw(chart: Chart) -> str:
    """Return a chart as SVG."""
    count, bars = len(chart.rows), len(chart.values)
    figure = Figure(figsize=(8.6, 0.9 + count * (0.115 * bars + 0.13)), layout="constrained")
    axes = figure.subplots()
    places = np.arange(count)
    colors = iter(OTHERS)
    for k, (name, values) in enumerate(chart.values.items()):
        ours = name.startswith(("ours", "encode", "kernel")) or bars == 1
        color = OURS if ours and k < 2 else next(colors)
        offset = (k - (bars - 1) / 2) * 0.8 / bars
        shown = [color] * count
        if bars == 1:
            shown = [OURS if "ours" in row else OTHERS[0] for row in chart.rows]
        axes.barh(places + offset, np.nan_to_num(values), 0.8 / bars, color=shown, label=name)
    if chart.line is not None:
        axes.axvline(chart.line, color="black", lw=0.8, ls="--", label=chart.line_says)
    if chart.logarithmic:
        axes.set_xscale("log")
    axes.set_yticks(places, chart.rows, fontsize=8)
    axes.set_ylim(count - 0.4, -0.6)
    axes.set_xlabel(chart.unit, fontsize=9)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(axis="x", alpha=0.3)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    if bars > 1 or chart.line is not None:
        axes.legend(fontsize=8, loc="best", framealpha=0.9)
    target = io.StringIO()
    figure.savefig(target, format="svg", metadata={"Date": None}, facecolor="white")
    return target.getvalue()


def anchor(heading: str) -> str:
    """Return the anchor that a heading gets."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def make(source: Source) -> None:
    """Write the charts and their page."""
    text = PAGE.read_text(encoding="utf-8")
    facts = re.findall(r"^- (?:Date|Machine|Versions): .*$", text, re.MULTILINE)
    parts = [
        "# Speed",
        "Charts of the tables of [BENCHMARKS.md](BENCHMARKS.md), which `make bench` writes. The "
        "first two were measured so, the others as their tables say:",
        "\n".join(facts),
    ]
    for chart in charts(tables(text)):
        source.write(f"charts/{chart.name}.svg", draw(chart))
        parts += [
            f"## {chart.title}",
            chart.says,
            f"![{chart.title}: {chart.says}](charts/{chart.name}.svg)",
            f"[The numbers](BENCHMARKS.md#{anchor(chart.section)})",
        ]
    parts.append(toctree(["BENCHMARKS"]))
    source.write("speed.md", "\n\n".join(parts) + "\n")
