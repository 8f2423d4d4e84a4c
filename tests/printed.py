"""What printed code is tried on, maps, packings, directions and places, and what it is held to."""

from __future__ import annotations

import ctypes
import subprocess
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import ran
import spheremap as sm
from conftest import NAMES, REGISTRY
from hard_directions import SPECIAL, near_planes, near_special_points, signed_zeros
from spheremap import _core

Array = np.ndarray
VERBS = ("encode", "decode", "density", "jacobian", "valid")
# Whose densities and derivatives in f32, or all numbers, kernels compute in f64, where printed f32
# cannot have their bits.
IN_DOUBLE = {entry["name"] for entry in REGISTRY if entry["in_double"]}
BOUNDS = {entry["name"]: entry["round_trip"] for entry in REGISTRY}
LANGUAGES: list[dict[str, Any]] = _core.code_languages()

MORE = {
    "cube:unreal": {},
    "cube:directxtex-h-cross": {},
    "octahedral:unreal": {},
    "latlong:mitsuba": {},
    "angular(fov=180)": {},
    "perspective(fov=60)": {},
    "dual_fisheye(fov=200)": {},
}
CASES = [*NAMES, *MORE, "turned", "cross"]


def made(case: str) -> sm.Projection:
    """Return the map of a case; a grid may stand behind its name."""
    if case == "turned":
        return sm.projection("latlong").turned(sm.rotation(30, 20, 10))
    if case in ("cross", "strip"):
        return sm.projection("cube", layout=case)
    name, _, grid = case.partition("/")
    return sm.projection(name, grid=grid or None)


@cache
def directions(dtype: type) -> Array:
    """Unit vectors: ties, poles, seams, creases, signs of zeros, and all over."""
    rng = np.random.default_rng(3)
    parts = [
        SPECIAL,
        signed_zeros(np.float64),
        near_special_points(np.float64),
        near_planes(np.float64),
        rng.normal(size=(16_000, 3)),
    ]
    d = np.concatenate(parts)
    d = (d / np.linalg.norm(d, axis=-1, keepdims=True)).astype(dtype)
    # What is smaller counts as zero in printed code, which scales nothing.
    kept = np.all((d == 0) | (np.abs(d) > 1e-16), axis=-1)
    return np.ascontiguousarray(d[kept])


def places(p: sm.Projection, dtype: type) -> Array:
    """Image coordinates: what directions encode to, edges, corners, the middle."""
    encoded = p.encode(directions(dtype))
    encoded = encoded[~np.isnan(encoded[:, 0])]
    steps = np.array([0, 1e-6, 0.25, 0.5, 0.75, 1 - 2.0**-24, 1])
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    if encoded.shape[1] == 3:
        grid = np.concatenate([np.insert(grid, 2, face, axis=1) for face in range(p.faces)])
    return np.ascontiguousarray(np.concatenate([encoded, grid]).astype(dtype))


def same_bits(a: Array, b: Array) -> Array:
    """Tell where numbers are equal; NaN are, and zeros of both signs."""
    return (a == b) | (np.isnan(a) & np.isnan(b))


def asked(p: sm.Projection, dtype: type) -> dict[str, Array]:
    """Return what each verb is tried on."""
    uv = places(p, dtype)
    inside = np.ascontiguousarray(uv[p.valid(uv)])
    inside_verbs = dict.fromkeys(("decode", "density", "jacobian"), inside)
    return {"encode": directions(dtype), **inside_verbs, "valid": uv}


def assert_alike(
    p: sm.Projection, dtype: type, verb: Callable[[str, Array], Array], *, exact: bool = True
) -> None:
    """Hold a language's verbs to the library's, on all directions and places.

    To the bit, where the library does not compute in f64 what the language does in f32.
    """
    given = asked(p, dtype)
    found = {name: verb(name, data) for name, data in given.items()}
    # (n, 3, 2) from both columns, one after the other.
    found["jacobian"] = np.swapaxes(found["jacobian"].reshape(-1, 2, 3), 1, 2)
    if exact and (dtype is np.float64 or p.name not in IN_DOUBLE):
        assert_same(p, given, found)
    else:
        assert_near(p, given, found, 2 * BOUNDS[p.name][dtype is np.float64])
    ran.note_map(p, dtype, given, found)


def assert_same(p: sm.Projection, given: dict[str, Array], found: dict[str, Array]) -> None:
    """Hold what was found to the bits of the library."""
    wanted = p.encode(given["encode"])
    outside = np.isnan(wanted[:, 0])
    assert np.array_equal(outside, np.isnan(found["encode"][:, 0]))
    assert same_bits(found["encode"], wanted)[~outside].all()
    assert np.array_equal(found["valid"].astype(bool), p.valid(given["valid"]))
    for verb in ("decode", "density", "jacobian"):
        assert same_bits(found[verb], getattr(p, verb)(given[verb])).all()


def assert_none_of_none(verb: Callable[[str, Array], Array], dtype: type) -> None:
    """Hold a language to a NaN for a direction of three, as docs/languages.md says of it.

    One component alone is not looked at by every map.
    """
    found = verb("encode", np.full((1, 3), np.nan, dtype))
    assert np.isnan(found[:, :2]).any()


def assert_near(
    p: sm.Projection, given: dict[str, Array], found: dict[str, Array], bound: float
) -> None:
    """Hold what was found to a bound of directions: twice the claim of the registry.

    It is claimed of a direction through the image, and of a place. Twice, as languages may contract
    and divide less exactly.
    """
    d, inside = given["encode"], given["decode"]
    covered = ~np.isnan(p.encode(d)[:, 0])
    # NaN, or what stands in its place: but for what lies on a rim, as below.
    assert (found["encode"][~covered, 0] >= 0).sum() <= 0.01 * len(d)
    back = p.decode(found["encode"][covered])
    off = np.linalg.norm(back.astype(np.float64) - d[covered], axis=-1)
    # What lies on a rim may be taken for outside, by a rounding.
    assert np.isnan(off).mean() < 0.01
    assert np.nanmax(off) <= bound
    off = np.linalg.norm(found["decode"].astype(np.float64) - p.decode(inside), axis=-1)
    assert off.max() <= bound
    assert (found["valid"].astype(bool) == p.valid(given["valid"])).mean() > 0.99
    for verb in ("density", "jacobian"):
        wanted, steady = values_and_steady(getattr(p, verb), inside.astype(np.float64))
        assert steady.mean() > 0.75
        off = size_of(found[verb][steady] - wanted[steady]) / size_of(wanted[steady])
        # A thousand roundings of f32: a wrong operand shows, and so does NaN.
        assert off.max() <= 1e-4


def assert_native(
    p: sm.Projection, there_and_back: Callable[[Array], Array], ulps: int = 4096
) -> None:
    """Hold a round trip in f32 by a language's own functions to what the language allows them.

    By default that is what WGSL and Vulkan allow, the loosest: an arctangent is off by 4096 units
    of its last place, and a sine by 2**-11. GLSL promises nothing, and is held to the same.
    """
    d = directions(np.float32)
    d = np.ascontiguousarray(d[p.covers(d)])
    off = np.linalg.norm(np.asarray(there_and_back(d), np.float64) - d, axis=-1)
    # What lies on a rim, or beside a blind spot, may be taken for outside.
    assert np.isnan(off).mean() < 0.01
    # An arctangent of up to half a turn has units of 2**-24 of it, and is asked for twice; maps
    # stretch that by 3 at most. Or what the map loses.
    bound = max(3 * 2 * ulps * 2.0**-24 * np.pi, 4 * BOUNDS[p.name][0])
    assert np.nanmax(off) <= bound
    seen = {"precision": "native", "verbs": ("decode", "encode"), "apart": float(np.nanmax(off))}
    ran.note("maps", repr(p), 32, directions=len(d), **seen)


def assert_sums_alike(
    language: str, channels: int, run: Callable[[str, Array], Array], order: int = 4
) -> None:
    """Hold a language's `evaluate`, of each direction, to that of the library."""
    c = np.random.default_rng(2).normal(size=((order + 1) ** 2, channels))
    d = directions(np.float32)
    found = run(sm.sh.code(c, language, name="m"), d)
    # Ten roundings a degree, of terms up to sqrt(9 / 4 pi) times |c|, and as many for languages
    # that contract.
    bound = 20 * (order + 1) * 0.85 * np.abs(c).sum(axis=0).max() * float(np.finfo(np.float32).eps)
    assert np.abs(found - sm.sh.evaluate(c, d)).max() <= bound
    ran.note("harmonics", f"{order}, {channels}", 32)


def values_and_steady(verb: Callable[[Array], Array], places: Array) -> tuple[Array, Array]:
    """Return values in f64, and where a rounding of a place changes them little.

    Near a rim, a pole, a crease or a blind spot it changes them much: no f32 is near there.
    """
    with np.errstate(all="ignore"):
        values = verb(places)
        change = np.zeros(len(places))
        for axis, step in ((0, 2.0**-22), (0, -(2.0**-22)), (1, 2.0**-22), (1, -(2.0**-22))):
            beside = places.copy()
            beside[:, axis] = np.clip(beside[:, axis] + step, 0, 1)
            off = size_of(verb(beside) - values) / size_of(values)
            change = np.maximum(change, off)
        # A hundred roundings of f32.
        return values, change <= 1e-5


def size_of(values: Array) -> Array:
    """Return the size of numbers or of matrices."""
    return np.linalg.norm(values.reshape(len(values), -1), axis=1)


# Maps and sizes (rows, columns) of images that `taps` is tried on: of each rule, some with axes of
# a program, one that is turned, layouts of faces, texels on the edges.
TAPPED = [
    ("latlong", (8, 16)),
    ("latlong:blender", (32, 64)),
    ("latlong:openexr", (9, 17)),
    ("latlong/corners-v", (9, 16)),
    ("turned", (16, 32)),
    ("lambert_cylindrical", (8, 26)),
    ("mercator", (16, 16)),
    ("octahedral", (9, 9)),
    ("octahedral/corners", (9, 9)),
    ("octahedral:unreal", (64, 64)),
    ("equal_area", (16, 16)),
    ("hemioctahedral", (12, 12)),
    ("perspective(fov=60)", (9, 9)),
    ("cube", (8, 8)),
    ("cube/corners", (9, 9)),
    ("cube:unreal", (7, 7)),
    ("strip", (8, 48)),
    ("cross", (24, 32)),
    ("cube:directxtex-h-cross", (24, 32)),
    ("cube_equiangular", (8, 8)),
    ("cube_equal_area", (9, 9)),
]


def mixed_by(found: Array, image: Array) -> Array:
    """Return what texels and weights, twelve or sixteen numbers of each direction, mix."""
    *places, weights = np.split(found, found.shape[1] // 4, axis=1)
    columns, rows, *faces = (numbers.astype(int) for numbers in places)
    return (weights * image[(*faces, rows, columns)]).sum(axis=1)


def image_shape(p: sm.Projection, size: tuple[int, int]) -> tuple[int, ...]:
    """Return the shape of an image of a map; sizes are of a face where faces are apart."""
    return (p.faces, *size) if p.faces > 1 else size


def within_a_face(p: sm.Projection, d: Array, size: tuple[int, int]) -> Array:
    """Tell where a direction lies between four texels of its own face."""
    if not p.name.startswith("cube") or p.grid != "centers":
        return np.ones(len(d), bool)
    n = np.gcd(*size)
    place = p.encode(d)[:, :2] * size[::-1] % n
    return ((place >= 0.5) & (place <= n - 0.5)).all(axis=1)


def assert_taps(
    case: str, size: tuple[int, int], taps: Callable[[Array], Array], dtype: type = np.float32
) -> None:
    """Hold texels and weights, of each direction, to what `sample` mixes.

    At an edge of a cube it mixes more; there the texels are to be near.
    """
    p = made(case)
    d = directions(dtype)
    d = np.ascontiguousarray(d[p.covers(d)])
    assert len(d) > 2000
    image = np.random.default_rng(1).uniform(size=image_shape(p, size))
    wanted = sm.sample(image, d.astype(np.float64), p)
    found = taps(d).astype(np.float64)
    # What lies on a rim may be taken for outside, by a rounding.
    inside = ~(np.isnan(found).any(axis=-1) | np.isnan(wanted))
    assert inside.mean() > 0.99
    d, found, wanted = d[inside].astype(np.float64), found[inside], wanted[inside]
    *places, weights = np.split(found, found.shape[1] // 4, axis=1)
    for numbers, n in zip(places, (*size[::-1], p.faces), strict=False):
        assert (numbers == np.floor(numbers)).all() and numbers.min() >= 0 and numbers.max() < n
    # Weights are products of two parts of texels, each rounded a few times at the size of the side.
    rounding = 16 * max(size) * float(np.finfo(dtype).eps)
    assert np.abs(weights.sum(axis=1) - 1).max() <= rounding and weights.min() >= -rounding
    same = within_a_face(p, d, size)
    assert np.abs(mixed_by(found, image) - wanted)[same].max() <= rounding
    if not same.all():
        # A texel and a half at most, of two parts in n of a face, in both coordinates.
        columns, rows, *faces = (numbers[~same] for numbers in places)
        centers = ((columns + 0.5) / size[1], (rows + 0.5) / size[0], *faces)
        there = p.decode(np.stack(centers, axis=-1))
        far = np.linalg.norm(there - d[~same][:, None], axis=-1)
        assert far[weights[~same] > rounding].max() <= 1.5 * np.sqrt(2) * 2 / np.gcd(*size)
    ran.note("taps", case, 8 * np.dtype(dtype).itemsize)


# Every scheme that is a formula, of each grid at 16 bits or the first size above, and sizes that
# ask for other words: of one byte, of 24, 32, 48 and 64 bits.
_SIZES = ("oct8", "oct24-centers", "oct32", "woct32", "hemioct24", "snorm10x3", "snorm16x3")
_WIDE = ("oct64", "cube32-s2", "spherical48")
PACKINGS = [
    *(
        name
        for name in sm.packing.packings(words=True)
        for about in [sm.packing.packing(name)]
        if about.bits == 16 and about.family not in ("fibonacci", "rings")
    ),
    "snorm8x3",
    "rgb8x3",
    "rgb10a2",
    "cube20",
    *_SIZES,
]
PACKINGS_DOUBLE = [*PACKINGS, *_WIDE]
# What the library computes in the width of the directions; the rest it computes in f64.
IN_SINGLE = ("oct", "woct")


def roundings(name: str) -> tuple[str, ...]:
    """Return the ways that a scheme rounds."""
    return sm.packing.packing(name).roundings


def unit_vectors(name: str, dtype: type) -> Array:
    """Return directions that a scheme holds."""
    d = directions(dtype).copy()
    if sm.packing.packing(name).hemisphere:
        d[:, 2] = np.abs(d[:, 2])
    return d


def words_of(codes: Array, name: str) -> Array:
    """Return codes as words of 64 bits, the first field in the lowest."""
    about = sm.packing.packing(name)
    if not about.shape:
        return codes.astype(np.uint64)
    bits = about.bits // about.shape[0]
    mask = np.uint64((1 << bits) - 1)
    words = np.zeros(codes.shape[:-1], np.uint64)
    for k in range(about.shape[0]):
        field = codes[..., k].astype(np.int64).view(np.uint64) & mask
        words |= field << np.uint64(k * bits)
    return words


def some_words(name: str, packed: Array) -> Array:
    """Return words to unpack: all of up to 16 bits, else what was packed and random ones."""
    about = sm.packing.packing(name)
    if about.bits <= 16:
        return np.arange(about.codes, dtype=np.uint64)
    random = np.random.default_rng(7).integers(0, about.codes - 1, 20_000, np.uint64, endpoint=True)
    return np.concatenate([packed, random])


def fields_of(words: Array, name: str) -> Array:
    """Return words as the codes that the library takes."""
    about = sm.packing.packing(name)
    if not about.shape:
        return words.astype(about.dtype)
    bits = about.bits // about.shape[0]
    shifts = np.arange(about.shape[0], dtype=np.uint64) * np.uint64(bits)
    fields = (words[:, None] >> shifts) & np.uint64((1 << bits) - 1)
    if about.dtype.kind == "u":
        return fields.astype(about.dtype)
    signed = fields.astype(np.int64)
    signed[signed >= 1 << (bits - 1)] -= 1 << bits
    return signed.astype(about.dtype)


def assert_packs_alike(
    name: str,
    rounding: str,
    dtype: type,
    pack: Callable[[Array], Array],
    unpack: Callable[[Array], Array],
    *,
    exact: bool = True,
) -> None:
    """Hold a language's `pack` and `unpack` to the library's: the same integers, the same bits.

    In f32 that is so where the library computes in f32; the others, and languages that contract and
    divide less exactly, are held to their bounds.
    """
    about = sm.packing.packing(name)
    d = unit_vectors(name, dtype)
    assert len(d) > 20_000
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", sm.packing.UnboundedPackingWarning)
        wanted = words_of(sm.packing.pack(d, name, rounding), name)
    found = pack(d).astype(np.uint64)
    words = some_words(name, wanted)
    back = unpack(words)
    held = sm.packing.unpack(fields_of(words, name), name, dtype=dtype)
    same = np.array_equal(found, wanted) and bool(same_bits(back, held).all())
    ran.note("packings", name, 8 * np.dtype(dtype).itemsize, same=same)
    if exact and (dtype is np.float64 or about.family in IN_SINGLE):
        assert np.array_equal(found, wanted)
        assert same_bits(back, held).all()
        return
    # Decoding rounds ten times or so, each a component of up to 1, or an angle of a few half turns.
    few = 20 * float(np.finfo(np.float32).eps)
    nan = np.isnan(held).any(axis=-1)
    assert np.array_equal(nan, np.isnan(back).any(axis=-1))
    if about.family not in ROOTS:
        assert np.abs(back[~nan] - held[~nan]).max() <= few
    # A direction between two codes may get the other one; then nothing is lost but the rounding.
    off = np.linalg.norm(
        sm.packing.unpack(fields_of(found, name), name, dtype=np.float64) - d, axis=-1
    )
    assert off.max() <= about.bounds[rounding] + few
    # The hard directions, a fifth of all, lie between codes by intent.
    assert (found == wanted).mean() > 0.8


# Near a rim or a pole they decode by the root of a difference, which takes half of the digits.
ROOTS = ("sphere", "matcap", "z_phi")


def compiled(text: str, folder: Path, *flags: str, cpp: bool = False) -> ctypes.CDLL:
    """Return C, or C++, as a library; C without a warning."""
    source, target = folder / ("all.cpp" if cpp else "all.c"), folder / "all.so"
    source.write_text(text)
    own = ["c++", "-std=c++17"] if cpp else ["cc", "-std=c99", "-Wall", "-Wextra", "-Werror"]
    command = [*own, *flags, "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run([*command, source, "-o", target, "-lm"], check=True)
    return ctypes.CDLL(str(target))


def called(function: Any, *arrays: Array) -> Array:
    """Call a function of C on arrays; return the last, which has a row for each result."""
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
    function(*pointers, ctypes.c_long(len(arrays[-1])))
    return arrays[-1]
