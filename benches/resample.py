"""Time and judge conversions against other programs; rewrite their section of BENCHMARKS.md.

    python benches/resample.py             # times and quality
    python benches/resample.py --only times
    python benches/resample.py --quick     # a smoke test: small images, printed only
    python benches/resample.py --figures   # the pictures of docs/resampling.md instead

Times: all entrants of a row take turns, and what counts is the ratio of their medians. `cv2.remap`
is given its coordinates ready made, in memory; the time to make them in numpy stands beside it.
Quality: images are made from a finer original, or from a formula, so that there is a truth: the
mean of 64 places in each texel of the target. A program that is not installed has no numbers.
"""

from __future__ import annotations

import argparse
import inspect
import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import spheremap as sm
from measure import ROOT, machine, race, say, table
from resample_peers import Ffmpeg, cv2, cv2_remap, numpy_maps, py360convert, skylibs
from resample_peers import versions as peer_versions

BEGIN = "<!-- resampling: written by benches/resample.py -->"
END = "<!-- end of resampling -->"
DATA = Path(os.environ.get("SPHEREMAP_DATA") or ROOT.parent / "shared" / "data")
Call = Callable[[], object]
CONVERT_OPTIONS = inspect.signature(sm.convert).parameters
# What convert does where it is only asked to interpolate, as the others do.
PLAIN = {"antialias": False} if "antialias" in CONVERT_OPTIONS else {}


def filters(*wanted: str) -> list[str]:
    """Return those of the filters that this version has."""
    return [name for name in wanted if has_filter(name)]


def has_filter(name: str) -> bool:
    tiny = np.zeros((2, 4, 1), np.float32)
    try:
        sm.convert(tiny, "latlong", "latlong", size=2, filter=name, **PLAIN)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True


# --- times

# The speed that issue is held to: ours, coordinates included, to cv2.remap's without its maps.
TARGETS = {"nearest": 0.8, "bilinear": 0.8, "bicubic": 0.8, "u8 bilinear": 0.9}
PAIRS = (
    ("latlong 4096×2048 → cube 6×1024²", "latlong", (2048, 4096), "cube", (6, 1024, 1024)),
    ("cube 6×1024² → latlong 2048×1024", "cube", (6, 1024, 1024), "latlong", (1024, 2048)),
    ("latlong 4096×2048 → angular 1024²", "latlong", (2048, 4096), "angular", (1024, 1024)),
)


# Targets of a latlong that is two to sixteen times finer.
FINER = (4096, 8192)
COARSER = (
    ("cube", (6, 1024, 1024)),
    ("cube", (6, 512, 512)),
    ("angular", (1024, 1024)),
    ("angular", (512, 512)),
    ("octahedral", (512, 512)),
    ("latlong", (2048, 4096)),
    ("latlong", (1024, 2048)),
    ("latlong", (256, 512)),
)


def small(shape: tuple[int, ...], quick: bool) -> tuple[int, ...]:
    return tuple(n if n == 6 else n // 8 for n in shape) if quick else shape


def bench_times(args: argparse.Namespace) -> list[str]:
    rng = np.random.default_rng(0)
    rows = []
    for title, src, source_shape, dst, shape in PAIRS:
        if args.match not in title:
            continue
        source_shape, shape = small(source_shape, args.quick), small(shape, args.quick)
        floats = rng.random((*source_shape, 3), np.float32)
        kinds = {"": floats, "u8 ": (floats * 255).astype(np.uint8)}
        started = time.perf_counter()
        maps = numpy_maps(src, dst, source_shape, shape)
        making = time.perf_counter() - started
        for prefix, image in kinds.items():
            out = np.empty((*shape, 3), image.dtype)
            names = ["bilinear"] if prefix else ["nearest", "bilinear", "bicubic"]
            for name in filters(*names):
                say(f"{title} {prefix}{name}")
                entrants: dict[str, Call] = {"ours": converts(image, src, dst, shape, name, out)}
                if name == "bilinear" and PLAIN:
                    entrants["antialiased"] = converts(image, src, dst, shape, name, out, plain={})
                if name == "bilinear" and not prefix and has_filter("area"):
                    entrants["area"] = converts(image, src, dst, shape, "area", out, plain={})
                if cv2 is not None:
                    entrants["cv2"] = cv2_remap(image, maps, shape, name, args.threads)
                if py360convert is not None:
                    call = py360convert(image, src, dst, shape, name)
                    if call is not None and name != "bicubic":
                        entrants["py360convert"] = call
                if skylibs is not None and not prefix and name == "bilinear":
                    call = skylibs(image, src, dst, shape)
                    if call is not None:
                        entrants["skylibs"] = call
                seconds = race(entrants, args.rounds, patience=0.5)
                if prefix and name == "bilinear":
                    with Ffmpeg(image, src, dst, shape, args.threads) as program:
                        if program.path is not None:
                            seconds["ffmpeg"] = program.seconds()
                rows.append((title, prefix + name, seconds, making))
    head = ["work", "filter", "ours, ms", "cv2.remap", "its maps in numpy", "ours to cv2.remap"]
    head += [
        "target",
        "reached",
        "ours, antialiased",
        "area",
        "py360convert",
        "ffmpeg v360",
        "skylibs",
    ]
    body = []
    for title, name, s, making in rows:
        goal = TARGETS[name]
        ratio = s["ours"] / s["cv2"] if "cv2" in s else None
        cells = [title, name, ms(s["ours"]), ms(s.get("cv2")), ms(making)]
        cells += [f"{ratio:.2f}" if ratio else "–", f"{goal:g}"]
        cells += [("yes" if ratio <= goal else "**no**") if ratio else "–"]
        cells += [
            ms(s.get(k)) for k in ("antialiased", "area", "py360convert", "ffmpeg", "skylibs")
        ]
        body.append(cells)
    return [
        "Milliseconds of a conversion of RGB texels, float32 unless u8. Ours computes its "
        "coordinates in the call. `cv2.remap` has them ready made in memory, and has no seams to "
        "look after; the next column is what making them costs in numpy. The ratio is ours to "
        "`cv2.remap` without that, less is faster.",
        table(head, body, 2),
        *(bench_finer(args) if args.match in "finer" else []),
        *(bench_lookups(args) if args.match in "lookups" else []),
    ]


def converts(image, src, dst, shape, filter, out, plain=PLAIN) -> Call:
    return lambda: sm.convert(image, src, dst, size=shape, filter=filter, out=out, **plain)


def ms(seconds: float | None) -> str:
    return "–" if seconds is None else f"{seconds * 1e3:.1f}"


def bench_finer(args: argparse.Namespace) -> list[str]:
    """Convert a large latlong to small images, by the defaults, against reading it once."""
    source_shape = small(FINER, args.quick)
    floats = np.random.default_rng(2).random((*source_shape, 3), np.float32)
    body = []
    for prefix, image in (("f32", floats), ("u8", (floats * 255).astype(np.uint8))):
        words = image.ravel() if image.dtype == np.float32 else image.ravel().view(np.uint64)
        for dst, shape in COARSER:
            shape = small(shape, args.quick)
            title = f"{dst} {'×'.join(map(str, shape))}, {prefix}"
            say(f"finer, {title}")
            out = np.empty((*shape, 3), image.dtype)
            entrants: dict[str, Call] = {
                "antialiased": converts(image, "latlong", dst, shape, "bilinear", out, plain={}),
                "plain": converts(image, "latlong", dst, shape, "bilinear", out),
                "sum": lambda w=words: w.sum(dtype=w.dtype),
            }
            s = race(entrants, max(3, args.rounds // 2), patience=2)
            goal = s["sum"] + 2 * s["plain"]
            numbers = [ms(s[k]) for k in ("antialiased", "plain", "sum")]
            numbers += [ms(goal), f"{s['antialiased'] / goal:.1f}"]
            body.append([title, *numbers, "yes" if s["antialiased"] <= goal else "**no**"])
    head = ["target", "ours, antialiased", "plain", "a sum over the source", "at most", "of that"]
    rows, columns = source_shape
    return [
        f"Milliseconds of `convert` with its defaults from a latlong of {columns}×{rows}×3, two to "
        "sixteen times finer. It may take what `numpy.sum` takes to read the source, on one "
        "thread, and two plain conversions.",
        table([*head, "reached"], body),
    ]


def bench_lookups(args: argparse.Namespace) -> list[str]:
    """Look up directions, random and in the order of an octahedral map."""
    if cv2 is None:
        return []
    height, side = (256, 256) if args.quick else (2048, 4096)
    rng = np.random.default_rng(1)
    image = rng.random((height, 2 * height, 3), np.float32)
    p = sm.projection("latlong")
    out = np.empty((side, side, 3), np.float32)
    body = []
    for where, goal in (("random", 1.0), ("coherent", 1.05)):
        say(f"lookups, {where}")
        if where == "random":
            d = rng.standard_normal((side, side, 3), np.float32)
        else:
            d = sm.directions("octahedral", side, dtype=np.float32)
        uv = p.encode(d) * np.float32([2 * height, height]) - np.float32(0.5)
        maps = np.ascontiguousarray(uv[..., 0]), np.ascontiguousarray(uv[..., 1])
        del uv
        entrants = {
            "ours": lambda d=d: p.sample(image, d, out=out),
            "cv2": cv2_remap(image, maps, (side, side), "bilinear", args.threads),
        }
        s = race(entrants, max(3, args.rounds // 2), patience=9)
        rate = {k: side * side / v / 1e6 for k, v in s.items()}
        ratio = s["cv2"] / s["ours"]
        reached = "yes" if ratio >= goal else "**no**"
        cells = [where, f"{rate['ours']:.0f}", f"{rate['cv2']:.0f}", f"{ratio:.2f}", f"{goal:g}"]
        body.append([*cells, reached])
        del d, maps
    head = ["directions", "ours", "cv2.remap", "ours to cv2.remap", "target", "reached"]
    return [
        f"Bilinear lookups of {side * side / 1e6:.1f} million directions in a latlong "
        f"{2 * height}×{height}×3 f32, millions a second (more is faster). Ours starts from "
        "directions, `cv2.remap` from ready maps.",
        table(head, body),
    ]


# --- quality


def band_limited(d: np.ndarray) -> np.ndarray:
    """A signal of direction without detail finer than 1/24 of a turn, between 0 and 1.

    It is a sum of plane waves, cos(k · d), with |k| up to 24, in random directions.
    """
    rng = np.random.default_rng(7)
    k = rng.standard_normal((12, 3))
    k *= rng.uniform(4, 24, (12, 1)) / np.linalg.norm(k, axis=1, keepdims=True)
    phase = rng.uniform(0, 2 * np.pi, 12)
    waves = np.cos(d @ k.T + phase)
    return np.stack([waves[..., i::3].mean(-1) for i in range(3)], -1) * 0.5 + 0.5


def fine_directions(dst: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return the directions of 8×8 places in each texel of an image."""
    return sm.directions(dst, (*shape[:-2], shape[-2] * 8, shape[-1] * 8))


def boxed(fine: np.ndarray, by: int) -> np.ndarray:
    """Return the means of blocks of texels."""
    *faces, height, width, channels = fine.shape
    blocks = fine.reshape(*faces, height // by, by, width // by, by, channels)
    return blocks.mean(axis=(-4, -2))


def bilinear(image: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Look directions up in a fine latlong image, in plain numpy and float64."""
    height, width = image.shape[:2]
    x = (np.arctan2(d[..., 0], -d[..., 2]) / (2 * np.pi) + 0.5) * width - 0.5
    y = np.clip(np.arccos(np.clip(d[..., 1], -1, 1)) / np.pi * height - 0.5, 0, height - 1)
    i, j = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    s, t = (x - i)[..., None], (y - j)[..., None]
    left, right = i % width, (i + 1) % width
    top = image[j, left] * (1 - s) + image[j, right] * s
    return top * (1 - t) + (image[j + 1, left] * (1 - s) + image[j + 1, right] * s) * t


def originals(args: argparse.Namespace) -> dict[str, Callable[[np.ndarray], np.ndarray]]:
    """Return what each picture shows in any direction, by name."""
    found: dict[str, Callable[[np.ndarray], np.ndarray]] = {"band-limited": band_limited}
    from spheremap import io

    venice = DATA / "venice.exr"
    if venice.exists():
        image = np.maximum(io.read(venice)[..., :3].astype(np.float64), 0)
        found["venice.exr"] = lambda d, image=image: bilinear(image, d)
    grace = DATA / "grace_probe.hdr"
    if grace.exists():
        probe = io.read(grace)[..., :3].astype(np.float32)
        # As a latlong of twice its density, and from there on by the formula above.
        image = sm.convert(probe, "angular", "latlong", size=1024, **PLAIN).astype(np.float64)
        found["grace_probe.hdr"] = lambda d, image=image: bilinear(image, d)
    return found


# To targets of an eighth of the density of the source.
COARSE = (
    ("latlong", (256, 512), "cube", (6, 16, 16)),
    ("latlong", (256, 512), "angular", (32, 32)),
    ("cube", (6, 128, 128), "latlong", (32, 64)),
)
# Beside these, to one of about its density, and from larger ones to a quarter of it.
QUALITY = (
    ("latlong", (256, 512), "cube", (6, 128, 128)),
    *COARSE,
    ("latlong", (512, 1024), "cube", (6, 64, 64)),
    ("latlong", (512, 1024), "angular", (128, 128)),
)


def entrants(image, src, dst, shape) -> dict[str, Call]:
    """Return everybody who turns this image into that."""
    calls: dict[str, Call] = {}
    for name in filters("bilinear", "bicubic", "mitchell", "lanczos3", "trilinear", "ewa", "area"):
        calls[f"ours, {name}"] = lambda name=name: sm.convert(
            image, src, dst, size=shape, filter=name
        )
    if cv2 is not None:
        maps = numpy_maps(src, dst, image.shape[:-1], shape)
        for name in ("bilinear", "bicubic"):
            calls[f"cv2.remap, {name}"] = cv2_remap(image, maps, shape, name, 2)
    if py360convert is not None and (call := py360convert(image, src, dst, shape, "bilinear")):
        calls["py360convert, bilinear"] = call
    if skylibs is not None and (call := skylibs(image, src, dst, shape)):
        calls["skylibs, bilinear"] = call
    return calls


def compared(show, src, source_shape, dst, shape):
    """Return the truth, its weights, and what each program makes of the same source."""
    finer = (*source_shape[:-2], *(n * 4 for n in source_shape[-2:]))
    source = boxed(show(sm.directions(src, finer)), 4).astype(np.float32)
    fine = fine_directions(dst, shape)
    held = ~np.isnan(fine[..., 0])
    truth = boxed(np.where(held[..., None], show(np.nan_to_num(fine)), 0), 8)
    whole = boxed(held[..., None].astype(float), 8)[..., 0] == 1
    results = {name: np.asarray(call()) for name, call in entrants(source, src, dst, shape).items()}
    return truth, whole, results


def bench_quality(args: argparse.Namespace) -> list[str]:
    pictures = originals(args)
    body = []
    cases = COARSE[:1] if args.quick else QUALITY
    for src, source_shape, dst, shape in cases:
        for picture, show in pictures.items():
            say(f"quality {src} → {dst} {shape} {picture}")
            truth, whole, results = compared(show, src, source_shape, dst, shape)
            scale = np.sqrt(np.mean(truth[whole] ** 2))
            weight = sm.solid_angle(dst, shape)[whole][:, None]
            light = np.sum(truth[whole] * weight)
            for name, got in results.items():
                error = got.reshape(truth.shape)[whole].astype(np.float64) - truth[whole]
                kept = np.sum(got.reshape(truth.shape)[whole] * weight) / light
                numbers = [np.sqrt(np.mean(error**2)) / scale, np.abs(error).max() / scale, kept]
                sizes = "×".join(map(str, shape))
                texts = [f"{numbers[0] * 100:.2f}", f"{numbers[1] * 100:.1f}", f"{kept:.4f}"]
                body.append(
                    [
                        f"{src} {source_shape[-1]}×{source_shape[-2]} → {dst} {sizes}",
                        picture,
                        name,
                        *texts,
                    ]
                )
    head = ["work", "picture", "program, filter", "RMSE, %", "worst, %", "light"]
    return [
        "Each source is the 4×4 mean of a finer picture; the truth of a texel is the mean of 8×8 "
        "places of that picture within it. RMSE and worst error are in percent of the truth's "
        "root mean square, over the texels that are whole; light is Σ L dω to that of the truth. "
        "Ours are with `convert`'s defaults, the others as they come.",
        table(head, body, 3),
    ]


# --- figures


def figures(args: argparse.Namespace) -> None:
    """Write a picture for each pair: a peer, ours, the truth, and both differences."""
    from spheremap import io

    pictures = originals(args)
    show = pictures.get("venice.exr", pictures["band-limited"])
    chosen = next(iter(filters("area", "ewa", "trilinear", "bilinear")))
    folder = ROOT / "docs" / "images"
    for src, source_shape, dst, shape in COARSE:
        truth, whole, results = compared(show, src, source_shape, dst, shape)
        peers = ("py360convert, bilinear", "skylibs, bilinear", "cv2.remap, bilinear")
        peer = next(name for name in peers if name in results)
        theirs = results[peer].reshape(truth.shape)
        ours = results[f"ours, {chosen}"].reshape(truth.shape)
        panels = [theirs, ours, truth]
        exposure = 0.5 / np.median(truth[whole])
        tiles = [picture(np.clip(panel * exposure, 0, None), dst) for panel in panels]
        for one in (theirs, ours):
            off = np.where(whole[..., None], np.abs(one - truth), 0)
            tiles.append(picture(off * exposure, dst))
        gap = np.ones((tiles[0].shape[0], 4, 3))
        joined = np.concatenate([x for tile in tiles for x in (tile, gap)][:-1], axis=1)
        by = max(1, 1280 // joined.shape[1])
        big = np.repeat(np.repeat(joined, by, 0), by, 1)
        path = folder / f"resample-{src}-{dst}.png"
        io.write(path, (np.clip(big, 0, 1) * 255 + 0.5).astype(np.uint8))
        say(f"wrote {path.name}: {peer}; ours, {chosen}; truth; both differences")


def picture(image: np.ndarray, dst: str) -> np.ndarray:
    """Return linear light as sRGB, faces of a cube three by two."""
    curve = np.where(
        image < 0.0031308, image * 12.92, 1.055 * np.maximum(image, 1e-9) ** (1 / 2.4) - 0.055
    )
    curve = np.clip(curve, 0, 1)
    if curve.ndim == 3:
        return curve
    rows = [np.concatenate(list(curve[k : k + 3]), axis=1) for k in (0, 3)]
    return np.concatenate(rows, axis=0)


# --- report


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("times", "quality"), help="this half alone, printed")
    parser.add_argument("--match", default="", help="time the rows whose title has this, printed")
    parser.add_argument("--quick", action="store_true", help="a smoke test with small images")
    parser.add_argument("--figures", action="store_true", help="write the pictures of the docs")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--rounds", type=int, default=25)
    args = parser.parse_args()
    if args.quick:
        args.rounds = 3
    sm.set_num_threads(args.threads)
    if args.figures:
        figures(args)
        return
    parts = ["## Resampling", f"{machine()}; {args.threads} threads each. {peer_versions()}."]
    if args.only != "quality":
        parts += ["### Times", *bench_times(args)]
    if args.only != "times" and not args.match:
        parts += ["### Quality", *bench_quality(args)]
    text = "\n\n".join(parts)
    print(text)
    if args.quick or args.only or args.match:
        return
    path = ROOT / "BENCHMARKS.md"
    old = path.read_text(encoding="utf-8") if path.exists() else "# Benchmarks\n"
    before, _, rest = old.partition(BEGIN)
    after = rest.partition(END)[2] if rest else ""
    path.write_text(
        f"{before.rstrip()}\n\n{BEGIN}\n\n{text}\n\n{END}\n{after.lstrip()}", encoding="utf-8"
    )
    say(f"wrote {path}")


if __name__ == "__main__":
    main()
