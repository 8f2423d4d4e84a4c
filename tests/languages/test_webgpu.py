"""Printed WGSL, run by WebGPU (`make test-printed`)."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from oracles import need
from printed import CASES, TAPPED, VERBS, Array, assert_alike, assert_taps, directions, made

pytestmark = pytest.mark.programs

SHADER = """{text}
@group(0) @binding(0) var<storage, read> given: array<f32>;
@group(0) @binding(1) var<storage, read_write> made: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    let i = id.x;
    if (i >= {count}u) {{ return; }}
    {call}
}}
"""


def run(text: str, call: str, data: Array) -> Array:
    """Return what a call of printed code makes of each row, as many numbers as it stores."""
    need("wgpu")
    from wgpu.utils.compute import compute_with_buffers

    shader = SHADER.format(text=text, count=len(data), call=call)
    each = call.count("made[")
    groups = (-(-len(data) // 64), 1, 1)
    out = compute_with_buffers({0: data}, {1: (each * len(data), "f")}, shader, n=groups)
    return np.frombuffer(out[1], np.float32).reshape(-1, each)


def vector(width: int, each: int = 0, first: int = 0) -> str:
    """Return the vector that some numbers of a row are."""
    each = each or width
    parts = ", ".join(f"given[{each}u * i + {first + k}u]" for k in range(width))
    return f"vec{width}<f32>({parts})"


def stores(n: int) -> str:
    """Return what stores a vector as the numbers of a row."""
    return " ".join(f"made[{n}u * i + {k}u] = r[{k}];" for k in range(n))


@pytest.mark.parametrize("case", CASES)
def test_webgpu_is_within_the_bounds(case: str) -> None:
    p = made(case)
    width = p.encode(np.zeros(3)).shape[-1]
    text = sm.code(p, "wgsl", verbs=VERBS, name="m")
    place = vector(width)
    columns = " ".join(
        f"made[6u * i + {3 * c + k}u] = r[{c}][{k}];" for c in range(2) for k in range(3)
    )
    of = {
        "encode": f"let r = m_encode({vector(3)}); {stores(width)}",
        "decode": f"let r = m_decode({place}); {stores(3)}",
        "density": f"made[i] = m_density({place});",
        "valid": f"made[i] = select(0.0, 1.0, m_valid({place}));",
        "jacobian": f"let r = m_jacobian({place}); {columns}",
    }

    def verb(name: str, data: Array) -> Array:
        out = run(text, of[name], data)
        return out[:, 0] if name in ("density", "valid") else out

    assert len(directions(np.float32)) > 20_000
    assert_alike(p, np.float32, verb, exact=False)


def test_webgpu_reflects() -> None:
    text = sm.code("latlong", "wgsl", verbs=["reflect"], name="m")
    view = directions(np.float32)
    normal = np.roll(view, 7, axis=0)
    call = f"let r = m_reflect({vector(3, 6)}, {vector(3, 6, 3)}); {stores(3)}"
    found = run(text, call, np.concatenate([view, normal], axis=1))
    # A dozen roundings of numbers up to 2.
    few = 24 * float(np.finfo(np.float32).eps)
    assert np.abs(found - sm.reflect(view, normal)).max() <= few


@pytest.mark.parametrize(("case", "size"), TAPPED)
def test_webgpu_taps(case: str, size: tuple[int, int]) -> None:
    text = sm.code(made(case), "wgsl", verbs=["taps"], name="m")
    names = [f"t{k}" for k in range(text.count("ptr<function"))]
    n = 4 * len(names)
    made_of = " ".join(
        f"made[{n}u * i + {4 * k + c}u] = {name}[{c}];"
        for k, name in enumerate(names)
        for c in range(4)
    )
    call = (
        " ".join(f"var {name}: vec4<f32>;" for name in names)
        + f" m_taps({vector(3)}, vec2<f32>({size[1]}.0, {size[0]}.0), "
        + ", ".join(f"&{name}" for name in names)
        + f"); {made_of}"
    )
    assert_taps(case, size, lambda d: run(text, call, d))
