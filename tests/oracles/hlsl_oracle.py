"""HLSL by Microsoft's compiler, DXC, which compushady has, run by Vulkan."""

from __future__ import annotations

import numpy as np

from . import need, vulkan_oracle

SHADER = """
{text}
Buffer<{takes}> given : register(t0);
RWBuffer<{gives}> made : register(u0);
[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {{
    uint i = id.x;
    if (i >= {count}u) return;
    {call}
}}
"""
NAMES = {np.dtype(np.float32): "float", np.dtype(np.uint32): "uint"}


def run(text: str, call: str, rows: np.ndarray, dtype: type = np.float32) -> np.ndarray:
    """Return what a call of printed code makes of each row, as many numbers as it stores."""
    need("compushady")
    from compushady.shaders import hlsl

    takes, gives = NAMES[rows.dtype], NAMES[np.dtype(dtype)]
    shader = SHADER.format(text=text, takes=takes, gives=gives, count=len(rows), call=call)
    return vulkan_oracle.run(hlsl.compile(shader), rows, call.count("made["), dtype)
