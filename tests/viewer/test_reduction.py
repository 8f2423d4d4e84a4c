"""Images made smaller for a page: means, of the right texels, and no more than asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from spheremap.viewer.reduction import reduced

RANDOM = np.random.default_rng(5)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
@pytest.mark.parametrize(
    "name, size", [("latlong", 96), ("cube", 48), ("octahedral", 96), ("cube:ffmpeg-c3x2", 48)]
)
def test_blocks_are_averaged(name: str, size: int, dtype: Any) -> None:
    p = sm.projection(name)
    shape = p.shape(size)
    image = (RANDOM.random((*shape, 3)) * 200).astype(dtype)
    longest = max(shape[-2:]) if p.faces > 1 or "c3x2" not in name else size
    small = reduced(image, p, longest // 4)
    axes = 2 if p.faces == 1 else 3
    sides = [n // 4 for n in shape[-2:]]
    wanted = (
        image.astype(np.float64)
        .reshape(*shape[: axes - 2], sides[0], 4, sides[1], 4, 3)
        .mean(axis=(axes - 1, axes + 1))
    )
    assert small.shape == wanted.shape
    if np.dtype(dtype).kind == "u":
        assert small.dtype == dtype and np.array_equal(small, np.floor(wanted + 0.5))
    else:
        # Sums of sixteen in float32.
        assert np.allclose(small, wanted, rtol=1e-6)


@pytest.mark.parametrize("size", [30, 33, 50, 64, 65, 100, 127, 128, 129, 400])
@pytest.mark.parametrize("name", ["latlong", "latlong(corners)", "angular", "mollweide", "cube"])
def test_no_larger_than_asked_for_and_not_much_smaller(name: str, size: int) -> None:
    corners = "corners" in name
    p = sm.projection("latlong", grid="corners") if corners else sm.projection(name)
    shape = p.shape(size)
    small = reduced(np.full((*shape, 1), 3.0, np.float32), p, 64)
    longest, before = max(small.shape[-3:-1]), max(shape[-2:])
    assert longest == before if before <= 64 else 57 <= longest <= 64
    held = np.isfinite(p.directions(small.shape[:-1], any_aspect=True)[..., 0])
    # A constant stays one, to a few roundings.
    assert np.allclose(small[held], 3, rtol=1e-6)


def test_what_is_not_finite_stays_where_it_is() -> None:
    image = np.ones((64, 128, 3), np.float32)
    image[5, 9, 0], image[40, 80, 2] = np.nan, np.inf
    small = reduced(image, sm.projection("latlong"), 32)
    assert np.argwhere(~np.isfinite(small)).tolist() == [[1, 2, 0], [10, 20, 2]]


def test_no_sun_is_lost() -> None:
    p = sm.projection("latlong")
    image = np.zeros((256, 512, 1), np.float32)
    image[120:136, ::7] = 1000.0
    small = reduced(image, p, 64)
    light = [float(np.sum(x[..., 0] * p.solid_angle(x.shape[:2]))) for x in (image, small)]
    # Near the horizon all texels are as large, to a few thousandths.
    assert light[1] == pytest.approx(light[0], rel=5e-3)
