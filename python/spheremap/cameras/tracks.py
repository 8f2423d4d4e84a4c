"""The two tracks of a GoPro MAX as one equi-angular cube: where both lenses see, they are blended.

Source: Bourke 2021, GoPro MAX 360 Action Cam movie layout/format, and the program that goes with
it, MAX2sphere. Each track holds three faces of a cube. Of the outer ones, which both lenses see,
one half is the one lens's and the other half the other's; each half goes on beyond the middle, by
half of what both see.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._arrays import as_image
from .._scalars import as_whole
from ..resample import sample_uv
from .exposure import coded, expect_curve, light_of_codes
from .pictures import exact

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .exposure import Curve

__all__ = ["gopro"]

# How many columns both lenses fill, by the height of a track: MAX at 5.6K and 3K, MAX 2 at 8K.
OVERLAPS = {1344: 64, 736: 32, 1920: 128}


def gopro(
    front: ArrayLike,
    rear: ArrayLike,
    /,
    *,
    overlap: int | None = None,
    exposure: Literal["match"] | None = None,
    curve: Curve = "srgb",
) -> NDArray[Any]:
    """Return the frames of both tracks of a GoPro's .360 file as one equi-angular cube.

    Parameters
    ----------
    front, rear : array_like, shape (N, W) or (N, W, C)
        A frame of the first video track, with the left, front and right faces, and the same one of
        the second, with the lower, rear and upper ones on their side. The middle face is N wide,
        and each outer one (W - N)/2.
    overlap : int, optional
        How many columns in the middle of an outer face are there twice, once of each lens. It is
        known for frames of 4096 × 1344, 2272 × 736 and 5888 × 1920 pixels.
    exposure : "match" or None
        Whether the light of each lens is multiplied so that both are as bright where both see.
    curve : {"srgb", "linear"}
        What integers are, where light is multiplied. Floats are light as they are.

    Returns
    -------
    ndarray, shape (2N, 3N) or (2N, 3N, C)
        The projection ``"cube_equiangular:ffmpeg-eac"``, which every verb takes. In the middles of
        its outer faces one lens goes over into the other.

    Raises
    ------
    ValueError, TypeError
        For frames of different shapes or dtypes, or whose outer faces hold no such `overlap`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> front = rear = np.full((1344, 4096), 90, np.uint8)
    >>> eac = sm.cameras.gopro(front, rear)
    >>> eac.shape
    (2688, 4032)
    >>> sm.convert(eac, "cube_equiangular:ffmpeg-eac", "latlong", size=64).min()
    np.uint8(90)
    """
    curve_of = expect_curve(curve)
    if exposure is not None and exposure != "match":
        raise ValueError(f"Expected `exposure` to be 'match' or None, got {exposure!r}.")
    tracks = [as_image(track, None, name) for track, name in ((front, "front"), (rear, "rear"))]
    first, second = tracks
    if first.shape != second.shape or first.dtype != second.dtype:
        raise ValueError(
            f"Expected `front` and `rear` of one shape and dtype, got {first.shape} of "
            f"{first.dtype} and {second.shape} of {second.dtype}."
        )
    height, width = _frame(first.shape)
    side = (width - height) // 2
    both = _overlap(overlap, height, width, side)
    # Of the rear track, the lens in the middle is the rear one.
    gains = (1.0, 1.0) if exposure is None else _gains(tracks, height, side, both, curve_of)
    rows = [_row(tracks[k], height, side, both, (gains[k], gains[1 - k]), curve_of) for k in (0, 1)]
    found = np.concatenate(rows)
    if first.dtype.kind == "u":
        np.clip(found + 0.5, 0, np.iinfo(first.dtype).max, out=found)
    return found.reshape(found.shape[: first.ndim]).astype(first.dtype)


def _frame(shape: tuple[int, ...]) -> tuple[int, int]:
    # Halves of outer faces are whole columns.
    if len(shape) not in (2, 3) or 0 in shape or not _is_wide(*shape[:2]):
        raise ValueError(
            "Expected `front` to be a track of three faces side by side, more than three times as "
            f"wide as high, as (1344, 4096, 3), got shape {shape}."
        )
    return shape[0], shape[1]


def _is_wide(height: int, width: int) -> bool:
    return width > 3 * height and (width - height) % 4 == 0


def _overlap(given: int | None, height: int, width: int, side: int) -> int:
    if given is None:
        known = OVERLAPS.get(height)
        if known is None or known >= side:
            raise ValueError(
                f"Expected `overlap` for frames of {width} x {height} pixels, which are none of "
                "those that are known."
            )
        return known
    columns = as_whole(given, "overlap")
    if not 0 < columns < side // 2 or columns % 2:
        raise ValueError(
            f"Expected `overlap` to be even and in (0, {side // 2}), got {columns} of the {side} "
            "columns of an outer face."
        )
    return columns


def _row(
    track: NDArray[Any], height: int, side: int, both: int, gains: tuple[float, float], curve: str
) -> NDArray[Any]:
    """Return the three faces of a track, of which the gains are those of the middle and beyond."""
    channels = track if track.ndim == 3 else track[..., None]
    own, other = (_brightened(channels, gain, curve) for gain in gains)
    middle = slice(side, side + height)
    return np.concatenate(
        [
            _outer(other[:, :side], own[:, :side], both),
            own[:, middle],
            _outer(own[:, side + height :], other[:, side + height :], both),
        ],
        axis=1,
    )


def _outer(left: NDArray[Any], right: NDArray[Any], both: int) -> NDArray[Any]:
    """Return an outer face, on the left of its middle as the one has it, on the right the other."""
    height, side = left.shape[:2]
    half, apart = side / 2, side - both
    u = (np.arange(height) + 0.5) / height
    # Where a place lies among the columns that are there once, and how far it is on its way.
    place = u * apart
    share = np.clip((place - (apart - both) / 2) / both, 0, 1)[:, None]
    halves = (
        (left[:, : side // 2], place / half),
        (right[:, side - side // 2 :], (place + both - half) / half),
    )
    seen = [
        sample_uv(part, np.stack(np.broadcast_arrays(at, u[:, None]), -1)) for part, at in halves
    ]
    return np.asarray((1 - share) * seen[0] + share * seen[1], left.dtype)


def _brightened(track: NDArray[Any], gain: float, curve: str) -> NDArray[Any]:
    """Return a track's values in floats, as they are where its light is multiplied."""
    if track.dtype.kind == "u" and gain != 1:
        return np.asarray(coded(track.dtype, curve, gain)[track])
    return np.asarray(track.astype(exact(track.dtype)) * exact(track.dtype)(gain))


def _gains(
    tracks: list[NDArray[Any]], height: int, side: int, both: int, curve: str
) -> tuple[float, float]:
    """Return the gains of the front and the rear lens, of geometric mean 1."""
    sums = np.zeros(2)
    start = (side - 2 * both) // 2
    for k, track in enumerate(tracks):
        # The lens beyond the middle face fills the outer half of each outer face.
        for at, outer_first in ((start, True), (side + height + start, False)):
            pair = [track[:, at : at + both], track[:, at + both : at + 2 * both]]
            lights, known = zip(*(_light(part, curve) for part in pair), strict=True)
            counts = known[0] & known[1]
            own, other = (lights[1], lights[0]) if outer_first else lights
            sums[k] += own[counts].sum()
            sums[1 - k] += other[counts].sum()
    if not (sums > 0).all():
        return 1.0, 1.0
    ratio = float(np.sqrt(sums[1] / sums[0]))
    return ratio, 1 / ratio


def _light(part: NDArray[Any], curve: str) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return light, and where it is known: what is as bright as can be may be brighter."""
    if part.dtype.kind != "u":
        known = np.isfinite(part)
        return np.where(known, part, 0).astype(np.float64), known
    codes = light_of_codes(part.dtype, curve)
    return codes[part].astype(np.float64), part != np.iinfo(part.dtype).max
