"""OpenCV's calibrations, as programs write them with FileStorage: YAML 1.0, XML or JSON.

The keys are those of OpenCV's own samples: camera_matrix, distortion_coefficients, image_width,
image_height, fisheye_model; cameraResolution of its interactive-calibration; a stereo pair has M1,
D1, M2, D2. Tutorials mix names, so any of a matrix goes with any of a distortion. The parts of YAML
that FileStorage writes for matrices and numbers are read here, so that neither OpenCV nor a YAML
library is needed.
"""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

import numpy as np

from ..map.cameras import camera
from .views import Rig, View, where

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

__all__ = ["read"]

# A matrix of two or of any number of dimensions, or a sequence; what it holds is in one row.
MATRIX = re.compile(
    r"^\s*(\w+)\s*:\s*(?:!!opencv-(?:nd-)?matrix\s[^\[]*(?:sizes\s*:\s*\[[^\]]*\][^\[]*)?data\s*:\s*)?"
    r"\[([^\]]*)\]",
    re.MULTILINE,
)
NUMBER = re.compile(r"^(\w+)\s*:\s*([-+.\deE]+)\s*$", re.MULTILINE)
# A camera's name, and those of its matrix and of its distortion.
CAMERAS = (
    (
        "camera",
        ("camera_matrix", "Camera_Matrix", "cameraMatrix", "K"),
        (
            "distortion_coefficients",
            "Distortion_Coefficients",
            "distCoeffs",
            "dist_coeffs",
            "dist",
            "D",
        ),
    ),
    ("left", ("M1",), ("D1",)),
    ("right", ("M2",), ("D2",)),
)
WIDTHS = ("image_width", "image_Width", "width")
HEIGHTS = ("image_height", "image_Height", "height")
# Width and height.
RESOLUTION = "cameraResolution"


def read(path: Path) -> Rig:
    """Read a FileStorage file."""
    text = path.read_text(encoding="utf-8")
    start = text.lstrip()[:1]
    found = (_xml if start == "<" else _json if start == "{" else _yaml)(text)

    def number(names: tuple[str, ...]) -> int | None:
        return next((int(found[name][0]) for name in names if name in found), None)

    def one_of(names: tuple[str, ...]) -> str | None:
        # Numbers may be written as is not read here: a name is there without them, too.
        there = [
            x for x in names if x in found or re.search(rf'^\s*[<"]?{x}\b', text, re.MULTILINE)
        ]
        if len(there) > 1:
            raise ValueError(f"Expected one of {' and '.join(there)} in {path.name!r}, got both.")
        if there and there[0] not in found:
            raise ValueError(f"Expected numbers of {there[0]!r} in {path.name!r}, got none.")
        return there[0] if there else None

    width, height = number(WIDTHS), number(HEIGHTS)
    if width is None and height is None and len(found.get(RESOLUTION, ())) == 2:
        width, height = map(int, found[RESOLUTION])
    views = []
    for name, matrices, distortions in CAMERAS:
        matrix = one_of(matrices)
        if matrix is None:
            continue
        if width is None or height is None:
            raise ValueError(
                f"Expected `image_width` and `image_height` in {path.name!r}, got none: make the "
                "camera with `sm.camera(K, size)`."
            )
        distortion = one_of(distortions)
        given = np.zeros(0) if distortion is None else found[distortion]
        fisheye = number(("fisheye_model", "fisheye")) == 1
        if "xi" in found:
            model, given = "unified", np.concatenate([found["xi"][:1], given])
        elif fisheye:
            model = "kannala_brandt"
        elif len(given) == 0 or not given.any():
            model, given = "pinhole", given[:0]
        else:
            model = "brown_conrady"
        size = (height, width)
        if len(found[matrix]) != 9:
            raise ValueError(f"Expected 9 numbers of {matrix!r}, got {len(found[matrix])}.")
        with where(f"{path.name!r}, {matrix}"):
            made = camera(found[matrix].reshape(3, 3), size, distortion=given, model=model)  # type: ignore[arg-type]
        views.append(View(name, made, size))
    if not views:
        raise ValueError(f"Expected a `camera_matrix` of OpenCV in {path.name!r}, got none.")
    return Rig(tuple(views))


def _yaml(text: str) -> dict[str, NDArray[np.float64]]:
    written = [*NUMBER.findall(text), *MATRIX.findall(text)]
    found = {name: _numbers(data) for name, data in written}
    return {name: numbers for name, numbers in found.items() if len(numbers)}


def _xml(text: str) -> dict[str, NDArray[np.float64]]:
    if "<!ENTITY" in text:
        raise ValueError("Expected OpenCV's XML, got one that declares entities.")
    # Rarely asked for, and it takes longer to import than all the rest.
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"Expected OpenCV's XML, got a file that is none: {error}.") from error
    found = {}
    for node in root:
        data = node.findtext("data") or node.text or ""
        if node.get("type_id", "").endswith("matrix") or re.fullmatch(r"[-+.\deE\s]+", data):
            found[node.tag] = _numbers(data)
    return {name: numbers for name, numbers in found.items() if len(numbers)}


def _json(text: str) -> dict[str, NDArray[np.float64]]:
    try:
        nodes = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"Expected OpenCV's JSON, got a file that is none: {error}.") from error
    found = {}
    for name, node in nodes.items():
        data = node.get("data") if isinstance(node, dict) else node
        # Numbers, or rows of them as others write a matrix.
        found[name] = _numbers(re.sub(r"[\[\]]", " ", json.dumps(data)))
    return {name: numbers for name, numbers in found.items() if len(numbers)}


def _numbers(data: str) -> NDArray[np.float64]:
    """Return what is written in a row; a text is none."""
    words = data.replace(",", " ").split()
    try:
        return np.array([float(x) for x in words])
    except ValueError:
        return np.zeros(0)
