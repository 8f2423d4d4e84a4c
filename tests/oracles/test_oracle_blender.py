"""Blender's environment textures show, in each direction, what our rows say."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm

from oracles import blender_oracle, openimageio_oracle

pytestmark = pytest.mark.programs


@pytest.mark.parametrize(
    ("row", "projection"),
    [("latlong:blender", "EQUIRECTANGULAR"), ("sphere:blender", "MIRROR_BALL")],
)
def test_each_pixel_sees_its_direction(row, projection, tmp_path):
    n, size = 512, 64
    # An image of directions, as colors.
    world = np.nan_to_num(sm.directions(row, n)).astype(np.float32)
    image = openimageio_oracle.write((world + 1) / 2, tmp_path / "world.exr")
    seen = blender_oracle.views(image, projection, tmp_path, size)
    for picture, d in zip(seen, blender_oracle.directions(size), strict=True):
        # Behind a mirror ball, along +y, all directions are in the last texels of the rim.
        apart = d[..., 1] < np.cos(np.radians(20)) if projection == "MIRROR_BALL" else d[..., 0] < 2
        error = np.abs(2 * picture - 1 - d)[apart]
        # Bilinear between texels: (π/n)²/8 of what curves like a circle, and Cycles rounds places
        # to float32; at 20° from the blind spot, where a texel is 10 times as long, 100 times that.
        bound = (np.pi / n) ** 2 / 8 + 3e-5
        assert error.max() < (100 * bound if projection == "MIRROR_BALL" else bound)
        # A shift by half a texel would be 3e-3.
        assert np.median(error) < bound
