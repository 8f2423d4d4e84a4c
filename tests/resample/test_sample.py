"""Looking images up: constants, smooth functions across every seam, poison, dtypes, shapes."""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import hard_directions
import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import (
    DEFAULTS,
    GRIDS,
    LAYOUTS,
    NARROW,
    PARAMETERS,
    Case,
    each,
    random_directions,
    some_fast,
)

each_filter = pytest.mark.parametrize("filter", NARROW)
DTYPES = ("uint8", "uint16", "float16", "float32", "float64")
# A value that no filter can hide: what lies outside the valid image.
POISON = {"uint8": 255, "uint16": 65535, "float16": 6e4, "float32": 1e30, "float64": 1e30}
CONSTANT = {"uint8": 137, "uint16": 40001, "float16": 0.1, "float32": 0.1, "float64": 0.1}
# The largest slope of any channel of reference.smooth_function; measured, tested there (< 2.9).
SLOPE = 2.9
MORE_LAYOUTS = [c for c in LAYOUTS if c not in DEFAULTS]
# Directions take longest to be found in them.
HEAVY = [c for c in DEFAULTS if c.name in ("mollweide", "cube_equal_area")]
ONE_FACE = [c for c in LAYOUTS if c.make().layout in (None, "faces")]


def outside(p: sm.Projection, shape: tuple[int, ...] | int) -> np.ndarray:
    """Texels whose centers hold no sphere."""
    return np.isnan(p.directions(shape)[..., 0])


def hard_and_random(p: sm.Projection, n: int = 6000) -> np.ndarray:
    d = hard_directions.hard(np.float64)[::3]
    size = np.max(np.abs(d), axis=-1)
    d = d[(size > 1e-100) & (size < 1e100)]  # so that plain arithmetic can judge
    d = np.concatenate([d / np.max(np.abs(d), axis=-1, keepdims=True), random_directions(n, 70)])
    return d[p.covers(d)]


def constant_image(p: sm.Projection, shape: tuple[int, ...], dtype: str, channels: tuple[int, ...]):
    image = np.full((*shape, *channels), CONSTANT[dtype], dtype)
    image[outside(p, shape)] = POISON[dtype]
    return image


# --- constants ------------------------------------------------------------------------------


@each(DEFAULTS, slow=[*HEAVY, *MORE_LAYOUTS, *PARAMETERS])
@each_filter
def test_constant_image_is_constant_to_the_bit(case, filter):
    p = case.make()
    d = hard_and_random(p, 2000)
    for dtype, size in product(DTYPES, (1, 2, 5, 16)):
        shape = p.shape(size)
        if p.grid != "centers" and size == 1:
            continue
        if outside(p, shape).all():
            continue
        image = constant_image(p, shape, dtype, (3,))
        for directions in (d, d.astype(np.float32)):
            directions = directions[p.covers(directions)]
            got = p.sample(image, directions, filter=filter)
            assert got.dtype == image.dtype and got.shape == (len(directions), 3)
            wrong = got != np.array(CONSTANT[dtype], dtype)
            where = directions[wrong.any(-1)][:3]
            assert not wrong.any(), (dtype, size, where, got[wrong][:3])


@each(LAYOUTS)
@each_filter
@pytest.mark.parametrize("channels", [(), (1,), (2,), (3,), (4,), (5,), (9,)])
def test_any_number_of_channels(case, filter, channels):
    p = case.make()
    rng = np.random.default_rng(71)
    shape = p.shape(6)
    image = rng.random((*shape, *channels)).astype(np.float32)
    d = random_directions(500, 72)
    got = p.sample(image, d, filter=filter)
    assert got.shape == (500, *channels)
    flat = image.reshape(*shape, -1)
    for c in range(flat.shape[-1]):
        one = p.sample(np.ascontiguousarray(flat[..., c]), d, filter=filter)
        assert np.array_equal(got.reshape(500, -1)[:, c], one, equal_nan=True)


@each(DEFAULTS)
@each_filter
@pytest.mark.parametrize("grid", GRIDS[1:])
def test_constant_on_corner_grids(case, filter, grid):
    p = case.make(grid=grid)
    d = hard_and_random(p, 2000)
    for size in (2, 3, 16):
        if outside(p, p.shape(size)).all():
            continue  # 2 × 2 on corners: a disk holds none of them
        image = constant_image(p, p.shape(size), "float32", (3,))
        got = p.sample(image, d, filter=filter)
        assert np.all(got == np.float32(0.1)), (size, d[np.any(got != np.float32(0.1), -1)][:3])


@each(LAYOUTS)
@each_filter
def test_extreme_constants(case, filter):
    p = case.make()
    d = hard_and_random(p, 500)
    for value in (np.finfo(np.float32).max, np.finfo(np.float32).tiny, -3.7e30, 1 / 3):
        image = np.full((*p.shape(8), 3), value, np.float32)
        assert np.all(p.sample(image, d, filter=filter) == np.float32(value)), value


# --- smooth functions -----------------------------------------------------------------------


def steps(r: reference.Reference, uv: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Angle that one texel spans at uv, in u plus in v, from the reference; nudged inside."""
    e = 1e-5
    p, q, _ = r.local(uv)
    rows, columns = 1, 1
    if r.layout not in (None, "faces"):
        rows, columns, _ = reference.LAYOUTS[r.name][r.layout]
    inside = uv.copy()
    shrink = 1 - 1e-3
    # Toward the center of the face, in p and q, by a thousandth.
    if r.layout in (None, "faces"):
        inside[:, 0] = (p * shrink + 1) / 2
        inside[:, 1] = (q * shrink + 1) / 2
    else:
        cell = np.floor(np.clip(uv[:, :2], 0, 1 - 1e-12) * [columns, rows])
        local = uv[:, :2] * [columns, rows] - cell
        inside[:, :2] = (cell + 0.5 + (local - 0.5) * shrink) / [columns, rows]
    out = np.zeros(len(uv))
    for k, n in ((0, shape[-1]), (1, shape[-2])):
        move = np.zeros(uv.shape[-1])
        move[k] = e
        a, b = r.decode(inside + move), r.decode(inside - move)
        out += np.nan_to_num(np.linalg.norm(a - b, axis=-1) / (2 * e), nan=0.0) / n
    return out


_CURVATURES: dict[tuple[object, ...], float] = {}


def curvature(r: reference.Reference, shape: tuple[int, ...], inner: float) -> float:
    """Bilinear error of the smooth function in the smooth interior: max (|f_uu| + |f_vv|)/8."""
    # The grid does not matter here, and the filter neither.
    map_of = (r.name, r.axes, r.layout, r.convention, *r.parameters.items())
    key = (*map_of, shape, inner)
    if key not in _CURVATURES:
        _CURVATURES[key] = _curvature(r, shape, inner)
    return _CURVATURES[key]


def _curvature(r: reference.Reference, shape: tuple[int, ...], inner: float) -> float:
    rng = np.random.default_rng(73)
    uv = rng.random((20_000, 2))
    if r.faces > 1:
        uv = np.concatenate([uv, rng.integers(0, r.faces, (len(uv), 1)).astype(float)], -1)
    p, q, face = r.local(uv)
    h = np.array([1 / shape[-1], 1 / shape[-2]])
    keep = ~np.isnan(p)
    if r.is_disk:
        keep &= p * p + q * q < inner * inner
    margin = 4 * float(h.max()) * (1 if r.layout in (None, "faces") else 6)
    keep &= r.off_creases(p, q, min(margin, 0.2))
    uv, face = uv[keep], face[keep]
    f = reference.smooth_function
    total = np.zeros((len(uv), 3))
    same = np.ones(len(uv), bool)
    for k in (0, 1):
        move = np.zeros(uv.shape[-1])
        move[k] = h[k]
        with np.errstate(invalid="ignore"):
            for side in (uv + move, uv - move):
                same &= r.local(side)[2] == face
            second = f(r.decode(uv + move)) + f(r.decode(uv - move)) - 2 * f(r.decode(uv))
        total += np.abs(second) / 8
    return float(np.nanmax(total[same]))


def nearest_held(r: reference.Reference, p: np.ndarray, q: np.ndarray) -> tuple:
    """Bring places beyond the outline of a face back to it."""
    if r.is_disk:
        norm = np.maximum(np.hypot(p, q), 1)
        return p / norm, q / norm
    p, q = np.clip(p, -1, 1), np.clip(q, -1, 1)
    if r.name == "sinusoidal":
        width = np.cos(np.pi / 2 * q) * (1 - 1e-9)
        p = np.clip(p, -width, width)
    return p, q


def resolution(r: reference.Reference, uv: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Largest angle from uv to any place within one and a half texels of it that holds sphere."""
    p, q, face = r.local(uv)
    here = reference.FORMULAS[r.name].decode(p, q, face, r.parameters)
    worst = np.zeros(len(uv))
    reach = 3 / min(shape[-1], shape[-2])  # 1.5 texels in p
    for a in np.linspace(0, 2 * np.pi, 16, endpoint=False):
        for scale in (0.5, 1.0, 1.4143):
            pp, qq = p + reach * scale * np.cos(a), q + reach * scale * np.sin(a)
            pp, qq = nearest_held(r, pp, qq)
            there = reference.FORMULAS[r.name].decode(pp, qq, face, r.parameters)
            dot = np.clip(np.sum(here * np.nan_to_num(there), axis=-1), -1, 1)
            worst = np.maximum(worst, np.arccos(dot))
    return worst


# A bilinear filter meets a kink (a jump of slope) of the image of a smooth function where the map
# has a crease. In the middle between two texels it errs by |a - b|/4 texels for slopes a and b.
# Octahedron: |a - b|/|a| is √2 at most (in the equator's corners); cube: 1 (at a corner, where
# lines turn by 60°); a rim met by another face or by itself: √2 as well. So 0.36 of the change
# over one texel, where a lookup that is off by half a texel would be wrong by 0.5.
# At the tip of a cone, as in the middle of equal-area squares, slopes may be opposite: 2, so 0.5.
# What is beside a tip is farther than a step says, for the nearest texel, too.
# Three triangles meet at a vertex of the tetrahedron, and five at one of the icosahedron.
CONES = ("equal_area", "concentric", "cube_equal_area", "healpix", "tetrahedral", "icosahedral")
TIPS = dict.fromkeys(CONES, 0.5)
KINK = {"octahedral": 0.36, "hemioctahedral": 0.36, "cube": 0.36, **TIPS}
RIM_KINK = {"angular": 0.36, "dual_paraboloid": 0.36, "dual_fisheye": 0.36}
# Where the interior ends, in p and q: beyond it texels see more without bound, or meet a seam that
# is no line of texels.
INNER = {"sphere": 0.75, "matcap": 0.75, "mollweide": 0.93, "hammer": 0.93}


# uv, and the angle that a texel spans there.
Places = tuple[np.ndarray, np.ndarray]


def places(r: reference.Reference, d: np.ndarray, shape: tuple[int, ...]) -> Places:
    uv = r.encode(d)
    return uv, steps(r, uv, shape)


def smooth_bound(
    r: reference.Reference,
    d: np.ndarray,
    shape: tuple[int, ...],
    filter: str,
    at: Places | None = None,
) -> np.ndarray:
    uv, step = at or places(r, d, shape)
    inner = INNER.get(r.name, 0.97)
    second = 1.15 * curvature(r, shape, inner)
    kink = KINK.get(r.name, 0.0)
    bound = np.full(len(d), second) + kink * SLOPE * step
    if filter == "nearest":
        # Half a texel either way, a bit more where the scale changes across a seam.
        bound = SLOPE * ((0.6 + TIPS.get(r.name, 0)) * step) + 8 * second
    if r.covered_solid_angle < 12.5:
        # An end of the world: the border clamps. A lookup beyond the last texel centers gets
        # their value: half a texel off along each side, and at a rim, where the last whole square
        # of texels is meant, up to one and a half diagonals.
        p, q, _ = r.local(uv)
        last = 2 * 1.5 / min(shape[-2:])
        square = np.maximum(np.abs(p), np.abs(q)) > 1 - last
        border = np.hypot(p, q) > 1 - 2 * last if r.is_disk else square
        bound = bound + np.where(border, (1.5 if r.is_disk else 0.55) * SLOPE * step, 0)
    if r.is_disk:
        p, q, _ = r.local(uv)
        radius = np.hypot(p, q)
        rim = radius > 1 - 2 * 3 / min(shape[-2:]) * (2 if r.layout not in (None, "faces") else 1)
        if r.name in RIM_KINK and filter == "bilinear":
            bound = bound + np.where(rim, RIM_KINK[r.name] * SLOPE * step, 0)
        elif r.name in RIM_KINK:
            # Nearest, at the rim: the nearest valid texel may be one diagonal further.
            bound = bound + np.where(rim, SLOPE * step, 0)
        else:
            bound = np.where(radius > inner, SLOPE * resolution(r, uv, shape) + bound, bound)
    elif r.name in ("lambert_cylindrical", "sinusoidal"):
        p, q, _ = r.local(uv)
        # Its rows beside a pole are high; its rim is no line of texels.
        last = 16 / min(shape[-2:])
        outer = np.abs(q) > 1 - last
        if r.name == "sinusoidal":
            outer |= np.abs(p) > np.cos(np.pi / 2 * np.minimum(np.abs(q) + last / 4, 1)) - last / 4
        bound = np.where(outer, SLOPE * resolution(r, uv, shape) + bound, bound)
    return bound + 1e-12


# Tests of all filters for a map follow each other.
@lru_cache(maxsize=2)
def smooth_scene(
    case: Case, size: int, more: tuple[tuple[str, str], ...]
) -> tuple[reference.Reference, np.ndarray, np.ndarray, Places]:
    """Give a map, an image of the smooth function, and directions with their places."""
    p = case.make(**dict(more))
    r = reference.of(p)
    texels = r.directions(size)
    image = np.where(np.isnan(texels), 1e30, reference.smooth_function(texels))
    d = hard_and_random(p)
    d = d[r.covers(d)]
    return r, image, d, places(r, d, p.shape(size))


def check_smooth(case: Case, size: int, filter: str, **more: str) -> None:
    p = case.make(**more)
    shape = p.shape(size)
    r, image, d, at = smooth_scene(case, size, tuple(more.items()))
    got = p.sample(image, d, filter=filter)
    assert not np.isnan(got).any(), d[np.isnan(got).any(-1)][:3]
    error = np.abs(got - reference.smooth_function(reference.unit(d))).max(axis=-1)
    limit = smooth_bound(r, d, shape, filter, at)
    bad = error > limit
    i = int(np.argmax(error / limit))
    assert not bad.any(), (
        f"{np.count_nonzero(bad)} of {len(d)} lookups; worst {error[i]:.4g} where {limit[i]:.4g} "
        f"is the bound, at direction {d[i].tolist()}, uv {r.encode(d[i]).tolist()}, shape {shape}"
    )


@each_filter
@each(DEFAULTS, slow=[*MORE_LAYOUTS, *PARAMETERS])
def test_smooth_function_comes_back_everywhere(case, filter):
    check_smooth(case, 48, filter)


@some_fast("filter", NARROW, fast=("bilinear",))
@each(DEFAULTS)
def test_smooth_function_at_an_odd_size(case, filter):
    check_smooth(case, 65, filter)


@each_filter
@each([c for c in DEFAULTS if c.make().layout is None])
@some_fast("grid", GRIDS[1:], fast=("corners",))
def test_smooth_function_on_corner_grids(case, filter, grid):
    check_smooth(case, 49, filter, grid=grid)


@each(ONE_FACE)
def test_error_falls_with_the_square_of_the_texel_at_seams_as_elsewhere(case):
    # Means over directions near the image's borders and over the others, at n and 2n.
    # (Evenly spread ones: hard directions gather at the tips of cones, which err with the first
    # power on a share h² of the image.)
    p, r = case.make(), case.reference()
    d = random_directions(20_000, 70)
    d = d[p.covers(d)]
    uv = r.encode(d)
    a, b, _ = r.local(uv)
    edge = np.hypot(a, b) > 0.96 if r.is_disk else np.maximum(np.abs(a), np.abs(b)) > 0.96
    means = []
    for size in (48, 96):
        texels = r.directions(size)
        image = np.where(np.isnan(texels), 1e30, reference.smooth_function(texels))
        error = np.abs(p.sample(image, d) - reference.smooth_function(reference.unit(d))).max(-1)
        means.append((error[edge].mean(), error[~edge].mean()))
    (seam1, inner1), (seam2, inner2) = means
    # h²: 4; the octahedral creases inside the image are of first order on a share h of it, so
    # their mean falls by 4 too. Random scatter of these means is a few percent.
    assert inner1 / inner2 > 3
    if case.name in reference.ROOT_RIMS:
        assert seam2 < seam1 / 1.3  # √h at the rim, where the map itself degenerates
    elif p.coverage != "sphere":
        assert seam1 / seam2 > 1.8  # h: the border clamps, and nothing lies beyond it
    else:
        assert seam1 / seam2 > 1.8
        assert seam2 < 12 * inner2


def test_latlong_seam_and_poles_are_as_good_as_the_interior():
    p = sm.projection("latlong", axes="+x +y +z")
    r = reference.of(p)
    n = 90
    image = reference.smooth_function(r.directions(n))
    rng = np.random.default_rng(74)
    near_seam = np.stack(
        [rng.normal(size=4000) * 1e-3, rng.uniform(-1, 1, 4000), -np.ones(4000)], -1
    )
    near_pole = np.stack(
        [rng.normal(size=4000) * 0.01, rng.choice([-1.0, 1.0], 4000), rng.normal(size=4000) * 0.01],
        -1,
    )
    inner = random_directions(8000, 75)
    uv = r.encode(inner)
    inner = inner[(uv[:, 0] > 0.05) & (uv[:, 0] < 0.95) & (uv[:, 1] > 0.05) & (uv[:, 1] < 0.95)]

    def worst(d):
        return np.abs(p.sample(image, d) - reference.smooth_function(reference.unit(d))).max()

    assert worst(near_seam) <= 1.02 * worst(inner)
    assert worst(near_pole) <= 1.02 * worst(inner)


@each(DEFAULTS)
def test_bilinear_is_continuous_across_seams(case):
    # Two directions 1e-9 apart on either side of a seam see nearly the same bilinear value.
    p = case.make()
    rng = np.random.default_rng(76)
    image = rng.random((*p.shape(16), 1))
    rows = []
    for plane in range(3):
        d = random_directions(400, 77 + plane)
        d[:, plane] = 0
        rows.append(d)
    for a in (1, -1):
        d = random_directions(400, 80)
        d[:, 0] = a * d[:, 1]
        rows.append(d)
        d = random_directions(400, 81)
        d[:, 1] = a * d[:, 2]
        rows.append(d)
        d = random_directions(400, 82)
        d[:, 0] = a * d[:, 2]
        rows.append(d)
    d = reference.unit(np.concatenate(rows))
    step = 1e-9 * random_directions(len(d), 83)
    one, two = d + step, d - step
    both = p.covers(one) & p.covers(two)
    if p.seam.startswith("rim-other-face") or p.seam == "rim-mirrored":
        # Texels do not line up along the rim, and each side gives its own centers back exactly: on
        # white noise they differ there. A smooth function comes back with second order, which
        # another test asks for.
        both &= np.abs(one[:, 0 if p.seam == "rim-mirrored" else 2]) > 1e-6
    a, b = p.sample(image, one[both]), p.sample(image, two[both])
    jump = np.abs(a - b).max(-1)
    # Slope of the noise: 1 a texel in u and v, 16 texels over a map that spans π or 2π; toward
    # the blind spot of the sphere map √(1e-9) of it.
    limit = np.full(len(a), {"sphere": 5e-3, "matcap": 5e-3}.get(case.name, 1e-6))
    if case.name in reference.POLES | {"miller", "hemi_latlong"}:
        # Near a pole the same step is a larger part of a turn.
        limit /= np.hypot(one[both][:, 0], one[both][:, 2])
    i = int(np.argmax(jump / limit))
    assert np.all(jump < limit), (one[both][i].tolist(), jump[i])


@each(LAYOUTS, slow=PARAMETERS)
def test_bilinear_is_continuous_inside_a_face(case):
    # Along lines across the image, in steps of 1e-5, white noise must not jump: its slope is at
    # most 2 a texel and axis, so a step may change it by 2·2·12·1e-5·columns.
    p, r = case.make(), case.reference()
    rng = np.random.default_rng(99)
    image = rng.random(p.shape(12))
    columns = 1 if p.layout in (None, "faces") else max(reference.LAYOUTS[p.name][p.layout][:2])
    t = np.arange(0, 0.06, 1e-5)
    for _ in range(20):
        a = rng.uniform(0, 2 * np.pi)
        start = rng.random(2)
        if r.is_disk:
            b = rng.uniform(0, 2 * np.pi)
            start = 0.5 + 0.48 * np.array([np.cos(b), np.sin(b)])
        uv = start / columns + t[:, None] * [np.cos(a), np.sin(a)] / columns
        if r.faces > 1:
            uv = np.concatenate([uv, np.zeros((len(uv), 1))], -1)
        ok = r.valid(uv)
        face = r.local(uv)[2]
        value = p.sample(image, p.decode(uv))
        # The rim's last 1e-6 rounds to the other side of the world on a sphere map.
        if case.name == "dual_fisheye":
            # Where pictures overlap, the hemisphere tells which one a direction is looked up in.
            ok &= p.encode(p.decode(uv))[:, -1] == uv[:, -1] if r.faces > 1 else ok
        pair = ok[1:] & ok[:-1] & (face[1:] == face[:-1])
        jump = np.abs(np.diff(value))[pair]
        if len(jump):
            where = uv[1:][pair][np.argmax(jump)]
            # 2·2·12·1e-5 for each column of a layout, of which there are up to four.
            assert jump.max() < 2e-3, f"jumps by {jump.max():.3f} at uv {where.tolist()}"


# --- poison ---------------------------------------------------------------------------------


@each(DEFAULTS, slow=[*HEAVY, *MORE_LAYOUTS, *PARAMETERS])
@each_filter
def test_nothing_leaks_from_outside_the_valid_image(case, filter):
    p = case.make()
    rng = np.random.default_rng(84)
    d = hard_and_random(p, 4000)
    for dtype, size in product(DTYPES, (2, 7, 24)):
        shape = p.shape(size)
        out = outside(p, shape)
        if out.all():
            continue
        image = rng.integers(10, 100, (*shape, 3)).astype(dtype)
        clean = image.copy()
        image[out] = POISON[dtype]
        clean[out] = 50
        got = p.sample(image, d, filter=filter)
        assert got.min() >= 10 and got.max() < 100, (dtype, size, got.max())
        assert np.array_equal(got, p.sample(clean, d, filter=filter))
        if dtype in ("float32", "float64"):
            image[out] = np.nan
            assert np.array_equal(got, p.sample(image, d, filter=filter))
            image[out] = np.inf
            assert np.array_equal(got, p.sample(image, d, filter=filter))


@each(LAYOUTS)
def test_nearest_returns_a_texel_that_exists(case):
    p = case.make()
    shape = p.shape(9)
    out = outside(p, shape)
    image = np.arange(out.size, dtype=np.float64).reshape(shape)
    allowed = image[~out]
    d = hard_and_random(p)
    got = p.sample(image, d, filter="nearest")
    assert np.isin(got, allowed).all()
    # And every valid texel is seen by somebody looking at its center.
    centers = p.directions(9)[~out]
    got = p.sample(image, centers, filter="nearest")
    # Two texels whose centers lie on the rim are one direction.
    other = got != allowed
    shown = centers[np.searchsorted(allowed, got[other])]
    # The same direction twice: some ε of a unit vector.
    assert np.abs(shown - centers[other]).max(initial=0) < 1e-15


@each(LAYOUTS)
def test_bilinear_at_texel_centers_is_the_texel(case):
    p = case.make()
    rng = np.random.default_rng(85)
    image = rng.random((*p.shape(12), 3))
    d = p.directions(12)
    ok = ~np.isnan(d[..., 0])
    got = p.sample(image, d[ok])
    # x = u·W - ½ is off by a few eps·W; the slope is at most 1 a texel. Sphere and matcap: the
    # rim texels' √eps is undone by encode, which is well conditioned there.
    assert np.abs(got - image[ok]).max() < 1e-12


@each([c for c in LAYOUTS if c.make().layout is None])
@each_filter
def test_interior_against_the_reference(case, filter):
    p, r = case.make(), case.reference()
    rng = np.random.default_rng(86)
    image = rng.random((*p.shape(37), 2))
    d = random_directions(20_000, 87)
    d = d[r.covers(d)]
    want, plain = r.sample_interior(image, d, filter)
    assert plain.mean() > 0.7
    got = p.sample(image, d, filter=filter)
    # Places are off by some ε of 74 columns, and noise rises by less than 1 a texel.
    assert np.abs(got - want)[plain].max() < 1e-12


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_integers_are_rounded_once(dtype):
    p = sm.projection("octahedral")
    r = reference.of(p)
    rng = np.random.default_rng(88)
    image = rng.integers(0, np.iinfo(dtype).max, (32, 32, 3), endpoint=True).astype(dtype)
    d = random_directions(20_000, 89)
    want, plain = r.sample_interior(image, d, "bilinear")
    got = p.sample(image, d)
    # Half for rounding, and float32 weights of 16-bit numbers.
    slack = 1e-3 if dtype == "uint8" else 0.05
    assert np.abs(got.astype(float) - want)[plain].max() <= 0.5 + slack
    exact = p.sample(image.astype(np.float64), d)
    assert np.abs(got.astype(float) - exact).max() <= 0.5 + slack


def test_half_floats_are_filtered_in_float():
    p = sm.projection("octahedral")
    rng = np.random.default_rng(90)
    image = rng.random((32, 32, 3)).astype(np.float16)
    d = random_directions(5000, 91)
    got = p.sample(image, d)
    exact = p.sample(image.astype(np.float64), d)
    assert got.dtype == np.float16
    # Half an ulp of a number below 1 is 2^-12.
    assert np.abs(got.astype(float) - exact).max() <= 2.0**-12 * 1.01


# --- fill, coverage, shapes -----------------------------------------------------------------


@each_filter
@pytest.mark.parametrize("dtype", DTYPES)
def test_fill_of_what_is_not_covered(filter, dtype):
    image = np.ones((8, 8, 3), dtype)
    d = np.array([[0, 0, 1.0], [0, 0, -1], [np.nan, 0, 0], [0, 0, 0], [0.1, 0.1, -0.5]])
    got = sm.sample(image, d, "matcap", filter=filter)
    assert np.all(got[0] == 1) and np.all(got[1:] == 0)
    got = sm.sample(image, d, "matcap", filter=filter, fill=7)
    assert np.all(got[0] == 1) and np.all(got[1:] == 7)
    # A projection of the whole sphere fills for what is no direction, too.
    got = sm.sample(image, d[2:4], "octahedral", filter=filter, fill=9)
    assert np.all(got == 9)


@each_filter
def test_hemispheres_clamp_at_their_border(filter):
    # Just inside the equator: the value of the rim's own texels, nothing from elsewhere.
    for name in ("matcap", "hemioctahedral"):
        p = sm.projection(name, axes="+x +y +z")
        n = 32
        texels = p.directions(n)
        image = np.where(np.isnan(texels), 1e30, 1 + texels)
        a = np.linspace(0, 2 * np.pi, 100)
        d = np.stack([np.cos(a), np.sin(a), np.zeros_like(a)], -1)
        got = p.sample(image, d, filter=filter)
        # One and a half texels in angle at the rim; the matcap's is √(2·3/n).
        limit = 0.45 if name == "matcap" else 3.5 / n * 2
        assert np.abs(got - (1 + d)).max() < limit


def test_leading_shapes_and_scalars():
    image = np.random.default_rng(92).random((4, 8, 3))
    assert sm.sample(image, [1.0, 0, 0], "latlong").shape == (3,)
    assert sm.sample(image, np.ones((2, 5, 3)), "latlong").shape == (2, 5, 3)
    assert sm.sample(image, np.ones((0, 3)), "latlong").shape == (0, 3)
    assert sm.sample(image[..., 0], np.ones((2, 5, 3)), "latlong").shape == (2, 5)
    assert sm.sample(image[..., 0], [1.0, 0, 0], "latlong").shape == ()


def test_out_of_sample():
    image = np.random.default_rng(93).random((8, 8, 3)).astype(np.float32)
    d = random_directions(40, 94)
    out = np.empty((40, 3), np.float32)
    assert sm.sample(image, d, "octahedral", out=out) is out
    assert np.array_equal(out, sm.sample(image, d, "octahedral"))
    with pytest.raises(ValueError, match="out"):
        sm.sample(image, d, "octahedral", out=np.empty((40, 4), np.float32))
    with pytest.raises(TypeError, match="out"):
        sm.sample(image, d, "octahedral", out=np.empty((40, 3), np.float64))
    with pytest.raises(ValueError, match="out"):
        sm.sample(image, d, "octahedral", out=image.reshape(-1, 3)[:40])


@each(DEFAULTS)
def test_rotation_turns_the_content(case):
    p = case.make()
    turn = sm.rotation(30, -20, 75)
    rng = np.random.default_rng(95)
    image = rng.random((*p.shape(10), 2))
    d = random_directions(300, 96)
    a = p.sample(image, d, rotation=turn)
    b = p.sample(image, d @ turn)  # Rᵀ d, row by row
    assert np.array_equal(np.isnan(a), np.isnan(b))
    ok = ~np.isnan(a)
    # The turned direction rounds by ε, magnified beside poles, and noise rises by 1 a texel.
    assert np.abs(a - b)[ok].max() < 1e-12


@each(DEFAULTS)
@each_filter
def test_strided_and_reversed_images(case, filter):
    p = case.make()
    rng = np.random.default_rng(97)
    shape = p.shape(8)
    d = random_directions(300, 98)
    plain = rng.random((*shape, 3)).astype(np.float32)
    want = p.sample(plain, d, filter=filter)
    wide = np.zeros((*shape, 7), np.float32)
    wide[..., 1:7:2] = plain
    views = {
        "strided channels": wide[..., 1:7:2],
        "fortran": np.asfortranarray(plain),
        "reversed rows": np.ascontiguousarray(plain[..., ::-1, :, :])[..., ::-1, :, :],
        "reversed channels": np.ascontiguousarray(plain[..., ::-1])[..., ::-1],
        "transposed": np.ascontiguousarray(np.swapaxes(plain, -2, -3)).swapaxes(-2, -3),
    }
    for what, view in views.items():
        assert np.array_equal(view, plain)
        assert np.array_equal(p.sample(view, d, filter=filter), want, equal_nan=True), what
    frozen = plain.copy()
    frozen.flags.writeable = False
    assert np.array_equal(p.sample(frozen, d, filter=filter), want, equal_nan=True)
