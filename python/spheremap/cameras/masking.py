"""Which pixels of a rig's views count: those nearest to an axis, without the photographer."""

from __future__ import annotations

import math
import struct
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array, as_doubles
from .._scalars import as_flag, as_number
from ..map.grid import row_blocks
from .views import Rig
from .weights import along, axis

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection

    Mask = NDArray[np.bool_]

__all__ = ["expect_masks", "masks", "write_mask"]


def masks(
    rig: Rig,
    /,
    *,
    nearest: bool = True,
    photographer: float | None = None,
    down: ArrayLike | None = None,
) -> list[NDArray[np.bool_]]:
    """Return which pixels of each view count.

    Parameters
    ----------
    rig : Rig
        The cameras, with their poses.
    nearest : bool
        Whether a pixel counts in the view alone to whose axis its direction is nearest; at equal
        angles in the first. Structure from motion then sees everything once.
    photographer : float, optional
        The half angle in degrees of a cone around straight down, in which nothing counts: who
        holds the camera, a tripod.
    down : array_like, shape (3,), optional
        What is down in the rig's world; by default that of its first camera's.

    Returns
    -------
    list of ndarray of bool
        A mask for each view, of its size: True where a pixel counts. `stitch` takes them, and
        `write` for other programs.

    Raises
    ------
    ValueError, TypeError
        For what is no rig, an angle outside (0, 180), or a `down` without a direction.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> rig = sm.cameras.rig(64, fov=90, overlap=0.2)
    >>> masks = sm.cameras.masks(rig, photographer=30)
    >>> masks[0].shape, masks[0].dtype.name
    ((64, 64), 'bool')

    Together they see everything once, but the cone:

    >>> area = [sm.solid_angle(view.camera, view.size) for view in rig]
    >>> seen = sum(float(a[mask].sum()) for a, mask in zip(area, masks))
    >>> cone = (1 - np.cos(np.radians(30))) / 2
    >>> round(seen / (4 * np.pi), 2), float(round(1 - cone, 2))
    (0.93, 0.93)
    """
    if not isinstance(rig, Rig):
        raise TypeError(f"Expected `rig` to be a Rig, got {type(rig).__name__}.")
    if len(rig) == 0:
        raise ValueError("Expected `rig` to have at least one view, got none.")
    only = as_flag(nearest, "nearest")
    angle = None
    if photographer is not None:
        angle = as_number(photographer, "photographer")
        if not 0 < angle < 180:
            raise ValueError(f"Expected `photographer` to be in (0, 180), got {angle:g}.")
    below = _down(rig[0].projection) if down is None else as_doubles(down, "down")
    if below.shape != (3,):
        raise ValueError(f"Expected `down` to have shape (3,), got {below.shape}.")
    length = float(np.linalg.norm(below))
    if not (length > 0 and math.isfinite(length)):
        raise ValueError("Expected `down` to be a direction, got one without a length.")
    axes = np.stack([axis(view.projection) for view in rig])
    found = []
    for k, view in enumerate(rig):
        mask = np.empty(view.size, bool)
        for rows, directions in row_blocks(view.projection, view.size):
            seen = np.asarray(~np.isnan(directions[..., 0]))
            if only:
                seen &= (directions @ axes.T).argmax(axis=-1) == k
            if angle is not None:
                seen &= directions @ (below / length) < math.cos(math.radians(angle))
            mask[rows] = seen
        found.append(mask)
    return found


def expect_masks(given: Any, rig: Rig) -> list[Mask]:
    """Return masks as arrays of bool, one of each view's size, or raise."""
    found = [as_array(mask, "masks") for mask in given]
    if len(found) != len(rig):
        raise ValueError(
            f"Expected `masks` to have one for each of {len(rig)} views, got {len(found)}."
        )
    for mask, view in zip(found, rig, strict=True):
        if mask.dtype != np.bool_:
            raise TypeError(f"Expected `masks` to be of bool, got dtype {mask.dtype}.")
        if mask.shape != view.size:
            raise ValueError(
                f"Expected the mask of {view.name!r} to have shape {view.size}, got {mask.shape}."
            )
    return found


def write_mask(path: Path, mask: Mask) -> None:
    """Write a mask as PNG, 255 where a pixel counts.

    Source: Portable Network Graphics (third edition), W3C 2025: chunks IHDR, IDAT and IEND. It is
    written here, since programs ask for this very format, and files need a library otherwise.
    """
    height, width = mask.shape
    # A zero before each row: as it is, no filter.
    rows = np.zeros((height, width + 1), np.uint8)
    rows[:, 1:] = np.where(mask, 255, 0)
    parts = [
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows.tobytes(), 6)),
        (b"IEND", b""),
    ]
    data = b"\x89PNG\r\n\x1a\n"
    for kind, content in parts:
        sum_of = zlib.crc32(kind + content)
        data += struct.pack(">I", len(content)) + kind + content + struct.pack(">I", sum_of)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def _down(camera: Projection) -> NDArray[np.float64]:
    """Return what is down in the world that a camera is made for."""
    return -along(camera.world, 1)
