"""The grid is honored by sample, convert and solid_angle: centers, corners, corners in v."""

from __future__ import annotations

import math

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import GRIDS, NAMES

each_grid = pytest.mark.parametrize("grid", GRIDS)
LAYOUTS = [(name, None) for name in NAMES] + [("cube", "cross"), ("dual_paraboloid", "strip")]


def function(d: np.ndarray) -> np.ndarray:
    return reference.smooth_function(np.nan_to_num(d, nan=0.5))


@each_grid
@pytest.mark.parametrize(("name", "layout"), LAYOUTS)
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_a_texel_is_found_at_its_own_direction(name, layout, grid, filter):
    p = sm.projection(name, grid=grid, layout=layout)
    d = p.directions(9)
    image = function(d)
    got = sm.sample(image, d, p, filter=filter)
    ok = ~np.isnan(d[..., 0]) & ~np.isnan(got[..., 0])
    # Of texels that see one direction, as on a rim, the one it encodes to answers for all.
    ok &= np.abs(p.encode(d) - reference.of(p).texel_uv(image.shape[:-1])).max(-1) < 1e-9
    assert ok.sum() >= 0.6 * np.count_nonzero(~np.isnan(d[..., 0]))
    assert np.abs(got - image)[ok].max() < 1e-6


@each_grid
@pytest.mark.parametrize("name", ["latlong", "cube"])
def test_convert_goes_from_grid_to_grid(name, grid):
    source = sm.projection(name, axes="-y -z +x", grid=grid)
    image = function(source.directions(96))
    for other in GRIDS:
        target = sm.projection(name, grid=other)
        got = sm.convert(image, source, target, size=31, antialias=False)
        want = function(target.directions(31))
        # Bilinear: the function bends by 6 at most, and a texel is 0.05 rad wide at most.
        assert np.abs(got - want).max() < 6 * 0.05**2 / 8 * 2
        if other != grid:
            # Taken for the other grid, half a texel shows.
            wrong = sm.convert(
                image,
                sm.projection(name, axes="-y -z +x", grid=other),
                target,
                size=31,
                antialias=False,
            )
            assert np.abs(wrong - want).max() > 3 * np.abs(got - want).max()


@each_grid
@pytest.mark.parametrize(("name", "layout"), LAYOUTS)
def test_solid_angles_sum_to_what_is_covered(name, layout, grid):
    p = sm.projection(name, grid=grid, layout=layout)
    w = p.solid_angle(12)
    assert w.shape == p.shape(12)
    assert math.isclose(w.sum(), p.covered_solid_angle, rel_tol=1e-9)


def test_texels_on_an_edge_see_half_and_in_a_corner_a_quarter():
    inner = sm.projection("cube").solid_angle(9)
    w = sm.projection("cube", grid="corners").solid_angle(9)
    assert w[0, 0, 4] < 0.6 * w[0, 1, 4] and w[0, 0, 0] < 0.3 * w[0, 1, 1]
    assert np.allclose(w.sum(), inner.sum())
    v = sm.projection("latlong", grid="corners-v").solid_angle((5, 8))
    assert v[0, 0] < 0.2 * v[1, 0] and np.allclose(v[0], v[0, 0])


@pytest.mark.parametrize(("grid", "shape"), [("corners", (1, 2)), ("corners-v", (1, 2))])
def test_one_row_lies_on_no_two_corners(grid, shape):
    p = sm.projection("latlong", grid=grid)
    with pytest.raises(ValueError, match="needs at least 2"):
        p.solid_angle(shape)
    with pytest.raises(ValueError, match="needs at least 2"):
        sm.sample(np.ones(shape), [0, 0, 1], p)
    with pytest.raises(ValueError, match="needs at least 2"):
        sm.convert(np.ones((4, 8)), "latlong", p, size=1)


def test_axes_that_repeat_say_why():
    with pytest.raises(ValueError, match="each appear once"):
        sm.projection("cube:opengl", axes="+x -x +z")
