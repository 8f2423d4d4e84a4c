"""Finding the axes, the yaw and the grid that relate two images of one scene.

Both images are compressed in tone, because a sun would outshine every other feature, and reduced
to what a panorama of a few degrees a texel can hold. There are 48 axes; a quarter turn about the
vertical takes one to another, so 12 are left that no yaw relates, and for each of these one
circular correlation along the rows answers for all yaws at once. The best are then refined on
points over the whole sphere, first in yaw and then, for one, in the grid, at the full resolution
of the images.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..map.named import resolve
from ..map.variants import axes_matrix, changed
from ..map.verbs import rotation
from ..resample.verbs import convert, sample

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._core import Projection
    from ..map.named import ProjectionLike

    Array = NDArray[np.float64]

__all__ = ["Candidate", "Identification", "identify"]

# Rows of the band-limited panoramas: 2.8° a texel, below what mislaid half texels could blur.
_ROWS = 64
_COLUMNS = 2 * _ROWS
# How many times finer an image is read before it is averaged down to that.
_FINER = 8
# Points at which images are compared at their own resolution: for the yaw of each candidate, and
# for the grid of the best one, which is a matter of half a texel.
_POINTS = 10_000
_MANY_POINTS = 40_000


@dataclass(frozen=True)
class Candidate:
    """One way in which the second image may show the scene of the first.

    Attributes
    ----------
    axes : str
        The axes of the second image in the world of the first.
    yaw : float
        Degrees in [-45, 45) that the second image is turned about +y after that.
    grid : str or None
        The grid on which the second image's texels lie, where it can be told.
    score : float
        The correlation of both, compressed in tone: 1 for the same image.
    projection : Projection
        The map of the second image with these axes and this grid.
    mirrored : bool
        Whether one image is the mirror image of the other.
    """

    axes: str
    yaw: float
    grid: str | None
    score: float
    projection: Projection
    mirrored: bool

    @property
    def rotation(self) -> Array:
        """The yaw as a matrix, for `rotation=` of `sample` and `convert`."""
        return np.asarray(rotation(self.yaw, 0, 0))

    def __str__(self) -> str:
        words = f'axes "{self.axes}", yaw {self.yaw:+.2f}°'
        words += f", grid {self.grid}" if self.grid else ""
        return f"{self.score:+.4f}  {words}{', mirrored' if self.mirrored else ''}"


@dataclass(frozen=True)
class Identification:
    """What `identify` found.

    Attributes
    ----------
    certain : bool
        Whether the first candidate is clearly better than every other.
    reason : str
        Why, in words.
    candidates : tuple of Candidate
        The best first.
    """

    certain: bool
    reason: str
    candidates: tuple[Candidate, ...]

    @property
    def best(self) -> Candidate | None:
        """The first candidate, or None where nothing can be told."""
        return self.candidates[0] if self.certain else None

    def __str__(self) -> str:
        head = self.reason if self.certain else f"cannot tell: {self.reason}"
        return "\n".join([head, *map(str, self.candidates)])


def identify(
    image_a: ArrayLike,
    image_b: ArrayLike,
    a: ProjectionLike | None = None,
    b: ProjectionLike | None = None,
    /,
    *,
    count: int = 5,
) -> Identification:
    """Find how two images of one scene are related: axes, mirror, yaw and grid.

    Parameters
    ----------
    image_a, image_b : array_like, shape (H, W), (H, W, C), or with faces (F, N, N, ...)
        The same scene, each in any projection, at any size, exposure and color.
    a, b : Projection or str, optional
        The maps of both. `a` is believed with all that it says; of `b` the projection, the layout
        and the order of faces are, and the axes and the grid are looked for. By default each is
        what its shape suggests: 2:1 a latlong, 1:1 an angular map, else a cube.
    count : int
        How many candidates to return at most.

    Returns
    -------
    Identification
        Ranked candidates with scores. ``certain`` is False where two of them fit about as well, as
        in a scene without features, or where none fits.

    Raises
    ------
    ValueError
        For an image that holds nothing finite, or whose shape no projection has.

    Notes
    -----
    ``candidate.projection`` and ``candidate.rotation`` go into `convert` and `sample`: image b seen
    through them shows what image a shows.

    Negative texels count as black, texels outside a disk and those that are not finite do not count
    at all.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> d = sm.directions("latlong", 64)
    >>> scene = 1 + d[..., 0] / 2 + d[..., 1] * d[..., 2] + d[..., 0] * d[..., 1]
    >>> found = sm.align.identify(scene, scene[:, ::-1])
    >>> found.certain, found.best.axes, found.best.mirrored
    (True, '-x -y -z', True)
    """
    if count < 1:
        raise ValueError(f"`count` must be at least 1, got {count}.")
    first, second = _Image("image_a", image_a, a), _Image("image_b", image_b, b)
    if first.values.shape[-1] != second.values.shape[-1]:
        first.to_gray()
        second.to_gray()
    panorama, weight = first.panorama()
    found: list[tuple[float, str, float]] = []
    cube, valid = second.faces()
    for axes in _classes():
        scores = _scores(panorama, weight, *_seen(cube, valid, second, axes))
        for k in _peaks(scores):
            found.append((scores[k], axes, _vertex(scores, k)))
    found.sort(key=lambda entry: -entry[0])
    found = _distinct(found)[: max(count, 2)]
    if not found:
        return Identification(False, "one of the images has no features", ())
    points = _Points(first, second, _POINTS)
    candidates = [points.candidate(axes, *points.refined(axes, yaw)) for _, axes, yaw in found]
    candidates.sort(key=lambda c: -c.score)
    candidates[0] = _Points(first, second, _MANY_POINTS).with_grid(candidates[0])
    candidates.sort(key=lambda c: -c.score)  # more points may tell two that fit badly apart
    certain, reason = _verdict(candidates)
    return Identification(certain, reason, tuple(candidates[:count]))


class _Image:
    """An image with its map, compressed in tone, in float32."""

    def __init__(self, name: str, image: ArrayLike, projection: ProjectionLike | None) -> None:
        values = np.asarray(image)
        if values.dtype.kind not in "uif":
            raise TypeError(f"Expected `{name}` to be real numbers, got {values.dtype}.")
        if projection is None:
            self.map, channels = _guess(name, values.shape)
        else:
            self.map = resolve(projection)
            channels = values.ndim > (3 if self.map.faces > 1 else 2)
        values = values.astype(np.float32)
        if not channels:
            values = values[..., None]
        # Two channels are gray and alpha, four are colors and alpha: alpha is no scene.
        values = values[..., :3] if values.shape[-1] >= 3 else values[..., :1]
        self.map.shape(values.shape[:-1])
        self.values = self._compressed(name, values)

    @staticmethod
    def _compressed(name: str, values: NDArray[np.float32]) -> NDArray[np.float32]:
        known = np.isfinite(values)
        bright = values[known & (values > 0)]
        if not known.any():
            raise ValueError(f"Expected `{name}` to hold finite values, got none.")
        if bright.size == 0:
            return np.where(known, np.float32(0), np.float32(np.nan))
        level = np.float32(np.median(bright))
        with np.errstate(invalid="ignore"):
            toned = np.log1p(np.maximum(values, 0) / level)
        return np.where(known, toned, np.float32(np.nan))

    def to_gray(self) -> None:
        self.values = self.values.mean(axis=-1, keepdims=True)

    def look(self, d: Array, projection: Projection, turn: Array | None = None) -> Array:
        values = sample(self.values, d, projection, rotation=turn)
        return np.asarray(values, np.float64)

    def panorama(self) -> tuple[Array, Array]:
        """Return the image as a small panorama in the world of its map, and where it is known."""
        cube, valid = self.faces()
        return _seen(cube, valid, self, self.map.axes)

    def faces(self) -> tuple[Array, Array]:
        """Return the image on a small cube in its view frame, and the known share of each texel."""
        n = _ROWS // 2
        p = changed(self.map, axes="+x +y +z")
        fine = convert(
            self.values, p, _core.projection("cube", axes="+x +y +z"), size=n * _FINER, fill=np.nan
        )
        blocks = fine.reshape(6, n, _FINER, n, _FINER, -1).astype(np.float64)
        known = np.isfinite(blocks).all(axis=-1, keepdims=True)
        share = known.mean(axis=(2, 4))
        mean = np.where(known, blocks, 0).mean(axis=(2, 4)) / np.maximum(share, 1e-9)
        return mean, share


def _guess(name: str, shape: tuple[int, ...]) -> tuple[Projection, bool]:
    """Return the likeliest map of a shape, and whether its last axis holds channels."""
    for channels in (False, True):
        size = shape[:-1] if channels else shape
        for kind in ("latlong", "angular", "cube"):
            layouts = (
                (None,)
                if kind != "cube"
                else ("faces", "cross", "vertical_cross", "strip", "column", "3x2")
            )
            for layout in layouts:
                p = _core.projection(kind, layout=layout)
                try:
                    unit = p.shape(2)
                    fits = len(size) == len(unit) and p.shape(size) == size
                except ValueError:
                    continue
                # Of one face, the aspect has to fit as well.
                if fits and size[-1] * unit[-2] == size[-2] * unit[-1]:
                    return p, channels
    raise ValueError(f"No projection is likely for `{name}` of shape {shape}: say which it is.")


def _classes() -> list[str]:
    """Return the 12 axes that no turn about +y relates: what is down in the image, and mirrored."""
    classes = []
    for order in itertools.permutations("xyz"):
        for signs in itertools.product("+-", repeat=3):
            words = [sign + letter for sign, letter in zip(signs, order, strict=True)]
            at = order.index("y")
            # One of the four quarter turns: the next view axis lies along the world's +x.
            if words[(at + 1) % 3] == "+x":
                classes.append(" ".join(words))
    return classes


def _seen(cube: Array, valid: Array, image: _Image, axes: str) -> tuple[Array, Array]:
    """Return the small cube of a view frame as a panorama of a world with these axes."""
    d = _core.projection("latlong").directions((_ROWS, _COLUMNS)) @ axes_matrix(axes).T
    p = _core.projection("cube", axes="+x +y +z")
    values = np.asarray(sample(cube * valid, d, p))
    share = np.asarray(sample(valid, d, p))
    known = share > 0.5
    return np.where(known, values / np.maximum(share, 1e-9), 0), known[..., 0].astype(np.float64)


def _scores(a: Array, known_a: Array, b: Array, known_b: Array) -> Array:
    """Return the correlation of two panoramas for each shift of the second by whole columns."""
    rows = (np.arange(_ROWS) + 0.5) / _ROWS * np.pi
    wa = known_a * np.sin(rows)[:, None]

    def along(x: Array, y: Array) -> Array:
        # Σ x(j) y(j + k) over rows and columns, for each k.
        fx, fy = np.fft.rfft(x, axis=1), np.fft.rfft(y, axis=1)
        return np.fft.irfft((np.conj(fx) * fy).sum(axis=0), _COLUMNS)

    total = np.maximum(along(wa, known_b), 1e-12)
    whole = float(wa.sum())
    covariance = variance_a = variance_b = np.zeros(_COLUMNS)
    for c in range(a.shape[-1]):
        x, y = a[..., c] * known_a, b[..., c] * known_b
        mean_x, mean_y = along(wa * x, known_b) / total, along(wa, y) / total
        covariance = covariance + along(wa * x, y) / total - mean_x * mean_y
        variance_a = variance_a + along(wa * x * x, known_b) / total - mean_x**2
        variance_b = variance_b + along(wa, y * y) / total - mean_y**2
    spread = np.sqrt(np.maximum(variance_a, 0) * np.maximum(variance_b, 0))
    # Too little in common, or too flat, to say anything.
    usable = (total > 0.1 * whole) & (spread > 1e-9)
    return np.where(usable, covariance / np.where(usable, spread, 1), -1.0)


def _peaks(scores: Array) -> list[int]:
    higher = (scores >= np.roll(scores, 1)) & (scores > np.roll(scores, -1)) & (scores > -1)
    return [int(k) for k in np.flatnonzero(higher)]


def _vertex(scores: Array, k: int) -> float:
    """Return the yaw in degrees at the top of the parabola through a peak."""
    left, top, right = scores[k - 1], scores[k], scores[(k + 1) % _COLUMNS]
    bend = left - 2 * top + right
    offset = 0.5 * (left - right) / bend if bend < 0 else 0.0
    return float((k + offset) * 360 / _COLUMNS)


def _distinct(found: list[tuple[float, str, float]]) -> list[tuple[float, str, float]]:
    """Leave out what lies within 8° of something better."""
    kept: list[tuple[float, str, float]] = []
    for score, axes, yaw in found:
        near = (axes == other and abs((yaw - y + 180) % 360 - 180) < 8 for _, other, y in kept)
        if not any(near):
            kept.append((score, axes, yaw))
    return kept


def _correlation(x: Array, y: Array) -> float:
    known = np.isfinite(x).all(axis=-1) & np.isfinite(y).all(axis=-1)
    x, y = x[known], y[known]
    if len(x) < 100:
        return -1.0
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    spread = np.sqrt(np.sum(x * x) * np.sum(y * y))
    return float(np.sum(x * y) / spread) if spread > 0 else -1.0


def _even(p: Projection, d: Array, turn: Array | None) -> NDArray[np.bool_]:
    """Tell where a map, in a direction or across it, is not much coarser than it mostly is."""
    slopes = np.asarray(p.jacobian(p.encode(d, rotation=turn)))
    coarse = np.sqrt(np.sum(slopes * slopes, axis=(-2, -1)))
    known = np.isfinite(coarse)
    usual = np.median(coarse[known]) if known.any() else 0.0
    return np.asarray(np.where(known, coarse, np.inf) < 2 * usual, np.bool_)


class _Points:
    """Places that lie evenly on the sphere, and what the first image shows there."""

    def __init__(self, first: _Image, second: _Image, count: int) -> None:
        k = np.arange(count) + 0.5
        y, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
        r = np.sqrt(1 - y * y)
        self.directions = np.stack([r * np.sin(turn), y, r * np.cos(turn)], axis=-1)
        self.first, self.second = first, second
        self.keep = _even(first.map, self.directions, None)
        self.seen = first.look(self.directions, first.map)

    def score(self, p: Projection, yaw: float) -> float:
        shown = self.second.look(self.directions, p, np.asarray(rotation(yaw, 0, 0)))
        return _correlation(self.seen[self.keep], shown[self.keep])

    def without_stretched(self, p: Projection, yaw: float) -> None:
        """Leave out where a map, about so turned, stretches: all it shows there is blurred."""
        turn = np.asarray(rotation(yaw, 0, 0))
        self.keep = _even(self.first.map, self.directions, None) & _even(p, self.directions, turn)

    def refined(self, axes: str, yaw: float) -> tuple[float, float]:
        """Return the yaw near this one that fits best, and how well."""
        p = changed(self.second.map, axes=axes)
        self.without_stretched(p, yaw)
        best, step = self.score(p, yaw), 360 / _COLUMNS
        while step > 0.01:
            step /= 2
            for angle in (yaw - step, yaw + step):
                value = self.score(p, angle)
                if value > best:
                    best, yaw = value, angle
        return yaw, best

    def candidate(self, axes: str, yaw: float, score: float, grid: str | None = None) -> Candidate:
        axes, yaw = _reduced(axes, yaw)
        p, a = changed(self.second.map, axes=axes, grid=grid), self.first.map
        # The formulas of two kinds may differ in their sense: faces say it, where there are some.
        mirrored = p.mirrored != a.mirrored
        return Candidate(axes, yaw, grid, score, p, mirrored)

    def with_grid(self, found: Candidate) -> Candidate:
        """Try each grid, with the yaw that goes best with it; keep one that clearly fits better."""
        results = []
        self.without_stretched(found.projection, found.yaw)
        for grid in ("centers", "corners", "corners-v"):
            p = changed(self.second.map, axes=found.axes, grid=grid)
            near = found.yaw + np.linspace(-0.2, 0.2, 7)
            try:
                results.append((*max((self.score(p, yaw), yaw) for yaw in near), grid))
            except ValueError:
                continue  # a single row lies on no two corners
        results.sort(reverse=True)
        score, yaw, grid = results[0]
        # What is left unexplained has to shrink by a tenth.
        if len(results) > 1 and (1 - score) > 0.9 * (1 - results[1][0]):
            p = changed(self.second.map, axes=found.axes)
            return self.candidate(found.axes, found.yaw, self.score(p, found.yaw))
        return self.candidate(found.axes, float(yaw), score, grid)


def _reduced(axes: str, yaw: float) -> tuple[str, float]:
    """Put the quarter turns of a yaw into the axes."""
    quarters = int(np.floor((yaw + 45) / 90))
    turn = np.rint(np.asarray(rotation(90 * (quarters % 4), 0, 0)))
    matrix = axes_matrix(axes) @ turn.T
    words = []
    for row in matrix:
        k = int(np.flatnonzero(row)[0])
        words.append(("-" if row[k] < 0 else "+") + "xyz"[k])
    yaw = yaw - 90 * quarters
    return " ".join(words), float(np.round(yaw, 3)) + 0.0


def _verdict(candidates: list[Candidate]) -> tuple[bool, str]:
    best = candidates[0]
    if best.score < 0.3:
        return False, f"nothing fits; the best score is {best.score:.2f}"
    if len(candidates) == 1:
        return True, "one way fits"
    other = candidates[1].score
    # Of what the best leaves unexplained, the next has to leave half as much again.
    if 1 - other < 1.5 * (1 - best.score) + 1e-3:
        return False, f"two ways fit about as well, scores {best.score:.4f} and {other:.4f}"
    return True, f"one way fits, score {best.score:.4f}; the next has {other:.4f}"
