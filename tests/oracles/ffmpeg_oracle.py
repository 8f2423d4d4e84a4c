"""ffmpeg's v360 filter on 16-bit gray images. The wheel imageio-ffmpeg carries the program."""

from __future__ import annotations

import re
import subprocess
from typing import Any

import numpy as np

from . import need


def program() -> str:
    ffmpeg: Any = need("imageio_ffmpeg")
    return str(ffmpeg.get_ffmpeg_exe())


def version() -> str:
    text = subprocess.run([program(), "-version"], capture_output=True, text=True, check=True)
    found = re.match(r"ffmpeg version n?(\d+(\.\d+)*)", text.stdout)
    assert found, text.stdout[:80]
    return f"ffmpeg {found[1]}"


def v360(image: np.ndarray, source: str, target: str, shape: tuple[int, int]) -> np.ndarray:
    """Turn a (H, W) image of values from 0 to 65535 from one layout into another, bilinearly."""
    height, width = image.shape
    raw = ["-f", "rawvideo", "-pix_fmt", "gray16le"]
    effect = f"v360={source}:{target}:interp=linear:w={shape[1]}:h={shape[0]}"
    command = [program(), "-loglevel", "error", *raw, "-s", f"{width}x{height}", "-i", "-"]
    command += ["-vf", effect, *raw, "-"]
    data = np.rint(image).astype("<u2").tobytes()
    result = subprocess.run(command, input=data, capture_output=True, check=True)
    return np.frombuffer(result.stdout, "<u2").reshape(shape).astype(np.float64)
