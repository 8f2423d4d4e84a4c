"""The samplers of OpenGL, as Mesa's software renderer or a graphics card runs them.

A compute shader looks up with `textureLod` or `textureGrad`, in textures of 32-bit floats whose
levels OpenGL makes. Mesa's renderer is asked for a level for each lookup; by default four share
one. Its logarithm of a length is half of a linear stand-in for that of the square, exact at powers
of 2 and off by at most 0.044.
"""

from __future__ import annotations

import os
from functools import cache
from typing import Any

import numpy as np
import pytest

from oracles import need

Array = np.ndarray

# Read by Mesa when its driver is loaded.
os.environ.setdefault("EGL_PLATFORM", "surfaceless")
os.environ.setdefault("GALLIVM_PERF", "no_quad_lod")

SHADER = """
#version 430
layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer In { vec4 given[]; };
layout(std430, binding = 1) buffer Out { vec4 seen[]; };
uniform %(sampler)s image;
void main() {
    uint k = gl_GlobalInvocationID.x;
    vec4 place = given[3u * k], right = given[3u * k + 1u], down = given[3u * k + 2u];
    seen[k] = %(call)s;
}
"""
CALLS = {
    ("lod", 2): "textureLod(image, place.xy, place.w)",
    ("derivatives", 2): "textureGrad(image, place.xy, right.xy, down.xy)",
    ("lod", 3): "textureLod(image, place.xyz, place.w)",
    ("derivatives", 3): "textureGrad(image, place.xyz, right.xyz, down.xyz)",
}


# What the levels that Mesa takes are off.
ROUGH = 0.044

# GL_TEXTURE_CUBE_MAP_SEAMLESS
SEAMLESS = 0x884F


@cache
def context() -> Any:
    """A context without a window; skips where there is none."""
    moderngl = need("moderngl")
    try:
        made = moderngl.create_context(standalone=True, backend="egl", require=430)
    except Exception as error:
        pytest.skip(f"no OpenGL 4.3 here: {error}")
    made.enable_direct(SEAMLESS)
    return made


def is_exact() -> bool:
    """Tell whether this is Mesa's renderer.

    A graphics card divides less exactly, and the weights of its samplers have 8 bits.
    """
    return "llvmpipe" in context().info["GL_RENDERER"]


def need_exact() -> None:
    """Skip on a graphics card."""
    if not is_exact():
        pytest.skip("a graphics card's division, or the weights of its samplers, are less exact")


def texture(image: Array, wrap: tuple[bool, bool]) -> Any:
    """An image (H, W, 4), or faces (6, N, N, 4), with all its levels."""
    gl = need("moderngl")
    data = np.ascontiguousarray(image, np.float32)
    if image.ndim == 3:
        made = context().texture(image.shape[1::-1], 4, data.tobytes(), dtype="f4")
        made.repeat_x, made.repeat_y = wrap
    else:
        made = context().texture_cube(image.shape[1:3], 4, data.tobytes(), dtype="f4")
    made.build_mipmaps()
    made.filter = (gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR)
    return made


def sample(
    image: Array,
    places: Array,
    lod: Array | None = None,
    derivatives: tuple[Array, Array] | None = None,
    wrap: tuple[bool, bool] = (False, False),
) -> Array:
    """Look (u, v), or directions in a cube map, up."""
    n, width = places.shape
    given = np.zeros((n, 3, 4), np.float32)
    given[:, 0, :width] = places
    if lod is not None:
        given[:, 0, 3] = lod
    if derivatives is not None:
        given[:, 1, :width], given[:, 2, :width] = derivatives
    call = CALLS["lod" if derivatives is None else "derivatives", width]
    kind = "sampler2D" if width == 2 else "samplerCube"
    shader = context().compute_shader(SHADER % {"sampler": kind, "call": call})
    texture(image, wrap).use(0)
    source = context().buffer(given.tobytes())
    target = context().buffer(reserve=16 * n)
    source.bind_to_storage_buffer(0)
    target.bind_to_storage_buffer(1)
    shader.run(n)
    return np.frombuffer(target.read(), np.float32).reshape(n, 4)
