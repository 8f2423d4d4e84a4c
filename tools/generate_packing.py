"""Measure every packing scheme and write docs/packing.md.

python tools/generate_packing.py            measure and write (some minutes)
python tools/generate_packing.py --quick    a smoke test: few directions, printed only
python tools/generate_packing.py --check    fail if the page lacks a scheme; nothing is measured

Means are over seeded random directions in float64, the maxima of those refined by local search: a
random sample alone comes out about 1 % too small.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import spheremap as sm
from generate_docs import table

TARGET = Path(__file__).resolve().parents[1] / "docs" / "packing.md"
BITS = (8, 12, 16, 20, 24, 32)
SAMPLES = 10_000_000
# The others change in the third digit at most, and a tenth tells that.
WHOLE = ("oct", "woct", "equal_area")
CHUNK = 1_000_000
THREADS = sm.get_num_threads()
MEASURED: dict[str, tuple[float, float]] = {}
KEEP: list[Path] = []

# Schemes of the table: name without bits, grid, rounding.
ROWS = (
    ("oct", "", "nearest"),
    ("oct", "", "precise"),
    ("oct", "", "hex"),
    ("oct", "centers", "precise"),
    ("woct", "", "nearest"),
    ("woct", "", "precise"),
    ("woct", "", "hex"),
    ("woct", "centers", "precise"),
    ("equal_area", "", "precise"),
    ("fibonacci", "", "precise"),
    ("rings", "", "precise"),
    ("cube", "", "precise"),
    ("cube", "equiangular", "precise"),
    ("cube", "s2", "precise"),
    ("spherical", "", "precise"),
    ("hemioct", "", "precise"),
    ("sphere", "", "nearest"),
    ("matcap", "", "nearest"),
    ("z_phi", "", "nearest"),
)
COMPONENTS = ("snorm8x3", "snorm10x3", "snorm16x3", "rgb8x3", "rgb10a2")
PUBLISHED = {
    ("oct16", "nearest"): ".33709 / .94424",
    ("oct20", "nearest"): ".08380 / .23467",
    ("oct24", "nearest"): ".02091 / .05874",
    ("oct32", "nearest"): ".00131 / .0037",
    ("snorm8x3", "nearest"): ".17015 / .38588",
    ("snorm10x3", "nearest"): ".04228 / .09598",
}
# Fejes Tóth's covering by n points, in radians times √n.
LIMIT_MEAN, LIMIT_MAX = 1.33716, 2.1993


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angle between unit vectors; small ones without cancellation."""
    e = a - b
    return 2 * np.arcsin(np.minimum(np.sqrt(np.einsum("...i,...i", e, e)) / 2, 1))


def error(d: np.ndarray, name: str, rounding: str) -> np.ndarray:
    codes = sm.packing.pack(d, name, rounding)
    return angle(sm.packing.unpack(codes, name, dtype=np.float64), d)


def normalized(d: np.ndarray, upper: bool) -> np.ndarray:
    d = d / np.linalg.norm(d, axis=-1, keepdims=True)
    if upper:
        d[..., 2] = np.abs(d[..., 2])
    return d


def refine(d: np.ndarray, name: str, rounding: str, upper: bool, rounds: int = 60) -> float:
    """Return the largest error that a local search finds from these directions on."""
    rng = np.random.default_rng(7)
    worst = error(d, name, rounding)
    scale = worst.copy()
    for _ in range(rounds):
        near = d[:, None] + rng.normal(size=(len(d), 24, 3)) * scale[:, None, None]
        near = normalized(near, upper)
        found = error(near.reshape(-1, 3), name, rounding).reshape(near.shape[:2])
        best = found.argmax(1)
        rows = np.arange(len(d))
        better = found[rows, best] > worst
        d = np.where(better[:, None], near[rows, best], d)
        worst = np.where(better, found[rows, best], worst)
        scale = np.where(better, scale, scale * 0.75)
    return float(worst.max())


@cache
def directions(chunk: int) -> np.ndarray:
    return normalized(np.random.default_rng((1, chunk)).standard_normal((CHUNK, 3)), False)


def measure(name: str, rounding: str, samples: int, seeds: int = 48) -> tuple[float, float]:
    """Return the mean and the refined maximum of the error, in degrees."""
    key = f"{name} {rounding} {samples}"
    if key not in MEASURED:
        MEASURED[key] = measured(name, rounding, samples, seeds)
        if KEEP:
            KEEP[0].write_text(json.dumps(MEASURED))
    return MEASURED[key]


def measured(name: str, rounding: str, samples: int, seeds: int) -> tuple[float, float]:
    upper = sm.packing.packing(name).hemisphere
    total, worst, places = 0.0, [], []
    for first in range(0, samples, CHUNK):
        d = directions(first // CHUNK)[: samples - first]
        d = d * np.sign(d[:, 2:]) if upper else d
        e = error(d, name, rounding)
        total += float(e.sum())
        top = np.argpartition(e, -seeds)[-seeds:]
        worst.append(e[top])
        places.append(d[top])
    e, d = np.concatenate(worst), np.concatenate(places)
    d = d[np.argsort(e)[-4 * seeds :]]
    return np.degrees(total / samples), np.degrees(refine(d, name, rounding, upper))


def nanoseconds(name: str, rounding: str) -> tuple[float, float]:
    """Return the least cost of packing and unpacking one float32 direction, on one thread."""
    sm.set_num_threads(1)
    d = normalized(
        np.random.default_rng(2).standard_normal((1 << 16, 3)), sm.packing.packing(name).hemisphere
    )
    d = d.astype(np.float32)
    codes = sm.packing.pack(d, name, rounding)
    back = np.empty_like(d)
    times = []
    for call in (
        lambda: sm.packing.pack(d, name, rounding, out=codes),
        lambda: sm.packing.unpack(codes, name, out=back),
    ):
        runs = []
        for _ in range(15):
            start = time.perf_counter()
            call()
            runs.append(time.perf_counter() - start)
        times.append(min(runs) / len(d) * 1e9)
    sm.set_num_threads(THREADS)
    return times[0], times[1]


def short(x: float) -> str:
    """Return a number with as many digits as tell schemes apart."""
    digits = max(0, 4 - int(np.floor(np.log10(x))) - 1) if x > 0 else 3
    text = f"{x:.{digits}f}"
    return text[1:] if text.startswith("0.") else text


def limit(bits: int) -> tuple[float, float]:
    root = 2 ** (bits / 2)
    return np.degrees(LIMIT_MEAN / root), np.degrees(LIMIT_MAX / root)


def name_of(family: str, bits: int, variant: str) -> str:
    return f"{family}{bits}-{variant}" if variant else f"{family}{bits}"


def page(samples: int) -> str:
    head = ["scheme", "rounding", *(str(b) for b in BITS), "bits lost", "pack, unpack ns"]
    mean_rows = [["*limit*", "", *(short(limit(b)[0]) for b in BITS), "0", ""]]
    rows = [["*limit*", "", *(short(limit(b)[1]) for b in BITS), "0", ""]]
    for family, variant, rounding in ROWS:
        label = f"`{family}`" + (f" -{variant}" if variant else "")
        upper = family in ("hemioct", "matcap")
        means, maxima, lost = [], [], ("–", "–")
        for bits in BITS:
            name = name_of(family, bits, variant)
            if name not in sm.packing.packings():
                means.append("–")
                maxima.append("–")
                continue
            share = samples if family in WHOLE else samples // 10
            mean, worst = measure(name, rounding, share)
            means.append(short(mean))
            maxima.append(short(worst))
            if bits == 16:
                # A hemisphere is half of the sphere to cover.
                goal = [x / (np.sqrt(2) if upper else 1) for x in limit(bits)]
                lost = tuple(
                    f"{2 * np.log2(x / y):.2f}" for x, y in zip((mean, worst), goal, strict=True)
                )
        cost = nanoseconds(name_of(family, 16, variant), rounding)
        ns = f"{cost[0]:.1f}, {cost[1]:.1f}"
        mean_rows.append([label, rounding, *means, lost[0], ns])
        rows.append([label, rounding, *maxima, lost[1], ns])
        print(label, rounding, means, maxima, ns, flush=True)
    other = []
    for name in COMPONENTS:
        for rounding in ("nearest", "precise"):
            mean, worst = measure(name, rounding, samples // 10)
            cost = nanoseconds(name, rounding)
            other.append(
                [f"`{name}`", rounding, short(mean), short(worst), f"{cost[0]:.1f}, {cost[1]:.1f}"]
            )
    for name in sm.packing.packings():
        about = sm.packing.packing(name)
        if about.exact and about.bits in (16, 32):
            mean, worst = measure(name, about.roundings[0], samples // 40)
            cost = nanoseconds(name, about.roundings[0])
            other.append(
                [
                    f"`{name}`",
                    about.exact,
                    short(mean),
                    short(worst),
                    f"{cost[0]:.1f}, {cost[1]:.1f}",
                ]
            )
    against = []
    for (name, rounding), text in PUBLISHED.items():
        share = samples if name.startswith(WHOLE) else samples // 10
        mean, worst = measure(name, rounding, share)
        against.append([f"`{name}`", text, f"{short(mean)} / {short(worst)}"])
    return TEXT.format(
        samples=f"{samples:,}",
        means=table(head, mean_rows),
        maxima=table(head, rows),
        other=table(["scheme", "rounding or program", "mean", "max", "pack, unpack ns"], other),
        published=table(["scheme", "published", "ours, max refined"], against),
        families=families(),
        decoders=decoders(),
    )


def decoders() -> str:
    """Return what reads two schemes in GLSL, without what the text says about itself."""
    texts = [sm.packing.code(name, "glsl", verbs=["unpack"]) for name in ("oct16", "woct16")]
    functions = [text[text.index("\n\n") + 2 :].rstrip() for text in texts]
    return "```glsl\n" + "\n\n".join(functions) + "\n```"


def families() -> str:
    seen: dict[str, list[sm.packing.Packing]] = {}
    for name in sm.packing.packings():
        seen.setdefault(sm.packing.packing(name).family, []).append(sm.packing.packing(name))
    rows = []
    for family, members in seen.items():
        bits = sorted({m.bits for m in members})
        grids = [x for x in dict.fromkeys(m.variant for m in members) if x]
        example = members[min(4, len(members) - 1)]
        sizes = str(bits[0]) if len(bits) == 1 else f"{bits[0]} … {bits[-1]}"
        rows.append(
            [
                f"`{family}`",
                f"`{example.name}`",
                sizes,
                ", ".join(grids) or "–",
                ", ".join(example.roundings),
                example.summary,
                example.source,
            ]
        )
    return table(["family", "as in", "bits", "grids", "roundings", "what it is", "source"], rows)


TEXT = """# Packing unit vectors

Written by `tools/generate_packing.py`; do not edit.

`sm.packing.pack(d, "oct16")` turns directions into integers, `sm.packing.unpack` turns them back,
`sm.packing.packing(name)` describes a scheme, `sm.packing.best_packing(bits)` names the best one.
A name is a family and the total bits of a code, then a grid or spacing if it is not the default:
`oct16`, `oct16-centers`, `cube24-s2`. A number of fields makes an array of them: `oct8x2` is int8
of shape (..., 2), where `oct16` is one uint16 of the same bits. Fields fill a word from its lowest
bits, x first. +z is the pole.

## Which one

- Other programs read it: `oct`, `rounding="precise"`. It costs the reader nothing and a third of
  the worst error goes.
- Only you read it: `woct`. Three multiply-adds more in the decoder, and the worst error of any
  code of as many points could be at most 8 % smaller.
- Normals that face you, z ≥ 0: `hemioct`.
- A texture that is filtered: `-centers`, the positions of its texels. No direction has two codes
  there.
- Codes that are counted (histograms, visibility): `equal_area`; or `fibonacci` and `rings`, whose
  mean errors are the smallest and whose encoders search.
- Never `sphere`, `matcap` or `z_phi`: no multiple of the step bounds their error, and `pack`
  warns.

`nearest` rounds each coordinate. `precise`, the default, compares the four corners of the cell on
the sphere. `hex` rounds three barycentrics in the plane of the octahedron's face: for `oct` it
has the worst case of `precise` within 0.1 %, and decodes nothing. With δ = 1/(2ᵇ⁻¹ - 1)
the step of the snorm grid, the error of `oct` is never above (3/√2)δ with `nearest` and √2·δ with
`precise`, in exact arithmetic; float32, used for fields of up to 16 bits, adds up to 5e-7 rad,
and Draco's decoder, float32 for all, up to 1e-6.
`sm.packing.packing(name).bounds` has the bound of each scheme. `unpack` computes in float32 unless
told otherwise, whatever the code: fields of 23 bits and more (`oct46`, `oct64`, `oct32x2`), whose
bounds are smaller than what that adds, want `dtype=np.float64`.

In a shader ([languages](languages.md)): `sm.packing.code("oct16", "glsl")` prints both ways, with
the integers of `pack` and the bits of `unpack`. This is the decoder, and that of `woct16`:

{decoders}

## Worst error, degrees

Over {samples} seeded directions in float64 (a tenth of them for those that are not octahedral),
the largest error refined by local search. *limit* is Fejes Tóth's bound for n points, 2.1993/√n
rad; the bits lost are those by which the scheme's 16 bits fall short of it. Nanoseconds are the
least for a float32 direction and 16 bits, on one thread and in cache.

{maxima}

## Mean error, degrees

The limit is 1.33716/√n rad.

{means}

## Components and other programs' codes, degrees

{other}

## Against the published numbers

Mean / maximum in degrees as Cigolle et al. 2014 are quoted in public shader headers, against ours
with `rounding="nearest"`. Theirs are the largest of a sample.

{published}

## Families

{families}

`draco`, `meshoptimizer`, `pbrt`, `unreal` and `cesium` repeat those programs' codes to the bit,
and round as they do. meshoptimizer's decoder uses an approximate square root where it has SIMD;
its integers may then differ from ours, which are those of its plain code, by one. Draco's first
number is its quantization bits, and x is its pole. Draco takes vectors whose components sum to
1e-6 or less for +x; `draco` scales those by a power of two first and keeps their directions.

## One code for each direction

Where a map folds, several codes read as one direction: the edge of the octahedral square meets
itself, a pole has every longitude, -128 reads as -127. `pack` writes one of them, and
`sm.packing.canonical` gives that one for all. snorm `oct16` has 64,518 distinct directions. What
`canonical` returns decodes to the direction that was given, within 5e-7 rad (2e-6 in `draco`),
is the same for all codes of one direction, and stays as it is when it is given again. Exceptions:

- `snorm`, `rgb` and `rgb10a2`: numbers in proportion are one direction, of which `pack` writes now
  one, now another. `canonical` gives the point nearest to the unit sphere.
- `pbrt`, `unreal`, `cesium`, `meshoptimizer`: those programs write two codes on an edge of the
  square, where a component is just below 0. `canonical` gives that of one above.
- `meshoptimizer` rounds what it decodes: different codes may give the same numbers, and stay
  different.
- `matcap`: codes outside the disk, which `pack` does not write, decode to the horizon. `canonical`
  gives the first of them along a ray.
- `draco`: the last row and column, which `pack` does not write, lie beyond the grid and stay.

## Frames

`sm.packing.pack_frame` packs a normal with a tangent and the sign of the bitangent into 32 or 64
bits. The part of the tangent that is perpendicular to the normal counts; it is off by at most the
bound of the normal and half a step of the angle.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few directions, printed only")
    parser.add_argument("--keep", type=Path, help="a file of errors: read, and added to")
    parser.add_argument("--check", action="store_true", help="only compare what is not measured")
    args = parser.parse_args()
    if args.check:
        text = TARGET.read_text(encoding="utf-8") if TARGET.exists() else ""
        if families() not in text or decoders() not in text:
            raise SystemExit(f"{TARGET.name} is out of date: run python tools/generate_packing.py")
        return
    quick = args.quick
    if args.keep:
        KEEP.append(args.keep)
        if args.keep.exists():
            MEASURED.update(json.loads(args.keep.read_text()))
    warnings.simplefilter("ignore", sm.packing.UnboundedPackingWarning)
    text = page(50_000 if quick else SAMPLES)
    if quick:
        print(text)
    else:
        TARGET.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
