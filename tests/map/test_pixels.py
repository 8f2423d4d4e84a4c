"""Pixel coordinates: where the first texel's center is, every grid and layout, other programs."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
import spheremap as sm
from conftest import GRIDS, LAYOUTS, random_directions

N = 6


def texels(shape: tuple[int, ...]) -> np.ndarray:
    """Return (x, y) or (x, y, face) of the indices of every texel."""
    return np.stack(np.indices(shape)[::-1], axis=-1)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("case", LAYOUTS, ids=lambda case: case.id)
def test_the_centers_of_texels_see_what_texels_see(case, grid):
    p = case.make(grid=grid)
    want = p.directions(N)
    at = texels(want.shape[:-1])
    half = at + np.array([0.5, 0.5, 0.0])[: at.shape[-1]]
    for pixels, centers in ((at, "integer"), (half, "half")):
        got = p.pixels_to_directions(pixels, N, centers=centers)
        # A coordinate is off by a rounding or two, 16 beside the edges of joined faces; a texel is
        # at least a radian over 24, and half of one 0.02.
        assert np.allclose(got, want, rtol=0, atol=1e-14, equal_nan=True)
        assert np.array_equal(np.isnan(got), np.isnan(want))
        # Texels on a seam have several places; each must see what the texel sees.
        back = p.directions_to_pixels(got, N, centers=centers)
        again = p.pixels_to_directions(back, N, centers=centers)
        # Two more ways through the map: its own round trip is good to 6e-8 beside a blind spot.
        assert np.allclose(again, want, rtol=0, atol=1e-7, equal_nan=True)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("layout", ["faces", "strip", "column", "cross", "vertical_cross", "dice"])
def test_places_within_texels_come_back(layout, grid):
    p = sm.projection("cube", layout=layout, grid=grid)
    shape = p.shape(N)
    rng = np.random.default_rng(3)
    pixels = texels(shape).astype(float)
    # On a grid of corners the outer halves of texels on an edge see nothing.
    pixels[..., :2] += rng.uniform(0.01, 0.99, (*pixels.shape[:-1], 2))
    d = p.pixels_to_directions(pixels, N)
    seen = np.isfinite(d[..., 0])
    least = {"centers": 1, "corners-v": (N - 1.2) / N, "corners": ((N - 1.2) / N) ** 2}[grid]
    faces = 6 * N * N
    assert seen.sum() > 0.9 * least * faces
    back = p.directions_to_pixels(d, N)
    # Coordinates up to 24 texels, each through a handful of roundings of float64.
    assert np.abs(back - pixels)[seen].max() < 1e-13


def test_the_rule_of_the_first_pixel():
    # The upper left corner is (0, 0), the lower right (W, H).
    p = sm.projection("octahedral")
    for corner in ([0, 0], [8, 8], [8, 0]):
        assert p.pixels_to_directions(corner, 8)[2] == -1
    assert p.directions_to_pixels([0, 0, 1], 8).tolist() == [4, 4]
    assert p.directions_to_pixels([0, 0, 1], 8, centers="integer").tolist() == [3.5, 3.5]
    # With corners for a grid the outermost centers lie on the edges.
    p = sm.projection("octahedral", grid="corners")
    assert p.pixels_to_directions([0.5, 0.5], 8)[2] == -1
    assert np.isnan(p.pixels_to_directions([0.4, 4], 8)).all()
    assert np.isnan(p.pixels_to_directions([-0.1, 4], 8, centers="integer")).all()


def test_outside_is_nan():
    d = sm.pixels_to_directions([[-0.1, 2], [8.1, 2], [3, 4.1], [0, 2], [np.nan, 2]], "latlong", 4)
    assert np.isnan(d).all(axis=-1).tolist() == [True, True, True, False, True]
    d = sm.pixels_to_directions([[1, 1, 0], [1, 1, 6], [1, 1, 0.5]], "cube", 4)
    assert np.isnan(d).all(axis=-1).tolist() == [False, True, True]
    assert np.isnan(sm.directions_to_pixels([0, 0, 0], "latlong", 4)).all()
    assert np.isnan(sm.directions_to_pixels([0, 0, -1], "matcap", 4)).all()


@pytest.mark.parametrize("grid", GRIDS)
def test_plans_have_the_same_places(grid):
    src, size = sm.projection("cube", layout="cross", grid=grid), 16
    plan = sm.remap_plan(src, "latlong", size=8, source_shape=src.shape(size))
    x, y = plan.maps(dtype=np.float64)
    got = src.directions_to_pixels(sm.directions("latlong", 8), size, centers="integer")
    assert np.array_equal(got, np.stack([x, y], axis=-1))


def test_opencv_looks_up_there():
    panorama = sm.directions("latlong", 64, dtype=np.float32)
    d = random_directions(500, 7).astype(np.float32)
    places = sm.directions_to_pixels(d, "latlong", 64, centers="integer").astype(np.float32)
    got: Any = cv2.remap(
        panorama,
        places[:, None, 0],
        places[:, None, 1],
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_WRAP,
    )[:, 0]
    away = np.abs(d[:, 1]) < 0.95 * np.linalg.norm(d, axis=-1)
    unit = d / np.linalg.norm(d, axis=-1, keepdims=True)
    # A texel is 0.049 rad wide: linear interpolation is off by 0.049²/8, 3e-4, along each side, and
    # OpenCV's steps of 1/32 of a texel by 8e-4. Half a texel would be 0.025.
    assert np.abs(got - unit)[away].max() < 2.5e-3


def test_opencv_projects_there():
    fov, shape = 60.0, (48, 64)
    p = sm.projection("perspective", fov=fov, aspect=64 / 48)
    focal = 32 / np.tan(np.radians(fov) / 2)
    k = np.array([[focal, 0, 31.5], [0, focal, 23.5], [0, 0, 1]])
    d = p.directions(5).reshape(-1, 3)
    # OpenCV's y runs down and its z forward.
    want, _ = cv2.projectPoints(d * [1.0, -1.0, -1.0], np.zeros(3), np.zeros(3), k, None)
    got = p.directions_to_pixels(d, shape, centers="integer")
    # Pixels of a picture of 64, in a few roundings of float64.
    assert np.abs(got - want[:, 0]).max() < 1e-12


def test_axes_and_rotation_are_those_of_encode():
    turn, axes = sm.rotation(20, 30, 40), "+y +z +x"
    d = random_directions(50, 9)
    got = sm.directions_to_pixels(d, "latlong", 8, axes=axes, rotation=turn)
    # 16 columns: a rounding of each product.
    assert np.abs(got - sm.encode(d, "latlong", axes=axes, rotation=turn) * [16, 8]).max() < 1e-14
    back = sm.pixels_to_directions(got, "latlong", 8, axes=axes, rotation=turn)
    # The round trip of a latlong in float64 is good to 2e-15 of a radian, and more for roundings of
    # places that are up to 16.
    assert np.abs(back - d / np.linalg.norm(d, axis=-1, keepdims=True)).max() < 1e-14


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.int64])
def test_dtypes_and_shapes(dtype):
    p = sm.projection("cube")
    wanted = np.float32 if dtype in (np.float16, np.float32) else np.float64
    pixels = np.ones((2, 0, 5, 3), dtype)
    assert p.pixels_to_directions(pixels, 4).shape == (2, 0, 5, 3)
    d = p.pixels_to_directions(np.ones((2, 5, 3), dtype), 4)
    assert d.shape == (2, 5, 3) and d.dtype == wanted
    assert p.directions_to_pixels(d, 4).dtype == wanted
    assert p.directions_to_pixels(d[:, :0], 4).shape == (2, 0, 3)


def test_many_are_each():
    # Beyond the block in which arrays are converted, and with strides.
    pixels = np.random.default_rng(1).uniform(0, 64, (3, 9001, 4))[..., ::-2]
    d = sm.pixels_to_directions(pixels, "octahedral", 64)
    assert np.array_equal(d[2, 9000], sm.pixels_to_directions(pixels[2, 9000], "octahedral", 64))
    assert np.array_equal(d[:, ::3], sm.pixels_to_directions(pixels[:, ::3], "octahedral", 64))
    back = sm.directions_to_pixels(d, "octahedral", 64)
    assert np.array_equal(back[2, 9000], sm.directions_to_pixels(d[2, 9000], "octahedral", 64))


def test_what_is_wrong_is_said():
    with pytest.raises(ValueError, match=r"Expected `pixels` to have shape \(..., 2\), got \(3,\)"):
        sm.pixels_to_directions([1, 2, 3], "latlong", 4)
    with pytest.raises(ValueError, match=r"Expected `pixels` to have shape \(..., 3\), got \(2,\)"):
        sm.pixels_to_directions([1, 2], "cube", 4)
    with pytest.raises(ValueError, match="Expected `centers` to be 'half' or 'integer', got 'cv2'"):
        sm.pixels_to_directions([1, 2], "latlong", 4, centers="cv2")
    with pytest.raises(ValueError):
        sm.directions_to_pixels([1, 2, 3], "latlong", (4, 4, 4))
    with pytest.raises(TypeError):
        sm.pixels_to_directions([1j, 2], "latlong", 4)
