"""Printed GLSL ES in a shader whose own numbers are of 16 bits, compiled to SPIR-V.

`make test-languages`; glslangValidator and spirv-dis are packages of most systems.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from printed import CASES, VERBS, made

pytestmark = pytest.mark.programs

# Arguments and results are the program's own: what is stored in 16 bits is lost before or after.
SHADER = """#version 310 es
precision mediump float;
{text}
layout(location = 0) in highp vec3 d;
layout(location = 0) out highp vec4 first;
layout(location = 1) out highp vec4 second;
void main() {{
    {encode}
    highp mat2x3 j = m_jacobian({place});
    first = vec4(m_decode({place}), m_density({place}));
    second = vec4(j[0] + j[1], m_valid({place}) ? 1.0 : 0.0);
}}
"""


def relaxed(text: str, width: int, folder: Path) -> int:
    """Return how many results of a shader may have 16 bits."""
    tools = [shutil.which(tool) for tool in ("glslangValidator", "spirv-dis")]
    if None in tools:
        pytest.skip("glslangValidator or spirv-dis was not found")
    glslang, disassembler = map(str, tools)
    source, binary = folder / "shader.frag", folder / "shader.spv"
    kind = f"highp vec{width}"
    shader = SHADER.format(text=text, encode=f"{kind} place = m_encode(d);", place="place")
    source.write_text(shader)
    subprocess.run([glslang, "-V", source, "-o", binary], check=True, capture_output=True)
    said = subprocess.run([disassembler, binary], check=True, capture_output=True, text=True)
    return said.stdout.count("RelaxedPrecision")


@pytest.mark.parametrize("case", CASES)
def test_numbers_keep_their_bits_in_a_program_of_mediump(case: str, tmp_path: Path) -> None:
    p = made(case)
    text = sm.code(p, "glsl_es", verbs=VERBS, name="m")
    width = p.encode(np.zeros(3)).shape[-1]
    assert relaxed(text, width, tmp_path) == 0
    without = text.replace("precision highp float;", "")
    assert relaxed(without, width, tmp_path) > 10
