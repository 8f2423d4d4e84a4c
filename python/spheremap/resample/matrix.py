"""Conversions as sparse matrices, for programs that regrid by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .plans import expect_options, remap_plan

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.sparse import csr_matrix

    from .._arrays import Size
    from ..map.named import ProjectionLike

    Floats = NDArray[np.float64]
    Places = NDArray[np.int64]

__all__ = ["weights_matrix"]

# Numbers of an image with channels that is converted at a time: 32 MiB.
_NUMBERS = 1 << 22

# Options of `convert` that are none of a matrix.
_REFUSED = ("fill", "alpha", "skipna", "channels_first", "window")

# What a conversion's rounding may make of a number near 1.
_ROUNDING = 1e-9


def weights_matrix(
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size,
    source_shape: tuple[int, ...],
    rotation: Any | None = None,
    **options: Any,
) -> csr_matrix:
    """Return a conversion as a sparse matrix: how much of each texel is in each.

    Parameters
    ----------
    src, dst : Projection or str
        The projection of the images, and that of the results.
    size : int or tuple of int
        The size of the result, as for `convert`.
    source_shape : tuple of int
        The shape of the images without channels.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the world of `src`.
    **options
        ``filter``, ``world`` and ``antialias`` as for `convert`: ``filter="area"`` gives the
        weights of conservative remapping.

    Returns
    -------
    matrix : scipy.sparse.csr_matrix of float64, shape (texels of the result, texels of the source)
        Both counted as in memory: ``matrix @ image.ravel()`` is the raveled result, to rounding.
        Rows sum to 1, but those of texels that see nothing of the source are empty.

    Raises
    ------
    ValueError, TypeError
        As for `convert`; ValueError for options with which a conversion is no matrix.
    ImportError
        If scipy is missing.

    Notes
    -----
    The weights are found by converting: images of which a few texels, far apart, are 1 and all
    others 0, and again more closely where texels that were thought to be far apart meet, as
    beside the poles of a latlong. It costs some hundred conversions where texels see tens of
    others, and thousands where one texel sees thousands. For one image `convert` is faster.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> options = {"size": 2, "filter": "area"}
    >>> matrix = sm.weights_matrix("latlong", "healpix", source_shape=(8, 16), **options)
    >>> field = np.random.default_rng(0).random((8, 16))
    >>> faces = sm.convert(field, "latlong", "healpix", **options)
    >>> matrix.shape, bool(np.allclose(matrix @ field.ravel(), faces.ravel()))
    ((48, 128), True)
    """
    try:
        from scipy.sparse import csr_matrix
    except ImportError:
        raise ImportError("`weights_matrix` needs scipy: pip install scipy", name="scipy") from None
    for name in _REFUSED:
        if name in options:
            raise ValueError(
                f"`{name}` is no option of a matrix: its weights are those of all texels, and of "
                "nothing else."
            )
    expect_options(options, "weights_matrix", _REFUSED)
    given = options.get("filter")
    if isinstance(given, str) and given == "mode":
        raise ValueError("`filter='mode'` is no matrix: it adds no texels up.")
    plan = remap_plan(src, dst, size=size, source_shape=source_shape, rotation=rotation, **options)
    shape = plan.source_shape
    if shape is None:
        raise TypeError("Expected `source_shape` to be a shape, got None.")

    def convert(channels: Floats) -> Floats:
        return plan(channels.reshape(*shape, -1)).reshape(targets, -1)

    targets = math.prod(plan.shape)
    return csr_matrix(weights_of(convert, shape, targets), shape=(targets, math.prod(shape)))


def weights_of(
    convert: Callable[[Floats], Floats], shape: tuple[int, ...], targets: int
) -> tuple[Floats, tuple[Places, Places]]:
    """Return the weights, rows and columns of what makes sums of texels of an image.

    `convert` takes the image as (texels, channels) and gives (targets, channels).
    """
    sources = math.prod(shape)
    # Numbers that no two texels have, nor means of them: they tell a texel from several.
    marks = np.random.default_rng(0).random(sources) + 1
    want = convert(marks[:, None])[:, 0]
    found = _Found(targets)
    for period in (6, 12, 24):
        rows = found.missing(marks, want)
        if not len(rows) or period**2 > sources:
            break
        _apart(convert, _colors(shape, period), marks, rows, found)
    rows = found.missing(marks, want)
    if len(rows):
        _halving(convert, sources, rows, found)
    row, column, weight = found.triples()
    return weight, (row, column)


class _Found:
    """Weights by target texel, some of which are not all there yet."""

    def __init__(self, targets: int) -> None:
        self.targets = targets
        self.parts: list[tuple[Places, Places, Floats]] = []

    def triples(self) -> tuple[Places, Places, Floats]:
        """Return rows, columns and weights."""
        if not self.parts:
            return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
        row, column, weight = (np.concatenate(part) for part in zip(*self.parts, strict=True))
        return row, column, weight

    def missing(self, marks: Floats, want: Floats) -> Places:
        """Return the rows whose weights do not make of the marks what converting makes of them."""
        row, column, weight = self.triples()
        got = np.bincount(row, weight * marks[column], self.targets)
        rows = np.flatnonzero(np.abs(got - want) > _ROUNDING)
        if len(rows):
            kept = ~np.isin(row, rows)
            self.parts = [(row[kept], column[kept], weight[kept])]
        return rows


def _colors(shape: tuple[int, ...], period: int) -> Places:
    """Return a number for each texel that those less than `period` texels away do not have."""
    place = np.indices(shape[-2:]) % period
    return np.broadcast_to(place[0] * period + place[1], shape).ravel()


def _apart(
    convert: Callable[[Floats], Floats],
    colors: Places,
    marks: Floats,
    rows: Places,
    found: _Found,
) -> None:
    """Find the weights of rows that see one texel of each color at most.

    Of each color one channel holds 1, one the texels' numbers and one their marks. Where one texel
    is seen, the quotients are its number and its mark.
    """
    numbers = np.arange(1.0, len(colors) + 1)
    each = max(_NUMBERS // (3 * max(len(colors), found.targets)), 1)
    count = int(colors.max()) + 1
    for first in range(0, count, each):
        some = np.arange(first, min(first + each, count))
        is_color = (colors[:, None] == some).astype(np.float64)
        stacked = np.stack([is_color, is_color * numbers[:, None], is_color * marks[:, None]], -1)
        seen = convert(stacked.reshape(len(colors), -1)).reshape(found.targets, len(some), 3)[rows]
        weight = seen[..., 0]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            number = np.rint(seen[..., 1] / weight) - 1
            inside = (number >= 0) & (number < len(colors))
            column = np.where(inside, number, 0).astype(np.int64)
            # Weights of nothing but rounding are none; their quotients say nothing.
            alone = inside & (np.abs(weight) > 1e-14) & (colors[column] == some)
            alone &= np.abs(seen[..., 2] / weight - marks[column]) < 1e-7
        row, color = np.nonzero(alone)
        found.parts.append((rows[row], column[row, color], weight[row, color]))


def _halving(
    convert: Callable[[Floats], Floats], sources: int, rows: Places, found: _Found
) -> None:
    """Find the weights of some rows: what parts of the source they see, then parts of those."""
    lengths = [1]
    while lengths[-1] * 16 < sources:
        lengths.append(lengths[-1] * 16)
    starts = np.zeros(1, np.int64)
    whole = sources
    for length in reversed(lengths):
        steps = np.arange(0, whole, length)
        parts = (starts[:, None] + steps).ravel()
        parts = parts[parts < sources]
        seen = []
        for some, responses in _responses(convert, parts, length, sources, rows):
            if length > 1:
                seen.append(some[(responses != 0).any(axis=0)])
                continue
            row, part = np.nonzero(responses)
            found.parts.append((rows[row], some[part], responses[row, part]))
        if length > 1:
            starts, whole = np.concatenate(seen), length


def _responses(
    convert: Callable[[Floats], Floats],
    parts: Places,
    length: int,
    sources: int,
    rows: Places,
) -> Iterator[tuple[Places, Floats]]:
    """Yield some parts of the source, and what the rows see of each."""
    # Different numbers, so that weights of both signs do not cancel out.
    marks = np.random.default_rng(1).random(length) + 1 if length > 1 else np.ones(1)
    each = max(_NUMBERS // sources, 1)
    for first in range(0, len(parts), each):
        some = parts[first : first + each]
        image = np.zeros((sources, len(some)))
        for k, start in enumerate(some):
            stop = min(start + length, sources)
            image[start:stop, k] = marks[: stop - start]
        yield some, convert(image)[rows]
