"""Which way yaw, pitch and roll turn: ours beside py360convert, ffmpeg and OpenCV.

Each program is run on a panorama that stores its own directions, so that its picture says where
each of its pixels looks; the camera's pose that explains them is a row of docs/rotation.md.
"""

from __future__ import annotations

import subprocess
from typing import Any

import numpy as np
import pytest
import spheremap as sm

from oracles import ffmpeg_oracle, need, py360convert_oracle

FOV, SIZE, HEIGHT = 60, 65, 512
# One angle at a time shows its sign, all three the order.
ANGLES = [(20, 0, 0), (0, 20, 0), (0, 0, 20), (35, 20, 10), (-120, -40, 75)]


def seen_by_py360convert(yaw: float, pitch: float, roll: float) -> tuple[np.ndarray, str]:
    py360convert: Any = need("py360convert")
    print(f"ran against {py360convert_oracle.version()}")
    p = sm.projection("latlong", convention="py360convert")
    image = py360convert.e2p(
        p.directions(HEIGHT), FOV, yaw, pitch, (SIZE, SIZE), in_rot_deg=roll, mode="bilinear"
    )
    # The same texels as the library's panorama has them; its pictures have corners for a grid.
    return sm.decode(p.encode(image), "latlong"), "corners"


def seen_by_ffmpeg(yaw: float, pitch: float, roll: float) -> tuple[np.ndarray, str]:
    print(f"ran against {ffmpeg_oracle.version()}")
    # As the row `latlong:ffmpeg` says, its texels lie on corners.
    directions = sm.projection("latlong", grid="corners").directions(HEIGHT)
    effect = f"v360=e:flat:interp=linear:w={SIZE}:h={SIZE}:h_fov={FOV}:v_fov={FOV}"
    effect += f":yaw={yaw}:pitch={pitch}:roll={roll}"
    raw = ["-f", "rawvideo", "-pix_fmt", "gray16le"]
    command = [ffmpeg_oracle.program(), "-loglevel", "error", *raw, "-s", f"{2 * HEIGHT}x{HEIGHT}"]
    command += ["-i", "-", "-vf", effect, *raw, "-"]
    seen = []
    for k in range(3):
        data = np.rint((directions[..., k] + 1) / 2 * 65535).astype("<u2").tobytes()
        run = subprocess.run(command, input=data, capture_output=True, check=True)
        seen.append(np.frombuffer(run.stdout, "<u2").reshape(SIZE, SIZE) / 65535 * 2 - 1)
    return np.stack(seen, axis=-1), "centers"


@pytest.mark.parametrize("seen_by", [seen_by_py360convert, seen_by_ffmpeg])
@pytest.mark.parametrize("angles", ANGLES, ids=str)
def test_py360convert_and_ffmpeg_look_right_and_up_and_roll_clockwise(seen_by, angles):
    yaw, pitch, roll = angles
    seen, grid = seen_by(yaw, pitch, roll)
    camera = sm.projection("perspective", fov=FOV, grid=grid)
    pose = sm.rotation(-yaw, pitch, -roll)
    want = camera.directions(SIZE) @ pose.T
    # ffmpeg's four weights have 14 bits, each off by 2^-15 of a range of 2; py360convert looks up
    # in steps of 1/32 of a texel of 2π/1024. Both are below 2.5e-4.
    assert np.abs(seen - want).max() < 2.5e-4
    # Any other sign of an angle is off by sin 10° at least.
    for other in np.array([(1, 1, -1), (-1, -1, -1), (-1, 1, 1)]) * angles:
        if not np.array_equal(other, (-yaw, pitch, -roll)):
            assert np.abs(seen - camera.directions(SIZE) @ sm.rotation(*other).T).max() > 0.1


# A turn about each axis of OpenCV's camera (right, down, forward), in degrees, and the angles of
# the pose: where the vector is a camera's (world to camera), and where it is the pose itself.
RVECS = [
    ((20, 0, 0), (0, -20, 0), (0, 20, 0)),
    ((0, 20, 0), (20, 0, 0), (-20, 0, 0)),
    ((0, 0, 20), (0, 0, 20), (0, 0, -20)),
]
# OpenCV's axes (right, down, forward) from a world with y up that is looked at along -z.
CV = np.diag([1.0, -1.0, -1.0])


@pytest.mark.parametrize(("rvec", "as_camera", "as_pose"), RVECS, ids=str)
def test_opencv_vectors_are_world_to_camera(rvec, as_camera, as_pose):
    cv2: Any = need("cv2")
    print(f"ran against OpenCV {cv2.__version__}")
    vector = np.radians(rvec)
    matrix = cv2.Rodrigues(vector)[0]
    # A rotation by 20°: rounding of its sine and cosine.
    assert np.abs(CV @ matrix.T @ CV - sm.rotation(*as_camera)).max() < 1e-15
    assert np.abs(CV @ matrix @ CV - sm.rotation(*as_pose)).max() < 1e-15

    camera = sm.projection("perspective", fov=FOV)
    world = camera.directions(9).reshape(-1, 3) @ sm.rotation(*as_camera).T
    focal = SIZE / (2 * np.tan(np.radians(FOV) / 2))
    middle = (SIZE - 1) / 2
    k = np.array([[focal, 0, middle], [0, focal, middle], [0, 0, 1]])
    pixels, _ = cv2.projectPoints(world @ CV.T, vector, np.zeros(3), k, None)
    want = camera.directions(9).reshape(-1, 3)
    # Pixels of a picture of 65, in a few roundings of float64.
    assert np.abs(pixels[:, 0] - (camera.encode(want) * SIZE - 0.5)).max() < 1e-11


def test_ours():
    forward, right = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    yaw, pitch, roll = sm.rotation(20, 0, 0), sm.rotation(0, 20, 0), sm.rotation(0, 0, 20)
    assert (yaw @ forward)[0] < -0.3  # a pose looks left, content moves left
    assert (pitch @ forward)[1] > 0.3  # up
    assert (roll @ right)[1] > 0.3  # its right side goes up
    both = sm.rotation(35, 0, 0) @ sm.rotation(0, 20, 0) @ sm.rotation(0, 0, 10)
    # Rounding of two products.
    assert np.abs(sm.rotation(35, 20, 10) - both).max() < 1e-15
