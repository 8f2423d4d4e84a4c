"""Finding the axes, the yaw and the grid that relate two images of one scene.

Both images are compressed in tone, because a sun would outshine every other feature, and reduced
to what a panorama of a few degrees a texel can hold. There are 48 axes; a quarter turn about the
vertical takes one to another, so 12 are left that no yaw relates, and for each of these one
circular correlation along the rows answers for all yaws at once. The best are then refined on
points over the whole sphere, first in yaw and then, for one, in the grid, at the full resolution
of the images.

A score over the whole sphere forgives a wrong face or a wrong kind. So the best is looked at once
more, part by part; where parts do not fit, other kinds of the same shape and other orders of faces
are tried (`kinds`, `parts`).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array, expect_room, spatial_axes
from .._progress import counted, part
from .._scalars import as_whole
from .._show import short
from ..map.named import conventions, projection, resolve
from ..map.variants import axes_matrix, axes_text, changed
from ..map.verbs import rotation
from ..resample.verbs import convert, sample
from .kinds import alike
from .parts import Arrangement, apart, arranged, correlation, misfits, sides

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
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
# Below this nothing fits, below the second at most a part; above the third nothing else is tried.
_NOTHING, _PARTLY, _CLEAN = 0.3, 0.8, 0.995
# What a kind leaves unexplained in small panoramas, of what the given one does, to be looked at.
_WORTH = 0.75
# Yaws nearer to 0 than this, in degrees, are none.
_STRAIGHT = 0.5
# How much of the time has passed when images are read, ranked by panoramas, and refined; the
# rest is for a second look.
_READ, _RANKED, _REFINED = 0.2, 0.4, 0.6


@dataclass(frozen=True)
class Candidate:
    """One way in which the second image may show the scene of the first.

    Attributes
    ----------
    axes : str
        The axes of the second image in the world of the first.
    yaw : float
        Degrees in [-45, 45) that undo what is left after that: by so much the content of the second
        image has to be turned about what is up in the world of the first, counterclockwise seen
        from above, to show what the first shows.
    grid : str or None
        The grid on which the second image's texels lie, where it can be told.
    score : float
        The correlation of both, compressed in tone: 1 for the same image.
    projection : Projection
        The map of the second image with these axes and this grid, in the world of the first.
    mirrored : bool
        Whether one image is the mirror image of the other.
    kind : str or None
        The projection of one of the images where it is another than what it was taken for.
    """

    axes: str
    yaw: float
    grid: str | None
    score: float
    projection: Projection
    mirrored: bool
    kind: str | None = None

    @property
    def rotation(self) -> Array:
        """The yaw as a matrix in the world of the first, for `rotation=` of `sample`, `convert`."""
        ours = _to_our_world(self.projection)
        return np.asarray(ours.T @ np.asarray(rotation(self.yaw, 0, 0)) @ ours)

    def __str__(self) -> str:
        words = f'axes "{self.axes}", yaw {self.yaw:+.2f}°'
        up = self.projection.world.split()[1]
        words += f" about {up}" if up != "+y" else ""
        words += f", grid {self.grid}" if self.grid else ""
        words += f", as {self.kind}" if self.kind else ""
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
    rows : tuple of str
        The rows of `conventions` that say what the first candidate does, ``"cube:opengl"``, ...:
        an image of such a row is what `convert`, which matches worlds, makes of the first.
    """

    certain: bool
    reason: str
    candidates: tuple[Candidate, ...]
    rows: tuple[str, ...] = ()

    @property
    def best(self) -> Candidate | None:
        """The first candidate, or None where nothing can be told."""
        return self.candidates[0] if self.certain else None

    def __repr__(self) -> str:
        best = f", best: {str(self.best).strip()}" if self.best else ""
        rows = f", as in {short(self.rows)}" if self.rows else ""
        sure = "certain" if self.certain else "cannot tell"
        return f"Identification({sure}: {self.reason}{best}{rows}; {len(self.candidates)} in all)"

    def __str__(self) -> str:
        head = self.reason if self.certain else f"cannot tell: {self.reason}"
        tail = [f"as in the table: {', '.join(self.rows)}"] if self.rows else []
        return "\n".join([head, *map(str, self.candidates), *tail])


def identify(
    image_a: ArrayLike,
    image_b: ArrayLike,
    /,
    a: ProjectionLike | None = None,
    b: ProjectionLike | None = None,
    *,
    count: int = 5,
) -> Identification:
    """Find how two images of one scene are related: axes, mirror, yaw and grid.

    Parameters
    ----------
    image_a, image_b : array_like, shape (H, W), (H, W, C), or with faces (F, N, N, ...)
        The same scene, each in any projection, at any size, exposure and white balance.
    a, b : Projection or str, optional
        The maps of both. `a` is believed with all that it says; of `b` the projection and the
        layout are, and the axes and the grid are looked for, and where faces do not fit, their
        order, whether they are apart or in one picture. By default each is what its shape
        suggests: 2:1 a latlong, 1:1 an angular map, else a cube.
    count : int
        How many candidates to return at most.

    Returns
    -------
    Identification
        Ranked candidates with scores. ``certain`` is False where two of them fit about as well, as
        in a scene without features, where none fits, where the best fits in part alone (below a
        score of 0.8, or with a face that does not correlate to 0.9, or to what the faces mostly
        do), or where another kind of image fits better; ``reason`` then says which.

    Raises
    ------
    ValueError
        For an image that holds nothing finite, or whose shape no projection has.

    Notes
    -----
    ``candidate.projection`` and ``candidate.rotation`` go into `convert` and `sample`: image b seen
    through them shows what image a shows. Axes and yaw are told in the world of `a`; the rows of
    the table are those of programs whose images look so once worlds are matched, as `convert` does.

    Images of one scene, clean and of the kinds that are given, score above 0.98, whatever each
    channel is multiplied by; where channels are exchanged, or one is compared with three, down to
    0.6, which may be too little to tell. Below 0.995, or where a face does not fit, kinds of the
    same shape are tried in place of the given ones, and all orders of six faces with all quarter
    turns, among them those of the table.

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
    if as_whole(count, "count") < 1:
        raise ValueError(f"`count` must be at least 1, got {count}.")
    with part(0, _READ):
        given = counted([("image_a", image_a, a), ("image_b", image_b, b)])
        first, second = (_Image(*image) for image in given)
    # The second one's axes are those in the world of the first. They are looked for in ours, where
    # +y is up: a yaw turns about what is up.
    world = first.map
    second.map = changed(second.map, world=world.world)
    for image in (first, second):
        image.names = sides(image.map)
        image.map = image.map.in_world_of("latlong")
    if first.values.shape[-1] != second.values.shape[-1]:
        first.to_gray()
        second.to_gray()
    with part(_READ, _RANKED):
        ranked = _ranked(first, second)
    if not ranked:
        return Identification(False, "one of the images has no features", ())
    found = ranked[: max(count, 2)]
    points = _Points(first, second, _POINTS)
    with part(_RANKED, 0.5 * (_RANKED + _REFINED)):
        candidates = [
            points.candidate(axes, *points.refined(axes, yaw)) for _, axes, yaw in counted(found)
        ]
    candidates.sort(key=lambda c: -c.score)
    many = _Points(first, second, _MANY_POINTS)
    with part(0.5 * (_RANKED + _REFINED), _REFINED):
        candidates[0] = many.with_grid(candidates[0])
    candidates.sort(key=lambda c: -c.score)  # more points may tell two that fit badly apart
    certain, reason = _verdict(candidates)
    if candidates[0].score >= _NOTHING:
        usual = ranked[0][0]
        with part(_REFINED, 1):
            certain, reason, candidates = _looked_at_again(many, usual, certain, reason, candidates)
    candidates = [_in_world_of(world, candidate) for candidate in candidates]
    rows = _rows(candidates[0]) if certain else ()
    return Identification(certain, reason, tuple(candidates[:count]), rows)


def _ranked(first: _Image, second: _Image) -> list[tuple[float, str, float]]:
    """Return the axes and yaws that small panoramas favor, with their scores, the best first."""
    found: list[tuple[float, str, float]] = []
    with part(0, 0.4):
        panorama, weight = first.panorama
    with part(0.4, 0.8):
        cube, valid = second.faces
    with part(0.8, 1):
        for axes in counted(_classes()):
            scores = _scores(panorama, weight, *_seen(cube, valid, second, axes))
            for k in _peaks(scores):
                found.append((scores[k], axes, _vertex(scores, k)))
    found.sort(key=lambda entry: -entry[0])
    return _distinct(found)


def _looked_at_again(
    points: _Points, usual: float, certain: bool, reason: str, candidates: list[Candidate]
) -> tuple[bool, str, list[Candidate]]:
    """Return the verdict once the best candidate was looked at part by part.

    `usual` is the best score of small panoramas.
    """
    first, second, best = points.first, points.second, candidates[0]
    wrong = points.misfits(best)
    if best.score >= _CLEAN and not wrong:
        return certain, reason, candidates
    with part(0, 0.7):
        kind = _other_kind(first, second, usual, best)
    with part(0.7, 1):
        found = _other_order(first, second, candidates)
    # An order that fits clearly better than another kind in this order is what there is.
    if kind is not None and (found is None or 1 - found.score > 0.5 * (1 - kind[2].score)):
        which, given, better = kind
        words = f"{which} fits as '{better.kind}', score {better.score:.4f}, not as '{given}'"
        return False, f"{words}, score {best.score:.4f}", [better, *candidates]
    if found is not None:
        for name, p in found.rows():
            fresh = points.candidate_of(p, found.yaw)
            if not points.misfits(fresh) and fresh.score > best.score:
                fresh = points.with_grid(fresh)
                words = f"one way fits, with faces stored as in {name}, score {fresh.score:.4f}"
                return True, words, [fresh, *candidates]
        order = "; ".join(found.words)
        return False, f"faces are in an order that no row of the table has: {order}", candidates
    if wrong:
        words = f"faces {_list(wrong)} do not" if wrong[1:] else f"face {wrong[0]} does not"
        return False, f"fits in part: {words}", candidates
    if best.score < _PARTLY:
        return False, f"fits in part, score {best.score:.4f}", candidates
    return certain, reason, candidates


def _list(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _other_kind(
    first: _Image, second: _Image, usual: float, best: Candidate
) -> tuple[str, str, Candidate] | None:
    """Return the kind of one of the images that leaves half as much unexplained, if there is one.

    That is: of which image, what was given, and how it fits.
    """
    found: list[tuple[float, str, str, Candidate]] = []
    for image, which in counted([(second, "image_b"), (first, "image_a")]):
        for other in counted(alike(image.map)):
            taken = image.taken_as(other)
            pair = (taken, second) if image is first else (first, taken)
            tried = _ranked(*pair)[:2]
            # Small panoramas tell already whether a kind is worth a closer look.
            if not tried or 1 - tried[0][0] > _WORTH * (1 - usual):
                continue
            points = _Points(*pair, _POINTS)
            results = [points.candidate(axes, *points.refined(axes, yaw)) for _, axes, yaw in tried]
            top = max(results, key=lambda c: c.score)
            top = replace(top, kind=other.name)
            if 1 - top.score < 0.5 * (1 - best.score) and not points.misfits(top):
                found.append((top.score, which, image.map.name, top))
        if found:
            # The first image is believed where the second explains it.
            break
    if not found:
        return None
    _, which, given, candidate = max(found, key=lambda entry: entry[0])
    return which, given, candidate


def _other_order(first: _Image, second: _Image, candidates: list[Candidate]) -> Arrangement | None:
    """Return the order of the faces of a cube that fits, if one does."""
    p = second.map
    best: Arrangement | None = None
    for yaw in counted(sorted({0.0, *(c.yaw for c in candidates)})):
        look = partial(first.look, projection=first.map)
        found = arranged(look, second.values, p, yaw, second.names)
        if found is not None and (best is None or found.score > best.score):
            best = found
    if best is None or not best.fits or 1 - best.score > 0.5 * (1 - candidates[0].score):
        return None
    return best


def _rows(best: Candidate) -> tuple[str, ...]:
    """Return the rows of the table by which an image lies as the candidate says."""
    if abs(best.yaw) > _STRAIGHT:
        return ()
    p, size = best.projection, 6
    wanted = changed(p, grid=best.grid or "centers").directions(size)
    found = []
    for row in conventions(p.name):
        q = projection(p.name, convention=row["name"]).in_world_of(p)
        if best.grid not in (None, q.grid) or q.parameters != p.parameters:
            continue
        own = changed(q, grid=best.grid or "centers").directions(size)
        # To rounding.
        if own.shape == wanted.shape and np.allclose(own, wanted, atol=1e-9, equal_nan=True):
            found.append(f"{p.name}:{row['name']}")
    return tuple(found)


def _in_world_of(other: Projection, found: Candidate) -> Candidate:
    """Return a candidate told in the world of another map."""
    p = found.projection.in_world_of(other)
    return replace(found, axes=p.axes, projection=p)


def _to_our_world(p: Projection) -> Array:
    """Return what takes directions of a map's world to ours: right is +x, up +y, ahead -z."""
    return np.array([[1.0], [1.0], [-1.0]]) * axes_matrix(p.world)


class _Image:
    """An image with its map, compressed in tone, in float32.

    `names` are those of its faces, by the map that was given.
    """

    map: Projection
    names: tuple[str, ...]

    def __init__(self, name: str, image: ArrayLike, projection: ProjectionLike | None) -> None:
        values = as_array(image, name)
        if values.dtype.kind not in "uif":
            raise TypeError(f"Expected `{name}` to be real numbers, got {values.dtype}.")
        if projection is None:
            self.map, channels = _guess(name, values.shape)
        else:
            self.map = resolve(projection)
            axes = spatial_axes(self.map)
            channels = values.ndim > axes
            if values.ndim == axes + 2:
                raise ValueError(
                    f"Expected `{name}` to be one image, got a batch of shape {values.shape}: "
                    "[sm.align.identify(a, b) for a, b in zip(images_a, images_b)]."
                )
        expect_room(values.shape, np.dtype(np.float32))
        # Float32 has not the range of wider floats, which `_compressed` brings into it.
        if values.dtype.kind != "f" or values.dtype.itemsize < 4:
            values = values.astype(np.float32)
        if not channels:
            values = values[..., None]
        # Two channels are gray and alpha, four are colors and alpha: alpha is no scene.
        values = values[..., :3] if values.shape[-1] >= 3 else values[..., :1]
        self.map.shape(values.shape[:-1])
        self.values = self._compressed(name, values)

    @staticmethod
    def _compressed(name: str, values: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        known = np.isfinite(values)
        if not known.any():
            raise ValueError(f"Expected `{name}` to hold finite values, got none.")
        toned = np.empty(values.shape, np.float32)
        # Each channel by its own level: what multiplies one changes nothing.
        for c in range(values.shape[-1]):
            channel = values[..., c]
            bright = channel[known[..., c] & (channel > 0)]
            # Halves, as the middle of two large numbers is not to overflow.
            level = 2 * np.median(bright / 2) if bright.size else 1.0
            with np.errstate(invalid="ignore", over="ignore"):
                toned[..., c] = np.log1p(np.maximum(channel, 0) / values.dtype.type(level))
        # What is too large for its level is not finite.
        return np.where(known & np.isfinite(toned), toned, np.float32(np.nan))

    def taken_as(self, p: Projection) -> _Image:
        """Return the same texels in another map."""
        other = object.__new__(_Image)
        other.map, other.values, other.names = p, self.values, self.names
        return other

    def to_gray(self) -> None:
        self.values = self.values.mean(axis=-1, keepdims=True)

    def look(self, d: Array, projection: Projection, turn: Array | None = None) -> Array:
        values = sample(self.values, d, projection, rotation=turn, fill=np.nan, any_aspect=True)
        return np.asarray(values, np.float64)

    @cached_property
    def panorama(self) -> tuple[Array, Array]:
        """The image as a small panorama in the world of its map, and where it is known."""
        return _seen(*self.faces, self, self.map.axes)

    @cached_property
    def faces(self) -> tuple[Array, Array]:
        """The image on a small cube in its view frame, and the known share of each texel."""
        n = _ROWS // 2
        p = changed(self.map, axes="+x +y +z")
        fine = convert(
            self.values,
            p,
            projection("cube", axes="+x +y +z"),
            size=n * _FINER,
            fill=np.nan,
            world="literal",
            any_aspect=True,
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
                p = projection(kind, layout=layout)
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
    d = projection("latlong").directions((_ROWS, _COLUMNS)) @ axes_matrix(axes).T
    p = projection("cube", axes="+x +y +z")
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
        return correlation(self.seen[self.keep], shown[self.keep])

    def misfits(self, found: Candidate) -> list[str]:
        """Return the names of the parts of the second image that do not show the same."""
        p, turn = found.projection, found.rotation
        if p.layout is None:
            return []
        uv = np.asarray(apart(p).encode(self.directions, rotation=turn))
        names = self.second.names
        part = np.nan_to_num(uv[:, 2]).astype(np.intp)
        shown = self.second.look(self.directions, p, turn)
        known = np.isfinite(uv[:, 0])
        wrong = misfits(self.seen[known], shown[known], part[known], len(names))
        return [names[k] for k in wrong]

    def candidate_of(self, p: Projection, yaw: float) -> Candidate:
        """Return how a map of the second image fits, turned by about so much."""
        self.without_stretched(p, yaw)
        yaw, score = self.best_yaw(p, yaw)
        mirrored = p.mirrored != self.first.map.mirrored
        return Candidate(p.axes, float(np.round(yaw, 3)) + 0.0, None, score, p, mirrored)

    def best_yaw(self, p: Projection, yaw: float) -> tuple[float, float]:
        """Return the yaw near this one that fits best, and how well."""
        best, step = self.score(p, yaw), 360 / _COLUMNS
        while step > 0.01:
            step /= 2
            for angle in (yaw - step, yaw + step):
                value = self.score(p, angle)
                if value > best:
                    best, yaw = value, angle
        return yaw, best

    def without_stretched(self, p: Projection, yaw: float) -> None:
        """Leave out where a map, about so turned, stretches: all it shows there is blurred."""
        turn = np.asarray(rotation(yaw, 0, 0))
        self.keep = _even(self.first.map, self.directions, None) & _even(p, self.directions, turn)

    def refined(self, axes: str, yaw: float) -> tuple[float, float]:
        """Return the yaw near this one that fits best, and how well."""
        p = changed(self.second.map, axes=axes)
        self.without_stretched(p, yaw)
        return self.best_yaw(p, yaw)

    def candidate(
        self,
        axes: str,
        yaw: float,
        score: float,
        grid: str | None = None,
        of: Projection | None = None,
    ) -> Candidate:
        axes, yaw = _reduced(axes, yaw)
        p, a = changed(of or self.second.map, axes=axes, grid=grid), self.first.map
        # The formulas of two kinds may differ in their sense: faces say it, where there are some.
        mirrored = p.mirrored != a.mirrored
        return Candidate(axes, yaw, grid, score, p, mirrored)

    def with_grid(self, found: Candidate) -> Candidate:
        """Try each grid, with the yaw that goes best with it; keep one that clearly fits better."""
        results, given = [], found.projection
        self.without_stretched(given, found.yaw)
        for grid in counted(("centers", "corners", "corners-v")):
            p = changed(given, grid=grid)
            near = found.yaw + np.linspace(-0.2, 0.2, 7)
            try:
                results.append((*max((self.score(p, yaw), yaw) for yaw in near), grid))
            except ValueError:
                continue  # a single row lies on no two corners
        results.sort(reverse=True)
        score, yaw, grid = results[0]
        # What is left unexplained has to shrink by an eighth: by a tenth it does for a wrong grid,
        # too, where the second image is much finer than the first.
        if len(results) > 1 and (1 - score) > 0.875 * (1 - results[1][0]):
            score = self.score(given, found.yaw)
            return self.candidate(found.axes, found.yaw, score, of=given)
        return self.candidate(found.axes, float(yaw), score, grid, of=given)


def _reduced(axes: str, yaw: float) -> tuple[str, float]:
    """Put the quarter turns of a yaw into the axes."""
    quarters = int(np.floor((yaw + 45) / 90))
    turn = np.rint(np.asarray(rotation(90 * (quarters % 4), 0, 0)))
    yaw = yaw - 90 * quarters
    return axes_text(axes_matrix(axes) @ turn.T), float(np.round(yaw, 3)) + 0.0


def _verdict(candidates: list[Candidate]) -> tuple[bool, str]:
    best = candidates[0]
    if best.score < _NOTHING:
        return False, f"nothing fits; the best score is {best.score:.2f}"
    if len(candidates) == 1:
        return True, "one way fits"
    other = candidates[1].score
    # Of what the best leaves unexplained, the next has to leave half as much again.
    if 1 - other < 1.5 * (1 - best.score) + 1e-3:
        return False, f"two ways fit about as well, scores {best.score:.4f} and {other:.4f}"
    return True, f"one way fits, score {best.score:.4f}; the next has {other:.4f}"
