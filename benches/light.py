"""Time sums of light against numpy, numba, ducc0, healpy and pyshtools; rewrite their section.

    python benches/light.py            # rewrites the section
    python benches/light.py --print    # prints it only

Entrants of a row take turns; a time is the median of its rounds.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ducc0
import healpy
import numba
import numpy as np
import pyshtools
import spheremap as sm

FILE = Path(__file__).resolve().parent.parent / "BENCHMARKS.md"
START, END = "<!-- light: written by benches/light.py -->", "<!-- light: end -->"


def race(entrants: dict[str, Callable[[], Any]], rounds: int) -> dict[str, float]:
    times: dict[str, list[float]] = {name: [] for name in entrants}
    for call in entrants.values():
        call()
    for _ in range(rounds):
        for name, call in entrants.items():
            start = time.perf_counter()
            call()
            times[name].append(1e3 * (time.perf_counter() - start))
    return {name: statistics.median(ms) for name, ms in times.items()}


@numba.njit(parallel=True, fastmath=True)
def _numba_sum(d: np.ndarray, flux: np.ndarray, n: np.ndarray, out: np.ndarray) -> None:
    for t in numba.prange(len(n)):
        r = g = b = np.float32(0)
        for s in range(len(d)):
            cos = n[t, 0] * d[s, 0] + n[t, 1] * d[s, 1] + n[t, 2] * d[s, 2]
            if cos > 0:
                r += cos * flux[s, 0]
                g += cos * flux[s, 1]
                b += cos * flux[s, 2]
        out[t, 0], out[t, 1], out[t, 2] = r, g, b


def irradiance() -> list[str]:
    image = np.random.default_rng(0).random((512, 1024, 3)).astype(np.float32)
    d = sm.directions("latlong", 512, dtype=np.float32).reshape(-1, 3)
    n = sm.directions("latlong", 32, dtype=np.float32).reshape(-1, 3)
    flux = image.reshape(-1, 3) * sm.light.weights("latlong", 512).reshape(-1, 1).astype(np.float32)
    out = np.empty((len(n), 3), np.float32)

    def product() -> np.ndarray:
        parts = (
            np.maximum(n @ d[k : k + 16384].T, 0) @ flux[k : k + 16384]
            for k in range(0, len(d), 16384)
        )
        return sum(parts)

    ms = race(
        {
            "spheremap": lambda: sm.light.irradiance(image, "latlong", "latlong", size=32),
            "numba": lambda: _numba_sum(d, flux, n, out),
            "numpy": product,
        },
        5,
    )
    return [
        "Irradiance of 1024 × 512 × 3 to 64 × 32, exact sums (ours float64, theirs float32):",
        "",
        "| | ms | ours is faster by | target | reached |",
        "| --- | ---: | ---: | ---: | --- |",
        f"| spheremap | {ms['spheremap']:.1f} | | | |",
        f"| numpy, in chunks | {ms['numpy']:.0f} | {ms['numpy'] / ms['spheremap']:.0f} | 20 | "
        f"{_reached(ms['numpy'] / ms['spheremap'], 20)} |",
        f"| numba | {ms['numba']:.0f} | {ms['numba'] / ms['spheremap']:.0f} | 7 | "
        f"{_reached(ms['numba'] / ms['spheremap'], 7)} |",
    ]


def harmonics() -> list[str]:
    rng = np.random.default_rng(0)
    lat = rng.random((512, 1024, 3)).astype(np.float32)
    threads = sm.get_num_threads()

    def ducc() -> list[np.ndarray]:
        return [
            ducc0.sht.analysis_2d(
                map=np.ascontiguousarray(lat[np.newaxis, ..., c]),
                spin=0,
                lmax=8,
                mmax=8,
                geometry="F1",
                nthreads=threads,
            )
            for c in range(3)
        ]

    # On their own grids: HEALPix, and Driscoll and Healy's with a row on a pole.
    pixels = rng.random((3, healpy.nside2npix(209)))
    rows_of_dh = np.ascontiguousarray(np.moveaxis(lat, -1, 0), np.float64)

    def healpy_alm() -> list[np.ndarray]:
        return [healpy.map2alm(channel, lmax=8, iter=0) for channel in pixels]

    def pyshtools_dh() -> list[np.ndarray]:
        expand = pyshtools.expand.SHExpandDH
        return [expand(channel, sampling=2, lmax_calc=8) for channel in rows_of_dh]

    images: dict[str, Any] = {"latlong": lat}
    for name, shape in (
        ("cube", (6, 296, 296)),
        ("octahedral", (724, 724)),
        ("angular", (816, 816)),
    ):
        images[name] = rng.random((*shape, 3)).astype(np.float32)
    entrants: dict[str, Callable[[], Any]] = {
        "ducc0": ducc,
        "healpy": healpy_alm,
        "pyshtools": pyshtools_dh,
    }
    for name, image in images.items():
        entrants[name] = lambda image=image, name=name: sm.sh.project(image, name, order=8)
    ms = race(entrants, 15)
    rows = [
        "Spherical harmonics of order 8, half a million texels × 3 (ducc0: the latlong, float32; "
        "healpy: nside 209, no iterations; pyshtools: Driscoll and Healy's grid; both float64):",
        "",
        "| | ms | of ducc0's time | target | reached |",
        "| --- | ---: | ---: | ---: | --- |",
        f"| ducc0 | {ms['ducc0']:.1f} | | | |",
    ]
    for name in ("healpy", "pyshtools"):
        rows.append(f"| {name} | {ms[name]:.1f} | {ms[name] / ms['ducc0']:.2f} | | |")
    for name in images:
        ratio, goal = ms[name] / ms["ducc0"], 1.2 if name == "latlong" else 3
        rows.append(f"| {name} | {ms[name]:.1f} | {ratio:.2f} | {goal} | {_reached(goal, ratio)} |")
    return rows


def chain() -> list[str]:
    image = np.random.default_rng(0).random((512, 1024, 3)).astype(np.float32)
    start = time.perf_counter()
    sm.light.prefilter_chain(image, "latlong", "cube", size=512, levels=6, samples=1024)
    seconds = time.perf_counter() - start
    return [
        f"GGX chain of 6 levels from 512² a face, 1024 samples a texel: {seconds:.1f} s "
        f"(target: 10; reached: {_reached(10, seconds)})."
    ]


def _reached(large: float, small: float) -> str:
    return "yes" if large >= small else "**no**"


def main() -> None:
    parts = [START, "", "## Light", "", *irradiance(), "", *harmonics(), "", *chain(), "", END]
    text = "\n".join(parts)
    print(text)
    if "--print" not in sys.argv:
        old = FILE.read_text()
        head, tail = old, ""
        if START in old:
            head, rest = old.split(START)
            tail = rest.split(END)[1]
        FILE.write_text(head.rstrip() + "\n\n" + text + tail.rstrip() + "\n")


if __name__ == "__main__":
    main()
