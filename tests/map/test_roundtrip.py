"""Properties of encode and decode over inputs that hypothesis chooses."""

from __future__ import annotations

import dataclasses

import numpy as np
import reference
import spheremap as sm
from conftest import CASES, LAYOUTS, each, random_directions, valid_uv
from hypothesis import example, given
from hypothesis import strategies as st

finite64 = st.floats(allow_nan=False, allow_infinity=False)
finite32 = st.floats(allow_nan=False, allow_infinity=False, width=32)
unit64 = st.floats(0, 1)
NAMES = st.sampled_from(sm.projections())

# From the design: radians of angle(d, decode(encode(d))).
LIMITS = {
    "sphere": (1.2e-3, 6e-8),
    "matcap": (4.8e-4, 2.5e-8),
    "orthographic": (4.8e-4, 2.5e-8),
    # Near the lower pole v is near 1, and 2√(ε/4) of angle are lost.
    "lambert_cylindrical": (3.6e-4, 1.6e-8),
    # A unit of u is 8 radians at the rim, and not 2π.
    "hammer": (1.25e-6, 2.6e-15),
    # ε^¾ at the poles: 1 - |q| rounds by 3ε, and the distance to the pole is 1.55 (1 - |q|)^¾.
    "mollweide": (1e-5, 5e-12),
}


@given(NAMES, finite64, finite64, finite64)
@example("sphere", 1e-308, 0.0, -1.0)
@example("latlong", -0.0, 5e-324, 0.0)
@example("octahedral", -0.0, -0.0, -1e308)
def test_any_float64_direction(name, x, y, z):
    _round_trip(name, np.array([x, y, z]), 1, 2e-15)


@given(NAMES, finite32, finite32, finite32)
@example("cube", 1.0, 1.0, -1.0)
@example("matcap", 1.0, 1e-45, 1e-45)
def test_any_float32_direction(name, x, y, z):
    _round_trip(name, np.array([x, y, z], np.float32), 0, 9.5e-7)


def _round_trip(name: str, d: np.ndarray, which: int, otherwise: float) -> None:
    uv = sm.encode(d, name)
    assert uv.dtype == d.dtype
    if not np.any(d):
        assert np.isnan(uv).all()
        return
    if not sm.covers(d, name):
        assert np.isnan(uv).all() and sm.projection(name).coverage != "sphere"
        return
    limit = LIMITS[name][which] if name in LIMITS else otherwise
    assert reference.angle(sm.decode(uv, name), d) <= limit


@given(NAMES, unit64, unit64, st.integers(0, 5))
def test_uv_round_trip(name, u, v, face):
    p = sm.projection(name)
    uv = np.array([u, v] if p.faces == 1 else [u, v, min(face, p.faces - 1)], float)
    d = p.decode(uv)
    assert np.isnan(d).any() == (not p.valid(uv))
    if np.isnan(d).any():
        return
    assert abs(np.linalg.norm(d) - 1) < 1e-15
    again = p.decode(p.encode(d)) if p.covers(d) else d
    # decode gives a direction with rounding of its own; from there the same limits hold.
    assert reference.angle(again, d) <= (LIMITS[name][1] if name in LIMITS else 2e-15)


@each(LAYOUTS)
def test_uv_comes_back_in_the_interior(case):
    p, r = case.make(), case.reference()
    uv = valid_uv(r, 20_000, 40, margin=1e-3)
    back = p.encode(p.decode(uv))
    if p.faces > 1:
        assert np.array_equal(back[:, 2], uv[:, 2])
    # The smallest slope of direction over uv in this interior is at the rim and the poles, where
    # a latlong's u is blurred by eps / sin θ with θ ≥ 3e-3.
    assert np.abs(back - uv)[:, :2].max() < 2e-13


@each(CASES)
def test_axes_are_a_permutation_of_the_world(case):
    p = case.make()
    r = case.reference()
    plain = dataclasses.replace(r, axes="+x +y +z")
    d = random_directions(2000, 41)
    view = d @ reference.axes_matrix(p.axes).T
    got, want = p.encode(d), plain.encode(view)
    assert np.array_equal(np.isnan(got), np.isnan(want))
    ok = ~np.isnan(want[:, 0])
    assert np.abs(got - want)[ok].max() < 1e-15 * 4


@each(LAYOUTS)
def test_axes_keyword_of_the_functions(case):
    p = case.make()
    q = case.make(axes="+y +z +x")
    d = random_directions(100, 42)
    uv = q.encode(d)
    assert np.array_equal(sm.encode(d, p, axes="+y +z +x"), uv, equal_nan=True)
    uv = uv[~np.isnan(uv[:, 0])]
    assert np.array_equal(sm.decode(uv, p, axes="+y +z +x"), q.decode(uv))
    assert np.array_equal(sm.jacobian(uv, p, axes="+y +z +x"), q.jacobian(uv), equal_nan=True)
    a = sm.directions(p, 4, axes="+y +z +x")
    assert np.array_equal(a, q.directions(4), equal_nan=True)


@each(LAYOUTS)
def test_functions_take_object_name_and_qualified_name(case):
    d = random_directions(50, 43)
    p = sm.projection(case.name)
    assert np.array_equal(sm.encode(d, case.name), p.encode(d), equal_nan=True)
    assert np.array_equal(sm.encode(d, p), p.encode(d), equal_nan=True)
    for row in sm.conventions(case.name):
        q = sm.projection(case.name, convention=row["name"])
        qualified = f"{case.name}:{row['name']}"
        assert np.array_equal(sm.encode(d, qualified), q.encode(d), equal_nan=True)
