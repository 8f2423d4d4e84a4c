"""`convert(filter="area")` and `"mode"`: no light is lost or made."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import (
    DEFAULTS,
    LAYOUTS,
    NAMES,
    PARAMETERS,
    assert_same_bits_everywhere,
    each,
    some_fast,
)
from reference import area as reference_area

SPHERES = [n for n in NAMES if sm.projection(n).coverage == "sphere"]
PARTNERS = ("latlong", "cube", "angular")
TURN = sm.rotation(33.0, -20.0, 71.0)
# The promise is 1e-6 for any pair. Edges are cut and integrated to 1e-9 of a cell each; worst is
# the mirror ball, whose formula itself blurs directions by 6e-8 rad around its blind spot.
KEPT = 1e-6


def area(image, src, dst, size, **options):
    return sm.convert(image, src, dst, size=size, filter="area", **options)


def energy(image, projection, shape):
    """Σ L·dω of a source, its rim texels filled as the rule says."""
    p = sm.projection(projection) if isinstance(projection, str) else projection
    return reference_area.energy(reference.of(p), image, p.solid_angle(shape))


def pairs():
    seen = [(a, b) for a in SPHERES for b in PARTNERS]
    return list(dict.fromkeys(seen + [(b, a) for a, b in seen]))


@some_fast(("src", "dst"), pairs(), fast=[x for x in pairs() if "latlong" in x])
def test_energy_bounds_and_constants(src, dst):
    a, b = sm.projection(src), sm.projection(dst)
    rng = np.random.default_rng(4)
    shape = a.shape(18)
    image = rng.random((*shape, 3)) ** 8
    image[..., 2] = 0.7
    image.reshape(-1, 3)[rng.integers(image.size // 3), 1] = 1e6
    outside = np.isnan(a.directions(18)[..., 0])
    image[outside] = 1e30
    # Both at once: edges that lie on each other, and edges that lie anyhow.
    for rotation in (None, TURN):
        got = area(image, src, dst, 9, rotation=rotation)
        weights = b.solid_angle(got.shape[:-1])
        held = weights > 0
        assert np.all(got[held] >= 0)
        for k in range(3):
            want = energy(image[..., k], src, shape)
            kept = (got[..., k] * weights).sum()
            assert abs(kept - want) <= KEPT * want, (rotation is None, k, kept / want - 1)
            assert got[..., k].max() <= image[..., k][~outside].max()
        assert np.all(got[held][:, 2] == 0.7)
        assert np.all(got[~held] == 0)


def parts_of_the_sphere(cases):
    return [c for c in cases if c.make().coverage != "sphere"]


@each(parts_of_the_sphere(DEFAULTS), slow=parts_of_the_sphere(PARAMETERS))
def test_nothing_that_a_source_sees_is_left_out(case):
    p = case.make()
    got = area(np.ones(p.shape(64)), p, "latlong", 64, rotation=TURN, fill=np.nan)
    seen = ~np.isnan(got)
    # A constant stays that constant, however little of a texel is seen.
    assert np.all(got[seen] == 1)
    finer = np.ascontiguousarray(sm.directions("latlong", 3 * 64) @ TURN)
    covered = p.covers(finer).reshape(64, 3, 128, 3).any((1, 3))
    assert np.all(seen[covered])


TWICE = "dual_fisheye(fov=200)"


@pytest.mark.parametrize(
    ("src", "n", "dst", "m"),
    [
        (TWICE, 40, "latlong", 24),
        (TWICE, 9, "cube", 8),
        ("latlong", 32, TWICE, 40),
        ("octahedral", 20, TWICE, 9),
        (TWICE, 60, "dual_fisheye(fov=260)", 21),
        ("dual_fisheye", 20, TWICE, 30),
        (TWICE, 50, TWICE, 20),
    ],
)
def test_what_two_lenses_see_counts_once(src, n, dst, m):
    a, b = sm.projection(src), sm.projection(dst)
    shape = a.shape(n)
    weights = a.solid_angle(shape)
    # Beside where the one lens begins to count, and anywhere.
    z = a.directions(shape)[..., 2 if a.name == "dual_fisheye" else 1]
    anywhere = np.flatnonzero(weights)
    beside = anywhere[np.argsort(np.abs(z.flat[anywhere]))[:40]]
    rng = np.random.default_rng(n)
    suns = np.r_[rng.choice(beside, 20), rng.choice(anywhere, 20)]
    image = np.zeros((weights.size, 41))
    image[suns, np.arange(40)] = 1e5
    image[:, 40] = 0.7
    image = image.reshape(*shape, 41)
    for rotation in (None, TURN):
        got = area(image, src, dst, m, rotation=rotation, fill=np.nan)
        seen = b.solid_angle(got.shape[:-1])
        kept = np.nansum(got[..., :40] * seen[..., None], axis=tuple(range(seen.ndim)))
        want = [energy(image[..., k], src, shape) for k in range(40)]
        assert np.all(np.abs(kept / want - 1) < KEPT)
        # What a lens sees of the other's half has a value as well.
        held = ~np.isnan(b.directions(got.shape[:-1])[..., 0])
        assert np.all(got[held][:, 40] == 0.7)


def test_a_thousand_suns():
    """One texel each, anywhere: each a channel of an image of 100 channels."""
    rng = np.random.default_rng(1000)
    shape, n = sm.projection("latlong").shape(48), 100
    weights = sm.solid_angle("latlong", shape).reshape(-1)
    target = sm.solid_angle("octahedral", 12)
    for _ in range(10):
        sun = rng.choice(weights.size, n, replace=False)
        image = np.zeros((weights.size, n), np.float32)
        image[sun, np.arange(n)] = 1e5
        got = area(image.reshape(*shape, n), "latlong", "octahedral", 12, rotation=TURN)
        assert got.dtype == np.float32 and got.min() >= 0
        kept = np.einsum("ijk,ij->k", got.astype(float), target)
        # float32 texels round by 6e-8 each.
        assert np.all(np.abs(kept / (1e5 * weights[sun]) - 1) < KEPT)


@pytest.mark.parametrize(("n", "m"), [(128, 1), (128, 2), (1, 7), (3, 20), (1, 1)])
def test_far_from_each_other_in_size(n, m):
    rng = np.random.default_rng(n)
    for src, dst in (("latlong", "cube"), ("octahedral", "latlong")):
        shape = sm.projection(src).shape(n if n < 128 or src == "latlong" else 64)
        image = np.zeros(shape)
        image.reshape(-1)[rng.integers(image.size)] = 1e5
        got = area(image, src, dst, m, rotation=TURN)
        want = (image * sm.solid_angle(src, shape)).sum()
        kept = (got * sm.solid_angle(dst, got.shape)).sum()
        assert abs(kept / want - 1) < KEPT and got.min() >= 0 and got.max() <= 1e5


@cache
def there_and_back(name):
    """An image as the faces of a map, whose layouts have it otherwise, and out of these again."""
    image = np.random.default_rng(7).random((17, 34))
    plain = area(image, "latlong", name, 6, rotation=TURN)
    return plain, area(plain, name, "latlong", 8)


# Maps without layouts are converted in other tests, too.
@each(LAYOUTS, slow=[c for c in LAYOUTS if c.make().layout is None])
def test_layouts(case):
    p = case.make()
    faces = sm.projection(case.name)
    image = np.random.default_rng(7).random((17, 34))
    got = area(image, "latlong", p, 6, rotation=TURN)
    plain, plain_back = there_and_back(case.name)
    weights = p.solid_angle(got.shape)
    kept, want = (got * weights).sum(), (plain * faces.solid_angle(plain.shape)).sum()
    # The same cells, whose places in a layout round otherwise; `isclose` adds its own 1e-8.
    assert np.isclose(kept, want, rtol=1e-12)
    # And back: the layout is only another order of the same texels.
    back = area(got, p, "latlong", 8)
    # The same texels in another order; `allclose` adds its own 1e-8.
    assert np.allclose(back, plain_back, rtol=1e-12)


@pytest.mark.parametrize("grid", ["centers", "corners", "corners-v"])
def test_grids(grid):
    p = sm.projection("latlong", grid=grid)
    image = np.random.default_rng(8).random((12, 24))
    got = area(image, p, "cube", 5, rotation=TURN)
    kept = (got * sm.solid_angle("cube", 5)).sum()
    assert np.isclose(kept, (image * p.solid_angle(image.shape)).sum(), rtol=KEPT)
    back = area(got, "cube", p, (9, 14), any_aspect=True)
    assert np.isclose((back * p.solid_angle(back.shape, any_aspect=True)).sum(), kept, rtol=KEPT)


@pytest.mark.parametrize(
    ("src", "dst"), [("latlong", "octahedral"), ("angular", "latlong"), ("octahedral", "angular")]
)
def test_against_brute_force(src, dst):
    a, b = reference.of(sm.projection(src)), reference.of(sm.projection(dst))
    image = np.random.default_rng(9).random(sm.projection(src).shape(16))
    image[~a.valid(a.texel_uv(image.shape))] = 1e30
    got = area(image, src, dst, 8, rotation=TURN)
    want = reference_area.convert(image, a, b, got.shape, TURN, 48)
    # 48² places a texel, of which those at source edges, about 5 · 48, are a gamble.
    held = sm.solid_angle(dst, got.shape) > 1e-4
    assert np.abs(got - want)[held].max() < 0.02
    # The mean of such errors, which go either way: a sixth of the largest.
    assert np.abs(got - want)[held].mean() < 0.003


def test_the_same_texels_stay():
    image = np.random.default_rng(10).random((20, 40, 2)).astype(np.float32)
    assert np.array_equal(area(image, "latlong", "latlong", 20), image)
    halves = area(image.astype(float), "latlong", "latlong", 10)
    w = sm.solid_angle("latlong", 20)[..., None]

    def blocks(x):
        return x.reshape(10, 2, 20, 2, -1).sum((1, 3))

    # Shares of cells are right to 1e-7 of a texel, and to 1e-9 on the general path.
    assert np.allclose(halves, blocks(image * w) / blocks(w), rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
def test_dtypes(dtype):
    rng = np.random.default_rng(11)
    image = (rng.random((9, 18, 2)) * 200).astype(dtype)
    got = area(image, "latlong", "cube", 4)
    want = area(image.astype(float), "latlong", "cube", 4)
    assert got.dtype == image.dtype
    half = {"uint8": 0.5, "uint16": 0.5, "float16": 0.07, "float32": 1e-5, "float64": 0}[dtype]
    assert np.abs(got.astype(float) - want).max() <= half
    flat = np.full((9, 18), 77, dtype)
    assert np.all(area(flat, "latlong", "cube", 4) == 77)


def test_what_the_source_does_not_cover():
    image = np.ones((16, 16))
    got = area(image, "hemioctahedral", "latlong", 15, fill=-3.0)
    d = sm.directions("latlong", 15)
    # One in part is the mean over that part; none in part is the fill.
    assert set(np.unique(got)) == {-3.0, 1.0}
    assert np.all(got[d[..., 2] > 0] == 1.0) and np.all(got[d[..., 2] < -0.3] == -3.0)
    # Inside, energy is kept: back onto the hemisphere from a sphere of which it is a part.
    rng = np.random.default_rng(12)
    image = rng.random((12, 12))
    whole = area(image, "hemioctahedral", "octahedral", 24)
    kept = (whole * sm.solid_angle("octahedral", 24)).sum()
    # The square's diagonals cut the border's texels: what they hold is counted for all of them.
    assert kept > (image * sm.solid_angle("hemioctahedral", 12)).sum()


@each(DEFAULTS, slow=PARAMETERS)
def test_constants_of_a_hundred_rows(case):
    # Most of their texels take the fast path, to which hostile calls of a few rows do not come.
    p, latlong = case.make(), sm.projection("latlong")
    for src, dst in ((p, latlong), (latlong, p)):
        made = area(np.full(src.shape(128), 3.0), src, dst, 16, fill=np.nan)
        held = np.isfinite(made)
        assert held.any() and (made[held] == 3).all()


@pytest.mark.parametrize(
    "lens", [{"p2": -0.05}, {"p2": 0.05}, {"p1": -0.05}, {"p1": 0.05}], ids=str
)
@pytest.mark.parametrize("size", [16, 33, 64])
def test_a_texel_that_bulges_over_the_edge_of_the_source(lens, size):
    # Its window among the source's texels has a row beyond the last.
    p = sm.projection("camera_unified", **lens)
    image = np.repeat(np.arange(1.0, 129.0)[:, None], 128, axis=1)
    made = area(image, p, "latlong", size, fill=np.nan)
    held = np.isfinite(made)
    assert held.any() and made[held].min() >= 1 and made[held].max() <= 128


def test_credits_never_leak():
    for name in ("angular", "sphere", "dual_paraboloid", "matcap"):
        p = sm.projection(name)
        image = np.ones(p.shape(15))
        image[np.isnan(p.directions(15)[..., 0])] = np.nan
        got = area(image, p, "latlong", 9, fill=1.0, rotation=TURN)
        assert np.all(got == 1.0)


def test_nan():
    image = np.ones((16, 32, 2))
    image[5, 9, 0] = np.nan
    spread = area(image, "latlong", "cube", 4)
    assert 1 <= np.isnan(spread[..., 0]).sum() <= 4 and np.all(spread[..., 1] == 1)
    skipped = area(image, "latlong", "cube", 4, skipna=True)
    assert np.all(skipped == 1)
    alone = area(np.full((16, 32), np.nan), "latlong", "cube", 4, skipna=True)
    assert np.all(np.isnan(alone))
    image[5, 9, 0] = np.inf
    assert np.isinf(area(image, "latlong", "cube", 4)[..., 0]).sum() == np.isnan(spread).sum()


def test_mode():
    rng = np.random.default_rng(13)
    labels = rng.integers(0, 4, (6, 12)).astype(np.uint8) * 60
    labels = labels.repeat(4, 0).repeat(4, 1)
    got = sm.convert(labels, "latlong", "octahedral", size=12, filter="mode", rotation=TURN)
    assert set(np.unique(got)) <= set(np.unique(labels))
    # The label of the largest share, by the conservative shares of each.
    values = np.unique(labels)
    shares = area(
        (labels[..., None] == values).astype(float), "latlong", "octahedral", 12, rotation=TURN
    )
    assert np.array_equal(got, values[np.argmax(shares, -1)])
    assert np.array_equal(sm.convert(labels, "latlong", "latlong", filter="mode"), labels)


def test_the_same_bits_for_any_number_of_threads_and_level():
    image = np.random.default_rng(14).random((30, 60, 3)).astype(np.float32)
    assert_same_bits_everywhere(
        lambda: [area(image, "latlong", "cube", 8, rotation=TURN)], threads=(1, 2, 5)
    )
    kinds = [image, image.astype(np.float16), image.astype(float), (255 * image).astype(np.uint8)]
    assert_same_bits_everywhere(
        lambda: [area(x, "latlong", "mercator", 13) for x in kinds], threads=(1, 2, 5)
    )
    face = np.random.default_rng(14).random((40, 40, 3)).astype(np.float32)
    assert_same_bits_everywhere(
        lambda: [area(face, p, p, 11) for p in ("octahedral", "angular")], threads=(1, 2, 5)
    )


def overlaps(of, among):
    """How long each interval between edges is in each of others."""
    low = np.maximum(of[:-1, None], among[:-1])
    return np.clip(np.minimum(of[1:, None], among[1:]) - low, 0, None)


@pytest.mark.parametrize("size", [5, 12, 40])
@pytest.mark.parametrize("dtype", ["uint8", "float16", "float32", "float64"])
def test_panoramas_share_zones_and_sectors(dtype, size):
    """Archimedes: the zone between two parallels is as large as its height."""
    image = (np.random.default_rng(15).random((24, 48, 3)) * 200).astype(dtype)
    got = area(image, "latlong", "lambert_cylindrical", size)
    height, width = got.shape[:2]
    rows = overlaps(
        np.linspace(-1, 1, height + 1), -np.cos(np.pi * np.linspace(0, 1, len(image) + 1))
    )
    columns = overlaps(np.linspace(0, 1, width + 1), np.linspace(0, 1, image.shape[1] + 1))
    sums = np.einsum("ij,jkc,lk->ilc", rows, image.astype(float), columns)
    want = sums / (rows.sum(1)[:, None] * columns.sum(1))[..., None]
    unit = {"uint8": 1, "float16": 2.0**-3, "float32": 2.0**-16, "float64": 0}[dtype]
    # Half a unit of the type, and overlaps of less than 3e-8 of a texel of at most 200 are none.
    assert np.abs(got - want).max() <= 0.5 * unit + 2e-5


@pytest.mark.parametrize("columns", [1, 7, 12, 24])
def test_a_panorama_turns_about_its_axis(columns):
    image = np.random.default_rng(16).random((24, 48, 2))
    turn = sm.rotation(360 * columns / 48, 0.0, 0.0)
    turned = sm.convert(image, "latlong", "latlong", filter="nearest", rotation=turn)
    assert np.array_equal(turned, np.roll(image, columns, 1)) or np.array_equal(
        turned, np.roll(image, -columns, 1)
    )
    got = area(image, "latlong", "miller", 10, rotation=turn)
    # The same sums but for where edges are rounded.
    assert np.allclose(got, area(turned, "latlong", "miller", 10), rtol=1e-12)


@pytest.mark.parametrize(
    "program",
    [c["name"] for c in sm.conventions("latlong") if c["grid"] == "centers"],
)
def test_every_program_has_the_same_texels(program):
    image = np.random.default_rng(17).random((8, 16, 2))
    world = f"latlong:{program}"
    moved = sm.convert(image, "latlong", world, size=8, filter="nearest")
    # One share each, which rounding keeps from 1.
    assert np.allclose(area(image, "latlong", world, 8), moved, rtol=1e-12)


def test_panoramas_in_part():
    """Nothing below the horizon, no poles in a Mercator's square, and half of the way around."""
    image = np.ones((6, 24))
    got = area(image, "hemi_latlong", "latlong", 10, fill=-3.0)
    assert np.all(got[:5] == 1.0) and np.all(got[5:] == -3.0)
    half = sm.projection("cylindrical", fov=180.0, aspect=2.0)
    got = area(np.ones(half.shape(8)), half, "latlong", 16, fill=-3.0)
    assert np.all(got[:, :8] == -3.0) and np.all(got[:, 24:] == -3.0)
    assert np.all(got[7:9, 8:24] == 1.0) and np.all(got[0] == -3.0)
    poles = area(np.ones(sm.projection("mercator").shape(32)), "mercator", "latlong", 90, fill=-3.0)
    # 85.05 degrees are the edge.
    assert np.all(poles[[0, 1, -2, -1]] == -3.0) and np.all(poles[2:-2] == 1.0)


def test_nan_in_a_panorama():
    image = np.ones((16, 32, 2))
    image[5, 9, 0] = np.nan
    spread = area(image, "latlong", "latlong", 8)
    assert np.argwhere(np.isnan(spread)).tolist() == [[2, 4, 0]]
    assert np.all(area(image, "latlong", "latlong", 8, skipna=True) == 1)
    image[4:6, 8:10, 1] = np.nan
    assert np.isnan(area(image, "latlong", "latlong", 8, skipna=True)[2, 4, 1])


def test_errors():
    image = np.ones((8, 16))
    with pytest.raises(ValueError, match="shape"):
        area(np.ones((8, 16)), "cube", "latlong", 4)
    with pytest.raises(ValueError, match="overlaps"):
        sm.convert(image, "latlong", "latlong", size=8, filter="area", out=image)
    out = np.empty((6, 4, 4))
    assert area(image, "latlong", "cube", 4, out=out) is out and np.all(out == 1)
    assert np.all(area(image[::-1, ::-1], "latlong", "cube", 4) == 1)


@each(DEFAULTS, slow=PARAMETERS)
def test_a_copy_in_another_size_keeps_its_light(case):
    p = case.make()
    shape = p.shape(24)
    outside = np.isnan(p.directions(shape)[..., 0])
    rng = np.random.default_rng(18)
    image = rng.random((*shape, 2)) ** 8
    image[..., 1] = 0.7
    image.reshape(-1, 2)[rng.choice(np.flatnonzero(~outside)), 0] = 1e5
    want = energy(image[..., 0], p, shape)
    image[outside] = 1e30
    # Texels on each other, across each other, and finer ones.
    for size in (8, 11, 37):
        got = area(image, p, p, size)
        weights = p.solid_angle(got.shape[:-1])
        assert abs((got[..., 0] * weights).sum() / want - 1) <= KEPT, size
        held = weights > 0
        if case.name == "dual_fisheye":
            # A lens that sees some of the other's half has values there as well, and no light.
            edges = np.linspace(-1, 1, size + 1)
            nearest = np.clip(0, edges[:-1], edges[1:])
            held |= np.hypot(nearest, nearest[:, None]) < 1
        assert np.all(got[held][:, 1] == 0.7) and np.all(got[~held] == 0)


def test_copies_in_other_layouts_and_grids():
    image = np.random.default_rng(19).random((6, 20, 20))
    small = area(image, "cube", "cube", 7)
    cross = sm.projection("cube", layout="cross")
    there = area(image, "cube", cross, 7)
    back = sm.convert(there, cross, "cube", size=7, filter="nearest")
    # The same cells in another order; `allclose` adds its own 1e-8.
    assert np.allclose(back, small, rtol=1e-12)
    p = sm.projection("octahedral", grid="corners")
    image = np.random.default_rng(20).random(p.shape(25))
    kept = (area(image, p, p, 9) * p.solid_angle(9)).sum()
    assert np.isclose(kept, (image * p.solid_angle(25)).sum(), rtol=KEPT)


@pytest.mark.parametrize("name", ["cube", "cube_equiangular", "octahedral", "healpix"])
def test_blocks_are_means_by_solid_angle(name):
    p = sm.projection(name)
    image = np.random.default_rng(21).random(p.shape(36))
    w = p.solid_angle(36)

    def blocks(x):
        return x.reshape(-1, x.shape[-2] // 3, 3, x.shape[-1] // 3, 3).sum((2, 4))

    got = area(image, p, p, 12)
    # Shares are right to 1e-8 of a texel's solid angle.
    assert np.allclose(got.reshape(blocks(w).shape), blocks(image * w) / blocks(w), rtol=1e-7)
    # What is far from each other in size is cut first.
    for n in (1, 2, 5):
        kept = (area(image, p, p, n) * p.solid_angle(n)).sum()
        assert np.isclose(kept, (image * w).sum(), rtol=KEPT)


def test_the_label_of_the_most_in_a_copy():
    labels = np.random.default_rng(22).integers(0, 5, (6, 9, 9)).astype(np.uint8)
    copy = sm.convert(labels.repeat(4, 1).repeat(4, 2), "cube", "cube", size=9, filter="mode")
    assert np.array_equal(copy, labels)
