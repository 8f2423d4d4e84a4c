"""Videos of a turning sky, rendered plane by plane at the places where texels lie."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import spheremap as sm

Planes = list[np.ndarray]
RATIOS = {"yuv420p": (2, 2), "yuv422p": (2, 1), "yuv444p": (1, 1)}


def sky(d: np.ndarray) -> np.ndarray:
    """Return three values from 0 to 1, with waves of about 20°."""
    x, y, z = np.moveaxis(np.nan_to_num(d), -1, 0)
    waves = [
        np.sin(9 * x + 4 * y + 1) * np.cos(7 * z),
        np.sin(8 * y - 5 * z + 2) * np.cos(6 * x),
        np.sin(10 * z + 3 * x) * np.cos(5 * y + 1),
    ]
    return 0.5 + 0.45 * np.stack(waves, -1)


def turning(k: int) -> np.ndarray:
    """Return how the sky is turned in frame k."""
    return sm.rotation(7.0 * k, 3.0 * k)


def rendered(
    p: sm.Projection | str,
    shape: tuple[int, int],
    k: int,
    kind: str,
    at: tuple[float, float] = (-0.25, 0),
) -> Planes:
    """Return the planes of frame k; chroma lies `at` of its texels right of and below centers."""
    p = sm.projection(p) if isinstance(p, str) else p
    bits = 10 if kind.endswith("10le") else 8
    across, down = RATIOS[kind.removesuffix("10le")]
    planes = []
    for channel in range(3):
        rows, columns = shape if channel == 0 else (shape[0] // down, shape[1] // across)
        x, y = at if channel and across > 1 else (0, 0)
        u, v = (np.arange(columns) + 0.5 + x) / columns, (np.arange(rows) + 0.5 + y) / rows
        d = p.decode(np.stack(np.meshgrid(u, v), -1))
        black, span = (128, 224) if channel else (16, 219)
        value = 16 + span * sky(d @ turning(k))[..., channel]
        value = np.where(np.isnan(d[..., 0]), black, value)
        planes.append(np.rint(value * 2 ** (bits - 8)).astype(np.uint8 if bits == 8 else np.uint16))
    return planes


def arrays(frame: av.VideoFrame) -> Planes:
    """Return copies of the planes of a frame."""
    wide = frame.format.components[0].bits > 8
    found = []
    for plane in frame.planes:
        flat = np.frombuffer(plane, np.uint16 if wide else np.uint8)
        rows = flat.reshape(plane.height, -1)
        found.append(rows[:, : plane.width].copy())
    return found


def film(
    path: Path,
    frames: Sequence[Planes],
    kind: str = "yuv420p",
    *,
    codec: str = "ffv1",
    options: dict[str, str] | None = None,
    times: Sequence[int] | None = None,
    audio: bool = False,
) -> Path:
    """Write frames, 25 a second or at times in 1/90000 s, without loss by default."""
    with av.open(str(path), "w") as file:
        height, width = frames[0][0].shape
        stream = file.add_stream(codec, rate=25, width=width, height=height, options=options or {})
        stream.pix_fmt = kind
        stream.codec_context.time_base = Fraction(1, 90000)
        sound = file.add_stream("aac", rate=48000) if audio else None
        for k, planes in enumerate(frames):
            frame = av.VideoFrame(width, height, kind)
            for held, plane in zip(frame.planes, planes, strict=True):
                row = held.line_size // plane.itemsize
                padded = np.zeros((held.height, row), plane.dtype)
                padded[:, : held.width] = plane
                held.update(padded.tobytes())
            frame.pts = 3600 * k if times is None else times[k]
            frame.time_base = Fraction(1, 90000)
            file.mux(stream.encode(frame))
        file.mux(stream.encode(None))
        if sound is not None:
            _hum(file, sound, len(frames) / 25)
    return path


def _hum(file: Any, stream: Any, seconds: float) -> None:
    wave = np.sin(np.arange(int(48000 * seconds)) * (2 * np.pi * 440 / 48000)).astype(np.float32)
    for first in range(0, len(wave), 1024):
        frame = av.AudioFrame.from_ndarray(wave[None, first : first + 1024], "fltp", "mono")
        frame.sample_rate, frame.pts = 48000, first
        file.mux(stream.encode(frame))
    file.mux(stream.encode(None))


def read(path: Path) -> list[Planes]:
    """Return the planes of all frames."""
    with av.open(str(path)) as file:
        return [arrays(frame) for frame in file.decode(video=0)]


def times(path: Path) -> list[Fraction]:
    """Return when each frame is shown, in seconds."""
    with av.open(str(path)) as file:
        return [frame.pts * frame.time_base for frame in file.decode(video=0)]


def sounds(path: Path) -> list[tuple[Fraction, bytes]]:
    """Return when each packet of audio is heard, and what it holds."""
    with av.open(str(path)) as file:
        stream = file.streams.audio[0]
        packets = [p for p in file.demux(stream) if p.dts is not None]
        return [(p.pts * p.time_base, bytes(p)) for p in packets]


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    """Return the peak signal-to-noise ratio of bytes in decibels."""
    error = np.mean((a.astype(float) - b.astype(float)) ** 2)
    return float(10 * np.log10(255**2 / error))
