"""Hard directions through every projection, in float32 and float64, against the reference."""

from __future__ import annotations

import hard_directions
import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import CASES, DEFAULTS, PARAMETERS, each, round_trip_limit

DTYPES = (np.float32, np.float64)
each_dtype = pytest.mark.parametrize("dtype", DTYPES, ids=["f32", "f64"])
HARD = {dtype: hard_directions.hard(dtype) for dtype in DTYPES}


def bound(r: reference.Reference, dtype: type) -> float:
    # What is claimed holds at the default parameters. A fisheye that stretches more than it does
    # there, and more than the angular map's 2π per unit of u, rounds as much more.
    claimed = max(2 * np.pi, reference.make(r.name).stretch)
    return round_trip_limit(r.name, dtype) * max(1.0, r.stretch / claimed)


def worst(error: np.ndarray, d: np.ndarray, limit: float) -> str:
    i = int(np.argmax(error))
    exact = [x.hex() for x in d[i].astype(float).tolist()]
    return (
        f"{np.count_nonzero(error > limit)} of {len(d)} above {limit:g}; "
        f"worst {float(error[i]):.3g} rad at {exact} = {d[i].tolist()}"
    )


@each(CASES, slow=PARAMETERS)
@each_dtype
def test_round_trip(case, dtype):
    p, r = case.make(), case.reference()
    d = HARD[dtype]
    inside = r.clear_of_the_border(d)
    d = d[inside]
    uv = p.encode(d)
    assert uv.dtype == dtype
    assert not np.isnan(uv).any(), d[np.isnan(uv).any(-1)][:3]
    assert uv[..., :2].min() >= 0 and uv[..., :2].max() <= 1
    back = p.decode(uv)
    assert back.dtype == dtype
    assert not np.isnan(back).any(), (d[np.isnan(back).any(-1)][:3], uv[np.isnan(back).any(-1)][:3])
    error = reference.angle(back, d)
    limit = bound(r, dtype)
    assert error.max() <= limit, worst(error, d, limit)


@each(CASES, slow=PARAMETERS)
@each_dtype
def test_encode_lands_where_the_reference_says(case, dtype):
    # Through the reference's own decoder in longdouble, so that a seam may round to either side.
    # The limit is that of the round trip: uv is what rounds, and it is the same uv.
    p, r = case.make(), case.reference()
    d = HARD[dtype]
    d = d[r.clear_of_the_border(d)][::2]
    uv = p.encode(d).astype(np.longdouble)
    back = r.decode(uv)
    # A rim point may have rounded to outside the true disk: the reference keeps the stated 8 eps.
    off = np.isnan(back).any(-1)
    if r.is_disk:
        x, y, _ = r.local(np.where(off[:, None], uv, 0.5))
        assert np.all((x * x + y * y)[off] <= 1 + 8 * np.finfo(dtype).eps)
    elif case.name == "sinusoidal":
        x, y, _ = r.local(np.where(off[:, None], uv, 0.5))
        assert np.all((np.abs(x) - np.cos(np.pi / 2 * y))[off] <= 8 * np.finfo(dtype).eps)
    else:
        assert not off.any(), d[off][:3]
    error = reference.angle(back[~off], d[~off])
    limit = bound(r, dtype)
    assert error.max() <= limit, worst(error, d[~off], limit)


@each(DEFAULTS)
@each_dtype
def test_encode_is_good_to_a_few_eps_absolute(case, dtype):
    p, r = case.make(), case.reference()
    d = hard_directions.uniform(dtype, 20_000, 3)
    d = d[r.covers(d)]
    want = r.encode(d.astype(np.longdouble))
    got = p.encode(d)
    # Four eps: a division or a square root and a half-turn arctangent each cost one at most, and
    # uv is at most 1. (No random direction lies within 4 eps of a seam.)
    error = np.abs(got.astype(np.longdouble) - want)
    assert error.max() <= 4 * np.finfo(dtype).eps


@each(CASES, slow=PARAMETERS)
@each_dtype
def test_decode_is_unit_and_agrees_with_the_reference(case, dtype):
    p, r = case.make(), case.reference()
    rng = np.random.default_rng(31)
    uv = rng.random((8_000, 2))
    lattice = np.stack(np.meshgrid(np.linspace(0, 1, 25), np.linspace(0, 1, 25)), -1).reshape(-1, 2)
    near = np.clip(lattice[:, None] + 10.0 ** -np.arange(3, 12)[None, :, None], 0, 1).reshape(-1, 2)
    uv = np.concatenate([uv, lattice, near])
    if p.faces > 1:
        uv = np.concatenate([uv, rng.integers(0, p.faces, (len(uv), 1))], -1)
    uv = uv.astype(dtype)
    got = p.decode(uv)
    want = r.decode(uv.astype(np.longdouble))
    eps = np.finfo(dtype).eps
    x, y, _ = r.local(uv.astype(np.longdouble))
    r2 = x * x + y * y
    edge = np.zeros(len(uv), bool)
    if r.is_disk:
        edge = np.abs(r2 - 1) < 64 * eps
    if case.name == "sinusoidal":
        edge = np.abs(np.abs(x) - np.cos(np.pi / 2 * y)) < 64 * eps
    if p.layout not in (None, "faces"):
        # At the border of two cells, uv belongs to either.
        rows, columns, _ = reference.LAYOUTS[p.name][p.layout]
        for k, n in ((0, columns), (1, rows)):
            t = uv[:, k].astype(np.float64) * n
            edge |= np.abs(t - np.rint(t)) < 64 * eps
    assert np.array_equal(np.isnan(got).any(-1)[~edge], np.isnan(want).any(-1)[~edge])
    assert np.array_equal(np.isnan(got).any(-1), np.isnan(got).all(-1))
    ok = ~np.isnan(got).any(-1)
    length = np.sqrt(np.sum(got[ok].astype(np.longdouble) ** 2, axis=-1))
    assert np.abs(length - 1).max() <= 4 * eps
    ok &= ~edge & ~np.isnan(want).any(-1)
    error = reference.angle(got[ok], want[ok])
    # p = 2u - 1 is exact on one face; an atlas adds the rounding of u·columns, which is at most 8.
    limit = np.full(len(error), (8 if p.layout in (None, "faces") else 32) * eps)
    if case.name in reference.ROOT_RIMS:
        # √c with c = 1 - r² known to 2 eps: an angle of 2·2·eps/√c, from either map's root.
        c = np.maximum(1 - r2[ok], eps).astype(np.float64)
        limit = limit + 8 * eps / np.sqrt(c)
    assert np.all(error <= limit), worst(error - limit, uv[ok], 0.0)


@each(CASES)
@each_dtype
def test_bad_input_is_nan_in_every_component_and_never_raises(case, dtype):
    p = case.make()
    d = hard_directions.bad(dtype)
    uv = p.encode(d)
    assert np.isnan(uv).all()
    assert not p.covers(d).any()
    width = 3 if p.faces > 1 else 2
    for value in (np.nan, np.inf, -np.inf, -1e-3, 1.001, 1e30):
        for k in range(2):
            x = np.full((1, width), 0.5, dtype)
            x[:, 2:] = 0
            x[0, k] = value
            assert np.isnan(p.decode(x)).all() and np.isnan(p.jacobian(x)).all()
            assert np.isnan(p.density(x)).all() and not p.valid(x).any()


@each(CASES)
@each_dtype
def test_bad_ones_among_good_ones_spoil_nothing(case, dtype):
    # Position in a block of 64 must not matter, nor what its neighbors are.
    p = case.make()
    good = hard_directions.uniform(dtype, 300, 8)
    mixed = good.copy()
    mixed[::3] = hard_directions.bad(dtype)[:100]
    keep = np.ones(300, bool)
    keep[::3] = False
    a, b = p.encode(good), p.encode(mixed)
    assert np.array_equal(a[keep], b[keep], equal_nan=True)
    assert np.isnan(b[~keep]).all()


@each(CASES)
@each_dtype
def test_length_does_not_matter(case, dtype):
    p = case.make()
    d = hard_directions.uniform(dtype, 500, 9)
    d = (d / np.max(np.abs(d), axis=-1, keepdims=True)).astype(dtype)
    want = p.encode(d)
    top = 126 if dtype == np.float32 else 1022
    for e in (-top // 2, -20, 3, 40, top):
        # A power of two changes no bit of the mantissa, so it must change no bit of the answer
        # beyond rounding.
        got = p.encode(np.ldexp(d, e))
        # If lengths were scaled elsewhere: a root and a quotient, each rounded by ε at most.
        assert np.allclose(got, want, rtol=0, atol=2 * np.finfo(dtype).eps, equal_nan=True)


@each(CASES)
@each_dtype
def test_signs_of_zero_do_not_move_an_axis(case, dtype):
    # ±0 in the other components must not change where an axis lands.
    p, r = case.make(), case.reference()
    for k in range(3):
        for sign in (1.0, -1.0):
            places = []
            for a in (0.0, -0.0):
                for b in (0.0, -0.0):
                    d = np.insert(np.array([a, b]), k, sign).astype(dtype)
                    places.append(p.encode(d))
                    if p.covers(d):
                        back = p.decode(places[-1])
                        assert reference.angle(back, d) <= bound(r, dtype)
            places = np.array(places)
            view = reference.permute(r.axes, np.eye(3)[k] * sign, back=False)
            view_to_world = reference.axes_matrix(r.axes)
            if np.array_equal(view, [0, 0, -1]):
                # The stated place of the backward axis: azimuth of (+x, 0); seam u = 0.
                assert np.array_equal(places, places[:1].repeat(4, 0), equal_nan=True)
                if p.layout in (None, "faces") and p.coverage == "sphere":
                    want = {
                        "sphere": [1, 0.5],
                        "angular": [1, 0.5],
                        "octahedral": [1, 1],
                        "equal_area": [1, 1],
                        "latlong": [0, 0.5],
                        "lambert_cylindrical": [0, 0.5],
                        "dual_paraboloid": [0.5, 0.5, 1],
                        **{
                            cube: [0.5, 0.5, reference.stored(p, 5)]
                            for cube in reference.CUBES
                            if cube == case.name
                        },
                    }.get(case.name)
                    if want is not None:
                        assert places[0].tolist() == want
                    else:
                        there = r.encode(np.array([0.0, 0.0, -1.0]) @ view_to_world)
                        assert np.abs(places[0] - there).max() <= 4 * np.finfo(dtype).eps
            if abs(view[1]) == 1 and case.name in reference.POLES:
                assert np.all(places == [0.5, 0.0 if view[1] < 0 else 1.0])


@each_dtype
def test_backward_has_one_place(dtype):
    for name in sm.projections():
        p = sm.projection(name, axes="+x +y +z")
        d = np.array([[a, b, -1.0] for a in (0.0, -0.0) for b in (0.0, -0.0)], dtype)
        uv = p.encode(d)
        assert np.array_equal(uv, uv[:1].repeat(4, 0), equal_nan=True), name


@each_dtype
def test_latlong_seam_is_u_zero(dtype):
    p = sm.projection("latlong", axes="+x +y +z")
    y = np.array([-1.0, -0.1, 0.0, 0.5, 20.0], dtype)
    for x in (0.0, -0.0):
        d = np.stack([np.full_like(y, x), y, np.full_like(y, -1)], -1)
        assert np.all(p.encode(d)[:, 0] == 0)


@each_dtype
def test_cube_ties_are_as_stated(dtype):
    # x wins over y wins over z, by the components of the view frame.
    p = sm.projection("cube", axes="+x +y +z")
    r = reference.of(p)
    d = hard_directions.signed_zeros(dtype)
    uv = p.encode(d)
    assert np.array_equal(uv, r.encode(d))
    assert p.encode(np.array([1, 1, 1], dtype))[2] == 0
    assert p.encode(np.array([-1, 1, 1], dtype))[2] == 1
    assert p.encode(np.array([0.5, 1, -1], dtype))[2] == 3
    assert p.encode(np.array([0.5, -1, 1], dtype))[2] == 2


@each_dtype
def test_dual_paraboloid_equator_is_face_zero(dtype):
    p = sm.projection("dual_paraboloid", axes="+x +y +z")
    for z in (0.0, -0.0):
        assert p.encode(np.array([0.6, 0.8, z], dtype))[2] == 0
    assert p.encode(np.array([0.6, 0.8, -1e-30], dtype))[2] == 1


@each_dtype
@pytest.mark.parametrize("name", ["matcap", "hemioctahedral"])
def test_the_equator_belongs_to_a_hemisphere(name, dtype):
    p = sm.projection(name, axes="+x +y +z")
    for z in (0.0, -0.0):
        d = np.array([[1, 0, z], [-1, -0.0, z], [0.6, -0.8, z], [3, 1e-20, z]], dtype)
        assert p.covers(d).all() and not np.isnan(p.encode(d)).any()
    below = np.array([0.6, 0.8, -np.finfo(dtype).smallest_subnormal], dtype)
    assert not p.covers(below) and np.isnan(p.encode(below)).all()


@pytest.mark.parametrize("name", ["sphere", "angular", "matcap", "dual_paraboloid"])
@each_dtype
def test_rim_accepts_eight_eps_and_no_more(name, dtype):
    p = sm.projection(name)
    eps = np.finfo(dtype).eps
    tail = [0.0] * (p.faces > 1)
    rim = np.array([[1.0, 0.5, *tail], [0.5, 0.0, *tail], [0.0, 0.5, *tail]], dtype)
    assert p.valid(rim).all() and not np.isnan(p.decode(rim)).any()
    # 3-4-5: p = 0.6, q = 0.8 with v a few ulp on; 2·0.8·2·k·(eps/2) grows past 8 eps at k = 5.
    for k in range(1, 40):
        v = dtype(0.9)
        for _ in range(k):
            v = np.nextafter(v, dtype(1))
        x = np.array([0.8, v, *tail], dtype)
        a, b = 2 * x[:2].astype(np.longdouble) - 1
        over = (a * a + b * b - 1) / eps
        if over < 6:
            assert p.valid(x) and not np.isnan(p.decode(x)).any(), k
        elif over > 10:
            assert not p.valid(x) and np.isnan(p.decode(x)).all(), k
