"""NaN, infinite and negative texels are told by number and place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from spheremap._arrays import checked_image


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_bad_values_are_counted_and_placed(dtype: type) -> None:
    image = np.ones((4, 5, 3), dtype)
    image[1, 2, 0], image[3, 4, 2] = np.nan, -np.inf
    with pytest.raises(ValueError, match=r"`probe` has 2 NaN or infinite values, at \(1, 2, 0\), "):
        checked_image(image, name="probe")
    kept = checked_image(image, skipna=True)
    assert kept.dtype == dtype and np.count_nonzero(kept == 0) == 2 and np.isnan(image[1, 2, 0])


def test_a_sum_that_overflows_is_no_fault_of_the_texels() -> None:
    image = np.full((2, 2), np.finfo(np.float64).max)
    assert np.shares_memory(checked_image(image), image)


def test_negative_values_are_kept_clipped_or_refused() -> None:
    image = np.array([[1.0, -2.0], [-0.0, -1.0]])
    assert np.shares_memory(checked_image(image), image)
    with pytest.raises(ValueError, match=r"2 negative values, at \(0, 1\), \(1, 1\); `negative="):
        checked_image(image, negative="raise")
    assert checked_image(image, negative="clip").tolist() == [[1, 0], [0, 0]]
    assert image[0, 1] == -2
    with pytest.raises(ValueError, match="Expected `negative` to be 'keep', 'clip' or 'raise'"):
        checked_image(image.astype(np.uint8), negative="zero")


def verbs(p: str) -> dict[str, Callable[..., Any]]:
    """Return functions of light that take an image of a projection, as numbers to compare."""
    return {
        "integrate": lambda x, **o: sm.light.integrate(x, p, **o),
        "mean": lambda x, **o: sm.light.mean(x, p, **o),
        "average_direction": lambda x, **o: sm.light.average_direction(x, p, **o),
        "irradiance": lambda x, **o: sm.light.irradiance(x, p, "cube", size=2, **o),
        "irradiance_at": lambda x, **o: sm.light.irradiance_at(x, [0, 1, 0], p, **o),
        "convolve": lambda x, **o: sm.light.convolve(
            x, p, "cube", size=2, lobe="phong", exponent=2, **o
        ),
        "prefilter": lambda x, **o: sm.light.prefilter(
            x, p, "cube", size=2, roughness=0.8, method="exact", **o
        ),
        "energy": lambda x, **o: sm.light.energy(x, p, **o).integral,
    }


# Each function of light that takes an image.
LIGHT = {
    **verbs("latlong"),
    "irradiance sh": lambda x, **o: sm.light.irradiance(
        x, "latlong", "cube", size=2, method="sh", order=2, **o
    ),
    "prefilter_chain": lambda x, **o: sm.light.prefilter_chain(
        x, "latlong", "cube", size=2, levels=1, samples=16, roughness=[0.8], **o
    )[0],
    "lights": lambda x, **o: sm.light.lights(x, "latlong", count=2, **o).irradiance,
    "sun": lambda x, **o: sm.light.sun(x, "latlong", **o).surround,
    "remove_sun": lambda x, **o: sm.light.remove_sun(x, "latlong", **o)[0],
    "add_sun": lambda x, **o: sm.light.add_sun(x, SUN, "latlong", **o),
    "bake": lambda x, **o: (
        sm.light.bake(x, "latlong", specular=False, diffuse=False, order=1, **o).sh
    ),
}
SUN = sm.light.Sun(np.array([0.0, 1.0, 0.0]), 1e-3, np.array([1.0]), np.zeros(1), 0.01)


@pytest.mark.parametrize("name", LIGHT)
def test_one_rule_for_negative_numbers_in_all_of_light(name) -> None:
    work = LIGHT[name]
    image = np.full((16, 32), 0.5)
    # A sun and what sharpening leaves around it: the ring is part of the median of its surround.
    image[1:12, 8:20] = -0.25
    image[6, 14] = 1000
    clipped = np.maximum(image, 0)
    kept = work(image)
    assert np.array_equal(work(image, negative="keep"), kept)
    assert np.array_equal(work(image, negative="clip"), work(clipped))
    assert not np.array_equal(kept, work(clipped))
    assert np.array_equal(work(clipped, negative="raise"), work(clipped))
    with pytest.raises(ValueError, match=r"131 negative values, at \(1, 8\), \(1, 9\)"):
        work(image, negative="raise")


# The same of a map with a rim.
OUTSIDE = {
    **verbs("angular"),
    "sampled": lambda x, **o: sm.light.prefilter(
        x, "angular", "cube", size=2, roughness=0.8, method="sampled", samples=16, **o
    ),
    "mirror": lambda x, **o: sm.light.prefilter(x, "angular", "cube", size=2, roughness=0, **o),
    "bake": lambda x, **o: (
        sm.light.bake(x, "angular", specular=False, size=4, order=1, **o).diffuse
    ),
    "ws_psnr": lambda x: sm.light.ws_psnr(x, np.ones_like(x), "angular"),
    "sh": lambda x: sm.sh.project(x, "angular", order=2),
}


@pytest.mark.parametrize("name", OUTSIDE)
def test_what_lies_outside_is_nothing(name) -> None:
    work = OUTSIDE[name]
    sky = np.random.default_rng(8).random((24, 48, 3)).astype(np.float32)
    disk = sm.convert(sky, "latlong", "angular", size=32)
    for outside in (np.nan, np.inf, -1.0):
        marked = sm.convert(sky, "latlong", "angular", size=32, fill=outside)
        assert not np.array_equal(marked, disk)
        assert np.array_equal(work(marked), work(disk))
        if name not in ("ws_psnr", "sh"):
            assert np.array_equal(work(marked, negative="raise"), work(disk))
    marked[16, 16] = np.nan
    with pytest.raises(ValueError, match=r"3 NaN or infinite values, at \(16, 16, 0\)"):
        work(marked)


def test_integers_pass_and_other_types_do_not() -> None:
    assert checked_image(np.ones((2, 2), np.uint8)).dtype == np.uint8
    with pytest.raises(TypeError, match="complex128"):
        checked_image(np.ones((2, 2), complex))
