"""How two lenses back to back are blended, and how far a pixel is from a border: literally.

It imports nothing of the library.
"""

from __future__ import annotations

import numpy as np


def share_of_first(theta: np.ndarray, fov: float) -> np.ndarray:
    """Return how much the first of two equidistant lenses counts, `theta` from its axis; radians.

    A pixel of an equidistant lens is as many radians from the rim as pixels, but for a factor that
    both share. The weight is the square of that.
    """
    first = np.clip(fov / 2 - theta, 0, None)
    second = np.clip(fov / 2 - (np.pi - theta), 0, None)
    return first**2 / (first**2 + second**2)


def signed_distance(mask: np.ndarray, x: float, y: float) -> float:
    """Return how far a place is from the nearest pixel on the other side, by looking at them all.

    Pixels are squares, (x, y) is (0, 0) in the upper left corner; outside the mask it is negative.
    """
    rows, columns = np.mgrid[: mask.shape[0], : mask.shape[1]]
    dx = np.maximum(np.maximum(columns - x, x - columns - 1), 0)
    dy = np.maximum(np.maximum(rows - y, y - rows - 1), 0)
    squared = dx**2 + dy**2
    return float(np.sqrt(squared[~mask].min()) - np.sqrt(squared[mask].min()))


def gains(parts: np.ndarray, ratios: np.ndarray) -> np.ndarray:
    """Return the gains of geometric mean 1 by the normal equations, bordered by the gauge."""
    n = len(parts)
    system, right = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    for i in range(n):
        for j in range(n):
            if i != j:
                part = max(parts[i, j], parts[j, i])
                ratio = ratios[i, j] if parts[i, j] > 0 else -ratios[j, i]
                system[i, i] += part
                system[i, j] -= part
                right[i] -= part * ratio
    system[n, :n] = system[:n, n] = 1
    return np.exp(np.linalg.solve(system, right)[:n])


def gopro_columns(u: float, sidewidth: int, blendwidth: int) -> tuple[float, float, float]:
    """Return where an outer face's u is in both halves of a track, and how much the right counts.

    As MAX2sphere has it, whose blend width is half of what both lenses see.
    """
    duv = blendwidth / sidewidth
    left = 2 * (0.5 - duv) * u
    right = 2 * (0.5 - duv) * (u - 0.5) + 0.5 + duv
    if left <= 0.5 - 2 * duv:
        alpha = 0.0
    elif right >= 0.5 + 2 * duv:
        alpha = 1.0
    else:
        alpha = (left - 0.5 + 2 * duv) / (2 * duv)
    return left * sidewidth, right * sidewidth, alpha
