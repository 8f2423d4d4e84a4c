"""OpenGL's own samplers: levels, derivatives, edges."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from reference import sampler

from oracles import opengl_oracle

MODES = {False: "clamp", True: "wrap"}
# OpenGL computes places in float32: two pictures beyond the first, 64 texels wide, a place is off
# by 2⁻²⁴ · 3 · 64 or 1.1e-5 of a texel, along u and v, and texels differ by 1.
CLOSE = 3e-5


@pytest.fixture(autouse=True)
def exact() -> None:
    opengl_oracle.need_exact()


def picture() -> np.ndarray:
    return np.random.default_rng(1).random((16, 64, 4)).astype(np.float32)


def places(n: int) -> np.ndarray:
    return np.random.default_rng(2).uniform(-1, 2, (n, 2)).astype(np.float32)


def right_and_down(n: int, width: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    return rng.normal(size=(2, n, width)) * 2.0 ** rng.uniform(-9, 0, (2, n, 1))


def cube() -> list[np.ndarray]:
    """Faces, and their means of blocks, as OpenGL makes levels."""
    levels = [np.random.default_rng(4).random((6, 32, 32, 4)).astype(np.float32)]
    while (n := levels[-1].shape[1] // 2) > 0:
        levels.append(levels[-1].reshape(6, n, 2, n, 2, 4).mean(axis=(2, 4)))
    return levels


wraps = pytest.mark.parametrize("wrap", [(False, False), (True, True), (True, False)])


@wraps
def test_levels_of_a_picture(wrap):
    uv = places(2000)
    lod = np.random.default_rng(5).uniform(-1, 8, 2000).astype(np.float32)
    theirs = opengl_oracle.sample(picture(), uv, lod=lod, wrap=wrap)
    address = (MODES[wrap[0]], MODES[wrap[1]])
    ours = sm.sample_uv(picture(), uv, lod=lod, address=address)
    assert np.abs(ours - theirs).max() < CLOSE


@wraps
def test_derivatives_of_a_picture(wrap):
    uv, pair = places(2000), right_and_down(2000, 2)
    address = (MODES[wrap[0]], MODES[wrap[1]])
    theirs = opengl_oracle.sample(picture(), uv, derivatives=tuple(pair), wrap=wrap)
    ours = sm.sample_uv(picture(), uv, derivatives=tuple(pair), address=address)
    # Texels of two levels differ by less than 1.
    assert np.abs(ours - theirs).max() < opengl_oracle.ROUGH + CLOSE
    # At whole levels its logarithm is exact.
    rho = np.linalg.norm(pair * (64, 16), axis=-1).max(axis=0)
    pair *= (2.0 ** np.round(np.log2(rho)) / rho)[:, None]
    theirs = opengl_oracle.sample(picture(), uv, derivatives=tuple(pair), wrap=wrap)
    ours = sm.sample_uv(picture(), uv, derivatives=tuple(pair), address=address)
    assert np.abs(ours - theirs).max() < CLOSE


def test_levels_and_derivatives_of_a_cube():
    # The reference, which ours is compared with: levels are made otherwise here, by solid angle.
    levels = cube()
    d = np.random.default_rng(6).normal(size=(1500, 3)).astype(np.float32)
    lod = np.random.default_rng(7).uniform(-1, 6, 1500).astype(np.float32)
    pair = right_and_down(1500, 3)
    for k, r in enumerate(d):
        face = sampler.cube_face(r)
        sides = [32 * sampler.cube_derivative(r.astype(np.float64), x[k], face) for x in pair]
        level = sampler.level_of_detail(*sides)
        pair[:, k] *= 2.0 ** (round(level) - level)
    by_level = opengl_oracle.sample(levels[0], d, lod=lod)
    by_derivatives = opengl_oracle.sample(levels[0], d, derivatives=tuple(pair))
    seen = 0
    for k, r in enumerate(d.astype(np.float64)):
        want = sampler.sample_cube(levels, r, lod=lod[k])
        if want is not None:
            seen += 1
            assert np.abs(by_level[k] - want).max() < CLOSE
        want = sampler.sample_cube(levels, r, derivatives=(pair[0, k], pair[1, k]))
        if want is not None:
            seen += 1
            assert np.abs(by_derivatives[k] - want).max() < CLOSE
    assert seen > 1000
