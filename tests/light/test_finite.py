"""NaN, infinite and negative texels are told by number and place."""

from __future__ import annotations

import numpy as np
import pytest
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


def test_negative_values_are_kept_or_refused() -> None:
    image = np.array([[1.0, -2.0], [-0.0, -1.0]])
    assert np.shares_memory(checked_image(image), image)
    with pytest.raises(ValueError, match=r"2 negative values, at \(0, 1\), \(1, 1\)\."):
        checked_image(image, negative="raise")


def test_integers_pass_and_other_types_do_not() -> None:
    assert checked_image(np.ones((2, 2), np.uint8)).dtype == np.uint8
    with pytest.raises(TypeError, match="complex128"):
        checked_image(np.ones((2, 2), complex))
