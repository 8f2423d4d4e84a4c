"""Printed Slang, compiled by slangc, and run as C++ and by Vulkan (`make test-languages`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from oracles import slang_oracle, vulkan_oracle
from printed import (
    CASES,
    PACKINGS,
    TAPPED,
    VERBS,
    Array,
    asked,
    assert_alike,
    assert_native,
    assert_packs_alike,
    assert_taps,
    made,
    roundings,
)

pytestmark = pytest.mark.programs


def vector(width: int) -> str:
    """Return the vector that a row is."""
    parts = ", ".join(f"given[{width} * i + {k}]" for k in range(width))
    return f"float{width}({parts})"


def stores(n: int) -> str:
    """Return what stores a vector as the numbers of a row."""
    return " ".join(f"made[{n} * i + {k}] = r[{k}];" for k in range(n))


def calls(p: sm.Projection) -> dict[str, str]:
    """Return what calls each verb on a row."""
    width = p.encode(np.zeros(3)).shape[-1]
    place = vector(width)
    columns = " ".join(
        f"made[6 * i + {3 * c + k}] = r[{c}][{k}];" for c in range(2) for k in range(3)
    )
    return {
        "encode": f"float{width} r = m_encode({vector(3)}); {stores(width)}",
        "decode": f"float3 r = m_decode({place}); {stores(3)}",
        "density": f"made[i] = m_density({place});",
        "valid": f"made[i] = m_valid({place}) ? 1.0 : 0.0;",
        "jacobian": f"float2x3 r = m_jacobian({place}); {columns}",
    }


def in_one(name: str, out: Array) -> Array:
    return out[:, 0] if name in ("density", "valid") else out


@pytest.mark.runs("slangc, c++", language="slang")
@pytest.mark.parametrize("case", CASES)
def test_slang_as_cpp_has_the_bits_of_the_library(case: str, tmp_path: Path) -> None:
    p = made(case)
    text, of = sm.code(p, "slang", verbs=VERBS, name="m"), calls(p)
    given = {verb: (of[verb], data) for verb, data in asked(p, np.float32).items()}
    found = slang_oracle.as_cpp(text, given, tmp_path, np.float32)
    assert_alike(p, np.float32, lambda name, _: in_one(name, found[name]))


@pytest.mark.runs("slangc, vulkan", language="slang")
@pytest.mark.parametrize("case", CASES)
def test_slang_by_vulkan_has_the_bits_of_the_library(case: str, tmp_path: Path) -> None:
    p = made(case)
    text = sm.code(p, "slang", verbs=VERBS, name="m")
    of = calls(p)

    def verb(name: str, data: Array) -> Array:
        return in_one(name, slang_oracle.as_spirv(text, of[name], data, tmp_path))

    assert_alike(p, np.float32, verb, exact=vulkan_oracle.is_exact())


@pytest.mark.runs("slangc, vulkan", language="slang")
@pytest.mark.parametrize("case", CASES)
def test_slang_by_vulkan_has_functions_of_its_own(case: str, tmp_path: Path) -> None:
    p = made(case)
    text = sm.code(p, "slang", name="m", precision="native")
    call = f"float3 r = m_decode(m_encode({vector(3)})); {stores(3)}"
    assert_native(p, lambda d: slang_oracle.as_spirv(text, call, d, tmp_path))


@pytest.mark.runs("slangc, vulkan", language="slang")
@pytest.mark.parametrize(("case", "size"), TAPPED)
def test_slang_taps(case: str, size: tuple[int, int], tmp_path: Path) -> None:
    text = sm.code(made(case), "slang", verbs=["taps"], name="m")
    names = ["a", "b", "c", "e"][: text.count("out float4")]
    n = 4 * len(names)
    stored = " ".join(
        f"made[{n} * i + {4 * k + c}] = {name}[{c}];"
        for k, name in enumerate(names)
        for c in range(4)
    )
    targets = ", ".join(names)
    extent = f"float2({size[1]}.0, {size[0]}.0)"
    call = f"float4 {targets}; m_taps({vector(3)}, {extent}, {targets}); {stored}"
    assert_taps(case, size, lambda d: slang_oracle.as_spirv(text, call, d, tmp_path))


@pytest.mark.runs("slangc, vulkan", language="slang")
@pytest.mark.parametrize("name", [n for n in PACKINGS if sm.packing.packing(n).bits <= 32])
def test_slang_by_vulkan_has_the_integers_of_packings(name: str, tmp_path: Path) -> None:
    for rounding in roundings(name):
        text = sm.packing.code(name, "slang", rounding=rounding, name="m")

        def run(call: str, rows: Array, dtype: type, text: str = text) -> Array:
            return slang_oracle.as_spirv(text, call, rows, tmp_path, dtype)

        def pack(d: Array) -> Array:
            return run(f"made[i] = m_pack({vector(3)});", d, np.uint32)[:, 0]

        def unpack(words: Array) -> Array:
            call = f"float3 r = m_unpack(given[i]); {stores(3)}"
            return run(call, words.astype(np.uint32), np.float32)

        exact = vulkan_oracle.is_exact()
        assert_packs_alike(name, rounding, np.float32, pack, unpack, exact=exact)


@pytest.mark.runs("slangc, c++", language="slang")
@pytest.mark.parametrize("name", PACKINGS)
def test_slang_as_cpp_has_the_integers_of_packings(name: str, tmp_path: Path) -> None:
    word = np.uint32 if sm.packing.packing(name).bits <= 32 else np.uint64
    for rounding in roundings(name):
        text = sm.packing.code(name, "slang", rounding=rounding, name="m")

        def run(call: str, rows: Array, dtype: type, text: str = text) -> Array:
            return slang_oracle.as_cpp(text, {"all": (call, rows)}, tmp_path, dtype)["all"]

        def pack(d: Array) -> Array:
            return run(f"made[i] = m_pack({vector(3)});", d, word)[:, 0]

        def unpack(words: Array) -> Array:
            return run(
                f"float3 r = m_unpack(given[i]); {stores(3)}", words.astype(word), np.float32
            )

        assert_packs_alike(name, rounding, np.float32, pack, unpack)


EFFECTS = {
    "sphere_map": "m_color(m_vertex(d, d))",
    "matcap": "m_color(d)",
    "light_probe": "m_color(d)",
    "mirror_balls": "m_color(d)",
    "gbuffer": "float4(m_unpack(m_pack(d)), 1.0)",
}
STAGE = """
[shader("fragment")]
float4 main(float3 d : TEXCOORD0) : SV_Target {{ return {call}; }}
"""


@pytest.mark.parametrize("effect", EFFECTS)
def test_slang_compiles_effects(effect: str, tmp_path: Path) -> None:
    text = sm.effect(effect, "slang", name="m") + STAGE.format(call=EFFECTS[effect])
    options = ("-O0", "-entry", "main", "-stage", "fragment")
    assert slang_oracle.compiled(text, tmp_path, "spirv", *options).stat().st_size > 0
    assert "m_" in slang_oracle.compiled(text, tmp_path, "metal", *options).read_text()


# Opcodes of SPIR-V: OpDecorate, and its NoContraction.
DECORATE, NO_CONTRACTION = 71, 42


@pytest.mark.parametrize(("mode", "kept"), [("precise", True), ("default", False)])
def test_precise_is_kept_where_the_compiler_is_told(mode: str, kept: bool, tmp_path: Path) -> None:
    """What docs/languages.md says of SPIR-V: without the option nothing is held together."""
    text = sm.code("latlong", "slang", verbs=["encode"], name="m")
    stage = """
[shader("fragment")]
float4 main(float3 d : TEXCOORD0) : SV_Target { return float4(m_encode(d), 0.0, 1.0); }
"""
    options = ("-O0", "-fp-mode", mode, "-entry", "main", "-stage", "fragment")
    binary = slang_oracle.compiled(text + stage, tmp_path, "spirv", *options).read_bytes()
    words = np.frombuffer(binary, np.uint32)
    at, found = 5, 0
    while at < len(words):
        length, opcode = int(words[at]) >> 16, int(words[at]) & 0xFFFF
        found += opcode == DECORATE and int(words[at + 2]) == NO_CONTRACTION
        at += length
    assert (found > 20) == kept and (found == 0) != kept
