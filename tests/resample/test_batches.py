"""Batches are their images one by one, to the bit; channels may come first; rank decides."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import assert_same_bits
from scipy.spatial.transform import Rotation
from spheremap import _core

TURNS = np.stack([sm.rotation(yaw, 20, -30) for yaw in (0, 70, 200)])
PLACES = np.random.default_rng(1).normal(size=(4, 5, 3))
SOURCES = ("latlong", "cube", "cube(layout)", "octahedral")


def named(source):
    return sm.projection("cube", layout="cross") if source == "cube(layout)" else source


def batch(source, dtype=np.float32, n=3, channels=2):
    p = sm.projection(named(source)) if isinstance(named(source), str) else named(source)
    texels = np.random.default_rng(7).random((n, *p.shape(8), channels))
    return (200 * texels).astype(dtype) if np.dtype(dtype).kind == "u" else texels.astype(dtype)


# Each verb, of an image, its projection and options; what is stacked has `out` or not.
IMAGES = {
    "convert": lambda x, p, **o: sm.convert(x, p, "angular", size=6, **o),
    "convert by area": lambda x, p, **o: sm.convert(x, p, "latlong", size=4, filter="area", **o),
    "pad": lambda x, p, **o: sm.pad(x, p, 2, **o),
}
LIT = {
    "irradiance": lambda x, p, **o: sm.light.irradiance(x, p, "cube", size=2, **o),
    "irradiance sh": lambda x, p, **o: sm.light.irradiance(
        x, p, "cube", size=2, method="sh", order=1, **o
    ),
    "convolve": lambda x, p, **o: sm.light.convolve(
        x, p, "latlong", size=2, lobe="vmf", kappa=3, **o
    ),
    "prefilter": lambda x, p, **o: sm.light.prefilter(x, p, "latlong", size=2, roughness=0.6, **o),
}
PICTURES = IMAGES | LIT
VALUES = {
    "sample": lambda x, p, **o: sm.sample(x, PLACES, p, **o),
    "sample at a level": lambda x, p, **o: sm.sample(x, PLACES, p, lod=1.5, **o),
    "irradiance_at": lambda x, p, **o: sm.light.irradiance_at(x, PLACES, p, **o),
}
NUMBERS = {
    "integrate": lambda x, p, **o: sm.light.integrate(x, p, **o),
    "mean": lambda x, p, **o: sm.light.mean(x, p, **o),
    "average_direction": lambda x, p, **o: sm.light.average_direction(x, p, **o),
    "sh.project": lambda x, p, **o: sm.sh.project(x, p, order=2, **o),
}
EVERY = PICTURES | VALUES | NUMBERS
# What a rotation would not change has none.
TURNED = [name for name in EVERY if name not in ("pad", "integrate", "mean")]


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("name", EVERY)
def test_a_batch_is_its_images_one_by_one(name, source):
    verb, p, images = EVERY[name], named(source), batch(source)
    want = np.stack([verb(image, p) for image in images])
    assert_same_bits(verb(images, p), want)
    # As a list, and with strides.
    assert_same_bits(verb(list(images), p), want)
    assert_same_bits(verb(images[::-1], p), want[::-1])
    assert verb(images[:0], p).shape == (0, *want.shape[1:])
    # One image with nothing to tell it from a batch but its rank.
    assert_same_bits(verb(images[:1], p), want[:1])


@pytest.mark.parametrize("name", TURNED)
def test_each_image_has_its_rotation_or_one_image_has_many(name):
    verb, images = EVERY[name], batch("latlong")
    one_by_one = [verb(x, "latlong", rotation=r) for x, r in zip(images, TURNS, strict=True)]
    assert_same_bits(verb(images, "latlong", rotation=TURNS), np.stack(one_by_one))
    assert_same_bits(
        verb(images, "latlong", rotation=TURNS[1]),
        np.stack([verb(x, "latlong", rotation=TURNS[1]) for x in images]),
    )
    views = np.stack([verb(images[0], "latlong", rotation=r) for r in TURNS])
    assert_same_bits(verb(images[0], "latlong", rotation=TURNS), views)
    # Matrices of quaternions differ in the last bits from those they were made of.
    turns = Rotation.from_matrix(TURNS)
    want = np.stack([verb(images[0], "latlong", rotation=r) for r in turns.as_matrix()])
    assert_same_bits(verb(images[0], "latlong", rotation=turns), want)
    gray = images[0, ..., 0]
    assert verb(gray, "latlong", rotation=TURNS[:2]).shape == (2, *verb(gray, "latlong").shape)
    with pytest.raises(ValueError, match="one for each image: got 2 for 3 images"):
        verb(images, "latlong", rotation=TURNS[:2])
    with pytest.raises(ValueError, match=r"shape \(3, 3\), got \(3, 2\)"):
        verb(images, "latlong", rotation=TURNS[..., :2])


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("name", EVERY)
def test_channels_may_lie_before_the_rows(name, source):
    verb, p, images = EVERY[name], named(source), batch(source)
    first = np.ascontiguousarray(np.moveaxis(images, -1, -3))
    one, many = verb(images[0], p), verb(images, p)
    if name in PICTURES:
        one, many = np.moveaxis(one, -1, -3), np.moveaxis(many, -1, -3)
    elif name in VALUES:
        one, many = np.moveaxis(one, -1, 0), np.moveaxis(many, -1, 1)
    got = verb(first[0], p, channels_first=True)
    assert_same_bits(got, one)
    assert got.flags.c_contiguous or name in NUMBERS
    assert_same_bits(verb(first, p, channels_first=True), many)
    # An image without channels is one either way.
    gray = images[0, ..., 0]
    assert_same_bits(verb(gray, p, channels_first=True), verb(gray, p))


# Options of which none is the default: each image of a batch has them, too.
OPTIONS = {
    "sample": lambda x, **o: sm.sample(
        x, PLACES, "latlong", filter="mitchell", axes="+x -y +z", fill=9, alpha=-1, **o
    ),
    "convert": lambda x, **o: sm.convert(
        x,
        "latlong:blender",
        "angular:debevec",
        filter="nearest",
        antialias=False,
        fill=[7, 8],
        world="literal",
        **o,
    ),
    "pad": lambda x, **o: sm.pad(x, "octahedral", 3, filter="nearest", any_aspect=True, **o),
    "mean": lambda x, **o: sm.light.mean(x - 0.5, "latlong", negative="clip", **o),
    "average_direction": lambda x, **o: sm.light.average_direction(
        x, "latlong", axes="+y +z +x", **o
    ),
    "convolve": lambda x, **o: sm.light.convolve(
        x, "latlong:blender", "cube", lobe="cone", half_angle=20, size=2, world="literal", **o
    ),
    "prefilter": lambda x, **o: sm.light.prefilter(
        x, "latlong", "cube", roughness=0.9, method="sampled", samples=8, size=2, **o
    ),
    "sh.project": lambda x, **o: sm.sh.project(x, "latlong", order=1, texels="points", **o),
}


@pytest.mark.parametrize("name", OPTIONS)
def test_each_image_of_a_batch_has_all_options(name):
    images, verb = batch("latlong"), OPTIONS[name]
    assert_same_bits(verb(images), np.stack([verb(image) for image in images]))


def test_an_error_in_a_batch_is_not_far_from_its_call():
    with pytest.raises(ValueError, match="unknown filter 'cubik'") as caught:
        sm.convert(batch("latlong"), "latlong", "cube", size=2, filter="cubik")
    # This file, the verb, what calls it for each image (two frames), the verb, and its own help.
    assert len(caught.traceback) <= 6


def test_a_single_channel_stays_an_axis():
    image = batch("latlong", channels=1)
    assert sm.convert(image, "latlong", "cube", size=4).shape == (3, 6, 4, 4, 1)
    first = np.moveaxis(image, -1, -3)
    assert sm.convert(first, "latlong", "cube", size=4, channels_first=True).shape[:3] == (3, 6, 1)


@pytest.mark.parametrize("channels_first", [False, True])
@pytest.mark.parametrize("name", ["convert", "sample"])
def test_out_of_a_batch(name, channels_first):
    verb, images = EVERY[name], batch("latlong")
    if channels_first:
        images = np.moveaxis(images, -1, -3)
    options = {"channels_first": channels_first}
    want = verb(images, "latlong", **options)
    out = np.empty_like(want)
    assert verb(images, "latlong", out=out, **options) is out
    assert_same_bits(out, want)
    for wrong in (out[:2], out[..., :1].copy(), np.concatenate([out, out])):
        with pytest.raises(ValueError, match=r"`out` to have shape \(|`out` must|Expected `out`"):
            verb(images, "latlong", out=wrong, **options)
    with pytest.raises(
        TypeError, match=r"`out` to (be an array of|have dtype) float32, got float64"
    ):
        verb(images, "latlong", out=out.astype(np.float64), **options)
    overlapping = np.zeros((4, *images.shape[1:]), np.float32)
    with pytest.raises(ValueError, match="overlaps"):
        sm.convert(overlapping[1:], "latlong", "latlong", size=8, out=overlapping[:3], **options)


def test_mipmaps_and_chains_of_a_batch():
    images = batch("latlong")
    first = np.moveaxis(images, -1, -3)
    for verb in (
        lambda x, **o: sm.mipmaps(x, "latlong", **o),
        lambda x, **o: sm.light.prefilter_chain(
            x, "latlong", "cube", size=4, levels=2, samples=16, **o
        ),
    ):
        want = [np.stack(level) for level in zip(*map(verb, images), strict=True)]
        for got, level in zip(verb(images), want, strict=True):
            assert_same_bits(got, level)
        for got, level in zip(verb(first, channels_first=True), want, strict=True):
            assert_same_bits(got, np.moveaxis(level, -1, -3))
        for got, level in zip(verb(first[1], channels_first=True), want, strict=True):
            assert_same_bits(got, np.moveaxis(level[1], -1, -3))
        assert [level.shape for level in verb(images[:0])] == [(0, *x.shape[1:]) for x in want]


def test_chains_of_many_rotations():
    def verb(x, **o):
        return sm.light.prefilter_chain(x, "latlong", "cube", size=4, levels=2, samples=16, **o)

    images = batch("latlong")
    one_by_one = [verb(x, rotation=turn) for x, turn in zip(images, TURNS, strict=True)]
    want = [np.stack(level) for level in zip(*one_by_one, strict=True)]
    for got, level in zip(verb(images, rotation=TURNS), want, strict=True):
        assert_same_bits(got, level)
    for got, level in zip(verb(images[0], rotation=TURNS[:1]), want, strict=True):
        assert_same_bits(got, level[:1])


def test_depth_and_embedding():
    depth = batch("latlong", channels=1) + 1
    # z is the distance times a cosine, and what lies behind has none.
    kinds = {"source": "distance", "target": "z"}
    want = np.stack([sm.convert_depth(x, "latlong", **kinds) for x in depth])
    assert_same_bits(sm.convert_depth(depth, "latlong", **kinds), want)
    first = np.moveaxis(depth, -1, -3)
    got = sm.convert_depth(first, "latlong", channels_first=True, **kinds)
    assert_same_bits(got, np.moveaxis(want, -1, -3))
    view, panorama = batch("perspective")[0], batch("latlong")[0]
    want = sm.embed(view, "perspective", panorama, "latlong")
    arguments = (view.transpose(2, 0, 1), "perspective", panorama.transpose(2, 0, 1), "latlong")
    got = sm.embed(*arguments, channels_first=True)
    assert_same_bits(got, want.transpose(2, 0, 1))
    out = np.empty_like(got)
    assert sm.embed(*arguments, channels_first=True, out=out) is out
    assert_same_bits(out, got)


def test_plans_take_batches_with_channels_first():
    images = batch("latlong", np.uint8)
    first = np.moveaxis(images, -1, -3)
    plan = sm.remap_plan(
        "latlong", "cube", size=4, source_shape=(8, 16), channels_first=True, fill=(1, 2)
    )
    want = sm.convert(images, "latlong", "cube", size=4, fill=(1, 2))
    assert_same_bits(plan(first), np.moveaxis(want, -1, -3))
    assert_same_bits(plan(first[0]), np.moveaxis(want[0], -1, -3))
    with pytest.raises(ValueError, match=r"Expected an image of shape \(8, 16\)"):
        plan(images)


def test_a_batch_is_one_call_of_the_core_for_each_image(monkeypatch):
    calls = []
    convert = _core.convert

    def counted(image, *arguments, **options):
        calls.append(image)
        return convert(image, *arguments, **options)

    monkeypatch.setattr(_core, "convert", counted)
    images = batch("latlong")
    sm.convert(images, "latlong", "cube", size=4)
    # No image is copied on the way.
    assert len(calls) == len(images) and all(np.shares_memory(x, images) for x in calls)


@pytest.mark.parametrize("flag", ["any_aspect", "channels_first"])
@pytest.mark.parametrize("name", EVERY)
def test_flags_are_flags(name, flag):
    with pytest.raises(TypeError, match=f"Expected `{flag}` to be a bool, got int"):
        EVERY[name](batch("latlong"), "latlong", **{flag: 1})
