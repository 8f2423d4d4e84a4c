"""Time cameras against OpenCV, stitching against conversions; write their part of BENCHMARKS.md.

    python benches/cameras.py            # rewrites the section
    python benches/cameras.py --quick    # a smoke test: small arrays, printed only

Entrants of a row take turns; a time is the median of the CPU time of all threads together, since
OpenCV has one thread for points and several for pictures; for points what a clock says is told as
well. What COLMAP's example panorama_sfm.py does for a panorama is written here once more, without
its files: the grids of each view in NumPy, `cv2.remap`, and in NumPy the mask of what is nearest.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
import spheremap as sm
from measure import machine, publish, say, table

BEGIN, END = "<!-- cameras: written by benches/cameras.py -->", "<!-- cameras: end -->"
Call = Callable[[], object]

K = np.array([[900.0, 0, 655.3], [0, 910, 349.2], [0, 0, 1]])
BROWN = np.array([-0.28, 0.07, 0.0002, 0.0001, 0.0])
FISHEYE = np.array([0.02, -0.004, 0.001, -0.0002])
PRISM = (0.02, -0.01, 2e-3, -3e-3, 0.003, -0.0005, 5e-3, -2e-3)
ARIA = (0.02, -0.01, 0.003, -5e-4, 1e-4, -1e-5, 2e-3, -3e-3, 5e-3, -2e-3, 1e-3, -1e-3)
SIZE = (720, 1280)


class Times(NamedTuple):
    """Medians in seconds: of CPU time, of the kernel's part of it, and of what a clock says."""

    cpu: float
    kernel: float
    elapsed: float


def race(entrants: dict[str, Call], rounds: int) -> dict[str, Times]:
    """Return each entrant's median times."""
    times: dict[str, list[tuple[float, float, float]]] = {name: [] for name in entrants}
    for call in entrants.values():
        call()
    order = random.Random(0)
    for _ in range(rounds):
        for name, call in order.sample(list(entrants.items()), len(entrants)):
            clock, start, before = time.perf_counter(), time.process_time(), os.times().system
            result = call()
            cpu, kernel = time.process_time() - start, os.times().system - before
            times[name].append((cpu, kernel, time.perf_counter() - clock))
            del result
    return {
        name: Times(*map(statistics.median, zip(*each, strict=True)))
        for name, each in times.items()
    }


def points(args: argparse.Namespace) -> list[list[str]]:
    count = 20_000 if args.quick else 1_000_000
    rng = np.random.default_rng(0)
    xy = rng.uniform(0.5, 1, (count, 2)) * [[SIZE[1] - 1, SIZE[0] - 1]]
    zero = np.zeros(3)
    body = []
    for model, coefficients in (("brown_conrady", BROWN), ("kannala_brandt", FISHEYE)):
        camera = sm.camera(K, SIZE, distortion=coefficients, model=model)  # type: ignore[arg-type]
        # What is seen, so that both have an answer everywhere.
        d = sm.pixels_to_directions(xy, camera, SIZE, centers="integer")
        uv = camera.encode(d)
        single, uv32 = d.astype(np.float32), uv.astype(np.float32)
        shaped, pixels = d.reshape(-1, 1, 3), xy.reshape(-1, 1, 2)
        theirs = cv2 if model == "brown_conrady" else cv2.fisheye
        project, undistort = theirs.projectPoints, theirs.undistortPoints
        say(f"{model}, {count} points")
        ours, f32 = partial(camera.decode, uv), partial(camera.decode, uv32)
        races: dict[str, dict[str, Call]] = {
            "encode": {
                "ours": partial(camera.encode, d),
                "f32": partial(camera.encode, single),
                "cv2": partial(project, shaped, zero, zero, K, coefficients),
            },
            "decode": {
                "ours": ours,
                "f32": f32,
                "cv2": partial(undistort, pixels, K, coefficients),
            },
        }
        if model == "brown_conrady":
            until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 400, 1e-12)
            exact = partial(undistort, pixels, K, coefficients, None, None, None, until)
            races["decode, cv2 until 1e-12"] = {"ours": ours, "f32": f32, "cv2": exact}
        for work, entrants in races.items():
            s = race(entrants, args.rounds)
            body.append(
                [
                    f"`{model}`, {work}",
                    *(f"{s[who].cpu / count * 1e9:.1f}" for who in ("ours", "f32", "cv2")),
                    f"{s['cv2'].cpu / s['ours'].cpu:.1f}×",
                    f"{s['cv2'].elapsed / s['ours'].elapsed:.1f}×",
                ]
            )
    return body


def leftover(args: argparse.Namespace) -> float:
    """Return how many pixels off OpenCV's inverse is, as it comes, in the same places."""
    rng = np.random.default_rng(0)
    xy = rng.uniform(0.5, 1, (10_000, 1, 2)) * [SIZE[1] - 1, SIZE[0] - 1]
    plane = cv2.undistortPoints(xy, K, BROWN)[:, 0]
    rays = np.column_stack([plane, np.ones(len(plane))])
    there, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, BROWN)
    return float(np.hypot(*(there - xy)[:, 0].T).max())


def rates(args: argparse.Namespace) -> list[list[str]]:
    """Conversions to and from each model, beside those of `perspective`."""
    height, width = (96, 128) if args.quick else (1536, 2048)
    rows = 128 if args.quick else 2048
    panorama, picture = checkered((rows, 2 * rows)), checkered((height, width))
    pixels = (width / 2, width / 2, width / 2 - 0.5, height / 2 - 0.5)

    def model(name: str, *distortion: float) -> sm.Projection:
        return sm.camera(pixels, (height, width), distortion=distortion, model=name)  # type: ignore[arg-type]

    cameras = {
        "perspective": sm.projection("perspective", fov=90, aspect=4 / 3),
        "pinhole": model("pinhole"),
        "brown_conrady": model("brown_conrady", *BROWN),
        "kannala_brandt": model("kannala_brandt", *FISHEYE),
        "unified": model("unified", 0.9, -0.1, 0.02, 1e-3, 1e-3),
        "double_sphere": model("double_sphere", -0.2, 0.6),
        "eucm": model("eucm", 0.6, 1.1),
        "fov": model("fov", 0.9),
        "thin_prism_fisheye": model("thin_prism_fisheye", *PRISM),
        "rad_tan_thin_prism_fisheye": model("rad_tan_thin_prism_fisheye", *ARIA),
    }
    say("conversions to and from cameras")

    def to(camera: sm.Projection) -> Call:
        return lambda: sm.convert(
            panorama, "latlong", camera, size=(height, width), antialias=False
        )

    def back(camera: sm.Projection) -> Call:
        return lambda: sm.convert(picture, camera, "latlong", size=rows // 2, antialias=False)

    ways = [race({name: way(c) for name, c in cameras.items()}, args.rounds) for way in (to, back)]
    counts = (height * width, rows * rows // 2)
    return [
        [
            f"`{name}`",
            *(
                text
                for times, count in zip(ways, counts, strict=True)
                for text in (
                    f"{times[name].cpu / count * 1e9:.1f}",
                    f"{times[name].cpu / times['perspective'].cpu:.2f}",
                )
            ),
        ]
        for name in cameras
    ]


def rays(view: sm.cameras.View) -> np.ndarray:
    """Return what the pixels of a view see in its own frame."""
    height, width = view.size
    fx = view.camera.parameters["fx"] * width
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    found = np.stack([x - width / 2, y - height / 2, np.full_like(x, fx)], -1)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def grids(there: np.ndarray, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return where directions lie in a latlong, as panorama scripts for COLMAP do it."""
    yaw = np.arctan2(there[..., 0], there[..., 2])
    pitch = -np.arctan2(there[..., 1], np.linalg.norm(there[..., [0, 2]], axis=-1))
    u = (1 + yaw / np.pi) / 2 * shape[1] - 0.5
    v = (1 - pitch * 2 / np.pi) / 2 * shape[0] - 0.5
    return u.astype(np.float32), v.astype(np.float32)


def cutting(args: argparse.Namespace) -> list[list[str]]:
    side, height = (100, 256) if args.quick else (1600, 4096)
    rig = sm.cameras.rig(side, n=12)
    image = checkered((height, 2 * height))
    shape = image.shape[:2]
    axes = np.stack([view.pose[:, 2] for view in rig])
    ready = [grids(rays(view) @ view.pose.T, shape) for view in rig]

    def remap(maps: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        return cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)

    def script(with_masks: bool) -> list[object]:
        seen, found = rays(rig[0]), []
        for k, view in enumerate(rig):
            there = seen @ view.pose.T
            picture = remap(grids(there, shape))
            mask = (there @ axes.T).argmax(-1) == k if with_masks else None
            found.append((picture, mask))
        return found

    entrants: dict[str, Call] = {
        "`rig.convert`": lambda: rig.convert(image, "latlong"),
        "as many `convert`": lambda: [
            sm.convert(image, "latlong", view.projection, size=view.size) for view in rig
        ],
        "`rig.convert`, `antialias=False`": lambda: rig.convert(image, "latlong", antialias=False),
        "`cameras.masks`": lambda: sm.cameras.masks(rig),
        "`cv2.remap`, grids ready": lambda: [remap(maps) for maps in ready],
        "COLMAP's script, without masks": lambda: script(False),
        "COLMAP's script": lambda: script(True),
    }
    say(f"{len(rig)} views of {side}²")
    return rows_of(
        f"{len(rig)} views of {side}² from {2 * height}×{height}",
        race(entrants, max(3, args.rounds // 2)),
    )


def rows_of(work: str, times: dict[str, Times]) -> list[list[str]]:
    first = next(iter(times.values())).cpu
    return [
        [work, name, ms(t.cpu), ms(t.kernel), f"{t.cpu / first:.2f}"] for name, t in times.items()
    ]


def checkered(shape: tuple[int, int]) -> np.ndarray:
    """Return RGB noise in blocks of 16, as smooth as a photograph is for a cache."""
    rng = np.random.default_rng(0)
    small = rng.integers(0, 256, (shape[0] // 16, shape[1] // 16, 3), np.uint8)
    return np.repeat(np.repeat(small, 16, 0), 16, 1)


def stitching(args: argparse.Namespace) -> list[list[str]]:
    side = 256 if args.quick else 2880
    cameras = sm.cameras.back_to_back("angular(fov=200)")
    pictures = [checkered((side, side)) for _ in cameras]

    def three() -> object:
        return [sm.convert(pictures[k], cameras[k], "latlong", size=side) for k in (0, 1, 0)]

    def stitched(**options: object) -> Call:
        return lambda: sm.cameras.stitch(pictures, cameras, "latlong", size=side, **options)

    say(f"two fisheyes of {side}²")
    s = race(
        {
            "three `convert`": three,
            "`stitch`": stitched(),
            '`blend="nearest"`': stitched(blend="nearest"),
            '`blend="bands"`': stitched(blend="bands"),
            '`exposure="match"`': stitched(exposure="match"),
        },
        max(3, args.rounds // 2),
    )
    return rows_of(f"two fisheyes of {side}² to {2 * side}×{side}", s)


def ms(seconds: float) -> str:
    return f"{seconds * 1e3:,.0f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small arrays")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    sm.set_num_threads(args.threads)
    cv2.setNumThreads(args.threads)
    text = [
        BEGIN,
        "## Cameras",
        f"CPU time of all of {args.threads} threads, medians of {args.rounds} rounds in turn; "
        f"{machine()}; OpenCV {cv2.__version__}. Nanoseconds a point, a million of them in the "
        "lower right quarter of the picture. `encode` is OpenCV's `projectPoints`, `decode` "
        "`undistortPoints`, or those of `cv2.fisheye`; ratios are of float64, of CPU time and of "
        "what a clock says: OpenCV has one thread for points. As it comes, its `undistortPoints` "
        f"is up to {leftover(args):.1g} pixels off here, ours less than 1e-9.",
        table(
            ["work", "ours", "ours, float32", "cv2", "ours is faster by", "by the clock"],
            points(args),
        ),
        "Conversions by plain lookups, RGB, uint8: nanoseconds of CPU a texel, and the ratio to "
        "`perspective`.",
        table(["camera", "latlong to it", "ratio", "it to latlong", "ratio"], rates(args)),
        "Pictures are RGB, uint8; the ratio is to the first row of each. The kernel's part is "
        "new memory. COLMAP's script is what its example panorama_sfm.py does for a panorama, "
        "without its files: it looks up, and does not antialias.",
        table(
            ["work", "how", "ms", "of it the kernel's", "ratio"],
            [*cutting(args), *stitching(args)],
            2,
        ),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
