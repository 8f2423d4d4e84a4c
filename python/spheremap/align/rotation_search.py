"""The rotation between two images of one scene, from nothing but what they show.

Both are panoramas of log brightness, with a weight for each texel. A grid over all rotations (the
super-Fibonacci spiral of Alexa, CVPR 2022) is tried on panoramas of 11° a texel, by correlation,
which exposure does not change. The best are refined by Gauss and Newton's method on ever finer
panoramas, with Tukey's weights, because what moved between two photos must not pull.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .._progress import counted, part
from ..map.evenly import points
from ..map.named import resolve
from ..resample.verbs import sample

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

# Rotations tried, about 12° apart, and how many of them go on to each finer panorama.
_GRID = 12_000
_KEPT = (24, 8, 3, 2, 1)
_STEPS = 6
# Points at which panoramas are compared: on the grid of rotations, and of each finer panorama.
_FEW = 400
_POINTS = (1500, 3000, 8000, 20_000, 40_000)
# How much of the time the grid takes.
_OF_GRID = 0.7


@dataclass(frozen=True)
class Panorama:
    """A latlong of log brightness (H, 2H) and how much each texel counts, from 0 to 1."""

    brightness: Array
    weight: Array

    def look(self, d: Array) -> tuple[Array, Array]:
        """Return the brightness and the weight in given directions."""
        layers = np.stack([self.brightness * self.weight, self.weight], axis=-1)
        found = np.asarray(sample(layers, d, resolve("latlong")))
        weight = found[..., 1]
        return found[..., 0] / np.maximum(weight, 1e-12), weight


@dataclass(frozen=True)
class Match:
    """A rotation from the second image's frame to the first's, and how well it fits."""

    rotation: Array
    correlation: float
    overlap: float


def search(first: Sequence[Panorama], second: Sequence[Panorama]) -> Match:
    """Return the rotation that fits best; panoramas go from coarse to fine."""
    rotations = _grid()
    d = points(_FEW)
    a, wa = first[0].look(d)
    scores = np.empty(len(rotations))
    with part(0, _OF_GRID):
        for begin in counted(range(0, len(rotations), 500)):
            block = rotations[begin : begin + 500]
            # The rotation takes the second frame to the first: its rows undo that.
            b, wb = second[0].look(np.einsum("rji,nj->rni", block, d))
            scores[begin : begin + 500] = _correlation(a, b, wa * wb)[0]
    order = np.argsort(-scores)
    best = [Match(rotations[i], float(scores[i]), 0.0) for i in order[:400]]
    best = _distinct(best, 0.2)
    with part(_OF_GRID, 1):
        for level, (x, y) in counted([*enumerate(zip(first, second, strict=True))]):
            places = points(_POINTS[min(level, len(_POINTS) - 1)])
            kept = _KEPT[min(level, len(_KEPT) - 1)]
            best = [refined(x, y, match.rotation, places) for match in best[:kept]]
            best.sort(key=lambda match: -match.correlation)
            best = _distinct(best, 0.05)
    return best[0]


def refined(first: Panorama, second: Panorama, rotation: Array, d: Array) -> Match:
    """Return the rotation near this one at which both panoramas differ least."""
    a, wa = first.look(d)
    step = 0.5 * np.pi / len(second.brightness)
    for _ in range(_STEPS):
        b, wb = second.look(d @ rotation)
        slopes = np.empty((len(d), 3))
        for k in range(3):
            turn = rotation_of_vector(step * np.eye(3)[k])
            ahead, _ = second.look(d @ turn @ rotation)
            behind, _ = second.look(d @ turn.T @ rotation)
            slopes[:, k] = (ahead - behind) / (2 * step)
        weight = wa * wb
        total = weight.sum()
        if total < 1e-9:
            break
        error = a - b
        middle = median(error, weight)
        error = error - middle
        spread = 4.685 * 1.4826 * median(np.abs(error), weight) + 1e-9
        weight = weight * np.clip(1 - (error / spread) ** 2, 0, 1) ** 2
        # The exposure is free: a fourth unknown.
        design = np.concatenate([slopes, np.ones((len(d), 1))], axis=1)
        normal = design.T @ (weight[:, None] * design)
        normal += 1e-9 * np.trace(normal) * np.eye(4)
        change = np.linalg.solve(normal, design.T @ (weight * error))[:3]
        length = float(np.linalg.norm(change))
        change *= min(1.0, 6 * step / max(length, 1e-12))
        rotation = rotation_of_vector(change) @ rotation
        if length < 1e-6:
            break
    b, wb = second.look(d @ rotation)
    correlation, overlap = _correlation(a, b, wa * wb)
    return Match(orthogonal(rotation), float(correlation), float(overlap))


def _correlation(a: Array, b: Array, weight: Array) -> tuple[Array, Array]:
    """Return weighted correlations along the last axis, and the mean weight."""
    total = np.maximum(weight.sum(axis=-1, keepdims=True), 1e-12)
    x = a - (weight * a).sum(axis=-1, keepdims=True) / total
    y = b - (weight * b).sum(axis=-1, keepdims=True) / total
    both = (weight * x * y).sum(axis=-1)
    spread = np.sqrt((weight * x * x).sum(axis=-1) * (weight * y * y).sum(axis=-1))
    overlap = weight.mean(axis=-1)
    found = both / np.where(spread > 1e-12, spread, 1)
    return np.where((spread > 1e-12) & (overlap > 0.01), found, -1.0), overlap


def median(values: Array, weights: Array) -> float:
    """Return the value at which half of the weight lies on either side."""
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(share, share[-1] / 2)])


def rotation_of_vector(vector: Array) -> Array:
    """Return the rotation by a vector's length about it (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-15:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k)


def orthogonal(matrix: Array) -> Array:
    """Return the rotation nearest to a matrix."""
    u, _, v = np.linalg.svd(matrix)
    return np.asarray(u @ v)


def _grid() -> Array:
    """Return rotations that cover all of them evenly."""
    s = np.arange(_GRID) + 0.5
    r, q = np.sqrt(s / _GRID), np.sqrt(1 - s / _GRID)
    a, b = 2 * np.pi * s / np.sqrt(2), 2 * np.pi * s / 1.533751168755204288118041413
    x, y, z, w = r * np.sin(a), r * np.cos(a), q * np.sin(b), q * np.cos(b)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _distinct(matches: list[Match], angle: float) -> list[Match]:
    """Leave out what lies within an angle of something better."""
    kept: list[Match] = []
    most = 1 + 2 * np.cos(angle)
    for match in matches:
        if all(np.sum(match.rotation * other.rotation) < most for other in kept):
            kept.append(match)
    return kept
