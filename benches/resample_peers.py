"""Other programs that turn one projection into another, each as a call without arguments.

A program that is not installed is None here. All are told the same frame: images that look along
-z, +x to the right, +y up, the defaults of `latlong` and `angular`; a cube's faces are in OpenGL's
order and are turned into what each program stores.
"""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

try:
    import cv2
except ImportError:
    cv2 = None
try:
    import py360convert as _py360
except ImportError:
    _py360 = None
try:
    import envmap as _skylibs
except ImportError:
    _skylibs = None
try:
    import imageio_ffmpeg as _ffmpeg
except ImportError:
    _ffmpeg = None

Call = Callable[[], object]


def versions() -> str:
    names = ("opencv-python-headless", "py360convert", "skylibs", "imageio-ffmpeg")
    found = []
    for name in names:
        try:
            found.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            found.append(f"no {name}")
    return ", ".join(found)


# --- coordinates in numpy, as a user of cv2.remap writes them


def numpy_directions(dst: str, shape: tuple[int, ...]) -> np.ndarray:
    height, width = shape[-2:]
    u = (np.arange(width, dtype=np.float32) + np.float32(0.5)) / np.float32(width)
    v = (np.arange(height, dtype=np.float32)[:, None] + np.float32(0.5)) / np.float32(height)
    if dst == "latlong":
        longitude, theta = (u * 2 - 1) * np.float32(np.pi), v * np.float32(np.pi)
        sin = np.sin(theta)
        d = (sin * np.sin(longitude), np.cos(theta) + 0 * u, -sin * np.cos(longitude))
        return np.stack(d, -1)
    p, q = 2 * u - 1 + 0 * v, 2 * v - 1 + 0 * u
    if dst == "angular":
        r = np.hypot(p, q)
        angle = np.where(r <= 1, r, np.nan) * np.float32(np.pi)
        scale = np.sin(angle) / np.maximum(r, np.float32(1e-12))
        return np.stack([p * scale, -q * scale, -np.cos(angle)], -1)
    one = np.ones_like(p)
    table = [(one, -q, -p), (-one, -q, p), (p, one, q), (p, -one, -q), (p, -q, one), (-p, -q, -one)]
    d = np.stack([np.stack(face, -1) for face in table])
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def numpy_maps(
    src: str, dst: str, source_shape: tuple[int, ...], shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return float32 columns and rows of the source, the faces of a cube one below the other."""
    d = numpy_directions(dst, shape)
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    height, width = source_shape[-2:]
    if src == "latlong":
        u = np.arctan2(x, -z) * np.float32(0.5 / np.pi) + np.float32(0.5)
        v = np.arccos(np.clip(y, -1, 1)) * np.float32(1 / np.pi)
        columns, rows = u * width - np.float32(0.5), v * height - np.float32(0.5)
    else:
        ax, ay, az = np.abs(x), np.abs(y), np.abs(z)
        on_x = (ax >= ay) & (ax >= az)
        on_y = ~on_x & (ay >= az)
        major = np.where(on_x, ax, np.where(on_y, ay, az))
        p = np.where(on_x, np.where(x > 0, -z, z), np.where(on_y, x, np.where(z > 0, x, -x)))
        q = np.where(on_y, np.where(y > 0, z, -z), -y)
        negative = np.where(on_x, x < 0, np.where(on_y, y < 0, z < 0))
        face = np.where(on_x, 0, np.where(on_y, 2, 4)) + negative
        columns = (p / major + 1) * np.float32(width / 2) - np.float32(0.5)
        rows = (q / major + 1) * np.float32(height / 2) - np.float32(0.5)
        rows = np.clip(rows, 0, height - 1) + face * height
    flat = (-1, shape[-1])
    return (
        np.ascontiguousarray(columns.reshape(flat), np.float32),
        np.ascontiguousarray(rows.reshape(flat), np.float32),
    )


def cv2_remap(image, maps, shape, filter: str, threads: int) -> Call:
    flag = {
        "nearest": cv2.INTER_NEAREST,
        "bilinear": cv2.INTER_LINEAR,
        "bicubic": cv2.INTER_CUBIC,
    }[filter]
    cv2.setNumThreads(threads)
    flat = image.reshape(-1, *image.shape[-2:])
    x, y = (m.reshape(-1, shape[-1]) for m in maps)
    out = np.empty((*x.shape, image.shape[-1]), image.dtype)
    return lambda: cv2.remap(flat, x, y, flag, out, cv2.BORDER_WRAP)


# --- py360convert: F R B L U D, a latlong that looks along its +z with x to the right

_FACES = ("F", "R", "B", "L", "U", "D")


def _to_py360(cube: np.ndarray) -> list[np.ndarray]:
    """OpenGL's faces as py360convert sees them from inside, looking along -z."""
    right, left, up, down, back, front = cube
    mirrored = [f[:, ::-1] for f in (front, right, back, left)]
    return [*mirrored, up[::-1], down[::-1]]


def _from_py360(faces: list[np.ndarray]) -> np.ndarray:
    front, right, back, left, up, down = faces
    sides = [f[:, ::-1] for f in (right, left)]
    return np.stack([*sides, up[::-1], down[::-1], back[:, ::-1], front[:, ::-1]])


def _py360_call(image, src, dst, shape, filter: str) -> Call | None:
    if image.dtype != np.float32 and image.dtype != np.uint8:
        return None
    if (src, dst) == ("latlong", "cube"):
        return lambda: _from_py360(
            _py360.e2c(image, face_w=shape[-1], mode=filter, cube_format="list")
        )
    if (src, dst) == ("cube", "latlong"):
        faces = [np.ascontiguousarray(f) for f in _to_py360(image)]
        height, width = shape
        return lambda: _py360.c2e(faces, height, width, mode=filter, cube_format="list")
    return None


py360convert = None if _py360 is None else _py360_call


# --- skylibs: its latlong and angular are in our frame


def _skylibs_call(image, src, dst, shape) -> Call | None:
    if "cube" in (src, dst):
        return None
    return lambda: _skylibs.EnvironmentMap(image, src).convertTo(dst, shape[-2]).data


skylibs = None if _skylibs is None else _skylibs_call


# --- ffmpeg: a file of one frame, looped; the time of nine more frames


_FORMATS = {"latlong": "e", "cube": "c1x6", "angular": "fisheye"}


class Ffmpeg:
    """The filter v360 on 8-bit frames. `path` is None where ffmpeg is not installed."""

    def __init__(self, image, src: str, dst: str, shape, threads: int) -> None:
        self.path = None if _ffmpeg is None else _ffmpeg.get_ffmpeg_exe()
        planes = image.reshape(-1, *image.shape[-2:])
        self.planes, self.threads = planes, threads
        height, width = shape[-2] * (6 if dst == "cube" else 1), shape[-1]
        output = f"output={_FORMATS[dst]}:w={width}:h={height}:interp=linear"
        if dst == "angular":
            output += ":h_fov=360:v_fov=360"
        self.filter = f"v360=input={_FORMATS[src]}:{output}"

    def __enter__(self) -> Ffmpeg:
        handle, name = tempfile.mkstemp(suffix=".rgb")
        os.close(handle)
        self.file = Path(name)
        # Planar, as the filter works: the conversion of pixel formats is not what is timed.
        self.file.write_bytes(np.ascontiguousarray(self.planes[..., [1, 2, 0]].transpose(2, 0, 1)))
        return self

    def __exit__(self, *_: object) -> None:
        self.file.unlink()

    def run(self, frames: int) -> float:
        height, width = self.planes.shape[:2]
        command = [str(self.path), "-v", "error", "-filter_threads", str(self.threads)]
        command += [
            "-f",
            "rawvideo",
            "-pix_fmt",
            "gbrp",
            "-s",
            f"{width}x{height}",
            "-i",
            str(self.file),
        ]
        command += ["-vf", f"loop=loop={frames - 1}:size=1,{self.filter}", "-f", "null", "-"]
        start = time.perf_counter()
        subprocess.run(command, check=True, stdin=subprocess.DEVNULL)
        return time.perf_counter() - start

    def seconds(self) -> float:
        """Return the time of a frame: what nine more take, the least of three tries."""
        return max(min((self.run(10) - self.run(1)) / 9 for _ in range(3)), 0.0)
