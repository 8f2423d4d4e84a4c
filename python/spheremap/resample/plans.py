"""Conversions that are prepared once and run on many images."""

from __future__ import annotations

import inspect
import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from .._arrays import as_array, spatial_axes
from .._scalars import as_float_dtype, as_items, as_whole
from ..map.grid import cells, on_corners, row_blocks, texel
from ..map.images import target_shape
from ..map.named import resolve
from ..map.size import matching_size
from .verbs import convert

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, DTypeLike, NDArray

    from .._arrays import Scalar, Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["RemapPlan", "remap_plan"]


@dataclass(frozen=True, slots=True)
class RemapPlan:
    """A conversion from one projection into another, as `remap_plan` returns it.

    Frozen, hashable and picklable; it holds no arrays of coordinates. Calling it converts. Plans
    that convert by the same options are equal, in whatever order and with whatever defaults these
    were given.

    Attributes
    ----------
    src, dst : Projection
        What images come in, and what comes out.
    shape : tuple of int
        The shape of the whole result, without channels, and of `maps`. With the option ``window``,
        what a call returns has the window's rows and columns.
    source_shape : tuple of int or None
        The shape that images must have, without channels; None for any.
    options : tuple of (str, object)
        What else `convert` is told, by name: ``filter``, ``fill``, ``world`` and so on, but for
        what it does by default.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> plan = sm.remap_plan("latlong", "cube", size=16)
    >>> plan(np.ones((5, 32, 64, 3), np.float32)).shape  # five frames of a video
    (5, 6, 16, 16, 3)
    """

    src: Projection
    dst: Projection
    shape: tuple[int, ...]
    source_shape: tuple[int, ...] | None = None
    options: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:
        pairs = list(as_items(self.options, "options", "pairs of a name and a value"))
        if not all(
            isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], str)
            for pair in pairs
        ):
            raise TypeError(
                f"Expected `options` to be pairs of a name and a value, got {self.options!r}."
            )
        plain = {name: _plain(value, name) for name, value in pairs}
        said = sorted((name, x) for name, x in plain.items() if not _is_default(name, x))
        object.__setattr__(self, "options", tuple(said))

    def __hash__(self) -> int:
        # Not of the options: slices have no hash before Python 3.12.
        return hash((self.src, self.dst, self.shape, self.source_shape))

    def __reduce__(self) -> tuple[type[RemapPlan], tuple[Any, ...]]:
        # By `__post_init__`, for the one NaN.
        return RemapPlan, (self.src, self.dst, self.shape, self.source_shape, self.options)

    @overload
    def __call__(
        self, image: NDArray[Scalar], /, *, out: NDArray[Any] | None = None
    ) -> NDArray[Scalar]: ...
    @overload
    def __call__(self, image: ArrayLike, /, *, out: NDArray[Any] | None = None) -> NDArray[Any]: ...
    def __call__(self, image: ArrayLike, /, *, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Convert an image, or a batch of images with channels.

        Parameters
        ----------
        image : array_like
            As for `convert`, or with one more axis in front: (N, H, W, C), or (N, F, S, S, C) for
            an array of faces. A batch has its channels spelled out, with C = 1 for gray. Of a plan
            with ``channels_first=True`` channels lie right before the rows.
        out : ndarray, optional
            Where to put the result.

        Returns
        -------
        image : ndarray
            Of the same dtype and channels, and as many of them.

        Raises
        ------
        ValueError, TypeError
            As for `convert`, and for an image of another shape than the plan was made for.
        """
        if not isinstance(image, np.ndarray):
            image = as_array(image, "image")
        options = dict(self.options)
        spatial = spatial_axes(self.src)
        held = image.shape
        if len(held) > spatial:
            channel = -3 if options.get("channels_first") else -1
            held = np.moveaxis(image, channel, -1).shape[-1 - spatial : -1]
        if self.source_shape is not None and held != self.source_shape:
            raise ValueError(
                f"Expected an image of shape {self.source_shape}, with or without channels, "
                f"got {image.shape}."
            )
        return convert(image, self.src, self.dst, size=self.shape, out=out, **options)

    def maps(
        self, source_shape: tuple[int, ...] | None = None, /, *, dtype: DTypeLike = np.float32
    ) -> tuple[NDArray[np.floating[Any]], ...]:
        """Return where in the source each texel of the result lies, for other programs.

        Parameters
        ----------
        source_shape : tuple of int, optional
            The shape of the source, without channels, where the plan was made for any.
        dtype : float32 or float64
            Of the result. ``cv2.remap`` takes float32, which is exact to 1/512 of a texel in an
            image 32768 wide.

        Returns
        -------
        map_x, map_y : ndarray, shape as the plan's
            Column and row in texels. **The center of the first texel is 0**, as OpenCV counts:
            on a grid of centers x = u·W - ½, and the image spans -½ to W - ½. NaN where the
            result has no sphere, or the source does not hold the direction. A ``window`` of the
            plan does not count.
        face : ndarray
            The number of the face, for a source that is an array of faces; else it is not there.

        Raises
        ------
        ValueError
            Where no shape of the source is known, or it is another one.
        TypeError
            For another dtype.

        Notes
        -----
        A program that looks up at these places knows nothing of seams: ``cv2.BORDER_WRAP`` is
        right beside the left and right edge of a latlong alone. Nothing but this method makes
        coordinates of a whole image.

        Examples
        --------
        >>> import spheremap as sm
        >>> plan = sm.remap_plan("latlong", "latlong", size=2, source_shape=(2, 4))
        >>> x, y = plan.maps()
        >>> x.round(5).tolist()
        [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]]
        >>> abs(y.round(5)).tolist()
        [[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0]]
        """
        if source_shape is not None:
            source_shape = tuple(as_items(source_shape, "source_shape", "whole numbers"))
        if source_shape is not None and self.source_shape not in (None, source_shape):
            raise ValueError(f"The plan was made for {self.source_shape}, got {source_shape}.")
        source_shape = source_shape or self.source_shape
        if source_shape is None:
            raise ValueError("Expected the shape of the source: the plan was made for any.")
        dtype = as_float_dtype(dtype)
        options = dict(self.options)
        any_aspect = options.get("any_aspect", False)
        shape = target_shape(self.src, source_shape, any_aspect, "source_shape")
        height, width = shape[-2:]
        (cells_v, cells_u), (corners_v, corners_u) = (
            cells(self.src),
            on_corners(self.src),
        )
        literal = options.get("world", "match") == "literal"
        target = self.dst if literal else self.dst.in_world_of(self.src)
        maps = tuple(np.empty(self.shape, dtype) for _ in range(spatial_axes(self.src)))
        flat = [one.reshape(-1, self.shape[-1]) for one in maps]
        for rows, directions in row_blocks(target, self.shape):
            at = self.src.encode(directions)
            flat[0][rows] = texel(at[..., 0], width, cells_u, corners_u)
            flat[1][rows] = texel(at[..., 1], height, cells_v, corners_v)
            if len(flat) == 3:
                flat[2][rows] = at[..., 2]
        return maps


def remap_plan(
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    source_shape: tuple[int, ...] | None = None,
    rotation: Any | None = None,
    **options: Any,
) -> RemapPlan:
    """Prepare a conversion to be run on many images: the frames of a video, a batch.

    Parameters
    ----------
    src, dst : Projection or str
        The projection of the images, and that of the results.
    size : int or tuple of int, optional
        The size of the result, as for `convert`. By default the one that fits `source_shape`.
    source_shape : tuple of int, optional
        The shape of the images without channels. Given, images of another shape raise.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the world of `src`: the plan's `src` is turned by it.
    **options
        What else `convert` takes: ``filter``, ``fill``, ``world``, ``any_aspect``,
        ``channels_first``, ... They are checked here, once.

    Returns
    -------
    RemapPlan
        Frozen and picklable. ``plan(image, out=None)`` converts one image or a batch;
        ``plan.maps()`` gives source coordinates for other programs.

    Raises
    ------
    ValueError, TypeError
        As for `convert`, and where neither `size` nor `source_shape` is given.

    Notes
    -----
    A plan gives the very bits of `convert`, and holds no coordinates: computing them again in tiles
    is faster than reading them from memory. So there is no limit on sizes: the source may be a
    memory-mapped file.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> camera = sm.projection("perspective", fov=90, aspect=2).turned(sm.rotation(30, 0, 0))
    >>> plan = sm.remap_plan("latlong", camera, size=32)
    >>> plan.shape
    (32, 64)
    >>> plan(np.zeros((64, 128), np.uint8)).shape
    (32, 64)
    """
    expect_options(options, "remap_plan")
    source, target = resolve(src), resolve(dst)
    any_aspect = options.get("any_aspect", False)
    known = None
    if source_shape is not None:
        sides = tuple(as_items(source_shape, "source_shape", "whole numbers"))
        known = target_shape(source, sides, any_aspect, "source_shape")
    if size is None:
        if known is None:
            raise TypeError("Expected `size`, or the `source_shape` that gives it.")
        size = matching_size(known, source, target)
    shape = target_shape(target, size, any_aspect)
    source = resolve(source, rotation=rotation)
    plan = RemapPlan(source, target, shape, known, tuple(options.items()))
    _try(plan)
    return plan


def expect_options(options: Mapping[str, Any], verb: str, refused: tuple[str, ...] = ()) -> None:
    """Raise TypeError for what `convert` does not take, in the name of the verb that hands it on.

    What the verb itself refuses is not among the names of the message.
    """
    for name in ("image", "out"):
        if name in options:
            raise TypeError(f"`{name}` is no option of a plan: pass it when calling the plan.")
    known = [name for name, p in _parameters().items() if p.kind is p.KEYWORD_ONLY]
    for name in options:
        if name not in known:
            others = {"size", "rotation", "out", *refused}
            taken = ", ".join(each for each in known if each not in others)
            raise TypeError(f"`{name}` is no option of `{verb}`; it takes {taken} of `convert`'s.")


def _plain(value: Any, name: str) -> Any:
    """Return an option in Python's own numbers and tuples, with one and the same NaN.

    So it is equal to another of the same numbers, to NaN as well.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = as_array(value, name).tolist()
    if isinstance(value, list | tuple):
        return tuple(_plain(each, name) for each in value)
    return math.nan if isinstance(value, float) and math.isnan(value) else value


def _is_default(name: str, value: object) -> bool:
    """Tell whether an option says what `convert` does without it; 0 is no False."""
    known = _parameters().get(name)
    return (
        known is not None
        and isinstance(value, bool | int | float | str | None)
        and isinstance(value, bool) == isinstance(known.default, bool)
        and value == known.default
    )


@cache
def _parameters() -> Mapping[str, inspect.Parameter]:
    return inspect.signature(convert).parameters


def _reached(channel: object) -> int:
    """Return how many channels there are at least where there is one of this number."""
    if channel is None:
        return 0
    number = as_whole(channel, "alpha")
    return -number if number < 0 else number + 1


def _try(plan: RemapPlan) -> None:
    """Convert a tiny image: `convert` itself checks the options."""
    options = dict(plan.options)
    fill = options.get("fill")
    channels = len(fill) if isinstance(fill, tuple) else max(4, _reached(options.get("alpha")))
    tiny = np.zeros((*plan.src.shape(2), channels), np.float32)
    if options.get("channels_first") is True:
        tiny = np.moveaxis(tiny, -1, -3)
    convert(tiny, plan.src, plan.dst, size=2, **options)
