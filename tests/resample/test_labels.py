"""Labels of any integers and bool: taken whole, counted exactly, never mixed."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import assert_same_bits, some_fast

DTYPES = ("bool", "int8", "int16", "int32", "int64", "uint32", "uint64")
# Some that no smaller type and no float holds.
PLACES = np.random.default_rng(3).normal(size=(50, 3))
TURN = sm.rotation(33, -20, 71)


def labels(dtype, shape, seed=0):
    """Return labels over all of a dtype's range, its ends among them, and their places in order."""
    rng = np.random.default_rng(seed)
    if dtype == "bool":
        known = np.array([False, True])
    else:
        info = np.iinfo(dtype)
        ends = np.array([info.min, info.min + 1, info.max - 1, info.max], dtype)
        inner = rng.integers(info.min, info.max, 40, dtype, endpoint=True)
        known = np.unique(np.concatenate([ends, inner, np.array([0], dtype)]))
    places = rng.integers(0, len(known), shape)
    return known[places], places.astype(np.uint16), known


@some_fast("channels", [(), (1,), (3,)], fast=((3,),))
@some_fast("dtype", DTYPES, fast=("bool", "int8", "int64", "uint64"))
@pytest.mark.parametrize("filter", ["nearest", "mode"])
def test_labels_go_where_their_numbers_go(filter, dtype, channels):
    image, places, known = labels(dtype, (16, 32, *channels))
    given = known[-1]
    fill = {"fill": given.item()}
    at = {"fill": len(known) - 1}
    verbs = [lambda x, **o: sm.convert(x, "latlong", "angular", size=9, rotation=TURN, **o)]
    verbs.append(lambda x, **o: sm.convert(x, "latlong", "cube", size=3, rotation=TURN, **o))
    if filter == "nearest":
        verbs.append(lambda x, **o: sm.sample(x, PLACES, "latlong", **o))
        verbs.append(lambda x, **o: sm.sample(x, [np.nan, 0, 0], "latlong", **o))
    for verb in verbs:
        want = known[verb(places, filter=filter, **at)]
        got = verb(image, filter=filter, **fill)
        assert_same_bits(got, want)
        out = np.empty_like(want) if want.ndim else np.empty((), want.dtype)
        assert verb(image, filter=filter, out=out, **fill) is out
        assert_same_bits(out, want)
        assert_same_bits(
            verb(image[::-1], filter=filter, **fill),
            known[verb(np.ascontiguousarray(places[::-1]), filter=filter, **at)],
        )
        if dtype != "bool":
            assert_same_bits(
                verb(image.astype(image.dtype.newbyteorder()), filter=filter, **fill), want
            )


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("source", ["latlong", "octahedral", "cube", "angular"])
def test_borders_of_labels(source, dtype):
    image, places, known = labels(dtype, (*sm.projection(source).shape(6), 2))
    got = sm.pad(image, source, 3, filter="nearest")
    assert_same_bits(got, known[sm.pad(places, source, 3, filter="nearest")])
    assert_same_bits(
        sm.pad(image[..., 0], source, 3, filter="nearest"), np.ascontiguousarray(got[..., 0])
    )


@pytest.mark.parametrize("dtype", DTYPES)
def test_pictures_of_labels(dtype):
    image, places, known = labels(dtype, (5, 7))
    uv = np.random.default_rng(5).uniform(-0.2, 1.2, (40, 2))
    options = {"address": "border", "filter": "nearest"}
    got = sm.sample_uv(image, uv, fill=known[0].item(), **options)
    assert_same_bits(got, known[sm.sample_uv(places, uv, fill=0, **options)])


def test_batches_and_channels_first_of_labels():
    image, _, _ = labels("int64", (2, 8, 16, 3))
    want = np.stack([sm.convert(x, "latlong", "cube", size=4, filter="nearest") for x in image])
    assert_same_bits(sm.convert(image, "latlong", "cube", size=4, filter="nearest"), want)
    first = np.moveaxis(image, -1, -3)
    got = sm.convert(first, "latlong", "cube", size=4, filter="nearest", channels_first=True)
    assert_same_bits(got, np.moveaxis(want, -1, -3))
    plan = sm.remap_plan("latlong", "cube", size=4, filter="nearest")
    assert_same_bits(plan(image), want)


def test_of_equals_the_smallest_also_below_zero():
    # Two texels of equal areas in each texel of the result.
    image = np.tile(np.array([[-5, 3], [-5, 3]], np.int8), (2, 4))
    for dtype in ("int8", "int16", "int32", "int64"):
        got = sm.convert(image.astype(dtype), "latlong", "latlong", size=(2, 4), filter="mode")
        assert got.tolist() == [[-5] * 4] * 2


@pytest.mark.parametrize("dtype", DTYPES)
def test_what_mixes_takes_no_labels(dtype):
    image = np.ones((4, 8), dtype)
    calls = [
        lambda **o: sm.convert(image, "latlong", "cube", **o),
        lambda **o: sm.sample(image, [0, 0, 1], "latlong", **o),
        lambda **o: sm.pad(image, "latlong", 1, **o),
        lambda **o: sm.sample_uv(image, [0, 0], **o),
    ]
    for call in calls:
        for options in ({}, {"filter": "catmull-rom"}):
            with pytest.raises(TypeError, match=rf"`image` of dtype {dtype} to be 'nearest'"):
                call(**options)
    with pytest.raises(ValueError, match="Labels have no opacity"):
        sm.convert(image[..., None].repeat(2, 2), "latlong", "cube", filter="nearest", alpha=1)
    for fill in (0.5, 1 << 63 if dtype != "uint64" else -1):
        with pytest.raises(ValueError, match=f"`fill` to be of dtype {dtype}"):
            sm.convert(image, "latlong", "angular", filter="nearest", fill=fill)
    with pytest.raises(ValueError, match="`fill` to be one number or 1"):
        sm.convert(image, "latlong", "angular", filter="nearest", fill=[0, 1])
    with pytest.raises(TypeError, match=f"`out` to be an array of {dtype}, got float32"):
        sm.convert(image, "latlong", "cube", filter="nearest", out=np.zeros((6, 4, 4), np.float32))
    with pytest.raises(TypeError, match=r"to have dtype uint8, .*, got complex128"):
        sm.convert(image.astype(complex), "latlong", "cube", filter="nearest")
