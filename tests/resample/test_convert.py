"""Images from one projection to another."""

from __future__ import annotations

import math

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, LAYOUTS, NAMES, each, random_directions
from test_sample import CONSTANT, DTYPES, POISON, each_filter, outside, smooth_bound

# Conversion is decode, then encode: what is a projection's own shows with any partner. So each is
# source and target of a few, itself among them, and not of all, whose number grows with the square.
# Steps of 0, 1 and 3 around the registry put kin beside each other and strangers, too.
PAIRS = [(a, NAMES[(i + k) % len(NAMES)]) for i, a in enumerate(NAMES) for k in (0, 1, 3)]
each_pair = pytest.mark.parametrize(("src", "dst"), PAIRS, ids=[f"{a}-{b}" for a, b in PAIRS])


def plain(*arguments, **options):
    """Convert by one lookup a texel: what the others are compared with is a lookup, too."""
    return sm.convert(*arguments, **{"antialias": False, **options})


@each_pair
@each_filter
def test_constant_to_the_bit(src, dst, filter):
    a, b = sm.projection(src), sm.projection(dst)
    d = b.directions(12)
    seen = a.covers(np.nan_to_num(d, nan=0.0))
    for dtype in DTYPES:
        image = np.full((*a.shape(9), 3), CONSTANT[dtype], dtype)
        image[outside(a, 9)] = POISON[dtype]
        got = plain(image, src, dst, size=12, filter=filter, fill=3)
        assert got.dtype == image.dtype and got.shape == (*b.shape(12), 3)
        assert np.all(got[seen] == np.array(CONSTANT[dtype], dtype))
        assert np.all(got[outside(b, 12)] == 3)
        assert np.all(got[~seen] == 3)


@each(LAYOUTS)
@each_filter
def test_constant_through_every_layout(case, filter):
    p = case.make()
    image = np.full((*p.shape(6), 4), 0.3, np.float32)
    image[outside(p, 6)] = 1e30
    got = plain(image, p, "octahedral", size=21, filter=filter, fill=-1)
    ok = p.covers(sm.directions("octahedral", 21))
    assert np.all(got[ok] == np.float32(0.3)) and np.all(got[~ok] == -1)
    back = plain(np.full((21, 21, 4), 0.3, np.float32), "octahedral", p, size=6, fill=-1)
    ok = ~outside(p, 6)
    assert np.all(back[ok] == np.float32(0.3)) and np.all(back[~ok] == -1)


@each_pair
def test_smooth_function_at_every_texel(src, dst):
    a, b = sm.projection(src), sm.projection(dst)
    ra = reference.of(a)
    n = 48
    texels = ra.directions(n)
    image = np.where(np.isnan(texels), 1e30, reference.smooth_function(texels))
    got = plain(image, src, dst, size=31, fill=-5.0)
    d = reference.of(b).directions(31)
    seen = ra.covers(np.nan_to_num(d, nan=0.0)) & ~np.isnan(d[..., 0])
    # A texel exactly on the border of a hemisphere is rounded to either side of it.
    border = (np.abs(d @ reference.axes_matrix(a.axes)[2]) < 1e-12) & (a.coverage == "hemisphere")
    assert np.all(got[~seen & ~border] == -5.0)
    seen &= ~border
    if not seen.any():
        return  # two hemispheres that look away from each other
    error = np.abs(got[seen] - reference.smooth_function(d[seen])).max(-1)
    limit = smooth_bound(ra, d[seen], a.shape(n), "bilinear")
    i = int(np.argmax(error / limit))
    assert np.all(error <= limit), (error[i], limit[i], d[seen][i])


@each_pair
@each_filter
def test_convert_is_sample_at_the_texels(src, dst, filter):
    rng = np.random.default_rng(110)
    a, b = sm.projection(src), sm.projection(dst)
    image = rng.random((*a.shape(17), 3))
    turn = sm.rotation(10, 20, 30)
    got = plain(image, src, dst, size=14, rotation=turn, filter=filter, fill=0.25)
    d = b.directions(14)
    want = a.sample(image, d, rotation=turn, filter=filter, fill=0.25)
    if filter == "nearest":
        # Rounding of d may choose the other of two texels, for a texel in a thousand.
        assert np.mean(np.any(got != want, axis=-1)) < 0.005
    else:
        # Wherever coverage is not decided by a rounding.
        ok = (got != 0.25).all(-1) == (want != 0.25).all(-1)
        assert np.mean(~ok) < 0.01
        error = np.abs(got - want).max(-1)[ok]
        # The rim of a sphere map blurs uv by √eps.
        assert error.max() < (1e-5 if src in reference.ROOT_RIMS else 1e-11)


@each(LAYOUTS)
@pytest.mark.parametrize("dtype", DTYPES)
def test_identity(case, dtype):
    p = case.make()
    rng = np.random.default_rng(111)
    image = (rng.random((*p.shape(20), 3)) * 200).astype(dtype)
    ok = ~outside(p, 20)
    got = plain(image, p, p, size=20, filter="nearest")
    assert np.array_equal(got[ok], image[ok])
    got = plain(image, p, p, size=20)
    # Bilinear at a texel center is off it by a few eps of the coordinate (float32: 20·6·6e-8 of a
    # step of 200 at most); integers round that away, float16 to one ulp.
    limit = {"uint8": 0, "uint16": 0, "float16": 0.125, "float32": 0.02, "float64": 0.02}[dtype]
    assert np.abs(got[ok].astype(float) - image[ok].astype(float)).max() <= limit
    assert np.all(got[~ok] == 0)


@each(DEFAULTS)
def test_default_size_keeps_the_size_of_the_same_projection(case):
    p = case.make()
    for n in (8, 33):
        image = np.zeros((*p.shape(n), 2), np.float32)
        assert plain(image, p, p).shape == image.shape


@each_pair
def test_default_size_has_the_nearest_number_of_covered_texels_per_steradian(src, dst):
    a, b = sm.projection(src), sm.projection(dst)
    n = 40
    got = plain(np.zeros((*a.shape(n), 1), np.float32), src, dst)

    def per_steradian(p, size):
        # Covered texels: the share of the image that holds sphere, times its texels.
        return math.prod(p.shape(size)) * reference.of(p).used_part / p.covered_solid_angle

    want = per_steradian(a, n)
    m = min(range(1, 200), key=lambda k: abs(per_steradian(b, k) - want))
    # "Nearest" in texels or in side length may differ by one.
    side = got.shape[:-1]
    assert side in {b.shape(k) for k in (m - 1, m, m + 1)}


def test_size_may_be_a_whole_shape():
    image = np.zeros((8, 8, 3), np.float32)
    assert plain(image, "octahedral", "latlong", size=(16, 32)).shape == (16, 32, 3)
    assert plain(image, "octahedral", "cube", size=(6, 5, 5)).shape == (6, 5, 5, 3)
    assert plain(image[..., 0], "octahedral", "latlong", size=4).shape == (4, 8)


def test_out_and_fill():
    image = np.random.default_rng(112).random((16, 32, 3)).astype(np.float32)
    out = np.full((20, 20, 3), 9, np.float32)
    assert plain(image, "latlong", "angular", size=20, out=out) is out
    assert np.all(out[0, 0] == 0)
    assert np.array_equal(out, plain(image, "latlong", "angular", size=20))
    got = plain(image, "latlong", "angular", size=20, fill=float("nan"))
    assert np.isnan(got[0, 0]).all()
    assert np.array_equal(np.nan_to_num(got), out)
    with pytest.raises(ValueError, match="out"):
        plain(image, "latlong", "angular", size=20, out=np.empty((20, 21, 3), np.float32))
    with pytest.raises(TypeError, match="out"):
        plain(image, "latlong", "angular", size=20, out=np.empty((20, 20, 3)))
    with pytest.raises(ValueError, match="out"):
        plain(image, "latlong", "latlong", size=16, out=image)


@each_pair
def test_labeled_axes_land_where_they_should(src, dst):
    # ±x ±y ±z as six colors: a flip or a swap of axes shows at once.
    a, b = sm.projection(src), sm.projection(dst)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    d = np.nan_to_num(a.directions(33))
    label = np.argmax(d @ axes.T, axis=-1).astype(np.float64)
    image = plain(label, src, dst, size=33, filter="nearest", fill=-1.0)
    seen = a.covers(axes) & b.covers(axes)
    for part in (a, b):
        if part.coverage == "sphere":
            continue
        seen &= np.abs(axes[:, 2]) == 1  # the others lie on the border
        tilt = axes * 0.95 + 0.15 * part.decode([0.5, 0.5])  # so look a bit above it, too
        both = a.covers(tilt) & b.covers(tilt)
        got = b.sample(image, tilt[both], filter="nearest")
        assert np.array_equal(got, np.flatnonzero(both))
    got = b.sample(image, axes[seen], filter="nearest")
    want = np.flatnonzero(seen).astype(float)
    # The back of a sphere map is its rim, where a texel is many degrees long.
    ok = got == want
    if "sphere" in (src, dst):
        # Axes are exact: -z itself, and no other.
        ok |= np.abs(axes[seen] @ [0, 0, -1] - 1) < 1e-9
    assert ok.all(), (got, want)


@pytest.mark.parametrize("dst", NAMES)
def test_rotation_of_content(dst):
    # f turned by R is f(Rᵀ d).
    turn = sm.rotation(35, -50, 110)
    texels = sm.directions("latlong", 90)
    image = reference.smooth_function(texels)
    got = plain(image, "latlong", dst, size=30, rotation=turn)
    d = sm.directions(dst, 30)
    ok = ~np.isnan(d[..., 0])
    want = reference.smooth_function(d[ok] @ turn)
    limit = smooth_bound(reference.make("latlong"), d[ok] @ turn, (90, 180), "bilinear")
    assert np.all(np.abs(got[ok] - want).max(-1) <= limit)


def test_yaw_moves_the_panorama_sideways():
    # A quarter turn about +y takes what lies at -z to -x: a quarter of the width to the left.
    image = np.random.default_rng(113).random((16, 32, 3))
    got = plain(image, "latlong", "latlong", size=16, rotation=sm.rotation(90, 0, 0))
    # Places are off by some ε of 32 columns, and noise rises by less than 1 a texel.
    assert np.abs(got - np.roll(image, -8, axis=1)).max() < 1e-10


def test_rotation_object_with_as_matrix():
    scipy_rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    r = scipy_rotation.from_euler("yxz", [30, 40, 50], degrees=True)
    image = np.random.default_rng(114).random((16, 32, 3))
    a = plain(image, "latlong", "cube", size=8, rotation=r)
    b = plain(image, "latlong", "cube", size=8, rotation=r.as_matrix())
    assert np.array_equal(a, b)


@each([c for c in LAYOUTS if c.make().layout not in (None, "faces")])
def test_layouts_hold_the_same_faces(case):
    p = case.make()
    rng = np.random.default_rng(115)
    base = sm.projection(case.name)
    faces = rng.random((*base.shape(7), 2))
    flat = plain(faces, base, p, size=7, filter="nearest", fill=-1.0)
    rows, columns, cells = reference.LAYOUTS[case.name][p.layout]
    want = np.full((rows * 7, columns * 7, 2), -1.0)
    inside = ~outside(base, 7)
    for i, (row, column, turned) in enumerate(cells):
        block = np.where(inside[i][..., None], faces[i], -1.0)
        block = block[::-1, ::-1] if turned else block
        want[row * 7 : row * 7 + 7, column * 7 : column * 7 + 7] = block
    assert np.array_equal(flat, want)
    back = plain(flat, p, base, size=7, filter="nearest", fill=-1.0)
    assert np.array_equal(back[inside], faces[inside])


@pytest.mark.parametrize("antialias", [False, True])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize(
    "turned", ["cube/vertical_cross", "cube_equiangular:ffmpeg-eac", "cube_quadratic:s2"]
)
@each_filter
def test_turned_faces_are_looked_up_as_straight_ones(turned, channels, filter, antialias):
    name, _, layout = turned.partition("/")
    p = sm.projection(name, layout=layout) if layout else sm.projection(name)
    straight = sm.projection(name.partition(":")[0])
    options = {"size": 40, "filter": filter, "antialias": antialias, "world": "literal"}
    for dtype in DTYPES:
        high = 250 if np.issubdtype(dtype, np.integer) else 1
        faces = np.random.default_rng(118).random((6, 48, 48, channels)) * high
        faces = faces.astype(dtype)
        image = plain(faces, straight, p, size=48, filter="nearest", world="literal")
        want = sm.convert(faces, straight, "latlong", **options).astype(float)
        got = sm.convert(image, p, "latlong", **options).astype(float)
        # Places differ by a rounding of f32, 48 texels times 1e-7, and weights of `lanczos3`
        # change by less than 2 a texel, of noise no larger than `high`; an integer, or a half,
        # then rounds to a neighbor.
        off = 1 if high > 1 else 1e-4 + np.finfo(dtype).eps
        # Which of two texels is the nearest, and how many places a mean has, rounding says.
        assert np.mean(np.abs(got - want) > off) <= 2e-3


def test_convention_pairs_flip_as_they_should():
    rng = np.random.default_rng(116)
    image = rng.random((16, 32, 3))
    # mitsuba's center is +z, ours is -z: half a turn apart, but its rows lie on corners, so only
    # compare with a program on the same grid.
    got = plain(image, "latlong:openimageio", "latlong", size=16, world="literal")
    # Places are off by some ε of 32 columns, and noise rises by less than 1 a texel.
    assert np.abs(got - np.roll(image, 16, axis=1)).max() < 1e-10
    # Both have in the middle what lies ahead in their worlds.
    got = plain(image, "latlong:openimageio", "latlong", size=16)
    # As above.
    assert np.abs(got - image).max() < 1e-10
    probe = rng.random((9, 9, 3))
    got = plain(probe, "angular:openimageio", "angular", size=9, filter="nearest")
    assert got.shape == probe.shape
    d = random_directions(200, 117)
    a = sm.sample(probe, d, "angular:openimageio")
    b = sm.sample(probe, d * [1, 1, -1], "angular")
    # The same place but for rounding: some ε of 9 texels.
    assert np.abs(a - b).max() < 1e-12


def test_real_probe_correlates_with_no_flip(data_folder):
    # A light probe unwrapped the right way is brighter at the windows above than at the floor:
    # for Grace Cathedral the brightest texels lie in the upper half.
    oiio = pytest.importorskip("OpenImageIO")
    file = oiio.ImageInput.open(str(data_folder / "grace_probe.hdr"))
    probe = np.asarray(file.read_image("float"))[..., :3]
    file.close()
    pano = plain(probe, "angular", "latlong", size=128)
    light = pano.mean(-1)
    rows = np.sort(light.ravel())[-50]
    assert np.mean(np.argwhere(light >= rows)[:, 0]) < 64
    assert pano.min() >= 0 and pano.max() <= probe.max()
    # Energy: ∫ over the sphere is kept by the unwrapping, within the noise of point sampling.
    w = sm.solid_angle("latlong", 128)
    v = sm.solid_angle("angular", probe.shape[:2])
    a, b = np.sum(np.minimum(light, 5) * w), np.sum(np.minimum(probe.mean(-1), 5) * v)
    # The noise of point sampling: a probe of 10⁶ texels looked up at 32 768 places.
    assert a == pytest.approx(b, rel=0.02)


@pytest.mark.parametrize("filter", ["bilinear", "trilinear", "area", "mode"])
def test_skipna_leaves_out_infinity_as_well(filter):
    image = np.ones((16, 32, 2), np.float32)
    image[4, 5], image[9, 9, 1], image[8, 8] = np.inf, np.nan, -np.inf
    out = sm.convert(image, "latlong", "cube", size=12, filter=filter, skipna=True)
    # Whatever holds nothing finite is NaN; nothing else differs from 1 by more than rounding.
    assert not np.isinf(out).any() and np.isnan(out).mean() < 0.1
    assert np.abs(out[np.isfinite(out)] - 1).max() < 1e-6
    assert np.array_equal(sm.light.mean(image, "latlong", skipna=True), [1, 1])
