"""Rigs that cover the sphere, what is cut with them, and what COLMAP reads of them."""

from __future__ import annotations

import json
import math
import re

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
    # Parts that meet do so within 1e-9 rad, a few times that in halves of a picture.
    assert least.max() <= 1 - options.get("overlap", 0.2) + 1e-8
    assert not np.isnan(uv[..., 0]).all(0).any()
    assert "n" not in options or len(rig) <= options["n"]


def beside_crossings(rig, part):
    """Directions in the four corners where sides of the middle parts cross: a hole has some."""
    p = rig[0].camera.parameters
    a, b = part / (2 * p["fx"]), part / (2 * p["fy"])
    local = np.array([[1, 0, a], [-1, 0, a], [0, 1, b], [0, -1, b]])
    local /= np.linalg.norm(local, axis=-1, keepdims=True)
    sides = np.concatenate([local @ view.pose.T for view in rig])
    i, j = np.triu_indices(len(sides), 1)
    crossing = np.cross(sides[i], sides[j])
    length = np.linalg.norm(crossing, axis=-1)
    # Sides on one great circle cross nowhere; others are at least some degrees apart.
    kept = length > 1e-6
    i, j, crossing = i[kept], j[kept], crossing[kept] / length[kept, None]
    return np.concatenate(
        [
            way * crossing + 1e-6 * (x * sides[i] + y * sides[j])
            for way in (-1, 1)
            for x in (-1, 1)
            for y in (-1, 1)
        ]
    )


@pytest.mark.parametrize(
    ("size", "options"),
    [
        # These left holes of a thousandth of the sphere and less.
        ((48, 64), {"fov": 45, "overlap": 0}),
        ((480, 640), {"n": 36, "overlap": 0}),
        ((36, 64), {"fov": 53, "overlap": 0}),
        ((64, 48), {"fov": 45, "overlap": 0}),
        ((36, 64), {"fov": 109, "overlap": 0}),
        ((1080, 1920), {"n": 24, "overlap": 0}),
        ((480, 640), {"fov": 90}),
        # Sides on each other.
        (64, {"fov": 90, "overlap": 0}),
        (64, {"fov": 60, "overlap": 0}),
    ],
    ids=str,
)
def test_the_middle_parts_leave_no_hole(size, options):
    rig = sm.cameras.rig(size, **options)
    part = 1 - options.get("overlap", 0.2)
    p = rig[0].camera.parameters
    left = beside_crossings(rig, part)
    for view in rig:
        x, y, z = (left @ view.pose).T
        # Parts that meet do so within 1e-9 rad, or ten times that in a wide one.
        seen = (np.abs(x) * p["fx"] <= (part / 2 + 1e-8) * z) & (
            np.abs(y) * p["fy"] <= (part / 2 + 1e-8) * z
        )
        left = left[~seen]
    assert len(left) == 0


def test_rigs_are_no_larger_than_they_need_be():
    # Sides on each other: no more views for their rounding.
    assert len(sm.cameras.rig(64, fov=60, overlap=0)) == 18
    assert len(sm.cameras.rig(64, fov=90)) == 13


def test_a_panorama_comes_back_whole():
    rig = sm.cameras.rig((48, 64), fov=45, overlap=0)
    views = rig.convert(np.ones((256, 512), np.float32), "latlong")
    _, weight = sm.cameras.stitch(views, rig, "latlong", size=256, return_weight=True)
    assert weight.min() > 0


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
    if format == "nerfstudio":
        # It has one model for all.
        moved = moved[:2]
    sm.cameras.write(moved, tmp_path, format=format, frame="a.jpg")
    name = {"colmap": "cameras.txt", "nerfstudio": "transforms.json"}[format]
    for path in (tmp_path / name, tmp_path):
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


def raised(vectors):
    """What nerfstudio's colmap_to_json does to COLMAP's world, for +z up."""
    x, y, z = np.asarray(vectors).T
    return np.stack([x, z, -y], -1)


def test_nerfstudio_has_opengls_cameras_in_a_world_with_z_up(moved, tmp_path):
    sm.cameras.write(moved[:2], tmp_path, format="nerfstudio")
    frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    for view, frame in zip(moved[:2], frames, strict=True):
        matrix = np.array(frame["transform_matrix"])
        # Columns: right, up, backward; where it is.
        assert np.array_equal(matrix[:3, 0], raised(view.pose[:, 0]))
        assert np.array_equal(matrix[:3, 1], -raised(view.pose[:, 1]))
        assert np.array_equal(matrix[:3, 2], -raised(view.pose[:, 2]))
        assert np.array_equal(matrix[:3, 3], raised(view.position))


def test_a_panorama_is_nerfstudios(tmp_path):
    """The rays of its cameras.py, written out: EQUIRECTANGULAR, cx and cy of the middle."""
    pose = np.linalg.qr(np.random.default_rng(505).normal(size=(3, 3)))[0]
    pose *= np.linalg.det(pose)
    view = sm.cameras.View("sky", sm.projection("latlong:colmap"), (40, 80), pose)
    sm.cameras.write(sm.cameras.Rig((view,)), tmp_path, format="nerfstudio")
    scene = json.loads((tmp_path / "transforms.json").read_text())
    assert scene["camera_model"] == "EQUIRECTANGULAR"
    frame = scene | scene["frames"][0]
    x, y = np.meshgrid(np.arange(80) + 0.5, np.arange(40) + 0.5)
    theta = -math.pi * (x - frame["cx"]) / frame["fl_x"]
    phi = math.pi * (0.5 + (y - frame["cy"]) / frame["fl_y"])
    rays = np.stack([-np.sin(theta) * np.sin(phi), np.cos(phi), -np.cos(theta) * np.sin(phi)], -1)
    rays = rays @ np.array(frame["transform_matrix"])[:3, :3].T
    ours = raised(view.camera.directions(view.size).reshape(-1, 3) @ pose.T).reshape(rays.shape)
    # A few roundings of numbers at most 1.
    assert np.abs(ours - rays).max() < 1e-14
    (back,) = sm.cameras.read(tmp_path / "transforms.json")
    assert back.camera == view.camera
    # Two changes of sign.
    assert np.array_equal(back.pose, pose)


def test_nerfstudio_has_one_model_at_the_top(moved, tmp_path):
    """As its nerfstudio_dataparser.py reads: in a frame it looks for what the top has not."""
    with pytest.raises(ValueError, match=r"of one model .* got OPENCV and OPENCV_FISHEYE"):
        sm.cameras.write(moved, tmp_path / "none", format="nerfstudio")
    same = {"fl_x", "fl_y", "cx", "cy", "w", "h"}
    fisheye = sm.cameras.View("again", moved[2].camera, moved[2].size, moved[0].pose)
    for rig, model, distortion, shared in (
        ((moved[2], fisheye), "OPENCV_FISHEYE", {"k1", "k2", "k3", "k4"}, True),
        (moved[:2], "OPENCV", {"k1", "k2", "p1", "p2"}, False),
        (moved[:1], "OPENCV", set(), True),
    ):
        sm.cameras.write(sm.cameras.Rig(tuple(rig)), tmp_path, format="nerfstudio")
        scene = json.loads((tmp_path / "transforms.json").read_text())
        assert scene.pop("camera_model") == model
        frames = scene.pop("frames")
        for fields in [scene] if shared else frames:
            assert set(fields) >= same | distortion
        if not shared:
            assert not scene
            # Every frame has what one has.
            assert len({frozenset(frame) for frame in frames}) == 1
        for a, b in zip(rig, sm.cameras.read(tmp_path), strict=True):
            xy = np.random.default_rng(506).uniform(0.3, 0.7, (100, 2)) * a.size[::-1]
            d, e = (sm.pixels_to_directions(xy, view.projection, view.size) for view in (a, b))
            # Pixels up to 640 by half a pixel: a few ε.
            assert np.abs(d - e).max() < 1e-14


def test_what_is_level_in_nerfstudio_is_level_here(tmp_path):
    """A level camera that looks along +y, with +z up, and its picture of the height."""
    scene = {
        "camera_model": "OPENCV", "fl_x": 32, "fl_y": 32, "cx": 32, "cy": 32, "w": 64, "h": 64,
        "frames": [{
            "file_path": "images/a.png",
            "transform_matrix": [[1, 0, 0, 1], [0, 0, -1, 2], [0, 1, 0, 3], [0, 0, 0, 1]],
        }],
    }  # fmt: skip
    (tmp_path / "transforms.json").write_text(json.dumps(scene))
    (view,) = rig = sm.cameras.read(tmp_path)
    height = np.broadcast_to(np.linspace(1, -1, 128)[:, None], (128, 256))
    (seen,) = rig.convert(height, "latlong")
    # Between two rows whose mean is zero, but for rounding.
    assert abs(seen[31:33].mean()) < 1e-9 and seen[0].min() > 0.2 > -0.2 > seen[-1].max()
    panorama = sm.cameras.stitch([seen], rig, "latlong", size=64)
    # As above, and resampled.
    assert abs(panorama[31:33, 64].mean()) < 1e-9 and panorama[24, 64] > 0.05
    (mask,) = sm.cameras.masks(rig, photographer=60)
    assert mask[0].all() and not mask[-1, 32]
    assert view.position.tolist() == [1, -3, 2]
    sm.cameras.write(rig, tmp_path / "again", format="nerfstudio")
    assert json.loads((tmp_path / "again" / "transforms.json").read_text()) == scene


def test_a_cameras_own_turn_axes_and_world_are_written(moved, tmp_path):
    turn = sm.rotation(20, -30, 40)
    fields = {"fx": 0.5, "fy": 0.75, "aspect": 1.5}
    cameras = [
        moved[0].camera.turned(turn),
        sm.projection("camera_pinhole", **fields),
        sm.projection("camera_pinhole", axes="+z +x +y", **fields).turned(turn),
        sm.projection("camera_pinhole", **fields).in_world_of("latlong:unity"),
        sm.projection("latlong"),
        sm.projection("latlong:blender").turned(turn),
    ]
    for k, camera in enumerate(cameras):
        size = (480, 640) if k == 0 else (40, 80) if camera.name == "latlong" else (40, 60)
        view = sm.cameras.View("a", camera, size, moved[1].pose, moved[1].position)
        want = view.projection.in_world_of("latlong:colmap")
        for format in ("colmap", "nerfstudio"):
            sm.cameras.write(sm.cameras.Rig((view,)), tmp_path / format, format=format)
            (back,) = sm.cameras.read(tmp_path / format)
            uv = np.random.default_rng(507).uniform(0, 1, (100, 2))
            # Turns, quaternions and pixels up to 640: a few ε.
            assert np.abs(back.projection.decode(uv) - want.decode(uv)).max() < 1e-14
    # In Unity +y is up, and +z ahead.
    view = sm.cameras.View("a", cameras[3], (40, 60), np.eye(3), [1.0, 2.0, 3.0])
    sm.cameras.write(sm.cameras.Rig((view,)), tmp_path, format="colmap")
    assert sm.cameras.read(tmp_path)[0].position.tolist() == [1, -2, 3]
    for wrong in ({"axes": "-x -y -z"}, {"grid": "corners"}):
        camera = sm.projection("camera_pinhole", **wrong, **fields)
        view = sm.cameras.View("a", camera, (40, 60), np.eye(3))
        with pytest.raises(ValueError, match="mirror nothing, with grid 'centers', got 'a'"):
            sm.cameras.write(sm.cameras.Rig((view,)), tmp_path / "none", format="colmap")
    assert not (tmp_path / "none").exists()


def test_names_survive(tmp_path):
    """From file to file, in each order of the programs."""
    rig = sm.cameras.rig(64, n=6)
    formats = ("colmap", "nerfstudio")
    for format in formats:
        sm.cameras.write(rig, tmp_path / format, format=format)
    for source in formats:
        read = sm.cameras.read(tmp_path / source)
        for format in formats:
            there = tmp_path / f"{source}-{format}"
            sm.cameras.write(read, there, format=format)
            names = [view.name for view in sm.cameras.read(there)]
            assert names == [view.name for view in sm.cameras.read(tmp_path / format)]
            for path in there.iterdir():
                texts = [p.read_text() for p in (path, tmp_path / format / path.name)]
                prefixes, wanted = (re.findall(r"\bview[\w./]*", text) for text in texts)
                assert prefixes == wanted
    flat = [sm.cameras.View(f"{k}.JPG", rig[0].camera, (64, 64), rig[k].pose) for k in range(2)]
    sm.cameras.write(sm.cameras.Rig(tuple(flat)), tmp_path / "flat", format="colmap")
    assert [view.name for view in sm.cameras.read(tmp_path / "flat")] == ["0.JPG", "1.JPG"]
    (config,) = pycolmap.read_rig_config(str(tmp_path / "flat" / "rig_config.json"))
    assert [camera.image_prefix for camera in config.cameras] == ["0.JPG", "1.JPG"]


@pytest.mark.parametrize(
    "name", ["../../evil", "/evil", "a/../../b", "a\nb", "C:evil", "..\\evil", "", "a\u2028b"]
)
def test_names_that_leave_the_folder_are_refused(name, tmp_path):
    rig = sm.cameras.rig(16, fov=90, overlap=0)
    masks = sm.cameras.masks(rig)
    evil = sm.cameras.View(name, rig[0].camera, (16, 16), np.eye(3))
    views = sm.cameras.Rig((evil, *rig[1:]))
    for format in ("colmap", "nerfstudio"):
        with pytest.raises(ValueError, match="of one line and stay in the folder"):
            sm.cameras.write(views, tmp_path / "in", format=format, masks=masks)
    for frame in ("..", "../../a.png", "a\n.png", ["a.png", "../b.png"]):
        with pytest.raises(ValueError, match="of one line and stay in the folder"):
            sm.cameras.write(rig, tmp_path / "in", format="colmap", frame=frame, masks=masks)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "pose",
    [
        np.zeros((3, 3)),
        2 * np.eye(3),
        np.diag([1, 1, -1]),
        np.full((3, 3), np.nan),
        [[1, 1, 0], [0, 1, 0], [0, 0, 1]],
    ],
)
def test_poses_are_rotations(pose, moved, tmp_path):
    camera, size = moved[0].camera, moved[0].size
    with pytest.raises(ValueError, match="`pose` is no rotation"):
        sm.cameras.View("a", camera, size, pose)
    transform = np.eye(4)
    transform[:3, :3] = pose
    frames = [{"file_path": "b.png", "transform_matrix": transform.tolist()}]
    scene = {"fl_x": 9, "fl_y": 9, "cx": 8, "cy": 8, "w": 16, "h": 16, "frames": frames}
    (tmp_path / "transforms.json").write_text(json.dumps(scene))
    with pytest.raises(
        ValueError, match=r"'transforms.json', frame 'b.png': `pose` is no rotation"
    ):
        sm.cameras.read(tmp_path)


def test_positions_are_finite_and_sizes_the_cameras(moved, tmp_path):
    camera, size = moved[0].camera, moved[0].size
    with pytest.raises(ValueError, match=r"`position` to be finite, got .*nan"):
        sm.cameras.View("a", camera, size, np.eye(3), [0, np.nan, 0])
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 16 16 9 9 8 8\n")
    for image, text in (("0 0 0 0 0 0 0", "of no length"), ("1 0 0 0 0 nan 0", "to be finite")):
        (tmp_path / "images.txt").write_text(f"1 {image} 1 a/b.png\n\n")
        with pytest.raises(ValueError, match=rf"'images.txt', image 'a/b.png': .*{text}"):
            sm.cameras.read(tmp_path)
    with pytest.raises(ValueError, match=r"`size` to be .* got \(640, 480\)"):
        sm.cameras.View("a", camera, (640, 480))
    # Within a texel, as everywhere.
    assert sm.cameras.View("a", camera, (240, 321)).size == (240, 321)


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
