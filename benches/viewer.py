"""Time the page of `sm.view` in Chromium without a graphics card; write its part of BENCHMARKS.md.

    python benches/viewer.py            # rewrites the section
    python benches/viewer.py --quick    # a smoke test: a small image, printed only

Chromium draws by SwiftShader, on the processor. CPU time is that of all of its processes.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import spheremap as sm
from measure import machine, publish, say, table
from playwright.sync_api import sync_playwright

BEGIN, END = "<!-- viewer: written by benches/viewer.py -->", "<!-- viewer: end -->"
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
CANVAS = (1280, 720)
LOOKS: dict[str, dict[str, Any]] = {
    "perspective": {},
    "with a graticule": {"graticule": 15},
    "in false color": {"false_color": True},
    "little planet": {"fov": 250},
    "`mollweide`": {"screen": "mollweide"},
}

# Milliseconds of frames that are drawn one by one, each waited for by reading a pixel of it.
FRAMES = """([samples, count]) => {
    const gl = spheremap.canvas.getContext("webgl2"), pixel = new Uint8Array(4), times = [];
    for (let k = 0; k < count; k++) {
        spheremap.look.yaw += 1;
        const start = performance.now();
        spheremap.draw(samples);
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        times.push(performance.now() - start);
    }
    return times;
}"""
# A hand that turns without a stop: milliseconds from frame to frame, and columns of the last.
TURN = """(count) => new Promise((done) => {
    const times = [];
    let last = 0;
    const step = (now) => {
        if (last) times.push(now - last);
        last = now;
        if (times.length === count) done({ times, width: spheremap.canvas.width });
        else { spheremap.set({ yaw: spheremap.look.yaw + 1 }, true); requestAnimationFrame(step); }
    };
    requestAnimationFrame(step);
})"""


def cpu() -> float:
    """Return the CPU seconds of all processes below this one, or NaN where no /proc tells."""
    if not Path("/proc").is_dir():
        return float("nan")
    parents, ticks = {}, {}
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = place.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        number = int(place.parent.name)
        parents[number] = int(fields[1])
        # Of its own, and of those of its children that have ended.
        ticks[number] = sum(int(field) for field in fields[11:15])

    def below(number: int) -> bool:
        number = parents.get(number, 0)
        return number == os.getpid() or (number != 0 and below(number))

    return sum(t for n, t in ticks.items() if below(n)) / os.sysconf("SC_CLK_TCK")


@contextmanager
def opened(browser: Any, path: Path) -> Iterator[Any]:
    page = browser.new_page(viewport={"width": CANVAS[0], "height": 900})
    page.goto(path.as_uri(), wait_until="commit")
    page.wait_for_function("window.spheremap")
    yield page
    page.close()


def fit(page: Any) -> None:
    """Give the canvas its size."""
    beside = 900 - page.evaluate("spheremap.canvas.clientHeight")
    page.set_viewport_size({"width": CANVAS[0], "height": CANVAS[1] + beside})
    # It is drawn anew, and what moves is compiled.
    page.wait_for_timeout(1500)


def interaction(browser: Any, folder: Path, quick: bool) -> list[list[str]]:
    height, count = (64, 4) if quick else (1024, 40)
    sky = sm.directions("latlong", height, dtype=np.float32) ** 2
    body = []
    for name, look in LOOKS.items():
        say(name)
        path = folder / "look.html"
        sm.view(sky, "latlong", **look).save(path)
        with opened(browser, path) as page:
            page.evaluate("spheremap.ready.then(() => true)")
            fit(page)
            row = [name]
            for samples in (3, 1):
                page.evaluate(FRAMES, [samples, 2])
                before = cpu()
                times = page.evaluate(FRAMES, [samples, count])
                each = (cpu() - before) / count
                row += [f"{statistics.median(times):.0f}", f"{1e3 * each:.0f}"]
            page.evaluate(TURN, count)
            turned = page.evaluate(TURN, 2 * count)
            rate = 1e3 / statistics.mean(turned["times"])
            row += [f"{rate:.0f}", f"{turned['width']}"]
            body.append(row)
    return body


def opening(browser: Any, folder: Path, quick: bool) -> list[list[str]]:
    height = 512 if quick else 8192
    sky = np.empty((height, 2 * height, 3), np.float32)
    small = sm.directions("latlong", height // 8, dtype=np.float32) ** 2
    noise = np.random.default_rng(0).random((height, 2 * height), np.float32) * 0.2 + 0.9
    sky[:] = np.repeat(np.repeat(small, 8, axis=0), 8, axis=1) * noise[..., np.newaxis]
    path, body = folder / "large.html", []
    for kind in ("float32", "uint8"):
        say(kind)
        image = sky if kind == "float32" else (255 * sky.clip(0, 1)).astype(np.uint8)
        sm.view(image[:64, :128], "latlong").save(path)
        start, spent = time.perf_counter(), time.process_time()
        sm.view(image, "latlong")._shown_in_widget()
        widget, widget_cpu = time.perf_counter() - start, time.process_time() - spent
        start, spent = time.perf_counter(), time.process_time()
        sm.view(image, "latlong").save(path)
        saved, saved_cpu = time.perf_counter() - start, time.process_time() - spent
        before, start = cpu(), time.perf_counter()
        with opened(browser, path) as page:
            page.evaluate("spheremap.first.then(() => true)")
            first = time.perf_counter() - start
            page.evaluate("spheremap.ready.then(() => true)")
            whole, whole_cpu = time.perf_counter() - start, cpu() - before
        size = path.stat().st_size / 1e6
        body.append(
            [
                f"{kind}, {size:.0f} MB",
                f"{widget:.2f} ({widget_cpu:.2f})",
                f"{saved:.2f} ({saved_cpu:.2f})",
                f"{first:.2f}",
                f"{saved + first:.2f}",
                f"{whole:.2f} ({whole_cpu:.2f})",
            ]
        )
    return body


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with a small image")
    args = parser.parse_args()
    program = os.environ.get("SPHEREMAP_CHROMIUM") or shutil.which("chromium")
    with tempfile.TemporaryDirectory() as name, sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=program, args=ARGUMENTS)
        moved = interaction(browser, Path(name), args.quick)
        found = opening(browser, Path(name), args.quick)
        version = browser.version
        browser.close()
    load = os.getloadavg()[0]
    busy = f"; other work had the machine as well, at a load of {load:.0f}" if load > 3 else ""
    text = [
        BEGIN,
        "## The viewer",
        f"The page of `sm.view` in Chromium {version}, which draws on the processor by "
        f"SwiftShader; {machine()}{busy}. A canvas of {CANVAS[0]}×{CANVAS[1]} shows a latlong of "
        "2048×1024 floats. A frame at rest has several lookups where it sees several texels, one "
        "of a hand that moves has one. Frames a second are of a hand that turns without a stop: "
        "the canvas then has as many columns as it takes for 25.",
        table(
            [
                "what is seen",
                "at rest, ms",
                "its CPU ms",
                "moving, ms",
                "its CPU ms",
                "frames a second",
                "at columns",
            ],
            moved,
        ),
        "Opening a panorama of 16384×8192 in seconds, of CPU time in parentheses: what a widget "
        "is sent first, a page saved, its first picture, both, and all of its 4096×2048 texels.",
        table(["image, page", "widget", "save", "first picture", "both", "whole page"], found),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
