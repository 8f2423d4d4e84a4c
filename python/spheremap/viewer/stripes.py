"""What a still says pixel by pixel: isolines, clipping, what is not held, density, seams."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..io.tonemap import WHITE
from ..light.image import REC709
from .colors import ramped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection

__all__ = ["ASKED", "mark"]

ASKED = ("isolines", "clipping", "valid", "density", "seams")

_BRIGHT, _DARK, _UNKNOWN = (230, 0, 0), (0, 51, 230), (140, 26, 26)
_SEAM = (255, 217, 26)
# Pixels from stripe to stripe, and how wide an isoline is.
_STRIPES, _LINE = 12, 1.4


def mark(
    picture: NDArray[np.uint8],
    light: NDArray[np.float32],
    held: NDArray[np.bool_],
    directions: NDArray[np.float32],
    p: Projection,
    asked: dict[str, bool],
    exposure: float,
    curve: str,
) -> None:
    """Mark a picture with what is asked for; `directions` are those of its pixels."""
    height, width = held.shape
    stripe = np.add.outer(np.arange(height), np.arange(width)) % _STRIPES < _STRIPES // 2
    seen = np.nan_to_num(light, posinf=1e30, neginf=-1e30) * np.float32(2.0**exposure)
    if asked["isolines"]:
        _draw_isolines(picture, seen)
    if asked["clipping"]:
        picture[stripe & held & (seen.max(axis=-1) >= (WHITE if curve != "none" else 1.0))] = (
            _BRIGHT
        )
        picture[stripe & held & (seen.min(axis=-1) < 0)] = _DARK
    on_screen = np.isfinite(directions[..., 0])
    if asked["valid"]:
        picture[stripe & on_screen & ~held] = _UNKNOWN
    if not (asked["density"] or asked["seams"]):
        return
    uv = np.asarray(p.encode(directions), np.float64)
    if asked["density"]:
        mean = p.covered_solid_angle / (p.used_part * p.faces)
        with np.errstate(invalid="ignore", divide="ignore"):
            parts = 2 * np.log2(np.asarray(p.density(uv), np.float64) / mean)
        known = np.isfinite(parts)
        mixed = 0.3 * picture[known] + 0.7 * 255 * ramped(parts[known])
        picture[known] = np.rint(mixed).astype(np.uint8)
    if asked["seams"]:
        picture[_seams(uv) & on_screen] = _SEAM


def _draw_isolines(picture: NDArray[np.uint8], light: NDArray[np.float32]) -> None:
    """Draw lines where stops of luminance are whole, unless they lie too close."""
    luminance = light @ np.array(REC709)
    stops = np.log2(np.maximum(luminance, 1e-12))
    slope = sum(np.abs(np.gradient(stops, axis=axis)) for axis in (0, 1))
    away = np.abs((stops + 0.5) % 1 - 0.5)
    drawn = np.clip(0.5 + 0.5 * _LINE - away / np.maximum(slope, 1e-9), 0, 1)
    drawn *= np.clip(2 - 8 * slope, 0, 1) * (luminance > 0)
    picture[:] = np.rint(picture * (1 - 0.8 * drawn[..., np.newaxis]))


def _seams(uv: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return where an image ends, or goes on elsewhere, between a pixel and the next."""
    found = np.zeros(uv.shape[:-1], bool)
    for axis in (0, 1):
        along = np.moveaxis(uv, axis, 0)
        here, there = along[:-1], along[1:]
        inside = np.isfinite(here[..., 0]), np.isfinite(there[..., 0])
        with np.errstate(invalid="ignore"):
            jump = np.abs(there[..., :2] - here[..., :2])
            edges = (np.minimum(side[..., :2], 1 - side[..., :2]) for side in (here, there))
            # Over an edge of the image there is a fold, whose sides are both as close to it.
            cut = (jump > 0.1).any(axis=-1) | (np.maximum(*edges) < jump).any(axis=-1)
            if uv.shape[-1] == 3:
                cut |= here[..., 2] != there[..., 2]
        cut = (inside[0] & inside[1] & cut) | (inside[0] != inside[1])
        marks = np.moveaxis(found, axis, 0)
        marks[:-1] |= cut
        marks[1:] |= cut
    return found
