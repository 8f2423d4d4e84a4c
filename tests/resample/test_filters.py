"""The wide filters: their weights, their order, and that seams do not show."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, each, random_directions

WIDE = ("catmull-rom", "mitchell", "lanczos3")
each_wide = pytest.mark.parametrize("filter", WIDE)


def cubic(x: np.ndarray, b: float, c: float) -> np.ndarray:
    """Mitchell and Netravali 1988, equation 8."""
    x = np.abs(x)
    near = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + 6 - 2 * b
    far = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + 8 * b + 24 * c
    return np.where(x < 1, near, np.where(x < 2, far, 0)) / 6


def weights(filter: str, t: np.ndarray) -> np.ndarray:
    """Of the six texels about a place, t of a texel to the right of the third."""
    x = np.arange(-2, 4) - t[..., None]
    if filter == "lanczos3":
        w = np.where(np.abs(x) < 3, np.sinc(x) * np.sinc(x / 3), 0)
        return w / w.sum(-1, keepdims=True)
    return cubic(x, *((0, 0.5) if filter == "catmull-rom" else (1 / 3, 1 / 3)))


@each_wide
@pytest.mark.parametrize("channels", [1, 2, 3, 4, 7])
@pytest.mark.parametrize("dtype", ["float64", "float32", "uint8"])
def test_lookups_are_the_weighted_sum_of_the_papers(filter, channels, dtype):
    rng = np.random.default_rng(channels)
    image = (200 * rng.random((40, 80, channels))).astype(dtype)
    uv = np.stack([rng.uniform(0.1, 0.9, 500), rng.uniform(0.2, 0.8, 500)], -1)
    x, y = uv[:, 0] * 80 - 0.5, uv[:, 1] * 40 - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    window = image.astype(float)[
        (j[:, None] + np.arange(-2, 4))[:, :, None], (i[:, None] + np.arange(-2, 4))[:, None, :]
    ]
    want = np.einsum("nr,nt,nrtc->nc", weights(filter, y - j), weights(filter, x - i), window)
    got = sm.sample(image, sm.decode(uv, "latlong"), "latlong", filter=filter)
    # Integers round once and saturate; float32 sums 36 products of numbers up to 200.
    bound = {"float64": 1e-10, "float32": 36 * 200 * 2.0**-23, "uint8": 0.5 + 1e-3}[dtype]
    if dtype == "uint8":
        want = np.clip(want, 0, 255)
    assert np.abs(got - want).max() < bound


@each(DEFAULTS)
@each_wide
@pytest.mark.parametrize("dtype", ["uint8", "float16", "float32", "float64"])
def test_a_constant_stays_constant_to_the_bit(case, filter, dtype):
    p = case.make()
    d = random_directions(3000, 5)
    d = d[p.covers(d)]
    for size in (1, 2, 3, 16):
        image = np.full((*p.shape(size), 3), 0.1 if dtype[0] == "f" else 137, dtype)
        dark = np.isnan(p.directions(size)[..., 0])
        if dark.all():
            continue
        constant = image[~dark][0, 0]
        image[dark] = 6e4 if dtype[0] == "f" else 255  # what must never take part
        assert np.all(p.sample(image, d, filter=filter) == constant), size


@each(DEFAULTS)
@each_wide
def test_seams_are_as_good_as_the_rest(case, filter):
    # Of a smooth function: with what this filter errs far from every border as the measure, no
    # lookup near a border is worse than what the borders' own rules promise.
    p, r = case.make(), case.reference()
    n = 96
    image = np.nan_to_num(reference.smooth_function(r.directions(n)))
    d = random_directions(20_000, 6)
    d = d[r.covers(d)]
    truth = reference.smooth_function(d)
    wide = np.abs(p.sample(image, d, filter=filter) - truth).max(-1)
    linear = np.abs(p.sample(image, d) - truth).max(-1)
    u, v, _ = r.local(r.encode(d))
    reach = 1 - 2 * 4 / min(p.shape(n)[-2:])
    border = np.hypot(u, v) > reach if r.is_disk else np.maximum(np.abs(u), np.abs(v)) > reach
    if filter != "lanczos3":
        # Mitchell's blurs, by h²/9 f'' where bilinear errs by up to h²/8 f''. Lanczos' shifts a
        # place by up to 1/100 of a texel, whatever the function: on a smooth one it is no match.
        factor = {"catmull-rom": 0.7, "mitchell": 2.5}[filter]
        assert wide[~border].mean() < factor * linear[~border].mean()
    if border.any() and p.coverage == "sphere":
        # At a border the bilinear rules have the second order, and the wide ones not less.
        there = max(linear[border].mean(), wide[~border].mean())
        assert wide[border].mean() < 2.5 * there


@pytest.mark.parametrize("name", ["latlong", "octahedral"])
@pytest.mark.parametrize("filter", ["catmull-rom", "lanczos3"])
def test_interpolation_gives_back_every_texel(name, filter):
    p = sm.projection(name)
    image = np.random.default_rng(7).random((*p.shape(12), 3))
    got = p.sample(image, p.directions(12), filter=filter)
    # Places are off by some ε of 24 columns; weights of neighbors are zero to that.
    np.testing.assert_allclose(got, image, atol=1e-12)


def test_bicubic_is_catmull_rom():
    image = np.random.default_rng(8).random((8, 16))
    d = random_directions(100, 9)
    one, other = (sm.sample(image, d, "latlong", filter=f) for f in ("bicubic", "catmull-rom"))
    assert np.array_equal(one, other)
    with pytest.raises(ValueError, match="did you mean 'lanczos3'"):
        sm.sample(image, d, "latlong", filter="lanczos")
