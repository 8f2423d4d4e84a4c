"""Depth images: the distance along the ray, and the depth along a face's axis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .._arrays import as_array, spatial_axes
from .._scalars import as_flag, as_text
from ..map.images import channels_last, expect_aspect
from ..map.named import resolve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ..map.named import ProjectionLike

__all__ = ["convert_depth"]


def convert_depth(
    depth: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    source: Literal["distance", "z"] = "distance",
    target: Literal["distance", "z"] | None = None,
    out: NDArray[Any] | None = None,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Turn distances along the ray into depths along the axis of a face, or back.

    Parameters
    ----------
    depth : array_like, shape (H, W) or (F, N, N), or either with one channel (..., 1)
        Of real numbers. NaN, infinity and 0 (as "nothing") stay what they are. A batch, as for
        `convert`, has one channel.
    projection : Projection or str
        The projection of the image.
    source : {"distance", "z"}
        What `depth` is: the distance to the eye, or the depth that a z-buffer holds, which is the
        distance times the cosine of the angle to the axis of the face.
    target : {"distance", "z"}, optional
        What to return; by default the other one.
    out : ndarray, optional
        Where to put the result; it may be `depth` itself.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    depth : ndarray, of the shape of `depth`
        float32 for float16 and float32, else float64. Where the image holds no sphere, the input.

    Raises
    ------
    ValueError
        For a kind of depth that is unknown, or a shape that the projection cannot have.
    TypeError
        For complex numbers and objects, or an `out` of another dtype.

    Notes
    -----
    Each face of several has an axis of its own, the direction of its middle, whatever the layout.
    A projection of one face has one, the forward axis of the image (a perspective whose principal
    point is moved keeps it). Behind that axis z is negative, and at a right angle to it 0, from
    where no distance comes back: it is infinite there.

    Examples
    --------
    A wall at z = 2, seen by a camera of 90° whose corner texels look past (±1/2, ±1/2, 1):

    >>> import numpy as np, spheremap as sm
    >>> wall = np.full((2, 2), 2.0)
    >>> sm.convert_depth(wall, "perspective", source="z").round(6).tolist()
    [[2.44949, 2.44949], [2.44949, 2.44949]]
    """
    p = resolve(projection)
    for name, kind in (("source", source), ("target", source if target is None else target)):
        expect_kind(kind, name)
    if target is None:
        target = "z" if source == "distance" else "distance"
    given = as_array(depth, "depth")
    if given.dtype.kind not in "fiub":
        raise TypeError(f"Expected `depth` to be real numbers, got dtype {given.dtype}.")
    single = given.dtype.kind == "f" and given.dtype.itemsize <= 4
    dtype = np.dtype(np.float32 if single else np.float64)
    dimensions = spatial_axes(p)
    shaped = (
        channels_last(given, dimensions) if as_flag(channels_first, "channels_first") else given
    )
    held = shaped.shape[1:] if shaped.ndim == dimensions + 2 else shaped.shape
    if len(held) > dimensions and held[-1] == 1:
        held = held[:-1]
    expect_aspect(p, held, any_aspect, "depth")
    shape = p.shape(held)
    if out is None:
        out = np.empty(given.shape, dtype)
    elif not isinstance(out, np.ndarray) or out.dtype != dtype:
        got = getattr(out, "dtype", type(out).__name__)
        raise TypeError(f"Expected `out` to have dtype {dtype}, got {got}.")
    elif out.shape != given.shape:
        raise ValueError(f"Expected `out` to have shape {given.shape}, got {out.shape}.")
    out[...] = given
    if source != target:
        found = np.ascontiguousarray(out)
        for one in found if shaped.ndim == dimensions + 2 else (found,):
            _core.convert_depth(one, p, shape, target)
        if found is not out:
            out[...] = found
    return out


def expect_kind(kind: object, name: str) -> None:
    """Raise for what is no kind of depth."""
    if as_text(kind, name) not in ("distance", "z"):
        raise ValueError(f"unknown {name} '{kind}'; there are distance, z")
