"""Lookups of directions in chunks."""

import dask.array as da
import numpy as np
import pytest
import spheremap as sm
import spheremap.dask as smd

rng = np.random.default_rng(6)
directions = rng.normal(size=(20, 30, 3))


@pytest.mark.parametrize("channels", [(), (1,), (3,)])
@pytest.mark.parametrize("chunks", [(7, 11, 2), (20, 30, 3)])
def test_lookups_have_the_bits_of_the_whole(channels, chunks):
    image = rng.random((16, 32, *channels)).astype(np.float32)
    options = {"rotation": sm.rotation(20, 30), "filter": "lanczos3", "fill": 2.0}
    whole = sm.sample(image, directions, "angular(fov=200)", any_aspect=True, **options)
    found = smd.sample(
        image,
        da.from_array(directions, chunks=chunks),
        "angular(fov=200)",
        any_aspect=True,
        **options,
    )
    assert found.dtype == whole.dtype and found.shape == whole.shape
    values = found.compute(scheduler="synchronous")
    np.testing.assert_array_equal(values, whole)
    assert found.chunks[:2] == da.core.normalize_chunks(chunks[:2], (20, 30))


def test_one_direction():
    found = smd.sample(np.ones((8, 16)), da.ones(3, chunks=1), "latlong")
    assert found.shape == () and found.compute(scheduler="synchronous") == 1


def test_masks_are_nan():
    image = np.ma.masked_greater(rng.random((16, 32)), 0.8)
    found = smd.sample(image, da.from_array(directions, chunks=7), "latlong")
    whole = sm.sample(image, directions, "latlong")
    assert np.isnan(whole).any()
    np.testing.assert_array_equal(found.compute(scheduler="synchronous"), whole)
    with pytest.raises(TypeError, match="masked"):
        smd.sample((image * 99).astype(np.uint8), da.ones((4, 3)), "latlong")


@pytest.mark.parametrize(
    ("image", "places", "error", "said"),
    [
        (np.ones((8, 16)), directions, TypeError, "from_array"),
        (np.ones((8, 16)), da.ones((4, 2)), ValueError, r"\(\.\.\., 3\)"),
        (np.ones((8, 16)), da.ones(()), ValueError, r"\(\.\.\., 3\)"),
        (np.ones((8, 8)), da.ones((4, 3)), ValueError, "twice as wide"),
        (np.ones((2, 8, 16, 3)), da.ones((4, 3)), ValueError, "image"),
    ],
)
def test_errors_come_at_once(image, places, error, said):
    with pytest.raises(error, match=said):
        smd.sample(image, places, "latlong")
