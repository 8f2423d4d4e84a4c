"""Where two images fit: in each part of the sphere apart, and with faces in another order.

A score over the whole sphere hides what is wrong with two faces of six: the others outweigh them.
So each face is correlated by itself, about its own mean, and compared with how well the others fit.
Where faces do not fit, every arrangement of them is tried: each stored tile against each face of
the other image, in eight ways, and the best permutation of all. Tiles of 32 × 32 texels are enough,
for a wrong face has nothing to do with what it should show.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.named import conventions, projection
from ..map.variants import axes_matrix, axes_text, changed
from ..map.verbs import rotation
from ..resample.verbs import convert

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .._projection import Projection

    Array = NDArray[np.float64]

__all__ = ["FITS", "Arrangement", "apart", "arranged", "correlation", "misfits", "sides"]

# A part fits that leaves no more unexplained than this, or than twice what the parts mostly do.
FITS = 0.9
# A part with less contrast than this, relative to all, says nothing.
_FLAT = 1e-3
# Points that a part needs.
_FEWEST = 100
# Texels along the side of a tile.
_TILE = 32
# Equal directions.
_SAME = 1e-9
# The faces of a cube.
_FACES = 6


def apart(p: Projection) -> Projection:
    """Return a map with its faces as an array, where it has several and joins them."""
    return p if p.layout is None else changed(p, layout="faces")


def sides(p: Projection) -> tuple[str, ...]:
    """Return the names of a map's faces: of a cube the sides of the world, else numbers."""
    p = apart(p)
    if p.faces != _FACES:
        return tuple(map(str, range(p.faces)))
    middles = p.directions(3)[:, 1, 1]
    along = np.abs(middles).argmax(axis=-1)
    return tuple(
        ("-" if middle[k] < 0 else "+") + "xyz"[k] for middle, k in zip(middles, along, strict=True)
    )


def correlation(x: Array, y: Array) -> float:
    """Return the correlation of values at the places where both are known; -1 of too few."""
    known = np.isfinite(x).all(axis=-1) & np.isfinite(y).all(axis=-1)
    x, y = x[known], y[known]
    if len(x) < _FEWEST:
        return -1.0
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    spread = np.sqrt(np.sum(x * x) * np.sum(y * y))
    return float(np.sum(x * y) / spread) if spread > 0 else -1.0


def misfits(x: Array, y: Array, part: NDArray[np.intp], count: int) -> list[int]:
    """Return the parts in which two images do not show the same."""
    whole = float(np.nanvar(x)) + float(np.nanvar(y))
    scores: dict[int, float] = {}
    for k in range(count):
        here = part == k
        if here.sum() < _FEWEST:
            continue
        a, b = x[here], y[here]
        known = np.isfinite(a).all(axis=-1) & np.isfinite(b).all(axis=-1)
        if known.sum() < _FEWEST or max(a[known].var(), b[known].var()) < _FLAT * whole:
            continue
        scores[k] = correlation(a, b)
    if not scores:
        return []
    limit = min(FITS, 1 - 2 * (1 - float(np.median(list(scores.values())))))
    return [k for k, score in scores.items() if score < limit]


class Arrangement:
    """An order of faces that fits where the given one does not.

    Attributes
    ----------
    yaw : float
        Degrees that the world of the faces is turned about +y.
    score : float
        The correlation over all faces.
    fits : bool
        Whether each face does.
    words : tuple of str
        What each face that does not show its own side shows.
    """

    def __init__(
        self, p: Projection, yaw: float, score: float, words: tuple[str, ...], shown: Array
    ) -> None:
        self.yaw, self.score, self.words, self._world = yaw, score, words, p.world
        self.fits = False
        # Where each stored texel looks, by the given map and in truth.
        given = np.asarray(changed(p, grid="centers").directions(_TILE), np.float64)
        faces = np.asarray(_upright(p).directions(_TILE), np.float64)
        face = _numbers(faces, given)
        self._held = face >= 0
        self._directions = shown.reshape(-1, 3)[face[self._held]]

    def rows(self) -> list[tuple[str, Projection]]:
        """Return the conventions that store faces so, each with its axes put into this world.

        Those whose own axes do come first.
        """
        found = []
        for row in conventions("cube"):
            q = projection("cube", convention=row["name"], grid="centers")
            own = q.directions(_TILE)
            held = np.isfinite(own[..., 0])
            if held.shape != self._held.shape or (held != self._held).any():
                continue
            turn = np.rint(np.linalg.lstsq(own[held], self._directions, rcond=None)[0])
            # Directions to rounding; the next texel is a hundred thousand times that away.
            if np.abs(own[held] @ turn - self._directions).max() < _SAME:
                axes = axes_text(axes_matrix(q.axes) @ turn)
                put = changed(q, axes=axes, world=self._world)
                found.append((axes != q.axes, f"cube:{row['name']}", put))
        found.sort(key=lambda entry: entry[0])
        return [(name, put) for _, name, put in found]


def _upright(p: Projection) -> Projection:
    """Return a map with its faces as an array, no two texels of which look the same way."""
    return changed(apart(p), grid="centers")


def _numbers(places: Array, directions: Array) -> NDArray[np.intp]:
    """Return the number of the place at each direction, -1 where there is none."""
    known = {tuple(d): k for k, d in enumerate(np.rint(places.reshape(-1, 3) * 1e6).tolist())}
    flat = np.rint(np.nan_to_num(directions.reshape(-1, 3)) * 1e6).tolist()
    numbers = [known.get(tuple(d), -1) for d in flat]
    return np.array(numbers, np.intp).reshape(directions.shape[:-1])


def _ways() -> list[tuple[str, Callable[[Any], Any]]]:
    """Return the eight ways in which a tile may lie, and their names."""

    def way(turns: int, mirrored: bool) -> tuple[str, Callable[[Any], Any]]:
        words = [" mirrored"] if mirrored else []
        words += [f" turned by {90 * turns}°"] if turns else []
        return " and".join(words), lambda t: np.rot90(t[:, ::-1] if mirrored else t, turns)

    return [way(turns, mirrored) for mirrored in (False, True) for turns in range(4)]


def arranged(
    look: Callable[[Array], Array],
    values: NDArray[np.float32],
    p: Projection,
    yaw: float,
    names: tuple[str, ...],
) -> Arrangement | None:
    """Return the best arrangement of the faces of an image; None where these are not six.

    `look` gives what the other image shows in directions of its world; `names` are of the faces.
    """
    upright = _upright(p)
    if upright.faces != _FACES:
        return None
    stored = np.asarray(convert(values, p, upright, size=_TILE, fill=np.nan), np.float64)
    places = upright.directions(_TILE)
    turn = np.asarray(rotation(yaw, 0, 0))
    shown = look(places.reshape(-1, 3) @ turn.T).reshape(*places.shape[:3], -1)
    if not (np.isfinite(stored).all() and np.isfinite(shown).all()):
        return None
    weight = upright.solid_angle(_TILE)[0][..., None]

    def centered(x: Any) -> Array:
        x = x - (x * weight).sum(axis=(0, 1, 2)) / (6 * weight.sum())
        return np.asarray(x / np.sqrt((x * x * weight).sum()))

    stored, shown = centered(stored), centered(shown)
    ways = _ways()
    # Of a stored tile and a side of the world: the best way without and with a mirror.
    table = np.empty((6, 6, len(ways)))
    for side in range(6):
        for k, (_, way) in enumerate(ways):
            tile = way(shown[side]) * weight
            table[:, side, k] = (stored * tile).sum(axis=(1, 2, 3))
    best: tuple[float, tuple[int, ...], NDArray[np.intp]] | None = None
    # All mirrored or none, or each as it will: that has to fit clearly better.
    for half, more in ((slice(0, 4), 0.0), (slice(4, 8), 0.0), (slice(0, 8), 0.02)):
        scores, choice = table[..., half].max(axis=-1), table[..., half].argmax(axis=-1)
        choice = choice + half.start
        for order in itertools.permutations(range(6)):
            score = float(scores[range(6), order].sum())
            if best is None or score > best[0] + more:
                best = (score, order, choice)
    assert best is not None
    score, order, choice = best
    directions = np.empty_like(places)
    words, tiles = [], np.empty_like(shown)
    for face, side in enumerate(order):
        name, way = ways[choice[face, side]]
        directions[face], tiles[face] = way(places[side]), way(shown[side])
        if side != face or name:
            words.append(f"face {names[face]} shows {names[side]}{name}")
    part = np.repeat(np.arange(6), _TILE * _TILE)
    flat = (-1, stored.shape[-1])
    wrong = misfits(stored.reshape(flat), tiles.reshape(flat), part, 6)
    same = {ways[choice[face, side]][0] for face, side in enumerate(order)}
    if list(order) == list(range(6)) and len(same) == 1 and words:
        words = [f"each shows its own side{same.pop()}"]
    found = Arrangement(p, yaw, score, tuple(words), directions)
    found.fits = bool(words) and score >= FITS and not wrong
    return found
