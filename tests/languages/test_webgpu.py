"""Printed WGSL, run by WebGPU (`make test-printed`)."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from oracles import need
from printed import (
    CASES,
    PACKINGS,
    TAPPED,
    VERBS,
    Array,
    assert_alike,
    assert_native,
    assert_packs_alike,
    assert_sums_alike,
    assert_taps,
    directions,
    made,
    roundings,
)

pytestmark = [pytest.mark.programs, pytest.mark.runs("webgpu", language="wgsl")]

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


@pytest.mark.parametrize("case", CASES)
def test_webgpu_has_functions_of_its_own(case: str) -> None:
    p = made(case)
    text = sm.code(p, "wgsl", name="m", precision="native")
    call = f"let r = m_decode(m_encode({vector(3)})); {stores(3)}"
    assert_native(p, lambda d: run(text, call, d))


@pytest.mark.parametrize("name", [n for n in PACKINGS if sm.packing.packing(n).bits <= 32])
def test_webgpu_packs(name: str) -> None:
    for rounding in roundings(name):
        text = sm.packing.code(name, "wgsl", rounding=rounding, name="m")

        def pack(d: Array, text: str = text) -> Array:
            # The bits of some words are those of a NaN, which may lose some where it is a float.
            halves = "let w = m_pack(" + vector(3) + "); "
            halves += "made[2u * i] = f32(w & 65535u); made[2u * i + 1u] = f32(w >> 16u);"
            low, high = run(text, halves, d).astype(np.uint32).T
            return low | high << 16

        def unpack(words: Array, text: str = text) -> Array:
            halves = np.stack([words & 65535, words >> 16], axis=1).astype(np.float32)
            word = "u32(given[2u * i]) | (u32(given[2u * i + 1u]) << 16u)"
            return run(text, f"let r = m_unpack({word}); {stores(3)}", halves)

        assert_packs_alike(name, rounding, np.float32, pack, unpack, exact=False)


@pytest.mark.parametrize("channels", [1, 3])
def test_webgpu_sums_harmonics(channels: int) -> None:
    call = f"let r = vec3<f32>(m_evaluate({vector(3)})); {stores(3)}"
    assert_sums_alike("wgsl", channels, lambda text, d: run(text, call, d)[:, :channels])


CALLS = {
    "sphere_map": "m_color(image, image_sampler, m_vertex(d, d))",
    "matcap": "m_color(image, image_sampler, d)",
    "light_probe": "m_color(image, image_sampler, d)",
    "mirror_balls": "m_color(image, image_sampler, image, image_sampler, d)",
    "gbuffer": "vec4<f32>(m_unpack(m_pack(d)), 1.0) + textureSample(image, image_sampler, d.xy)",
}
STAGES = """{text}
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var image_sampler: sampler;
struct Vertex {{ @builtin(position) at: vec4<f32>, @location(0) d: vec3<f32> }}
@vertex fn vertex(@builtin(vertex_index) i: u32) -> Vertex {{
    let p = vec2<f32>(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Vertex(vec4<f32>(p, 0.0, 1.0), vec3<f32>(p, 1.0));
}}
@fragment fn fragment(@location(0) d: vec3<f32>) -> @location(0) vec4<f32> {{
    return {call};
}}
"""


@pytest.mark.parametrize("effect", CALLS)
def test_webgpu_compiles_effects(effect: str) -> None:
    wgpu = need("wgpu.utils")
    text = STAGES.format(text=sm.effect(effect, "wgsl", name="m"), call=CALLS[effect])
    device = wgpu.utils.get_default_device()
    module = device.create_shader_module(code=text)
    pipeline = device.create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "vertex"},
        fragment={
            "module": module,
            "entry_point": "fragment",
            "targets": [{"format": "rgba32float"}],
        },
        primitive={"topology": "triangle-list"},
    )
    assert pipeline is not None
