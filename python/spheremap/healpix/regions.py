"""Pixels in regions of the sphere, and between which pixels a place lies."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from .._arrays import as_unit_vectors, expect_room
from .._scalars import as_flag, as_number, as_whole
from ..map.named import resolve
from .numbers import (
    MAX_NSIDE,
    as_angles,
    as_nside,
    bring_into_range,
    cells,
    nside2npix,
    pix2vec,
    ring2nest,
)

if TYPE_CHECKING:
    from typing import SupportsIndex

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Pixels = NDArray[np.int64]

# Parts along a side of a pixel; each is looked at.
_MOST_PARTS = 64

# Parts that are looked at at a time.
_BLOCK = 1 << 18


def query_disc(
    nside: SupportsIndex,
    direction: ArrayLike,
    radius: float,
    /,
    inclusive: bool = False,
    fact: SupportsIndex = 4,
    nest: bool = False,
) -> Pixels:
    """Return the pixels in a disc on the sphere.

    Parameters
    ----------
    nside : int
        As for `vec2pix`.
    direction : array_like, shape (3,)
        Toward the middle of the disc; of any length.
    radius : float
        Of the disc, from 0 to π, in radians.
    inclusive : bool
        Return every pixel that meets the disc, and a few that come near it; else those whose
        centers lie in it.
    fact : int
        How closely an inclusive query looks: a pixel comes near if one of fact² parts of it does,
        by its center and the largest distance of a corner from there. At most 64.
    nest : bool
        Return nested numbers; then `nside` and `fact` are powers of two.

    Returns
    -------
    pixels : ndarray of int64, shape (K,)
        In ascending order.

    Raises
    ------
    ValueError
        For an `nside`, `direction`, `radius` or `fact` that does not exist.
    TypeError
        For input of other kinds.

    Examples
    --------
    >>> from spheremap import healpix
    >>> healpix.query_disc(8, [0, 0, 1], 0.3).tolist()
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]
    >>> len(healpix.query_disc(8, [0, 0, 1], 0.3, inclusive=True))
    24
    """
    n, nest = _division(nside, nest)
    inclusive = as_flag(inclusive, "inclusive")
    fact = _fact(fact, n, nest) if inclusive else as_whole(fact, "fact")
    center = _toward(direction, "direction", 1)[0]
    size = as_number(radius, "radius")
    if not 0 <= size <= math.pi:
        raise ValueError(f"`radius` must be from 0 to π, got {size:g}.")
    if not inclusive:
        return _numbers(n, _within(n, center, size), nest)
    pixels = _within(n, center, size + _pixel_radius(n))
    return _numbers(n, pixels[_near(n, fact, pixels, [(center, size)], nest)], nest)


def query_polygon(
    nside: SupportsIndex,
    vertices: ArrayLike,
    /,
    inclusive: bool = False,
    fact: SupportsIndex = 4,
    nest: bool = False,
) -> Pixels:
    """Return the pixels in a convex polygon on the sphere, whose sides are great circles.

    Parameters
    ----------
    nside : int
        As for `vec2pix`.
    vertices : array_like, shape (V, 3)
        Directions of the corners in order, either way round; at least three.
    inclusive, fact, nest
        As for `query_disc`; a part is near if it is near to every side, and to the smallest disc
        around the polygon. Nested numbers are those of healpy, which finds some more in ring order.

    Returns
    -------
    pixels : ndarray of int64, shape (K,)
        In ascending order.

    Raises
    ------
    ValueError
        For vertices that are no convex polygon, and as for `query_disc`.
    TypeError
        For input of other kinds.

    Examples
    --------
    >>> from spheremap import healpix
    >>> corners = [[1, 0.3, 0], [1, -0.3, 0], [1, 0, 0.4]]
    >>> healpix.query_polygon(4, corners).tolist()
    [72, 88, 103]
    """
    n, nest = _division(nside, nest)
    inclusive = as_flag(inclusive, "inclusive")
    fact = _fact(fact, n, nest) if inclusive else as_whole(fact, "fact")
    corners = _toward(vertices, "vertices", 3)
    sides = _inward(corners)
    middle, size = _smallest_disc(corners)
    if not inclusive:
        # A disc smaller than half the sphere holds all between its points.
        pixels = _within(n, middle, size + 1e-9 if size < 1.5 else math.pi)
        inside = np.all(pix2vec(n, pixels) @ sides.T >= 0, axis=-1)
        return _numbers(n, pixels[inside], nest)
    pixels = _within(n, middle, size + _pixel_radius(n) if size < 1.5 else math.pi)
    discs = [(side, math.pi / 2) for side in sides] + [(middle, size)]
    return _numbers(n, pixels[_near(n, fact, pixels, discs, nest)], nest)


def interpolation_weights(
    nside: SupportsIndex,
    theta: ArrayLike,
    phi: ArrayLike,
    /,
    nest: bool = False,
    lonlat: bool = False,
) -> tuple[Pixels, Floats]:
    """Return the four pixels around places, and their weights in bilinear interpolation.

    Parameters
    ----------
    nside : int
        As for `vec2pix`.
    theta, phi, nest, lonlat
        As for `ang2pix`.

    Returns
    -------
    pixels : ndarray of int64, shape (..., 4)
        Two on the ring to the north and two on that to the south; -1 where an angle is not finite,
        or a longitude 2⁵⁰ half turns and more.
    weights : ndarray of float64, shape (..., 4)
        They sum to 1; NaN where there are no pixels.

    Raises
    ------
    ValueError, TypeError
        As for `ang2pix`.

    Notes
    -----
    Linear in longitude on both rings, and in the polar angle between them. Beyond the first and the
    last ring the pole has the mean of that ring's four pixels. It is what healpy's
    ``get_interp_weights`` gives; ``sample(..., filter="bilinear")`` interpolates on the faces.

    Examples
    --------
    >>> from spheremap import healpix
    >>> pixels, weights = healpix.interpolation_weights(2, 1.0, 0.7)
    >>> pixels.tolist(), weights.round(3).tolist()
    ([4, 5, 12, 13], [0.361, 0.232, 0.044, 0.363])
    """
    n, nest = _division(nside, nest)
    lonlat = as_flag(lonlat, "lonlat")
    angles = as_angles(theta, phi)
    expect_room((*angles.shape[:-1], 8), np.dtype(np.int64))
    found = _core.healpix_interpolation(n, angles, nest=nest, lonlat=lonlat)
    if np.min(found[0], initial=0) < 0 and bring_into_range(angles, lonlat):
        return _core.healpix_interpolation(n, angles, nest=nest, lonlat=lonlat)
    return found


def _division(nside: SupportsIndex, nest: bool) -> tuple[int, bool]:
    n, nest = as_nside(nside), as_flag(nest, "nest")
    if nest and n & (n - 1):
        raise ValueError(f"`nside` must be a power of two in nested order, got {n}.")
    return n, nest


def _fact(fact: SupportsIndex, n: int, nest: bool) -> int:
    number = as_whole(fact, "fact")
    most = min(MAX_NSIDE // n, _MOST_PARTS)
    if not 1 <= number <= most:
        raise ValueError(f"`fact` must be from 1 to {most}, got {number}.")
    if nest and number & (number - 1):
        raise ValueError(f"`fact` must be a power of two in nested order, got {number}.")
    return number


def _toward(directions: ArrayLike, name: str, least: int) -> Floats:
    """Return (V, 3) unit vectors, or raise."""
    unit, leading = as_unit_vectors(directions, name)
    if len(leading) != (least > 1) or len(unit) < least:
        pattern = "(V, 3), V at least 3" if least > 1 else "(3,)"
        raise ValueError(f"Expected `{name}` to have shape {pattern}, got {(*leading, 3)}.")
    if not np.isfinite(unit).all():
        raise ValueError(f"Expected `{name}` to be finite and not zero.")
    return unit


def _numbers(n: int, ring: Pixels, nest: bool) -> Pixels:
    return np.sort(ring2nest(n, ring)) if nest else ring


def _pixel_radius(n: int) -> float:
    """Return the largest distance of a pixel's center from one of its corners.

    It is that of the pixel on the parallel where caps and belt meet, to its northern corner. It is
    rounded up: what touches is near.
    """
    z, height = 2 / 3, (1 - 1 / n) ** 2 / 3
    turn = math.pi / (4 * n)
    a = np.array([math.sqrt(1 - z * z) * math.cos(turn), math.sqrt(1 - z * z) * math.sin(turn), z])
    b = np.array([math.sqrt(height * (2 - height)), 0, 1 - height])
    return math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b)) + 1e-13


def _rings(n: int, ring: Pixels) -> tuple[Pixels, Pixels, Floats, Floats]:
    """Return rings' first pixels, pixels, centers' shift in pixels, and polar angles."""
    nearer = np.minimum(ring, 4 * n - ring)
    short = nearer < n
    quadrant = np.where(short, nearer, n)
    cap = 2 * quadrant * (quadrant - 1)
    first = np.where(ring < n, cap, 2 * n * (n - 1) + 4 * n * (ring - n))
    first = np.where(ring > 3 * n, nside2npix(n) - 2 * quadrant * (quadrant + 1), first)
    shift = np.where(short | ((ring - n) % 2 == 0), 0.5, 0.0)
    polar = 2 * np.arcsin(quadrant / (math.sqrt(6) * n))
    belt = np.arccos(np.clip((2 * n - ring) * (2 / (3 * n)), -1, 1))
    angle = np.where(short, np.where(ring < n, polar, math.pi - polar), belt)
    return first, 4 * quadrant, shift, angle


def _rings_above(n: int, theta: Floats) -> Pixels:
    """Return how many rings lie north of polar angles, or on them."""
    z = np.cos(theta)
    cap = math.sqrt(6) * n * np.sin(np.minimum(theta, math.pi - theta) / 2)
    belt = 2 * n - 1.5 * n * z
    guess = np.where(np.abs(z) <= 2 / 3, belt, np.where(z > 0, cap, 4 * n - cap))
    above = np.clip(np.floor(guess).astype(np.int64), 0, 4 * n - 1)
    # Rounding may put it one off, either way.
    below = np.minimum(above + 1, 4 * n - 1)
    above = np.where(_rings(n, below)[3] <= theta, below, above)
    return above - ((above > 0) & (_rings(n, np.maximum(above, 1))[3] > theta))


def _within(n: int, center: Floats, reach: float) -> Pixels:
    """Return the ring numbers of pixels whose centers lie within a distance, ascending."""
    reach = min(reach, math.pi)
    x, y, z = center.tolist()
    tilt, turn = math.atan2(math.hypot(x, y), z), math.atan2(y, x)
    # Before anything is made that large.
    expect_room((int(nside2npix(n) * (1 - math.cos(reach)) / 2),), np.dtype(np.int64))
    ends = np.array([max(tilt - reach, 0.0), min(tilt + reach, math.pi)])
    above = _rings_above(n, ends)
    ring = np.arange(max(int(above[0]), 1), min(int(above[1]) + 1, 4 * n - 1) + 1)
    first, count, shift, angle = _rings(n, ring)
    # Of two places with angles a and b between parallels and meridians:
    # sin² of half the distance is sin²(a/2) + sin θ sin θ' sin²(b/2).
    rest = math.sin(reach / 2) ** 2 - np.sin((angle - tilt) / 2) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        share = rest / (np.sin(angle) * math.sin(tilt))
    whole = (rest >= 0) & ~(share < 1)
    half = 2 * np.arcsin(np.sqrt(np.clip(np.nan_to_num(share), 0, 1)))
    low = np.ceil((turn - half) * count / (2 * math.pi) - shift).astype(np.int64)
    high = np.floor((turn + half) * count / (2 * math.pi) - shift).astype(np.int64)
    low, high = np.where(whole, 0, low), np.where(whole, count - 1, high)
    length = np.where(rest >= 0, np.clip(high - low + 1, 0, count), 0)
    # What goes on beyond a ring's last pixel comes first.
    start = low % count
    wrapped = np.maximum(start + length - count, 0)
    starts = first[:, None] + np.stack([np.zeros_like(start), start], -1)
    return _core.healpix_runs(starts, np.stack([wrapped, length - wrapped], -1))


def _near(
    n: int, fact: int, pixels: Pixels, discs: list[tuple[Floats, float]], nest: bool
) -> NDArray[np.bool_]:
    """Tell the pixels that come near to all discs: one of fact² parts of each does.

    In nested order what that lies in of every coarser division does, too. So it is in healpy.
    """
    found = np.empty(len(pixels), np.bool_)
    step = max(_BLOCK // fact**2, 1)
    finest = n * fact
    for first in range(0, len(pixels), step):
        face, cell, _ = cells(n, pixels[first : first + step], nest=False)
        good, above = np.zeros(len(cell), np.bool_), np.ones(len(cell), np.bool_)
        for level in _levels(1, n) if nest else ():
            above &= _meets(level, face, cell // (n // level), discs)
        for part in itertools.product(range(fact), repeat=2):
            fine = cell * fact + part
            inside = _meets(finest, face, fine, discs)
            for level in _levels(2 * n, finest // 2) if nest else ():
                inside &= _meets(level, face, fine // (finest // level), discs)
            good |= inside
        found[first : first + step] = good & above
    return found


def _levels(first: int, last: int) -> list[int]:
    """Return the divisions from one to another, each with halves of the one before."""
    return [first << k for k in range((last // first).bit_length())] if last >= first else []


def _meets(
    n: int, face: Floats, cell: Floats, discs: list[tuple[Floats, float]]
) -> NDArray[np.bool_]:
    """Tell which cells of a division come near to all discs."""
    uv = np.concatenate([(cell + 0.5) / n, face[:, None]], -1)
    centers = resolve("healpix").decode(uv)
    radius = _pixel_radius(n)
    near = [
        np.square(centers - middle).sum(-1) <= 4 * math.sin(min(size + radius, math.pi) / 2) ** 2
        for middle, size in discs
    ]
    return np.asarray(np.all(near, axis=0))


def _inward(corners: Floats) -> Floats:
    """Return the normals of a convex polygon's sides toward its inside, or raise."""
    normals = np.cross(corners, np.roll(corners, -1, axis=0))
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    if (length < 1e-15).any():
        raise ValueError("Expected neighboring `vertices` to differ, and not to be opposite.")
    normals /= length
    # All other corners lie on one side of each.
    heights = normals @ corners.T
    count = len(corners)
    for k in range(count):
        heights[k, [k, (k + 1) % count]] = 0
    if (heights > -1e-14).all():
        return normals
    if (heights < 1e-14).all():
        return np.asarray(-normals)
    raise ValueError("Expected `vertices` to be those of a convex polygon.")


def _smallest_disc(points: Floats) -> tuple[Floats, float]:
    """Return the middle and radius of the smallest disc that holds points.

    After E. Welzl, "Smallest enclosing disks (balls and ellipsoids)", 1991: a point outside the
    disc of those before it lies on the border of the disc with it.
    """

    def spanned(*some: Floats) -> tuple[Floats, float]:
        a, b = some[:2]
        middle = a + b if len(some) == 2 else np.cross(b - a, some[2] - a)
        if middle @ a < 0:
            middle = -middle
        middle = middle / max(float(np.linalg.norm(middle)), 1e-300)
        return middle, float(np.linalg.norm(a - middle))

    def outside(disc: tuple[Floats, float], p: Floats) -> bool:
        return bool(np.linalg.norm(p - disc[0]) > disc[1] + 1e-14)

    disc = spanned(points[0], points[1])
    for i, p in enumerate(points):
        if not outside(disc, p):
            continue
        disc = spanned(points[0], p)
        for j, q in enumerate(points[:i]):
            if not outside(disc, q):
                continue
            disc = spanned(q, p)
            for r in points[:j]:
                if outside(disc, r):
                    disc = spanned(r, q, p)
    return disc[0], 2 * math.asin(min(disc[1] / 2, 1.0))
