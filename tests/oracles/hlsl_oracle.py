"""HLSL by Microsoft's compiler, DXC, run by Vulkan: compushady has both.

Its Linux fork `compushady-lrtu` is a wheel; without a graphics card Mesa's lavapipe runs it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import need

# Typed buffers: those of structures are bound at other lengths than their own.
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
    import compushady
    from compushady import formats
    from compushady.shaders import hlsl

    words = {"float": formats.R32_FLOAT, "uint": formats.R32_UINT}
    takes, gives = NAMES[rows.dtype], NAMES[np.dtype(dtype)]
    size = 4 * call.count("made[") * len(rows)
    up = compushady.Buffer(rows.nbytes, compushady.HEAP_UPLOAD)
    up.upload(rows.tobytes())
    source: Any = compushady.Buffer(rows.nbytes, format=words[takes])
    up.copy_to(source)
    target: Any = compushady.Buffer(size, format=words[gives])
    shader = SHADER.format(text=text, takes=takes, gives=gives, count=len(rows), call=call)
    program = compushady.Compute(hlsl.compile(shader), srv=[source], uav=[target])
    program.dispatch(-(-len(rows) // 64), 1, 1)
    down = compushady.Buffer(size, compushady.HEAP_READBACK)
    target.copy_to(down)
    return np.frombuffer(down.readback(), dtype, size // 4)
