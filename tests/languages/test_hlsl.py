"""Printed HLSL, compiled by DXC and run by Vulkan (`make test-languages`)."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from oracles import hlsl_oracle, need, vulkan_oracle
from printed import (
    CASES,
    PACKINGS,
    VERBS,
    Array,
    assert_alike,
    assert_native,
    assert_packs_alike,
    made,
    roundings,
)

pytestmark = [pytest.mark.programs, pytest.mark.runs("dxc", language="hlsl")]

DIRECTION = "float3(given[3 * i], given[3 * i + 1], given[3 * i + 2])"


def stores(n: int) -> str:
    """Return what stores a vector as the numbers of a row."""
    return " ".join(f"made[{n} * i + {k}] = r[{k}];" for k in range(n))


@pytest.mark.parametrize("case", CASES)
def test_dxc_has_the_bits_of_the_library(case: str) -> None:
    p = made(case)
    text = sm.code(p, "hlsl", verbs=VERBS, name="m")
    width = p.encode(np.zeros(3)).shape[-1]
    parts = ", ".join(f"given[{width} * i + {k}]" for k in range(width))
    place = f"float{width}({parts})"
    columns = " ".join(
        f"made[6 * i + {3 * c + k}] = r[{c}][{k}];" for c in range(2) for k in range(3)
    )
    of = {
        "encode": (f"float{width} r = m_encode({DIRECTION}); {stores(width)}", width),
        "decode": (f"float3 r = m_decode({place}); {stores(3)}", 3),
        "density": (f"made[i] = m_density({place});", 1),
        "valid": (f"made[i] = m_valid({place}) ? 1.0 : 0.0;", 1),
        "jacobian": (f"float2x3 r = m_jacobian({place}); {columns}", 6),
    }

    def verb(name: str, data: Array) -> Array:
        call, n = of[name]
        out = hlsl_oracle.run(text, call, data).reshape(-1, n)
        return out[:, 0] if n == 1 else out

    assert_alike(p, np.float32, verb, exact=vulkan_oracle.is_exact())


@pytest.mark.parametrize("case", CASES)
def test_dxc_has_functions_of_its_own(case: str) -> None:
    p = made(case)
    text = sm.code(p, "hlsl", name="m", precision="native")
    call = f"float3 r = m_decode(m_encode({DIRECTION})); {stores(3)}"
    assert_native(p, lambda d: hlsl_oracle.run(text, call, d).reshape(-1, 3))


CALLS = {
    "sphere_map": "m_color(m_vertex(d, d))",
    "matcap": "m_color(d)",
    "light_probe": "m_color(d)",
    "mirror_balls": "m_color(d)",
    "gbuffer": "float4(m_unpack(m_pack(d)), 1.0)",
}


@pytest.mark.parametrize("effect", CALLS)
def test_dxc_compiles_effects(effect: str) -> None:
    need("compushady")
    from compushady.shaders import hlsl

    text = sm.effect(effect, "hlsl", name="m")
    stage = f"float4 main(float3 d : TEXCOORD0) : SV_Target {{ return {CALLS[effect]}; }}"
    assert hlsl.compile(f"{text}\n{stage}", "main", "ps_6_0")


@pytest.mark.parametrize("name", [n for n in PACKINGS if sm.packing.packing(n).bits <= 32])
def test_dxc_has_the_integers_of_packings(name: str) -> None:
    for rounding in roundings(name):
        text = sm.packing.code(name, "hlsl", rounding=rounding, name="m")

        def pack(d: Array, text: str = text) -> Array:
            return hlsl_oracle.run(text, f"made[i] = m_pack({DIRECTION});", d, np.uint32)

        def unpack(words: Array, text: str = text) -> Array:
            call = f"float3 r = m_unpack(given[i]); {stores(3)}"
            return hlsl_oracle.run(text, call, words.astype(np.uint32)).reshape(-1, 3)

        exact = vulkan_oracle.is_exact()
        assert_packs_alike(name, rounding, np.float32, pack, unpack, exact=exact)
