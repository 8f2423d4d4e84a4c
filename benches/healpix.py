"""Time HEALPix pixel numbers against healpy and cdshealpix; write their section of BENCHMARKS.md.

    python benches/healpix.py            # rewrites the section
    python benches/healpix.py --maps     # rewrites what it says of whole maps alone
    python benches/healpix.py --quick    # a smoke test: small arrays, printed only

Entrants of a row take turns; a time is the median of its rounds. healpy has one thread; cdshealpix
is told to use as many as we do, and gets longitudes and latitudes, which it works on, ready made.
Whole maps are timed by the CPU time of all threads together, beside a copy of the map.
"""

from __future__ import annotations

import argparse
import os
import re
import time
from pathlib import Path

import astropy.units as u
import cdshealpix
import cdshealpix.nested
import cdshealpix.ring
import healpy
import numpy as np
import spheremap as sm
from astropy.coordinates import Latitude, Longitude
from measure import ROOT, Call, race, say, table
from spheremap import healpix

BEGIN, END = "<!-- healpix: written by benches/healpix.py -->", "<!-- healpix: end -->"
MAPS, MAPS_END = (
    "<!-- healpix maps: written by benches/healpix.py -->",
    "<!-- healpix maps: end -->",
)
TO_HEALPY, TO_CDS = 8.0, 3.0


def rows(nside: int, count: int, args: argparse.Namespace) -> list[list[str]]:
    rng = np.random.default_rng(nside)
    d = rng.standard_normal((count, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    single = d.astype(np.float32)
    x, y, z = (np.ascontiguousarray(c) for c in d.T)
    lon = Longitude(np.degrees(np.arctan2(y, x)), u.deg)
    lat = Latitude(np.degrees(np.arcsin(z)), u.deg)
    degrees = lon.deg, lat.deg
    theta, phi = np.arccos(z), np.arctan2(y, x)
    depth, threads = nside.bit_length() - 1, args.threads
    pixels = rng.integers(0, 12 * nside * nside, count)
    whole, triples = np.empty(count, np.int64), np.empty((count, 3))
    work: dict[str, dict[str, Call]] = {
        "vec2pix, nested": {
            "out": lambda: healpix.vec2pix(nside, d, nest=True, out=whole),
            "ours": lambda: healpix.vec2pix(nside, d, nest=True),
            "healpy": lambda: healpy.vec2pix(nside, x, y, z, nest=True),
            "cds": lambda: cdshealpix.nested.lonlat_to_healpix(
                lon, lat, depth, num_threads=threads
            ),
        },
        "vec2pix, ring": {
            "out": lambda: healpix.vec2pix(nside, d, out=whole),
            "ours": lambda: healpix.vec2pix(nside, d),
            "healpy": lambda: healpy.vec2pix(nside, x, y, z),
            "cds": lambda: cdshealpix.ring.lonlat_to_healpix(lon, lat, nside, num_threads=threads),
        },
        "vec2pix of float32, nested": {
            "out": lambda: healpix.vec2pix(nside, single, nest=True, out=whole),
            "ours": lambda: healpix.vec2pix(nside, single, nest=True),
        },
        "ang2pix of longitude and latitude, nested": {
            "ours": lambda: healpix.ang2pix(nside, *degrees, nest=True, lonlat=True),
            "healpy": lambda: healpy.ang2pix(nside, *degrees, nest=True, lonlat=True),
            "cds": lambda: cdshealpix.nested.lonlat_to_healpix(
                lon, lat, depth, num_threads=threads
            ),
        },
        "pix2vec, nested": {
            "out": lambda: healpix.pix2vec(nside, pixels, nest=True, out=triples),
            "ours": lambda: healpix.pix2vec(nside, pixels, nest=True),
            "healpy": lambda: healpy.pix2vec(nside, pixels, nest=True),
        },
        "pix2vec, ring": {
            "out": lambda: healpix.pix2vec(nside, pixels, out=triples),
            "ours": lambda: healpix.pix2vec(nside, pixels),
            "healpy": lambda: healpy.pix2vec(nside, pixels),
        },
        "nest2ring": {
            "out": lambda: healpix.nest2ring(nside, pixels, out=whole),
            "ours": lambda: healpix.nest2ring(nside, pixels),
            "healpy": lambda: healpy.nest2ring(nside, pixels),
            "cds": lambda: cdshealpix.to_ring(pixels, depth, num_threads=threads),
        },
        "ring2nest": {
            "out": lambda: healpix.ring2nest(nside, pixels, out=whole),
            "ours": lambda: healpix.ring2nest(nside, pixels),
            "healpy": lambda: healpy.ring2nest(nside, pixels),
        },
        "neighbors, nested": {
            "ours": lambda: healpix.neighbors(nside, pixels, nest=True),
            "healpy": lambda: healpy.get_all_neighbours(nside, pixels, nest=True),
            "cds": lambda: cdshealpix.nested.neighbours(pixels, depth, threads),
        },
        "neighbors, ring": {
            "ours": lambda: healpix.neighbors(nside, pixels),
            "healpy": lambda: healpy.get_all_neighbours(nside, pixels),
        },
        "interpolation_weights, nested": {
            "ours": lambda: healpix.interpolation_weights(nside, theta, phi, nest=True),
            "healpy": lambda: healpy.get_interp_weights(nside, theta, phi, nest=True),
        },
        "interpolation_weights, ring": {
            "ours": lambda: healpix.interpolation_weights(nside, theta, phi),
            "healpy": lambda: healpy.get_interp_weights(nside, theta, phi),
        },
        "boundaries, nested": {
            "ours": lambda: healpix.boundaries(nside, pixels, nest=True),
            "healpy": lambda: healpy.boundaries(nside, pixels, nest=True),
        },
    }
    body = []
    for name, entrants in work.items():
        say(f"{name}, nside {nside}")
        seconds = race(entrants, args.rounds, patience=9)
        rate = {who: count / s / 1e6 for who, s in seconds.items()}
        best = max(rate["ours"], rate.get("out", 0.0))
        cells = [
            f"{rate[who]:,.0f}" if who in rate else "–" for who in ("out", "ours", "healpy", "cds")
        ]
        ratios = [f"{best / rate[who]:.1f}×" if who in rate else "–" for who in ("healpy", "cds")]
        reached = ""
        if name.startswith("vec2pix") and "cds" in rate:
            good = best >= TO_HEALPY * rate["healpy"] and best >= TO_CDS * rate["cds"]
            reached = "yes" if good else "**no**"
        body.append([f"{name}, nside {nside:,}", *cells, *ratios, reached])
    return body


def cpu_time(call: Call, rounds: int) -> float:
    """Return the least CPU time of some calls, of all threads together."""
    best = float("inf")
    for _ in range(rounds):
        start = time.process_time()
        result = call()
        best = min(best, time.process_time() - start)
        del result
    return best


def peak(call: Call) -> int:
    """Return by how many bytes a call raises the memory that the process holds at most."""
    status = Path("/proc/self/status")
    Path("/proc/self/clear_refs").write_text("5")

    def kib(name: str) -> int:
        return int(re.search(rf"{name}:\s*(\d+)", status.read_text())[1])

    before = kib("VmRSS")
    result = call()
    most = kib("VmHWM")
    del result
    return 1024 * (most - before)


def maps(args: argparse.Namespace, nside: int) -> str:
    ring = np.random.default_rng(0).standard_normal(12 * nside**2, dtype=np.float32)
    nested, faces = healpix.reorder(ring, nest=False), healpix.to_image(ring)
    work: dict[str, Call] = {
        "a copy of the map": lambda: ring.copy(),
        "`to_image`, of nested order": lambda: healpix.to_image(nested, True),
        "`to_image`, of ring order": lambda: healpix.to_image(ring),
        "`from_image`, to nested order": lambda: healpix.from_image(faces, True),
        "`from_image`, to ring order": lambda: healpix.from_image(faces),
        "`reorder`, to nested order": lambda: healpix.reorder(ring, nest=False),
        "`reorder`, to ring order": lambda: healpix.reorder(nested, nest=True),
        "healpy's `reorder`, to nested order": lambda: healpy.reorder(ring, r2n=True),
    }
    body, yardstick = [], 0.0
    for name, call in work.items():
        say(f"{name}, nside {nside}")
        seconds = cpu_time(call, 2 if "healpy" in name else args.rounds)
        yardstick = yardstick or seconds
        body.append(
            [
                name,
                f"{seconds * 1e3:,.0f} ms",
                f"{yardstick / seconds:.2f}",
                f"{1 + peak(call) / ring.nbytes:.2f}",
            ]
        )
    return "\n\n".join(
        [
            MAPS,
            f"Whole maps: float32, nside {nside:,}. CPU time of {args.threads} threads, the "
            "least of some calls; how fast that is beside a copy; and the memory of the map and "
            "of all that the call takes, in sizes of the map.",
            table(["work", "CPU time", "of a copy's speed", "memory, of the map's"], body),
            MAPS_END,
        ]
    )


def write(section: str, begin: str, end: str, after: str | None = None) -> None:
    path = ROOT / "BENCHMARKS.md"
    old = path.read_text(encoding="utf-8")
    if begin in old and end in old:
        new = old.split(begin)[0] + section + old.split(end)[1]
    elif after is not None and after in old:
        new = old.replace(after, f"{after}\n\n{section}")
    else:
        new = old.rstrip("\n") + "\n\n" + section + "\n"
    path.write_text(new, encoding="utf-8")
    say(f"wrote a section of {path}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--maps", action="store_true", help="whole maps alone")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    sm.set_num_threads(args.threads)
    of_maps = maps(args, 64 if args.quick else 1024)
    print(of_maps)
    if not args.quick:
        write(of_maps, MAPS, MAPS_END, after=END)
    if args.maps:
        return
    count = 20_000 if args.quick else 4_000_000
    body = [row for nside in (64, 1 << 20) for row in rows(nside, count, args)]
    head = ["work", "ours, `out=`", "ours", "healpy", "cdshealpix", "to healpy", "to cdshealpix"]
    text = [
        BEGIN,
        "## HEALPix",
        f"Millions a second, {args.threads} threads, {count:,} float64 directions or int64 pixels "
        f"a call; healpy {healpy.__version__} has one thread, cdshealpix {cdshealpix.__version__} "
        f"{args.threads}. The ratios are of our faster number; the targets for `vec2pix` are "
        f"{TO_HEALPY:g}× and {TO_CDS:g}×.",
        table([*head, "reached"], body),
        END,
    ]
    section = "\n\n".join(text)
    print(section)
    if args.quick:
        return
    write(section, BEGIN, END)


if __name__ == "__main__":
    main()
