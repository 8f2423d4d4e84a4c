"""Views mixed band by band: coarse differences over wide seams, fine detail over narrow ones.

Source: Burt and Adelson 1983, A Multiresolution Spline with Application to Image Mosaics. Each view
counts where it has the largest weight. Its Laplacian pyramid is mixed by the pyramid of that area,
level by level: exposure that is not matched is spread over 2⁵ pixels, and detail that does not fit
is not mixed. Levels are the panorama's own `mipmaps`, so that its seams and poles are none here.

Where a view sees nothing, it goes on with what the weighted mean of all views shows: of views that
agree the pyramids are the same, and the result is what they show. Where no view sees anything,
that mean goes on with what it is one level coarser.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..resample import convert, mipmaps

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .._projection import Projection

    # Writes a view in the panorama: its values times their weights, and the weights.
    Layer = Callable[[int, NDArray[Any]], NDArray[Any]]

__all__ = ["banded"]

# Pyramids have one level more.
BANDS = 5


def banded(target: Projection, total: NDArray[Any], count: int, layer: Layer) -> NDArray[Any]:
    """Return `count` views as one image with a weight, in the place of their weighted sum.

    `total`, with one channel more than the views have, is written. Of the result the last channel
    is the sum of the weights, and the others are values times it.
    """
    owner = _owners(total, count, layer)
    weight = total[..., -1].copy()
    seen = weight[..., None] > 0
    mean = np.divide(
        total[..., :-1], weight[..., None], where=seen, out=np.zeros_like(total[..., :-1])
    )
    if not seen.all():
        mean = _filled(_levels(np.concatenate([mean, seen], axis=-1), target), target)
    positive = bool((mean >= 0).all())
    sums: list[NDArray[Any]] = []
    for k in range(count):
        weighted = layer(k, total)
        view = mean.copy()
        np.divide(weighted[..., :-1], weighted[..., -1:], out=view, where=weighted[..., -1:] > 0)
        areas = _levels((owner == k).astype(total.dtype)[..., None], target)
        for i, band in enumerate(_laplacian(_levels(view, target), target)):
            band *= areas[i]
            if k == 0:
                sums.append(band)
            else:
                sums[i] += band
    image = sums.pop()
    while sums:
        image = _finer(image, sums[-1].shape, target) + sums.pop()
    if positive:
        np.maximum(image, 0, out=image)
    total[..., -1] = weight
    np.multiply(image, weight[..., None], out=total[..., :-1])
    return total


def _owners(total: NDArray[Any], count: int, layer: Layer) -> NDArray[np.int32]:
    """Write the weighted sum of all views, and return the one with the largest weight.

    What none sees belongs to the first.
    """
    owner = np.zeros(total.shape[:-1], np.int32)
    layer(0, total)
    best = total[..., -1].copy()
    more = np.empty_like(total) if count > 1 else total
    for k in range(1, count):
        weighted = layer(k, more)
        better = weighted[..., -1] > best
        owner[better] = k
        np.copyto(best, weighted[..., -1], where=better)
        total += weighted
    return owner


def _levels(image: NDArray[Any], target: Projection) -> list[NDArray[Any]]:
    return mipmaps(image, target, any_aspect=True)[: BANDS + 1]


def _filled(levels: list[NDArray[Any]], target: Projection) -> NDArray[Any]:
    """Return means of what is seen, and where nothing is, those of the next level."""
    found = np.zeros_like(levels[-1][..., :-1])
    for level in reversed(levels):
        values, share = level[..., :-1], level[..., -1:]
        found = _finer(found, values.shape, target)
        np.divide(values, share, out=found, where=share > 0)
    return found


def _laplacian(levels: list[NDArray[Any]], target: Projection) -> list[NDArray[Any]]:
    """Return what each level has more than the next one; the last is what it is."""
    bands = [level - _finer(coarser, level.shape, target) for level, coarser in pairwise(levels)]
    return [*bands, levels[-1]]


def _finer(level: NDArray[Any], shape: tuple[int, ...], target: Projection) -> NDArray[Any]:
    """Return a level at the size of the one before it."""
    return convert(
        level, target, target, size=shape[:-1], antialias=False, any_aspect=True, fill=0.0
    )
