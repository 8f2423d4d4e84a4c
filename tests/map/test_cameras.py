"""Calibrated cameras against OpenCV, COLMAP and their papers, and where their lenses end."""

from __future__ import annotations

import math
import pickle
import warnings

import cv2
import numpy as np
import pycolmap
import pytest
import spheremap as sm
from spheremap.cameras import colmap

SIZE = (720, 1280)
K = np.array([[900.0, 0, 655.3], [0, 910.0, 349.2], [0, 0, 1]])
# Of every model: what calibrations give, and what they give with all terms.
BROWN = [
    [-0.28, 0.07, 2e-4, -3e-5],
    [-0.28, 0.07, 2e-4, -3e-5, 0.01],
    [5.1, 2.2, 1e-3, -2e-3, 0.3, 5.2, 3.4, 0.6],
    [0.12, -0.2, 0.01, -0.02, 0.05],
    [0.12, -0.2, 0.01, -0.02, 0.05, 0.1, -0.05, 0.02, 0.02, -0.01, -0.03, 0.02],
    [0.12, -0.2, 0.01, -0.02, 0.05, 0.1, -0.05, 0.02, 0.02, -0.01, -0.03, 0.02, 0.1, -0.2],
    [-0.28, 0.07, 2e-3, -3e-3, 0.01, 0, 0, 0, 0, 0, 0, 0, -0.3, 0.2],
]
FISHEYE = [[0.02, -0.01, 0.003, -0.0005], [-0.04, 0.004, -0.001, 0.0002]]
PRISM_FISHEYE = [0.02, -0.01, 2e-3, -3e-3, 0.003, -0.0005, 5e-3, -2e-3]
ARIA = [0.02, -0.01, 0.003, -5e-4, 1e-4, -1e-5, 2e-3, -3e-3, 5e-3, -2e-3, 1e-3, -1e-3]
CAMERAS = [
    ("pinhole", []),
    *(("brown_conrady", d) for d in BROWN),
    *(("kannala_brandt", d) for d in FISHEYE),
    ("unified", [0.9]),
    ("unified", [1.4, -0.15, 0.03, 1e-3, -5e-4]),
    ("double_sphere", [-0.2, 0.6]),
    ("eucm", [0.6, 1.1]),
    ("eucm", [0.5, -0.8]),
    ("fov", [0.9]),
    ("thin_prism_fisheye", PRISM_FISHEYE),
    ("rad_tan_thin_prism_fisheye", ARIA),
]
each_camera = pytest.mark.parametrize(("model", "distortion"), CAMERAS)
# A few hundred roundings of numbers up to 1280: ε of it is 3e-13.
PIXEL = 1e-9


def pixels(n: int = 20_000, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Places all over an image, its corners among them, as OpenCV counts."""
    h, w = size
    xy = np.random.default_rng(400).uniform([-0.5, -0.5], [w - 0.5, h - 0.5], (n, 2))
    corners = [[-0.5, -0.5], [w - 0.5, -0.5], [-0.5, h - 0.5], [w - 0.5, h - 0.5]]
    return np.concatenate([xy, corners])


def to_pixels(d, camera, size=SIZE):
    return sm.directions_to_pixels(d, camera, size, centers="integer")


def to_directions(xy, camera, size=SIZE):
    return sm.pixels_to_directions(xy, camera, size, centers="integer")


@each_camera
def test_every_pixel_comes_back(model, distortion):
    camera = sm.camera(K, SIZE, distortion=distortion, model=model)
    xy = pixels()
    d = to_directions(xy, camera)
    assert np.isfinite(d).all()
    # Directions are unit to a few roundings.
    assert np.abs(np.linalg.norm(d, axis=-1) - 1).max() < 1e-14
    assert np.abs(to_pixels(d, camera) - xy).max() < PIXEL


@pytest.mark.parametrize("distortion", [[], *BROWN])
def test_brown_conrady_is_opencvs(distortion):
    model = "brown_conrady" if distortion else "pinhole"
    camera = sm.camera(K, SIZE, distortion=distortion, model=model)
    xy = pixels()
    d = to_directions(xy, camera)
    there, _ = cv2.projectPoints(d, np.zeros(3), np.zeros(3), K, np.array(distortion))
    assert np.abs(there[:, 0] - xy).max() < PIXEL
    assert np.abs(to_pixels(d * 7, camera) - there[:, 0]).max() < PIXEL
    # Its inverse is an iteration that is told when to stop.
    until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 400, 1e-14)
    near = np.hypot(*(d[:, :2] / d[:, 2:]).T) < 0.3
    given = np.array(distortion)
    plane = cv2.undistortPoints(xy[near, None], K, given, None, None, None, until)
    # It stops when a step is that small, a few of which are left.
    assert np.abs(d[near, :2] / d[near, 2:] - plane[:, 0]).max() < 1e-11


@pytest.mark.parametrize("distortion", FISHEYE)
def test_kannala_brandt_is_opencvs_fisheye(distortion):
    camera = sm.camera(K, SIZE, distortion=distortion, model="kannala_brandt")
    xy = pixels()
    d = to_directions(xy, camera)
    there, _ = cv2.fisheye.projectPoints(
        d[:, None], np.zeros(3), np.zeros(3), K, np.array(distortion)
    )
    assert np.abs(there[:, 0] - xy).max() < PIXEL


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("SIMPLE_PINHOLE", [700, 640, 360]),
        ("PINHOLE", [700, 710, 641, 352]),
        ("SIMPLE_RADIAL", [700, 640, 360, -0.1]),
        ("RADIAL", [700, 640, 360, -0.1, 0.03]),
        ("OPENCV", [700, 710, 641, 352, -0.1, 0.03, 1e-3, -2e-3]),
        ("FULL_OPENCV", [700, 710, 641, 352, -0.1, 0.03, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.002]),
        ("OPENCV_FISHEYE", [400, 410, 641, 352, 0.02, -0.01, 0.003, -0.0005]),
        ("SIMPLE_RADIAL_FISHEYE", [400, 640, 360, 0.02]),
        ("RADIAL_FISHEYE", [400, 640, 360, 0.02, -0.003]),
        ("FOV", [700, 710, 641, 352, 0.9]),
        ("THIN_PRISM_FISHEYE", [400, 410, 641, 352, *PRISM_FISHEYE]),
        ("RAD_TAN_THIN_PRISM_FISHEYE", [400, 410, 641, 352, *ARIA]),
        ("SIMPLE_FISHEYE", [400, 640, 360]),
        ("FISHEYE", [400, 410, 641, 352]),
        ("EUCM", [700, 710, 641, 352, 0.6, 1.1]),
        ("SIMPLE_DIVISION", [700, 640, 360, -0.2]),
        ("DIVISION", [700, 710, 641, 352, -0.2]),
        ("DIVISION", [700, 710, 641, 352, 0]),
        ("SIMPLE_DIVISION", [700, 640, 360, 0.3]),
        ("DIVISION", [700, 710, 641, 352, 0.6]),
    ],
)
def test_models_are_colmaps(name, numbers):
    camera = colmap.from_model(name, SIZE, [float(x) for x in numbers])
    theirs = pycolmap.Camera(model=name, width=SIZE[1], height=SIZE[0], params=numbers)
    # COLMAP counts the center of the first pixel (½, ½), as we do where nothing is said.
    xy = pixels(4000) + 0.5
    d = sm.pixels_to_directions(xy, camera, SIZE)
    ahead = d[:, 2] > 0.05
    assert ahead.mean() > 0.8
    there = np.asarray(theirs.img_from_cam(d[ahead]))
    assert np.abs(there - xy[ahead]).max() < PIXEL


def test_a_panorama_is_a_camera_of_colmaps():
    size = (640, 1280)
    camera = colmap.from_model("EQUIRECTANGULAR", size, [1280.0, 640.0])
    assert camera == sm.projection("latlong:colmap")
    theirs = pycolmap.Camera(model="EQUIRECTANGULAR", width=1280, height=640, params=[1280, 640])
    d = np.random.default_rng(404).normal(size=(20_000, 3))
    there = np.asarray(theirs.img_from_cam(d))
    assert np.abs(sm.directions_to_pixels(d, camera, size) - there).max() < PIXEL
    for numbers in ([1280.0, 639.0], []):
        with pytest.raises(ValueError, match="whole panorama"):
            colmap.from_model("EQUIRECTANGULAR", size, numbers)


def test_omnidirectional_is_opencvs_name_of_unified():
    xi, d = 1.4, [-0.15, 0.03, 1e-3, -5e-4]
    camera = sm.camera(K, SIZE, distortion=[xi, *d], model="omnidirectional")
    assert camera == sm.camera(K, SIZE, distortion=[xi, *d], model="unified")


@pytest.mark.parametrize("omega", [0.01, 0.9, 2.0, 3.0])
def test_fov_sees_behind_itself_as_the_formula_does(omega):
    camera = sm.camera((100, 100, 399.5, 399.5), (800, 800), distortion=[omega], model="fov")
    d = np.random.default_rng(405).normal(size=(20_000, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    h = np.hypot(d[:, 0], d[:, 1])
    r = np.arctan2(2 * math.tan(omega / 2) * h, d[:, 2]) / omega
    want = 399.5 + 100 * r[:, None] * d[:, :2] / h[:, None]
    xy = to_pixels(d, camera, (800, 800))
    seen = ~np.isnan(xy[:, 0])
    assert seen.mean() > 0.3
    assert np.abs(xy[seen] - want[seen]).max() < PIXEL


def test_unified_as_the_paper_prints_it():
    xi, k1, k2, p1, p2 = 1.4, -0.15, 0.03, 1e-3, -5e-4
    camera = sm.camera(K, SIZE, distortion=[xi, k1, k2, p1, p2], model="unified")
    xy = pixels()
    d = to_directions(xy, camera)
    # Equations 1 to 4, and OpenCV's order of p1 and p2.
    x, y = (d[:, :2] / (d[:, 2:] + xi)).T
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2
    a = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    b = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    want = np.stack([900 * a + 655.3, 910 * b + 349.2], -1)
    assert np.abs(want - xy).max() < PIXEL


def test_special_cameras_are_other_cameras():
    d = to_directions(pixels(), sm.camera(K, SIZE))

    def same(a, b):
        # Formulas in other letters of u at most 1: a few ε each.
        assert np.nanmax(np.abs(a.encode(d) - b.encode(d))) < 1e-13

    def make(model, *distortion):
        return sm.camera(K, SIZE, distortion=distortion, model=model)

    same(make("pinhole"), make("brown_conrady", 0, 0, 0, 0))
    same(make("pinhole"), make("unified", 0))
    # α/(1 - α) = ξ, and (1 - α) of the focal length.
    small = K * [[0.5, 1, 1], [1, 0.5, 1], [1, 1, 1]]
    same(
        sm.camera(K, SIZE, distortion=[0.5, 1], model="eucm"),
        sm.camera(K * [[2, 1, 1], [1, 2, 1], [1, 1, 1]], SIZE, distortion=[1], model="unified"),
    )
    same(
        sm.camera(small, SIZE, distortion=[0.0, 0.5], model="double_sphere"),
        sm.camera(small, SIZE, distortion=[0.5, 1], model="eucm"),
    )


def test_a_pinhole_is_perspective():
    focal = 640 / math.tan(math.radians(30))
    camera = sm.camera((focal, focal, 639.5, 359.5), SIZE)
    view = sm.projection("perspective", fov=60, aspect=1280 / 720, axes="+x +y +z")
    d = to_directions(pixels(), camera)
    # Each rounds a quotient and a product of numbers at most 1.
    assert np.abs(camera.encode(d) - view.encode(d)).max() < 1e-14
    assert camera.covered_solid_angle == pytest.approx(view.covered_solid_angle, rel=1e-14)


# A lens of each kind that ends inside its image, with its center in the middle and outside.
FOLDING = [
    ("brown_conrady", [-0.3, 0, 0, 0], (0.5, 0.5, 0.0, 0.0)),
    ("brown_conrady", [-0.3, 0.02, 0.01, -0.02], (0.5, 0.6, 0.3, -0.2)),
    ("kannala_brandt", [-0.1, 0, 0, 0], (0.3, 0.3, 0.0, 0.0)),
    ("kannala_brandt", [0, 0, 0, 0], (0.12, 0.1, 0.1, 0.0)),
    ("unified", [2.0], (0.5, 0.4, 0.0, 0.1)),
    ("unified", [1.5, -0.1, 0.02, 1e-3, -1e-3], (0.5, 0.5, 0.0, 0.0)),
    ("double_sphere", [-0.2, 0.6], (0.25, 0.3, 0.0, 0.1)),
    ("eucm", [0.6, 1.1], (0.2, 0.3, 0.45, 0.0)),
    ("fov", [1.5], (0.2, 0.25, 0.1, 0.0)),
    ("brown_conrady", [-0.3, 0, 0, 0, 0, 0, 0, 0, 0.02, 0, -0.01, 0.01], (0.5, 0.6, 0.1, 0.0)),
    ("thin_prism_fisheye", [-0.1, 0, 2e-3, 1e-3, 0, 0, 5e-3, -2e-3], (0.3, 0.3, 0.0, 0.0)),
    ("thin_prism_fisheye", [0, 0, 2e-3, 1e-3, 0, 0, 5e-3, -2e-3], (0.12, 0.1, 0.1, 0.0)),
    ("brown_conrady", [-0.3, *[0] * 11, 0.3, -0.4], (0.5, 0.6, 0.1, 0.0)),
    ("brown_conrady", [*[0] * 12, 0.9, 0.9], (0.2, 0.2, 0.0, 0.1)),
    ("eucm", [0.5, -4.0], (0.4, 0.4, 0.1, 0.0)),
    (
        "rad_tan_thin_prism_fisheye",
        [-0.1, 0, 0, 0, 0, 0, 2e-3, 1e-3, 5e-3, 0, -2e-3, 0],
        (0.3, 0.3, 0.0, 0.1),
    ),
]
each_fold = pytest.mark.parametrize(("model", "distortion", "sensor"), FOLDING)


def folding(model, distortion, sensor):
    fx, fy, cx, cy = sensor
    k = (fx * 400, fy * 300, (cx + 0.5) * 400 - 0.5, (cy + 0.5) * 300 - 0.5)
    return sm.camera(k, (300, 400), distortion=distortion, model=model)


@each_fold
def test_what_a_lens_does_not_hold_is_nan(model, distortion, sensor):
    camera = folding(model, distortion, sensor)
    uv = np.random.default_rng(401).random((40_000, 2))
    valid = camera.valid(uv)
    assert 0.05 < valid.mean() < 0.99
    d = camera.decode(uv)
    assert np.array_equal(np.isnan(d).any(-1), ~valid)
    assert np.array_equal(np.isnan(camera.density(uv)), ~valid)
    single = uv.astype(np.float32)
    assert np.array_equal(np.isnan(camera.decode(single)).any(-1), ~camera.valid(single))
    assert np.array_equal(np.isnan(camera.jacobian(uv)).all((-2, -1)), ~valid)
    back = camera.encode(d[valid])
    # A pixel is 1/400 of u: 1e-9 of it is 2.5e-12.
    assert np.abs(back - uv[valid]).max() < 2.5e-12


@each_fold
def test_a_direction_has_one_place(model, distortion, sensor):
    camera = folding(model, distortion, sensor)
    d = np.random.default_rng(402).normal(size=(40_000, 3))
    uv = camera.encode(d)
    seen = ~np.isnan(uv[:, 0])
    assert np.array_equal(seen, camera.covers(d))
    single = d.astype(np.float32)
    assert np.array_equal(np.isfinite(camera.encode(single)[:, 0]), camera.covers(single))
    back = camera.decode(uv[seen])
    unit = d[seen] / np.linalg.norm(d[seen], axis=-1, keepdims=True)
    # Where the slope is a hundredth, ε of the place is a hundred of the angle; 256 ε are let out.
    assert np.linalg.norm(back - unit, axis=-1).max() < 1e-9
    share = camera.covered_solid_angle / (4 * math.pi)
    # Five standard deviations of 40,000.
    assert seen.mean() == pytest.approx(
        share, abs=5 * math.sqrt(share * (1 - share) / 40_000) + 1e-9
    )


@each_fold
@pytest.mark.parametrize("n", [1, 3, 16, 40])
def test_texels_sum_to_what_the_lens_sees(model, distortion, sensor, n):
    camera = folding(model, distortion, sensor)
    w = camera.solid_angle((n, n + 1), any_aspect=True)
    assert w.min() >= -1e-15
    # Gauss's rules across texels in which the density doubles, and the rim found by bisection.
    assert w.sum() == pytest.approx(camera.covered_solid_angle, rel=2e-6)


@each_fold
def test_pictures_end_where_the_lens_does(model, distortion, sensor):
    camera = folding(model, distortion, sensor)
    picture = sm.convert(np.ones((64, 128)), "latlong", camera, size=(30, 40), fill=np.nan)
    assert np.array_equal(np.isnan(picture), np.isnan(camera.directions((30, 40))[..., 0]))
    # A constant stays one: weights sum to it but for rounding.
    assert np.nanmax(np.abs(picture - 1)) < 1e-12
    area = sm.convert(np.ones((30, 40)), camera, "latlong", size=32, filter="area", fill=np.nan)
    # Likewise.
    assert np.nanmax(np.abs(area - 1)) < 1e-12 and np.isfinite(area).any()


@each_camera
def test_every_verb_takes_a_camera(model, distortion):
    camera = sm.camera(K, SIZE, distortion=distortion, model=model)
    assert pickle.loads(pickle.dumps(camera)) == camera
    assert hash(pickle.loads(pickle.dumps(camera))) == hash(camera)
    assert eval(f"sm.{repr(camera).replace('Projection', 'projection')}") == camera
    assert camera.shape(36) == (36, 64) and camera.shape(SIZE) == SIZE
    image = np.random.default_rng(403).random((36, 64, 3)).astype(np.float32)
    panorama = sm.convert(image, camera, "latlong", size=64)
    assert np.isfinite(panorama).all() and panorama.any()
    w = camera.solid_angle((36, 64))
    # The registry's tests hold sums to 1e-10; across square texels.
    assert w.sum() == pytest.approx(camera.covered_solid_angle, rel=1e-9)
    assert camera.sample(image, camera.directions((36, 64))).shape == (36, 64, 3)
    padded = sm.pad(image, camera, 2)
    assert padded.shape == (40, 68, 3) and np.isfinite(padded).all()
    plan = sm.remap_plan("latlong", camera, size=(36, 64))
    view = sm.convert(np.ones((32, 64), np.float32), "latlong", camera, size=(36, 64))
    assert np.array_equal(plan(np.ones((32, 64), np.float32)), view)
    uv = np.random.default_rng(404).random((200, 2))
    single = camera.decode(uv.astype(np.float32))
    assert single.dtype == np.float32
    # f32 is computed in f64 and rounded once, after uv was rounded.
    assert np.abs(single - camera.decode(uv)).max() < 1e-6


def test_a_camera_looks_ahead_in_every_world():
    camera = sm.camera(K, SIZE)
    for panorama in ("latlong", "latlong:blender", "latlong:unity"):
        shape = (64, 128)
        ramp = np.broadcast_to(np.arange(128.0), shape)
        picture = sm.convert(ramp, panorama, camera, size=(36, 64))
        # Ahead is the middle of these panoramas or a quarter off; to the right u grows.
        assert (np.diff(picture[18]) > 0).all()


def test_a_skew_that_is_rounding_is_none():
    exact = sm.camera([[300, 0, 319.5], [0, 300, 239.5], [0, 0, 1]], (480, 640))
    for skew in (1e-14, -1e-14, 2e-7):
        assert sm.camera([[300, skew, 319.5], [0, 300, 239.5], [0, 0, 1]], (480, 640)) == exact
    # A ten-millionth of the focal length is one that somebody wrote, and NaN is none.
    for skew in (3e-5, np.nan):
        with pytest.raises(ValueError, match="`K`"):
            sm.camera([[300, skew, 319.5], [0, 300, 239.5], [0, 0, 1]], (480, 640))


@pytest.mark.parametrize(
    ("arguments", "options", "text"),
    [
        (([1, 2, 3], SIZE), {}, r"shape \(3, 3\) or \(4,\)"),
        ((np.array([[1, 1, 0], [0, 1, 0], [0, 0, 1]]), SIZE), {}, "no skew"),
        ((K, SIZE), {"distortion": [1]}, "to have 0 numbers"),
        ((K, SIZE), {"distortion": [1], "model": "brown_conrady"}, "5 or 8 or 12 or 14 numbers"),
        ((K, SIZE), {"model": "unified"}, "1 or 5 numbers"),
        ((K, SIZE), {"model": "spherical"}, "`model` to be one of"),
        ((K, SIZE), {"model": "fisheye"}, "got 'fisheye'; here it is 'kannala_brandt'"),
        ((K, SIZE), {"distortion": [-0.1, 0, 0, 0]}, "are of `model` 'brown_conrady'"),
        (
            (K, SIZE),
            {"distortion": [0.0] * 12 + [0.1, -1.6], "model": "brown_conrady"},
            r"`tau_y` must be in \(-1, 1\]",
        ),
        ((K, (0, 5)), {}, "positive"),
        ((-K, SIZE), {}, "0, 0, 1"),
        (((-1, 1, 1, 1), SIZE), {}, "`fx`"),
        (
            ((400000, 400000, 2000, 2000), (4000, 4000)),
            {},
            r"`fx` of `K` to be at most 80000 pixels, 20 times .* 4000, .* 2.86°, got 400000;",
        ),
        (((900, 1e5, 5, 5), SIZE), {"model": "kannala_brandt"}, "`fy` .* 14400 .* got 100000"),
        (((900, 900, 5000, 5), SIZE), {}, "`cx` .* 2560 pixels, .* at 639.5, got 5000"),
        (((900, 900, 5, np.nan), SIZE), {}, "`cy` of `K`"),
        (((90, 90, 50, 5), (10, 1000)), {}, "at most 20 times as wide as high"),
    ],
)
def test_what_is_wrong_is_told(arguments, options, text):
    with pytest.raises(ValueError, match=text):
        sm.camera(*arguments, **options)
    with pytest.raises(TypeError, match="height and a width"):
        sm.camera(K, 720)


def test_coefficients_of_a_prism_that_is_none():
    """OpenCV's calibrateCamera gives 14 numbers with CALIB_RATIONAL_MODEL, six of them 0."""
    for count in (12, 14):
        long = sm.camera(K, SIZE, distortion=BROWN[2] + [0.0] * (count - 8), model="brown_conrady")
        assert long == sm.camera(K, SIZE, distortion=BROWN[2], model="brown_conrady")


def test_a_size_of_width_and_height_is_warned_of():
    with pytest.warns(UserWarning, match=r"did you mean \(720, 1280\)"):
        sm.camera(K, (1280, 720))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sm.camera(K, SIZE)
        # Of a square nothing can be told, nor where the principal point is far off either way.
        sm.camera((500, 500, 255.5, 255.5), (512, 512))
        sm.camera((500, 500, 100, 30), (480, 640))


@pytest.mark.parametrize(
    ("name", "parameters", "error"),
    [
        ("perspective", {"fx": 500}, ValueError),
        ("perspective", {"K": K}, TypeError),
        ("camera_pinhole", {"fx": 500}, ValueError),
        ("kannala_brandt", {"fx": 500, "k1": 0.1}, ValueError),
    ],
)
def test_who_has_pixels_is_told_of_camera(name, parameters, error):
    with pytest.raises(error, match=r"[^.]; `sm.camera\(K, size\)` makes the projection"):
        sm.projection(name, **parameters)
    with pytest.raises(ValueError, match="did you mean 'fov'") as other:
        sm.projection("perspective", fovv=3)
    assert "sm.camera" not in str(other.value)
