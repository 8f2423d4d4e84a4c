"""An image as the page looks it up: halves with a border, so that no lookup needs a seam.

A face gets a border of one texel that continues it over its seams, by `pad`; four texels around any
place are then a bilinear lookup. Values are scaled by a power of two, which costs no bit, so that
the brightest is near the largest half.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import spatial_axes
from .._srgb import decoded
from .._threads import on_all_threads
from ..map.variants import changed
from ..resample.padding import pad
from .packing import packed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["Texels", "apart", "halves", "light", "own_faces", "shown_channels", "texels"]

BORDER = 1
# What a texel is: outside the valid image, a value, or NaN in some channel.
OUTSIDE, VALUE, MISSING = 0, 1, 2
# The largest half is just below 2^16.
_EXPONENT = 16
# Numbers that a thread takes at a time: what is made on the way stays in its cache.
_BLOCK = 1 << 18


@dataclass(frozen=True)
class Texels:
    """What is sent of an image.

    `words` are halves (F, H, W, 1) or (F, H, W, 3), or places in `table`; `states` says what the
    texels are, or is None where all are values. Light is what the halves say times `gain`.
    """

    words: NDArray[np.uint16] | NDArray[np.uint8]
    states: NDArray[np.uint8] | None
    table: NDArray[np.uint16] | None
    gain: float
    grid: str

    def record(self) -> dict[str, Any]:
        """Return what the page reads: numbers as they are, arrays packed."""
        faces, height, width, channels = self.words.shape
        return {
            "channels": channels,
            "faces": faces,
            "height": height,
            "width": width,
            "gain": self.gain,
            "place": self.place(),
            "words": packed(self.words),
            "table": None if self.table is None else self.table.tolist(),
            "states": None if self.states is None else packed(self.states[..., np.newaxis]),
        }

    def place(self) -> list[float]:
        """Return what takes (u, v) to columns and rows of `words`: two factors and two terms."""
        _, height, width, _ = self.words.shape
        factors, terms = [], []
        for side, corners in (
            (width, self.grid == "corners"),
            (height, self.grid in ("corners", "corners-v")),
        ):
            texels = side - 2 * BORDER
            factors.append(texels - 1.0 if corners else float(texels))
            terms.append(BORDER - (0.0 if corners else 0.5))
        return factors + terms


def own_faces(p: Projection) -> Projection:
    """Return the same map with its faces apart."""
    return p if p.layout in (None, "faces") else changed(p, layout="faces")


def light(pixels: NDArray[Any]) -> NDArray[np.float32]:
    """Return the light of three channels of any dtype: integers are pictures, by the curve of sRGB.

    What float32 does not hold is infinite.
    """
    if pixels.dtype.kind == "u":
        values = pixels.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
        return decoded(values).astype(np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        return pixels.astype(np.float32, copy=False)


def shown_channels(pixels: NDArray[Any], p: Projection) -> NDArray[Any]:
    """Return what is shown of an image with channels last: one channel, or three."""
    if pixels.ndim == spatial_axes(p):
        pixels = pixels[..., np.newaxis]
    # Of two the second is alpha, as of four the fourth.
    return pixels[..., : 3 if pixels.shape[-1] >= 3 else 1]


def apart(pixels: NDArray[Any], p: Projection) -> NDArray[Any]:
    """Return an image of any layout, channels last, as faces (F, H, W, 1) or (F, H, W, 3)."""
    pixels = np.ascontiguousarray(shown_channels(pixels, p))
    if p.layout not in (None, "faces"):
        pixels = pad(pixels, p, 0, any_aspect=True)
    return pixels if pixels.ndim == 4 else pixels[np.newaxis]


def texels(faces: NDArray[Any], p: Projection) -> Texels:
    """Return what is sent of an image whose faces are apart."""
    own = own_faces(p)
    valid = _valid(faces, own)
    bordered = pad(faces if own.faces > 1 else faces[0], own, BORDER, any_aspect=True)
    bordered = bordered if own.faces > 1 else bordered[np.newaxis]
    if bordered.dtype == np.uint8:
        table = light(np.arange(256, dtype=np.uint8))
        words, gain = halves(table)
        return Texels(bordered, valid, words, gain, own.grid)
    states = _missing(bordered, valid)
    values = light(bordered)
    if states is not None:
        values[states != VALUE] = 0
    words, gain = halves(values)
    return Texels(words, states, None, gain, own.grid)


def _valid(faces: NDArray[Any], own: Projection) -> NDArray[np.uint8] | None:
    """Return what holds sphere, with its border; None where everything does."""
    if own.used_part == 1.0:
        return None
    shape = faces.shape[1:3] if own.faces == 1 else faces.shape[:3]
    held = np.isfinite(own.directions(shape, any_aspect=True, dtype=np.float32)[..., 0])
    held = held.reshape(faces.shape[:3]).astype(np.uint8) * VALUE
    return np.pad(held, ((0, 0), (BORDER, BORDER), (BORDER, BORDER)), constant_values=OUTSIDE)


def _missing(bordered: NDArray[Any], valid: NDArray[np.uint8] | None) -> NDArray[np.uint8] | None:
    """Return what texels are where some are NaN."""
    if bordered.dtype.kind != "f":
        return valid
    if not np.isnan(bordered.min()):
        return valid
    missing = np.isnan(bordered).any(axis=-1)
    states = np.full(bordered.shape[:-1], VALUE, np.uint8) if valid is None else valid.copy()
    states[missing & (states == VALUE)] = MISSING
    return states


def halves(values: NDArray[np.float32]) -> tuple[NDArray[np.uint16], float]:
    """Return values as halves, and what those are to be multiplied with."""
    flat = values.reshape(-1)
    starts = range(0, flat.size, _BLOCK)
    tops: list[float] = []
    on_all_threads(lambda start: tops.append(_largest(flat[start : start + _BLOCK])), starts)
    largest = max(tops, default=0.0)
    exponent = math.frexp(largest)[1] - (_EXPONENT - 1) if largest else 0
    # In two steps: one power of two alone may be more than float32 holds.
    first = -exponent // 2
    factors = np.float32(2.0**first), np.float32(2.0 ** (-exponent - first))
    made = np.empty(flat.shape, np.float16)

    def scale(start: int) -> None:
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            scaled = flat[start : start + _BLOCK] * factors[0]
            scaled *= factors[1]
            made[start : start + _BLOCK] = scaled

    on_all_threads(scale, starts)
    return made.reshape(values.shape).view(np.uint16), math.ldexp(1.0, exponent)


def _largest(values: NDArray[np.float32]) -> float:
    """Return the largest absolute value of those that are finite."""
    sizes = np.abs(values)
    largest = float(np.max(sizes, initial=0.0))
    if math.isfinite(largest):
        return largest
    return float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
