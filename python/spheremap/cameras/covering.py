"""Cameras that cover the whole sphere, for cutting a panorama into views."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from .._scalars import as_items, as_number, as_whole
from ..map.cameras import camera
from .views import Rig, View

if TYPE_CHECKING:
    from numpy.typing import NDArray

    # Rows of cameras: how many in each, with its pitch in degrees.
    Rows: TypeAlias = tuple[tuple[int, float], ...]

__all__ = ["rig"]

# Sides that lie on each other, as a cube's, do so to rounding, some 1e-15: parts reach so far, in
# radians, over their sides, and what must be held lies a little farther out, so that no part holds
# its own sides. A hole as narrow is a tenth of the finest pixel, 1 degree in a million of them.
TOUCHING = 1e-9
OUTSIDE = 2e-9
# So many pairs of sides are looked at in one go: 1 MiB.
BLOCK = 1 << 17
# So many rows of cameras are tried.
MOST_ROWS = 14
WIDEST = 170.0
MOST_VIEWS = 500


def rig(
    size: int | tuple[int, int],
    /,
    *,
    n: int | None = None,
    fov: float | None = None,
    overlap: float = 0.2,
) -> Rig:
    """Return pinhole cameras that together see the whole sphere.

    They stand in one place, in rows of equal pitch, in OpenCV's world (+x right, +y down, +z
    ahead). Cut from a panorama, their pictures are what structure from motion and splats take.

    Parameters
    ----------
    size : int or tuple of int
        Height and width of each camera's pictures; one number is a square.
    n : int, optional
        At most so many cameras: their field of view is as narrow as then is possible.
    fov : float, optional
        The horizontal field of view in degrees, up to 170: there are as few cameras as then is
        possible in rows. Give `n` or `fov`.
    overlap : float, optional
        The part of a picture's width and height that neighbors see as well, below 0.9. Every
        direction is in the middle part, so large, of some picture.

    Returns
    -------
    Rig

    Raises
    ------
    ValueError, TypeError
        For both or none of `n` and `fov`, or numbers out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import spheremap as sm
    >>> rig = sm.cameras.rig(800, fov=90, overlap=0)
    >>> len(rig)
    6
    >>> directions = np.random.default_rng(0).normal(size=(1000, 3))
    >>> seen = [view.projection.covers(directions) for view in rig]
    >>> bool(np.any(seen, axis=0).all())
    True

    A point of the panorama in the pixels of a view, and back:

    >>> xy = sm.directions_to_pixels([0.1, 0.2, 1], rig[1].projection, rig[1].size)
    """
    height, width = _height_and_width(size)
    part = as_number(overlap, "overlap")
    if not 0 <= part < 0.9:
        raise ValueError(f"Expected `overlap` to be in [0, 0.9), got {part:g}.")
    if (n is None) is (fov is None):
        raise ValueError("Expected either `n` or `fov`, got " + ("none." if n is None else "both."))
    if fov is not None:
        angle = as_number(fov, "fov")
        if not 1 <= angle <= WIDEST:
            raise ValueError(f"Expected `fov` to be in [1, {WIDEST:g}], got {angle:g}.")
        rows = _rows(angle, height / width, part)
    else:
        count = as_whole(n, "n")
        if not 4 <= count <= MOST_VIEWS:
            raise ValueError(f"Expected `n` to be in [4, {MOST_VIEWS}], got {count}.")
        angle, rows = _narrowest(count, height / width, part)
    if rows is None:
        raise ValueError(
            f"Expected a `fov` and an `overlap` with which {MOST_VIEWS} cameras in {MOST_ROWS} "
            f"rows cover the sphere, got {angle:g} and {part:g}."
        )
    focal = 0.5 * width / math.tan(math.radians(angle) / 2)
    pinhole = camera((focal, focal, (width - 1) / 2, (height - 1) / 2), (height, width))
    poses = _poses(rows)
    digits = max(2, len(str(len(poses) - 1)))
    return Rig(
        tuple(
            View(f"view{k:0{digits}}", pinhole, (height, width), pose, np.zeros(3))
            for k, pose in enumerate(poses)
        )
    )


def _height_and_width(size: object) -> tuple[int, int]:
    if isinstance(size, int | np.integer):
        height = width = as_whole(size, "size")
    else:
        given = [as_whole(x, "size") for x in as_items(size, "size", "whole numbers")]
        if len(given) != 2:
            raise ValueError(f"Expected `size` to be a height and a width, got {len(given)}.")
        height, width = given
    if min(height, width) < 1 or max(height, width) > 1 << 20:
        raise ValueError(f"Expected `size` to be in [1, {1 << 20}], got {(height, width)}.")
    if not 1 / 8 <= height / width <= 8:
        raise ValueError(
            f"Expected `size` to be at most 8 times as long as wide, got {(height, width)}."
        )
    return height, width


def _pose(yaw: float, pitch: float) -> NDArray[np.float64]:
    """Return the camera's right, down and forward as columns; yaw to the right, pitch up."""
    (sy, cy), (sp, cp) = (
        (math.sin(a), math.cos(a)) for a in (math.radians(yaw), math.radians(pitch))
    )
    return np.array(
        [
            [cy, sp * sy, cp * sy],
            # cp, rounded as a cross product.
            [0.0, cp * cy * cy + cp * sy * sy, -sp],
            [-sy, sp * cy, cp * cy],
        ]
    )


def _poses(rows: Rows) -> list[NDArray[np.float64]]:
    return [
        _pose(360 * k / count, pitch) for count, pitch in sorted(rows, key=lambda row: -row[1])
        for k in range(count)
    ]  # fmt: skip


def _sees(poses: list[NDArray[np.float64]], half: tuple[float, float]) -> bool:
    """Tell whether each direction is in the middle part of some view.

    Pieces of the parts' sides bound what no part holds, so there is none where the whole of every
    side, just outside of its own part, is in other parts. The poses are to be those of a rig,
    which is its own mirror image from left to right and from top to bottom.
    """
    a, b = half
    corners = np.array([[-a, -b, 1.0], [a, -b, 1.0], [a, b, 1.0], [-a, b, 1.0]])
    corners /= np.linalg.norm(corners[0])
    inward = np.cross(corners, np.roll(corners, -1, axis=0))
    inward /= np.linalg.norm(inward, axis=-1, keepdims=True)
    starts = corners - OUTSIDE * inward
    stops = np.roll(corners, -1, axis=0) - OUTSIDE * inward
    turns = np.stack(poses).swapaxes(-1, -2)
    sides = (inward @ turns).transpose(1, 2, 0)
    # Of mirror images one is enough: those to the right that do not look down.
    x, y, _ = turns[:, 2].T
    looked_at = turns[(x >= -TOUCHING) & (y <= TOUCHING)]
    step = max(1, BLOCK // (16 * len(turns)))
    return all(
        _hold(sides, (starts @ some).reshape(-1, 3), (stops @ some).reshape(-1, 3))
        for some in np.split(looked_at, range(step, len(looked_at), step))
    )


def _hold(
    sides: NDArray[np.float64], starts: NDArray[np.float64], stops: NDArray[np.float64]
) -> bool:
    """Tell whether parts, of which (4, 3, n) sides are given, together hold the whole of lines."""
    first, last = starts @ sides + TOUCHING, stops @ sides + TOUCHING
    line, part = np.nonzero(np.all(np.maximum(first, last) >= 0, axis=0))
    first, last = first[:, line, part], last[:, line, part]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = first / (first - last)
    # The lines in a row, each as long as 1. A part of which another side is outside leaves before
    # it enters; then others have to hold where it enters as well.
    enters = line + np.where(first < 0, crossing, 0.0).max(0)
    leaves = line + np.where(last < 0, crossing, 1.0).min(0)
    order = np.argsort(enters)
    reached = np.maximum.accumulate(np.append(0.0, leaves[order]))
    return bool(np.all(np.append(enters[order], len(starts)) <= reached))


def _rows(fov: float, tall: float, overlap: float) -> Rows | None:
    """Return rows of few cameras of this field of view that cover the sphere; None for none."""
    tan = math.tan(math.radians(fov) / 2)
    half = (tan * (1 - overlap), tan * tall * (1 - overlap))
    across, down = (2 * math.degrees(math.atan(x)) for x in half)
    best: list[tuple[int, float]] | None = None
    least = max(2, math.floor(180 / down))
    for count in range(least, least + 3):
        if count > MOST_ROWS:
            break
        poles = np.linspace(-90, 90, count) if count > 2 else np.zeros(0)
        for pitches in (poles, (np.arange(count) + 0.5) * 180 / count - 90):
            rows = _reduced([float(p) for p in pitches], across, half, best)
            if rows is not None:
                best = rows
    return None if best is None else tuple(best)


def _reduced(
    pitches: list[float],
    across: float,
    half: tuple[float, float],
    best: list[tuple[int, float]] | None,
) -> list[tuple[int, float]] | None:
    """Return the fewest cameras in rows of these pitches, if they are fewer than the best's."""
    if not pitches:
        return None
    # More than enough, from which cameras are taken: of two rows alike, from both. By twelves:
    # where two of 3, 4 or 6 meet, another row has one in their middle. 360/60 is 6 to rounding.
    full = 12 * math.ceil(120 / across - 1e-9)
    counts = {abs(p): 1 if abs(p) == 90 else full for p in (round(p, 9) for p in pitches)}

    def rows() -> list[tuple[int, float]]:
        return [(counts[abs(round(p, 9))], p) for p in pitches]

    def covered() -> bool:
        return _sees(_poses(tuple(rows())), half)

    if sum(count for count, _ in rows()) > 4 * MOST_VIEWS or not covered():
        return None
    for pitch in sorted(counts, reverse=True):
        if pitch == 90:
            continue
        if across > 50:
            # Not by halves: four views of 90 degrees meet the poles' as a cube does, five do not.
            least = max(2, int(180 * math.cos(math.radians(pitch)) / across))
            most = counts[pitch]
            for count in range(least, most + 1):
                counts[pitch] = count
                if covered():
                    break
        else:
            most = counts[pitch]
            row = math.cos(math.radians(max(pitch - 90 / len(pitches), 0)))
            counts[pitch] = max(3, math.ceil(360 * row / across))
            while counts[pitch] < most and not covered():
                counts[pitch] += 1
            while counts[pitch] > 2 and covered():
                counts[pitch] -= 1
            counts[pitch] = min(counts[pitch] + 1, most)
    total = sum(count for count, _ in rows())
    if total > MOST_VIEWS or (best is not None and total >= sum(count for count, _ in best)):
        return None
    return rows()


def _narrowest(n: int, tall: float, overlap: float) -> tuple[float, Rows | None]:
    """Return the narrowest field of view, to a tenth of a degree, with which `n` are enough."""
    low, high = 100, int(10 * WIDEST)
    found = _rows(high / 10, tall, overlap)
    if found is None or sum(count for count, _ in found) > n:
        raise ValueError(
            f"Expected `n` cameras of at most {WIDEST:g} degrees that cover the sphere with this "
            f"`overlap`, got {n}."
        )
    while low < high:
        middle = (low + high) // 2
        # The middle parts have to hold the sphere: 4 atan(ab/√(1 + a² + b²)) each.
        a = math.tan(math.radians(middle / 20)) * (1 - overlap)
        b = a * tall
        part = 4 * math.atan(a * b / math.sqrt(1 + a * a + b * b))
        rows = _rows(middle / 10, tall, overlap) if n * part >= 4 * math.pi else None
        if rows is not None and sum(count for count, _ in rows) <= n:
            high, found = middle, rows
        else:
            low = middle + 1
    return high / 10, found
