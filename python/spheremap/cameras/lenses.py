"""Two lenses back to back, and the lenses of a raw picture that holds both."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_rotation
from ..map.named import projection, resolve
from .weights import along

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["back_to_back", "lenses_of", "parts_of"]


def back_to_back(
    first: ProjectionLike, second: ProjectionLike | None = None, /, *, pose: Any | None = None
) -> tuple[Projection, Projection]:
    """Return the two cameras of a dual fisheye: the first looks ahead, the second behind.

    Parameters
    ----------
    first : Projection or str
        A lens in its own frame: ``"angular(fov=200)"``, or what `spheremap.camera` makes of a
        calibration.
    second : Projection or str, optional
        The other lens; by default it is as the first.
    pose : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        From the second lens's frame to the first one's, as a calibration of both gives it. By
        default half a turn about what is up for the first.

    Returns
    -------
    tuple of Projection
        For `stitch`, or any other verb.

    Raises
    ------
    ValueError, TypeError
        For an unknown projection, or what is no rotation.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> cameras = sm.cameras.back_to_back("angular(fov=190)")
    >>> [camera.decode([0.5, 0.5])[2].round(6).item() for camera in cameras]
    [-1.0, 1.0]

    Two calibrated lenses, and the files of both:

    >>> front = sm.camera((18, 18, 31.5, 31.5), (64, 64), model="kannala_brandt")
    >>> back = sm.camera((17, 17, 31, 32), (64, 64), model="kannala_brandt")
    >>> pictures = [np.full((64, 64, 3), 90, np.uint8)] * 2
    >>> panorama = sm.cameras.stitch(
    ...     pictures, sm.cameras.back_to_back(front, back), "latlong", size=32, fov=200
    ... )
    >>> panorama.shape, panorama.min()
    ((32, 64, 3), np.uint8(90))
    """
    ahead = resolve(first)
    behind = ahead if second is None else resolve(second)
    if pose is None:
        up = along(ahead.world, 1)
        turn = 2 * np.outer(up, up) - np.eye(3)
    else:
        turn = as_rotation(pose, "pose")
    return ahead, behind.in_world_of(ahead).turned(turn)


def lenses_of(p: Projection) -> tuple[Projection, Projection]:
    """Return the lenses of a `dual_fisheye` as projections of their own."""
    return _lens(p, 0), _lens(p, 1)


def parts_of(image: NDArray[Any], p: Projection) -> list[NDArray[Any]]:
    """Return the pictures of both lenses, without a copy, or raise.

    Side by side they may be where nothing says how they lie: so cameras write them.
    """
    if p.layout == "faces" and image.ndim in (3, 4) and len(image) == 2:
        return [image[0], image[1]]
    rows, columns = (1, 2) if p.layout == "faces" else p.shape(2)
    beside = columns > rows
    if image.ndim in (2, 3):
        height, width = image.shape[:2]
        if (width == 2 * height) if beside else (height == 2 * width):
            return np.split(image, 2, axis=int(beside))
    raise ValueError(
        f"Expected `images` to be one raw picture of '{p.name}', two squares "
        f"{'side by side' if beside else 'one above the other'}, got shape {image.shape}."
    )


def _lens(p: Projection, face: int) -> Projection:
    """Return the lens that a cell of the picture shows: its frame is what its middle sees."""
    # The middle, a place right of it, and one below.
    u, v = np.array([0.5, 0.6, 0.5]), np.array([0.5, 0.5, 0.6])
    if p.layout == "faces":
        uv = np.stack([u, v, np.full(3, float(face))], axis=-1)
    else:
        rows, columns = p.shape(2)
        strip = columns > rows
        uv = np.stack([(u + face) / 2, v] if strip else [u, (v + face) / 2], axis=-1)
    forward, *sides = np.asarray(p.decode(uv), np.float64)
    across = [side - forward * (side @ forward) for side in sides]
    right, down = (side / np.linalg.norm(side) for side in across)
    mirrored = np.linalg.det([right, down, forward]) < 0
    frame = np.stack([-right if mirrored else right, down, forward], axis=-1)
    # To the last bit a rotation: the nearest one.
    left, _, other = np.linalg.svd(frame)
    axes = f"{'-' if mirrored else '+'}x +y +z"
    lens: Projection = projection("angular", axes=axes, world=p.world, fov=p.parameters["fov"])
    return lens.turned(left @ other)
