"""Whole lookups printed for shaders, run by OpenGL: the colors that `sample` gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from printed import Array, called, compiled, directions

from oracles import opengl_oracle
from oracles.test_oracle_code import DIALECTS, DIRECTION, SHIM, run_shader

STORE = "made[4 * i] = c.x; made[4 * i + 1] = c.y; made[4 * i + 2] = c.z; made[4 * i + 3] = c.w;"
SIZE = 64


def picture(seed: int) -> Array:
    """Return colors without an edge sharper than a texel."""
    x, y = np.meshgrid(np.linspace(0, 1, SIZE), np.linspace(0, 1, SIZE))
    a, b, c, d = np.random.default_rng(seed).uniform(1, 3, 4)
    waves = [np.sin(a * x + b * y), np.cos(c * x - d * y), x * y, np.ones_like(x)]
    return np.stack(waves, axis=-1)


def inner(uv: Array) -> Array:
    """Tell what is more than a texel inside of the disk, where no rim is mixed in."""
    return np.linalg.norm(np.nan_to_num(uv, nan=9.0) - 0.5, axis=-1) < 0.5 - 1.5 / SIZE


def looked_up(name: str, call: str, d: Array, images: list[Array]) -> Array:
    text = sm.effect(name, "glsl", name="m")
    bound = [opengl_oracle.texture(image, (False, False)) for image in images]
    for k, texture in enumerate(bound):
        texture.use(k)
        text = text.replace("\nuniform", f"\nlayout(binding = {k}) uniform", 1)
    return run_shader(text, f"vec4 c = {call}; {STORE}", d, np.float32).reshape(-1, 4)


# Graphics cards mix texels with weights of 8 bits.
MIXED = 1 / 128


@pytest.mark.parametrize(("name", "of"), [("matcap", "matcap"), ("light_probe", "angular:debevec")])
def test_colors_are_what_sample_gives(name: str, of: str) -> None:
    d, image = directions(np.float32), picture(1)
    found = looked_up(name, f"m_color({DIRECTION})", d, [image])
    seen = inner(sm.encode(d, of))
    assert seen.mean() > 0.3
    assert np.abs(found - sm.sample(image, d, of))[seen].max() <= MIXED
    outside = np.isnan(sm.encode(d, of)[:, 0])
    assert (found[outside] == 0).all()


def test_the_sphere_map_is_seen_in_mirrors() -> None:
    d, image = directions(np.float32), picture(2)
    normal = np.array([0.6, 0.0, -0.8])
    mirrored = sm.reflect(d, normal)
    call = f"m_color(m_vertex({DIRECTION}, vec3(0.6, 0.0, -0.8)))"
    found = looked_up("sphere_map", call, d, [image])
    seen = inner(sm.encode(mirrored, "sphere:d3d"))
    assert np.abs(found - sm.sample(image, mirrored, "sphere:d3d"))[seen].max() <= MIXED


def test_two_balls_show_every_direction() -> None:
    # Two pictures of one scene, from both sides.
    behind = sm.projection("sphere").turned([[-1, 0, 0], [0, 1, 0], [0, 0, -1]])
    balls = [sm.projection("sphere"), behind]
    images = []
    for ball in balls:
        shown = np.nan_to_num(ball.directions(512))
        images.append(np.concatenate([shown, np.ones_like(shown[..., :1])], axis=-1))
    d = directions(np.float32)
    found = looked_up("mirror_balls", f"m_color({DIRECTION})", d, images)
    # Each is seen up to a right angle from its middle, where texels are small.
    assert np.abs(found[:, :3] - d).max() <= 4 / 512


def test_normals_come_back_from_a_buffer() -> None:
    d = directions(np.float32)
    text = sm.effect("gbuffer", "glsl", name="m")
    call = f"vec3 r = m_unpack(round(m_pack({DIRECTION}) * 65535.0) / 65535.0); "
    call += "made[3 * i] = r.x; made[3 * i + 1] = r.y; made[3 * i + 2] = r.z;"
    found = run_shader(text, call, d, np.float32).reshape(-1, 3)
    # Half a step of each coordinate, of a map that stretches by 2 * sqrt(3) at most.
    assert np.linalg.norm(found - d, axis=-1).max() <= 2 * 3**0.5 / 65535 * 2**0.5


# What stands for Metal's textures: colors that tell the place.
TEXTURES = """
struct float4 {
    float x, y, z, w;
    float4(float a, float b, float c, float d) : x(a), y(b), z(c), w(d) {}
};
static inline float2 operator-(float2 a, float2 b) { return float2(a.x - b.x, a.y - b.y); }
static inline float dot(float2 a, float2 b) { return a.x * b.x + a.y * b.y; }
namespace filter { enum Filter { linear }; }
namespace address { enum Address { clamp_to_edge }; }
struct sampler { constexpr sampler(filter::Filter, address::Address) {} };
template <class T> struct texture2d {
    T which;
    float4 sample(sampler, float2 uv) const { return float4(uv.x, uv.y, which, 1); }
};
"""
METAL = """
extern "C" void all(const float* given, float* made, long n) {{
    texture2d<float> a = {{1}}, b = {{2}};
    for (long i = 0; i < n; i++) {{ float4 c = {call}; {store} }}
}}
"""


def by_metal(name: str, call: str, d: Array, folder: Path) -> Array:
    text = sm.effect(name, "msl", name="m")
    text = text.replace("#include <metal_stdlib>\nusing namespace metal;", "")
    whole = SHIM + DIALECTS["msl"] + TEXTURES + text + METAL.format(call=call, store=STORE)
    (folder / name).mkdir()
    library = compiled(whole, folder / name, cpp=True)
    return called(library.all, d, np.empty((len(d), 4), np.float32))


def test_effects_of_metal_look_where_the_map_is(tmp_path: Path) -> None:
    d = directions(np.float32)
    for name, of in (("matcap", "matcap"), ("light_probe", "angular:debevec")):
        found = by_metal(name, f"m_color(a, {DIRECTION.replace('vec', 'float')})", d, tmp_path)
        uv = sm.encode(d, of)
        outside = np.isnan(uv[:, 0])
        assert (found[outside] == 0).all()
        assert np.array_equal(found[~outside, :2], uv[~outside])


def test_two_balls_and_the_sphere_map_of_metal(tmp_path: Path) -> None:
    d = directions(np.float32)
    direction = DIRECTION.replace("vec", "float")
    found = by_metal("mirror_balls", f"m_color(a, b, {direction})", d, tmp_path)
    front = sm.encode(d, "sphere")
    back = sm.encode(d, sm.projection("sphere").turned([[-1, 0, 0], [0, 1, 0], [0, 0, -1]]))
    from_front = found[:, 2] == 1
    assert np.array_equal(found[from_front, :2], front[from_front])
    assert np.array_equal(found[~from_front, :2], back[~from_front])
    # Half of the sphere each, and none at a rim.
    assert 0.4 < from_front.mean() < 0.6
    assert np.linalg.norm(found[:, :2] - 0.5, axis=1).max() < 0.4
    call = f"m_color(a, m_vertex({direction}, float3(0.6f, 0.0f, -0.8f)))"
    found = by_metal("sphere_map", call, d, tmp_path)
    mirrored = sm.reflect(d, np.float32([0.6, 0.0, -0.8]))
    assert np.array_equal(found[:, :2], sm.encode(mirrored, "sphere:d3d"))


def test_effects_and_languages_are_checked() -> None:
    with pytest.raises(ValueError, match="effect"):
        sm.effect("matcaps", "hlsl")
    with pytest.raises(ValueError, match="language"):
        sm.effect("matcap", "osl")
    with pytest.raises(ValueError, match="a letter"):
        sm.effect("matcap", "glsl", name="1st")
