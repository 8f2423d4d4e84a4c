"""nerfstudio's transforms.json.

Source: nerfstudio's documentation, "Data conventions", and its nerfstudio_dataparser.py:
transform_matrix takes the camera to the world, cameras are OpenGL's, +x right, +y up, -z ahead, and
the world has +z up: its colmap_to_json raises COLMAP's as is done here. cx and cy are COLMAP's,
which counts the center of the first pixel (½, ½). nerfstudio takes one camera_model for all frames;
what a frame has overrides the file's here, as instant-ngp began it. EQUIRECTANGULAR is a whole
panorama whose focal lengths are its height, as in its cameras.py. NeRF's synthetic scenes
(Mildenhall et al. 2020, load_blender.py) have camera_angle_x alone, and leave .png out.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_doubles
from .colmap import PANORAMA, from_model, to_model
from .views import Rig, View, mask_path, picture_path, unrounded, where

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from .._projection import Projection

__all__ = ["FILE", "read", "write"]

FILE = "transforms.json"
# OpenGL's camera axes among OpenCV's.
FLIPPED = np.diag([1.0, -1.0, -1.0])
# From OpenCV's world, with -y up, to one with +z up.
RAISED = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
COEFFICIENTS = ("k1", "k2", "k3", "k4", "p1", "p2")
INTRINSICS = ("fl_x", "fl_y", "cx", "cy")
# Perspectives, whose coefficients count whatever the name.
PERSPECTIVE = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL")


def read(path: Path) -> Rig:
    """Read a transforms.json, or that of a folder."""
    if path.is_dir():
        path = path / FILE
    try:
        scene = json.loads(path.read_text(encoding="utf-8"))
        frames = list(scene["frames"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(
            f"Expected nerfstudio's transforms.json, got {path.name!r}: {error!r}."
        ) from error
    views = []
    for k, frame in enumerate(frames):
        own = frame if isinstance(frame, dict) else {}
        name = str(own.get("file_path", k))
        with where(f"{path.name!r}, frame {name!r}"):
            if not own:
                raise ValueError(f"Expected fields, got {frame!r}.")
            views.append(_view({**scene, **own}, name, path))
    return Rig(tuple(views))


def _view(fields: dict[str, Any], name: str, path: Path) -> View:
    size = _size(fields, name, path)
    transform = as_doubles(fields.get("transform_matrix"), "transform_matrix")
    if transform.shape not in ((4, 4), (3, 4)):
        raise ValueError(
            f"Expected `transform_matrix` to have shape (4, 4), got {transform.shape}."
        )
    turn = RAISED.T @ unrounded(transform[:3, :3]) @ FLIPPED
    return View(name, _camera(fields, size), size, turn, RAISED.T @ transform[:3, 3])


def _size(fields: dict[str, Any], name: str, path: Path) -> tuple[int, int]:
    """Return height and width: those of the picture where the file has none."""
    if "h" in fields and "w" in fields:
        return int(_number(fields, "h")), int(_number(fields, "w"))
    picture = path.parent / name
    if not picture.suffix:
        picture = picture.with_name(f"{picture.name}.png")
    if not picture.is_file():
        raise ValueError(f"Expected `w` and `h`, or a picture {str(picture)!r} that has a size.")
    # It takes a while, and few files need it.
    from ..io import header

    found = header(picture)
    return found.height, found.width


def _number(fields: dict[str, Any], key: str, default: float | None = None) -> float:
    value = fields.get(key, default)
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise ValueError(f"Expected `{key}` to be a number, got {value!r}.") from None


def _camera(fields: dict[str, Any], size: tuple[int, int]) -> Projection:
    height, width = map(float, size)
    model = fields.get("camera_model", "OPENCV")
    if model == PANORAMA:
        return from_model(PANORAMA, size, [width, height])
    fx = None
    if "fl_x" not in fields and "camera_angle_x" in fields:
        fx = 0.5 * width / math.tan(0.5 * _number(fields, "camera_angle_x"))
    fx = _number(fields, "fl_x", fx)
    pixels = [
        fx,
        _number(fields, "fl_y", fx),
        _number(fields, "cx", 0.5 * width),
        _number(fields, "cy", 0.5 * height),
    ]
    c = {name: _number(fields, name, 0.0) for name in COEFFICIENTS}
    if model == "OPENCV_FISHEYE":
        numbers = [c["k1"], c["k2"], c["k3"], c["k4"]]
    elif model not in PERSPECTIVE:
        raise ValueError(
            f"Expected `camera_model` to be one of {', '.join(PERSPECTIVE)}, OPENCV_FISHEYE and "
            f"{PANORAMA}, got {model!r}, which has no formula here."
        )
    elif c["k4"]:
        # In nerfstudio k3 and k4 are more powers of the radius; k4 is no denominator.
        raise ValueError(f"Expected k4 of {model} to be 0, which has no formula here.")
    elif c["k3"]:
        model = "FULL_OPENCV"
        numbers = [c["k1"], c["k2"], c["p1"], c["p2"], c["k3"], 0.0, 0.0, 0.0]
    else:
        numbers = [c["k1"], c["k2"], c["p1"], c["p2"]]
        model, numbers = ("OPENCV", numbers) if any(numbers) else ("PINHOLE", [])
    return from_model(model, size, pixels + numbers)


def _fields(view: View) -> dict[str, Any]:
    """Return what transforms.json says of a camera."""
    height, width = view.size
    size = {"w": width, "h": height}
    model, numbers = to_model(view.camera, view.size)
    if model == PANORAMA:
        numbers = [float(height), float(height), 0.5 * width, 0.5 * height]
        return {"camera_model": PANORAMA, **dict(zip(INTRINSICS, numbers, strict=True)), **size}
    entry = {"camera_model": "OPENCV", **dict(zip(INTRINSICS, numbers[:4], strict=True)), **size}
    if model == "OPENCV_FISHEYE":
        entry["camera_model"] = model
        entry |= dict(zip(("k1", "k2", "k3", "k4"), numbers[4:], strict=True))
    elif model in ("OPENCV", "FULL_OPENCV"):
        if any(numbers[9:]):
            raise ValueError(
                "Expected brown_conrady cameras without k4, k5, k6: transforms.json has none."
            )
        entry |= dict(zip(("k1", "k2", "p1", "p2", "k3"), numbers[4:9], strict=False))
    elif model != "PINHOLE":
        raise ValueError(
            "Expected cameras with a model of transforms.json's (pinhole, brown_conrady, "
            f"kannala_brandt or a whole panorama), got COLMAP's {model}."
        )
    return entry


def write(rig: Rig, folder: Path, names: Sequence[str], masked: bool) -> None:
    """Write a transforms.json: intrinsics are the file's where all views have the same."""
    cameras = [_fields(view) for view in rig]
    models = sorted({camera.pop("camera_model") for camera in cameras})
    if len(models) > 1:
        raise ValueError(
            "Expected cameras of one model for nerfstudio, whose file has one `camera_model` for "
            f"all, got {' and '.join(models)}."
        )
    shared = cameras[0] if all(camera == cameras[0] for camera in cameras) else {}
    # What one frame has, each has to have.
    every = {} if shared else {key: 0.0 for camera in cameras for key in camera}
    frames = []
    for view, camera, name in zip(rig, cameras, names, strict=True):
        entry: dict[str, Any] = {"file_path": picture_path(name)}
        if not shared:
            entry |= every | camera
        if masked:
            entry["mask_path"] = mask_path(name)
        assert view.pose is not None and view.position is not None
        transform = np.eye(4)
        transform[:3, :3] = RAISED @ view.pose @ FLIPPED
        transform[:3, 3] = RAISED @ view.position
        entry["transform_matrix"] = (transform + 0.0).tolist()
        frames.append(entry)
    text = json.dumps({"camera_model": models[0], **shared, "frames": frames}, indent=2)
    (folder / FILE).write_text(text + "\n", encoding="utf-8")
