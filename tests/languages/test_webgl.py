"""Printed GLSL ES, run by WebGL 2 in Chromium (`make test-printed`)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from browser import launched
from oracles import webgl_oracle
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
    assert_sums_alike,
    assert_taps,
    directions,
    made,
    roundings,
)

pytestmark = [pytest.mark.programs, pytest.mark.runs("webgl", language="glsl_es")]

SHADER = """#version 300 es
{text}
uniform highp sampler2D given;
uniform int verb;
{targets}
void main() {{
    vec4 row = texelFetch(given, ivec2(gl_FragCoord.xy), 0);
    {call}
}}
"""
NAMES = ("first", "second", "third", "fourth")


def shader(text: str, call: str) -> str:
    """Return a shader that runs a call of printed code; it has the targets that the call names."""
    names = [name for name in NAMES if name in call]
    targets = [f"layout(location = {k}) out vec4 {name};" for k, name in enumerate(names)]
    begin = " ".join(f"{name} = vec4(0.0);" for name in names)
    return SHADER.format(text=text, targets="\n".join(targets), call=f"{begin} {call}")


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    with launched() as browser:
        yield browser.new_page()


@pytest.mark.parametrize("case", CASES)
def test_webgl_is_within_the_bounds(case: str, page: Any) -> None:
    p = made(case)
    width = p.encode(np.zeros(3)).shape[-1]
    place = "row.xy" if width == 2 else "row.xyz"
    text = sm.code(p, "glsl_es", verbs=VERBS, name="m")
    of = {
        "encode": (f"first.{'xyz'[:width]} = m_encode(row.xyz);", width),
        "decode": (f"first.xyz = m_decode({place});", 3),
        "density": (f"first.x = m_density({place});", 1),
        "valid": (f"first.x = m_valid({place}) ? 1.0 : 0.0;", 1),
        "jacobian": (f"mat2x3 r = m_jacobian({place}); first.xyz = r[0]; second.xyz = r[1];", 6),
    }
    # One program, as what is slow is its compiler.
    call = " ".join(f"if (verb == {k}) {{ {of[verb][0]} }}" for k, verb in enumerate(VERBS))
    given = asked(p, np.float32)
    found = webgl_oracle.run(page, shader(text, call), [given[verb] for verb in VERBS])

    def verb(name: str, _: Array) -> Array:
        out, n = found[VERBS.index(name)], of[name][1]
        if name == "jacobian":
            return np.ascontiguousarray(out[:, [0, 1, 2, 4, 5, 6]])
        return out[:, 0] if n == 1 else np.ascontiguousarray(out[:, :n])

    assert len(given["encode"]) > 20_000
    assert_alike(p, np.float32, verb, exact=False)


@pytest.mark.parametrize("case", CASES)
def test_webgl_has_functions_of_its_own(case: str, page: Any) -> None:
    p = made(case)
    text = sm.code(p, "glsl_es", name="m", precision="native")
    source = shader(text, "first.xyz = m_decode(m_encode(row.xyz));")
    assert_native(p, lambda d: webgl_oracle.run(page, source, [d])[0][:, :3])


def test_webgl_reflects(page: Any) -> None:
    text = sm.code("latlong", "glsl_es", verbs=["reflect"], name="m")
    view = directions(np.float32)
    # Its numbers in another order are a normal.
    call = "first.xyz = m_reflect(row.xyz, row.yzx);"
    (found,) = webgl_oracle.run(page, shader(text, call), [view])
    # A dozen roundings of numbers up to 2.
    few = 24 * float(np.finfo(np.float32).eps)
    wanted = sm.reflect(view, np.ascontiguousarray(view[:, [1, 2, 0]]))
    assert np.abs(found[:, :3] - wanted).max() <= few


@pytest.mark.parametrize(("case", "size"), TAPPED)
def test_webgl_taps(case: str, size: tuple[int, int], page: Any) -> None:
    text = sm.code(made(case), "glsl_es", verbs=["taps"], name="m")
    names = NAMES[: text.count("out vec4")]
    call = f"m_taps(row.xyz, vec2({size[1]}.0, {size[0]}.0), {', '.join(names)});"
    source = shader(text, call)
    assert_taps(case, size, lambda d: webgl_oracle.run(page, source, [d])[0])


@pytest.mark.parametrize("name", [n for n in PACKINGS if sm.packing.packing(n).bits <= 32])
def test_webgl_packs(name: str, page: Any) -> None:
    for rounding in roundings(name):
        text = sm.packing.code(name, "glsl_es", rounding=rounding, name="m")
        pack_call = "uint w = m_pack(row.xyz); "
        pack_call += "first.xy = vec2(float(w & 65535u), float(w >> 16u));"
        word = "uint(row.x) | (uint(row.y) << 16u)"
        packs, unpacks = shader(text, pack_call), shader(text, f"first.xyz = m_unpack({word});")

        def pack(d: Array, source: str = packs) -> Array:
            low, high = webgl_oracle.run(page, source, [d])[0][:, :2].astype(np.uint32).T
            return low | high << 16

        def unpack(words: Array, source: str = unpacks) -> Array:
            halves = np.stack([words & 65535, words >> 16], axis=1).astype(np.float32)
            return np.ascontiguousarray(webgl_oracle.run(page, source, [halves])[0][:, :3])

        assert_packs_alike(name, rounding, np.float32, pack, unpack, exact=False)


@pytest.mark.parametrize("channels", [1, 3])
def test_webgl_sums_harmonics(channels: int, page: Any) -> None:
    call = "first.xyz = vec3(m_evaluate(row.xyz));"

    def run(text: str, d: Array) -> Array:
        return webgl_oracle.run(page, shader(text, call), [d])[0][:, :channels]

    assert_sums_alike("glsl_es", channels, run)


CALLS = {
    "sphere_map": "m_color(m_vertex(row.xyz, row.xyz))",
    "matcap": "m_color(row.xyz)",
    "light_probe": "m_color(row.xyz)",
    "mirror_balls": "m_color(row.xyz)",
    "gbuffer": "vec4(m_unpack(m_pack(row.xyz)), 1.0)",
}


@pytest.mark.parametrize("effect", CALLS)
def test_webgl_compiles_effects(effect: str, page: Any) -> None:
    text = sm.effect(effect, "glsl_es", name="m")
    source = shader(text, f"first = {CALLS[effect]};")
    webgl_oracle.run(page, source, [directions(np.float32)[:256]])
