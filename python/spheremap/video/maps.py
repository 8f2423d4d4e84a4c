"""Maps of frames, each of which is one picture: layouts of several faces, sizes that halve."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..map.flat import layouts, legible
from ..map.images import expect_aspect, fits, target_shape
from ..map.named import resolve
from ..map.size import matching_size
from ..map.variants import changed

if TYPE_CHECKING:
    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["size_of", "source_of", "target_of"]


def target_of(dst: ProjectionLike) -> Projection:
    """Return the map as one picture; faces lie as people know them best."""
    p = resolve(dst)
    return changed(p, layout=legible(p.name)) if p.faces > 1 else p


def source_of(src: ProjectionLike, shape: tuple[int, int], any_aspect: bool) -> Projection:
    """Return the map of frames of a shape as one picture, in the first layout that fits.

    Raises
    ------
    ValueError
        For a shape that none fits.
    """
    p = resolve(src)
    if p.faces == 1:
        expect_aspect(p, shape, any_aspect, "frames")
        return p
    found = [changed(p, layout=layout) for layout in layouts(p.name)]
    for candidate in found:
        if _is_of(candidate, shape):
            return candidate
    height, width = shape
    sizes = [p.shape(64) for p in found]
    wanted = [f"{rows // 64}:{columns // 64} ({p.layout})" for p, (rows, columns) in
              zip(found, sizes, strict=True)]  # fmt: skip
    raise ValueError(
        f"Expected frames of projection {p.name!r} with a height to width of "
        f"{' or '.join(wanted)}, got {height} to {width}."
    )


def _is_of(p: Projection, shape: tuple[int, int]) -> bool:
    try:
        return p.shape(shape) == shape and fits(p, shape)
    except ValueError:
        return False


def size_of(
    size: Size | None,
    shape: tuple[int, int],
    src: Projection,
    dst: Projection,
    parts: tuple[int, int],
    any_aspect: bool,
) -> tuple[int, int]:
    """Return height and width of a result.

    Parameters
    ----------
    size : int or (int, int) or None
        As for `convert`; None for as many texels a steradian as the source has.
    shape : (int, int)
        Of the source.
    parts : (int, int)
        What has to divide height and width; a size that is not given is raised to the next of
        which it does.
    """
    if size is not None:
        height, width = target_shape(dst, size, any_aspect)
        return height, width
    first = matching_size(shape, src, dst)
    for one in range(first, first + 2 * max(parts)):
        height, width = dst.shape(one)
        if height % parts[0] == 0 and width % parts[1] == 0:
            return height, width
    return height, width
