"""What printed code costs a graphics card, beside what people write by hand: counted in SPIR-V.

`make test-languages`; glslangValidator and spirv-opt are packages of most systems.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import spheremap as sm

pytestmark = pytest.mark.programs

SHADER = """#version 450
layout(location = 0) in vec2 place;
layout(location = 0) out vec3 made;
{text}
void main() {{ made = m_decode(place); }}
"""
# The decoder that is usually copied: Cigolle et al. 2014, as shortened by Rune Stubbe in 2017.
BY_HAND = """
vec3 m_decode(vec2 f) {
    f = f * 2.0 - 1.0;
    vec3 n = vec3(f.x, f.y, 1.0 - abs(f.x) - abs(f.y));
    float t = clamp(-n.z, 0.0, 1.0);
    n.x += n.x >= 0.0 ? -t : t;
    n.y += n.y >= 0.0 ? -t : t;
    return normalize(n);
}
"""
# As the survey prints it.
SURVEY = """
vec2 sign_not_zero(vec2 v) {
    return vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0);
}
vec3 m_decode(vec2 f) {
    vec2 e = f * 2.0 - 1.0;
    vec3 v = vec3(e.xy, 1.0 - abs(e.x) - abs(e.y));
    if (v.z < 0.0) v.xy = (1.0 - abs(v.yx)) * sign_not_zero(v.xy);
    return normalize(v);
}
"""
# Three squares, two sums, the reciprocal of the root, three products.
NORMALIZE = 9
ARITHMETIC = re.compile(
    r"= Op(F(?:Add|Sub|Mul|Div|Negate|Ord\w+|Unord\w+)|Select|VectorTimesScalar) (%\w+)"
)
CALL = re.compile(r"= OpExtInst (%\w+) %\w+ (\w+)")


def operations(text: str, folder: Path) -> int:
    """Return the operations on single numbers of a decoder, once it is optimized."""
    tools = [shutil.which(tool) for tool in ("glslangValidator", "spirv-opt", "spirv-dis")]
    if None in tools:
        pytest.skip("glslangValidator or spirv-opt was not found")
    glslang, optimizer, disassembler = map(str, tools)
    source, binary = folder / "decode.frag", folder / "decode.spv"
    source.write_text(SHADER.format(text=text))
    subprocess.run([glslang, "-V", source, "-o", binary], check=True, capture_output=True)
    subprocess.run([optimizer, "-O", binary, "-o", binary], check=True)
    said = subprocess.run([disassembler, binary], check=True, capture_output=True, text=True).stdout

    def numbers(kind: str) -> int:
        return int(found[1]) if (found := re.search(r"v(\d)", kind)) else 1

    count = sum(numbers(kind) for _, kind in ARITHMETIC.findall(said))
    for kind, name in CALL.findall(said):
        count += NORMALIZE if name == "Normalize" else numbers(kind)
    return count


def test_octahedral_decode_costs_what_is_written_by_hand(tmp_path: Path) -> None:
    ours = operations(sm.code("octahedral", "glsl", verbs=["decode"], name="m"), tmp_path)
    by_hand, survey = (operations(text, tmp_path) for text in (BY_HAND, SURVEY))
    print(f"octahedral decode: {ours} operations, by hand {by_hand}, of the survey {survey}")
    assert ours <= by_hand <= survey
