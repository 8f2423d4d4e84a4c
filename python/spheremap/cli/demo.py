"""The demonstration: one sky in every projection, there and back, on one sheet."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import spheremap as sm
from spheremap import io, plot
from spheremap.cli import files, picture, sky
from spheremap.cli.steps import Step
from spheremap.map.flat import flat
from spheremap.map.size import matching_size

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DIRECTIONS = 1 << 20
# Of a picture on the sheet, about as much as is drawn.
_LONGEST = 600


class Row(NamedTuple):
    """What was measured of one projection."""

    name: str
    width: int
    height: int
    covers: float
    mtexels: float
    mdirections: float
    error: float


class Report(NamedTuple):
    """What the demonstration did."""

    source: str
    rows: list[Row]
    sheet: Path


def run(
    folder: Path, file: Path | None, name: str | None, part: str | None, size: int, step: Step
) -> Report:
    """Fill the folder and return the measurements."""
    if find_spec("matplotlib") is None:
        raise ImportError("the demonstration draws with matplotlib: pip install spheremap[plot]")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OSError(f"cannot make the folder {str(folder)!r}: {error.strerror}") from None
    sheet = folder / "contact_sheet.png"
    io.check_target(sheet)

    source, image, src = _source(file, name, part, size, step)
    pano = image if src == sm.projection("latlong") else sm.convert(image, src, "latlong")
    around = sm.directions("latlong", pano.shape[:2], dtype=np.float32)
    known = sm.covers(around, src)
    sphere = _random_directions()

    rows, pictures = [], []
    # What is timed has the machine for itself; the rest is done while a file is compressed.
    with ThreadPoolExecutor(1) as writer:
        for kind in sm.projections():
            p = flat(kind)
            step(f"converting to {files.described(p)}")
            converted, seconds = _timed(partial(sm.convert, image, src, p))
            speed = _encode_speed(p, sphere)
            written = writer.submit(io.write, folder / f"{kind}.exr", converted)
            height, width = converted.shape[:2]
            back = sm.convert(converted, p, "latlong", size=pano.shape[:2])
            rows.append(
                Row(
                    files.described(p),
                    width,
                    height,
                    p.covered_solid_angle / (4 * math.pi),
                    height * width * p.used_part / seconds / 1e6,
                    speed,
                    _error(back, pano, known & sm.covers(around, p)),
                )
            )
            pictures.append((p, _small(converted, p)))
            written.result()
            step.done()

    step("drawing the contact sheet")
    io.write(sheet, _contact_sheet(source, pictures, rows, labels=file is not None))
    return Report(source, rows, sheet)


def _source(
    file: Path | None,
    name: str | None,
    part: str | None,
    size: int,
    step: Callable[[str], None],
) -> tuple[str, NDArray[Any], sm.Projection]:
    if file is not None:
        step(f"reading {file.name}")
        loaded = picture.load(file, part=part)
        image = picture.as_light(loaded).pixels
        src = files.taken(name, loaded.projection, *image.shape[:2])
        return f"{file.name} ({files.described(src)})", image, src
    step("making the sky")
    src = sm.projection("latlong")
    return "analytic sky", sky.radiance(sm.directions(src, size, dtype=np.float32)), src


def _timed(work: Callable[[], NDArray[Any]]) -> tuple[NDArray[Any], float]:
    seconds = math.inf
    for _ in range(2):  # the first run may start threads
        start = time.perf_counter()
        result = work()
        seconds = min(seconds, time.perf_counter() - start)
    return result, seconds


def _random_directions() -> NDArray[np.float32]:
    return np.random.default_rng(0).standard_normal((_DIRECTIONS, 3), dtype=np.float32)


def _encode_speed(p: sm.Projection, directions: NDArray[np.float32]) -> float:
    out = p.encode(directions)
    _, seconds = _timed(lambda: p.encode(directions, out=out))
    return len(directions) / seconds / 1e6


def _error(got: NDArray[Any], wanted: NDArray[Any], where: NDArray[np.bool_]) -> float:
    # What counts for nothing is blanked: to pick out the rest would take longer than the sums.
    with np.errstate(invalid="ignore"):
        off, size = np.abs(got - wanted), np.abs(wanted)
    for nothing in (~where, ~np.isfinite(off)):
        off[nothing] = size[nothing] = 0
    light = float(size.sum(dtype=np.float64))
    return float(off.sum(dtype=np.float64)) / light if light > 0 else 0.0


def _small(image: NDArray[Any], p: sm.Projection) -> NDArray[Any]:
    longest = max(image.shape[:2])
    if longest <= _LONGEST:
        return image
    size = matching_size(image.shape, p, p) * _LONGEST // longest
    return sm.convert(image, p, p, size=size)


def _contact_sheet(
    source: str,
    pictures: list[tuple[sm.Projection, NDArray[Any]]],
    rows: list[Row],
    *,
    labels: bool,
) -> NDArray[np.uint8]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = math.ceil(math.sqrt(len(pictures)))
    lines = math.ceil(len(pictures) / columns)
    figure = Figure(figsize=(5 * columns, 5 * lines + 0.6), dpi=110, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves it untyped
    figure.suptitle(f"{source} in every projection", fontsize=18)
    axes = figure.subplots(lines, columns, squeeze=False)
    for ax, (p, image), row in zip(axes.flat, pictures, rows, strict=False):
        plot.show(image, p, ax=ax, labels=labels, exposure=None if labels else 0.0)
        view = ", mirrored" if p.mirrored else ""
        ax.set_title(f"{row.name}\n{row.width} × {row.height}, covers {row.covers:.0%}{view}")
    figure.supxlabel(
        "mirrored: as its standard has it, like a mirror ball or a cube seen from outside",
        fontsize=12,
    )
    for ax in axes.flat[len(pictures) :]:
        ax.set_axis_off()
    canvas.draw()
    return np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3])
