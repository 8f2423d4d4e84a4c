"""Places in an image counted in pixels, and the directions that are seen there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .._arrays import BLOCK, as_points, blocks, expect_room, spatial_axes
from .._scalars import as_text
from .grid import cells, coordinate, on_corners, texel
from .images import target_shape
from .named import resolve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Size
    from .._projection import Projection
    from .named import ProjectionLike

__all__ = ["directions_to_pixels", "pixels_to_directions"]

# Where the center of the first pixel is.
_FIRST = {"half": 0.5, "integer": 0.0}

# Past the methods of the subclass, which would resolve once more.
_Core = _core.Projection


def pixels_to_directions(
    pixels: ArrayLike,
    /,
    projection: ProjectionLike,
    size: Size,
    *,
    centers: Literal["half", "integer"] = "half",
    axes: str | None = None,
    rotation: Any | None = None,
    any_aspect: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the directions that are seen at places of an image, in pixels.

    Parameters
    ----------
    pixels : array_like, shape (..., 2), or (..., 3) for an array of faces
        x runs right and y runs down, both in pixels; the third is the number of the face. Fractions
        are places within a pixel.
    projection, axes, rotation
        As for `encode`.
    size : int or tuple of int
        Of the image, as for `solid_angle`.
    centers : {"half", "integer"}
        Where the center of the first pixel is. "half": at (0.5, 0.5), and (0, 0) is the image's
        upper left corner, as everywhere in this library. "integer": at (0, 0), as OpenCV counts,
        and as the indices of an array do: the texel ``image[y, x]`` is at (x, y).
    any_aspect : bool
        As for `solid_angle`.

    Returns
    -------
    directions : ndarray, shape (..., 3)
        Unit length; float32 for float16 and float32 input, else float64. NaN outside the valid
        image.

    Raises
    ------
    ValueError
        For a wrong shape, an unknown name, or a size that the projection cannot have.
    TypeError
        For complex numbers and objects.

    See Also
    --------
    directions : The direction of every texel.

    Notes
    -----
    On a grid of centers u = x/W and v = y/H. On a grid of corners the centers of the outermost
    texels lie on the edges of the image or the face, u = (x - 1/2)/(W - 1), and their outer halves
    see nothing.

    Examples
    --------
    What the first texel of a panorama sees, and the one in row 1 and column 4:

    >>> import numpy as np, spheremap as sm
    >>> d = sm.pixels_to_directions([0.5, 0.5], "latlong", 4)
    >>> bool((d == sm.directions("latlong", 4)[0, 0]).all())
    True
    >>> d = sm.pixels_to_directions([4, 1], "latlong", 4, centers="integer")
    >>> bool((d == sm.directions("latlong", 4)[1, 4]).all())
    True
    """
    p = resolve(projection, axes, rotation)
    shape, first = target_shape(p, size, any_aspect), _first(centers)
    sides = _sides(p, shape)
    array, single = as_points(pixels, "pixels", None)
    width = spatial_axes(p)
    if array.shape[-1:] != (width,):
        raise ValueError(f"Expected `pixels` to have shape (..., {width}), got {array.shape}.")
    dtype = np.dtype(np.float32 if single else np.float64)
    expect_room((*array.shape[:-1], 3), dtype)
    found: NDArray[np.floating[Any]] = np.empty((*array.shape[:-1], 3), dtype)
    if not found.size:
        return found
    flat, done = found.reshape(-1, 3), 0
    for block in blocks(array, single):
        places = block.reshape(-1, width)
        uv = np.empty_like(places)
        # A signaling NaN would warn.
        with np.errstate(all="ignore"):
            for k, side in enumerate(sides):
                uv[:, k] = coordinate(places[:, k] - first, *side)
        uv[:, 2:] = places[:, 2:]
        _Core.decode(p, uv, flat[done : done + len(uv)])
        done += len(uv)
    return found


def directions_to_pixels(
    directions: ArrayLike,
    /,
    projection: ProjectionLike,
    size: Size,
    *,
    centers: Literal["half", "integer"] = "half",
    axes: str | None = None,
    rotation: Any | None = None,
    any_aspect: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the places of an image at which directions are seen, in pixels.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection, axes, rotation, size, any_aspect
        As for `pixels_to_directions`.
    centers : {"half", "integer"}
        As for `pixels_to_directions`: the center of the first pixel is (0.5, 0.5), or (0, 0), as
        OpenCV counts and as ``cv2.remap`` wants it.

    Returns
    -------
    pixels : ndarray, shape (..., 2), or (..., 3) for an array of faces
        x runs right and y runs down; the third is the number of the face. float32 for float16 and
        float32 input, else float64. NaN for a direction outside the coverage, zero, or not finite.

    Raises
    ------
    ValueError, TypeError
        As for `pixels_to_directions`.

    See Also
    --------
    RemapPlan.maps : The same for every texel of another image.

    Notes
    -----
    With "half" the texel that holds a direction is ``image[int(y), int(x)]``, but at the right and
    lower edge of an image on a grid of centers, where x = W or y = H.

    Examples
    --------
    What is straight ahead is in the middle of a panorama:

    >>> import spheremap as sm
    >>> sm.directions_to_pixels([0, 0, -1], "latlong", (512, 1024)).tolist()
    [512.0, 256.0]
    >>> sm.directions_to_pixels([0, 0, -1], "latlong", (512, 1024), centers="integer").tolist()
    [511.5, 255.5]
    """
    p = resolve(projection, axes, rotation)
    shape, first = target_shape(p, size, any_aspect), _first(centers)
    sides = _sides(p, shape)
    found = _Core.encode(p, directions)
    flat = found.reshape(-1, found.shape[-1]) if found.size else found[:0]
    for start in range(0, len(flat), BLOCK):
        part = flat[start : start + BLOCK]
        for k, side in enumerate(sides):
            part[:, k] = texel(part[:, k], *side) + first
    return found


def _first(centers: str) -> float:
    if as_text(centers, "centers") not in _FIRST:
        raise ValueError(f"Expected `centers` to be 'half' or 'integer', got {centers!r}.")
    return _FIRST[centers]


def _sides(p: Projection, shape: tuple[int, ...]) -> tuple[tuple[int, int, bool], ...]:
    """Return what `coordinate` and `texel` want to know, for x and for y."""
    height, width = shape[-2:]
    (cells_v, cells_u), (corners_v, corners_u) = cells(p), on_corners(p)
    return (width, cells_u, corners_u), (height, cells_v, corners_v)
