"""Compute shaders in SPIR-V, run by Vulkan: compushady binds buffers and dispatches.

Its Linux fork `compushady-lrtu` is a wheel; without a graphics card Mesa's lavapipe runs it. What a
shader reads is at binding 1024, what it makes at 2048.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from . import need


@cache
def is_exact() -> bool:
    """Tell whether this is Mesa's renderer: Vulkan lets a graphics card divide less exactly."""
    need("compushady")
    import compushady

    return "llvmpipe" in compushady.get_best_device().name


def run(program: Any, rows: np.ndarray, each: int, dtype: type = np.float32) -> np.ndarray:
    """Return what a shader, whose groups have 64 threads, makes of each row: so many numbers."""
    need("compushady")
    import compushady
    from compushady import formats

    # Typed buffers: those of structures are bound at other lengths than their own.
    words = {np.dtype(np.float32): formats.R32_FLOAT, np.dtype(np.uint32): formats.R32_UINT}
    size = 4 * each * len(rows)
    up = compushady.Buffer(rows.nbytes, compushady.HEAP_UPLOAD)
    up.upload(rows.tobytes())
    source: Any = compushady.Buffer(rows.nbytes, format=words[rows.dtype])
    up.copy_to(source)
    target: Any = compushady.Buffer(size, format=words[np.dtype(dtype)])
    compute = compushady.Compute(program, srv=[source], uav=[target])
    compute.dispatch(-(-len(rows) // 64), 1, 1)
    down = compushady.Buffer(size, compushady.HEAP_READBACK)
    target.copy_to(down)
    return np.frombuffer(down.readback(), dtype, size // 4)
