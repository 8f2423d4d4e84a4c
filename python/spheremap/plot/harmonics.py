"""`sh`: spherical harmonics as glyphs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .._arrays import as_doubles
from .._scalars import as_whole
from ..light.image import REC709
from ..map.verbs import rotation
from ..sh import evaluate
from .drawing import new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

__all__ = ["sh"]

# Quadrilaterals of a glyph: around, and from pole to pole.
_AROUND, _DOWN = 48, 24
_POSITIVE, _NEGATIVE = (0.85, 0.33, 0.25), (0.25, 0.45, 0.80)
# How the world is turned before it is looked at along -z; toward the light.
_YAW, _PITCH = 30.0, -20.0
_LIGHT = np.array([-0.4, 0.6, 0.7])
# Of a glyph in its cell, which is 1 wide.
_RADIUS = 0.42


def sh(coefficients: ArrayLike, /, *, order: int | None = None, ax: Axes | None = None) -> Axes:
    """Draw spherical harmonic coefficients as glyphs, and the function that they make.

    A glyph reaches as far from its middle as the function is large in that direction: red where it
    is positive, blue where it is negative. Degrees are rows, by one scale; the sum of all is at the
    right, by its own. +y is up, and +z comes toward the reader and to the left.

    Parameters
    ----------
    coefficients : array_like, shape ((order + 1)²,) or ((order + 1)², 3)
        As `spheremap.sh.project` returns; of colors the luminance is drawn.
    order : int, optional
        The highest degree that has a row; by default all up to 4. The sum has all.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError
        For a number of coefficients that is no square, for other channels, for what is not finite,
        and for an order that the coefficients do not have.
    TypeError
        For numbers that are not real.
    ImportError
        If matplotlib is missing.

    Examples
    --------
    >>> import spheremap as sm
    >>> ax = sm.plot.sh([1.0, 0.5, 0, -0.5])
    >>> [text.get_text() for text in ax.texts]
    ['1', '0.5', '0', '-0.5', 'sum']
    """
    numbers = as_doubles(coefficients, "coefficients")
    if numbers.ndim == 2 and numbers.shape[1] in (1, 3):
        numbers = numbers @ np.array(REC709 if numbers.shape[1] == 3 else [1.0])
    highest = math.isqrt(len(numbers)) - 1 if numbers.ndim == 1 else -1
    if highest < 0 or (highest + 1) ** 2 != len(numbers):
        raise ValueError(
            "Expected `coefficients` to have shape ((order + 1)²,) or ((order + 1)², 3), "
            f"got {np.shape(coefficients)}."
        )
    if not np.isfinite(numbers).all():
        raise ValueError("Expected `coefficients` to be finite.")
    last = min(highest, 4) if order is None else as_whole(order, "order")
    if not 0 <= last <= highest:
        raise ValueError(f"Expected `order` from 0 to {highest}, got {last}.")
    ax = new_axes(ax)
    from matplotlib.collections import PolyCollection

    d = _net()
    basis = evaluate(np.eye((last + 1) ** 2), d) * numbers[: (last + 1) ** 2]
    whole = evaluate(numbers, d)
    largest = float(np.abs(basis).max()) or 1.0
    shapes, shades = [], []
    for k, (degree, m) in enumerate((n, m) for n in range(last + 1) for m in range(-n, n + 1)):
        center = (float(m), -1.2 * degree)
        if numbers[k]:
            polygons, colors = _glyph(d, basis[..., k] * (_RADIUS / largest))
            shapes.append(polygons + np.array(center))
            shades.append(colors)
        ax.text(*center, f"{numbers[k]:.3g}", fontsize=7, ha="center", va="bottom").set_y(
            center[1] - 0.68
        )
    size = max(1.0, 0.6 * (last + 1))
    right, middle = last + 0.8 + size / 2, -0.6 * last
    reach = float(np.abs(whole).max())
    if reach:
        polygons, colors = _glyph(d, whole * (size * _RADIUS / reach))
        shapes.append(polygons + np.array([right, middle]))
        shades.append(colors)
    ax.text(right, middle - size / 2 - 0.18, "sum", fontsize=8, ha="center", va="bottom")
    if shapes:
        ax.add_collection(
            PolyCollection(
                list(np.concatenate(shapes)),
                facecolors=np.concatenate(shades),
                edgecolors="face",
                linewidths=0.2,
            )
        )
    ax.set(xlim=(-last - 0.6, right + size / 2 + 0.1), ylim=(-1.2 * last - 0.8, 0.6))
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax


def _net() -> NDArray[np.float64]:
    """Return directions from pole to pole and around, shape (rows, columns, 3)."""
    polar, azimuth = np.meshgrid(
        np.linspace(0, np.pi, _DOWN + 1), np.linspace(0, 2 * np.pi, _AROUND + 1), indexing="ij"
    )
    ring = np.sin(polar)
    return np.stack([ring * np.cos(azimuth), ring * np.sin(azimuth), np.cos(polar)], axis=-1)


def _glyph(
    d: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the polygons of a glyph (N, 4, 2), the farthest first, and their colors (N, 3)."""
    points = np.abs(values)[..., np.newaxis] * d @ rotation(_YAW, 0).T @ rotation(0, -_PITCH).T
    corners = np.stack(
        [points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=-2
    ).reshape(-1, 4, 3)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal /= np.where(length > 0, length, 1.0)
    lit = 0.55 + 0.45 * np.abs(normal @ (_LIGHT / np.linalg.norm(_LIGHT)))
    sign = (values[:-1, :-1] + values[1:, 1:]).reshape(-1, 1)
    colors = np.where(sign >= 0, _POSITIVE, _NEGATIVE) * lit[:, np.newaxis]
    order = np.argsort(corners[..., 2].mean(axis=-1))
    return corners[order][..., :2], colors[order]
