"""Mirror balls: geometry, finding, unwrapping, merging, and their errors."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions, some_fast
from spheremap import io
from spheremap.align.rotation_search import _grid
from spheremap.ball.camera import Outline, view

SCENE = 1.2 + np.sin(6 * sm.directions("latlong", 64)) * np.cos(5 * sm.directions("latlong", 64))
VIEWS = {
    "ideal": view((480, 640), Outline((300, 250), 100, 100)),
    "fov": view((480, 640), Outline((500, 300), 100, 100), fov=40),
    "distance": view((480, 640), Outline((500, 300), 100, 100), distance=3),
    "both": view((480, 640), None, center=(650, 120), fov=90, distance=1.4),
}


@pytest.mark.parametrize("name", VIEWS)
def test_there_and_back(name):
    v, d = VIEWS[name], random_directions(20_000, 1)
    xy = v.pixels(d)
    seen = np.isfinite(xy[:, 0])
    # Exactly the blind cone is missing.
    np.testing.assert_array_equal(seen, d @ v.toward >= -np.cos(v.blind))
    back, cosine = v.reflections(xy[seen])
    # A rounding unit of a pixel turns the reflection by 1/cosine of it at the rim.
    assert np.max(np.linalg.norm(back - d[seen], axis=-1) * cosine) < 1e-13
    np.testing.assert_allclose(v.incidence(d[seen]) * cosine, cosine**2, atol=1e-12)


@pytest.mark.parametrize("name", [n for n in VIEWS if n != "ideal"])
def test_reflection_by_the_law(name):
    """The hit of a ray on the sphere, by the quadratic, and the reflection about its normal."""
    v = VIEWS[name]
    xy = v.outline.points(100, inset=0.3 * v.outline.mean)
    ray = v.rays(xy)
    center = -v.distance * v.toward
    b = ray @ center
    t = b - np.sqrt(b * b - (center @ center - 1))
    normal = t[:, None] * ray - center
    want = sm.reflect(-ray, normal)
    # b² - (|c|² - 1) cancels a squared distance of 84: some hundred ε.
    np.testing.assert_allclose(v.reflections(xy)[0], want, atol=1e-12)
    # The outline is where rays touch.
    touch = v.rays(v.outline.points(50)) @ center
    # A dot product and a root, of a distance that bisection finds to its last bits.
    np.testing.assert_allclose(touch, np.sqrt(v.distance**2 - 1), rtol=1e-12)


@pytest.mark.parametrize("name", VIEWS)
def test_pixels_per_radian(name):
    v, h = VIEWS[name], 1e-6
    d = random_directions(500, 2)
    d = d[d @ v.toward > -0.7]
    x = np.cross(d, [0.3, 0.5, 0.8])
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    columns = []
    for t in (x, np.cross(d, x)):
        ahead, behind = (v.pixels((d + s * t) / np.sqrt(1 + h * h)) for s in (h, -h))
        columns.append((ahead - behind) / (2 * h))
    want = np.linalg.svd(np.stack(columns, axis=-1), compute_uv=False)
    least, most = v.pixels_per_radian(d)
    # Pixels up to 650 round by 1e-13, and differences over 2h by 1e-7 pixels per radian.
    np.testing.assert_allclose(most, want[:, 0], rtol=1e-6)
    np.testing.assert_allclose(least, want[:, 1], rtol=1e-6)


def test_ideal_is_the_sphere_map():
    d = random_directions(5000, 3)
    v = view((100, 100), Outline((50, 50), 50, 50))
    # The same sine and root, in pixels up to 100: some ε of the image.
    np.testing.assert_allclose(v.pixels(d) / 100, sm.encode(d, "sphere"), atol=1e-14)
    for distance in (1e7, 1e9):
        far = view((100, 100), Outline((50, 50), 50, 50), distance=distance)
        near = d @ far.toward > -0.99
        # Of 50 pixels 1e-7 / 2 at 1e7 radii; rtol is 1e-7 as well.
        np.testing.assert_allclose(
            far.pixels(d[near]) / 100, sm.encode(d[near], "sphere"), atol=1e-8
        )


def test_far_cameras_are_where_they_are():
    rim = Outline((50, 50), 50, 50)
    for distance in (1e3, 1e7, 9e7):
        # An angle of 1e-8 is the difference of two that are off by 1e-16 each.
        assert view((100, 100), rim, distance=distance).distance == pytest.approx(
            distance, rel=1e-6
        )
    # Not 1e7, silently.
    assert view((100, 100), rim, distance=1e9).ideal


@pytest.mark.parametrize("distance", [1.001, 1.02, 1.5, 2.0, 2.2, 2.5, 3.0, 5.0, 100.0])
def test_newton_converges(distance):
    v = view((100, 100), Outline((50, 50), 50, 50), distance=distance)
    psi = np.linspace(0, np.pi - v.blind, 5001)
    phi = v._reflecting(psi)
    back = 2 * phi + np.arctan2(np.sin(phi), distance - np.cos(phi))
    # At the closest φ is 1e-3 ψ: a rounding unit of it counts as a thousand of ψ.
    np.testing.assert_allclose(back, psi, atol=1e-13)


def test_two_of_three():
    known = VIEWS["both"]
    size, rim = known.outline.center, known.outline
    for given in ({"fov": known.fov}, {"distance": known.distance}):
        found = view((480, 640), Outline(size, rim.along, rim.across), **given)
        # Bisection finds the focal length's logarithm to its last bits.
        assert found.distance == pytest.approx(known.distance, rel=1e-9)
        assert found.fov == pytest.approx(known.fov, rel=1e-9)
    with pytest.raises(ValueError, match="do not go together"):
        view((480, 640), rim, fov=40, distance=1.4)


def test_solid_angles_add_up():
    photo = np.ones((160, 160))
    found = sm.ball.unwrap(photo, center=(80, 80), radius=60, distance=4, size=64)
    area = sm.solid_angle("latlong", 64)
    # Texels times pixels per steradian count the pixels of the ball.
    pixels = (area / found.solid_angle).sum()
    # Texels of 2.8° on the blind cone's border count whole or not at all, but hold few pixels.
    assert pixels == pytest.approx(np.pi * 60**2, rel=0.01)
    # The blind cone, to within the texels on its border.
    blind = (1 - np.cos(np.radians(found.blind_cone))) / 2
    # Of the cone's 83 texels 32 lie on its border: 0.3·√32 of 83 is 2 %; five of that.
    assert 1 - found.coverage == pytest.approx(blind, rel=0.1)
    # The ball is in the middle of the photo: exact but for rounding.
    assert np.allclose(found.blind_direction, [0, 0, -1])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
def test_dtypes_and_constants(dtype):
    photo = np.full((64, 64, 2), 77, dtype)
    found = sm.ball.unwrap(photo, center=(32, 32), radius=30, fov=30, dst="cube", size=8)
    assert found.image.dtype == dtype and found.image.shape == (6, 8, 8, 2)
    assert np.all(found.image[found.seen] == 77)
    assert np.all(found.image[~found.seen] == 0 if dtype in (np.uint8, np.uint16) else True)


def test_metal_and_reflectance_are_undone():
    camera = dict(fov=40, distance=4)
    photo = sm.ball.render(SCENE, size=160, metal="Cu", reflectance=[0.9, 0.8, 0.7], **camera)
    found = sm.ball.unwrap(
        photo, center=(80, 80), metal="Cu", reflectance=[0.9, 0.8, 0.7], size=32, **camera
    )
    want = sm.convert(SCENE, "latlong", "latlong", size=32, filter="area")
    fine = found.spacing < np.pi / 32
    assert np.sqrt(np.mean((found.image - want)[fine] ** 2)) < 0.03


def test_backgrounds():
    white = np.ones((16, 32, 3), np.float32)
    alpha = sm.ball.render(white, size=(40, 60), radius=15, background="alpha")
    assert alpha.shape == (40, 60, 4) and alpha.dtype == np.float32
    # 94 pixels on the rim, each off by 0.3 of one, if it is looked up once: 0.3·√94 of 707.
    assert alpha[..., 3].sum() == pytest.approx(np.pi * 15**2, rel=0.005)
    # White times alpha in float32: 6e-8.
    np.testing.assert_allclose(alpha[..., 0], alpha[..., 3], atol=1e-6)
    assert np.all(sm.ball.render(white, size=30, radius=10) == 1)


def test_a_mask_hides():
    photo = np.ones((80, 80))
    photo[:, :40] = np.nan
    mask = np.zeros((80, 80), bool)
    mask[:, 40:] = True
    found = sm.ball.unwrap(photo, center=(40, 40), radius=38, mask=mask, size=16, distance=np.inf)
    assert 0.3 < found.coverage < 0.6
    assert np.all(found.image[found.seen] == 1)


def test_found_in_clutter_and_cut_off():
    rng = np.random.default_rng(0)
    photo = sm.ball.render(SCENE, size=(240, 320), center=(170, 110), radius=80, background="black")
    clutter = rng.random((12, 16, 3)).repeat(20, 0).repeat(20, 1)
    ball = sm.ball.render(
        np.ones((8, 16)), size=(240, 320), center=(170, 110), radius=80, background="alpha"
    )
    photo += clutter * (1 - ball[..., 1:])
    photo += 0.02 * rng.standard_normal(photo.shape)
    found = sm.ball.find(photo)
    assert np.hypot(found.center[0] - 170, found.center[1] - 110) < 1
    assert abs(found.radius - 80) < 1.5 and found.confidence > 0.7
    cut = sm.ball.find(photo[:150])
    assert np.hypot(cut.center[0] - 170, cut.center[1] - 110) < 2


def before_a_wall(size, center, radius, level, scene=SCENE, seed=0):
    """A photo of a ball before a plain wall, with a little noise."""
    rng = np.random.default_rng(seed)
    ball = sm.ball.render(
        scene, size=size, center=center, radius=radius, distance=6, background="alpha"
    )
    photo = ball[..., :3] + (1 - ball[..., 3:]) * level
    return photo + 0.01 * rng.standard_normal(photo.shape)


@some_fast("level", [0.0, 0.9, 1.2, 3.0], fast=(0.0, 1.2))
def test_found_before_a_plain_wall(level):
    photo = before_a_wall((200, 240), (132, 95), 62, level)
    found = sm.ball.find(photo)
    # 2 % of the radius is what `docs/mirror-balls.md` states for radii from 60 pixels on.
    off = np.hypot(found.center[0] - 132, found.center[1] - 95)
    assert off + abs(found.radius - 62) < 0.02 * 62
    # A wall as bright as the ball leaves doubt: there is hardly a step.
    assert found.confidence > (0.7 if level in (0.0, 3.0) else 0.1)


@some_fast("lens", ["angular", "perspective"], fast=("perspective",))
def test_a_frame_is_no_ball(lens):
    """The round picture of a dome camera, or a porthole: a sharp rim that mirrors nothing."""
    camera = sm.projection(lens, fov=170 if lens == "angular" else 90)
    d = sm.directions("latlong", 256)
    # Waves from everywhere: edges that run in all directions alike, as the page says.
    waves = random_directions(40, 5)
    scene = np.repeat(4 + np.sin(25 * d @ waves.T).sum(axis=-1, keepdims=True) / 3, 3, axis=-1)
    photo = np.zeros((240, 240, 3))
    photo[40:200, 40:200] = sm.convert(scene, "latlong", camera, size=160)
    photo[np.hypot(*(np.mgrid[:240, :240] + 0.5 - 120)) > 80] = 0
    photo += 0.01 * np.random.default_rng(0).standard_normal(photo.shape)
    assert sm.ball.find(photo).confidence < 0.5
    ball = before_a_wall((240, 240), (120, 120), 80, 0.0, scene)
    assert sm.ball.find(ball).confidence > 0.7


def test_doubt_is_told():
    """Of a ball under an even sky, with one lamp, hardly any of the rim is there to be seen."""
    d = sm.directions("latlong", 64)
    sky = np.ones((64, 128, 3)) + 3 * (d @ [0.6, 0.64, 0.48] > 0.9)[..., None]
    photo = before_a_wall((200, 240), (132, 95), 62, 1.0, sky)
    try:
        found = sm.ball.find(photo)
    except ValueError:
        return
    off = np.hypot(found.center[0] - 132, found.center[1] - 95) + abs(found.radius - 62)
    assert found.confidence < 0.7 or off < 2


@pytest.mark.parametrize(("yaw", "radius", "distance"), [(128.6, 76, 7.2), (315.8, 80, 10.3)])
def test_black_before_black_is_told(data_folder, yaw, radius, distance):
    """In a dark studio much of the rim shows nothing, beside nothing."""
    studio = sm.convert(
        sm.io.read(data_folder / "studio.exr"),
        "latlong",
        "latlong",
        size=256,
        rotation=sm.rotation(yaw),
    )
    center = (134, 121.7)
    photo = sm.ball.render(studio, size=256, center=center, radius=radius, distance=distance)
    photo /= np.percentile(photo, 99)
    noise = np.random.default_rng(0).standard_normal(photo.shape)
    found = sm.ball.find(photo + 0.01 * noise * np.sqrt(np.maximum(photo, 0) + 0.01))
    off = np.hypot(*(found.points() - center).T) - radius
    # 2 % is what `docs/mirror-balls.md` states for a confidence above 0.7.
    assert found.confidence < 0.7 or np.abs(off).max() < 0.02 * radius


@pytest.mark.parametrize("kind", ["noise", "flat", "stripes", "tiny", "nan"])
def test_no_ball(kind):
    rng = np.random.default_rng(1)
    photo = {
        "noise": rng.random((200, 200)),
        "flat": np.ones((100, 100)),
        "stripes": np.sin(np.arange(200) / 3)[None].repeat(200, 0) + 1,
        "tiny": np.ones((4, 4)),
        "nan": np.full((50, 50), np.nan),
    }[kind]
    with pytest.raises(ValueError, match="no ball found"):
        sm.ball.find(photo)


def test_merged_with_masks_and_given_rotations():
    camera = dict(size=96, fov=25, distance=6)
    ball = sm.ball.Ball((48, 48), (36.6, 36.6), 0, 1)
    pose = sm.rotation(120, 0, 0)
    a = sm.ball.render(SCENE, **camera)
    b = sm.ball.render(SCENE, pose=pose, **camera)
    a[40:56, 40:56] = 50  # somebody looks into the picture
    mask = np.ones((96, 96))
    mask[38:58, 38:58] = 0
    found = sm.ball.merge(
        [a, b], poses=[np.eye(3), pose], balls=[ball] * 2, fov=25, masks=[mask, None], size=24
    )
    want = sm.convert(SCENE, "latlong", "latlong", size=24, filter="area")
    assert found.coverage == 1 and found.image.max() < 4
    assert np.sqrt(np.mean((found.image - want) ** 2)) < 0.06
    # Each weight is rounded to float32: 6e-8.
    assert np.allclose(found.weights.sum(axis=0), 1, atol=1e-6)


def test_nobody_saw_it():
    """Where no photo saw anything is what is asked for there, 0 by default."""
    photo, ball = np.ones((64, 64, 2), np.float32), sm.ball.Ball((32, 32), (30, 30), 0, 1)
    found = sm.ball.merge([photo], balls=[ball], distance=3, size=32)
    hidden = found.weights[0] == 0
    assert 0 < hidden.mean() < 0.2 and (found.image[hidden] == 0).all()
    marked = sm.ball.merge([photo], balls=[ball], distance=3, size=32, fill=[np.nan, 7])
    assert np.isnan(marked.image[hidden, 0]).all() and (marked.image[hidden, 1] == 7).all()


def angle(a, b):
    return np.degrees(np.arccos(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1)))


def test_rotation_from_rims_that_were_found():
    """Rims that are off turn the result; refined with the rotation, both come out."""
    pose = sm.rotation(100, 7, -12)
    camera = dict(size=160, fov=25, distance=6)
    a, b = sm.ball.render(SCENE, **camera), sm.ball.render(SCENE, pose=pose, **camera)
    right = view((160, 160), None, center=(80, 80), fov=25, distance=6).outline
    # Half a percent to one of the radius, as `ball.find` has it.
    off = [
        sm.ball.Ball((80.5, 79.6), (right.mean * 0.994,) * 2, 0, 0.8),
        sm.ball.Ball((79.5, 80.3), (right.mean * 1.006,) * 2, 0, 0.8),
    ]
    found = sm.ball.merge([a, b], balls=off, fov=25, size=16)
    assert angle(found.poses[1], pose) < 0.1
    for rim in found.balls:
        # Half of what the rims were off by: 0.6 % and 0.6 pixels.
        assert abs(rim.radius / right.mean - 1) < 0.003
        assert np.hypot(rim.center[0] - 80, rim.center[1] - 80) < 0.3
    # Given by hand they are kept.
    given = [sm.ball.Ball(rim.center, rim.radii, 0, 1) for rim in off]
    kept = sm.ball.merge([a, b], balls=given, fov=25, size=16)
    for rim, kept_rim in zip(given, kept.balls, strict=True):
        # An ellipse of the same area, which bisection finds to its last bits.
        assert kept_rim.center == rim.center and kept_rim.confidence == 1
        assert kept_rim.radius == pytest.approx(rim.radius, rel=1e-9)


def test_photos_that_do_not_overlap():
    ball = sm.ball.Ball((48, 48), (36.6, 36.6), 0, 1)
    a = sm.ball.render(SCENE, size=96, fov=25, distance=6)
    other = 1.5 + np.cos(11 * sm.directions("latlong", 64)[..., [1, 2, 0]])
    b = sm.ball.render(other, size=96, fov=25, distance=6)
    with pytest.raises(ValueError, match="photo 2 does not overlap"):
        sm.ball.merge([a, b], balls=[ball] * 2, fov=25, size=8)
    left, right = np.zeros((2, 96, 96), bool)
    left[:, :40] = right[:, 60:] = True
    with pytest.raises(ValueError, match="photo 2 does not overlap"):
        sm.ball.merge(
            [a, a], balls=[ball] * 2, poses=[np.eye(3)] * 2, masks=[left, right], size=8, fov=25
        )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda p: sm.ball.unwrap(p[0]), r"shape \(H, W\)"),
        (lambda p: sm.ball.unwrap(p, radius=4), "`radius` without `center`"),
        (lambda p: sm.ball.unwrap(p, center=(8, 8), radius=0), "`radius` must be"),
        (lambda p: sm.ball.unwrap(p, center=(8, np.nan), radius=4), "`center` must be"),
        (lambda p: sm.ball.unwrap(p, center=(8, 8), radius=4, fov=200), "`fov` must be"),
        (lambda p: sm.ball.unwrap(p, center=(8, 8), radius=4, distance=0.5), "`distance` must be"),
        (lambda p: sm.ball.unwrap(p, center=(8, 8)), "Without `radius`"),
        (lambda p: sm.ball.unwrap(p, center=(8, 8), radius=4, mask=p[:3]), "`mask` to have shape"),
        (lambda p: sm.ball.unwrap(p, center=(8, 8), radius=4, metal="Fe"), "unknown metal 'Fe'"),
        (lambda p: sm.ball.render(p[:8], size=0), "`size` must be"),
        (lambda p: sm.ball.merge(p), "a sequence of photos, got one of shape .16, 16.; give"),
        (lambda p: sm.ball.merge(np.ones((16, 16, 3))), "sequence of photos, got one of shape"),
        (lambda p: sm.ball.merge([np.ones((3, 16, 16))]), "photo 1 .*looks like channels first"),
        (lambda p: sm.ball.find(np.ones((3, 16, 16))), "`photo` .*looks like channels first"),
        (
            lambda p: sm.ball.unwrap(np.ones((3, 16, 16)), center=(8, 8), radius=4),
            "`photo` .*looks like channels first",
        ),
        (lambda p: sm.ball.Ball((8, 8), 4, 0, 1), "`radii` to be two finite numbers above 0, got"),
        (lambda p: sm.ball.Ball((8, 8), (4, 0), 0, 1), "`radii` to be two finite numbers above 0"),
        (lambda p: sm.ball.Ball((8, np.nan), (4, 4), 0, 1), "`center` to be two finite numbers"),
        (lambda p: sm.ball.render(p, background="white"), "`background`"),
        (lambda p: sm.ball.render(p[:8], filter="ewa"), "^Expected `filter` to be one of nearest"),
        (
            lambda p: sm.ball.unwrap(p, center=(8, 8), radius=4, filter="trilinear"),
            "^Expected `filter` to be one of .*, gaussian, got 'trilinear'",
        ),
        (lambda p: sm.ball.merge([p], filter="ewa"), "^Expected `filter` to be one of"),
        (lambda p: sm.ball.merge([]), "at least one photo"),
        (lambda p: sm.ball.merge([p, p], masks=[None]), "one entry for each"),
        (lambda p: sm.light.bake_matcap(p, material="velvet"), "`material`"),
        (lambda p: sm.light.shade_matcap([0, 0, 1], p, eye=[0, 0, 1]), "or neither"),
    ],
)
def test_errors(call, words):
    with pytest.raises(ValueError, match=words):
        call(np.ones((16, 16)))


@pytest.mark.parametrize("size", [2.0, "x", (8, 8.0), None, True])
def test_the_sides_of_a_photo_are_whole(size):
    with pytest.raises(TypeError, match="`size` to be a whole number"):
        sm.ball.render(np.ones((8, 16)), size=size)


WALL = before_a_wall((96, 112), (58, 47), 32, 0.2).astype(np.float32)
KNOWN = dict(center=(58, 47), radius=32, distance=6)
# Every public function that takes a photo or an environment.
CALLS = {
    "find": lambda p: np.array(sm.ball.find(p).points(8)),
    "unwrap": lambda p: sm.ball.unwrap(p, size=8, **KNOWN).image,
    "merge": lambda p: (
        sm.ball.merge([p], balls=[sm.ball.Ball((58, 47), (32, 32), 0, 1)], distance=6).image
    ),
    "render": lambda p: sm.ball.render(p, size=12, any_aspect=True),
    "bake_matcap": lambda p: sm.light.bake_matcap(p, material="mirror", size=8, any_aspect=True),
    "shade_matcap": lambda p: sm.light.shade_matcap(
        [[0.1, 0.2, 0.9]], p[:96, :96] if p.ndim > 1 else p
    ),
    "shade_environment": lambda p: sm.light.shade_environment(
        [0, 0, 0], [[0.1, 0.2, 0.9]], [0, 0, 5], p, any_aspect=True
    ),
}


@some_fast("name", CALLS, fast=[name for name in CALLS if name != "find"])
def test_layouts_of_memory(name):
    """Strided, reversed, Fortran-ordered and read-only photos are as good as any."""
    want = CALLS[name](WALL)
    wide = np.zeros((96 * 2, 112 * 3, 3), np.float32)
    wide[::2, ::3] = WALL
    still = WALL.copy()
    still.flags.writeable = False
    backward = np.ascontiguousarray(WALL[::-1, ::-1])[::-1, ::-1]
    for photo in (wide[::2, ::3], still, backward, np.asfortranarray(WALL)):
        before = photo.copy()
        np.testing.assert_array_equal(CALLS[name](photo), want)
        np.testing.assert_array_equal(photo, before)


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("shape", [(0, 8, 3), (8, 0, 3), (8, 8, 0), (0,), ()])
def test_empty(name, shape):
    with pytest.raises(ValueError, match=r"shape|empty|at least"):
        CALLS[name](np.ones(shape, np.float32))


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("dtype", [complex, object, "S1"])
def test_wrong_dtypes(name, dtype):
    with pytest.raises(TypeError):
        CALLS[name](np.ones((32, 32, 3)).astype(dtype))


def test_pixels_that_are_not_finite():
    """NaN and infinity stay where they are: what they do not touch is as without them."""
    holes = WALL.copy()
    holes[30:34, 50:54], holes[60, 60] = np.nan, np.inf
    whole = sm.ball.unwrap(WALL, size=24, **KNOWN)
    found = sm.ball.unwrap(holes, size=24, **KNOWN)
    # Lookups in the same texels; `isclose`'s own 1e-5 is above float32's 6e-8.
    same = np.isclose(found.image, whole.image, equal_nan=True).all(axis=-1)
    assert 0.8 < same.mean() < 1
    rim = sm.ball.find(holes)
    assert np.hypot(rim.center[0] - 58, rim.center[1] - 47) + abs(rim.radius - 32) < 1.5
    two = sm.ball.merge(
        [holes, WALL],
        balls=[sm.ball.Ball((58, 47), (32, 32), 0, 1)] * 2,
        poses=[np.eye(3)] * 2,
        distance=6,
        size=24,
    )
    assert np.isfinite(two.image).all(axis=-1).sum() == np.isfinite(two.image[..., 0]).sum()
    assert np.isfinite(two.image).mean() > 0.97


def test_a_brightness_that_is_no_number():
    with pytest.raises(ValueError, match="no ball found"):
        sm.ball.find(np.full((80, 160, 3), 1e308))


def test_masks_of_the_wrong_size():
    ball = sm.ball.Ball((58, 47), (32, 32), 0, 1)
    for mask in (np.ones((96, 111)), np.ones((96, 112, 3)), np.ones(96), np.ones((0, 0))):
        with pytest.raises(ValueError, match="`mask` to have"):
            sm.ball.find(WALL, mask=mask)
        with pytest.raises(ValueError, match="`mask` to have"):
            sm.ball.unwrap(WALL, mask=mask, **KNOWN)
        with pytest.raises(ValueError, match="photo 2: Expected `mask` to have"):
            sm.ball.merge([WALL, WALL], balls=[ball] * 2, masks=[None, mask])


def test_no_ball_in_what_is_asked_for():
    gray = np.ones((64, 64, 3), np.float32)
    with pytest.raises(ValueError, match="no ball found"):
        sm.ball.unwrap(gray)
    with pytest.raises(ValueError, match="photo 2: no ball found"):
        sm.ball.merge([WALL, gray])


def test_how_far_the_ideal_camera_is_off():
    """What `ball.unwrap` says of a ball that fills 40°: at its rim, half of that."""
    exact = view((400, 400), Outline((200, 200), 200, 200), fov=40)
    ideal = view((400, 400), Outline((200, 200), 200, 200))
    xy = exact.outline.points(360, inset=1e-9)
    a, b = exact.reflections(xy)[0], ideal.reflections(xy)[0]
    off = np.degrees(np.arccos(np.einsum("ij,ij->i", a, b)))
    # 1e-9 pixels inside a rim of 200, reflections turn by 2·√(2e-9/200) rad = 4e-4°.
    np.testing.assert_allclose(off, 20, atol=0.01)


def test_matcaps():
    env = SCENE.astype(np.float32)
    pose = sm.rotation(50, 20, 0)
    n = sm.directions("matcap", 32)
    inside = n[..., 2] > 0.3
    mirror = sm.light.bake_matcap(env, material="mirror", size=32, pose=pose)
    d = sm.reflect(np.array([0.0, 0, 1]), n[inside]) @ pose.T
    # The mean of a texel that sees up to 15° is not its middle.
    assert np.sqrt(np.mean((mirror[inside] - sm.sample(env, d, "latlong")) ** 2)) < 0.1
    diffuse = sm.light.bake_matcap(env, material="diffuse", size=32, pose=pose)
    want = sm.light.irradiance_at(env, n[inside] @ pose.T, "latlong") / np.pi
    # The mean of a texel of 0.2 rad is not its middle: 0.2²/24 of a curvature of some units.
    np.testing.assert_allclose(diffuse[inside], want, atol=0.02)
    assert (mirror[0, 0] == 0).all()
    marked = sm.light.bake_matcap(env, material="mirror", size=32, pose=pose, fill=np.nan)
    assert np.isnan(marked[0, 0]).all() and np.array_equal(marked[inside], mirror[inside])
    rough = sm.light.bake_matcap(env, material="rough", size=16, roughness=0.8, fill=np.nan)
    assert np.nanstd(rough) < np.nanstd(marked)


def test_matcap_follows_the_camera():
    """What faces the eye has the color of the middle, wherever it is and however it turns."""
    matcap = np.nan_to_num(sm.directions("matcap", 65), nan=0)
    eye, place = np.array([1.0, 2.0, 8.0]), np.array([-2.0, 0.5, 1.0])
    color = sm.light.shade_matcap(eye - place, matcap, positions=place, eye=eye)
    # The color of the middle texel: a place off by some ε on a slope of 2 across the image.
    np.testing.assert_allclose(color, [0, 0, 1], atol=1e-6)
    away = sm.light.shade_matcap([[0, 0, -1], [1, 0, -0.2]], matcap)
    assert np.isfinite(away).all() or np.isnan(away[0]).all()


def test_rotations_are_covered():
    grid = _grid()
    q = np.random.default_rng(0).normal(size=(50, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=-1, keepdims=True)).T
    some = np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        ), -1, 0,
    )  # fmt: skip
    trace = np.einsum("aij,bij->ab", grid, some).max(axis=0)
    assert np.degrees(np.arccos((trace.min() - 1) / 2)) < 16


def test_command(tmp_path):
    photo = sm.ball.render(SCENE, size=128, fov=30, distance=5).astype(np.float32)
    io.write(tmp_path / "a.exr", photo)
    io.write(tmp_path / "gray.exr", np.ones((64, 64, 3), np.float32))

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "spheremap.cli", "ball", *words],
            cwd=tmp_path, capture_output=True, text=True, check=False,
        )  # fmt: skip

    done = run(
        "a.exr", "-o", "pano.exr", "--rim", "64,64,48.76", "--fov", "30",
        "--preview", "rims.png", "--size", "32",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert io.read(tmp_path / "pano.exr").shape == (32, 64, 3)
    assert (io.read(tmp_path / "rims.png") == (255, 64, 32)).all(axis=-1).sum() > 200
    known = ("--fov", "30", "--size", "32")
    rim = ("--rim", "64,64,48.76")
    done = run("a.exr", "-o", "z-up.exr", *rim, "--to", "latlong:blender", *known)
    assert done.returncode == 0, done.stderr
    there = sm.convert(io.read(tmp_path / "z-up.exr"), "latlong:blender", "latlong", size=32)
    seen = io.read(tmp_path / "pano.exr").any(axis=-1)
    # Worlds turn by quarters; texels beside a seam, which is elsewhere, are averaged of others.
    np.testing.assert_allclose(there[seen], io.read(tmp_path / "pano.exr")[seen], atol=0.02)
    io.write(tmp_path / "black.png", np.zeros((128, 128), np.uint8))
    for wrong, words in (
        (("--rim", "-300,64,40"), "outside of the photo, which is 128 x 128: look at its --rim"),
        ((*rim, "--mask", "black.png"), "--mask is 0 on all of the ball"),
        ((*rim, "--distance", "inf"), "do not go together"),
    ):
        failed = run("a.exr", "-o", "none.exr", *wrong, *known)
        assert failed.returncode == 1 and words in failed.stderr, failed.stderr
    none = run("gray.exr", "-o", "none.exr")
    assert none.returncode == 1 and "gray.exr: no ball found" in none.stderr
    assert not (tmp_path / "none.exr").exists()
