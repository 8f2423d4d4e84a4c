"""Printed code, run: GLSL by OpenGL, dialects of C++ by a C++ compiler."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from printed import (
    CASES,
    PACKINGS,
    TAPPED,
    VERBS,
    Array,
    assert_alike,
    assert_native,
    assert_none_of_none,
    assert_packs_alike,
    assert_taps,
    called,
    compiled,
    directions,
    made,
    mixed_by,
    roundings,
)

from oracles import opengl_oracle

SHADER = """#version 430
{text}
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer In {{ {takes} given[]; }};
layout(std430, binding = 1) buffer Out {{ {gives} made[]; }};
uniform uint count;
void main() {{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    {call}
}}
"""


def calls(width: int, vector: str, matrix: str) -> dict[str, tuple[str, int]]:
    """Return what calls each verb on numbers in a row, and how many numbers it gives."""
    direction = f"{vector}3(given[3 * i], given[3 * i + 1], given[3 * i + 2])"
    parts = ", ".join(f"given[{width} * i + {k}]" for k in range(width))
    place = f"{vector}{width}({parts})"
    store = "made[{n} * i + {k}] = r.{c};"

    def stores(n: int) -> str:
        return " ".join(store.format(n=n, k=k, c="xyz"[k]) for k in range(n))

    columns = " ".join(
        f"made[6 * i + {3 * column + row}] = r[{column}][{row}];"
        for column in range(2)
        for row in range(3)
    )
    return {
        "encode": (f"{vector}{width} r = m_encode({direction}); {stores(width)}", width),
        "decode": (f"{vector}3 r = m_decode({place}); {stores(3)}", 3),
        "density": (f"made[i] = m_density({place});", 1),
        "valid": (f"made[i] = m_valid({place}) ? 1.0 : 0.0;", 1),
        "jacobian": (f"{matrix} r = m_jacobian({place}); {columns}", 6),
    }


NAMES = {np.dtype(np.float32): "float", np.dtype(np.uint32): "uint"}


def run_shader(text: str, call: str, data: Array, dtype: type) -> Array:
    """Return what a call of printed code makes of each row, as many numbers as it stores."""
    gl = opengl_oracle.context()
    takes, gives = NAMES[data.dtype], NAMES[np.dtype(dtype)]
    shader = gl.compute_shader(SHADER.format(text=text, call=call, takes=takes, gives=gives))
    shader["count"] = len(data)
    each = call.count("made[")
    source = gl.buffer(data.tobytes())
    target = gl.buffer(reserve=4 * each * len(data))
    source.bind_to_storage_buffer(0)
    target.bind_to_storage_buffer(1)
    shader.run(-(-len(data) // 64))
    return np.frombuffer(target.read(), dtype)


@pytest.mark.runs("opengl", language="glsl")
@pytest.mark.parametrize("case", CASES)
def test_opengl_has_the_bits_of_the_library(case: str) -> None:
    p = made(case)
    text = sm.code(p, "glsl", verbs=VERBS, name="m")
    of = calls(p.encode(np.zeros(3)).shape[-1], "vec", "mat2x3")

    def verb(name: str, data: Array) -> Array:
        call, width = of[name]
        out = run_shader(text, call, data, np.float32).reshape(-1, width)
        return out[:, 0] if width == 1 else out

    assert_alike(p, np.float32, verb, exact=opengl_oracle.is_exact())


DIRECTION = "vec3(given[3 * i], given[3 * i + 1], given[3 * i + 2])"
STORE = "made[3 * i] = r.x; made[3 * i + 1] = r.y; made[3 * i + 2] = r.z;"


@pytest.mark.runs("opengl", language="glsl")
@pytest.mark.parametrize("case", CASES)
def test_opengl_has_functions_of_its_own(case: str) -> None:
    p = made(case)
    text = sm.code(p, "glsl", name="m", precision="native")
    call = f"vec3 r = m_decode(m_encode({DIRECTION})); {STORE}"
    assert_native(p, lambda d: run_shader(text, call, d, np.float32).reshape(-1, 3))


def test_the_arctangent_of_a_renderer_is_not_ours() -> None:
    """What docs/languages.md says of `precision="native"`: twenty roundings, wrong at the poles."""
    opengl_oracle.need_exact()
    d = directions(np.float32)
    d = d[(d[:, 0] != 0) | (d[:, 1] != 0)]
    found = run_shader("", "made[i] = atan(abs(given[3 * i]), given[3 * i + 1]);", d, np.float32)
    off = np.abs(found - np.arctan2(np.abs(d[:, 0].astype(float)), d[:, 1].astype(float)))
    # Near twenty, as the page says; 18.9 were measured.
    assert 15 < off.max() / (2.0**-24 * np.pi) < 25
    poles = np.array([[0, 1, 0], [0, -1, 0]], np.float32)
    call = f"vec2 r = m_encode({DIRECTION}); made[2 * i] = r.x; made[2 * i + 1] = r.y;"
    for precision, in_middle in (("exact", True), ("native", False)):
        text = sm.code("latlong", "glsl", verbs=["encode"], name="m", precision=precision)
        u, v = run_shader(text, call, poles, np.float32).reshape(-1, 2).T
        assert v.tolist() == [0, 1] and ((u == 0.5) == in_middle).all()


@pytest.mark.runs("opengl", language="glsl")
@pytest.mark.parametrize("name", [n for n in PACKINGS if sm.packing.packing(n).bits <= 32])
def test_opengl_has_the_integers_of_packings(name: str) -> None:
    opengl_oracle.need_exact()
    for rounding in roundings(name):
        text = sm.packing.code(name, "glsl", rounding=rounding, name="m")

        def pack(d: Array, text: str = text) -> Array:
            return run_shader(text, f"made[i] = m_pack({DIRECTION});", d, np.uint32)

        def unpack(words: Array, text: str = text) -> Array:
            call = f"vec3 r = m_unpack(given[i]); {STORE}"
            return run_shader(text, call, words.astype(np.uint32), np.float32).reshape(-1, 3)

        assert_packs_alike(name, rounding, np.float32, pack, unpack)


@pytest.mark.runs("opengl", language="glsl")
@pytest.mark.parametrize(("case", "size"), TAPPED)
def test_opengl_fetches_what_sample_mixes(case: str, size: tuple[int, int]) -> None:
    text = sm.code(made(case), "glsl", verbs=["taps"], name="m")
    extent = f"vec2({size[1]}.0, {size[0]}.0)"
    names = ["a", "b", "c", "e"][: text.count("out vec4")]
    n = 4 * len(names)
    stores = " ".join(
        f"made[{n} * i + {4 * k + c}] = {name}[{c}];"
        for k, name in enumerate(names)
        for c in range(4)
    )
    targets = ", ".join(names)
    call = f"vec4 {targets}; m_taps({DIRECTION}, {extent}, {targets}); {stores}"
    assert_taps(case, size, lambda d: run_shader(text, call, d, np.float32).reshape(-1, n))


@pytest.mark.parametrize("n", [1, 2, 5, 16])
def test_opengl_samples_a_cube_by_the_same_taps(n: int) -> None:
    """A seamless sampler, over edges and at corners."""
    opengl_oracle.need_exact()
    d = directions(np.float32)
    image = np.random.default_rng(1).uniform(size=(6, n, n, 1)).astype(np.float32)
    wanted = opengl_oracle.sample(image.repeat(4, axis=-1), d, lod=np.zeros(len(d)))[:, 0]
    names: dict[str, Any] = {}
    exec(sm.code("cube", "numpy", verbs=["taps"], name="m"), names)
    found = np.concatenate(names["m_taps"](d, np.float32([n, n])), axis=-1)
    # As above, of a side of n.
    rounding = 16 * n * float(np.finfo(np.float32).eps)
    assert np.abs(mixed_by(found, image[..., 0]) - wanted).max() <= rounding


@pytest.mark.runs("opengl", language="glsl")
@pytest.mark.parametrize("channels", [1, 3])
def test_opengl_sums_harmonics(channels: int) -> None:
    c = np.random.default_rng(2).normal(size=(25, channels))
    d = directions(np.float32)
    call = f"vec3 r = vec3(m_evaluate({DIRECTION})); {STORE}"
    found = run_shader(sm.sh.code(c, "glsl", name="m"), call, d, np.float32).reshape(-1, 3)
    # As in tests/light/test_sh_code.py: ten roundings a degree, of terms up to √(9/4π) times |c|.
    bound = 10 * 5 * 0.85 * np.abs(c).sum(axis=0).max() * float(np.finfo(np.float32).eps)
    assert np.abs(found[:, :channels] - sm.sh.evaluate(c, d)).max() <= bound


# What makes C++ of a language: its vectors, its names of functions, its qualifiers. The printed
# text itself is compiled as it is.
SHIM = """
#include <cmath>
#include <cstdint>
#include <cstring>
#define precise
#define __host__
#define __device__
typedef unsigned int uint;
typedef unsigned long ulong;
struct float2 { float x, y; float2(float a, float b) : x(a), y(b) {} };
struct float3 {
    float x, y, z;
    float3() {}
    float3(float a, float b, float c) : x(a), y(b), z(c) {}
    float operator[](int k) const { return k == 0 ? x : k == 1 ? y : z; }
};
struct float2x3 {
    float3 rows[2];
    float2x3(float3 a, float3 b) { rows[0] = a; rows[1] = b; }
    float2x3(float a, float b, float c, float d, float e, float f) {
        rows[0] = float3(a, b, c); rows[1] = float3(d, e, f);
    }
    const float3& operator[](int k) const { return rows[k]; }
};
using std::abs; using std::sqrt; using std::floor; using std::ldexp; using std::ilogb;
static inline float2 make_float2(float a, float b) { return float2(a, b); }
static inline float3 make_float3(float a, float b, float c) { return float3(a, b, c); }
static inline float asfloat(int32_t x) { float y; std::memcpy(&y, &x, 4); return y; }
static inline int32_t asint(float x) { int32_t y; std::memcpy(&y, &x, 4); return y; }
static inline float min(float a, float b) { return b < a ? b : a; }
static inline float max(float a, float b) { return b > a ? b : a; }
"""
DIALECTS = {
    # HLSL rounds halves to even.
    "hlsl": "static inline float round(float x) { return std::rint(x); }\n",
    "cuda": "",
    # Functions of floats, which the header of Metal would bring.
    "msl": "using std::fabs; using std::rint;\n",
}


@pytest.fixture(scope="session")
def dialect(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], ctypes.CDLL]:
    """Return every case of a language as one library."""

    @cache
    def build(language: str) -> ctypes.CDLL:
        parts = [SHIM, DIALECTS[language]]
        for k, case in enumerate(CASES):
            p = made(case)
            text = sm.code(p, language, verbs=VERBS, name=f"m{k}")
            text = text.replace("#include <metal_stdlib>\nusing namespace metal;", "")
            parts.append(text)
            of = calls(p.encode(np.zeros(3)).shape[-1], "float", "float2x3")
            if language == "cuda":
                place = of["density"][0].removeprefix("made[i] = m_density(").removesuffix(");")
                columns = of["jacobian"][0].partition("; ")[2]
                call = f"float3 r[2]; m_jacobian({place}, &r[0], &r[1]); {columns}"
                of["jacobian"] = (call, 6)
            for verb, (call, _) in of.items():
                named = call.replace(" m_", f" m{k}_")
                parts.append(
                    f'extern "C" void all{k}_{verb}(const float* given, float* made, long n) {{\n'
                    f"    for (long i = 0; i < n; i++) {{ {named} }}\n}}\n"
                )
        return compiled("\n".join(parts), tmp_path_factory.mktemp(language), cpp=True)

    return build


@pytest.mark.runs("c++")
@pytest.mark.slow
@pytest.mark.parametrize("language", DIALECTS)
def test_dialects_of_cpp_have_the_bits_of_the_library(
    language: str, dialect: Callable[[str], ctypes.CDLL]
) -> None:
    library = dialect(language)
    for k, case in enumerate(CASES):
        p = made(case)
        of = calls(p.encode(np.zeros(3)).shape[-1], "float", "float2x3")

        def verb(name: str, data: Array, k: int = k, of: dict[str, tuple[str, int]] = of) -> Array:
            width = of[name][1]
            out = np.empty((len(data), width), np.float32)
            called(library[f"all{k}_{name}"], data, out)
            return out[:, 0] if width == 1 else out

        assert_alike(p, np.float32, verb)
        if language == "cuda":
            assert_none_of_none(verb, np.float32)


@pytest.mark.runs("c++")
@pytest.mark.slow
@pytest.mark.parametrize("language", DIALECTS)
def test_dialects_of_cpp_have_the_integers_of_packings(language: str, tmp_path: Path) -> None:
    names = [n for n in PACKINGS if language != "hlsl" or sm.packing.packing(n).bits <= 32]
    cases = [(name, rounding) for name in names for rounding in roundings(name)]
    parts = [SHIM, DIALECTS[language]]
    for k, (name, rounding) in enumerate(cases):
        text = sm.packing.code(name, language, rounding=rounding, name=f"m{k}")
        parts.append(text.replace("#include <metal_stdlib>\nusing namespace metal;", ""))
        direction = "float3(given[3 * i], given[3 * i + 1], given[3 * i + 2])"
        loop = "{ for (long i = 0; i < n; i++) {"
        parts.append(
            f'extern "C" void pack{k}(const float* given, uint64_t* made, long n) {loop} '
            f"made[i] = m{k}_pack({direction}); }} }}\n"
            f'extern "C" void unpack{k}(const uint64_t* given, float* made, long n) {loop} '
            f"float3 r = m{k}_unpack(given[i]); {STORE} }} }}\n"
        )
    library = compiled("\n".join(parts), tmp_path, cpp=True)

    for k, (name, rounding) in enumerate(cases):

        def pack(d: Array, k: int = k) -> Array:
            return called(library[f"pack{k}"], d, np.empty(len(d), np.uint64))

        def unpack(words: Array, k: int = k) -> Array:
            return called(library[f"unpack{k}"], words, np.empty((len(words), 3), np.float32))

        assert_packs_alike(name, rounding, np.float32, pack, unpack)
