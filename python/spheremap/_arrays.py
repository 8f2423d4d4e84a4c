"""Shapes and dtypes of what callers give, checked and converted.

The core reads C-contiguous native arrays itself. For everything else (lists, float16, other byte
orders, views with strides ...) it calls the functions up to `as_rotation`: small arrays are
converted whole, large ones block by block, so that no call needs room for a copy of its input.
Images are converted whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import (
    TYPE_CHECKING,
    Any,
    Concatenate,
    Literal,
    ParamSpec,
    Protocol,
    TypeAlias,
    TypeVar,
    overload,
)

import numpy as np

from . import _core
from ._scalars import as_flag, as_text, kind_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    from ._projection import Projection

    Size: TypeAlias = int | tuple[int, ...]
    # What light below 0 counts as.
    Negative: TypeAlias = Literal["keep", "clip", "raise"]
    Array = NDArray[np.float64]
    Reals: TypeAlias = NDArray[np.floating[Any]]

Options = ParamSpec("Options")
Scalar = TypeVar("Scalar", bound=np.generic)


class KeepsDtype(Protocol[Options]):
    """A function of an image, first of all, whose result has the image's dtype."""

    @overload
    def __call__(
        self, image: NDArray[Scalar], /, *args: Options.args, **kwargs: Options.kwargs
    ) -> NDArray[Scalar]: ...
    @overload
    def __call__(
        self, image: ArrayLike, /, *args: Options.args, **kwargs: Options.kwargs
    ) -> NDArray[Any]: ...


def keeps_dtype(
    function: Callable[Concatenate[ArrayLike, Options], NDArray[Any]],
) -> KeepsDtype[Options]:
    """Tell type checkers that a function keeps the dtype of its image."""
    return function


IMAGE_DTYPES = ("uint8", "uint16", "float16", "float32", "float64")

# The most points that are converted at a time.
BLOCK = 1 << 14


def as_real(obj: object, name: str) -> Reals:
    """Return `obj` as a C-contiguous, aligned, native float32 or float64 array."""
    array = as_array(obj, name)
    return _converted(array, _is_single(array, name))


def as_doubles(obj: object, name: str) -> NDArray[np.float64]:
    """Return `obj` as a C-contiguous, aligned, native float64 array."""
    # A signaling NaN would warn.
    with np.errstate(invalid="ignore"):
        return as_real(obj, name).astype(np.float64, copy=False)


def as_points(obj: object, name: str, out: object) -> tuple[NDArray[Any], bool]:
    """Return `obj` as an array, and whether it is computed in float32.

    An array of at most `BLOCK` points is converted as by `as_real`. A larger one is returned as it
    is; the core takes it from `blocks`.
    """
    array = as_array(obj, name)
    single = _is_single(array, name)
    expect_apart(array, out)
    return (array if _is_large(array) else _converted(array, single)), single


def blocks(array: NDArray[Any], single: bool) -> Iterator[Reals]:
    """Yield the points of an array, converted, at most `BLOCK` at a time."""
    for view in _views(array):
        yield _converted(view, single)


# Axes that an array may have here: NumPy's own limit before 2.0.
_MOST_AXES = 32


def expect_vectors(shape: tuple[int, ...], name: str) -> None:
    """Raise unless an array of this shape holds three numbers a point."""
    if shape[-1:] != (3,):
        raise ValueError(f"Expected `{name}` to have shape (..., 3), got {shape}.")


def common_shape(*named: tuple[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Return the shape that arrays are broadcast to, of the names and shapes of all."""
    for name, shape in named:
        if len(shape) > _MOST_AXES:
            raise ValueError(f"Expected `{name}` to have at most {_MOST_AXES} axes.")
    try:
        return np.broadcast_shapes(*(shape for _, shape in named))
    except ValueError:
        given = ", ".join(f"{shape} for `{name}`" for name, shape in named)
        raise ValueError(f"Expected shapes that broadcast, got {given}.") from None


def as_pair(view: object, normal: object, out: object) -> tuple[NDArray[Any], NDArray[Any], bool]:
    """Return both as arrays of one shape, by numpy's broadcasting, for `paired_blocks`.

    The third is whether they are computed in float32.
    """
    a, b = as_array(view, "view"), as_array(normal, "normal")
    # Both are looked at: a dtype that is no real number is an error whatever the other's is.
    singles = _is_single(a, "view"), _is_single(b, "normal")
    for array, name in ((a, "view"), (b, "normal")):
        expect_vectors(array.shape, name)
        expect_apart(array, out)
    shape = common_shape(("view", a.shape), ("normal", b.shape))
    return np.broadcast_to(a, shape), np.broadcast_to(b, shape), all(singles)


def paired_blocks(a: NDArray[Any], b: NDArray[Any], single: bool) -> Iterator[tuple[Reals, Reals]]:
    """Yield the points of two arrays of one shape, converted, at most `BLOCK` at a time."""
    for x, y in zip(_views(a), _views(b), strict=True):
        yield _converted(x, single), _converted(y, single)


def as_lookups(
    points: object, name: str, width: int, lod: object, derivatives: object, out: object
) -> list[NDArray[Any]]:
    """Return points and what says how much they see as arrays of one shape but for the last axis.

    They are for `lookup_blocks`: points, then levels of one number, or two derivatives of `width`.
    """
    if lod is not None and derivatives is not None:
        raise ValueError("Give `lod` or `derivatives`, not both.")
    arrays = [(as_array(points, name), name)]
    if lod is not None:
        levels = as_array(lod, "lod")
        # Too many axes are an error of ours, before one more is added.
        common_shape(("lod", levels.shape))
        arrays.append((levels[..., None], "lod"))
    if derivatives is not None:
        if isinstance(derivatives, np.ndarray | memoryview):
            # One without axes has no length, and no part can be had of a view of several.
            both = as_array(derivatives, "derivatives")
            derivatives = tuple(both) if both.shape[:1] == (2,) else None
        if not isinstance(derivatives, Sequence) or len(derivatives) != 2:
            raise ValueError(
                "Expected `derivatives` to be a pair of arrays, to the right and down."
            )
        arrays += [(as_array(each, "derivatives"), "derivatives") for each in derivatives]
    for array, label in arrays:
        _is_single(array, label)
        expect_apart(array, out)
        if label != "lod" and array.shape[-1:] != (width,):
            raise ValueError(f"Expected `{label}` to have shape (..., {width}), got {array.shape}.")
    common = common_shape(*((label, array.shape[:-1]) for array, label in arrays))
    return [np.broadcast_to(array, (*common, array.shape[-1])) for array, _ in arrays]


def lookup_blocks(arrays: list[NDArray[Any]]) -> Iterator[list[Reals]]:
    """Yield the points of arrays of one shape but for the last axis, at most `BLOCK` at a time."""
    for views in zip(*map(_views, arrays), strict=True):
        yield [_converted(view, False) for view in views]


def as_integers(obj: object, name: str, out: object = None) -> NDArray[np.int64]:
    """Return `obj` as a C-contiguous int64 array.

    What is beyond int64 becomes -1.
    """
    array = as_array(obj, name)
    # An empty list is an array of floats.
    if array.dtype.kind not in ("iu" if array.size else "iuf"):
        raise TypeError(f"Expected `{name}` to be integers, got dtype {array.dtype}.")
    expect_apart(array, out)
    if array.dtype == np.uint64:
        array = np.where(
            array > np.uint64(np.iinfo(np.int64).max), np.int64(-1), array.view(np.int64)
        )
    return _contiguous(array, np.dtype(np.int64))


def as_image(obj: object, out: object, name: str = "image") -> NDArray[Any]:
    """Return `obj` as a C-contiguous, aligned, native image of a supported dtype."""
    array = as_array(obj, name)
    if array.dtype.name not in IMAGE_DTYPES:
        *most, last = IMAGE_DTYPES
        raise TypeError(
            f"Expected `{name}` to have dtype {', '.join(most)} or {last}, got {array.dtype}."
        )
    expect_apart(array, out)
    return _contiguous(array, array.dtype.newbyteorder("="))


def as_levels(obj: Sequence[Any], out: object) -> tuple[object, list[NDArray[Any]]]:
    """Return an image and the levels behind it, of a sequence of arrays of different shapes.

    NumPy makes no array of such a sequence. Any other is an image, and has none.
    """
    shapes = {x.shape if isinstance(x, np.ndarray) else None for x in obj}
    if None in shapes or len(shapes) < 2:
        return obj, []
    levels = [as_image(level, out) for level in obj]
    if len({level.dtype for level in levels}) > 1:
        kinds = ", ".join(dict.fromkeys(level.dtype.name for level in levels))
        raise TypeError(f"Expected levels of one dtype, got {kinds}.")
    return levels[0], levels[1:]


def as_rotation(obj: object, name: str = "rotation") -> NDArray[np.float64]:
    """Return a matrix, or what `obj.as_matrix()` gives, as a float64 array of shape (3, 3).

    The core checks that it is a rotation.
    """
    as_matrix = getattr(obj, "as_matrix", None)
    if as_matrix is not None and not callable(as_matrix):
        raise TypeError(
            f"Expected `{name}` to have a method `as_matrix`, got {type(obj).__name__}."
        )
    matrix = as_real(obj if as_matrix is None else as_matrix(), name)
    if matrix.shape != (3, 3):
        raise ValueError(f"Expected `{name}` to have shape (3, 3), got {matrix.shape}.")
    return np.require(matrix, dtype=np.float64, requirements=["C", "A"])


def index_text(place: int, shape: list[int]) -> str:
    """Return the place of a point in an array of points, as in ``[3, 1]``."""
    if not shape:
        return ""
    return f"[{', '.join(str(int(i)) for i in np.unravel_index(place, shape))}]"


def as_array(obj: object, name: str) -> NDArray[Any]:
    """Return `obj` as an array in which masked elements are NaN."""
    if isinstance(obj, np.ma.MaskedArray):
        return _unmasked(obj, name)
    try:
        return np.asarray(obj)
    except ValueError as error:
        raise ValueError(f"Expected `{name}` to be an array of numbers: {error}") from None


def _unmasked(array: np.ma.MaskedArray[Any, Any], name: str) -> NDArray[Any]:
    if not np.ma.is_masked(array):
        return np.asarray(array.data)
    if array.dtype.kind != "f":
        raise TypeError(
            f"`{name}` has masked elements, and {array.dtype} has no NaN for them: say what they "
            f"are, as with `{name}.filled(0)`."
        )
    return np.asarray(array.filled(np.nan))


def _is_single(array: NDArray[Any], name: str) -> bool:
    """Tell whether an array is computed in float32 (or else in float64)."""
    dtype = array.dtype
    if dtype.kind not in "fiub":
        raise TypeError(f"Expected `{name}` to be real numbers, got dtype {dtype}.")
    return dtype.kind == "f" and dtype.itemsize <= 4


def _converted(array: NDArray[Any], single: bool) -> Reals:
    # A long double beyond float64 becomes infinity, which the core answers with NaN; a warning
    # would be the only difference between it and any other infinite input.
    # A signaling NaN would warn as well.
    with np.errstate(all="ignore"):
        return _contiguous(array, np.dtype(np.float32 if single else np.float64))


def _contiguous(array: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return an array as C-contiguous, aligned and of a dtype."""
    if array.dtype != dtype or not array.flags.c_contiguous:
        expect_room(array.shape, dtype)
    return np.require(array, dtype=dtype, requirements=["C", "A"])


def expect_room(shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
    """Raise MemoryError where an array would not fit; nothing is written.

    Views that repeat an element may have more of them than there are addresses.
    """
    try:
        np.empty(shape, dtype)
    except ValueError:
        raise MemoryError(f"There is no room for an array of shape {shape}.") from None


def expect_apart(array: NDArray[Any], out: object) -> None:
    """Raise if `out` lies within the bounds of an input: blocks of it would be read too late."""
    if isinstance(out, np.ndarray) and np.may_share_memory(array, out):
        raise ValueError("`out` overlaps an input or an array that another call is using.")


def _is_large(array: NDArray[Any]) -> bool:
    # What is no array of points counts its numbers: the core will refuse it, without a copy.
    points = array.shape[:-1] if array.shape[-1:] in ((2,), (3,)) else array.shape
    return math.prod(points) > BLOCK


def _views(array: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Yield views of whole points, in C order, of at most `BLOCK` points each."""
    each = math.prod(array.shape[1:-1])
    if array.ndim < 2 or len(array) * each <= BLOCK:
        yield array
    elif each > BLOCK:
        for part in array:
            yield from _views(part)
    else:
        step = BLOCK // each
        for first in range(0, len(array), step):
            yield array[first : first + step]


def spatial_axes(p: Projection) -> int:
    """Return how many axes an image has without its channels."""
    return 2 if p.faces == 1 else 3


def spatial_shape(image: NDArray[Any], p: Projection, name: str) -> tuple[int, ...]:
    """Return the shape of an image without its channels, or raise."""
    axes = spatial_axes(p)
    if image.ndim not in (axes, axes + 1):
        pattern = "(H, W) or (H, W, C)" if axes == 2 else "(F, N, N) or (F, N, N, C)"
        raise ValueError(
            f"Expected `{name}` of projection '{p.name}' to have shape {pattern}, "
            f"got {image.shape}."
        )
    return p.shape(image.shape[:axes])


# The core has its own message for shapes.
_LONGEST_SIDE = 1 << 28


def as_size(size: Size, name: str = "size") -> Any:
    """Return a size as the core takes it: a whole number or a tuple."""
    if isinstance(size, int | np.integer) and not isinstance(size, bool):
        if size > _LONGEST_SIDE:
            raise ValueError(f"Expected `{name}` to be at most {_LONGEST_SIDE} texels.")
        return size
    items: Any = size
    try:
        if not isinstance(items, str | bytes):
            return tuple(items)
    # Views of memory with several axes are not there yet, in their words.
    except (TypeError, NotImplementedError):
        pass
    raise TypeError(
        f"Expected `{name}` to be a whole number, or a shape of whole numbers, got {kind_of(size)}."
    )


def result_dtype(image: NDArray[Any]) -> type[np.floating[Any]]:
    """Return the dtype of light that is computed of an image."""
    return np.float32 if image.dtype.kind == "f" and image.dtype.itemsize <= 4 else np.float64


def has_channels(image: NDArray[Any], projection: Projection) -> bool:
    """Tell whether an image has an axis of channels."""
    return image.ndim > spatial_axes(projection)


def as_unit_vectors(
    directions: ArrayLike, name: str
) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Return unit vectors as (N, 3), NaN for what is none, and the leading axes."""
    array = as_doubles(directions, name)
    expect_vectors(array.shape, name)
    with np.errstate(all="ignore"):
        scaled = array / np.abs(array).max(axis=-1, keepdims=True)
        unit = scaled / np.sqrt(np.square(scaled).sum(axis=-1, keepdims=True))
    return np.ascontiguousarray(unit.reshape(-1, 3)), array.shape[:-1]


# How many places a message names.
_PLACES = 3


def checked_image(
    image: ArrayLike,
    projection: Projection | None = None,
    *,
    name: str = "image",
    skipna: bool = False,
    negative: Negative = "keep",
    origin: tuple[int, ...] | None = None,
    skipping: str | None = "counts them as 0",
) -> NDArray[Any]:
    """Return the image as a contiguous array of a supported dtype in which every value is finite.

    NaN and infinite values raise ValueError with their number and first places, or become 0 with
    `skipna`. So do negative ones where `negative` is "raise"; where it is "clip" they become 0. The
    array given is never changed. Of a part of an image, `origin` says where it begins. Given a
    projection, what its images do not hold becomes 0 where it is not finite, and is no error.
    `skipping` is what errors say of `skipna`; None where the caller has no such parameter.
    """
    skipna = as_flag(skipna, "skipna")
    if as_text(negative, "negative") not in ("keep", "clip", "raise"):
        raise ValueError(f"Expected `negative` to be 'keep', 'clip' or 'raise', got {negative!r}.")
    array = as_image(image, None, name)
    if array.dtype.kind != "f":
        return array
    # No mask of the image's size where all is well.
    if not _core.all_finite(array):
        bad = ~np.isfinite(array)
        if not skipna and (held := bad & held_texels(array, projection)).any():
            advice = "" if skipping is None else f"; `skipna=True` {skipping}"
            raise ValueError(f"`{name}` has {_described(held, 'NaN or infinite', origin)}{advice}.")
        array = np.where(bad, array.dtype.type(0), array)
    if negative != "keep" and array.size and array.min() < 0:
        below = (array < 0) & held_texels(array, projection)
        if negative == "raise" and below.any():
            raise ValueError(
                f"`{name}` has {_described(below, 'negative', origin)}; "
                '`negative="clip"` counts them as 0.'
            )
        array = np.maximum(array, array.dtype.type(0))
    return array


def held_texels(image: NDArray[Any], projection: Projection | None) -> NDArray[np.bool_] | np.bool_:
    """Return which numbers of an image are of texels that hold a value."""
    if projection is None or projection.used_part >= 1:
        return np.bool_(True)
    spatial = image.shape[: spatial_axes(projection)]
    held = _core.texels_held(projection, spatial).view(np.bool_)
    return held.reshape(held.shape + (1,) * (image.ndim - held.ndim))


def _described(bad: NDArray[np.bool_], what: str, origin: tuple[int, ...] | None = None) -> str:
    count = int(np.count_nonzero(bad))
    first = origin or (0,) * bad.ndim
    places = [
        str(
            tuple(int(i) + k for i, k in zip(np.unravel_index(flat, bad.shape), first, strict=True))
        )
        for flat in np.flatnonzero(bad)[:_PLACES]
    ]
    more = ", ..." if count > _PLACES else ""
    noun = "value" if count == 1 else "values"
    return f"{count} {what} {noun}, at {', '.join(places)}{more}"
