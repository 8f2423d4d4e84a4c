"""Views of a known panorama, stitched again."""

from __future__ import annotations

import tracemalloc

import cv2
import numpy as np
import pytest
import reference.stitching as literal
import spheremap as sm
from conftest import some_fast
from spheremap.cameras import mixing, stitching
from spheremap.cameras.borders import signed_distance
from spheremap.cameras.exposure import _least_squares

RIGS = {
    "cube": dict(fov=90, overlap=0.1),
    "twelve": dict(n=12, overlap=0.2),
    "wide": dict(n=6, overlap=0.2),
}
BACK = "angular(fov=200)"


def scene(d):
    """Colors without detail finer than an eighth of a turn, between 0.1 and 0.9."""
    waves = np.sin(np.asarray(d) @ np.array([[3, 1, 0], [0, 4, 2], [-2, 0, 4.0]]))
    return (0.5 + 0.4 * waves).astype(np.float32)


def panorama(size=256, projection="latlong"):
    return scene(sm.directions(projection, size))


def off(got, projection="latlong", turn=None):
    """Return how far texels are from the scene: from what centers see to means by solid angle.

    Beside the poles of a latlong these are not the same; of a texel that sees little more than one
    pixel the one is right, of one that sees several the other.
    """
    p = sm.projection(projection) if isinstance(projection, str) else projection
    shape = got.shape[:-1]
    finer = (*shape[:-2], 4 * shape[-2], 4 * shape[-1])
    turn = np.eye(3) if turn is None else turn
    centers = scene(p.directions(shape) @ turn)
    means = sm.convert(scene(p.directions(finer) @ turn), p, p, size=shape, filter="area")
    below, above = np.minimum(centers, means) - got, got - np.maximum(centers, means)
    return np.maximum(np.maximum(below, above), 0).max()


def views(rig, size=512):
    """Return what each camera of a rig sees of the scene, by its formula and no conversion."""
    latlong = sm.projection("latlong")
    seen = [view.projection.in_world_of(latlong) for view in rig]
    return [scene(camera.directions(view.size)) for camera, view in zip(seen, rig, strict=True)]


def lenses(size=256, fov=200):
    cameras = sm.cameras.back_to_back(f"angular(fov={fov})")
    return [np.nan_to_num(scene(c.directions(size))) for c in cameras], cameras


@pytest.mark.parametrize("blend", ["feather", "bands", "nearest"])
@some_fast(
    ("dst", "size"), [("latlong", 256), ("cube", 128), ("octahedral", 256)], fast=[("latlong", 256)]
)
@pytest.mark.parametrize("name", RIGS)
def test_a_panorama_comes_back_from_its_views(name, dst, size, blend):
    rig = sm.cameras.rig(256, **RIGS[name])
    got, weight = sm.cameras.stitch(
        views(rig), rig, dst, size=size, blend=blend, return_weight=True
    )
    truth = panorama(size, dst)
    assert got.shape == truth.shape and got.dtype == np.float32
    assert (weight > 0).all()
    # A pixel of 170 degrees is 3.3/256 at most, of waves up to 5: (h k)²/8 · 0.4 is 2e-4. What an
    # antialiased mean adds is up to three times as much, of texels 1/80 wide.
    assert off(got, dst) < 2e-3
    # And its mean square far less: 60 dB is 1e-3 of 1.
    assert 10 * np.log10(1 / np.mean((got - truth) ** 2)) > 60


def test_views_of_another_world_are_matched():
    rig = sm.cameras.rig(128, n=12)
    for name in ("latlong:blender", "latlong:unreal"):
        got = sm.cameras.stitch(views(rig), rig, name, size=128)
        # As above, of pixels and texels twice as wide.
        assert off(got, sm.projection(name).in_world_of("latlong")) < 4e-3


def test_a_rotation_turns_what_is_seen():
    pictures, cameras = lenses()
    turn = sm.rotation(20, 10, 5)
    got = sm.cameras.stitch(pictures, cameras, "latlong", size=128, rotation=turn)
    # Pixels of 200°/256 and texels of 180°/128: (1.4° k)²/8 · 0.4 with k up to 5, and their mean.
    assert off(got, turn=turn) < 4e-3


@some_fast("dtype", ["uint8", "uint16", "float16", "float32", "float64"], fast=("uint8", "float32"))
@pytest.mark.parametrize("gray", [True, False])
def test_constants_stay_constant(dtype, gray):
    rig = sm.cameras.rig(64, **RIGS["twelve"])
    value = 201 if dtype.startswith("u") else 0.7
    given = [np.full((64, 64) if gray else (64, 64, 2), value, dtype) for _ in rig]
    for blend in ("feather", "nearest"):
        got = sm.cameras.stitch(given, rig, "latlong", size=64, blend=blend)
        assert got.dtype == dtype and got.shape == ((64, 128) if gray else (64, 128, 2))
        if dtype.startswith("u"):
            assert (got == 201).all()
        else:
            # Products, a mean of up to a hundred, a sum of four views, a quotient; float16 once.
            bound = 8 * max(np.finfo(dtype).eps, np.finfo(np.float32).eps * (dtype != "float64"))
            assert np.abs(got - given[0].flat[0]).max() <= bound
    ones = [np.ones((64, 64), np.float32) for _ in rig]
    # A one has the bits of its weight all the way.
    assert (sm.cameras.stitch(ones, rig, "latlong", size=64) == 1).all()


def test_the_order_of_views_does_not_matter():
    rig = sm.cameras.rig(96, **RIGS["twelve"])
    pictures = views(rig)
    order = np.random.default_rng(510).permutation(len(rig))
    other = sm.cameras.Rig(tuple(rig[int(k)] for k in order))
    again = [pictures[k] for k in order]
    a, b = (
        sm.cameras.stitch(p, r, "latlong", size=96) for p, r in ((pictures, rig), (again, other))
    )
    # Sums of at most six numbers of one sign, in another order: as many ε of float32.
    assert np.abs(a - b).max() < 6 * np.finfo(np.float32).eps
    a, b = (
        sm.cameras.stitch(p, r, "latlong", size=96, blend="nearest")
        for p, r in ((pictures, rig), (again, other))
    )
    # Views that are equally far from their ends are told apart by their order: two pictures there.
    assert np.mean(a != b) < 0.02
    # Both show the scene: as in the first test.
    assert np.abs(a - b).max() < 4e-3


def test_gains_are_found():
    rig = sm.cameras.rig(128, **RIGS["twelve"])
    pictures = views(rig)
    rng = np.random.default_rng(511)
    factors = np.exp(rng.normal(size=len(rig)) * 0.3).astype(np.float32)
    darker = [p * f for p, f in zip(pictures, factors, strict=True)]
    found = sm.cameras.gains(darker, rig)
    assert np.log(found).mean() == pytest.approx(0, abs=1e-12)  # roundings of twelve logarithms
    product = found * factors
    # What the issue asks for; views of one scene disagree by the means of their pixels, 2e-4.
    assert np.abs(product / product.mean() - 1).max() < 1e-3
    matched = sm.cameras.stitch(darker, rig, "latlong", size=128, exposure="match")
    given = sm.cameras.stitch(darker, rig, "latlong", size=128, exposure=found)
    assert np.array_equal(matched, given)
    # The gauge is a factor of all; then 4e-3 as for pixels and texels twice as wide, of values
    # from 0.1 on, most of it where those are 0.2 and more.
    truth = panorama(128) * product.mean()
    assert np.abs(matched / truth - 1).max() < 2e-2


@pytest.mark.parametrize("curve", ["srgb", "linear"])
def test_gains_of_integers_are_those_of_light(curve):
    pictures, cameras = lenses()
    light = [p * f for p, f in zip(pictures, (0.5, 0.8), strict=True)]
    if curve == "srgb":
        # IEC 61966-2-1, of what is brighter than its line.
        light = [np.where(p > 0.0031308, 1.055 * p ** (1 / 2.4) - 0.055, 12.92 * p) for p in light]
    codes = [np.rint(p * 65535).astype(np.uint16) for p in light]
    found = sm.cameras.gains(codes, cameras, curve=curve)
    # As the issue asks; two lenses disagree by means of pixels at their rims, 2e-4.
    assert found[0] / found[1] == pytest.approx(1.6, rel=1e-3)
    assert found[0] * found[1] == pytest.approx(1, rel=1e-12)  # by construction, one rounding each
    plain = sm.cameras.stitch(codes, cameras, "latlong", size=128, exposure="match", curve=curve)
    truth = panorama(128) * np.sqrt(0.4)
    if curve == "srgb":
        truth = 1.055 * truth ** (1 / 2.4) - 0.055
    # Codes are mixed where light would be: bent by its curvature within a texel; as above.
    assert np.abs(plain / 65535 - truth).max() < 4e-3


def test_what_is_overexposed_says_nothing():
    pictures, cameras = lenses()
    codes = [
        np.rint(np.clip(p * f, 0, 1) * 255).astype(np.uint8)
        for f, p in zip((1.6, 0.8), pictures, strict=True)
    ]
    assert (codes[0] == 255).mean() > 0.05
    found = sm.cameras.gains(codes, cameras, curve="linear")
    # The other view's light still counts in texels that hold a few such pixels, and not those.
    assert found[1] / found[0] == pytest.approx(2, rel=0.01)


def test_gains_are_least_squares():
    rng = np.random.default_rng(512)
    parts, ratios = np.tril(rng.uniform(0.1, 1, (5, 5)), -1), np.tril(rng.normal(size=(5, 5)), -1)
    # Well conditioned systems of five unknowns.
    assert np.allclose(_least_squares(parts, ratios), literal.gains(parts, ratios), rtol=1e-12)
    # Two groups that nothing joins have a gauge each.
    parts[3:, :3] = 0
    found = np.log(_least_squares(parts, ratios))
    assert np.abs([found[:3].sum(), found[3:].sum()]).max() < 1e-12  # roundings of five sums


@pytest.mark.parametrize("blend", ["feather", "bands", "nearest"])
@pytest.mark.parametrize(
    ("dtype", "options", "nothing"),
    [
        (np.float32, {}, 0),
        (np.uint8, {}, 0),
        (np.float16, {"fill": np.nan}, np.nan),
        (np.uint8, {"fill": [1, 2, 3.4]}, [1, 2, 3]),
    ],
)
def test_what_no_view_sees(dtype, options, nothing, blend):
    rig = sm.cameras.rig(64, fov=90, overlap=0)
    one = np.full((64, 64, 3), 9, dtype)
    got, weight = sm.cameras.stitch(
        [one], rig[:1], "latlong", size=64, blend=blend, return_weight=True, **options
    )
    assert weight.shape == (64, 128) and weight.dtype == np.float32
    unseen = weight == 0
    assert np.array_equal(got[unseen], np.full((unseen.sum(), 3), nothing), equal_nan=True)
    # A product, a mean of a few and a quotient of float32; bands are seven sums.
    bound = 9 * (4 if blend != "bands" else 16) * np.finfo(np.float32).eps
    assert np.abs(got[~unseen].astype(float) - 9).max() <= bound
    camera = rig[0].projection.in_world_of("latlong")
    assert np.array_equal(~unseen, camera.covers(sm.directions("latlong", 64)))


@pytest.mark.parametrize("fov", [190, 200, 240])
def test_lenses_are_blended_by_the_squares_of_their_distances(fov):
    cameras = sm.cameras.back_to_back(f"angular(fov={fov})")
    black, white = np.zeros((512, 512), np.float64), np.ones((512, 512), np.float64)
    got = sm.cameras.stitch([white, black], cameras, "latlong", size=256)
    theta = np.arccos(-sm.directions("latlong", 256)[..., 2])
    want = literal.share_of_first(theta, np.radians(fov))
    # A rim is known to half a pixel of fov/512, and the square of the distance is mixed over a
    # texel; across the overlap of fov - 180 degrees the share goes from 1 to 0, twice as fast
    # in the middle.
    half = 1.5 * fov / 512 + 180 / 256 / 4
    assert np.abs(got - want).max() < 2 * half / (fov - 180)


def test_no_seam_shows():
    """Lenses of 200 degrees, the one a fifth brighter: steps are the scene's and the blend's."""
    pictures, cameras = lenses(512)
    truth = panorama()
    pictures[1] *= np.float32(1.2)

    def steps(image):
        return max(np.abs(np.diff(image, axis=k)).max() for k in (0, 1))

    feather, nearest = (
        sm.cameras.stitch(pictures, cameras, "latlong", size=256, blend=blend)
        for blend in ("feather", "nearest")
    )
    # From 1 to 1.2 over 20 degrees, twice as fast in the middle, of values up to 0.9: in steps of
    # 180/256 degrees. The truth's own may be a fifth larger.
    assert steps(feather) < 1.2 * steps(truth) + 0.2 * 0.9 * 2 / 20 * 180 / 256
    assert steps(nearest) > 1.2 * steps(truth) + 0.1
    # Across the panorama's own edges as well.
    edge = np.abs(feather[:, 0] - feather[:, -1]).max()
    assert edge < 1.2 * steps(truth) + 0.2 * 0.9 * 2 / 20 * 180 / 256
    matched = sm.cameras.stitch(pictures, cameras, "latlong", size=256, exposure="match")
    # What is left of a fifth by gains that are good to 1e-3.
    assert steps(matched) < steps(truth) * 1.1 * 1.02


@pytest.mark.parametrize("layout", ["faces", "strip", "column"])
@pytest.mark.parametrize("name", ["dual_fisheye(fov=200)", "dual_fisheye(fov=200):ffmpeg"])
def test_a_raw_picture_of_both_lenses_is_one_call(name, layout):
    p = sm.projection(name, layout=layout)
    d = p.in_world_of("latlong").directions(p.shape(256))
    raw = np.nan_to_num(scene(d))
    got = sm.cameras.stitch(raw, p, "latlong", size=128)
    # Pixels of 200°/256 and texels of 180°/128: (1.4° k)²/8 · 0.4 with k up to 5, and their mean.
    assert off(got) < 4e-3
    turned = p.turned(sm.rotation(30, 20, 10))
    got = sm.cameras.stitch(raw, turned, "latlong", size=128)
    if not name.endswith("ffmpeg"):
        assert off(got, turn=sm.rotation(30, 20, 10)) < 4e-3  # as above


def test_a_raw_picture_lies_side_by_side_where_nothing_is_said():
    p = sm.projection("dual_fisheye", fov=200, layout="strip")
    raw = np.nan_to_num(scene(p.directions(p.shape(64))))
    strip, said_less = (
        sm.cameras.stitch(raw, q, "latlong", size=32) for q in (p, "dual_fisheye(fov=200)")
    )
    assert np.array_equal(strip, said_less)
    gray = sm.cameras.stitch(raw[..., 0], "dual_fisheye(fov=200)", "latlong", size=32)
    assert np.array_equal(gray, strip[..., 0])


def test_pictures_side_by_side_are_those_in_a_list():
    pictures, cameras = lenses(64)
    listed = sm.cameras.stitch(pictures, cameras, "latlong", size=32)
    beside = sm.cameras.stitch(np.hstack(pictures), cameras, "latlong", size=32)
    batch = sm.cameras.stitch(np.stack(pictures), cameras, "latlong", size=32)
    assert np.array_equal(listed, beside) and np.array_equal(listed, batch)
    gray = sm.cameras.stitch([p[..., 0] for p in pictures], cameras, "latlong", size=32)
    assert np.array_equal(gray, listed[..., 0])


def test_calibrated_lenses_and_the_dark_around_them():
    size, focal = 256, 68.0
    options = dict(distortion=[0.02, -0.003, 0.0004, 0], model="kannala_brandt")
    front = sm.camera((focal, focal + 1, 126.0, 129.5), (size, size), **options)
    back = sm.camera((focal + 2, focal, 128.5, 127.0), (size, size), **options)
    # The second is mounted askew, as its calibration says.
    pose = np.diag([-1.0, 1, -1]) @ sm.rotation(3, -2, 1)
    cameras = sm.cameras.back_to_back(front, back, pose=pose)
    pictures = []
    for camera in cameras:
        d = camera.in_world_of("latlong").directions((size, size))
        axis = camera.pose[:, 2] if camera.pose is not None else np.array([0, 0, 1.0])
        theta = np.arccos(np.clip(camera.directions((size, size)) @ axis, -1, 1))
        # Nothing else is as bright as what lies beyond the lens.
        pictures.append(np.where(theta[..., None] < np.radians(100), scene(d), np.float32(50)))
    got = sm.cameras.stitch(pictures, cameras, "latlong", size=128, fov=198)
    # Pixels of 0.85 and texels of 1.4 degrees: as for ideal lenses; nothing is 50.
    assert off(got) < 4e-3
    assert sm.cameras.stitch(pictures, cameras, "latlong", size=128).max() > 10


def test_masked_pixels_and_those_that_are_not_finite_do_not_count():
    pictures, cameras = lenses()
    rng = np.random.default_rng(513)
    mask = np.ones((256, 256), bool)
    mask[100:130, 90:120] = False
    mask &= rng.random(mask.shape) > 0.01
    spoiled = pictures[0].copy()
    spoiled[~mask] = 1e6
    got, weight = sm.cameras.stitch(
        [spoiled, pictures[1]], cameras, "latlong", size=128, masks=[mask, None], return_weight=True
    )
    assert got.max() < 1 and (weight == 0).any()
    spoiled[~mask] = np.nan
    spoiled[3, 128, 1] = np.inf
    other = sm.cameras.stitch([spoiled, pictures[1]], cameras, "latlong", size=128, fill=np.nan)
    assert np.nanmax(other) < 1
    truth = panorama(128)
    # Beside a hole a texel is the mean of what is left of it, half a pixel of 0.8° off: times k.
    assert np.nanmax(np.abs(other - truth)) < 0.05


def test_a_sphere_among_the_views_fills_the_rest():
    rig = sm.cameras.rig(128, fov=90)
    whole = panorama(64)
    camera = rig[0].projection
    latlong = sm.projection("latlong").in_world_of(camera)
    got = sm.cameras.stitch([views(rig)[0], whole], [camera, latlong], "latlong", size=128)
    # Texels of 2.8 degrees: (h k)²/8 · 0.4 with k up to 5.
    assert np.abs(got - panorama(128)).max() < 1e-2


def test_distances_to_a_border_are_those_to_its_nearest_pixel():
    rng = np.random.default_rng(514)
    disk = np.hypot(*(np.mgrid[:40, :60] + 0.5 - [[[20]], [[25]]])) < 18
    for mask in (disk, ~disk, rng.random((40, 60)) > 0.02, rng.random((40, 60)) > 0.9):
        got = signed_distance(mask, 9, 13)
        for k, y in enumerate(np.linspace(0, 40, 9)):
            for i, x in enumerate(np.linspace(0, 60, 13)):
                # Whole numbers under one root.
                assert got[k, i] == pytest.approx(literal.signed_distance(mask, x, y), abs=1e-12)


def test_the_number_of_threads_changes_no_bit():
    pictures, cameras = lenses(300)
    before = sm.get_num_threads()
    found = []
    try:
        for threads in (1, 3):
            sm.set_num_threads(threads)
            found.append(
                sm.cameras.stitch(pictures, cameras, "latlong", size=256, exposure="match")
            )
    finally:
        sm.set_num_threads(before)
    assert np.array_equal(*found)


@pytest.mark.parametrize(("size", "held"), [(512, 4), (256, 1)])
def test_the_memory_is_that_of_the_pictures_or_of_two_images(size, held):
    cameras = sm.cameras.back_to_back(BACK)
    pictures = [np.zeros((512, 512, 3), np.uint8)] * 4
    tracemalloc.start()
    try:
        sm.cameras.stitch(pictures, [*cameras, *cameras], "latlong", size=size)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    texels, pixels = 2 * size**2, 512**2
    # Four pictures are as much as two images of 512 rows; beside images of 256 one is held.
    layers = 2 * 4 * mixing.FEW if held > 1 else 2 * 16 * texels
    wanted = held * 16 * pixels + layers + 3 * texels
    # Masks of four pictures are a byte a pixel; blocks and nodes are a few MB, of any size.
    assert peak < wanted + 4 * pixels + 12e6


@pytest.mark.parametrize("blend", ["feather", "nearest"])
@some_fast(
    ("dst", "size"), [("latlong", 300), ("cube", 150), ("octahedral", 200)], fast=[("cube", 150)]
)
def test_parts_of_a_panorama_are_those_of_the_whole(blend, dst, size, monkeypatch):
    rig = sm.cameras.rig(96, n=12, overlap=0.2)
    pictures = [np.uint8(255 * view) for view in views(rig, 96)]
    options = dict(size=size, blend=blend, return_weight=True)
    found = []
    for few in (1, 1 << 30):
        monkeypatch.setattr(mixing, "FEW", few)
        found.append(sm.cameras.stitch(pictures, rig, dst, **options))
    monkeypatch.setattr(stitching, "by_rows", lambda *_: False)
    found.append(sm.cameras.stitch(pictures, rig, dst, **options))
    for image, weight in found[1:]:
        assert np.array_equal(image, found[0][0]) and np.array_equal(weight, found[0][1])


def test_without_a_size_it_is_that_of_the_finest_view():
    pictures, cameras = lenses(64)
    coarse = pictures[1][::2, ::2]
    got = sm.cameras.stitch([pictures[0], coarse], cameras, "latlong")
    assert got.shape == sm.convert(pictures[0], cameras[0], "latlong").shape


RAW = np.zeros((8, 16, 3), np.uint8)
LENS = np.zeros((8, 8, 3), np.uint8)


@pytest.mark.parametrize(
    ("images", "cameras", "options", "text"),
    [
        ([LENS], [BACK, BACK], {}, "got 1 for 2 cameras"),
        ([LENS, LENS], BACK, {}, "got 2 for 1 camera; of one lens `back_to_back`"),
        ([LENS, RAW], [BACK, BACK], {}, "as wide as high"),
        ([LENS, LENS[..., :2]], [BACK, BACK], {}, "as many channels"),
        ([LENS, LENS.astype(np.float32)], [BACK, BACK], {}, "of one dtype"),
        ([LENS[None]], [BACK], {}, r"shape \(H, W\) or \(H, W, C\)"),
        (np.zeros((8, 15, 3)), [BACK, BACK], {}, "side by side"),
        ([LENS], [], {}, "at least one camera"),
        ([LENS], ["cube"], {}, "6 faces"),
        (
            [LENS, LENS],
            "dual_fisheye(fov=200)",
            {"blend": "poisson"},
            "'feather', 'bands' or 'nearest'",
        ),
        (LENS[0, 0], "dual_fisheye(fov=200)", {}, "one raw picture"),
        (3, "dual_fisheye(fov=200)", {}, "one raw picture"),
        ([LENS], [BACK], {"exposure": "auto"}, "'match' or gains"),
        ([LENS], [BACK], {"exposure": [1.0, 2.0]}, "one gain a picture"),
        ([LENS], [BACK], {"exposure": [0.0]}, "positive and finite"),
        ([LENS], [BACK], {"curve": "log"}, "'srgb' or 'linear'"),
        ([LENS], [BACK], {"fov": 0}, r"in \(0, 360\]"),
        ([LENS], [BACK], {"fov": [90, 90]}, "for each of 1 cameras"),
        ([LENS], [BACK], {"masks": [np.ones((8, 4), bool)]}, "mask of shape"),
        ([LENS], [BACK], {"size": (8, 8)}, "twice as wide"),
        ([LENS], [BACK], {"fill": np.nan}, "`fill` NaN is no value of uint8"),
        ([LENS], [BACK], {"fill": [1, 2]}, "`fill` to have one number for each of 3 channels"),
    ],
)
def test_what_is_wrong_is_told(images, cameras, options, text):
    with pytest.raises(ValueError, match=text):
        sm.cameras.stitch(images, cameras, "latlong", **options)


@pytest.mark.parametrize(
    ("images", "options", "text"),
    [
        ([LENS], {"masks": [np.ones((8, 8), np.uint8)]}, "of bool"),
        ([LENS.astype(np.int32)], {}, "dtype"),
        ([LENS], {"return_weight": 1}, "a bool"),
        (3, {}, "sequence of pictures"),
        ([LENS], {"fill": "black"}, "`fill` to be a number"),
    ],
)
def test_what_is_of_another_kind_is_told(images, options, text):
    with pytest.raises(TypeError, match=text):
        sm.cameras.stitch(images, [BACK], "latlong", **options)


def test_bands_spread_what_exposure_leaves_and_keep_detail():
    cameras = sm.cameras.back_to_back(BACK)
    # Brighter by 30 % in one lens: the step is 0.3 where nothing is mixed.
    flat = [np.ones((256, 256), np.float32), np.full((256, 256), 1.3, np.float32)]
    steps = {}
    for blend in ("nearest", "feather", "bands"):
        image = sm.cameras.stitch(flat, cameras, "latlong", size=128, blend=blend)
        steps[blend] = np.abs(np.diff(image, axis=1)).max()
        # Weighted means of float32 in 1 to 1.3.
        assert image.min() > 1 - 1e-6 and image.max() < 1.3 + 1e-6
    assert steps["bands"] < steps["feather"] < 0.2 * steps["nearest"]
    # Bars that do not fit: their mean is gray, and bands show one of both.
    wave = np.sin(np.arange(512) * (np.pi / 2)).astype(np.float32)
    bars = [np.tile(1 + sign * wave, (256, 1)) for sign in (1, -1)]
    pair = [sm.convert(b, "latlong", c, size=1024) for b, c in zip(bars, cameras, strict=True)]
    contrast = {}
    for blend in ("feather", "bands"):
        image = sm.cameras.stitch(pair, cameras, "latlong", size=256, blend=blend)[128]
        contrast[blend] = np.convolve(np.abs(image - 1), np.ones(8) / 8, mode="valid").min()
    assert contrast["bands"] > 2 * contrast["feather"]


def test_bands_leave_out_what_no_view_sees():
    camera = sm.projection("angular", fov=120)
    one = np.full((64, 64, 3), 100, np.uint8)
    image, weight = sm.cameras.stitch(
        [one], [camera], "latlong", size=32, blend="bands", return_weight=True
    )
    assert (image[weight > 0] == 100).all() and (image[weight == 0] == 0).all()
    assert 0 < (weight == 0).mean() < 1


def test_bands_are_those_of_opencvs_blender():
    """Away from the panorama's own edges, of which OpenCV's blender does not know."""
    cameras = sm.cameras.back_to_back(BACK)
    size = 256
    owner = np.argmax([_layer(np.ones((64, 64)), c, size)[1] for c in cameras], axis=0)
    seen, _ = lenses(512)
    found = {}
    for gain in (1.0, 1.15):
        pictures = [100 * seen[0], np.float32(gain) * 100 * seen[1]]
        ours = sm.cameras.stitch(pictures, cameras, "latlong", size=size, blend="bands")
        # What is beyond a view goes on with what both show.
        mean = sm.cameras.stitch(pictures, cameras, "latlong", size=size)
        theirs = cv2.detail_MultiBandBlender(0, 5)
        theirs.prepare((0, 0, 2 * size, size))
        for k, (picture, camera) in enumerate(zip(pictures, cameras, strict=True)):
            image, weight = _layer(picture, camera, size)
            whole = np.where(weight[..., None] > 0, image, mean)
            # It blends integers, and loses one or so in each band: of 10,000 that is nothing.
            theirs.feed(np.int16(100 * whole), np.uint8(255 * (owner == k)), (0, 0))
        image, _ = theirs.blend(None, None)
        found[gain] = np.abs(image / 100 - ours)[64:-64, 64:-64].max()
    # Six bands of integers, and what the views differ by.
    assert found[1.0] < 0.25
    # Its levels are smoother than ours: a fifth of a step of 15.
    assert found[1.15] < 0.25 * 15


def _layer(picture, camera, size):
    return sm.cameras.stitch([picture], [camera], "latlong", size=size, return_weight=True)
