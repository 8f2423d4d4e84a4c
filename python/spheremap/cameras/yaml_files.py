"""What Kalibr and ROS write in YAML, which PyYAML reads.

Sources: Kalibr's wiki, "Yaml formats" and "Supported models"; ROS's sensor_msgs/CameraInfo and
camera_calibration_parsers. Both count pixels as OpenCV does.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.cameras import camera
from .views import Rig, View, where

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["read_kalibr", "read_ros"]

# Kalibr's camera and distortion model: ours, and how many intrinsics come before fu, fv, pu, pv.
KALIBR = {
    ("pinhole", "none"): ("pinhole", 0),
    ("pinhole", "radtan"): ("brown_conrady", 0),
    ("pinhole", "equidistant"): ("kannala_brandt", 0),
    ("pinhole", "fov"): ("fov", 0),
    ("omni", "none"): ("unified", 1),
    ("omni", "radtan"): ("unified", 1),
    ("eucm", "none"): ("eucm", 2),
    ("ds", "none"): ("double_sphere", 2),
}
ROS = {
    "plumb_bob": "brown_conrady",
    "rational_polynomial": "brown_conrady",
    "equidistant": "kannala_brandt",
    "fisheye": "kannala_brandt",
    # Drivers say so of lenses without distortion.
    "": "pinhole",
    "none": "pinhole",
}


def read_kalibr(path: Path) -> Rig:
    """Read a camchain: poses are those in the first camera's frame."""
    chain = _load(path)
    views = []
    # From the first camera to this one: T_cn_cnm1 is from the one before.
    to_here = np.eye(4)
    try:
        names = sorted(
            (key for key in chain if key.startswith("cam")), key=lambda key: int(key[3:])
        )
        for k, name in enumerate(names):
            entry = chain[name]
            with where(f"{path.name!r}, {name}"):
                if k > 0:
                    to_here = np.asarray(entry["T_cn_cnm1"], float).reshape(4, 4) @ to_here
                turn = to_here[:3, :3]
                made, size = _kalibr_camera(entry)
                views.append(View(name, made, size, turn.T, -turn.T @ to_here[:3, 3] + 0.0))
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"Expected a camchain of Kalibr, got {path.name!r}: {error!r}.") from error
    if not views:
        raise ValueError(f"Expected cam0 and more in {path.name!r}, got none.")
    return Rig(tuple(views))


def _kalibr_camera(entry: dict[str, Any]) -> tuple[Any, tuple[int, int]]:
    kind = (str(entry["camera_model"]), str(entry.get("distortion_model", "none")))
    if kind not in KALIBR:
        known = ", ".join("-".join(pair) for pair in KALIBR)
        raise ValueError(
            f"Expected a camera among {known}, got {'-'.join(kind)}, which has no formula here."
        )
    model, own = KALIBR[kind]
    numbers = [float(x) for x in entry["intrinsics"]]
    if len(numbers) != own + 4:
        raise ValueError(f"Expected {own + 4} intrinsics of {kind[0]}, got {len(numbers)}.")
    coefficients = [] if kind[1] == "none" else [float(x) for x in entry["distortion_coeffs"]]
    width, height = (int(n) for n in entry["resolution"])
    size = (height, width)
    distortion = [*numbers[:own], *coefficients]
    return camera(numbers[own:], size, distortion=distortion, model=model), size  # type: ignore[arg-type]


def read_ros(path: Path) -> Rig:
    """Read a CameraInfo: the file of camera_calibration, or the message as it is printed."""
    info = _load(path)
    try:
        if "camera_matrix" in info:
            size = (int(info["image_height"]), int(info["image_width"]))
            numbers = info["camera_matrix"]["data"]
            given = [float(x) for x in info["distortion_coefficients"]["data"]]
        else:
            # Of ROS 1 and of ROS 2.
            size = (int(info["height"]), int(info["width"]))
            numbers = info["K"] if "K" in info else info["k"]
            given = [float(x) for x in (info["D"] if "D" in info else info["d"])]
        k = np.asarray(numbers, float).reshape(3, 3)
        name = str(info.get("distortion_model", "plumb_bob")).lower()
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"Expected ROS's CameraInfo, got {path.name!r}: {error!r}.") from error
    if name not in ROS:
        raise ValueError(
            f"Expected a distortion model among {', '.join(filter(None, ROS))}, got {name!r}, "
            "which has no formula here."
        )
    if not k.any():
        raise ValueError(f"Expected a calibrated camera in {path.name!r}, got a K of zeros.")
    # A message has room for plumb_bob's five: zeros after those of other models are none.
    count = {"kannala_brandt": 4, "pinhole": 0}.get(ROS[name], len(given))
    distortion = given if any(given[count:]) else given[:count]
    with where(repr(path.name)):
        made = camera(k, size, distortion=distortion, model=ROS[name])  # type: ignore[arg-type]
    header = info.get("header")
    frame = header.get("frame_id") if isinstance(header, dict) else None
    return Rig((View(str(info.get("camera_name") or frame or "camera"), made, size),))


def _load(path: Path) -> dict[str, Any]:
    try:
        yaml = import_module("yaml")
    except ImportError:
        raise ImportError(
            "Kalibr's and ROS's files are YAML, which PyYAML reads: pip install spheremap[cameras]"
        ) from None
    text = path.read_text(encoding="utf-8")
    try:
        # A message that is printed is followed by a line that begins the next one.
        loaded = next(yaml.safe_load_all(text), None)
    except yaml.YAMLError as error:
        raise ValueError(f"Expected YAML in {path.name!r}, got a file that is none.") from error
    if not isinstance(loaded, dict):
        raise ValueError(f"Expected a mapping in {path.name!r}, got {type(loaded).__name__}.")
    return loaded
