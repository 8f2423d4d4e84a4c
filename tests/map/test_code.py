"""Printed code does what the library does: compiled as C, run as NumPy, to the bit."""

from __future__ import annotations

import ctypes
import re
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from printed import (
    BOUNDS,
    CASES,
    IN_DOUBLE,
    LANGUAGES,
    TAPPED,
    VERBS,
    Array,
    assert_alike,
    assert_native,
    assert_none_of_none,
    assert_taps,
    called,
    compiled,
    directions,
    image_shape,
    made,
    mixed_by,
    same_bits,
)


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[type], ctypes.CDLL]:
    """Return every case as one library of C, by width."""

    @cache
    def of_type(dtype: type) -> ctypes.CDLL:
        number = "float" if dtype is np.float32 else "double"
        parts = []
        for k, case in enumerate(CASES):
            p = made(case)
            width = p.encode(np.zeros(3)).shape[-1]
            parts.append(sm.code(p, "c", verbs=VERBS, name=f"m{k}", dtype=dtype.__name__))
            for verb, call in {
                "encode": (f"m{k}_encode(in + 3 * i, out + {width} * i)"),
                "decode": (f"m{k}_decode(in + {width} * i, out + 3 * i)"),
                "density": (f"out[i] = m{k}_density(in + {width} * i)"),
                "valid": (f"out[i] = m{k}_valid(in + {width} * i)"),
                "jacobian": (f"m{k}_jacobian(in + {width} * i, out + 6 * i, out + 6 * i + 3)"),
            }.items():
                parts.append(
                    f"void all{k}_{verb}(const {number}* in, {number}* out, long n) {{\n"
                    f"    for (long i = 0; i < n; i++) {call};\n}}\n"
                )
        folder = tmp_path_factory.mktemp("code")
        return compiled("\n".join(parts), folder, "-Wno-unused-parameter")

    return of_type


def run_c(library: ctypes.CDLL, number: int, p: sm.Projection) -> Callable[[str, Array], Array]:
    """Return the verbs of a case as compiled."""
    width = p.encode(np.zeros(3)).shape[-1]
    gives = {"encode": width, "decode": 3, "density": 1, "valid": 1, "jacobian": 6}

    def verb(name: str, data: Array) -> Array:
        out = np.empty((len(data), gives[name]), data.dtype)
        called(library[f"all{number}_{name}"], data, out)
        return out[:, 0] if gives[name] == 1 else out

    return verb


@pytest.mark.runs("cc", language="c")
@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", CASES)
def test_compiled_c_has_the_bits_of_the_library(
    case: str, dtype: type, library: Callable[[type], ctypes.CDLL]
) -> None:
    p = made(case)
    assert_alike(p, dtype, run_c(library(dtype), CASES.index(case), p))


@pytest.mark.runs("numpy", language="numpy")
@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", CASES)
def test_numpy_has_the_bits_of_the_library(case: str, dtype: type) -> None:
    p = made(case)
    text = sm.code(p, "numpy", verbs=VERBS, name="m", dtype=dtype.__name__)
    names: dict[str, Any] = {}
    exec(text, names)

    def verb(name: str, data: Array) -> Array:
        with np.errstate(all="ignore"):
            out: Array = names[f"m_{name}"](data)
        assert name == "valid" or out.dtype == dtype
        if name == "jacobian":
            return np.swapaxes(out, -1, -2).reshape(-1, 6)
        return out

    assert_alike(p, dtype, verb)


@pytest.mark.parametrize("case", CASES)
def test_native_functions_are_those_of_the_language(case: str) -> None:
    """Round trips by NumPy's own functions, in f64."""
    p = made(case)
    names: dict[str, Any] = {}
    exec(sm.code(p, "numpy", name="m", precision="native", dtype="float64"), names)
    d = directions(np.float64)
    d = d[p.covers(d)]
    with np.errstate(all="ignore"):
        back = names["m_decode"](names["m_encode"](d))
    # They round a few hundred times; what loses digits loses them in the map.
    bound = max(2 * BOUNDS[p.name][1], 1e-13)
    assert np.nanmax(np.linalg.norm(back - d, axis=-1)) <= bound


@pytest.fixture(scope="session")
def native_library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Return a round trip of every case by the functions of C."""
    parts = []
    for k, case in enumerate(CASES):
        p = made(case)
        width = p.encode(np.zeros(3)).shape[-1]
        parts.append(sm.code(p, "c", name=f"m{k}", precision="native"))
        parts.append(
            f"void all{k}(const float* in, float* out, long n) {{\n"
            f"    for (long i = 0; i < n; i++) {{\n        float uv[{width}];\n"
            f"        m{k}_encode(in + 3 * i, uv);\n        m{k}_decode(uv, out + 3 * i);\n"
            "    }\n}\n"
        )
    return compiled("\n".join(parts), tmp_path_factory.mktemp("native"))


@pytest.mark.runs("cc", language="c")
@pytest.mark.parametrize("case", CASES)
def test_c_has_functions_of_its_own(case: str, native_library: ctypes.CDLL) -> None:
    function = native_library[f"all{CASES.index(case)}"]
    # Its standard promises nothing; C libraries state 1 to 4 units.
    assert_native(made(case), lambda d: called(function, d, np.empty_like(d)), ulps=4)


@pytest.mark.parametrize("language", [entry["name"] for entry in LANGUAGES])
@pytest.mark.parametrize("case", CASES)
def test_every_map_prints_in_every_language(case: str, language: str) -> None:
    text = sm.code(made(case), language, verbs=VERBS, name="some_name")
    for verb in VERBS:
        assert re.search(rf"\bsome_name_{verb}\(", text)
    # Nothing of Rust's own way to write numbers, and no name without the prefix at the top.
    assert not re.search(r"\b(inf|NaN)\b", re.sub(r"(//|#).*", "", text))
    opened = re.findall(r"^\w[\w ]* (\w+)\(", text, re.M)
    assert opened and all(name.startswith("some_name_") for name in opened)
    assert "spheremap" in text and made(case).source.split()[0] in text


@pytest.mark.parametrize("case", CASES)
def test_the_header_says_what_it_is(case: str) -> None:
    p = made(case)
    for language, dtype in (("glsl", "float32"), ("numpy", "float64")):
        text = sm.code(p, language, dtype=dtype)
        comments = re.findall(r"^(?://|#) ?(.*)$", text, re.M)
        said = " ".join(" ".join(comments).split())
        assert " ".join(p.source.split()) in said
        assert f'axes "{p.axes}"' in said
        for label in ("Directions:", "Image: u right, v down", "Singular:", "Functions:"):
            assert label in said
        bound = float(re.search(r"within (\S+) radians", said)[1])
        assert bound == BOUNDS[p.name][dtype == "float64"]
        assert f"Written by spheremap {sm.__version__} for " in said


# The longest name, the shortest, and some that are words elsewhere.
PREFIXES = ("q", "A1", "a_B_2", "x" * 64, "float3", "short", "fn", "d", "uv", "t0", "pair")


@pytest.mark.parametrize("name", PREFIXES)
def test_names_hide_nothing(name: str, tmp_path: Path) -> None:
    """A text works by any name, as C, as C++ and as NumPy."""
    p, d = made("latlong"), directions(np.float32)
    loop = (
        f"void all(const float* in, float* out, long n) {{\n"
        f"    for (long i = 0; i < n; i++) {name}_encode(in + 3 * i, out + 2 * i);\n}}\n"
    )
    text = sm.code(p, "c", verbs=VERBS, name=name)
    for cpp in (False, True):
        folder = tmp_path / str(cpp)
        folder.mkdir()
        whole = text + ('extern "C" ' if cpp else "") + loop
        library = compiled(whole, folder, "-Wno-unused-function", cpp=cpp)
        out = called(library.all, d, np.empty((len(d), 2), np.float32))
        assert same_bits(out, p.encode(d)).all()
    names: dict[str, Any] = {}
    exec(sm.code(p, "numpy", verbs=VERBS, name=name), names)
    assert same_bits(names[f"{name}_encode"](d), p.encode(d)).all()
    own = {key for key in names if key not in ("np", "__builtins__")}
    assert all(key.startswith(f"{name}_") for key in own)


@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", CASES)
def test_signs_of_zeros_come_out_as_they_do_here(
    case: str, dtype: type, library: Callable[[type], ctypes.CDLL]
) -> None:
    p = made(case)
    if dtype is np.float32 and p.name in IN_DOUBLE:
        return
    verb = run_c(library(dtype), CASES.index(case), p)
    d = directions(dtype)
    d = d[(d == 0).any(axis=1)]
    wanted, found = p.encode(d), verb("encode", np.ascontiguousarray(d))
    zero = wanted == 0
    assert np.array_equal(np.signbit(found[zero]), np.signbit(wanted[zero]))
    inside = wanted[~np.isnan(wanted[:, 0])]
    back, wanted = verb("decode", np.ascontiguousarray(inside)), p.decode(inside)
    zero = wanted == 0
    assert np.array_equal(np.signbit(back[zero]), np.signbit(wanted[zero]))


@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", CASES)
def test_what_is_no_number_stays_none(
    case: str, dtype: type, library: Callable[[type], ctypes.CDLL]
) -> None:
    p = made(case)
    assert_none_of_none(run_c(library(dtype), CASES.index(case), p), dtype)
    names: dict[str, Any] = {}
    exec(sm.code(p, "numpy", verbs=["encode"], name="m", dtype=dtype.__name__), names)
    with np.errstate(all="ignore"):
        assert_none_of_none(lambda _, d: names["m_encode"](d), dtype)


REFLECT_LOOP = """
void all_reflect(const {number}* view, const {number}* normal, {number}* out, long n) {{
    for (long i = 0; i < n; i++) m_reflect(view + 3 * i, normal + 3 * i, out + 3 * i);
}}
"""
TAPS_LOOP = """
void all_taps(const {number}* in, const {number}* size, {number}* out, long n) {{
    for (long i = 0; i < n; i++)
        m_taps(in + 3 * i, size, {arrays});
}}
"""


@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
def test_reflect_has_the_bits_of_the_library(dtype: type, tmp_path: Path) -> None:
    view, normal = directions(dtype), np.ascontiguousarray(np.roll(directions(dtype), 7, axis=0))
    wanted = sm.reflect(view, normal)
    number = "float" if dtype is np.float32 else "double"
    options: dict[str, Any] = {"verbs": ["reflect"], "name": "m", "dtype": dtype.__name__}
    text = sm.code("latlong", "c", **options) + REFLECT_LOOP.format(number=number)
    found = np.empty_like(view)
    called(compiled(text, tmp_path).all_reflect, view, normal, found)
    assert same_bits(found, wanted).all()
    names: dict[str, Any] = {}
    exec(sm.code("latlong", "numpy", **options), names)
    assert same_bits(names["m_reflect"](view, normal), wanted).all()


@pytest.mark.runs("cc", language="c")
@pytest.mark.parametrize(("case", "size"), TAPPED)
def test_taps_are_those_of_sample(case: str, size: tuple[int, int], tmp_path: Path) -> None:
    options: dict[str, Any] = {"verbs": ["taps"], "name": "m", "dtype": "float64"}
    n = 16 if made(case).faces > 1 else 12
    arrays = ", ".join(f"out + {n} * i + {k}" for k in range(0, n, 4))
    loop = TAPS_LOOP.format(number="double", arrays=arrays)
    library = compiled(sm.code(made(case), "c", **options) + loop, tmp_path)
    extent = np.array([size[1], size[0]], float)
    by_numpy = numpy_taps(case, size)

    def taps(d: Array) -> Array:
        found = np.empty((len(d), n))
        called(library.all_taps, d, extent, found)
        assert np.array_equal(by_numpy(d), found)
        return found

    assert_taps(case, size, taps, np.float64)


def numpy_taps(case: str, size: tuple[int, int]) -> Callable[[Array], Array]:
    names: dict[str, Any] = {}
    exec(sm.code(made(case), "numpy", verbs=["taps"], name="m", dtype="float64"), names)
    extent = np.array([size[1], size[0]], float)
    return lambda d: np.concatenate(names["m_taps"](d, extent), axis=-1)


CUBES = [(case, size) for case, size in TAPPED if case in ("cross", "strip") or "cube" in case]


@pytest.mark.parametrize(("case", "size"), CUBES)
def test_taps_of_cubes_have_no_seam(case: str, size: tuple[int, int]) -> None:
    """Continuous over every edge and corner, and near `sample` where light changes slowly."""
    p, taps = made(case), numpy_taps(case, size)
    if p.grid != "centers":
        return
    rng = np.random.default_rng(6)
    edge = rng.choice([-1.0, 1.0], (4000, 3))
    rows = np.arange(len(edge))
    edge[rows, rng.integers(0, 3, len(edge))] *= np.linspace(-1, 1, len(edge))
    d = edge / np.linalg.norm(edge, axis=1, keepdims=True)
    image = rng.uniform(size=image_shape(p, size))
    nudge = rng.normal(scale=1e-9, size=d.shape)
    step = np.abs(mixed_by(taps(d + nudge), image) - mixed_by(taps(d - nudge), image))
    # A texel is 2/n of a face, and values are 1 apart at most: 1e-9 makes some n times that.
    assert step.max() <= 1e-9 * 20 * max(size)
    d = np.concatenate([d, directions(np.float64)])
    n = int(np.gcd(*size))
    linear = sm.directions(p, image_shape(p, size)) @ np.array([0.48, 0.6, 0.64])
    linear = np.nan_to_num(linear)
    off = np.abs(mixed_by(taps(d), linear) - sm.sample(linear, d, p))
    # Texels of the same number are up to half a texel apart, and weigh a half at most on the edge.
    assert off.max() <= 0.25 * 2 / n


def test_taps_are_printed_where_texels_join_texels() -> None:
    for name in ("healpix", "sphere", "angular", "icosahedral", "sinusoidal", "dual_paraboloid"):
        with pytest.raises(ValueError, match="no single texel"):
            sm.code(name, "glsl", verbs=["taps"])


@pytest.mark.parametrize("language", [entry["name"] for entry in LANGUAGES])
def test_reflect_and_taps_print_in_every_language(language: str) -> None:
    for case in ("octahedral", "cube", "cross"):
        text = sm.code(made(case), language, verbs=["reflect", "taps"], name="some_name")
        for verb in ("reflect", "taps"):
            assert re.search(rf"\bsome_name_{verb}\(", text)


def test_names_and_options_are_checked() -> None:
    code: Any = sm.code
    for arguments, options, says in [
        (("latlong", "glls"), {}, "did you mean 'glsl'"),
        (("latlong", "glsl"), {"verbs": ["encod"]}, "did you mean 'encode'"),
        (("latlong", "glsl"), {"verbs": []}, "at least one verb"),
        (("latlong", "glsl"), {"name": "1st"}, "a letter"),
        (("latlong", "glsl"), {"name": "gl_map"}, "GLSL's own"),
        (("latlong", "c"), {"name": "webgl_map"}, "GLSL's own"),
        (("latlong", "glsl"), {"name": "a__b"}, "single underscores"),
        (("latlong", "c"), {"name": "union"}, "one that C99 takes"),
        (("latlong", "wgsl"), {"dtype": "float64"}, "64 bits"),
        (("latlong", "glsl"), {"dtype": "float16"}, "did you mean 'float"),
        (("latlong", "glsl"), {"precision": "fast"}, "exact, native"),
        (("latlongs", "glsl"), {}, "did you mean 'latlong'"),
    ]:
        with pytest.raises(ValueError, match=re.escape(says)):
            code(*arguments, **options)
    for options in ({"verbs": "encode"}, {"verbs": 3}, {"name": 3}, {"dtype": np.float32}):
        with pytest.raises(TypeError, match=r"Expected"):
            code("latlong", "glsl", **options)


def test_rotation_turns_the_map_as_it_does_elsewhere() -> None:
    turn = sm.rotation(30, 20, 10)
    turned = sm.projection("octahedral").turned(turn)
    assert sm.code("octahedral", "c", rotation=turn) == sm.code(turned, "c")


def test_only_what_is_used_is_printed() -> None:
    text = sm.code("octahedral", "glsl", verbs=["encode"])
    assert "decode" not in text and "sin_cos" not in text
    assert "sin_cos_pi" in sm.code("latlong", "glsl", verbs=["decode"])


def test_printing_takes_no_time() -> None:
    def took(case: str, language: str) -> float:
        start = time.process_time()
        sm.code(case, language, verbs=VERBS)
        return time.process_time() - start

    for case in [case for case in CASES if case not in ("turned", "cross")]:
        for entry in LANGUAGES:
            # The shortest of three: a process may be held up.
            assert min(took(case, entry["name"]) for _ in range(3)) < 0.05


def test_the_same_text_each_time(tmp_path: Path) -> None:
    first = sm.code("icosahedral", "hlsl", verbs=VERBS)
    assert sm.code("icosahedral", "hlsl", verbs=VERBS) == first
