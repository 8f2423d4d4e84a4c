"""What callers say of a ball: worlds, numbers for each photo, and what no photo can show."""

from __future__ import annotations

import math

import numpy as np
import pytest
import spheremap as sm

D = sm.directions("latlong", 64)
SCENE = (1.2 + np.sin(6 * D) * np.cos(5 * D[..., ::-1])).astype(np.float32)
POSE = sm.rotation(100, 7, -12)
POSES = [np.eye(3), POSE]
CAMERA = {"size": 128, "fov": 30, "distance": 5}
A, B = (sm.ball.render(SCENE, pose=pose, **CAMERA) for pose in POSES)
# The ball of `CAMERA` in the middle: 64 / tan 15° · tan asin(1/5).
BALL = sm.ball.Ball((64, 64), (48.755, 48.755), 0, 1)
KNOWN = {"center": (64, 64), "radius": 48.755, "fov": 30, "size": 16}
PAIR = {"balls": [BALL] * 2, "size": 16}


def degrees_off(a, b):
    return np.degrees(np.arccos(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1)))


@pytest.mark.parametrize("program", ["blender", "unreal", "pbrt"])
def test_worlds_are_matched(program):
    """What is up and ahead in the camera's frame is so in the program's panorama."""
    name = f"latlong:{program}"
    want = sm.ball.unwrap(A, **KNOWN)
    found = sm.ball.unwrap(A, dst=name, **KNOWN)
    assert found.projection == sm.projection(name)
    assert np.array_equal(found.blind_direction, want.blind_direction)
    back = sm.convert(found.image, name, "latlong", size=16)
    # Worlds turn by quarters, so texels are the same; those beside a seam, which is elsewhere, have
    # one neighbor that says how many lookups are averaged.
    np.testing.assert_allclose(back[want.seen], want.image[want.seen], atol=0.01)
    there = sm.convert(SCENE, "latlong", name)
    # Lookups in the same texels of float32.
    np.testing.assert_allclose(sm.ball.render(there, name, **CAMERA), A, atol=1e-4)
    joined = {"fov": 30, "poses": POSES, **PAIR}
    merged = sm.ball.merge([A, B], dst=name, **joined)
    assert np.array_equal(merged.poses, POSES)
    back = sm.convert(merged.image, name, "latlong", size=16)
    # The same neighbors.
    np.testing.assert_allclose(back, sm.ball.merge([A, B], **joined).image, atol=0.01)


def test_none_is_not_given_for_this_photo():
    with pytest.raises(ValueError, match="photo 2 has neither `fov` nor `distance`, which photo 1"):
        sm.ball.merge([A, B], fov=[30, None], poses=POSES, **PAIR)
    mixed = sm.ball.merge([A, B], fov=[30, None], distance=[None, 5], poses=POSES, **PAIR)
    # The outline is given to four digits.
    np.testing.assert_allclose(mixed.distances, 5, rtol=1e-4)
    with pytest.warns(UserWarning, match="infinitely far away"):
        sm.ball.merge([A], balls=[BALL], fov=[None], size=8)


@pytest.mark.slow
def test_none_for_all_is_as_none():
    alone = sm.ball.merge([A, B], **PAIR)
    assert sm.ball.merge([A, B], fov=[None] * 2, distance=[None] * 2, **PAIR).fov == alone.fov
    assert alone.doubt > 0


@pytest.mark.parametrize("given", [0, 1])
def test_a_pose_that_is_none_is_found(given):
    poses = [pose if k == given else None for k, pose in enumerate(POSES)]
    found = sm.ball.merge([A, B], fov=30, poses=poses, **PAIR)
    assert np.array_equal(found.poses[given], POSES[given])
    # Half a pixel of a radius of 49, through the mirror: photos of 128 pixels.
    assert degrees_off(found.poses[1 - given], POSES[1 - given]) < 0.3
    assert math.isnan(found.correlations[1]) == (given == 1)
    np.testing.assert_array_equal(found.exposures[0], 1)


def test_white_balance_does_not_turn_a_photo():
    gains = np.array([2, 1, 0.5], np.float32)
    plain = sm.ball.merge([A, B], fov=30, **PAIR)
    found = sm.ball.merge([A, B * gains], fov=30, **PAIR)
    # What it was without: hundredths of a degree.
    assert degrees_off(found.poses[1], plain.poses[1]) < 0.05
    assert degrees_off(found.poses[1], POSE) < 0.15
    # The median of ratios of photos of 128 pixels.
    np.testing.assert_allclose(found.exposures[1] * gains, 1, rtol=0.01)


def test_scalars_of_numpy_are_numbers():
    want = sm.ball.merge([A, B], fov=30, poses=POSES, **PAIR).image
    for fov in (np.float32(30), np.int64(30), np.array(30.0), [30, np.float32(30)]):
        assert np.array_equal(sm.ball.merge([A, B], fov=fov, poses=POSES, **PAIR).image, want)


def test_float64_of_one_photo_is_kept():
    for photos in ([A, B.astype(np.float64)], [A.astype(np.float64), B]):
        assert sm.ball.merge(photos, fov=30, poses=POSES, **PAIR).image.dtype == np.float64


def test_the_rim_that_was_used_is_returned():
    """Off the axis it is an ellipse of the same area."""
    size, center = (120, 180), (150, 40)
    photo = sm.ball.render(SCENE, size=size, center=center, fov=60, distance=5)
    found = sm.ball.unwrap(photo, center=center, radius=30, fov=60, size=8).ball
    # `radius` is of the circle with its area, which bisection finds to its last bits.
    assert found.radius == pytest.approx(30, rel=1e-9)
    assert found.radii[0] > found.radii[1] * 1.03
    assert found.angle == pytest.approx(math.degrees(math.atan2(40 - 60, 150 - 90)))
    given = sm.ball.Ball(center, (30, 30), 0, 1)
    assert sm.ball.merge([photo], balls=[given], fov=60, size=8).balls == (found,)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"distance": math.inf}, "`fov` 30 and `distance` inf do not go together"),
        ({"distance": math.inf, "radius": None}, "`fov` 30 and `distance` inf do not go together"),
        ({"distance": 1e9}, "do not go together"),
        ({"distance": -math.inf, "fov": None}, "`distance` must be at least"),
        ({"radius": 1e20}, "`radius` must be from"),
        ({"radius": 1e13}, "`radius` must be from"),
        ({"radius": 1e-300}, "`radius` must be from"),
        ({"radius": (1e-300, 1e300)}, "`radius` must be from"),
        ({"radius": 1e6}, "`fov` 30 and a `radius` of 1e.06 pixels do not go together"),
        ({"center": (-400, 64)}, r"center at \(-400, 64\) and a radius of 48.755 .*outside"),
        ({"mask": np.zeros((128, 128))}, "`mask` is 0 on all of the ball"),
        ({"filter": "ewa"}, "to be one of nearest, bilinear, catmull-rom, bicubic, mitchell"),
    ],
)
def test_what_cannot_be(options, words):
    with pytest.raises(ValueError, match=words):
        sm.ball.unwrap(A, **(KNOWN | options))


def test_a_mask_that_leaves_only_what_is_beside_the_ball():
    y, x = np.mgrid[:128, :128] - 63.5
    with pytest.raises(ValueError, match="`mask` is 0 on all of the ball"):
        sm.ball.unwrap(A, mask=np.hypot(x, y) > 49, **KNOWN)
    # A few pixels are enough.
    mask = np.hypot(x, y) > 49
    mask[68:72, 60:64] = True
    assert sm.ball.unwrap(A, mask=mask, **(KNOWN | {"size": 128})).coverage > 0


def test_a_photo_of_nothing():
    with pytest.raises(ValueError, match="pixels of the ball that are not NaN"):
        sm.ball.unwrap(A * np.nan, **KNOWN)
    with pytest.raises(ValueError, match=r"photo 2: .*pixels of the ball that are not NaN"):
        sm.ball.merge([A, A * np.nan], fov=30, poses=POSES, **PAIR)
    with pytest.raises(ValueError, match="`fov` 30 and `distance` inf do not go together"):
        sm.ball.render(SCENE, size=16, fov=30, distance=math.inf)


@pytest.mark.parametrize("name", ["fov", "radius", "distance"])
def test_a_bool_is_no_number(name):
    options = KNOWN | {"fov": None} | {name: True}
    with pytest.raises(TypeError, match=f"`{name}` to be .*number.*, got bool"):
        sm.ball.unwrap(A, **options)


@pytest.mark.parametrize(
    ("options", "kind", "words"),
    [
        ({"fill": "x"}, TypeError, "`fill`"),
        ({"fill": [1, 2]}, ValueError, "`fill` to have one number for each of 3 channels"),
        ({"distance": "x", "fov": None}, TypeError, "`distance` to be a number, got str"),
        ({"poses": 5}, TypeError, "`poses` to be a sequence"),
        ({"poses": "ab"}, TypeError, "`poses` to be a sequence of entries, got str"),
        ({"poses": [np.eye(3), "a"]}, TypeError, "`poses` of photo 2"),
        ({"poses": [np.eye(3), 2 * np.eye(3)]}, ValueError, "`poses` of photo 2"),
        ({"photographer": 89}, ValueError, "`photographer`"),
        ({"photographer": True}, TypeError, "`photographer` to be a number"),
        ({"filter": None}, TypeError, "`filter` to be a str"),
    ],
)
def test_errors_of_merge(options, kind, words):
    with pytest.raises(kind, match=words):
        sm.ball.merge([A, B], **({"fov": 30, "poses": POSES} | PAIR | options))


def test_errors_of_balls_and_masks():
    for wrong, kind in (("a", TypeError), (math.nan, ValueError), (math.inf, ValueError)):
        with pytest.raises(kind, match="`angle`"):
            sm.ball.Ball((8, 8), (4, 4), wrong, 1)
    for wrong, kind in (("a", TypeError), (math.nan, ValueError), (2, ValueError)):
        with pytest.raises(kind, match="`confidence`"):
            sm.ball.Ball((8, 8), (4, 4), 0, wrong)
    for wrong, kind in ((1.5, TypeError), ("a", TypeError), (0, ValueError)):
        with pytest.raises(kind, match="`count`"):
            BALL.points(wrong)
    with pytest.raises(ValueError, match="`mask` to have numbers from 0 to 1"):
        sm.ball.find(A, mask=np.full((128, 128), 7))
    merged = sm.ball.merge([A], balls=[BALL], fov=30, size=8)
    for wrong in (-1, 1):
        with pytest.raises(IndexError, match="there is no photo"):
            merged.angle(wrong)
