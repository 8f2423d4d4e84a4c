"""Time a HiPS of FITS tiles against reproject_to_hips; write its part of BENCHMARKS.md.

    python benches/hips.py            # rewrites the section
    python benches/hips.py --quick    # a smoke test: small tiles, printed only

It needs `pip install reproject`, which the tests do not. Times are of CPU, of all threads and
processes together, and files are not brought to the disk.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
import spheremap as sm
from astropy.wcs import WCS
from measure import machine, publish, say, table
from reproject import reproject_interp
from reproject.hips import reproject_to_hips

BEGIN, END = "<!-- hips: written by benches/hips.py -->", "<!-- hips: end -->"
SKY = "latlong:healpy"


def plate_carree(height: int) -> WCS:
    """Return the same sky for them: longitude grows to the left, and row 0 is at the south."""
    wcs = WCS(naxis=2)
    wcs.wcs.ctype = ["RA---CAR", "DEC--CAR"]
    wcs.wcs.cdelt = [-180 / height, 180 / height]
    wcs.wcs.crpix = [height + 0.5, height / 2 + 0.5]
    return wcs


def seconds(call: Callable[[], object]) -> float:
    def used() -> float:
        times = os.times()
        return times.user + times.system + times.children_user + times.children_system

    start = used()
    call()
    return used() - start


def row(height: int, order: int, width: int, folder: Path) -> list[str]:
    image = sm.directions(SKY, height)[..., 2].astype(np.float32)
    options = {"format": "hips", "extension": "fits", "tile_size": width, "page": False}
    ours = seconds(
        lambda: sm.tiles.write(image, SKY, folder / "ours", size=width << order, **options)
    )
    given = np.ascontiguousarray(image[::-1], np.float64), plate_carree(height)
    theirs = seconds(
        lambda: reproject_to_hips(
            given,
            coord_system_out="equatorial",
            reproject_function=reproject_interp,
            output_directory=str(folder / "theirs"),
            level=order,
            tile_size=width,
        )
    )
    count = 12 * 4**order * width**2 / 1e6
    say(f"order {order}: {ours:.1f} s, theirs {theirs:.1f} s")
    return [
        f"{2 * height}×{height}, tiles of {width}² to order {order}",
        f"{count / ours:.1f}",
        f"{count / theirs:.1f}",
        f"{theirs / ours:.1f}×",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small tiles")
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    # Hundreds of files on a disk that others use say nothing of either.
    os.fsync = lambda handle: None  # type: ignore[assignment]
    body = []
    for order in (1,) if args.quick else (1, 2):
        with tempfile.TemporaryDirectory() as folder:
            body.append(row(*((64, 1, 32) if args.quick else (2048, order, 512)), Path(folder)))
    remark = args.remark and f", {args.remark}"
    text = [
        BEGIN,
        "## HiPS",
        "Mtexel of the largest order for each second of CPU, from a latlong of one channel to FITS "
        "of all orders, bilinear; ours of float32, antialiased, with its coverage, theirs of "
        f"float64; one round; reproject {version('reproject')}, {machine()}{remark}.",
        table(["work", "ours", "`reproject_to_hips`", "ratio"], body),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
