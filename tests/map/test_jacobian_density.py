"""Jacobians (from dual numbers) and densities (from closed forms) against each other."""

from __future__ import annotations

import hard_directions
import numpy as np
import pytest
import reference
from conftest import CASES, DEFAULTS, PARAMETERS, each, valid_uv

# The fourth-order difference of the reference in longdouble: 1e-5⁴ times a fifth derivative, which
# grows beside poles and tips.
STEP = 1e-5


def off_creases(r, uv: np.ndarray, margin: float) -> np.ndarray:
    """Keep away from the lines where a map has no derivative, and from rims."""
    p, q, _ = r.local(uv)
    ok = np.ones(len(uv), bool)
    ok &= r.off_creases(p, q, margin)
    if r.is_disk:
        ok &= p * p + q * q < 0.98
    if r.name == "angular":
        # sin(πr)/r is 0/0 at the center, which the test near singular points has.
        ok &= p * p + q * q > 1e-4
    return ok


@each(CASES, slow=PARAMETERS)
def test_jacobian_against_differences(case):
    p, r = case.make(), case.reference()
    uv = valid_uv(r, 3000, 50, margin=3e-3)
    uv = uv[off_creases(r, uv, 5e-3)]
    assert len(uv) > 500
    got = p.jacobian(uv)
    assert got.shape == (len(uv), 3, 2) and got.dtype == np.float64
    want = r.jacobian(uv, STEP).astype(float)
    scale = np.max(np.abs(want), axis=(-1, -2))
    # Sphere and matcap: derivatives of the root grow like (1 - r²)^(-k+1/2); 0.98 leaves 1e-6.
    limit = 2e-6 if case.name in reference.ROOT_RIMS else 1e-9
    assert np.max(np.abs(got - want).max(axis=(-1, -2)) / scale) < limit


@each(CASES)
def test_jacobian_is_tangent_and_its_area_is_the_density(case):
    p, r = case.make(), case.reference()
    uv = valid_uv(r, 5000, 51, margin=1e-3)
    j, d = p.jacobian(uv), p.decode(uv)
    ok = ~np.isnan(j).any(axis=(-1, -2))
    # A derivative that does not exist (an exact crease) may be NaN; random points miss creases.
    assert ok.all()
    scale = np.linalg.norm(j, axis=-2)
    # What cancels is known to ε over the distance from a pole or rim, 1e-3: 2e-13 a term.
    assert np.abs(np.einsum("ni,nik->nk", d, j) / scale).max() < 1e-12
    area = np.linalg.norm(np.cross(j[..., 0], j[..., 1]), axis=-1)
    # Two lengths, an angle and the density, 2e-13 each, and ten times that where lenses are steep.
    assert np.abs(area / p.density(uv) - 1).max() < 1e-11


@each(CASES)
@pytest.mark.parametrize("grid", ["centers", "corners"])
@pytest.mark.parametrize("n", [2, 3, 4, 7, 8, 17, 20])
def test_area_of_the_jacobian_is_the_density_on_every_texel(case, grid, n):
    # Axes, diagonals, tips and edges are among the texels: there one branch of a formula must give
    # the value and the derivative, and a tip the derivatives of one of the ways into it.
    p = case.make(grid=grid)
    uv = case.reference(grid=grid).texel_uv(p.shape(n))
    uv = uv[p.valid(uv)]
    j, density = p.jacobian(uv), p.density(uv)
    area = np.linalg.norm(np.cross(j[..., 0], j[..., 1]), axis=-1)
    # The derivatives of a root do not exist on a rim or at a blind spot, and where the density is
    # zero or infinite there is nothing to compare: a few ε of the others count as zero.
    ok = np.isfinite(j).all(axis=(-1, -2)) & np.isfinite(density) & (density > 1e-9)
    # On a small grid of corners all texels may be rims and poles.
    assert np.count_nonzero(ok) >= 0.6 * len(ok) or (grid == "corners" and n < 8)
    # The limit of random points: texels that are not on a pole stay farther from it than those.
    assert np.abs(area[ok] / density[ok] - 1).max(initial=0) < 1e-11


@each(CASES)
def test_orientation_of_the_jacobian_is_the_chirality(case):
    # d · (∂u × ∂v): v runs down and u right, so an unmirrored image seen from inside is positive
    # in a right-handed world (right × down = forward).
    p, r = case.make(), case.reference()
    uv = valid_uv(r, 500, 52, margin=1e-3)
    j, d = p.jacobian(uv), p.decode(uv)
    sign = np.sign(np.sum(d * np.cross(j[..., 0], j[..., 1]), axis=-1))
    expected = -1 if p.mirrored else 1
    if case.name == "dual_paraboloid":
        # The back face is not flipped: it is the mirrored one.
        back = r.local(uv)[2] == 1
        assert np.all(sign[~back] == expected) and np.all(sign[back] == -expected)
    else:
        assert np.all(sign == expected)


@each(CASES, slow=PARAMETERS)
def test_density_against_the_reference(case):
    p, r = case.make(), case.reference()
    uv = valid_uv(r, 5000, 53)
    got, want = p.density(uv), r.density(uv.astype(np.longdouble)).astype(float)
    assert got.dtype == np.float64 and got.shape == (len(uv),)
    if case.name in ("matcap", "orthographic"):
        # 4/√(1 - r²): an eps of r² matters as 1/(1 - r²).
        a, b, _ = r.local(uv)
        # 4e-16 is two ε: r² sums two squares; the 4 is for a root and a quotient.
        assert np.all(np.abs(got / want - 1) < 4e-16 * (4 + 1 / (1 - a * a - b * b)))
    elif case.name in ("latlong", "angular", "miller", "hemi_latlong"):
        # A sine that goes to zero: absolute to the size of the largest value.
        assert np.abs(got - want).max() < 1e-14 * want.max()
    else:
        # 45 ε, relative: factors and powers multiply errors, and here no difference cancels.
        assert np.abs(got / want - 1).max() < 1e-14


@each(DEFAULTS)
def test_float32_jacobian_and_density(case):
    p, r = case.make(), case.reference()
    uv = valid_uv(r, 3000, 54, margin=3e-3)
    uv = uv[off_creases(r, uv, 5e-3)].astype(np.float32)
    j32, j64 = p.jacobian(uv), p.jacobian(uv.astype(np.float64))
    assert j32.dtype == np.float32
    scale = np.abs(j64).max(axis=(-1, -2), keepdims=True)
    # 0.98 of the disk leaves 1 - r² = 0.02, which float32 knows to 1e-5 relative.
    assert np.max(np.abs(j32 - j64) / scale) < 4e-5
    d32, d64 = p.density(uv), p.density(uv.astype(np.float64))
    assert d32.dtype == np.float32
    # ε of float32 over the 0.02 of 1 - r² is 6e-6; three times that for the other factors.
    assert np.max(np.abs(d32 / d64 - 1)) < 2e-5


@each(DEFAULTS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_jacobian_near_singular_points_is_finite_or_nan_but_never_raises(case, dtype):
    p = case.make()
    d = hard_directions.hard(dtype)[::7]
    uv = p.encode(d)
    uv = uv[~np.isnan(uv).any(-1)]
    j = p.jacobian(uv)
    density = p.density(uv)
    assert not np.isnan(density).any() and density.min() >= 0
    lo, hi = p.density_range
    eps = np.finfo(dtype).eps
    assert density.min() >= lo * (1 - 32 * eps) - 32 * eps
    assert density.max() <= hi * (1 + 32 * eps)
    # One-sided at creases: whatever is finite there is tangent to the sphere.
    ok = np.isfinite(j).all(axis=(-1, -2))
    assert ok.mean() > 0.3
    with np.errstate(over="ignore"):
        scale = np.linalg.norm(j[ok], axis=-2)
    dots = np.einsum("ni,nik->nk", p.decode(uv[ok]), j[ok])
    big = scale > 1e-6  # shorter columns are rounding alone
    # Beside roots half of the digits are left: √ε is 1.5e-8, 3.5e-4 in float32; 30 to 70 times.
    limit = 1e-2 if dtype == np.float32 else 1e-6
    assert np.abs(dots[big] / scale[big]).max() < limit
