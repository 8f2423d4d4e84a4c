"""Solid angles of texels: totals at every size, each texel against quadrature, rims, grids."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, GRIDS, LAYOUTS, PARAMETERS, each, some_fast

# Projections whose texels the rim cuts are integrated by quadrature there; the rest have closed
# forms. These are the two relative bounds that the design states.
CLOSED, RIM = 1e-12, 1e-6
# One texel against the reference's Gauss rules, of a mean texel: the errors of both, of which the
# totals keep a part.
EACH = 1e-11


# What quadrature leaves of lenses that calibrations bend as far as their parameters go.
BENT = 1e-9


def is_lens(name: str) -> bool:
    return name.startswith("camera_") and name != "camera_pinhole"


def total_bound(name: str) -> float:
    if is_lens(name):
        return BENT
    return RIM if name in reference.DISKS else CLOSED


def is_slow(case):
    """Tell lenses whose texels are integrated numerically: five take as long as all other maps."""
    return case.name.startswith("camera_") and case.name != "camera_pinhole"


QUICK = [c for c in DEFAULTS if not is_slow(c)]


def check_total(p: sm.Projection, r: reference.Reference, n: int) -> None:
    w = p.solid_angle(n)
    assert w.dtype == np.float64 and w.shape == r.shape(n)
    assert not np.isnan(w).any() and w.min() >= 0
    # fsum: the total of 64 million numbers must not be blurred by adding them.
    total = math.fsum(np.sum(w, axis=-1, dtype=np.longdouble).astype(float).ravel())
    assert total == pytest.approx(r.covered_solid_angle, rel=total_bound(r.name), abs=0), n


@each(QUICK)
def test_totals_at_every_small_size(case):
    p, r = case.make(), case.reference()
    for n in (*range(1, 33), 47, 63, 64):
        check_total(p, r, n)


@each([*(c for c in LAYOUTS if c.options), *PARAMETERS])
def test_totals_of_layouts_and_parameters(case):
    p, r = case.make(), case.reference()
    for n in (3, 31, 100) if is_slow(case) else (1, 2, 3, 10, 31, 64, 150):
        check_total(p, r, n)


@each([c for c in DEFAULTS + PARAMETERS if is_lens(c.name)])
def test_no_texel_whose_center_a_lens_holds_is_empty(case):
    # Rectangles beyond all that a lens holds are left out at once: none of these is.
    p = case.make()
    held = np.isfinite(p.directions(90)).all(-1)
    assert held.any() and p.solid_angle(90)[held].min() > 0


@each(DEFAULTS)
@some_fast("n", [100, 127, 255, 512, 1024], fast=(100, 127, 255))
def test_totals_at_chosen_sizes(case, n):
    check_total(case.make(), case.reference(), n)


def check_large_total(case, n):
    # The result itself, its row sums in longdouble, and room to breathe.
    need = 8 * math.prod(case.make().shape(n)) * 3 // 2 + (1 << 30)
    have = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if have < need:
        pytest.skip(f"needs {need / 2**30:.1f} GiB of memory, {have / 2**30:.1f} are free")
    check_total(case.make(), case.reference(), n)


@pytest.mark.slow
@each(QUICK)
def test_totals_at_a_large_size(case):
    check_large_total(case, 4096)


@pytest.mark.slow
@each([c for c in QUICK if c.name in ("sphere", "angular", "latlong", "cube", "octahedral")])
def test_totals_at_the_largest_size(case):
    check_large_total(case, 8192)


@each(LAYOUTS + PARAMETERS)
@some_fast("n", [1, 2, 5, 13], fast=(1, 2, 5))
def test_every_texel_against_quadrature(case, n):
    p, r = case.make(), case.reference()
    if r.grid != "centers" and n == 1:
        pytest.skip("a grid of corners has no single texel")
    got, want = p.solid_angle(n), r.solid_angle(r.shape(n))
    # Closed forms to rounding; a rim texel to the stated 1e-6 of the whole, shared out: no texel
    # may be off by more than 1e-6 of a mean texel. corners-v is where the reference itself stops.
    mean = r.covered_solid_angle / got.size
    limit = EACH if r.name not in reference.DISKS and not is_lens(r.name) else RIM
    if r.grid == "corners-v" and r.name in reference.CREASES:
        limit = 1e-4  # the reference's own error where a crease crosses oblong parts
    assert np.abs(got - want).max() <= limit * mean


@each(DEFAULTS)
@pytest.mark.parametrize("grid", GRIDS[1:])
@some_fast("n", [2, 3, 4, 7, 16], fast=(2, 7))
def test_corner_grids(case, grid, n):
    p = case.make(grid=grid)
    r = reference.of(p)
    check_total(p, r, n)
    got, want = p.solid_angle(n), r.solid_angle(r.shape(n))
    mean = r.covered_solid_angle / got.size
    limit = EACH if r.name not in reference.DISKS else RIM
    if grid == "corners-v" and r.name in reference.CREASES:
        limit = 2e-4  # the reference's own error where a crease crosses oblong parts
    assert np.abs(got - want).max() <= limit * mean


@each(DEFAULTS)
def test_partially_covered_texels(case):
    p, r = case.make(), case.reference()
    shape = (*p.shape(16)[:-2], 16, 16) if r.is_disk and r.faces == 1 else p.shape(16)
    w = p.solid_angle(shape, any_aspect=True).reshape(-1, *shape[-2:])[0]
    if r.is_disk:
        assert w[0, 0] == 0 and w[8, 8] > 0
        # Texel (2, 2) of 16: its nearest corner (3/16·2-1)²·2 < 1 is inside, its center is not.
        center = 2 * 2.5 / 16 - 1
        near = 2 * 3 / 16 - 1
        assert 2 * near**2 < 1 < 2 * (2 * 2 / 16 - 1) ** 2
        assert (2 * center**2 > 1) == bool(
            np.isnan(p.directions(shape, any_aspect=True).reshape(-1, 16, 16, 3)[0, 2, 2, 0])
        )
        # Its covered part is less than half of it, at a density that only the matcap lets grow.
        assert 0 < w[2, 2] < w[8, 8] * (4 if case.name in ("matcap", "orthographic") else 1)
    elif r.used_part < 1:
        assert w[0, 0] == 0 and w[8, 8] > 0
    else:
        assert w.min() > 0


@each(LAYOUTS)
def test_symmetry(case):
    # The default axes and formulas are even in both image directions, face by face, but for a few.
    if case.make().layout not in (None, "faces"):
        pytest.skip("an atlas has no symmetry of its own")
    w = case.make().solid_angle(9)
    if case.name in ("tetrahedral", "icosahedral"):
        turned = w[::-1, ::-1] if case.name == "tetrahedral" else np.swapaxes(w, -1, -2)
        # Quadrature on texels cut another way; 1e-15 is rounding where a texel holds nothing.
        assert np.allclose(w, turned, rtol=1e-9, atol=1e-15)
        return
    # The same, and the 1e-9 that outlined() states for texels that the edge cuts.
    assert np.allclose(w, w[..., ::-1], rtol=1e-9, atol=1e-15)
    if case.name == "hemi_latlong":
        return  # from the zenith down to the horizon
    # As across.
    assert np.allclose(w, w[..., ::-1, :], rtol=1e-9, atol=1e-15)


@each(DEFAULTS)
def test_whole_shapes_that_are_not_square(case):
    p, r = case.make(), case.reference()
    shape = (*p.shape(4)[:-2], 6, 10)
    try:
        w = p.solid_angle(shape, any_aspect=True)
    except ValueError as error:
        assert "shape" in str(error)  # a projection may insist on its aspect, but must say so
        return
    assert w.shape == shape and w.min() >= 0
    assert math.fsum(w.ravel()) == pytest.approx(r.covered_solid_angle, rel=total_bound(r.name))


@each(DEFAULTS)
def test_integral_of_cosine_and_of_one(case):
    # Σ w = ∫1, and Σ w·d → ∫d: the vector sum closes for whole spheres.
    p, r = case.make(), case.reference()
    n = 128
    w, d = p.solid_angle(n), p.directions(n)
    ok = ~np.isnan(d[..., 0])
    total = np.sum(w[ok][:, None] * d[ok], axis=0)
    if p.coverage == "sphere":
        # Rim texels whose centers lie outside have no direction and are missing from the sum.
        assert np.abs(total).max() < 0.05
        return
    center = r.decode(np.array([0.5, 0.5]))
    if case.name == "hemi_latlong":
        center = np.array([0.0, 1.0, 0.0])  # the zenith is at the upper edge
    if p.coverage == "part":
        assert np.abs(np.cross(total, center)).max() < 0.05
    else:
        assert np.abs(total - np.pi * center).max() < 0.05


def test_function_takes_names_and_whole_shapes():
    a = sm.solid_angle("latlong", (512, 1024))
    assert a.shape == (512, 1024)
    assert np.array_equal(a, sm.solid_angle("latlong", 512))
    assert math.fsum(a.ravel()) == pytest.approx(4 * math.pi, rel=CLOSED)
