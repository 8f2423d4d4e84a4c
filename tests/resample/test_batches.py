"""Batches are their images one by one, to the bit; channels may come first; rank decides."""

from __future__ import annotations

import dataclasses

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


def batch(source, dtype=np.float32, n=3, channels=2, size=8):
    p = sm.projection(named(source)) if isinstance(named(source), str) else named(source)
    texels = np.random.default_rng(7).random((n, *p.shape(size), channels))
    return (200 * texels).astype(dtype) if np.dtype(dtype).kind == "u" else texels.astype(dtype)


# Each verb, of an image, its projection and options; what is stacked has `out` or not.
IMAGES = {
    "convert": lambda x, p, **o: sm.convert(x, p, "angular", size=6, **o),
    "convert by area": lambda x, p, **o: sm.convert(x, p, "latlong", size=4, filter="area", **o),
    "pad": lambda x, p, **o: sm.pad(x, p, 2, **o),
    "bake_matcap": lambda x, p, **o: sm.light.bake_matcap(
        x, p, material="rough", size=3, pose=TURNS[0], **o
    ),
    "ball.render": lambda x, p, **o: sm.ball.render(x, p, size=5, background="alpha", **o),
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
    "shade_environment": lambda x, p, **o: sm.light.shade_environment(
        PLACES, PLACES[::-1], [0, 0, 9], x, p, mipmaps=True, **o
    ),
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
UNTURNED = ("pad", "bake_matcap", "ball.render", "integrate", "mean")
TURNED = [name for name in EVERY if name not in UNTURNED]
# What makes something else of an image makes a list of a batch.
OBJECTS = {
    "lights": lambda x, p, **o: sm.light.lights(x, p, count=3, luminance=[2, 1], **o),
    "sun": lambda x, p, **o: sm.light.sun(x, p, luminance=[2, 1], **o),
    "energy": lambda x, p, **o: sm.light.energy(x, p, luminance=[2, 1], **o),
    "bake": lambda x, p, **o: sm.light.bake(x, p, specular=False, diffuse_size=2, order=1, **o),
}


def skies(source, n=3):
    """Return a batch that has a sun in each image but the last."""
    images = batch(source, n=n, size=16)
    height = np.nan_to_num(sm.directions(named(source), images.shape[1:-1])[..., 1])
    images.reshape(n, -1, 2)[:-1, np.argmax(np.where(height < 0.9, height, 0))] = 1e4
    return images


def assert_same_objects(got, want):
    assert type(got) is type(want)
    if dataclasses.is_dataclass(want):
        for field in dataclasses.fields(want):
            assert_same_objects(getattr(got, field.name), getattr(want, field.name))
    elif isinstance(want, list | tuple):
        assert len(got) == len(want)
        for one, other in zip(got, want, strict=True):
            assert_same_objects(one, other)
    elif want is not None:
        assert_same_bits(np.asarray(got), np.asarray(want))


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
@pytest.mark.parametrize("name", OBJECTS)
def test_what_is_no_array_is_a_list(name, source):
    verb, p, images = OBJECTS[name], named(source), skies(source)
    want = [verb(image, p) for image in images]
    assert_same_objects(verb(images, p), want)
    assert_same_objects(verb(list(images), p), want)
    first = np.moveaxis(images, -1, -3)
    assert_same_objects(verb(first, p, channels_first=True), want)
    assert_same_objects(verb(first[0], p, channels_first=True), want[0])
    assert verb(images[:0], p) == []
    one_by_one = [verb(x, p, rotation=r) for x, r in zip(images, TURNS, strict=True)]
    assert_same_objects(verb(images, p, rotation=TURNS), one_by_one)
    assert_same_objects(verb(images[0], p, rotation=TURNS[:1]), one_by_one[:1])


@pytest.mark.parametrize("source", SOURCES)
def test_suns_of_a_batch_go_out_and_come_back(source):
    p, images = named(source), skies(source)
    luminance = [2, 1]
    one_by_one = [sm.light.remove_sun(image, p, luminance=luminance) for image in images]
    want, found = (list(part) for part in zip(*one_by_one, strict=True))
    assert found[0] is not None and found[-1] is None
    dull, suns = sm.light.remove_sun(images, p, luminance=luminance)
    assert_same_bits(dull, np.stack(want))
    assert_same_objects(suns, found)
    bright = np.stack([sm.light.add_sun(x, s, p) for x, s in zip(dull, suns, strict=True)])
    assert_same_bits(sm.light.add_sun(dull, suns, p), bright)
    assert_same_bits(bright[-1], dull[-1])
    for all_of_it in (suns[0], None):
        one_by_one = [sm.light.add_sun(x, all_of_it, p) for x in dull]
        assert_same_bits(sm.light.add_sun(dull, all_of_it, p), np.stack(one_by_one))
    first = np.moveaxis(images, -1, -3)
    dull_first, suns = sm.light.remove_sun(first, p, luminance=luminance, channels_first=True)
    assert_same_bits(dull_first, np.moveaxis(dull, -1, -3))
    bright_first = sm.light.add_sun(dull_first, suns, p, channels_first=True)
    assert_same_bits(bright_first, np.moveaxis(bright, -1, -3))
    none, no_suns = sm.light.remove_sun(images[:0], p, luminance=luminance)
    assert none.shape == images[:0].shape and no_suns == []
    assert sm.light.add_sun(none, no_suns, p).shape == none.shape
    with pytest.raises(ValueError, match="one `sun`, or one for each image: got 2 for 3 images"):
        sm.light.add_sun(images, suns[:2], p)
    with pytest.raises(TypeError, match="Expected `sun` to be a Sun, got list"):
        sm.light.add_sun(images[0], suns, p)


def test_a_distribution_says_how_there_is_one_for_each_image():
    images = batch("latlong")
    for given, turns in ((images, None), (images[0], TURNS), (images[:0], None)):
        with pytest.raises(
            ValueError, match=r"\[sm\.light\.Distribution\(one, \.\.\.\) for one in"
        ):
            sm.light.Distribution(given, "latlong", rotation=turns, luminance=[1, 1])
    first = np.moveaxis(images[0], -1, 0)
    d = sm.light.Distribution(first, "latlong", luminance=[2, 1], channels_first=True)
    want = sm.light.Distribution(images[0], "latlong", luminance=[2, 1])
    assert_same_bits(d.pdf(PLACES), want.pdf(PLACES))
    xi = np.random.default_rng(2).random((9, 2))
    for got, of_want in zip(d.sample(xi, weights=True), want.sample(xi, weights=True), strict=True):
        assert_same_bits(got, of_want)


def test_errors_of_two_batches():
    images, others = batch("latlong"), batch("latlong", n=6)[3:]
    want = [sm.light.ws_psnr(a, b, "latlong") for a, b in zip(images, others, strict=True)]
    assert_same_bits(sm.light.ws_psnr(images, others, "latlong"), np.array(want))
    first = [np.moveaxis(x, -1, -3) for x in (images, others)]
    assert_same_bits(sm.light.ws_psnr(*first, "latlong", channels_first=True), np.array(want))
    pair = [x[0] for x in first]
    assert sm.light.ws_psnr(*pair, "latlong", channels_first=True) == want[0]
    assert sm.light.ws_psnr(images[:0], others[:0], "latlong").shape == (0,)
    with pytest.raises(ValueError, match=r"of one shape, got \(3, 8, 16, 2\) and \(8, 16, 2\)"):
        sm.light.ws_psnr(images, others[0], "latlong")


def test_pictures_and_matcaps():
    pictures, uv = batch("matcap"), np.random.default_rng(3).random((4, 5, 2))
    first = np.moveaxis(pictures, -1, -3)
    for verb in (
        lambda x, **o: sm.sample_uv(x, uv, address="mirror", lod=0.5, **o),
        lambda x, **o: sm.light.shade_matcap(PLACES, x, pose=TURNS[0], mipmaps=True, **o),
    ):
        want = np.stack([verb(picture) for picture in pictures])
        assert_same_bits(verb(pictures), want)
        assert_same_bits(verb(first, channels_first=True), np.moveaxis(want, -1, 1))
        assert_same_bits(verb(first[1], channels_first=True), np.moveaxis(want[1], -1, 0))
        assert verb(pictures[:0]).shape == (0, *want.shape[1:])
        with pytest.raises(ValueError, match=r"shape \(., .\) or \(., ., C\)"):
            verb(pictures[None, None])
    out = np.empty((3, 4, 5, 2), np.float32)
    assert sm.sample_uv(pictures, uv, out=out) is out
    assert_same_bits(out, sm.sample_uv(pictures, uv))
    labels = batch("matcap", np.uint8).astype(np.int64)
    want = np.stack([sm.sample_uv(x, uv, filter="nearest") for x in labels])
    assert_same_bits(sm.sample_uv(labels, uv, filter="nearest"), want)


@pytest.mark.parametrize("source", SOURCES)
def test_points_of_depth(source):
    p, depth = named(source), batch(source, channels=1) + 1
    want = np.stack([sm.depth_to_points(x[..., 0], p) for x in depth])
    assert_same_bits(sm.depth_to_points(depth, p), want)
    assert_same_bits(sm.depth_to_points(depth[0], p), want[0])
    got = sm.depth_to_points(np.moveaxis(depth, -1, -3), p, channels_first=True)
    assert_same_bits(got, np.moveaxis(want, -1, -3))
    turned = [sm.depth_to_points(x, p, rotation=r) for x, r in zip(depth, TURNS, strict=True)]
    assert_same_bits(sm.depth_to_points(depth, p, rotation=TURNS), np.stack(turned))
    assert sm.depth_to_points(depth[:0], p).shape == (0, *want.shape[1:])
    with pytest.raises(ValueError, match=r"Expected `depth` to have shape"):
        sm.depth_to_points(batch(source), p)


def test_embedding_of_batches():
    views, images = batch("perspective"), batch("latlong")

    def verb(view, image, **o):
        return sm.embed(view, "perspective", image, "latlong", feather=2, filter="nearest", **o)

    of_each = np.stack([verb(view, image) for view, image in zip(views, images, strict=True)])
    into_one = np.stack([verb(view, images[0]) for view in views])
    of_one = np.stack([verb(views[0], image) for image in images])
    turned = np.stack([verb(views[0], images[0], rotation=turn) for turn in TURNS])
    each_turned = [verb(views[0], x, rotation=r) for x, r in zip(images, TURNS, strict=True)]
    for moved in (False, True):

        def laid(x, moved=moved):
            return np.moveaxis(x, -1, -3) if moved else x

        def embedded(view, image, laid=laid, moved=moved, **o):
            return verb(laid(view), laid(image), channels_first=moved, **o)

        assert_same_bits(embedded(views, images), laid(of_each))
        assert_same_bits(embedded(views, images[0]), laid(into_one))
        assert_same_bits(embedded(views[0], images), laid(of_one))
        assert_same_bits(embedded(views[0], images[0], rotation=TURNS), laid(turned))
        assert_same_bits(embedded(views[0], images, rotation=TURNS), laid(np.stack(each_turned)))
        assert embedded(views[:0], images[:0]).shape == laid(images[:0]).shape
        assert embedded(views[0], images[:0]).shape == laid(images[:0]).shape
    out = images.copy()
    assert verb(views, out, out=out) is out
    assert_same_bits(out, of_each)
    with pytest.raises(ValueError, match="one `image`, or one for each image: got 2 for 3 images"):
        verb(views, images[:2])
    with pytest.raises(ValueError, match="one rotation, or one for each image: got 3 for 2"):
        verb(views[:2], images[0], rotation=TURNS)


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


@pytest.mark.parametrize("material", ["diffuse", "rough"])
@pytest.mark.parametrize("source", ["angular", "cube(layout)"])
def test_what_holds_no_sphere_is_no_light_of_a_matcap(source, material):
    p = named(source)
    white = np.ones(sm.Projection.shape(sm.projection(p) if isinstance(p, str) else p, 32))
    baked = sm.light.bake_matcap(white, p, material=material, size=8, roughness=0.7, pose=TURNS[1])
    # A white sphere is white by any lobe: sums over 32 texels along a side are exact to their
    # solid angles, the resampling at the rim of a disk to a lookup.
    held = np.isfinite(sm.directions("matcap", 8)[..., 0])
    assert np.abs(baked[held] - 1).max() < 0.02
