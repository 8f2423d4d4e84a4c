"""Files of calibration programs, as the programs write them, and what is refused by name."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pycolmap
import pytest
import spheremap as sm

K = np.array([[700.5, 0, 639.25], [0, 701.5, 358.75], [0, 0, 1]])
D = np.array([-0.1, 0.03, 1e-3, -2e-3, 0.01])


def is_camera(view, distortion, model, size=(720, 1280)):
    want = sm.camera(K, size, distortion=distortion, model=model)
    assert view.camera == want and view.size == size


def store(path, **values):
    """Write as OpenCV's samples do."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in values.items():
        storage.write(name, value)
    storage.release()


@pytest.mark.parametrize("suffix", [".yml", ".yaml", ".xml"])
def test_opencv(tmp_path, suffix):
    path = tmp_path / f"out{suffix}"
    both = {"image_width": 1280, "image_height": 720, "camera_matrix": K}
    store(path, **both, distortion_coefficients=D.reshape(5, 1))
    (view,) = sm.cameras.read(path)
    is_camera(view, D, "brown_conrady")
    assert view.pose is None
    store(path, **both, fisheye_model=1, distortion_coefficients=D[:4])
    is_camera(sm.cameras.read(path)[0], D[:4], "kannala_brandt")
    store(path, **both, xi=np.array([[1.2]]), distortion_coefficients=D[:4])
    is_camera(sm.cameras.read(path)[0], [1.2, *D[:4]], "unified")
    store(path, **both, distortion_coefficients=np.zeros(5))
    is_camera(sm.cameras.read(path)[0], None, "pinhole")
    # As calibrateCamera gives them for CALIB_THIN_PRISM_MODEL.
    prism = np.concatenate([D, [0.1, 0.02, 0.003, 1e-3, -2e-3, 5e-4, 3e-3]])
    store(path, **both, distortion_coefficients=prism)
    is_camera(sm.cameras.read(path)[0], prism, "brown_conrady")
    # And for CALIB_RATIONAL_MODEL: prism and tilt are there, and zero.
    long = np.concatenate([D, [0.1, 0.02, 0.003], np.zeros(6)])
    store(path, **both, distortion_coefficients=long)
    is_camera(sm.cameras.read(path)[0], long[:8], "brown_conrady")
    tilted = np.concatenate([prism, [0.02, -0.03]])
    store(path, **both, distortion_coefficients=tilted)
    is_camera(sm.cameras.read(path)[0], tilted, "brown_conrady")
    store(path, camera_matrix=K)
    with pytest.raises(ValueError, match="image_width"):
        sm.cameras.read(path)


@pytest.mark.parametrize("suffix", [".yml", ".xml", ".json"])
@pytest.mark.parametrize("matrix", ["camera_matrix", "Camera_Matrix", "cameraMatrix", "K"])
@pytest.mark.parametrize(
    "distortion", ["distortion_coefficients", "distCoeffs", "dist_coeffs", "dist", "D"]
)
def test_any_name_of_a_matrix_goes_with_any_of_a_distortion(tmp_path, suffix, matrix, distortion):
    path = tmp_path / f"out{suffix}"
    store(path, image_width=1280, image_height=720, **{matrix: K, distortion: D.reshape(1, 5)})
    (view,) = sm.cameras.read(path)
    is_camera(view, D, "brown_conrady")


@pytest.mark.parametrize("suffix", [".yml", ".xml", ".json"])
def test_two_distortions_are_an_error(tmp_path, suffix):
    path = tmp_path / f"out{suffix}"
    both = {"image_width": 1280, "image_height": 720, "camera_matrix": K}
    store(path, **both, dist_coeffs=D, D=D)
    with pytest.raises(ValueError, match=rf"one of dist_coeffs and D in 'out{suffix}', got both"):
        sm.cameras.read(path)
    store(path, **both, K=K, D=D)
    with pytest.raises(ValueError, match="one of camera_matrix and K"):
        sm.cameras.read(path)
    # As in a file whose list is written one number a line, which is not read.
    store(path, **both, dist_coeffs="none")
    with pytest.raises(ValueError, match="numbers of 'dist_coeffs'"):
        sm.cameras.read(path)


@pytest.mark.parametrize("suffix", [".yml", ".xml", ".json"])
def test_the_interactive_calibration_has_a_resolution(tmp_path, suffix):
    path = tmp_path / f"out{suffix}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    # As cv::Size is written.
    storage.startWriteStruct("cameraResolution", cv2.FileNode_SEQ + cv2.FileNode_FLOW)
    storage.write("", 1280)
    storage.write("", 720)
    storage.endWriteStruct()
    storage.write("camera_matrix", K)
    storage.write("camera_matrix_std_dev", np.zeros((4, 1)))
    storage.write("dist_coeffs", D.reshape(1, 5))
    storage.write("dist_coeffs_std_dev", np.zeros((5, 1)))
    storage.write("avg_reprojection_error", 0.2)
    storage.release()
    is_camera(sm.cameras.read(path, format="opencv")[0], D, "brown_conrady")


def test_json_of_others_is_read_where_its_format_is_said(tmp_path):
    path = tmp_path / "out.json"
    fields = {"image_width": 1280, "image_height": 720, "model": "x", "K": K.tolist()}
    path.write_text(json.dumps({**fields, "dist": [D.tolist()]}))
    is_camera(sm.cameras.read(path, format="opencv")[0], D, "brown_conrady")
    path.write_text("{")
    with pytest.raises(ValueError, match="Expected OpenCV's JSON"):
        sm.cameras.read(path, format="opencv")


@pytest.mark.parametrize("binary", [False, True])
def test_colmap(tmp_path, binary):
    ours = sm.cameras.rig(64, n=6)
    sm.cameras.write(ours, tmp_path, format="colmap")
    theirs = pycolmap.Reconstruction(str(tmp_path))
    theirs.add_camera_with_trivial_rig(
        pycolmap.Camera(
            model="OPENCV",
            width=1280,
            height=720,
            params=[700.5, 701.5, 639.75, 359.25, *D[:4]],
            camera_id=9,
        )
    )
    folder = tmp_path / "theirs"
    folder.mkdir()
    (theirs.write_binary if binary else theirs.write_text)(str(folder))
    back = sm.cameras.read(folder)
    assert sorted(view.name for view in back) == [f"{view.name}/0001.png" for view in ours]
    for a, b in zip(ours, back, strict=True):
        # Through a quaternion: a few ε.
        assert np.abs(a.pose - b.pose).max() < 1e-14
        assert b.camera == a.camera
    for name in ("images.txt", "images.bin", "frames.txt", "frames.bin"):
        (folder / name).unlink(missing_ok=True)
    cameras = {view.name: view for view in sm.cameras.read(folder)}
    is_camera(cameras["9"], D[:4], "brown_conrady")


NUMBERS = {
    "SIMPLE_PINHOLE": [700, 640, 360],
    "PINHOLE": [700, 710, 641, 352],
    "SIMPLE_RADIAL": [700, 640, 360, -0.1],
    "RADIAL": [700, 640, 360, -0.1, 0.03],
    "OPENCV": [700, 710, 641, 352, -0.1, 0.03, 1e-3, -2e-3],
    "OPENCV_FISHEYE": [400, 410, 641, 352, 0.02, -0.01, 0.003, -0.0005],
    "FULL_OPENCV": [700, 710, 641, 352, -0.1, 0.03, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.002],
    "FOV": [700, 710, 641, 352, 0.9],
    "THIN_PRISM_FISHEYE": [400, 410, 641, 352, 0.02, -0.01, 2e-3, -3e-3, 3e-3, -5e-4, 5e-3, -2e-3],
    "SIMPLE_RADIAL_FISHEYE": [400, 640, 360, 0.02],
    "RADIAL_FISHEYE": [400, 640, 360, 0.02, -0.003],
    "RAD_TAN_THIN_PRISM_FISHEYE": [
        *(400, 410, 641, 352, 0.02, -0.01, 3e-3, -5e-4, 1e-4, -1e-5),
        *(2e-3, -3e-3, 5e-3, -2e-3, 1e-3, -1e-3),
    ],
    "SIMPLE_DIVISION": [700, 640, 360, 0.2],
    "DIVISION": [700, 710, 641, 352, -0.2],
    "SIMPLE_FISHEYE": [400, 640, 360],
    "FISHEYE": [400, 410, 641, 352],
    "EUCM": [700, 710, 641, 352, 0.6, 1.1],
    "EQUIRECTANGULAR": [1280, 640],
}


@pytest.mark.parametrize("binary", [False, True])
def test_colmaps_models_are_read_as_colmap_writes_them(tmp_path, binary):
    """Each model, by its name in text and by its number in binary, and written again."""
    theirs = pycolmap.Reconstruction()
    for k, (name, numbers) in enumerate(NUMBERS.items(), 1):
        height = 640 if name == "EQUIRECTANGULAR" else 720
        theirs.add_camera_with_trivial_rig(
            pycolmap.Camera(model=name, width=1280, height=height, params=numbers, camera_id=k)
        )
    (theirs.write_binary if binary else theirs.write_text)(str(tmp_path))
    for name in ("images.txt", "images.bin", "frames.txt", "frames.bin"):
        (tmp_path / name).unlink(missing_ok=True)
    d = np.random.default_rng(504).normal(size=(4000, 3))
    d[:, 2] = np.abs(d[:, 2]) + 0.5
    rig = sm.cameras.read(tmp_path)
    assert len(rig) == len(NUMBERS)
    for view in rig:
        camera = theirs.cameras[int(view.name)]
        xy = sm.directions_to_pixels(d, view.camera, view.size)
        seen = ~np.isnan(xy[:, 0])
        assert seen.sum() > 1000
        # As the issue asks: a few hundred roundings of numbers up to 1280.
        assert np.abs(xy[seen] - np.asarray(camera.img_from_cam(d[seen]))).max() < 1e-9
    posed = [sm.cameras.View(v.name, v.camera, v.size, np.eye(3)) for v in rig]
    sm.cameras.write(sm.cameras.Rig(tuple(posed)), tmp_path / "ours", format="colmap")
    again = pycolmap.Reconstruction(str(tmp_path / "ours"))
    for image in again.images.values():
        was = theirs.cameras[int(image.name.split("/")[0])]
        both = [np.asarray(c.img_from_cam(d)) for c in (image.camera, was)]
        # As above; some are written as others that are the same.
        assert np.nanmax(np.abs(both[0] - both[1])) < 1e-9


def test_colmap_models_without_a_formula_are_named(tmp_path):
    (tmp_path / "cameras.txt").write_text("1 BICUBIC 1280 720 700 640 360\n")
    with pytest.raises(ValueError, match="BICUBIC"):
        sm.cameras.read(tmp_path / "cameras.txt")
    theirs = pycolmap.Reconstruction()
    theirs.add_camera_with_trivial_rig(
        pycolmap.Camera(model="PINHOLE", width=64, height=48, params=[9, 9, 32, 24], camera_id=1)
    )
    theirs.write_binary(str(tmp_path))
    data = bytearray((tmp_path / "cameras.bin").read_bytes())
    # A count of 8 bytes and an id of 4 are before the model's number.
    data[12:16] = (99).to_bytes(4, "little")
    (tmp_path / "cameras.bin").write_bytes(data)
    with pytest.raises(ValueError, match="number 99"):
        sm.cameras.read(tmp_path / "cameras.bin")
    data = (tmp_path / "cameras.bin").read_bytes()
    (tmp_path / "cameras.bin").write_bytes(data[:20])
    with pytest.raises(ValueError, match="ends early"):
        sm.cameras.read(tmp_path / "cameras.bin")


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("cameras.txt", b"# no\nhello world, a text\n", "height and .* line 2 of cameras.txt"),
        ("cameras.txt", b"1 PINHOLE 9 9 a 9 4 4\n", "line 1 of cameras.txt, got '1 PINHOLE 9 9 a"),
        ("cameras.txt", b"\n1 PINHOLE\n", "line 2 of cameras.txt, got '1 PINHOLE'"),
        ("cameras.txt", b"\xff\xfe", "cameras.txt, got a file that holds no text"),
        ("images.txt", b"1 1 0 0 0 0 0 0\n\n", "an image's id, pose, .* line 1 of images.txt"),
    ],
)
def test_lines_that_colmap_does_not_write_are_named(name, data, says, tmp_path):
    (tmp_path / "cameras.txt").write_bytes(b"1 PINHOLE 9 9 9 9 4 4\n")
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ValueError, match=says):
        sm.cameras.read(tmp_path / "cameras.txt", format="colmap")


CHAIN = """\
cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.1, 0.03, 0.001, -0.002]
  distortion_model: radtan
  intrinsics: [700.5, 701.5, 639.25, 358.75]
  resolution: [1280, 720]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, 0.1]
  - [1.0, 0.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: ds
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [-0.2, 0.6, 700.5, 701.5, 639.25, 358.75]
  resolution: [1280, 720]
cam2:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, 1.0]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: omni
  distortion_coeffs: [-0.1, 0.03, 0.001, -0.002]
  distortion_model: radtan
  intrinsics: [1.2, 700.5, 701.5, 639.25, 358.75]
  resolution: [1280, 720]
"""


def test_kalibr(tmp_path):
    path = tmp_path / "camchain.yaml"
    path.write_text(CHAIN)
    rig = sm.cameras.read(path)
    assert [view.name for view in rig] == ["cam0", "cam1", "cam2"]
    is_camera(rig[0], D[:4], "brown_conrady")
    is_camera(rig[1], [-0.2, 0.6], "double_sphere")
    is_camera(rig[2], [1.2, *D[:4]], "unified")
    assert np.array_equal(rig[0].pose, np.eye(3)) and not rig[0].position.any()
    # A point of the first camera's frame goes through each matrix in turn.
    point = np.array([0.3, -0.4, 2.0])
    first = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]) @ point + [0.1, 0.2, 0.3]
    for view, want in ((rig[1], first), (rig[2], first + np.array([1, 0, 0]))):
        # A dozen roundings of numbers below 4.
        assert np.abs((point - view.position) @ view.pose - want).max() < 1e-14
    path.write_text(CHAIN.replace("omni", "spherical"))
    with pytest.raises(ValueError, match=r"'camchain.yaml', cam2: .*spherical-radtan"):
        sm.cameras.read(path)
    path.write_text(CHAIN.replace("[0.0, 0.0, 1.0, 0.3]", "[0.0, 0.0, -1.0, 0.3]"))
    with pytest.raises(ValueError, match=r"'camchain.yaml', cam1: `pose` is no rotation"):
        sm.cameras.read(path)
    path.write_text(
        CHAIN.replace("radtan", "fov").replace("[-0.1, 0.03, 0.001, -0.002]", "[0.9]")
        .replace("omni", "pinhole").replace("[1.2, ", "[")
    )  # fmt: skip
    is_camera(sm.cameras.read(path)[0], [0.9], "fov")


ROS = """\
image_width: 1280
image_height: 720
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [700.5, 0, 639.25, 0, 701.5, 358.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.1, 0.03, 0.001, -0.002, 0.01]
"""


def test_ros(tmp_path):
    path = tmp_path / "head_camera.yaml"
    path.write_text(ROS)
    (view,) = sm.cameras.read(path)
    assert view.name == "narrow_stereo"
    is_camera(view, D, "brown_conrady")
    path.write_text(ROS.replace("plumb_bob", "thin_prism"))
    with pytest.raises(ValueError, match="thin_prism"):
        sm.cameras.read(path)


def test_ros_has_lenses_without_distortion_and_zeros_to_fill(tmp_path):
    path = tmp_path / "head_camera.yaml"
    data = "data: [-0.1, 0.03, 0.001, -0.002, 0.01]"
    for name in ("''", "none", "None"):
        for given in ("data: []", "data: [0, 0, 0, 0, 0]"):
            path.write_text(ROS.replace("plumb_bob", name).replace(data, given))
            is_camera(sm.cameras.read(path)[0], None, "pinhole")
        path.write_text(ROS.replace("plumb_bob", name))
        with pytest.raises(ValueError, match=r"'head_camera.yaml': .* 'pinhole'"):
            sm.cameras.read(path)
    path.write_text(ROS.replace("plumb_bob", "PLUMB_BOB"))
    is_camera(sm.cameras.read(path)[0], D, "brown_conrady")
    fisheye = ROS.replace("plumb_bob", "equidistant")
    path.write_text(fisheye.replace("0.01]", "0.0]"))
    is_camera(sm.cameras.read(path)[0], D[:4], "kannala_brandt")
    path.write_text(fisheye)
    with pytest.raises(ValueError, match=r"'head_camera.yaml': .* got 5"):
        sm.cameras.read(path)


# As rostopic echo and ros2 topic echo print it.
MESSAGE = """\
header:
  stamp: {sec: 12, nanosec: 5}
  frame_id: left_optical
height: 720
width: 1280
distortion_model: plumb_bob
D: [-0.1, 0.03, 0.001, -0.002, 0.01]
K: [700.5, 0.0, 639.25, 0.0, 701.5, 358.75, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [700.5, 0.0, 639.25, 0.0, 0.0, 701.5, 358.75, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
---
"""


def test_ros_messages(tmp_path):
    path = tmp_path / "info.yaml"
    for text in (MESSAGE, MESSAGE.replace("D:", "d:").replace("K:", "k:")):
        path.write_text(text)
        (view,) = sm.cameras.read(path)
        assert view.name == "left_optical"
        is_camera(view, D, "brown_conrady")
    lines = MESSAGE.splitlines()
    path.write_text(
        "\n".join("K: [0, 0, 0, 0, 0, 0, 0, 0, 0]" if x[0] == "K" else x for x in lines)
    )
    with pytest.raises(ValueError, match="K of zeros"):
        sm.cameras.read(path)
    path.write_text(MESSAGE.replace("K:", "L:"))
    with pytest.raises(ValueError, match="CameraInfo"):
        sm.cameras.read(path)


# As nerfstudio's documentation has it.
SPLATS = {
    "fl_x": 700.5,
    "fl_y": 701.5,
    "cx": 639.75,
    "cy": 359.25,
    "w": 1280,
    "h": 720,
    "frames": [{"file_path": "images/a.png", "transform_matrix": np.eye(4).tolist()}],
}


def splats(path, frame=None, **fields):
    """Write a transforms.json, without the fields that are None."""
    scene = {key: value for key, value in (SPLATS | fields).items() if value is not None}
    scene["frames"] = [SPLATS["frames"][0] | (frame or {})]
    path.write_text(json.dumps(scene))


@pytest.mark.parametrize(
    "model", [None, "OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"]
)
def test_perspectives_of_nerfstudio_have_its_coefficients(tmp_path, model):
    """Its CAMERA_MODEL_TO_TYPE makes one kind of all of them."""
    path = tmp_path / "transforms.json"
    given = dict(zip(("k1", "k2", "p1", "p2"), D[:4].tolist(), strict=True))
    for frame in ({}, {"camera_model": "OPENCV"}):
        splats(path, frame, camera_model=model, **given)
        is_camera(sm.cameras.read(path)[0], D[:4], "brown_conrady")
        splats(path, {**frame, **given}, camera_model=model)
        is_camera(sm.cameras.read(tmp_path)[0], D[:4], "brown_conrady")
    splats(path, camera_model=model, **given, k3=0.01)
    is_camera(sm.cameras.read(path)[0], [*D, 0, 0, 0], "brown_conrady")
    splats(path, camera_model=model, k1=0.0)
    is_camera(sm.cameras.read(path)[0], None, "pinhole")


@pytest.mark.parametrize(
    ("frame", "fields", "says"),
    [
        ({"transform_matrix": [[1, 0], [0, 1]]}, {}, r"shape \(4, 4\), got \(2, 2\)"),
        ({"transform_matrix": [[1, 0], [0]]}, {}, "`transform_matrix` to be an array of numbers"),
        ({"transform_matrix": "x"}, {}, "`transform_matrix` to be real numbers"),
        ({"fl_x": "abc"}, {}, "`fl_x` to be a number, got 'abc'"),
        ({}, {"fl_x": None}, "`fl_x` to be a number, got None"),
        ({}, {"h": None}, "Expected `w` and `h`, or a picture"),
        ({"w": [3]}, {}, r"`w` to be a number, got \[3\]"),
        ({}, {"k4": 0.1}, "k4 of OPENCV to be 0"),
        ({}, {"camera_model": "VR180_L"}, "`camera_model` to be one of .* got 'VR180_L'"),
    ],
)
def test_what_is_wrong_in_a_frame_is_named(tmp_path, frame, fields, says):
    path = tmp_path / "transforms.json"
    splats(path, frame, **fields)
    with pytest.raises(ValueError, match=f"'transforms.json', frame 'images/a.png': .*{says}"):
        sm.cameras.read(path)


def test_poses_of_a_few_digits_are_rotations(tmp_path):
    turn = np.eye(4)
    turn[:3, :3] = sm.rotation(33, -20, 71)
    path = tmp_path / "transforms.json"
    splats(path, {"transform_matrix": turn.round(4).tolist()})
    pose = sm.cameras.read(path)[0].pose
    assert np.abs(pose @ pose.T - np.eye(3)).max() < 1e-14  # a few roundings of float64
    splats(path, {"transform_matrix": (1.01 * turn).tolist()})
    with pytest.raises(ValueError, match="is no rotation"):
        sm.cameras.read(path)


def test_nerfs_synthetic_scenes(tmp_path):
    """As its load_blender.py has it: .5 W / tan(.5 camera_angle_x), .png, the middle."""
    path = tmp_path / "transforms_train.json"
    frame = {"file_path": "./train/r_0", "transform_matrix": np.eye(4).tolist()}
    path.write_text(json.dumps({"camera_angle_x": 0.7, "frames": [frame, 3]}))
    with pytest.raises(ValueError, match=r"frame './train/r_0': .* or a picture .*r_0.png' that"):
        sm.cameras.read(path)
    (tmp_path / "train").mkdir()
    sm.io.write(tmp_path / "train" / "r_0.png", np.zeros((40, 60, 4), np.uint8))
    with pytest.raises(ValueError, match=r"_train.json', frame '1': Expected fields, got 3"):
        sm.cameras.read(path)
    path.write_text(json.dumps({"camera_angle_x": 0.7, "frames": [frame]}))
    (view,) = sm.cameras.read(path)
    focal = 0.5 * 60 / np.tan(0.5 * 0.7)
    assert view.size == (40, 60)
    assert view.camera == sm.camera((focal, focal, 29.5, 19.5), (40, 60))


def test_a_folder_without_cameras_says_what_is_there(tmp_path):
    with pytest.raises(ValueError, match=r"cameras.bin in .*, got nothing"):
        sm.cameras.read(tmp_path)
    rig = sm.cameras.rig(16, fov=90)
    sm.cameras.write(rig, tmp_path, format="colmap", frame=["a.jpg", "b.jpg"])
    with pytest.raises(ValueError, match=r"got rig_config.json; .* read the folder of its model"):
        sm.cameras.read(tmp_path)
    # A folder of both programs' files is COLMAP's: so it was before nerfstudio's was found.
    sm.cameras.write(rig, tmp_path, format="nerfstudio")
    assert sm.cameras.read(tmp_path)[0].name == "images/view00/0001.png"
    assert sm.cameras.read(tmp_path, format="nerfstudio")[0].name == "images/view00/0001.png"
    sm.cameras.write(rig, tmp_path, format="colmap")
    assert sm.cameras.read(tmp_path)[0].name == "view00/0001.png"


def test_files_that_are_none_of_these(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("nothing")
    with pytest.raises(ValueError, match="looks like none"):
        sm.cameras.read(path)
    for format in ("opencv", "kalibr", "ros", "nerfstudio"):
        with pytest.raises(ValueError, match="Expected"):
            sm.cameras.read(path, format=format)
    with pytest.raises(ValueError, match="`format` to be one of"):
        sm.cameras.read(path, format="zip")
    with pytest.raises(FileNotFoundError):
        sm.cameras.read(tmp_path / "missing.json")
