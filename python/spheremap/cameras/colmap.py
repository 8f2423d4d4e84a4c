"""COLMAP's cameras, images and rigs.

Source: COLMAP's documentation, "Output Format" and "Rig Support", and its table of camera models.
COLMAP counts the center of the first pixel (½, ½), and a pose takes the world to the camera.
"""

from __future__ import annotations

import json
import struct
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from ..map.cameras import COEFFICIENTS, PIXEL_CENTER, camera, matrix
from ..map.named import projection
from .quaternions import from_matrix, to_matrix
from .views import LATLONG, Rig, View, where

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["FILES", "from_model", "read", "to_model", "write"]

# COLMAP's name, how many focal lengths it has, our model, and our coefficients in COLMAP's order.
MODELS: dict[str, tuple[int, str, tuple[str, ...]]] = {
    "SIMPLE_PINHOLE": (1, "pinhole", ()),
    "PINHOLE": (2, "pinhole", ()),
    "SIMPLE_RADIAL": (1, "brown_conrady", ("k1",)),
    "RADIAL": (1, "brown_conrady", ("k1", "k2")),
    "OPENCV": (2, "brown_conrady", ("k1", "k2", "p1", "p2")),
    "OPENCV_FISHEYE": (2, "kannala_brandt", ("k1", "k2", "k3", "k4")),
    "FULL_OPENCV": (2, "brown_conrady", ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")),
    "SIMPLE_RADIAL_FISHEYE": (1, "kannala_brandt", ("k1",)),
    "RADIAL_FISHEYE": (1, "kannala_brandt", ("k1", "k2")),
    "FOV": (2, "fov", ("omega",)),
    "THIN_PRISM_FISHEYE": (
        2,
        "thin_prism_fisheye",
        ("k1", "k2", "p1", "p2", "k3", "k4", "s1", "s2"),
    ),
    "RAD_TAN_THIN_PRISM_FISHEYE": (
        2,
        "rad_tan_thin_prism_fisheye",
        COEFFICIENTS["rad_tan_thin_prism_fisheye"][0],
    ),
    "SIMPLE_FISHEYE": (1, "kannala_brandt", ()),
    "FISHEYE": (2, "kannala_brandt", ()),
    "EUCM": (2, "eucm", ("alpha", "beta")),
    "SIMPLE_DIVISION": (1, "division", ("k",)),
    "DIVISION": (2, "division", ("k",)),
}
# Of a folder with both, the first is read.
FILES = ("cameras.bin", "cameras.txt")
# What its rig_configurator reads.
RIG = "rig_config.json"
# Its numbers are a width and a height.
PANORAMA = "EQUIRECTANGULAR"
# By the number that stands for them in cameras.bin.
NUMBERS = (
    "SIMPLE_PINHOLE",
    "PINHOLE",
    "SIMPLE_RADIAL",
    "RADIAL",
    "OPENCV",
    "OPENCV_FISHEYE",
    "FULL_OPENCV",
    "FOV",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
    "RAD_TAN_THIN_PRISM_FISHEYE",
    "SIMPLE_DIVISION",
    "DIVISION",
    "SIMPLE_FISHEYE",
    "FISHEYE",
    "EUCM",
    PANORAMA,
)


def from_model(name: str, size: tuple[int, int], numbers: list[float]) -> Projection:
    """Return the camera of a COLMAP model with its numbers."""
    if name == PANORAMA:
        if numbers != [size[1], size[0]]:
            raise ValueError(
                f"Expected {PANORAMA} {size[1]} {size[0]} of a whole panorama, got {numbers}."
            )
        return projection(LATLONG)
    if name not in MODELS:
        raise ValueError(
            f"Expected a camera model among {', '.join((*MODELS, PANORAMA))}, got {name!r}, which "
            "has no formula here."
        )
    focals, model, names = MODELS[name]
    if len(numbers) != focals + 2 + len(names):
        raise ValueError(
            f"Expected {focals + 2 + len(names)} numbers of a {name} camera, got {len(numbers)}."
        )
    focal, rest = numbers[:focals], numbers[focals:]
    k = (focal[0], focal[-1], rest[0] - PIXEL_CENTER, rest[1] - PIXEL_CENTER)
    given = dict(zip(names, rest[2:], strict=True))
    if model == "division":
        return _division(k, size, given["k"])
    if model == "pinhole":
        return camera(k, size)
    count = next(
        n for n in COEFFICIENTS[model][1] if n and set(COEFFICIENTS[model][0][:n]) >= set(names)
    )
    distortion = [given.get(c, 0.0) for c in COEFFICIENTS[model][0][:count]]
    return camera(k, size, distortion=distortion, model=model)  # type: ignore[arg-type]


def _division(k: tuple[float, ...], size: tuple[int, int], bend: float) -> Projection:
    """Return the camera whose rays are (a, b, 1 + bend (a² + b²)).

    Source: Fitzgibbon 2001, Simultaneous linear estimation of multiple view geometry and lens
    distortion. Solved for a and b that is 2 (x, y)/(z + √(z² - 4 bend (x² + y²))): the enhanced
    unified model with alpha ½ and beta -4 bend.
    """
    if bend == 0:
        return camera(k, size)
    return camera(k, size, distortion=[0.5, -4 * bend], model="eucm")


def to_model(made: Projection, size: tuple[int, int]) -> tuple[str, list[float]]:
    """Return the COLMAP model of a camera and its numbers."""
    if made == projection(LATLONG):
        return PANORAMA, [float(size[1]), float(size[0])]
    fx, fy, cx, cy = matrix(made, size) if made.name.startswith("camera_") else (0.0,) * 4
    pixels = [fx, fy, cx + PIXEL_CENTER, cy + PIXEL_CENTER]
    c = made.parameters
    if made.name == "camera_pinhole":
        return "PINHOLE", pixels
    if made.name == "camera_kannala_brandt":
        return "OPENCV_FISHEYE", [*pixels, c["k1"], c["k2"], c["k3"], c["k4"]]
    if made.name == "camera_brown_conrady":
        first = [c["k1"], c["k2"], c["p1"], c["p2"]]
        more = [c["k3"], c["k4"], c["k5"], c["k6"]]
        if any(c[name] for name in ("s1", "s2", "s3", "s4", "tau_x", "tau_y")):
            raise ValueError(
                "Expected brown_conrady cameras without a thin prism and a tilt, which no model of "
                "COLMAP's has, got one that has it."
            )
        return (
            ("FULL_OPENCV", [*pixels, *first, *more]) if any(more) else ("OPENCV", pixels + first)
        )
    for model in ("THIN_PRISM_FISHEYE", "RAD_TAN_THIN_PRISM_FISHEYE"):
        if made.name == f"camera_{MODELS[model][1]}":
            return model, [*pixels, *(c[name] for name in MODELS[model][2])]
    if made.name == "camera_fov":
        return "FOV", [*pixels, c["omega"]]
    if made.name == "camera_eucm":
        if c["alpha"] == 0.5 and c["beta"] < 0:
            return "DIVISION", [*pixels, c["beta"] / -4]
        return "EUCM", [*pixels, c["alpha"], c["beta"]]
    raise ValueError(
        "Expected cameras with a model of COLMAP's (pinhole, brown_conrady, kannala_brandt, fov, "
        f"eucm, thin_prism_fisheye, rad_tan_thin_prism_fisheye, or {LATLONG!r}), got "
        f"{made.name!r}."
    )


def read(path: Path) -> Rig:
    """Read cameras.txt or .bin, and images.txt or .bin beside it."""
    if path.is_dir():
        found = [path / name for name in FILES if (path / name).is_file()]
        if not found:
            raise ValueError(
                f"Expected a cameras.txt or a cameras.bin in {path.name!r}, got {_listed(path)}."
            )
        path = found[0]
    binary = path.suffix == ".bin"
    try:
        cameras = dict(_binary_cameras(path.read_bytes()) if binary else _text_cameras(path))
        images = path.with_name(f"images{path.suffix}")
        poses = []
        if images.is_file():
            poses = list(_binary_images(images.read_bytes()) if binary else _text_images(images))
    except (struct.error, IndexError) as error:
        raise ValueError(f"Expected COLMAP's {path.name}, got a file that ends early.") from error
    if not poses:
        return Rig(tuple(View(str(key), *value) for key, value in cameras.items()))
    views = []
    for key, q, t, name in sorted(poses, key=lambda image: image[3]):
        if key not in cameras:
            raise ValueError(f"Expected images of cameras in {path.name}, got camera {key}.")
        with where(f"{images.name!r}, image {name!r}"):
            turn = to_matrix(q)
            views.append(View(name, *cameras[key], turn.T, -turn.T @ np.asarray(t)))
    return Rig(tuple(views))


def _listed(folder: Path) -> str:
    """Say what is in a folder without cameras, and what to do with a rig's."""
    names = sorted(path.name for path in folder.iterdir())
    listed = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "") if names else "nothing"
    if RIG in names:
        listed += (
            f"; {RIG} has no sizes and no places, which COLMAP finds: read the folder of its model"
        )
    return listed


Described = tuple["Projection", tuple[int, int]]


def _described(name: str, width: int, height: int, numbers: list[float]) -> Described:
    return from_model(name, (height, width), numbers), (height, width)


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Return the number and the words of each line of a text that is no remark."""
    try:
        text = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"Expected COLMAP's {path.name}, got a file that holds no text.") from None
    return [(k, line.split()) for k, line in enumerate(text, 1) if not line.startswith("#")]


@contextmanager
def _reading(path: Path, number: int, what: str, words: list[str]) -> Iterator[None]:
    """Say which line has a word in the place of a number, or too few of them."""
    try:
        yield
    except (ValueError, IndexError):
        raise ValueError(
            f"Expected {what} in line {number} of {path.name}, got {' '.join(words)!r:.60}."
        ) from None


def _text_cameras(path: Path) -> Iterator[tuple[int, Described]]:
    for number, words in _lines(path):
        if words:
            with _reading(path, number, "a camera's id, model, width, height and numbers", words):
                key, name, width, height = int(words[0]), words[1], int(words[2]), int(words[3])
                numbers = [float(x) for x in words[4:]]
            yield key, _described(name, width, height, numbers)


def _text_images(path: Path) -> Iterator[tuple[int, list[float], list[float], str]]:
    # A line of an image, then one of its points, which may be empty.
    lines = _lines(path)
    while lines and not lines[0][1]:
        lines.pop(0)
    for number, words in lines[::2]:
        if words:
            with _reading(path, number, "an image's id, pose, camera and name", words):
                numbers, key = [float(x) for x in words[1:8]], int(words[8])
            yield key, numbers[:4], numbers[4:], " ".join(words[9:])


def _binary_cameras(data: bytes) -> Iterator[tuple[int, Described]]:
    (count,) = struct.unpack_from("<Q", data)
    at = 8
    for _ in range(count):
        key, number, width, height = struct.unpack_from("<IiQQ", data, at)
        at += 24
        name = NUMBERS[number] if 0 <= number < len(NUMBERS) else f"number {number}"
        if name in MODELS:
            numbers = MODELS[name][0] + 2 + len(MODELS[name][2])
        else:
            numbers = 2 if name == PANORAMA else 0
        yield (
            key,
            _described(name, width, height, list(struct.unpack_from(f"<{numbers}d", data, at))),
        )
        at += 8 * numbers


def _binary_images(data: bytes) -> Iterator[tuple[int, list[float], list[float], str]]:
    (count,) = struct.unpack_from("<Q", data)
    at = 8
    for _ in range(count):
        _, *pose, key = struct.unpack_from("<I7dI", data, at)
        end = data.index(b"\0", at + 64)
        name = data[at + 64 : end].decode("utf-8", "replace")
        (points,) = struct.unpack_from("<Q", data, end + 1)
        at = end + 9 + 24 * points
        yield key, pose[:4], pose[4:], name


def write(rig: Rig, folder: Path, names: Sequence[Sequence[str]]) -> None:
    """Write rig_config.json and, of one frame, cameras.txt, images.txt and points3D.txt.

    `names` are those of each frame's pictures.
    """
    _write(folder / RIG, [json.dumps([{"cameras": _sensors(rig, names[0])}], indent=2)])
    if len(names) > 1:
        return
    cameras: dict[str, int] = {}
    numbers = []
    for view in rig:
        name, values = to_model(view.camera, view.size)
        height, width = view.size
        line = f"{name} {width} {height} " + " ".join(map(repr, values))
        numbers.append(cameras.setdefault(line, len(cameras) + 1))
    _write(
        folder / "cameras.txt",
        ["# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]"]
        + [f"{number} {line}" for line, number in cameras.items()],
    )
    images = [
        "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME",
        "# POINTS2D[] as (X, Y, POINT3D_ID)",
    ]
    for k, (view, number, name) in enumerate(zip(rig, numbers, names[0], strict=True), 1):
        turn, shift = _world_to_camera(view)
        pose = " ".join(map(repr, [*from_matrix(turn), *shift.tolist()]))
        images += [f"{k} {pose} {number} {name}", ""]
    _write(folder / "images.txt", images)
    _write(folder / "points3D.txt", ["# POINT3D_ID X Y Z R G B ERROR TRACK[]"])


def _sensors(rig: Rig, pictures: Sequence[str]) -> list[dict[str, object]]:
    """Return the rig as COLMAP's rig_configurator takes it: the first view is the reference."""
    sensors: list[dict[str, object]] = []
    for k, (view, prefix) in enumerate(zip(rig, _prefixes(pictures), strict=True)):
        name, values = to_model(view.camera, view.size)
        sensor: dict[str, object] = {"image_prefix": prefix}
        if k == 0:
            first, origin = _world_to_camera(view)
            sensor["ref_sensor"] = True
        else:
            turn, shift = _world_to_camera(view)
            relative = turn @ first.T
            sensor["cam_from_rig_rotation"] = from_matrix(relative)
            sensor["cam_from_rig_translation"] = (shift - relative @ origin).tolist()
        sensor["camera_model_name"] = name
        sensor["camera_params"] = values
        sensors.append(sensor)
    return sensors


def _prefixes(names: Sequence[str]) -> list[str]:
    """Return what tells the pictures of a camera: its folder, or else the name of its only one."""
    parts = [name.rpartition("/") for name in names]
    folders = [folder + slash for folder, slash, _ in parts]
    alike = len({file for *_, file in parts}) == 1
    return folders if alike and len(set(folders)) == len(names) else list(names)


def _world_to_camera(view: View) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    assert view.pose is not None and view.position is not None
    return view.pose.T, -view.pose.T @ view.position + 0.0


def _write(path: Path, lines: list[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
