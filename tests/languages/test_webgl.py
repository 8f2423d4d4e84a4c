"""Printed GLSL ES, run by WebGL 2 in Chromium (`make test-browser`)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from browser import launched
from oracles import webgl_oracle
from printed import CASES, VERBS, Array, assert_alike, directions, made

pytestmark = pytest.mark.programs

SHADER = """#version 300 es
{text}
uniform highp sampler2D given;
layout(location = 0) out vec4 first;
layout(location = 1) out vec4 second;
void main() {{
    vec4 row = texelFetch(given, ivec2(gl_FragCoord.xy), 0);
    first = second = vec4(0.0);
    {call}
}}
"""


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

    def verb(name: str, data: Array) -> Array:
        call, n = of[name]
        out = webgl_oracle.run(page, SHADER.format(text=text, call=call), data)
        if name == "jacobian":
            return np.ascontiguousarray(out[:, [0, 1, 2, 4, 5, 6]])
        return out[:, 0] if n == 1 else np.ascontiguousarray(out[:, :n])

    assert len(directions(np.float32)) > 20_000
    assert_alike(p, np.float32, verb, exact=False)


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
    shader = SHADER.format(text=text, call=f"first = {CALLS[effect]};")
    assert webgl_oracle.run(page, shader, directions(np.float32)).shape[1] == 8
