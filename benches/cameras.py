"""Time cameras against OpenCV, stitching against conversions; write their part of BENCHMARKS.md.

    python benches/cameras.py            # rewrites the section
    python benches/cameras.py --quick    # a smoke test: small arrays, printed only

Entrants of a row take turns; a time is the median of the CPU time of all threads together, since
OpenCV has one thread for points and several for pictures. `cv2.remap` is given its grids as scripts
that cut panoramas for COLMAP make them, in NumPy; that time is in the one and not in the other.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import time
from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
import spheremap as sm
from measure import machine, publish, say, table

BEGIN, END = "<!-- cameras: written by benches/cameras.py -->", "<!-- cameras: end -->"
Call = Callable[[], object]

K = np.array([[900.0, 0, 655.3], [0, 910, 349.2], [0, 0, 1]])
BROWN = np.array([-0.28, 0.07, 0.0002, 0.0001, 0.0])
FISHEYE = np.array([0.02, -0.004, 0.001, -0.0002])
SIZE = (720, 1280)


def race(entrants: dict[str, Call], rounds: int) -> dict[str, tuple[float, float]]:
    """Return each entrant's median CPU time in seconds, and the kernel's part of it."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in entrants}
    for call in entrants.values():
        call()
    order = random.Random(0)
    for _ in range(rounds):
        for name, call in order.sample(list(entrants.items()), len(entrants)):
            start, before = time.process_time(), os.times().system
            result = call()
            times[name].append((time.process_time() - start, os.times().system - before))
            del result
    return {
        name: (statistics.median(t for t, _ in each), statistics.median(k for _, k in each))
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
        races: dict[str, dict[str, Call]] = {
            "encode": {
                "ours": partial(camera.encode, d),
                "f32": partial(camera.encode, single),
                "cv2": partial(project, shaped, zero, zero, K, coefficients),
            },
            "decode": {
                "ours": partial(camera.decode, uv),
                "f32": partial(camera.decode, uv32),
                "cv2": partial(undistort, pixels, K, coefficients),
            },
        }
        for work, entrants in races.items():
            s = race(entrants, args.rounds)
            body.append(
                [
                    f"`{model}`, {work}",
                    *(f"{s[who][0] / count * 1e9:.0f}" for who in ("ours", "f32", "cv2")),
                    f"{s['cv2'][0] / s['ours'][0]:.1f}×",
                ]
            )
    return body


def grids(view: sm.cameras.View, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return where a view's pixels lie in a latlong, as panorama scripts for COLMAP do it."""
    height, width = view.size
    fx = view.camera.parameters["fx"] * width
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = np.stack([x - width / 2, y - height / 2, np.full_like(x, fx)], -1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    rays = rays @ view.pose.T
    yaw = np.arctan2(rays[..., 0], rays[..., 2])
    pitch = -np.arctan2(rays[..., 1], np.linalg.norm(rays[..., [0, 2]], axis=-1))
    u = (1 + yaw / np.pi) / 2 * shape[1] - 0.5
    v = (1 - pitch * 2 / np.pi) / 2 * shape[0] - 0.5
    return u.astype(np.float32), v.astype(np.float32)


def cutting(args: argparse.Namespace) -> list[list[str]]:
    side, height = (100, 256) if args.quick else (1600, 4096)
    rig = sm.cameras.rig(side, n=12)
    image = checkered((height, 2 * height))
    ready = [grids(view, image.shape[:2]) for view in rig]

    def theirs(maps: list[tuple[np.ndarray, np.ndarray]]) -> list[np.ndarray]:
        return [cv2.remap(image, *m, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP) for m in maps]

    entrants: dict[str, Call] = {
        "`rig.convert`": lambda: rig.convert(image, "latlong"),
        "as many `convert`": lambda: [
            sm.convert(image, "latlong", view.projection, size=view.size) for view in rig
        ],
        "`rig.convert`, `antialias=False`": lambda: rig.convert(image, "latlong", antialias=False),
        "`cv2.remap`, grids ready": lambda: theirs(ready),
        "`cv2.remap`, its grids in NumPy": lambda: theirs(
            [grids(view, image.shape[:2]) for view in rig]
        ),
    }
    say(f"{len(rig)} views of {side}²")
    s = race(entrants, max(3, args.rounds // 2))
    first = s["`rig.convert`"][0]
    return [
        [
            f"{len(rig)} views of {side}² from {2 * height}×{height}",
            name,
            ms(t),
            ms(kernel),
            f"{t / first:.2f}",
        ]
        for name, (t, kernel) in s.items()
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
            '`exposure="match"`': stitched(exposure="match"),
        },
        max(3, args.rounds // 2),
    )
    first = s["three `convert`"][0]
    return [
        [
            f"two fisheyes of {side}² to {2 * side}×{side}",
            name,
            ms(t),
            ms(kernel),
            f"{t / first:.2f}",
        ]
        for name, (t, kernel) in s.items()
    ]


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
        "`undistortPoints`, or those of `cv2.fisheye`; the ratio is of float64.",
        table(["work", "ours", "ours, float32", "cv2", "ours is faster by"], points(args)),
        "Pictures are RGB, uint8; the ratio is to the first row of each. The kernel's part is "
        "new memory: `stitch` makes two images of the result's size in float.",
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
