"""Circles that a ball's rim may be: the edges of a small picture vote for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

# Radii that a ball may have, in shorter sides of the photo.
_LEAST, _MOST = 0.06, 0.75
# Circles that are returned.
_TRIED = 6


def circles(image: Array, edges: NDArray[np.bool_]) -> list[tuple[float, float, float]]:
    """Return likely circles (x, y, radius) in pixels, the best first."""
    height, width = image.shape
    gy, gx = np.gradient(image)
    rows, columns = np.nonzero(edges)
    if len(rows) < 20:
        return []
    norm = np.maximum(np.hypot(gx, gy), 1e-12)
    ux, uy = (gx / norm)[rows, columns], (gy / norm)[rows, columns]
    x, y = columns + 0.5, rows + 0.5
    least, most = _LEAST * min(height, width), _MOST * min(height, width)
    radii = np.arange(least, most, 1.0)
    # Votes for centers on a grid of two pixels, at both ends of the gradient.
    cells = np.zeros((height // 2 + 1, width // 2 + 1))
    for sign in (-1.0, 1.0):
        cx = ((x[:, None] + sign * ux[:, None] * radii) / 2).astype(np.intp)
        cy = ((y[:, None] + sign * uy[:, None] * radii) / 2).astype(np.intp)
        inside = (cx >= 0) & (cy >= 0) & (cx < cells.shape[1]) & (cy < cells.shape[0])
        flat = (cy * cells.shape[1] + cx)[inside]
        # A center that is far away is hit by chance as often as one that is near.
        cells += np.bincount(flat, minlength=cells.size).reshape(cells.shape)
    votes = _blurred(cells)
    found: list[tuple[float, float, float, float]] = []
    for _ in range(4 * _TRIED):
        row, column = np.unravel_index(int(np.argmax(votes)), votes.shape)
        if votes[row, column] <= 0:
            break
        cx0, cy0 = 2.0 * column + 1, 2.0 * row + 1
        votes[max(row - 4, 0) : row + 5, max(column - 4, 0) : column + 5] = 0
        found += _radii(x - cx0, y - cy0, ux, uy, cx0, cy0, least, most)
    found.sort(key=lambda entry: -entry[3])
    return [(cx, cy, r) for cx, cy, r, _ in found[:_TRIED]]


def _radii(
    dx: Array, dy: Array, ux: Array, uy: Array, cx: float, cy: float, least: float, most: float
) -> list[tuple[float, float, float, float]]:
    """Return the circles around a center on which most edges lie, and how complete they are."""
    r = np.hypot(dx, dy)
    aligned = np.abs(dx * ux + dy * uy) > 0.94 * r
    near = aligned & (r > least) & (r < most)
    if not near.any():
        return []
    sector = np.floor((np.arctan2(dy, dx) / (2 * np.pi) + 0.5) * 72).astype(np.intp) % 72
    # Sectors of 5° in which a circle of each radius, ±1.5 %, has an edge.
    best = []
    steps = np.geomspace(least, most, max(2, int(np.log(most / least) / 0.015)))
    hits = np.zeros((len(steps), 72), np.bool_)
    index = np.round(np.log(r[near] / least) / 0.015).astype(np.intp)
    for shift in (-1, 0, 1):
        hits[np.clip(index + shift, 0, len(steps) - 1), sector[near]] = True
    complete = hits.mean(axis=1) * steps**0.25
    for _ in range(2):
        k = int(np.argmax(complete))
        best.append((cx, cy, float(steps[k]), float(complete[k])))
        complete[max(k - 4, 0) : k + 5] = 0
    return best


def _blurred(cells: Array) -> Array:
    for axis in (0, 1):
        for _ in range(2):
            cells = (np.roll(cells, 1, axis) + cells + np.roll(cells, -1, axis)) / 3
    return cells
