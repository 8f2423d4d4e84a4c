"""An image as a few directional lights, and its sun: found, taken out, put back."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np

from .._arrays import spatial_axes
from ..map.named import resolve
from ..map.verbs import directions, encode
from .image import as_light, coefficients, luminance_of, texel_weights

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    from ..map.named import ProjectionLike

    Array: TypeAlias = NDArray[np.float64]
    Method: TypeAlias = Literal["median", "variance"]

__all__ = ["Light", "Lights", "Sun", "add_sun", "lights", "remove_sun", "sun"]


@dataclass(frozen=True, eq=False)
class Light:
    """One directional light.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        Toward the light, in the world, of unit length.
    irradiance : ndarray, shape (C,)
        ∫ L dω over its part of the sphere: what a surface that faces it receives.
    solid_angle : float
        That part's, in steradians.
    """

    direction: Array
    irradiance: Array
    solid_angle: float

    @property
    def radiance(self) -> Array:
        """The mean radiance of its part of the sphere."""
        return self.irradiance / self.solid_angle if self.solid_angle else self.irradiance * 0


@dataclass(frozen=True, eq=False)
class Lights:
    """Directional lights that stand for an image, brightest first; a sequence of `Light`.

    Attributes
    ----------
    directions : ndarray, shape (N, 3)
        As `Light.direction`.
    irradiance : ndarray, shape (N, C)
        As `Light.irradiance`; the sum is the image's ∫ L dω.
    solid_angle : ndarray, shape (N,)
        As `Light.solid_angle`; the sum is the coverage.
    """

    directions: Array
    irradiance: Array
    solid_angle: Array

    def __len__(self) -> int:
        return len(self.directions)

    def __getitem__(self, index: int) -> Light:
        return Light(self.directions[index], self.irradiance[index], float(self.solid_angle[index]))

    def __iter__(self) -> Iterator[Light]:
        return (self[index] for index in range(len(self)))


@dataclass(frozen=True, eq=False)
class Sun:
    """A small bright source on a duller surround.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        Toward the middle of its light, in the world.
    solid_angle : float
        Of the disc that gives its irradiance at its peak's luminance, in steradians. For a disc
        of one brightness it is the disc's; for one in a single texel, the texel's.
    irradiance : ndarray, shape (C,)
        What it adds to its surround, ∫ (L - surround) dω, on a surface that faces it.
    surround : ndarray, shape (C,)
        The radiance around it.
    reach : float
        The angle from its brightest texel to the end of what counts as sun, in radians.
    """

    direction: Array
    solid_angle: float
    irradiance: Array
    surround: Array
    reach: float

    @property
    def radiance(self) -> Array:
        """Its mean radiance above the surround."""
        return self.irradiance / self.solid_angle

    @property
    def angular_diameter(self) -> float:
        """Of a disc with its solid angle, in degrees. The sun in our sky has 0.53."""
        return float(np.degrees(2 * _radius(self.solid_angle)))


class _Texels(NamedTuple):
    """The texels that hold sphere, as lists."""

    image: NDArray[np.floating[Any]]
    held: NDArray[np.intp]
    light: Array
    luminance: Array
    weight: Array
    direction: Array


def lit_texels(
    image: ArrayLike,
    projection: ProjectionLike,
    axes: str | None,
    rotation: Any | None,
    luminance: ArrayLike | None,
    skipna: bool,
) -> _Texels:
    p = resolve(projection, axes)
    array = as_light(image, p, skipna=skipna)
    n = spatial_axes(p)
    shape = array.shape[:n]
    bright = luminance_of(array, n, coefficients(array, n, luminance)).reshape(-1)
    weight = texel_weights(p, shape).reshape(-1)
    held = np.flatnonzero(weight > 0)
    toward = directions(p, shape, rotation=rotation).reshape(-1, 3).astype(np.float64, copy=False)
    flat = array.reshape(len(weight), -1)
    if len(held) == len(weight):
        return _Texels(array, held, flat.astype(np.float64), bright, weight, toward)
    return _Texels(
        array, held, flat[held].astype(np.float64), bright[held], weight[held], toward[held]
    )


def lights(
    image: ArrayLike,
    projection: ProjectionLike,
    n: int,
    /,
    *,
    method: Method = "median",
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
) -> Lights:
    """Approximate an image by directional lights.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Linear radiance.
    projection, axes, rotation
        As for `encode`.
    n : int
        How many lights, at least 1. There are fewer where the light comes from fewer places.
    method : {"median", "variance"}
        Median cut [1]_ halves the light of the brightest region, across its longer side. The
        other way [2]_ cuts the region of the largest variance where the larger variance of its
        parts is smallest; it does not cut through lamps.
    luminance, skipna
        As for `Distribution`.

    Returns
    -------
    lights : Lights
        Their irradiances sum to the image's ∫ L dω, negative texels included, and their solid
        angles to the coverage.

    Raises
    ------
    ValueError
        For n below 1, an unknown method, NaN or infinite texels, or a shape that does not fit.
    TypeError
        For an unfit dtype.

    Notes
    -----
    Any projection will do: texels are counted, whole, into a grid of latitude and longitude with
    as many cells, at most 512×1024, and regions are rectangles of that. A light stands at the
    centroid of its region's luminance. The variance is ∑ L ω |d - centroid|², d on the sphere.

    References
    ----------
    .. [1] P. Debevec, "A Median Cut Algorithm for Light Probe Sampling", SIGGRAPH 2005 posters.
    .. [2] K. Viriyothai, P. Debevec, "Variance Minimization Light Probe Sampling", SIGGRAPH 2009
       posters.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.maximum(sm.directions("latlong", 64), 0)[..., 1]
    >>> four = sm.light.lights(sky, "latlong", 4)
    >>> len(four), bool(np.isclose(four.irradiance.sum(), np.pi, rtol=1e-3))
    (4, True)
    """
    count = _count(n)
    if method not in ("median", "variance"):
        raise ValueError(f"unknown method {method!r}; there are 'median' and 'variance'")
    texels = lit_texels(image, projection, axes, rotation, luminance, skipna)
    rows = _grid_rows(texels.weight)
    uv = encode(texels.direction, "latlong")
    across = np.minimum((uv[:, 0] * (2 * rows)).astype(np.intp), 2 * rows - 1)
    down = np.minimum((uv[:, 1] * rows).astype(np.intp), rows - 1)
    cell = down * (2 * rows) + across
    energy = np.maximum(texels.luminance, 0) * texels.weight
    columns = [texels.weight, energy, *(energy * x for x in texels.direction.T)]
    columns += [texels.weight * x for x in texels.light.T]
    sums = [np.bincount(cell, c, minlength=2 * rows * rows) for c in columns]
    grid = np.stack(sums, axis=-1).astype(np.float64, copy=False).reshape(rows, 2 * rows, -1)
    return _as_lights(grid, _regions(grid[..., 1:5], count, method))


def _count(n: object) -> int:
    try:
        count = int(np.asarray(n).item()) if np.asarray(n).dtype.kind in "iu" else -1
    except (TypeError, ValueError):
        count = -1
    if count < 1:
        raise ValueError(f"Expected `n` to be an integer of at least 1, got {n!r}.")
    return count


def _grid_rows(weight: Array) -> int:
    cells = len(weight) * 4 * np.pi / float(weight.sum())
    return int(np.clip(round(float(np.sqrt(cells / 2))), 2, 512))


class _Region(NamedTuple):
    top: int
    bottom: int
    left: int
    right: int


def _regions(grid: Array, count: int, method: Method) -> list[_Region]:
    """Cut the grid of (energy, energy · direction) into at most `count` rectangles."""
    rows, columns = grid.shape[:2]
    table = np.zeros((rows + 1, columns + 1, 4))
    np.cumsum(np.cumsum(grid, axis=0), axis=1, out=table[1:, 1:])
    # What a difference of sums rounds to where there is no light at all.
    dark = 1e-13 * float(table[-1, -1, 0])
    final: list[_Region] = []
    whole = _Region(0, rows, 0, columns)
    # The second entry makes ties fall the same way at every run.
    queue: list[tuple[float, int, _Region]] = [(0.0, 0, whole)]
    made = 1
    while queue and len(queue) + len(final) < count:
        _, _, region = heapq.heappop(queue)
        parts = _median_cut(table, region, dark) if method == "median" else None
        if method == "variance":
            parts = _variance_cut(table, region, dark)
        if parts is None:
            final.append(region)
            continue
        for part in parts:
            sums = _sums(table, part)
            rank = sums[0] if method == "median" else _variance(sums)
            heapq.heappush(queue, (-float(rank), made, part))
            made += 1
    return final + [region for _, _, region in queue]


def _sums(table: Array, r: _Region) -> Array:
    right = table[r.bottom, r.right] - table[r.top, r.right]
    sums: Array = right - (table[r.bottom, r.left] - table[r.top, r.left])
    return sums


def _variance(sums: Array) -> Array:
    """Return ∑ e |d - c|² = E - |∑ e d|² / E for unit d."""
    energy = sums[..., 0]
    squared = (sums[..., 1:] ** 2).sum(-1)
    safe = np.where(energy > 0, energy, 1)
    variance: Array = np.where(energy > 0, np.maximum(energy - squared / safe, 0), 0)
    return variance


def _prefixes(table: Array, r: _Region, axis: int) -> Array:
    """Return the sums of the first 1, 2, ... lines of a region, all but the last."""
    if axis == 0:
        lines = table[r.top : r.bottom, r.right] - table[r.top : r.bottom, r.left]
    else:
        lines = table[r.bottom, r.left : r.right] - table[r.top, r.left : r.right]
    sums: Array = lines[1:] - lines[0]
    return sums


def _cut(r: _Region, axis: int, at: int) -> tuple[_Region, _Region]:
    """Return the first `at` + 1 lines and the others."""
    if axis == 0:
        middle = r.top + at + 1
        return r._replace(bottom=middle), r._replace(top=middle)
    middle = r.left + at + 1
    return r._replace(right=middle), r._replace(left=middle)


def _median_cut(table: Array, r: _Region, dark: float) -> tuple[_Region, _Region] | None:
    rows = len(table) - 1
    latitude = np.pi * (0.5 - 0.5 * (r.top + r.bottom) / rows)
    wide = (r.right - r.left) * np.cos(latitude) > r.bottom - r.top
    total = _sums(table, r)[0]
    for axis in (1, 0) if wide else (0, 1):
        first = _prefixes(table, r, axis)[:, 0]
        lit = (first > dark) & (total - first > dark)
        if lit.any():
            away = np.where(lit, np.abs(first - 0.5 * total), np.inf)
            return _cut(r, axis, int(away.argmin()))
    return None


def _variance_cut(table: Array, r: _Region, dark: float) -> tuple[_Region, _Region] | None:
    total = _sums(table, r)
    best, parts = np.inf, None
    for axis in (0, 1):
        first = _prefixes(table, r, axis)
        lit = (first[:, 0] > dark) & (total[0] - first[:, 0] > dark)
        if lit.any():
            larger = np.maximum(_variance(first), _variance(total - first))
            larger = np.where(lit, larger, np.inf)
            at = int(larger.argmin())
            if larger[at] < best:
                best, parts = float(larger[at]), _cut(r, axis, at)
    return parts


def _as_lights(grid: Array, regions: list[_Region]) -> Lights:
    sums = np.array([grid[r.top : r.bottom, r.left : r.right].sum(axis=(0, 1)) for r in regions])
    sums = sums[np.argsort(-sums[:, 1], kind="stable")]
    toward, length = sums[:, 2:5], np.linalg.norm(sums[:, 2:5], axis=-1, keepdims=True)
    # Without light, or with the same from everywhere, there is no centroid: any direction serves.
    ok = length > 1e-12 * sums[:, 1:2]
    unit = np.where(ok, toward / np.where(ok, length, 1), [0.0, 1.0, 0.0])
    return Lights(unit, sums[:, 5:].copy(), sums[:, 0].copy())


def _radius(solid_angle: float) -> float:
    """Return the angular radius of a disc, without the cancellation of 1 - cos."""
    return float(2 * np.arcsin(min(1.0, np.sqrt(solid_angle / (4 * np.pi)))))


def _angles(directions: Array, axis: Array) -> Array:
    chord = np.linalg.norm(directions - axis, axis=-1)
    angles: Array = 2 * np.arcsin(np.minimum(1, 0.5 * chord))
    return angles


class _Found(NamedTuple):
    sun: Sun
    region: NDArray[np.bool_]


# What makes a sun: this much above the surround, and all of it this near its brightest texel.
_CONTRAST = 10.0
_LARGEST = np.radians(10.0)
# Down to this part of its brightness a texel belongs to the sun for sure.
_CORE = 0.1


def find_sun(t: _Texels) -> _Found | None:
    peak = int(np.argmax(t.luminance))
    angle = _angles(t.direction, t.direction[peak])
    near = angle <= 2 * _LARGEST
    step = float(np.sqrt(t.weight[near].max()))
    dull = float(np.median(t.luminance[near]))
    if not t.luminance[peak] > dull:
        return None
    core = np.sort(angle[near & (t.luminance > dull + _CORE * (t.luminance[peak] - dull))])
    # From the peak outward, as far as there is a bright texel in every step.
    gaps = np.flatnonzero(np.diff(core) > 1.5 * step)
    last = float(core[gaps[0]] if len(gaps) else core[-1])
    reach = last + 1.5 * step
    if last > _LARGEST:
        return None
    region = angle <= reach
    ring = (angle > reach) & (angle <= max(1.5 * reach, reach + 3 * step))
    surround = np.median(t.light[ring], axis=0) if ring.any() else np.zeros(t.light.shape[1])
    dull = float(np.median(t.luminance[ring])) if ring.any() else 0.0
    highest = float(t.luminance[peak]) - dull
    if not highest > _CONTRAST * max(dull, 0.0):
        return None
    above = (t.luminance[region] - dull) * t.weight[region]
    if not above.sum() > 0:  # a bright texel among deep negative ones is noise
        return None
    toward = above @ t.direction[region]
    sun = Sun(
        direction=toward / np.linalg.norm(toward),
        solid_angle=float(above.sum()) / highest,
        irradiance=t.weight[region] @ (t.light[region] - surround),
        surround=surround,
        reach=reach,
    )
    return _Found(sun, region)


def sun(
    image: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
) -> Sun | None:
    """Find the sun of an image: its brightest source, if that is small and far above the rest.

    Parameters
    ----------
    image, projection, axes, rotation, luminance, skipna
        As for `lights`.

    Returns
    -------
    sun : Sun or None
        None where the brightest texel is not 10 times brighter than what surrounds it, or its
        like reach further than 10 degrees.

    Raises
    ------
    ValueError, TypeError
        As for `lights`.

    Notes
    -----
    From the brightest texel outward, everything counts up to the first gap in the texels above a
    tenth of it, and one and a half texels more for its blurred edge. The surround is the median of
    a ring around that.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.full((64, 128), 0.5)
    >>> sky[20, 40] = 1000
    >>> found = sm.light.sun(sky, "latlong")
    >>> bool(np.allclose(found.direction, sm.directions("latlong", 64)[20, 40]))
    True
    """
    found = find_sun(lit_texels(image, projection, axes, rotation, luminance, skipna))
    return None if found is None else found.sun


def remove_sun(
    image: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
) -> tuple[NDArray[np.floating[Any]], Sun | None]:
    """Return the image with its sun painted over by the surround, and the sun.

    Parameters
    ----------
    image, projection, axes, rotation, luminance, skipna
        As for `lights`.

    Returns
    -------
    image : ndarray
        A copy, float32 or float64. What it lost is the sun's irradiance.
    sun : Sun or None
        As `sun` finds it. Without one the image is as it was.

    Raises
    ------
    ValueError, TypeError
        As for `lights`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.full((64, 128), 0.5)
    >>> sky[20, 40] = 1000
    >>> dull, found = sm.light.remove_sun(sky, "latlong")
    >>> float(dull.max())
    0.5
    >>> bool(np.allclose(sm.light.add_sun(dull, "latlong", found), sky))
    True
    """
    t = lit_texels(image, projection, axes, rotation, luminance, skipna)
    result = t.image.copy()
    found = find_sun(t)
    if found is None:
        return result, None
    flat = result.reshape(-1, t.light.shape[1])
    flat[t.held[found.region]] = found.sun.surround.astype(result.dtype)
    return result, found.sun


def add_sun(
    image: ArrayLike,
    projection: ProjectionLike,
    sun: Sun,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the image with a sun added: a disc of its solid angle and irradiance.

    Parameters
    ----------
    image, projection, axes, rotation, skipna
        As for `lights`.
    sun : Sun
        From `sun` or `remove_sun`, of this image or another. Its `solid_angle` may be anything: a
        disc narrower than a texel fills the texel that it is in, to the same irradiance.

    Returns
    -------
    image : ndarray
        A copy, float32 or float64. What it gained is the sun's irradiance.

    Raises
    ------
    ValueError
        As for `lights`, and where the image does not cover the sun or has other channels.
    TypeError
        As for `lights`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> true = sm.light.Sun(np.array([0.0, 1.0, 0.0]), 6.8e-5, np.array([1.5]), np.zeros(1), 0.01)
    >>> sky = sm.light.add_sun(np.zeros((64, 128)), "latlong", true)
    >>> bool(np.isclose(np.vdot(sky, sm.solid_angle("latlong", 64)), 1.5))
    True
    """
    # No luminance is needed, so any number of channels will do.
    shape = np.shape(image)
    flat_image = len(shape) == spatial_axes(resolve(projection, axes))
    ones = np.ones(1 if flat_image or not shape else shape[-1])
    t = lit_texels(image, projection, axes, rotation, ones, skipna)
    if sun.irradiance.shape != (t.light.shape[1],):
        raise ValueError(
            f"Expected a sun of {t.light.shape[1]} channels, got {len(sun.irradiance)}."
        )
    if not resolve(projection, axes).covers(sun.direction, rotation=rotation):
        raise ValueError(f"The image does not cover the sun at {sun.direction.tolist()}.")
    angle = _angles(t.direction, sun.direction)
    # A texel's width is the width of the disc's blurred edge.
    share = np.clip(0.5 + (_radius(sun.solid_angle) - angle) / np.sqrt(t.weight), 0, 1)
    nearest = angle <= angle.min() * (1 + 1e-9)
    if sun.solid_angle <= t.weight[nearest].max() or not share.any():
        share = nearest.astype(np.float64)
    lit = np.flatnonzero(share)
    result = t.image.copy()
    flat = result.reshape(-1, t.light.shape[1])
    gain = share[lit, np.newaxis] * (sun.irradiance / float(share[lit] @ t.weight[lit]))
    flat[t.held[lit]] = (t.light[lit] + gain).astype(result.dtype)
    return result
