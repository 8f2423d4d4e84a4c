"""Rigs that cover the sphere, what is cut with them, and what COLMAP reads of them."""

from __future__ import annotations

import json
import math

import numpy as np
import pycolmap
import pytest
import spheremap as sm
from conftest import random_directions, some_fast
from spheremap.cameras.quaternions import from_matrix, to_matrix

RIGS = [
    {"fov": 90, "overlap": 0},
    {"fov": 90},
    {"fov": 65, "overlap": 0.3},
    {"n": 6},
    {"n": 12, "overlap": 0.1},
]
each_rig = pytest.mark.parametrize("options", RIGS, ids=str)


@each_rig
@some_fast("size", [64, (48, 80)], fast=(64,))
def test_every_direction_is_in_the_middle_of_a_view(options, size):
    rig = sm.cameras.rig(size, **options)
    d = random_directions(100_000, 500)
    uv = np.stack([view.projection.encode(d) for view in rig])
    off = 2 * np.abs(uv - 0.5).max(-1)
    least = np.nanmin(np.where(np.isnan(off), 2, off), axis=0)
    # 1500 places are looked at: what lies between them is missed by a fraction of 3 degrees.
    assert least.max() <= 1 - options.get("overlap", 0.2) + 0.05
    assert not np.isnan(uv[..., 0]).all(0).any()
    assert "n" not in options or len(rig) <= options["n"]


def test_six_views_of_90_degrees_are_a_cube():
    rig = sm.cameras.rig(64, fov=90, overlap=0)
    assert len(rig) == 6
    forward = np.stack([view.pose[:, 2] for view in rig])
    # Sines and cosines of multiples of 90 degrees: ε.
    assert np.abs(np.abs(forward).max(-1) - 1).max() < 1e-15
    assert sum(view.camera.covered_solid_angle for view in rig) == pytest.approx(
        4 * math.pi, rel=1e-14
    )


def test_views_are_cut_from_a_panorama_and_points_carried_between_them():
    rig = sm.cameras.rig((40, 60), n=10)
    world = "+x -y +z"
    panorama = sm.projection("latlong", axes="+x +y +z", world=world)
    # What a place of the panorama shows is its direction.
    picture = panorama.directions((256, 512)).astype(np.float64)
    for view, seen in zip(rig, rig.convert(picture, panorama), strict=True):
        want = view.projection.directions(view.size)
        # Between texels of 0.7 degrees a chord is 2e-5 off its arc; the poles have corners.
        assert np.abs(seen - want).max() < 1e-3
        xy = sm.directions_to_pixels(want, view.projection, view.size)
        middle = np.stack(np.meshgrid(np.arange(60) + 0.5, np.arange(40) + 0.5), -1)
        # Pixels up to 60, a dozen roundings.
        assert np.abs(xy - middle).max() < 1e-11
        there = sm.directions_to_pixels(want, panorama, (256, 512))
        back = sm.pixels_to_directions(there, panorama, (256, 512))
        # And through the panorama's pixels: a turn is 512, an ε of it 1e-15 rad.
        assert np.abs(back - want).max() < 1e-13
    with pytest.raises(TypeError, match="no `size`"):
        rig.convert(picture, panorama, size=3)


def test_what_is_up_in_a_panorama_is_up_in_its_views():
    for panorama in ("latlong", "latlong:blender", "latlong:unreal"):
        height = np.broadcast_to(np.linspace(1, -1, 64)[:, None], (64, 128))
        for view, seen in zip(
            (rig := sm.cameras.rig(32, fov=90, overlap=0)),
            rig.convert(height, panorama),
            strict=True,
        ):
            if abs(view.pose[1, 2]) < 0.5:
                assert seen[0].mean() > 0.3 > -0.3 > seen[-1].mean()
            else:
                assert np.sign(seen[16, 16]) == -np.sign(view.pose[1, 2])


def scene(rig, n=400):
    """Points all around, some near."""
    rng = np.random.default_rng(501)
    points = rng.normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=-1, keepdims=True) * rng.uniform(1, 20, (n, 1))


@pytest.fixture
def moved():
    """A rig of three kinds of cameras in three places, turned any way."""
    rng = np.random.default_rng(502)
    cameras = [
        (sm.camera((500, 510, 321.5, 238.2), (480, 640)), (480, 640)),
        (
            sm.camera(
                (500, 510, 321.5, 238.2),
                (480, 640),
                distortion=[-0.1, 0.02, 1e-3, 2e-3],
                model="brown_conrady",
            ),
            (480, 640),
        ),
        (
            sm.camera(
                (200, 201, 255.5, 250),
                (512, 512),
                distortion=[0.01, -0.002, 0.0005, -0.0001],
                model="kannala_brandt",
            ),
            (512, 512),
        ),
    ]
    views = []
    for k, (camera, size) in enumerate(cameras):
        pose, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        pose *= np.sign(np.linalg.det(pose))
        views.append(sm.cameras.View(f"eye{k}", camera, size, pose, rng.normal(size=3)))
    return sm.cameras.Rig(tuple(views))


def test_colmap_reads_what_is_written_and_sees_the_same(moved, tmp_path):
    sm.cameras.write(moved, tmp_path, format="colmap")
    theirs = pycolmap.Reconstruction(str(tmp_path))
    images = {image.name: image for image in theirs.images.values()}
    assert set(images) == {f"{view.name}/0001.png" for view in moved}
    points = scene(moved)
    seen = 0
    for view in moved:
        image = images[f"{view.name}/0001.png"]
        local = np.asarray(image.cam_from_world() * points)
        xy = sm.directions_to_pixels(points - view.position, view.projection, view.size)
        # COLMAP's fisheyes see what lies ahead.
        held = ~np.isnan(xy[:, 0]) & (local[:, 2] > 0)
        there = np.asarray(image.camera.img_from_cam(local[held]))
        # The file has every digit; a quaternion keeps a rotation to a few ε, 1e-12 of 600 pixels.
        assert np.abs(there - xy[held]).max() < 1e-6
        seen += held.sum()
    assert seen > 100


def test_colmap_reads_the_rig(moved, tmp_path):
    sm.cameras.write(moved, tmp_path, format="colmap")
    (rig,) = pycolmap.read_rig_config(str(tmp_path / "rig_config.json"))
    assert [camera.image_prefix for camera in rig.cameras] == ["eye0/", "eye1/", "eye2/"]
    assert [camera.ref_sensor for camera in rig.cameras] == [True, False, False]
    first = moved[0]
    for view, camera in list(zip(moved, rig.cameras, strict=True))[1:]:
        there = camera.cam_from_rig
        points = scene(moved, 50)
        ours = (points - view.position) @ view.pose
        # From the world to the first camera, then by theirs.
        theirs = np.asarray(there * ((points - first.position) @ first.pose))
        # A quaternion's few ε of distances up to 20.
        assert np.abs(ours - theirs).max() < 1e-12


@pytest.mark.parametrize("format", ["colmap", "nerfstudio"])
def test_what_is_written_is_read(moved, tmp_path, format):
    sm.cameras.write(moved, tmp_path, format=format, frame="a.jpg")
    name = {"colmap": "cameras.txt", "nerfstudio": "transforms.json"}[format]
    for path in [tmp_path / name, *([tmp_path] if format == "colmap" else [])]:
        back = sm.cameras.read(path)
        beside = "images/" if format == "nerfstudio" else ""
        assert [view.name for view in back] == [f"{beside}{view.name}/a.jpg" for view in moved]
        for a, b in zip(moved, back, strict=True):
            assert a.size == b.size
            # Quaternions and pixels by half a pixel: a few ε of numbers up to 10 and 640.
            assert np.abs(a.pose - b.pose).max() < 1e-14
            assert np.abs(a.position - b.position).max() < 1e-14
            # The same of fractions of the width.
            assert a.camera.name == b.camera.name
            for key, value in a.camera.parameters.items():
                # As above.
                assert b.camera.parameters[key] == pytest.approx(value, rel=1e-14, abs=1e-15)


def test_nerfstudio_has_opengls_cameras(moved, tmp_path):
    sm.cameras.write(moved, tmp_path, format="nerfstudio")
    frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    for view, frame in zip(moved, frames, strict=True):
        matrix = np.array(frame["transform_matrix"])
        # Columns: right, up, backward; where it is.
        assert np.array_equal(matrix[:3, 0], view.pose[:, 0])
        assert np.array_equal(matrix[:3, 1], -view.pose[:, 1])
        assert np.array_equal(matrix[:3, 2], -view.pose[:, 2])
        assert np.array_equal(matrix[:3, 3], view.position)


def test_a_panorama_is_nerfstudios(tmp_path):
    """The rays of its cameras.py, written out: EQUIRECTANGULAR, cx and cy of the middle."""
    pose = np.linalg.qr(np.random.default_rng(505).normal(size=(3, 3)))[0]
    pose *= np.linalg.det(pose)
    view = sm.cameras.View("sky", sm.projection("latlong:colmap"), (40, 80), pose)
    sm.cameras.write(sm.cameras.Rig((view,)), tmp_path, format="nerfstudio")
    (frame,) = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    assert frame["camera_model"] == "EQUIRECTANGULAR"
    x, y = np.meshgrid(np.arange(80) + 0.5, np.arange(40) + 0.5)
    theta = -math.pi * (x - frame["cx"]) / frame["fl_x"]
    phi = math.pi * (0.5 + (y - frame["cy"]) / frame["fl_y"])
    rays = np.stack([-np.sin(theta) * np.sin(phi), np.cos(phi), -np.cos(theta) * np.sin(phi)], -1)
    rays = rays @ np.array(frame["transform_matrix"])[:3, :3].T
    ours = view.camera.directions(view.size) @ pose.T
    # A few roundings of numbers at most 1.
    assert np.abs(ours - rays).max() < 1e-14
    (back,) = sm.cameras.read(tmp_path / "transforms.json")
    assert back.camera == view.camera
    # Two changes of sign.
    assert np.array_equal(back.pose, pose)


@pytest.mark.parametrize(
    ("model", "distortion"), [("fov", [0.9]), ("eucm", [0.6, 1.1]), ("unified", [0.5])]
)
def test_transforms_json_has_few_models(tmp_path, model, distortion):
    camera = sm.camera((300, 300, 319.5, 239.5), (480, 640), distortion=distortion, model=model)
    view = sm.cameras.View("a", camera, (480, 640), np.eye(3))
    with pytest.raises(ValueError, match="Expected cameras with a model of"):
        sm.cameras.write(sm.cameras.Rig((view,)), tmp_path, format="nerfstudio")


def test_quaternions_are_rotations():
    rng = np.random.default_rng(503)
    q = rng.normal(size=(200, 4))
    q = np.concatenate([q, np.eye(4), np.ones((1, 4)), [[0, 1, 1, 0], [1e-9, 1, 0, 0]]])
    for one in q:
        unit = one / np.linalg.norm(one)
        turn = to_matrix(one)
        # A few ε of numbers at most 2.
        assert np.abs(turn @ turn.T - np.eye(3)).max() < 2e-15
        back = np.array(from_matrix(turn))
        # And through a root.
        assert min(np.abs(back - unit).max(), np.abs(back + unit).max()) < 2e-15
        assert back[0] >= 0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "either `n` or `fov`, got none"),
        ({"n": 6, "fov": 90}, "got both"),
        ({"fov": 171}, "`fov` to be in"),
        ({"fov": 90, "overlap": 0.9}, "`overlap` to be in"),
        ({"n": 3}, "`n` to be in"),
        ({"fov": 2}, "cover the sphere"),
        ({"n": 4, "overlap": 0.8}, "cover the sphere"),
    ],
)
def test_what_is_wrong_is_told(options, text):
    with pytest.raises(ValueError, match=text):
        sm.cameras.rig(64, **options)


def test_a_rig_is_of_views_that_can_be_written(moved, tmp_path):
    assert len(moved[1:]) == 2 and "eye1" in repr(moved)
    with pytest.raises(TypeError, match="of View"):
        sm.cameras.Rig((1,))
    plain = sm.cameras.View("a", moved[0].camera, (480, 640))
    with pytest.raises(ValueError, match="'a' has none"):
        sm.cameras.write(sm.cameras.Rig((plain,)), tmp_path, format="colmap")
    lens = sm.camera((200, 200, 100, 100), (200, 200), distortion=[0.2, 0.6], model="double_sphere")
    odd = sm.cameras.Rig((sm.cameras.View("a", lens, (200, 200), np.eye(3)),))
    for format in ("colmap", "nerfstudio"):
        with pytest.raises(ValueError, match="camera_double_sphere"):
            sm.cameras.write(odd, tmp_path / "odd", format=format)


def test_a_rig_that_moved_is_written_without_poses(moved, tmp_path):
    masks = [np.ones(view.size, bool) for view in moved]
    frames = ["a.jpg", "b.jpg"]
    sm.cameras.write(moved, tmp_path, format="colmap", frame=frames, masks=masks)
    assert {path.name for path in tmp_path.iterdir()} == {"rig_config.json", "masks"}
    (rig,) = pycolmap.read_rig_config(str(tmp_path / "rig_config.json"))
    assert len(rig.cameras) == len(moved)
    assert len(list(tmp_path.glob("masks/*/?.jpg.png"))) == 2 * len(moved)
    with pytest.raises(ValueError, match="one `frame` for nerfstudio"):
        sm.cameras.write(moved, tmp_path, format="nerfstudio", frame=frames)
    with pytest.raises(ValueError, match="at least one file name"):
        sm.cameras.write(moved, tmp_path, format="colmap", frame=[])


@pytest.mark.parametrize("centers", ["half", "integer"])
def test_pixels_go_from_view_to_view(moved, centers):
    a, b = moved[0], moved[2]
    xy = np.random.default_rng(504).uniform(0, 1, (2000, 2)) * [640, 480]
    there = b.pixels_from(xy.astype(np.float32), a.projection, a.size, centers=centers)
    assert there.dtype == np.float64
    d = sm.pixels_to_directions(xy, a.projection, a.size, centers=centers)
    want = sm.directions_to_pixels(d, b.projection, b.size, centers=centers)
    seen = ~np.isnan(want[:, 0])
    assert 0 < seen.sum() < len(xy)
    # float32 rounds pixels up to 640 to 3e-5.
    assert np.abs(there[seen] - want[seen]).max() < 1e-4
    exact = b.pixels_from(xy, a.projection, a.size, centers=centers)[seen]
    back = b.pixels_to(exact, a.projection, a.size, centers=centers)
    # A few hundred roundings of pixels up to 640.
    assert np.abs(back - xy[seen]).max() < 1e-9
    for wrong in (3.0, [1, 2, 3]):
        with pytest.raises(ValueError, match=r"`xy` to have shape \(..., 2\)"):
            b.pixels_to(wrong, a.projection, a.size)


def test_pixels_of_a_panorama_are_in_its_world():
    """What is ahead and up in a panorama is so in the rig, as `convert` cuts it."""
    rig = sm.cameras.rig(64, fov=90, overlap=0)
    for name in ("latlong", "latlong:blender", "latlong:colmap", "latlong:unreal"):
        panorama = np.zeros((128, 256))
        panorama[40, 150] = 1
        views = rig.convert(panorama, name)
        for view, picture in zip(rig, views, strict=True):
            x, y = view.pixels_from([150.5, 40.5], name, (128, 256))
            if np.isnan(x):
                assert picture.max() < 0.5
            else:
                assert picture[int(y), int(x)] > 0.2
