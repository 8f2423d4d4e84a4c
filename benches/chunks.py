"""Time HEALPix to CAR and back in chunks against reproject; write their part of BENCHMARKS.md.

    python benches/chunks.py            # rewrites the section
    python benches/chunks.py --quick    # a smoke test: small maps, printed only

It needs `pip install reproject`, which the tests do not. Times are of CPU, of all threads together;
entrants of a row take turns, and the median of the rounds counts. Each is given the same function
at the centers of its own pixels, and its result is compared with the function at the centers of
those, or with its mean over them: so every entrant has its own conventions, and the same truth.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time
import warnings
from collections.abc import Callable
from importlib.metadata import version

import astropy_healpix
import dask
import dask.array as da
import numpy as np
import reproject
import spheremap as sm
import spheremap.dask as smd
from astropy import units as u
from astropy.wcs import WCS
from measure import machine, publish, say, table

BEGIN, END = "<!-- chunks: written by benches/chunks.py -->", "<!-- chunks: end -->"
# CAR has its pole at +z and centers of pixels, as this row.
HEALPIX, CAR = "healpix:healpy", "latlong:blender"
Call = Callable[[], np.ndarray]


def field(d: np.ndarray) -> np.ndarray:
    """Return a smooth function of directions, NaN where there are none."""
    x, y, z = np.moveaxis(d, -1, 0)
    return np.sin(5 * x) * np.cos(4 * y) + np.sin(6 * z) + 0.3 * np.cos(9 * x * z)


def of_degrees(lon: np.ndarray, lat: np.ndarray) -> np.ndarray:
    """Return the function at longitudes and latitudes in degrees."""
    a, b = np.radians(lon), np.radians(lat)
    return field(np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], -1))


def car(height: int) -> WCS:
    """Return the plate carrée of the whole sky."""
    wcs = WCS(naxis=2)
    wcs.wcs.ctype = ["GLON-CAR", "GLAT-CAR"]
    wcs.wcs.crval, wcs.wcs.cdelt = [0, 0], [-180 / height, 180 / height]
    wcs.wcs.crpix = [height + 0.5, height / 2 + 0.5]
    return wcs


def hpx(nside: int) -> WCS:
    """Return HEALPix as an image, whose facets are squares: 12 of 25."""
    wcs = WCS(naxis=2)
    wcs.wcs.ctype = ["GLON-HPX", "GLAT-HPX"]
    half = np.sqrt(0.5)
    wcs.wcs.crval, wcs.wcs.cdelt = [0, 0], [-90 * half / nside, 90 * half / nside]
    wcs.wcs.pc = [[half, half], [-half, half]]
    wcs.wcs.crpix = [2.5 * nside + 0.5] * 2
    return wcs


def at_pixels(wcs: WCS, shape: tuple[int, int], places: int = 1) -> np.ndarray:
    """Return the function at the centers of pixels, or its mean over them from so many places."""
    y, x = np.indices(shape, dtype=float)
    total, weight = np.zeros(shape), np.zeros(shape)
    for j in range(places):
        for i in range(places):
            dx, dy = (i + 0.5) / places - 0.5, (j + 0.5) / places - 0.5
            lon, lat = wcs.wcs_pix2world(x + dx, y + dy, 0)
            # Cells of CAR shrink to the pole, those of HEALPix are of one size.
            area = np.cos(np.radians(lat)) if "CAR" in wcs.wcs.ctype[0] else 1.0
            total += of_degrees(lon, lat) * area
            weight += area
    return total / weight


def means(p: str, size: int, places: int) -> np.ndarray:
    """Return the mean of the function over the texels of an image of ours."""
    fine = field(sm.directions(p, size * places)).astype(np.float64)
    area = sm.solid_angle(p, size * places)
    parts = [*fine.shape[:-2], size, places, fine.shape[-1] // places, places]
    area = np.broadcast_to(area, fine.shape)
    return (fine * area).reshape(parts).sum((-3, -1)) / area.reshape(parts).sum((-3, -1))


def rms(found: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean((np.asarray(found, np.float64) - truth) ** 2)))


def race(entrants: dict[str, Call], rounds: int) -> dict[str, tuple[float, np.ndarray]]:
    """Return each entrant's median time in seconds, and what it gave."""
    times: dict[str, list[float]] = {name: [] for name in entrants}
    given: dict[str, np.ndarray] = {}
    order = random.Random(0)
    for _ in range(rounds):
        for name, call in order.sample(list(entrants.items()), len(entrants)):
            start = time.process_time()
            given[name] = call()
            times[name].append(time.process_time() - start)
    return {name: (statistics.median(each), given[name]) for name, each in times.items()}


def rows(how: str, nside: int, chunk: int, rounds: int) -> list[list[str]]:
    height = 2 * nside
    shapes = {"CAR": (height, 2 * height), "HPX": (5 * nside, 5 * nside)}
    maps = {"CAR": car(height), "HPX": hpx(nside)}
    theirs = {name: at_pixels(maps[name], shapes[name]) for name in maps}
    chunks = {name: da.from_array(image, chunks=chunk) for name, image in theirs.items()}
    d = {name: sm.directions(name, n) for name, n in ((HEALPIX, nside), (CAR, height))}
    ours = {name: field(each) for name, each in d.items()}
    in_chunks = {name: da.from_array(image, chunks=chunk) for name, image in ours.items()}
    sky = astropy_healpix.HEALPix(nside, order="nested")
    lon, lat = (angle.to_value(u.deg) for angle in sky.healpix_to_lonlat(np.arange(12 * nside**2)))
    pixels = of_degrees(lon, lat)
    body = []
    for work, src, dst, size in (
        ("HEALPix → CAR", HEALPIX, CAR, height),
        ("CAR → HEALPix", CAR, HEALPIX, nside),
    ):
        a, b = ("HPX", "CAR") if src == HEALPIX else ("CAR", "HPX")
        count = 12 * nside**2 if dst == HEALPIX else 2 * height**2
        say(f"{work}, {how}")

        def mine(how: str = how, src: str = src, dst: str = dst, size: int = size) -> np.ndarray:
            options = {"filter": "area"} if how == "exact" else {"antialias": False}
            options["world"] = "literal"
            found = smd.convert(in_chunks[src], src, dst, size=size, chunks=chunk, **options)
            return found.compute()

        def other(how: str = how, a: str = a, b: str = b) -> np.ndarray:
            call = reproject.reproject_exact if how == "exact" else reproject.reproject_interp
            options = {} if how == "exact" else {"roundtrip_coords": False}
            # Its other way ends where a chunk sees nothing of the input.
            options["dask_method"] = "memmap"
            found = call(
                (chunks[a], maps[a]), maps[b], shape_out=shapes[b], block_size=(chunk, chunk),
                return_type="dask", return_footprint=False, **options,
            )  # fmt: skip
            return found.compute()

        def plain(work: str = work) -> np.ndarray:
            if work == "HEALPix → CAR":
                call, given, target = reproject.reproject_from_healpix, pixels, maps["CAR"]
                options = {"shape_out": shapes["CAR"]}
                return call((given, "galactic"), target, nested=True, **options)[0]
            given = (theirs["CAR"], maps["CAR"])
            return reproject.reproject_to_healpix(given, "galactic", nside=nside, nested=True)[0]

        entrants: dict[str, Call] = {"ours": mine, "chunks": other}
        truth = {"ours": ours[dst], "chunks": theirs[b]}
        if how == "bilinear":
            entrants["arrays"] = plain
            truth["arrays"] = theirs["CAR"] if dst == CAR else pixels
        else:
            truth = {"ours": means(dst, size, 4), "chunks": at_pixels(maps[b], shapes[b], 4)}
        found = race(entrants, rounds)
        s = {name: seconds for name, (seconds, _) in found.items()}
        errors = {name: rms(given, truth[name]) for name, (_, given) in found.items()}
        for name in entrants:
            if name == "ours":
                continue
            called = "in chunks" if name == "chunks" else "arrays"
            body.append(
                [
                    f"{work}, {how}, nside {nside}",
                    f"`{'reproject_exact' if how == 'exact' else 'reproject_interp'}`, {called}"
                    if name == "chunks"
                    else "`reproject_from_healpix`"
                    if dst == CAR
                    else "`reproject_to_healpix`",
                    f"{s['ours'] / count * 1e9:.0f}",
                    f"{s[name] / count * 1e9:.0f}",
                    f"{s[name] / s['ours']:.1f}×",
                    f"{errors['ours']:.1e}",
                    f"{errors[name]:.1e}",
                ]
            )
            say(" | ".join(body[-1]))
    return body


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small maps")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--remark", default="", help="of the machine, as: others work on it")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    rounds = 1 if args.quick else args.rounds
    with dask.config.set(scheduler="threads"):
        body = rows("bilinear", *((32, 64) if args.quick else (1024, 512)), rounds)
        # Theirs take minutes.
        body += rows("exact", *((32, 64) if args.quick else (128, 128)), 1)
    remark = args.remark and f", {args.remark}"
    text = [
        BEGIN,
        "## Images in chunks",
        "Nanoseconds of CPU for each pixel of the sky, HEALPix of some nside and CAR of 4 nside × "
        f"2 nside in float64, dask chunks of 512² and 128²; medians of {rounds} rounds in turn, of "
        f"exact areas one; reproject {version('reproject')}, {machine()}{remark}. Errors are the "
        "root mean square from the function that was sampled, of size 1, or from its means. In "
        "chunks HEALPix is an image in the HPX projection for them, of whose 25 squares 12 hold "
        "anything, and what it sees beyond these is NaN, which no error counts; "
        "`reproject_from_healpix` and `reproject_to_healpix` take arrays alone.",
        table(["work", "theirs", "ns, ours", "ns, theirs", "ratio", "error, ours", "error, theirs"],
              body, left=2),
        END,
    ]  # fmt: skip
    publish(text, args.quick)


if __name__ == "__main__":
    main()
