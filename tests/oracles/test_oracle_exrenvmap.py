"""OpenEXR's own program turns its two environment maps into each other as our rows do."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm

from oracles import exrenvmap_oracle

pytestmark = pytest.mark.programs

LATLONG, CUBE = "latlong:openexr", "cube:openexr"


@pytest.mark.parametrize(
    ("src", "dst", "letters", "width"),
    [(LATLONG, CUBE, "lc", 128), (CUBE, LATLONG, "cl", 512)],
)
def test_directions_stay_what_they_are(src, dst, letters, width, tmp_path):
    # An image of directions, as colors.
    before = (sm.directions(src, 256) + 1) / 2
    after = exrenvmap_oracle.convert(before, *letters, width, tmp_path)
    size = width if dst == CUBE else width // 2
    want = sm.directions(dst, size)
    assert after.shape == want.shape
    error = np.linalg.norm(2 * after - 1 - want, axis=-1)
    # Half floats near 1 round by 2.4e-4, doubled by the scale, in three channels; the filter's
    # five samples average within a tenth of a texel of 7e-3. A shift by half a texel is 3.5e-3.
    assert np.median(error) < 1e-3
    assert error.max() < 3e-3
