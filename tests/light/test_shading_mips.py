"""Shading by pixels that see many texels."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm

EYE = np.array([0.0, 0.0, 9.0])


def ball(n: int) -> np.ndarray:
    """The places and normals of a ball's pixels; NaN beside it."""
    y, x = np.mgrid[1 - 1 / n : -1 + 1 / n : n * 1j, -1 + 1 / n : 1 - 1 / n : n * 1j]
    with np.errstate(invalid="ignore"):
        return np.where(
            ((x * x + y * y) < 1)[..., None],
            np.stack([x, y, np.sqrt(1 - x * x - y * y)], axis=-1),
            np.nan,
        )


def blocks(image: np.ndarray, n: int) -> np.ndarray:
    """The mean of n × n pixels, NaN where one is."""
    h, w = (k // n for k in image.shape[:2])
    return image.reshape(h, n, w, n, -1).mean(axis=(1, 3))


@pytest.mark.parametrize("filter", [None, "ewa"])
def test_a_picture_with_mipmaps_is_nearer_to_one_of_many_rays_a_pixel(filter):
    rng = np.random.default_rng(1)
    image = rng.random((256, 512, 1)).astype(np.float32)
    matcap = rng.random((512, 512, 1))
    coarse, fine = ball(32), ball(32 * 16)
    for shade in (
        lambda p, **how: sm.light.shade_environment(p, p, EYE, image, **how),
        lambda p, **how: sm.light.shade_matcap(p, matcap, **how),
    ):
        many = blocks(np.where(np.isnan(fine[..., :1]), np.nan, shade(fine)), 16)
        known = np.isfinite(many)
        plain = np.abs(shade(coarse) - many)[known]
        mipped = np.abs(shade(coarse, mipmaps=True, filter=filter) - many)[known]
        assert known.sum() > 500
        # Means of four random texels deviate by 0.29 / 2, or by 0.11 in the mean of absolutes;
        # those of many by less, and so do the levels that stand for them.
        assert plain.mean() > 0.1 and mipped.mean() < 0.15 * plain.mean()


def test_an_outline_blurs_nothing():
    # Two mirrors that meet: at the edge, pixels see what their own mirror shows.
    normals = np.zeros((6, 8, 3))
    normals[:, :4] = (0, 0, 1)
    normals[:, 4:] = (1, 0, 1)
    normals[2, 6] = np.nan
    positions = np.zeros((6, 8, 3))
    positions[..., 0], positions[..., 1] = np.meshgrid(np.arange(8) / 1e4, -np.arange(6) / 1e4)
    sky = np.random.default_rng(2).random((32, 64))
    got = sm.light.shade_environment(positions, normals, EYE, sky, mipmaps=True)
    want = sm.light.shade_environment(positions, normals, EYE, sky)
    # Directions change by 1e-4 from pixel to pixel: level 0, by the same lookup but its rounding.
    assert np.allclose(got, want, rtol=0, atol=1e-12)


def test_level_and_bad_input():
    sky = np.random.default_rng(3).random((32, 64))
    n = ball(4)[1:3, 1:3]
    d = sm.reflect((EYE - n) / np.linalg.norm(EYE - n, axis=-1, keepdims=True), n)
    got = sm.light.shade_environment(n, n, EYE, sky, lod=2)
    assert np.array_equal(got, sm.sample(sky, d, "latlong", lod=2))
    matcap = np.random.default_rng(4).random((32, 32))
    assert np.ptp(sm.light.shade_matcap(n, matcap, lod=9)) == 0
    # A picture of one pixel has no neighbors, and sees one place.
    one = sm.light.shade_environment(n[:1, :1], n[:1, :1], EYE, sky, mipmaps=True)
    # The same lookup, rounded in another order.
    assert np.allclose(one, sm.sample(sky, d[0, 0], "latlong"), rtol=0, atol=1e-12)
    with pytest.raises(ValueError, match=r"`lod` or `mipmaps`, .*not both"):
        sm.light.shade_environment(n, n, EYE, sky, lod=2, mipmaps=True)
    with pytest.raises(ValueError, match=r"`lod` or `mipmaps`, .*not both"):
        sm.light.shade_matcap(n, matcap, lod=2, mipmaps=True)
    for flat in (n[0], n[0, 0]):
        with pytest.raises(ValueError, match=r"picture of shape \(H, W, 3\)"):
            sm.light.shade_environment(flat, flat, EYE, sky, mipmaps=True)
        with pytest.raises(ValueError, match=r"picture of shape \(H, W, 3\)"):
            sm.light.shade_matcap(flat, matcap, mipmaps=True)
    with pytest.raises(ValueError, match="knows no levels"):
        sm.light.shade_matcap(n, matcap, mipmaps=True, filter="nearest")


@pytest.mark.parametrize("shape", [(0, 3, 3), (3, 0, 3), (0, 0, 3)])
def test_a_picture_of_nothing(shape):
    nothing, sky = np.ones(shape), np.ones((8, 16, 4))
    color = sm.light.shade_environment(nothing, nothing, EYE, sky, mipmaps=True)
    assert color.shape == (*shape[:2], 4)
    assert sm.light.shade_matcap(nothing, np.ones((8, 8, 4)), mipmaps=True).shape == color.shape
