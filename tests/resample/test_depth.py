"""Depth along a ray and along an axis."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, LAYOUTS, each


@each(LAYOUTS)
def test_there_and_back(case):
    p = case.make()
    rng = np.random.default_rng(240)
    depth = rng.random(p.shape(16)) + 0.5
    z = sm.convert_depth(depth, p)
    assert z.shape == depth.shape and z.dtype == np.float64
    back = sm.convert_depth(z, p, source="z")
    # Square to the axis z is rounding alone, and says nothing of depth.
    ok = np.abs(z) > 1e-9
    # A product and a quotient by the same cosine: some ε of 1.5.
    assert np.abs(back - depth)[ok].max() < 1e-14 / 1e-2
    assert np.array_equal(sm.convert_depth(z, p, source="z", target="z"), z)


@pytest.mark.parametrize("layout", ["faces", "cross", "vertical_cross", "strip"])
@pytest.mark.parametrize("grid", ["centers", "corners"])
def test_walls_of_a_room_are_flat(layout, grid):
    # A cubic room seen from its middle: z is the same everywhere, whatever the layout.
    p = sm.projection("cube", layout=layout, grid=grid)
    d = p.directions(9)
    distance = 3 / np.abs(d).max(-1)
    z = sm.convert_depth(distance, p)
    ok = ~np.isnan(d[..., 0])
    # z is 3 and the distance up to 3·√3: five or ten units of 4e-16 to 9e-16.
    assert np.abs(z[ok] - 3).max() < 1e-14
    assert (
        np.abs(sm.convert_depth(np.where(ok, 3, np.nan), p, source="z") - distance)[ok].max()
        < 1e-14
    )


@each(DEFAULTS)
def test_one_face_has_the_axis_of_its_image(case):
    p = case.make()
    if p.layout is not None:
        pytest.skip("several faces have several axes")
    d = p.directions(12)
    forward = reference.axes_matrix(p.axes)[2]
    z = sm.convert_depth(np.full(d.shape[:-1], 2.0), p)
    ok = ~np.isnan(d[..., 0])
    # One product of the same direction and axis: a rounding of numbers up to 2.
    assert np.abs(z[ok] - 2 * (d @ forward)[ok]).max() < 1e-15
    assert np.all(z[~ok] == 2)  # no sphere there: as it came


def test_a_moved_principal_point_keeps_its_axis():
    p = sm.projection("perspective", fov=60, aspect=1.5, cx=0.4, cy=-0.2)
    z = sm.convert_depth(np.ones(p.shape(20)), p)
    j, i = np.unravel_index(np.argmax(z), z.shape)
    # The texel that holds it: half of one is 1/60 and 1/40 of the image.
    assert (i + 0.5) / 30 == pytest.approx(0.9, abs=0.02) and (j + 0.5) / 20 == pytest.approx(
        0.3, abs=0.03
    )


def test_nothing_passes_as_it_is():
    depth = np.array([[np.nan, np.inf], [0.0, -np.inf]], np.float32)
    for source in ("distance", "z"):
        got = sm.convert_depth(depth, "perspective", source=source)
        assert got.dtype == np.float32 and np.array_equal(got, depth, equal_nan=True)


def test_dtypes_channels_and_out():
    depth = np.full((4, 8, 1), 3, np.float16)
    assert sm.convert_depth(depth, "latlong").dtype == np.float32
    assert sm.convert_depth(depth, "latlong").shape == (4, 8, 1)
    assert sm.convert_depth(depth.astype(np.uint16), "latlong").dtype == np.float64
    same = np.full((4, 4), 3.0)
    want = sm.convert_depth(same, "perspective")
    assert sm.convert_depth(same, "perspective", out=same) is same and np.array_equal(same, want)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="source"):
        sm.convert_depth(np.ones((4, 8)), "latlong", source="depth")
    with pytest.raises(ValueError, match="shape"):
        sm.convert_depth(np.ones((4, 8, 3)), "latlong")
    with pytest.raises(TypeError, match="real"):
        sm.convert_depth(np.ones((4, 8), complex), "latlong")
    with pytest.raises(TypeError, match="out"):
        sm.convert_depth(np.ones((4, 8)), "latlong", out=np.ones((4, 8), np.float32))
    with pytest.raises(ValueError, match="out"):
        sm.convert_depth(np.ones((4, 8)), "latlong", out=np.ones((4, 9)))
