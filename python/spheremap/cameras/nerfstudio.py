"""nerfstudio's transforms.json.

Source: nerfstudio's documentation, "Data conventions": transform_matrix takes the camera to the
world, and cameras are OpenGL's, +x right, +y up, -z ahead. cx and cy are COLMAP's, which counts the
center of the first pixel (½, ½). As instant-ngp began it, fields of one frame override the file's.
EQUIRECTANGULAR is a whole panorama whose focal lengths are its height, as in its cameras.py.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from .colmap import PANORAMA, from_model, to_model
from .views import Rig, View, mask_path, picture_path

if TYPE_CHECKING:
    from pathlib import Path

    from .._projection import Projection

__all__ = ["read", "write"]

# OpenGL's camera axes among OpenCV's.
FLIPPED = np.diag([1.0, -1.0, -1.0])
COEFFICIENTS = ("k1", "k2", "k3", "k4", "p1", "p2")
INTRINSICS = ("fl_x", "fl_y", "cx", "cy")


def read(path: Path) -> Rig:
    """Read a transforms.json."""
    try:
        scene = json.loads(path.read_text(encoding="utf-8"))
        frames = scene["frames"]
        views = [_view(scene, frame, k) for k, frame in enumerate(frames)]
    except (json.JSONDecodeError, KeyError, TypeError, IndexError) as error:
        raise ValueError(
            f"Expected nerfstudio's transforms.json, got {path.name!r}: {error!r}."
        ) from error
    return Rig(tuple(views))


def _view(scene: dict[str, Any], frame: dict[str, Any], k: int) -> View:
    both = {**scene, **frame}
    size = (int(both["h"]), int(both["w"]))
    transform = np.asarray(frame["transform_matrix"], float)
    return View(
        str(frame.get("file_path", k)),
        _camera(both, size),
        size,
        transform[:3, :3] @ FLIPPED,
        transform[:3, 3],
    )


def _camera(both: dict[str, Any], size: tuple[int, int]) -> Projection:
    if both.get("camera_model") == PANORAMA:
        return from_model(PANORAMA, size, [float(size[1]), float(size[0])])
    fx = float(both["fl_x"])
    pixels = [fx, float(both.get("fl_y", fx)), float(both["cx"]), float(both["cy"])]
    c = {name: float(both.get(name, 0.0)) for name in COEFFICIENTS}
    model = str(both.get("camera_model", "OPENCV"))
    if model == "OPENCV_FISHEYE":
        numbers = [c["k1"], c["k2"], c["k3"], c["k4"]]
    elif model == "OPENCV" and (c["k3"] or c["k4"]):
        # In nerfstudio k3 and k4 of OPENCV are more powers of the radius; k4 is no denominator.
        if c["k4"]:
            raise ValueError("Expected k4 of an OPENCV camera to be 0, which has no formula here.")
        model = "FULL_OPENCV"
        numbers = [c["k1"], c["k2"], c["p1"], c["p2"], c["k3"], 0.0, 0.0, 0.0]
    elif model == "OPENCV":
        numbers = [c["k1"], c["k2"], c["p1"], c["p2"]]
        if not any(numbers):
            model, numbers = "PINHOLE", []
    elif model in ("PINHOLE", "SIMPLE_PINHOLE"):
        model, numbers = "PINHOLE", []
    else:
        raise ValueError(
            "Expected `camera_model` to be OPENCV, OPENCV_FISHEYE, PINHOLE or EQUIRECTANGULAR, "
            f"got {model!r}, which has no formula here."
        )
    return from_model(model, size, pixels + numbers)


def _fields(model: str, numbers: list[float], size: tuple[int, int]) -> dict[str, Any]:
    """Return what transforms.json says of a camera of COLMAP's."""
    if model == PANORAMA:
        height, width = map(float, size)
        numbers = [height, height, 0.5 * width, 0.5 * height]
        return {"camera_model": PANORAMA, **dict(zip(INTRINSICS, numbers, strict=True))}
    entry = {"camera_model": "OPENCV", **dict(zip(INTRINSICS, numbers[:4], strict=True))}
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


def write(rig: Rig, folder: Path, frame: str, masked: bool) -> None:
    """Write a transforms.json, with the intrinsics in each frame."""
    frames = []
    for view in rig:
        height, width = view.size
        entry: dict[str, Any] = {
            "file_path": picture_path(view, frame),
            **_fields(*to_model(view.camera, view.size), view.size),
            "w": width,
            "h": height,
        }
        if masked:
            entry["mask_path"] = mask_path(view, frame)
        assert view.pose is not None
        transform = np.eye(4)
        transform[:3, :3] = view.pose @ FLIPPED
        transform[:3, 3] = 0.0 if view.position is None else view.position
        entry["transform_matrix"] = (transform + 0.0).tolist()
        frames.append(entry)
    text = json.dumps({"frames": frames}, indent=2)
    (folder / "transforms.json").write_text(text + "\n", encoding="utf-8")
