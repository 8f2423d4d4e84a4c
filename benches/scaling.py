"""Measure what clusters take, and reckon what larger ones would; write a part of BENCHMARKS.md.

    python benches/scaling.py            # rewrites the section
    python benches/scaling.py --quick    # a smoke test with small images, printed only

Measured, on this machine: a cluster of `distributed` with one worker and with two, processes of a
thread each, which convert an archive of files and one image in chunks; the seconds of each task;
how much of the source a task sees, and how fast workers hand arrays to each other. Reckoned: these
tasks on more cores, by the model of docs/scaling.md.
"""

from __future__ import annotations

import argparse
import heapq
import random
import statistics
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import dask.array as da
import distributed
import numpy as np
import spheremap as sm
import spheremap.dask as smd
from measure import machine, publish, say, table
from spheremap import io
from spheremap.resample.seen import Rectangle, SourceTiles, tiles

BEGIN, END = "<!-- scaling: written by benches/scaling.py -->", "<!-- scaling: end -->"
# What a machine of the cluster is taken for, and what all of them share.
CORES, NETWORK, STORAGE = 16, 1.25e9, 20e9
# The scheduler hands out a task at a time.
DISPATCH = 1e-3
MACHINES = (1, 10, 100)
MANY = ("1 machine", "10 machines", "100 machines")


@dataclass(frozen=True)
class Work:
    """Tasks that are all alike: how many, seconds of each that were seen, bytes in and out."""

    name: str
    count: int
    seconds: list[float]
    moved: float


def light(height: int) -> np.ndarray:
    """Return half floats in blocks of 16, which compress as photographs do, with noise."""
    rng = np.random.default_rng(0)
    small = rng.random((height // 16, height // 8, 3)).astype(np.float32)
    image = small.repeat(16, 0).repeat(16, 1)
    return (image * rng.uniform(0.98, 1.02, image.shape)).astype(np.float16)


def convert_one(source: str, target: str, size: int) -> float:
    """Convert a file as `spheremap batch` does, and return the seconds that it took."""
    sm.set_num_threads(1)
    start = time.perf_counter()
    faces = sm.projection("cube", layout="strip")
    image = sm.convert(io.read(source), "latlong", faces, size=size)
    io.write(target, image)
    return time.perf_counter() - start


def archive(client: distributed.Client, folder: Path, sources: list[str], size: int) -> tuple:
    """Return the wall time of an archive, and the seconds of its tasks."""
    targets = [str(folder / f"out{k}.exr") for k in range(len(sources))]
    start = time.perf_counter()
    calls = client.map(convert_one, sources, targets, size=size, pure=False)
    seconds = client.gather(calls)
    return time.perf_counter() - start, seconds


def in_chunks(client: distributed.Client, height: int, chunk: int) -> float:
    """Return the wall time of one image in chunks, of which nothing but sums comes back."""
    shape = (height, 2 * height, 3)
    image = da.random.default_rng(0).integers(0, 255, shape, np.uint8, chunks=(chunk, chunk, 3))
    image = client.persist(image)
    distributed.wait(image)
    start = time.perf_counter()
    smd.convert(image, "latlong", "cube", size=height // 2, chunks=chunk).sum().compute()
    return time.perf_counter() - start


def chunk_seconds(height: int, chunk: int) -> list[float]:
    """Return the seconds of each of a few chunks of a result, by one thread."""
    threads = sm.get_num_threads()
    sm.set_num_threads(1)
    image = np.random.default_rng(0).integers(0, 255, (height, 2 * height, 3), np.uint8)
    found = []
    for face in range(6):
        window = (slice(0, chunk), slice(0, chunk), face)
        start = time.perf_counter()
        sm.convert(image, "latlong", "cube", size=height // 2, window=window)
        found.append(time.perf_counter() - start)
    sm.set_num_threads(threads)
    return found


def seen(height: int, chunk: int, count: int) -> float:
    """Return how many chunks of a latlong a chunk of a cube of half its height sees, on average."""
    parts = tiles((height, 2 * height), (chunk, chunk))
    source = SourceTiles(sm.projection("latlong"), (height, 2 * height), parts)
    side, rng = height // 2, random.Random(0)
    windows = []
    for _ in range(count):
        top, left = (rng.randrange(side // chunk) * chunk for _ in "yx")
        windows.append(Rectangle(top, top + chunk, left, left + chunk, rng.randrange(6)))
    found = source.seen_by_each(sm.projection("cube"), (6, side, side), windows)
    return statistics.mean(map(len, found))


def handed(client: distributed.Client) -> float:
    """Return the bytes a second that one worker hands to another."""
    first, second = client.scheduler_info()["workers"]
    held = client.submit(np.ones, 1 << 24, workers=[first], pure=False)
    distributed.wait(held)
    start = time.perf_counter()
    client.submit(len, held, workers=[second], pure=False).result()
    return (8 << 24) / (time.perf_counter() - start)


def reckoned(work: Work, machines: int) -> float:
    """Return the seconds of a work on so many machines, each task on the first free core."""
    rng = random.Random(0)
    # What others hold comes over the network, of which cores have a share each.
    share = NETWORK / CORES
    free = [0.0] * (machines * CORES)
    for k in range(work.count):
        start = max(heapq.heappop(free), k * DISPATCH)
        heapq.heappush(free, start + rng.choice(work.seconds) + work.moved / share)
    return max(max(free), work.count * work.moved / STORAGE)


def hours(seconds: float) -> str:
    return f"{seconds / 3600:.1f} h" if seconds >= 3600 else f"{seconds / 60:.1f} min"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small images")
    parser.add_argument("--remark", default="", help="of the machine, as: others at work on it")
    args = parser.parse_args()
    height, files, chunk = (128, 4, 64) if args.quick else (2048, 12, 512)
    image = light(height)
    walls: dict[str, list[float]] = {"archive": [], "chunks": []}
    seconds: list[float] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sources = [str(folder / f"in{k}.exr") for k in range(files)]
        for source in sources:
            io.write(source, image)
        size = Path(sources[0]).stat().st_size
        for count in (1, 2):
            say(f"{count} workers")
            with (
                distributed.LocalCluster(
                    n_workers=count, threads_per_worker=1, dashboard_address=None
                ) as cluster,
                distributed.Client(cluster) as client,
            ):
                client.run(sm.set_num_threads, 1)
                archive(client, folder, sources[:count], height // 4)
                wall, each = archive(client, folder, sources, height // 4)
                seconds = each if count == 1 else seconds
                walls["archive"].append(wall)
                in_chunks(client, 4 * chunk, chunk)
                walls["chunks"].append(in_chunks(client, 2 * height, chunk))
                rate = handed(client) if count == 2 else 0.0
        made = (folder / "out0.exr").stat().st_size
    # Of 8192×4096, by texels; and a sky of 2⁴⁰ texels, 1 482 910 × 741 455, in chunks of 8192².
    factor = (4096 / height) ** 2
    sky, large = (64 * chunk, chunk) if args.quick else (90 * 8192, 8192)
    part = chunk_seconds(height, chunk)
    texels = (sky // 2) ** 2 * 6
    tasks = -(-texels // large**2)
    sees = seen(sky, large, 20 if args.quick else 200)
    works = [
        Work("10 000 HDRIs of 8192×4096", 10_000, [s * factor for s in seconds],
             (size + made) * factor),
        Work(f"one sky of {2 * sky**2 / 1e12:.2f}·10¹² texels", tasks,
             [s * (large / chunk) ** 2 for s in part], (sees * 3 + 3) * large**2),
    ]  # fmt: skip
    body = []
    for work in works:
        times = [reckoned(work, n) for n in MACHINES]
        body.append(
            [
                work.name,
                f"{work.count:,}",
                f"{statistics.mean(work.seconds):.1f} s",
                f"{work.moved / 1e6:,.0f} MB",
                *(hours(t) for t in times),
                f"{times[0] / times[-1] / MACHINES[-1]:.0%}",
            ]
        )
    ratios = [
        [name, *(f"{t:.1f} s" for t in both), f"{both[0] / both[1]:.2f}×"]
        for name, both in zip(
            (f"{files} files of {2 * height}×{height} to cubes",
             f"one image of {4 * height}×{2 * height} to a cube, in chunks of {chunk}²"),
            walls.values(), strict=True,
        )
    ]  # fmt: skip
    remark = args.remark and f", {args.remark}"
    text = [
        BEGIN,
        "## Scaling",
        f"Measured: workers of `distributed`, processes of one thread; {machine()}{remark}. They "
        f"hand {rate / 1e6:.0f} MB a second to each other.",
        table(["work", "1 worker", "2 workers", "ratio"], ratios),
        "Reckoned from the seconds of these tasks by the model of [scaling](docs/scaling.md): "
        f"machines of {CORES} cores of this kind and {NETWORK * 8 / 1e9:.0f} Gbit/s, which share a "
        f"storage of {STORAGE / 1e9:.0f} GB/s. A chunk of the sky sees {sees:.1f} chunks of its "
        "source. Efficiency is that of 100 machines to one.",
        table(["work", "tasks", "a task", "moved by it", *MANY, "efficiency"], body),
        END,
    ]  # fmt: skip
    publish(text, args.quick)


if __name__ == "__main__":
    main()
