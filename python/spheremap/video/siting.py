"""Where texels of chroma lie, and planes of them moved to where a map has its texels.

A map's texel i of n lies at (i + ½)/n. So lie texels of luma, and those of chroma that are sited in
the center of what they stand for (JPEG, MPEG-1). MPEG-2 and what came after site them on the left
of it, on a texel of luma: half a texel of luma left of the center, a quarter of one of their own.
Of a latlong, and of any other picture around an axis, such a shift is a small turn of the world:
the turned map has its texels there, and nothing is resampled for it. Else the plane itself is
moved, by four taps along each axis.

On a grid of corners the first and last texels of each plane lie on the edges, as FFmpeg's v360
reads them: there no siting is known.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection
    from .planes import Plane

__all__ = ["SITINGS", "Siting", "cells", "gathered", "moved", "offset", "spread", "turn", "usual"]

Siting: TypeAlias = Literal["left", "center", "top-left"]
SITINGS = ("left", "center", "top-left")
# Of these chroma is sited as in JPEG.
_CENTERED = {"mjpeg", "mpeg1video"}
# Far above rounding, far below what is left where a shift is no turn.
_SAME = 1e-9


def usual(pixel_format: str, codec: str) -> str:
    """Return where chroma lies by the rules of its format: PyAV does not say what a file says."""
    return "center" if pixel_format.startswith("yuvj") or codec in _CENTERED else "left"


def offset(plane: Plane, siting: str) -> tuple[float, float]:
    """Return how far right and down of (i + ½)/n its texels lie, in its own texels."""
    across = (1 / plane.across - 1) / 2 if siting != "center" else 0.0
    down = (1 / plane.down - 1) / 2 if siting == "top-left" else 0.0
    return across, down


def turn(
    p: Projection, shape: tuple[int, int], shift: tuple[float, float]
) -> NDArray[np.float64] | None:
    """Return the rotation that shifts a picture so many texels right and down; None if none does.

    The best one is Kabsch's (1976), and it has to be exact.
    """
    if p.layout is not None:
        return None
    # Off the edges: beyond one lies what is on the other side, or nothing.
    u, v = np.meshgrid(np.linspace(0.1, 0.9, 9), np.linspace(0.1, 0.9, 9))
    uv = np.stack([u, v], -1).reshape(-1, 2)
    before = p.decode(uv)
    after = p.decode(uv + np.array(shift) / [shape[1], shape[0]])
    held = np.isfinite(before).all(-1) & np.isfinite(after).all(-1)
    before, after = before[held], after[held]
    if len(before) < 9:
        return None
    left, _, right = np.linalg.svd(after.T @ before)
    found = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return found if np.abs(before @ found.T - after).max() < _SAME else None


def cells(p: Projection) -> tuple[int, int]:
    """Return how many faces lie below and beside each other: what is across an edge is no neighbor.

    (1, 1) of a picture that is one face.
    """
    rows, columns = p.shape(64)
    return (rows // 64, columns // 64) if p.layout is not None else (1, 1)


def moved(
    plane: NDArray[Any],
    shift: tuple[float, float],
    faces: tuple[int, int] = (1, 1),
    top: int | None = None,
) -> NDArray[Any]:
    """Return the plane whose texel i is what the given one has at i + shift, right and down.

    By Catmull-Rom's cubic (Keys 1981), within each face; what lies beyond its edge is as
    at the edge. Shifts are from -1 to 1.
    """
    if shift[0]:
        plane = _along_rows(plane, shift[0], faces[1], top)
    if shift[1]:
        plane = np.ascontiguousarray(_along_rows(plane.T, shift[1], faces[0], top).T)
    return plane


def _along_rows(plane: NDArray[Any], shift: float, faces: int, top: int | None) -> NDArray[Any]:
    rows, columns = plane.shape
    t = abs(shift)
    # Exact for all offsets that there are: quarters in 128ths, eighths in 1024ths.
    bits = 7 if (4 * t).is_integer() else 10
    weights = {
        -1: round((-t + 2 * t * t - t**3) * 2 ** (bits - 1)),
        1: round((t + 4 * t * t - 3 * t**3) * 2 ** (bits - 1)),
        2: round((t**3 - t * t) * 2 ** (bits - 1)),
    }
    exact: type[Any] = np.int32 if top is not None else np.float32
    if plane.dtype == np.uint8 and bits == 7:
        exact = np.int16
    side = columns // faces
    texels: NDArray[Any] = plane.astype(exact).reshape(rows, faces, side)
    padded = np.pad(texels, ((0, 0), (0, 0), (2, 2)), "edge")
    total = np.zeros_like(texels)
    for distance, weight in weights.items():
        first = 2 + (distance if shift > 0 else -distance)
        # As differences to the texel itself, a sum of bytes stays within 16 bits.
        total += (padded[..., first : first + side] - texels) * exact(weight)
    if top is None:
        texels += total / 2**bits
        return texels.reshape(rows, columns)
    total += 1 << (bits - 1)
    total >>= bits
    total += texels
    return np.clip(total, 0, top, out=total).astype(plane.dtype).reshape(rows, columns)


def spread(
    plane: NDArray[Any], held: Plane, at: tuple[float, float], faces: tuple[int, int]
) -> NDArray[Any]:
    """Return chroma with as many texels as luma, from a plane whose texels lie at an offset."""
    whole = np.repeat(np.repeat(plane, held.down, 0), held.across, 1)
    for row in range(held.down):
        for column in range(held.across):
            # Where a texel of luma lies, from (i + ½)/n of chroma.
            x = (column + 0.5) / held.across - 0.5 - at[0]
            y = (row + 0.5) / held.down - 0.5 - at[1]
            whole[row :: held.down, column :: held.across] = moved(plane, (x, y), faces, held.top)
    return whole


def gathered(plane: NDArray[Any], held: Plane, is_mean: bool) -> NDArray[Any]:
    """Return chroma of luma's size with as few texels as it is held with.

    The mean of those that each stands for, in their center, or the first of them.
    """
    if not is_mean:
        return plane[:: held.down, :: held.across]
    rows, columns = plane.shape
    blocks = plane.reshape(rows // held.down, held.down, columns // held.across, held.across)
    means: NDArray[Any] = np.rint(blocks.mean((1, 3)))
    return means.astype(plane.dtype)
