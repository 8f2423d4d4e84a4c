"""The filters: what the table claims of them, their weights, and that seams do not show."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, FILTERS, LOOKUPS, WIDE, each, random_directions, some_fast

each_wide = pytest.mark.parametrize("filter", WIDE)


def cubic(x: np.ndarray, b: float, c: float) -> np.ndarray:
    """Mitchell and Netravali 1988, equation 8."""
    x = np.abs(x)
    near = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + 6 - 2 * b
    far = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + 8 * b + 24 * c
    return np.where(x < 1, near, np.where(x < 2, far, 0)) / 6


def windowed_sinc(x: np.ndarray) -> np.ndarray:
    """Return Lanczos' kernel of three lobes, before it is divided by its sum."""
    return np.where(np.abs(x) < 3, np.sinc(x) * np.sinc(x / 3), 0)


# The formulas of papers; other filters are held to theirs where they are written.
PAPERS = {
    "catmull-rom": lambda x: cubic(x, 0, 0.5),
    "mitchell": lambda x: cubic(x, 1 / 3, 1 / 3),
    "lanczos3": windowed_sinc,
}


def weights(filter: str, t: np.ndarray) -> np.ndarray:
    """Of the six texels about a place, t of a texel to the right of the third."""
    w = PAPERS[filter](np.arange(-2, 4) - t[..., None])
    return w / w.sum(-1, keepdims=True)


def bends_lines(filter: str) -> float:
    """Return by how much of a texel a ramp of columns is bent, far from every border."""
    image = np.tile(np.arange(64.0), (32, 1))
    u = np.linspace(0.4, 0.6, 301)
    got = sm.sample(
        image,
        sm.decode(np.stack([u, np.full_like(u, 0.5)], -1), "latlong"),
        "latlong",
        filter=filter,
    )
    return float(np.abs(got - (u * 64 - 0.5)).max())


@pytest.mark.parametrize("filter", PAPERS)
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
@some_fast("dtype", ["uint8", "float16", "float32", "float64"], fast=("float32",))
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
    if bends_lines(filter) < 1e-9:
        # A filter that blurs errs by half its variance times f'', a bilinear one by h²/12 f'' in
        # the mean. What bends lines (Lanczos' by up to 1/100 of a texel) is no match.
        factor = 0.7 if FILTERS[filter]["interpolates"] else 2.5
        assert wide[~border].mean() < factor * linear[~border].mean()
    if border.any() and p.coverage == "sphere":
        # At a border the bilinear rules have the second order, and the wide ones not less.
        there = max(linear[border].mean(), wide[~border].mean())
        assert wide[border].mean() < 2.5 * there


@pytest.mark.parametrize("name", ["latlong", "octahedral"])
@pytest.mark.parametrize("filter", LOOKUPS)
def test_those_that_interpolate_give_back_every_texel(name, filter):
    p = sm.projection(name)
    image = np.random.default_rng(7).random((*p.shape(12), 3))
    got = p.sample(image, p.directions(12), filter=filter)
    # Coordinates are off by some ε of the image, and numbers differ by up to 1 a texel.
    assert (np.abs(got - image).max() < 1e-12) == FILTERS[filter]["interpolates"]


@pytest.mark.parametrize("filter", FILTERS)
def test_those_that_ring_overshoot_beside_an_edge(filter):
    image = np.zeros((32, 64))
    image[:, 20:40] = 1
    got = sm.convert(image, "latlong", "latlong", size=(64, 128), filter=filter)
    # What is left of a sum of weights in rounding is no overshoot.
    rings = got.min() < -1e-9 or got.max() > 1 + 1e-9
    assert rings == FILTERS[filter]["ringing"]


@pytest.mark.parametrize("filter", FILTERS)
def test_those_for_labels_give_labels(filter):
    values = np.array([3, 50, 120, 251], np.uint8)
    labels = np.random.default_rng(8).choice(values, (32, 64))
    for size in (4, 40):
        got = sm.convert(labels, "latlong", "cube", size=size, filter=filter)
        assert np.isin(got, values).all() == FILTERS[filter]["takes_labels"]


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("dtype", ["uint8", "float16", "float32", "float64"])
def test_every_filter_keeps_a_constant_to_the_bit(filter, dtype):
    image = np.full((24, 48, 3), 0.1 if dtype[0] == "f" else 137, dtype)
    for size in (5, 20):
        got = sm.convert(image, "latlong", "cube", size=size, filter=filter)
        assert np.all(got == image[0, 0])


@pytest.mark.parametrize("filter", FILTERS)
def test_support_is_how_far_a_texel_is_seen(filter):
    support = FILTERS[filter]["support"]
    if support is None:
        with pytest.raises(
            ValueError, match=f"filter '{filter}' (makes texels of an image|has to know)"
        ):
            sm.sample(np.zeros((32, 64)), [0, 0, 1], "latlong", filter=filter)
        return
    image = np.zeros((32, 64))
    image[:, 30] = 1
    x = np.linspace(-4, 4, 1601)
    uv = np.stack([(30.5 + x) / 64, np.full_like(x, 0.5)], -1)
    got = sm.sample(image, sm.decode(uv, "latlong"), "latlong", filter=filter)
    # Beyond the support weights are 0 and not small.
    seen = np.abs(x[np.abs(got) > 1e-9])
    # To a step of the places, and a cubic's weight leaves zero slowly.
    assert support - 0.02 < seen.max() <= support + 0.005


def test_bicubic_is_catmull_rom():
    image = np.random.default_rng(8).random((8, 16))
    d = random_directions(100, 9)
    one, other = (sm.sample(image, d, "latlong", filter=f) for f in ("bicubic", "catmull-rom"))
    assert np.array_equal(one, other)
    with pytest.raises(ValueError, match="did you mean 'lanczos3'"):
        sm.sample(image, d, "latlong", filter="lanczos")
