"""Lookups at a level of detail or by derivatives, against the rules of graphics APIs."""

from __future__ import annotations

import hard_directions
import numpy as np
import pytest
import spheremap as sm
from conftest import (
    DEFAULTS,
    LOOKUPS,
    MIPMAPPED,
    assert_same_bits,
    assert_same_bits_everywhere,
    each,
    random_directions,
)
from reference import sampler

# Both compute in float64 and round once a step, some dozens of times, on values up to 1; near the
# edge of a face the quotient rule and a Jacobian lose a digit more, and λ is a logarithm of that.
CLOSE = 1e-11

each_mipmapped = pytest.mark.parametrize("filter", MIPMAPPED)


def random_image(p: sm.Projection, size: int) -> np.ndarray:
    return np.random.default_rng(size).random((*p.shape(size), 3))


def derivatives(d: np.ndarray, seed: int, spread: tuple[float, float] = (-12, 0)):
    """Vectors in all directions, also along d, of lengths from 2^low to 2^high."""
    rng = np.random.default_rng(seed)
    lengths = 2.0 ** rng.uniform(*spread, (2, *d.shape[:-1], 1))
    return tuple(rng.normal(size=(2, *d.shape)) * lengths)


def test_levels_of_a_cube_are_those_of_opengl():
    levels = sm.mipmaps(random_image(sm.projection("cube:opengl"), 32), "cube:opengl")
    d = random_directions(600, 5) * 3
    lod = np.random.default_rng(6).uniform(-1, 7, len(d))
    got = sm.sample(levels[0], d, "cube:opengl", lod=lod)
    seen = 0
    for k, r in enumerate(d):
        want = sampler.sample_cube(levels, r, lod=lod[k])
        if want is not None:
            seen += 1
            assert np.allclose(got[k], want, rtol=0, atol=CLOSE)
    assert seen > 250


def test_derivatives_on_a_cube_are_those_of_opengl():
    levels = sm.mipmaps(random_image(sm.projection("cube:opengl"), 64), "cube:opengl")
    d = random_directions(900, 7) * 5
    right, down = derivatives(d, 8, (-8, 0))
    got = sm.sample(levels[0], d, "cube:opengl", derivatives=(right, down))
    between = 0
    for k, r in enumerate(d):
        want = sampler.sample_cube(levels, r, derivatives=(right[k], down[k]))
        if want is not None:
            assert np.allclose(got[k], want, rtol=0, atol=CLOSE)
            between += bool(np.any(np.abs(got[k] - sampler.sample_cube(levels, r)) > CLOSE))
    assert between > 200


@each(DEFAULTS)
def test_whole_levels_are_lookups_in_mipmaps(case):
    p = case.make()
    image = random_image(p, 32)
    d = random_directions(300, 9)
    levels = sm.mipmaps(image, p)
    looks = np.stack([p.sample(level, d) for level in levels])
    for k, look in enumerate(looks):
        # Those of `sample` are rounded at each step, as here, in another order.
        assert np.allclose(p.sample(image, d, lod=k), look, rtol=0, atol=1e-12)
    between = p.sample(image, d, lod=0.25)
    if len(levels) > 1:
        # As above.
        assert np.allclose(between, 0.75 * looks[0] + 0.25 * looks[1], rtol=0, atol=1e-12)
    assert np.array_equal(p.sample(image, d, lod=99), p.sample(image, d, lod=len(levels) - 1))
    assert np.array_equal(p.sample(image, d, lod=np.inf), p.sample(image, d, lod=99))
    assert np.array_equal(p.sample(image, d, lod=-np.inf), p.sample(image, d, lod=0))


@each(DEFAULTS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.float16, np.uint8])
def test_level_0_has_the_bits_of_the_image(case, dtype):
    p = case.make()
    # Of more numbers than have a way of their own, too.
    for channels in (1, 3, 5):
        image = (200 * np.random.default_rng(4).random((*p.shape(32), channels))).astype(dtype)
        # Anywhere, on texels, and on lines between them.
        centers = [p.directions(size).reshape(-1, 3) for size in (32, 16)]
        d = np.concatenate([random_directions(300, 9), *centers])
        assert_same_bits(p.sample(image, d, lod=0), p.sample(image, d))


def test_a_texel_that_counts_for_nothing_may_be_no_number():
    image = np.ones((8, 16, 3), np.float32)
    image[3, 5] = np.nan
    seen = sm.sample(image, sm.directions("latlong", 8), "latlong", lod=0)
    assert np.array_equal(seen, image, equal_nan=True)


@each(DEFAULTS)
def test_derivatives_agree_with_differences_of_encode(case):
    p = case.make()
    shape = p.shape(64)
    image = random_image(p, 64)
    d = random_directions(200, 10)
    right, down = derivatives(d, 11, (-6, 1))
    step = 1e-6
    texels = np.array(shape[:-3:-1])
    lengths = []
    for change in (right, down):
        ahead, behind = p.encode(d + step * change), p.encode(d - step * change)
        # From one face to another they mean nothing, nor over a seam, where they are huge.
        ahead[np.any(ahead[..., 2:] != behind[..., 2:], axis=-1)] = np.nan
        lengths.append(np.linalg.norm((ahead - behind)[..., :2] * texels / (2 * step), axis=-1))
    rho = np.maximum(*lengths)
    got = p.sample(image, d, derivatives=(right, down), fill=np.nan)
    want = p.sample(image, d, lod=np.log2(np.maximum(rho, 1)), fill=np.nan)
    held = np.isfinite(want[..., 0]) & (rho < 64 * 64)
    assert held.sum() > 0.4 * np.isfinite(p.sample(image, d, fill=np.nan)[..., 0]).sum()
    error = np.abs(got - want)[held].max(axis=-1)
    # Differences are good to rounding / step and step² · curvature, 1e-8 or so of a length, but
    # beside singular places, where a formula curves within a step.
    assert np.quantile(error, 0.9) < 1e-6


@each(DEFAULTS)
def test_only_singular_places_see_everything(case):
    p = case.make()
    d = hard_directions.hard(np.float64)
    still = np.random.default_rng(23).normal(size=(2, *d.shape))
    # Tiny beside directions that are huge or tiny themselves.
    still *= 1e-9 * np.abs(d).max(axis=-1, keepdims=True)
    image = random_image(p, 16)[..., 0]
    got = p.sample(image, d, derivatives=tuple(still), fill=np.nan)
    want = p.sample(image, d, lod=0, fill=np.nan)
    other = (got != want) & ~np.isnan(want)
    jacobian = p.jacobian(p.encode(d[other]))
    known = np.isfinite(jacobian).all(axis=(-2, -1))
    shorter = np.linalg.svd(jacobian[known], compute_uv=False)[:, 1]
    # Level 0 ends at 1e-9 / shorter · 16 texels = 1; with what a Jacobian rounds there.
    assert np.all(shorter < 1e-6)
    assert np.array_equal(np.isnan(got), np.isnan(want))


def test_ewa_of_a_circle_and_along_a_line():
    # Of an image that varies with the latitude alone, an ellipse along the equator sees one value
    # and a long one across it many.
    y = sm.directions("latlong", 128)[..., 1]
    image = np.sign(y)
    d = np.array([0.3, 0.05, -0.9])
    east, up = np.cross(d, [0.0, 1, 0]), np.array([0.0, 1, 0])
    tiny = 1e-4

    def seen(right, down):
        return sm.sample(image, d, "latlong", derivatives=(right, down), filter="ewa")

    # 0.05 of a radian above the horizon: two texels, and more than an ellipse a texel high reaches.
    assert seen(0.4 * east, tiny * up) == 1
    assert abs(seen(tiny * east, 0.4 * up)) < 0.6
    assert seen(tiny * east, tiny * up) == 1
    # The longer side alone would blur as much either way.
    blurred = sm.sample(image, d, "latlong", derivatives=(0.4 * east, tiny * up))
    assert abs(blurred) < 0.9
    assert seen(0.4 * east, 0.4 * up) == seen(-0.4 * east, 0.4 * up)


@each_mipmapped
def test_what_is_no_number_is_fill_and_what_is_infinite_sees_all(filter):
    image = random_image(sm.projection("cube"), 16)
    d = random_directions(6, 12)
    right, down = np.full((2, 6, 3), 1e-3)
    right[1, 2] = np.nan
    down[2, 0] = np.nan
    right[3, 0] = np.inf
    down[4] = -np.inf
    right[5] = down[5] = 0
    options = {"derivatives": (right, down), "filter": filter, "fill": (7.0, 8.0, 9.0)}
    got = sm.sample(image, d, "cube", **options)
    assert got[1].tolist() == got[2].tolist() == [7.0, 8.0, 9.0]
    last = sm.sample(image, d, "cube", lod=np.inf)
    if filter == "trilinear":
        assert np.array_equal(got[3:5], last[3:5])
        assert np.array_equal(got[5], sm.sample(image, d[5], "cube", lod=0))
    else:
        # An ellipse in a level of one texel a face sees its neighbors, too.
        assert np.all(np.abs(got[3:5] - image.mean(axis=(0, 1, 2))) < 0.05)
    sampled = sm.sample(image, d, "cube", lod=[0, np.nan, 1, 1, 1, 1], fill=5)
    assert np.all(sampled[1] == 5) and np.all(sampled[[0, 2, 3, 4, 5]] < 1)
    invalid = sm.sample(image, [[0, 0, 0], [np.nan, 1, 1]], "cube", lod=1, fill=5)
    assert np.all(invalid == 5)
    assert np.all(sm.sample(image.astype(np.uint8), d, "cube", lod=np.nan, fill=9) == 9)


@each_mipmapped
@pytest.mark.parametrize("length", [1e-300, 1e-310, 1e300])
def test_the_length_of_a_direction_does_not_matter(filter, length):
    image = random_image(sm.projection("octahedral"), 32)
    d = random_directions(50, 13)
    right, down = derivatives(d, 14, (-6, -1))
    want = sm.sample(image, d, "octahedral", derivatives=(right, down), filter=filter)
    with np.errstate(under="ignore"):
        long = d * length, (right * length, down * length)
    got = sm.sample(image, long[0], "octahedral", derivatives=long[1], filter=filter)
    # Subnormal numbers have 30 bits and more here; others round once.
    assert np.allclose(got, want, rtol=0, atol=1e-7 if length < 1e-305 else CLOSE)


@each_mipmapped
def test_a_turned_world_turns_directions_and_derivatives(filter):
    p = sm.projection("angular")
    image = random_image(p, 64)
    turn = sm.rotation(20, 30, 40)
    d = random_directions(200, 15)
    right, down = derivatives(d, 16, (-6, -1))
    want = p.sample(image, d, derivatives=(right, down), filter=filter)
    turned = d @ turn.T, (right @ turn.T, down @ turn.T)
    got = p.sample(image, turned[0], derivatives=turned[1], filter=filter, rotation=turn)
    # The turn rounds directions; a disk's rim makes that a thousand times more.
    assert np.allclose(got, want, rtol=0, atol=1e-9)


@each_mipmapped
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32"])
def test_a_constant_stays_constant_in_every_dtype(filter, dtype):
    image = np.full((6, 16, 16, 2), 0.1 if dtype.startswith("f") else 200, dtype)
    d = random_directions(300, 17, np.float32)
    got = sm.sample(image, d, "cube", derivatives=derivatives(d, 18), filter=filter)
    assert got.dtype == image.dtype and np.all(got == image[0, 0, 0])
    assert np.all(sm.sample(image, d, "cube", lod=1.3) == image[0, 0, 0])


def test_opacity_and_holes_have_weights():
    image = np.zeros((32, 64, 2))
    image[:, 32:] = (1, 1)
    image[:, :32, 0] = 50  # transparent
    d = random_directions(200, 19)
    got = sm.sample(image, d, "latlong", lod=2.5, alpha=-1)
    assert np.all(np.isin(got[:, 0].round(12), [0, 1])) and 0 < got[:, 1].mean() < 1
    holes = np.where(image[..., :1] == 50, np.nan, 1.0)
    got = sm.sample(holes, d, "latlong", lod=2.5, skipna=True)
    assert np.all((got == 1) | np.isnan(got)) and (got == 1).sum() > np.sum(d[:, 0] > 0)
    assert np.isnan(sm.sample(holes, d, "latlong", lod=2.5)).sum() > np.isnan(got).sum()


@each_mipmapped
def test_levels_may_be_given(filter):
    image = random_image(sm.projection("cube"), 32)
    levels = sm.mipmaps(image, "cube")
    d = random_directions(100, 24)
    pair = derivatives(d, 25, (-7, 0))
    options = {"derivatives": pair, "filter": filter}
    want = sm.sample(image, d, "cube", **options)
    assert np.array_equal(sm.sample(levels, d, "cube", **options), want)
    assert np.array_equal(sm.projection("cube").sample(tuple(levels), d, **options), want)
    # What they hold is the caller's, and so is where they end.
    numbers = [np.full((6, n, n), k, np.uint8) for k, n in enumerate((16, 8, 4))]
    lod = np.array([0, 1, 1.6, 2, 9])
    assert sm.sample(numbers, d[0], "cube", lod=lod).tolist() == [0, 1, 2, 2, 2]
    swapped = [level.astype(">f4") for level in levels]
    # Rounded to float32 before and after.
    assert np.allclose(sm.sample(swapped, d, "cube", **options), want, rtol=0, atol=1e-6)


def test_bad_levels():
    levels = sm.mipmaps(random_image(sm.projection("cube"), 8), "cube")
    with pytest.raises(ValueError, match="`lod` or `derivatives` for a list of levels"):
        sm.sample(levels, [0, 0, 1], "cube")
    with pytest.raises(ValueError, match="levels are made of"):
        sm.sample(levels, [0, 0, 1], "cube", lod=1, skipna=True)
    with pytest.raises(TypeError, match="one dtype, got float64, float32"):
        sm.sample([levels[0], levels[1].astype("f4")], [0, 0, 1], "cube", lod=1)
    with pytest.raises(ValueError, match="with 3 channels"):
        sm.sample([levels[0], levels[1][..., :2]], [0, 0, 1], "cube", lod=1)
    with pytest.raises(ValueError, match="to have shape"):
        sm.sample([levels[0], levels[1][0]], [0, 0, 1], "cube", lod=1)
    out = levels[1][0, 0, 0]
    with pytest.raises(ValueError, match="overlaps"):
        sm.sample(levels, [0, 0, 1], "cube", lod=1, out=out)


def test_levels_and_derivatives_are_broadcast():
    image = random_image(sm.projection("latlong"), 32)
    d = random_directions(20, 20).reshape(4, 5, 3)
    assert sm.sample(image, d, "latlong", lod=np.ones((4, 1))).shape == (4, 5, 3)
    assert sm.sample(image, d[0, 0], "latlong", lod=[0, 1, 2]).shape == (3, 3)
    assert sm.sample(image[..., 0], d[0, 0], "latlong", lod=1).shape == ()
    pair = (np.full(3, 0.1), np.zeros((4, 1, 3)))
    got = sm.sample(image, d, "latlong", derivatives=pair)
    one = sm.sample(image, d[2, 3], "latlong", derivatives=(pair[0], np.zeros(3)))
    assert np.array_equal(got[2, 3], one)
    out = np.empty((4, 5, 3))
    assert sm.sample(image, d, "latlong", lod=1, out=out) is out
    strided = sm.sample(image, d[:, ::-1], "latlong", lod=np.ones((8, 5))[::2].astype("f2"))
    assert np.array_equal(strided, out[:, ::-1])
    assert sm.sample(image, np.empty((0, 3)), "latlong", lod=1).shape == (0, 3)


@each_mipmapped
def test_threads_and_levels_give_the_same_bits(filter):
    image = random_image(sm.projection("cube"), 32).astype(np.float32)
    d = random_directions(40_000, 21, np.float32)
    pair = derivatives(d, 22, (-8, 0))
    assert_same_bits_everywhere(
        lambda: [
            sm.sample(image, d, "cube", derivatives=pair, filter=filter),
            sm.sample(image, d, "cube", lod=np.linspace(0, 5, len(d))),
            sm.sample_uv(image[0], d[:, :2], derivatives=(pair[0][:, 1:], pair[1][:, 1:])),
        ]
    )


def test_bad_input():
    image = np.zeros((8, 16))
    d = np.ones((2, 3))
    with pytest.raises(ValueError, match="`lod` or `derivatives`, not both"):
        sm.sample(image, d, "latlong", lod=1, derivatives=(d, d))
    for filter in LOOKUPS:
        with pytest.raises(ValueError, match=f"filter '{filter}' knows no levels"):
            sm.sample(image, d, "latlong", lod=1, filter=filter)
    with pytest.raises(ValueError, match="'ewa' averages over the footprint"):
        sm.sample(image, d, "latlong", lod=1, filter="ewa")
    for filter in MIPMAPPED:
        with pytest.raises(ValueError, match="has to know how much a lookup sees"):
            sm.sample(image, d, "latlong", filter=filter)
        with pytest.raises(ValueError, match="has to know how much a lookup sees"):
            sm.sample_uv(image, d[:, :2], filter=filter)
    for pair in (d, (d,), (d, d, d), 3, np.array(3.0), (d[:, :2], d)):
        with pytest.raises(ValueError, match="`derivatives` to"):
            sm.sample(image, d, "latlong", derivatives=pair if pair is not d else d[:1])
    with pytest.raises(ValueError, match="broadcast"):
        sm.sample(image, d, "latlong", lod=[1, 2, 3])
    with pytest.raises(TypeError, match="`lod` to be real numbers"):
        sm.sample(image, d, "latlong", lod="one")
    with pytest.raises(ValueError, match="overlaps"):
        sm.sample(image, d, "latlong", lod=d[:, 0], out=d[:, 1])
