"""Images as callers give them: of the aspect of their map, one or several, channels last or first.

Every verb of an image asks here, so that one rule holds in all of them. What an image is follows
from how many axes it has, never from how long they are: (H, W) is gray, (H, W, C) has channels,
(N, H, W, C) is a batch, whose channels are spelled out. With `channels_first` channels lie right
before the rows instead of last. An array of faces has one axis more in each case. Of a batch a verb
gives what it gives of each image alone, stacked, or in a list where it is no array.

The aspect is right where each side is within a texel of what the map says: rounding, and rows on
both poles, are no more than that. Stretched by more, a picture shows things where they are not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from inspect import signature
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar, cast

import numpy as np

from .. import _core
from .._arrays import as_array, as_size, expect_apart, spatial_axes
from .._scalars import as_flag

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from .._arrays import Size
    from .._projection import Projection

__all__ = [
    "Several",
    "channels_last",
    "expect_aspect",
    "fits",
    "images",
    "is_chain",
    "target_shape",
]

T = TypeVar("T")

# What a verb of one image returns: an image, values at places (the channels last), numbers of the
# whole image, levels that are images, or anything else, of which a list is made.
Result: TypeAlias = Literal["image", "values", "numbers", "levels", "object"]

# Past the method of the subclass, which would call no other.
_Core = _core.Projection

# Sizes at which an aspect is exact to far less than a texel, the second for maps that are nearly a
# line.
_LARGE = (1 << 20, 1 << 10)
# An axis that comes first and is no longer than this is taken for channels, in messages alone.
_MOST_CHANNELS = 4


def fits(p: Projection, shape: tuple[int, ...]) -> bool:
    """Tell whether each side of an image is within a texel of the map's aspect.

    The core itself holds images of several faces to theirs, to the texel.
    """
    if p.faces > 1 or len(shape) != 2:
        return True
    aspect = _aspect(p)
    if aspect is None or 0 in shape:
        return True
    (rows, columns), (height, width) = aspect, shape
    too_high = (height - 1) * columns > (width + 1) * rows
    too_wide = (width - 1) * rows > (height + 1) * columns
    return not (too_high or too_wide)


def expect_aspect(
    p: Projection, shape: tuple[int, ...], any_aspect: object, name: str = "image"
) -> None:
    """Raise ValueError for the shape of an image, channels and all, whose aspect is another one."""
    if as_flag(any_aspect, "any_aspect"):
        return
    axes = spatial_axes(p)
    if p.faces > 1:
        _expect_faces(p, shape, axes, name)
    elif len(shape) in (2, 3) and not fits(p, shape[:2]):
        raise ValueError(
            f"Expected `{name}` of projection '{p.name}' to be {_said(p, shape[0])}, each side "
            f"within a texel, got {shape}. {_advice(p, shape, axes)}"
        )


def target_shape(
    p: Projection, size: Size, any_aspect: object, name: str = "size"
) -> tuple[int, ...]:
    """Return the shape that a size stands for; one of another aspect is an error."""
    try:
        # The core itself looks how long an array is before it is read.
        shape = _Core.shape(p, size if isinstance(size, np.ndarray) else as_size(size, name))
    except ValueError as error:
        # The core takes a shape for an image's.
        text = str(error).replace("Expected an image of", f"Expected `{name}` of an image of")
        raise ValueError(text) from None
    if isinstance(size, int | np.integer):
        as_flag(any_aspect, "any_aspect")
    else:
        expect_aspect(p, shape, any_aspect, name)
    return shape


def images(
    image: Any,
    p: Projection | None,
    *,
    any_aspect: object,
    channels_first: object = False,
    rotation: Any = None,
    name: str = "image",
) -> Several | None:
    """Return None for one image that is as the core takes it, else what makes such images of it.

    The aspect is checked in both cases. A picture that maps no sphere has no projection.
    """
    first = as_flag(channels_first, "channels_first")
    shape = _shape(image, name)
    turns = _rotations(rotation)
    axes = 2 if p is None else spatial_axes(p)
    is_batch = len(shape) == axes + 2
    masked = isinstance(image, np.ma.MaskedArray)
    if not (is_batch or masked or turns is not None or (first and len(shape) > axes)):
        if p is not None:
            expect_aspect(p, shape, any_aspect, name)
        return None
    array = as_array(image, name)
    if first:
        array = channels_last(array, axes)
    if p is not None:
        expect_aspect(p, array.shape[1:] if is_batch else array.shape, any_aspect, name)
    if is_batch and turns is not None and len(turns) != len(array):
        raise ValueError(
            f"Expected one rotation, or one for each image: got {len(turns)} for {len(array)} "
            "images."
        )
    moved = first and array.ndim > axes
    return Several(array, turns, is_batch, moved, name)


def channels_last(array: NDArray[Any], axes: int) -> NDArray[Any]:
    """Return a view of an image, or a batch, whose channels lie right before the rows.

    `axes` is how many it has without channels.
    """
    return np.moveaxis(array, -3, -1) if array.ndim > axes else array


@dataclass(frozen=True, slots=True)
class Several:
    """Images with channels last, and the rotation of each: a batch, or one image many times."""

    array: NDArray[Any]
    turns: NDArray[np.float64] | None
    is_batch: bool
    channels_first: bool
    # That of the verb's parameter.
    name: str

    def each(
        self,
        verb: Callable[..., T],
        given: dict[str, Any],
        result: Result | tuple[Result, ...] = "image",
        **along: Any,
    ) -> T:
        """Return what a verb makes of each image alone, put together as `result` says.

        The verb says ``return several.each(verb, locals())`` and is called again for each image,
        with everything else that it was given itself, or has made of that by then. Aspects are
        checked already. What goes `along` is one for each image as well. With `channels_first`
        channels lie right before the rows of images and first in values at places. Numbers of a
        whole image stay as they are.
        """
        for name, values in along.items():
            if len(values) != self.count:
                raise ValueError(
                    f"Expected one `{name}`, or one for each image: got {len(values)} for "
                    f"{self.count} images."
                )
        calls = self._calls(verb, given, along)
        if result not in ("image", "values", "numbers"):
            return cast("T", self._joined([verb(*data, **rest) for data, rest in calls], result))
        out = given.get("out")
        if isinstance(out, np.ndarray):
            expect_apart(self.array, out)
        if not self.channels_first or result == "numbers":
            return cast("T", self._stacked(verb, calls, out))
        found = self._stacked(verb, calls, None)
        found = np.moveaxis(found, -1, -3 if result == "image" else int(self.is_many))
        if out is None:
            return cast("T", np.ascontiguousarray(found))
        _expect_same(out, found)
        out[...] = found
        return cast("T", out)

    def repeated(self, count: int) -> Several:
        """Return one image so many times; of many, themselves."""
        if self.is_many:
            return self
        # NumPy has no array of more.
        if self.array.ndim >= 64:
            raise ValueError(f"Expected `{self.name}` to be an image, got 64 axes.")
        array = np.broadcast_to(self.array, (count, *self.array.shape))
        return replace(self, array=array, is_batch=True)

    @property
    def is_many(self) -> bool:
        """Whether there is a result for each image, or for each rotation of one."""
        return self.is_batch or self.turns is not None

    @property
    def count(self) -> int:
        """How many results there are."""
        if not self.is_many:
            return 1
        return len(self.array if self.turns is None else self.turns)

    def _calls(
        self, verb: Callable[..., Any], given: dict[str, Any], along: dict[str, Any]
    ) -> Iterator[tuple[list[Any], dict[str, Any]]]:
        """Yield the arguments of each call; of no image, some that say what it would result in."""
        data, rest, more = _parameters(verb)
        options = {name: given[name] for name in (*data, *rest)} | (given[more] if more else {})
        # Each image has the channels last, and an `out` of its own.
        options = {k: v for k, v in options.items() if k not in ("channels_first", "out")}
        if "any_aspect" in options:
            options["any_aspect"] = True
        options[self.name] = self.array
        several = along | ({self.name: self.array} if self.is_batch else {})
        for k in range(max(self.count, 1)):
            options |= {name: _one(values, k) for name, values in several.items()}
            if self.turns is not None:
                options["rotation"] = self.turns[k] if self.count else None
            named = {name: value for name, value in options.items() if name not in data}
            yield [options[name] for name in data], named

    def _joined(self, found: list[Any], result: Result | tuple[Result, ...]) -> Any:
        if isinstance(result, tuple):
            parts = zip(zip(*found, strict=True), result, strict=True)
            return tuple(self._joined(list(part), kind) for part, kind in parts)
        if result == "levels":
            return [self._joined(list(level), "image") for level in zip(*found, strict=True)]
        if result == "object":
            return found[: self.count] if self.is_many else found[0]
        image = np.stack(found)[: self.count] if self.is_many else found[0]
        if self.channels_first:
            image = np.ascontiguousarray(np.moveaxis(image, -1, -3))
        return image

    def _stacked(
        self,
        verb: Callable[..., Any],
        calls: Iterator[tuple[list[Any], dict[str, Any]]],
        out: Any,
    ) -> Any:
        if not self.is_many:
            [(data, rest)] = calls
            return verb(*data, **rest) if out is None else verb(*data, **rest, out=out)
        count = self.count
        if out is not None and (not isinstance(out, np.ndarray) or out.shape[:1] != (count,)):
            got = getattr(out, "shape", type(out).__name__)
            raise ValueError(f"Expected `out` to have shape ({count}, ...), got {got}.")
        result = out
        for k, (data, rest) in enumerate(calls):
            if out is not None and count:
                verb(*data, **rest, out=out[k])
                continue
            found = np.asarray(verb(*data, **rest))
            if result is None:
                result = np.empty((count, *found.shape), found.dtype)
            if count:
                result[k] = found
        return result


def _one(values: Any, k: int) -> Any:
    """Return one of several; of none, an image that is black, or nothing."""
    if len(values):
        return values[k]
    is_array = isinstance(values, np.ndarray)
    return np.zeros_like(values, shape=values.shape[1:]) if is_array else None


@cache
def _parameters(verb: Callable[..., Any]) -> tuple[list[str], list[str], str]:
    """Return the names of the data of a verb, which are given by place, of others, and of more."""
    known = signature(verb).parameters.values()
    data = [each.name for each in known if each.kind is each.POSITIONAL_ONLY]
    more = "".join(each.name for each in known if each.kind is each.VAR_KEYWORD)
    return data, [each.name for each in known if each.name not in (*data, more)], more


def _expect_same(out: object, found: NDArray[Any]) -> None:
    if not isinstance(out, np.ndarray) or out.dtype != found.dtype:
        got = getattr(out, "dtype", type(out).__name__)
        raise TypeError(f"Expected `out` to have dtype {found.dtype}, got {got}.")
    if out.shape != found.shape:
        raise ValueError(f"Expected `out` to have shape {found.shape}, got {out.shape}.")
    if not out.flags.writeable:
        raise ValueError("Expected `out` to be writable.")


def _shape(image: Any, name: str) -> tuple[int, ...]:
    shape = getattr(image, "shape", None)
    if isinstance(shape, tuple):
        return shape
    if is_chain(image):
        return tuple(image[0].shape)
    if isinstance(image, str | PathLike):
        raise TypeError(
            f"Expected `{name}` to be an array, got the name of a file: `sm.io.read` reads it."
        )
    if image is None:
        raise TypeError(f"Expected `{name}` to be an array, got None.")
    return as_array(image, name).shape


def is_chain(image: Any) -> bool:
    """Tell whether this is a list of levels of different shapes, the first the image."""
    if not isinstance(image, list | tuple):
        return False
    shapes = [one.shape for one in image if isinstance(one, np.ndarray)]
    return len(shapes) == len(image) and len(set(shapes)) > 1


def _rotations(rotation: Any) -> NDArray[np.float64] | None:
    """Return several rotations as one array, or None where there is at most one."""
    if rotation is None or (isinstance(rotation, np.ndarray) and rotation.ndim == 2):
        return None
    as_matrix = getattr(rotation, "as_matrix", None)
    matrices = as_array(as_matrix() if callable(as_matrix) else rotation, "rotation")
    return matrices if matrices.ndim == 3 else None


def _aspect(p: Projection) -> tuple[int, int] | None:
    """Return rows and columns of a large image; None of a map that is all but a line."""
    for size in _LARGE:
        try:
            rows, columns = _Core.shape(p, size)
        except ValueError:
            continue
        return rows, columns
    return None


def _said(p: Projection, height: int) -> str:
    """Return the aspect in words."""
    rows, columns = _aspect(p) or (1, 1)
    if rows == columns:
        return "as wide as high"
    ratio = columns / rows
    return "twice as wide as high" if ratio == 2 else f"{ratio:.5g} times as wide as high"


def _advice(p: Projection, shape: tuple[int, ...], axes: int) -> str:
    """Return what the caller may have meant, and the way out."""
    ways = []
    if len(shape) == axes + 1 and shape[0] and _takes(p, shape[1:]):
        if shape[0] <= _MOST_CHANNELS:
            ways.append(
                f"{shape} looks like channels first: pass `channels_first=True` where the verb "
                "takes it, or move the axis, np.moveaxis(image, 0, -1)."
            )
        else:
            ways.append(f"A batch of gray images has shape {(*shape, 1)}.")
    elif "aspect" in p.parameters:
        ways.append(f"A map of this aspect is '{p.name}' with aspect={shape[1]}/{shape[0]}.")
    ways.append("`any_aspect=True` takes it as it is, stretched.")
    return " ".join(ways)


def _takes(p: Projection, shape: tuple[int, ...]) -> bool:
    try:
        _Core.shape(p, shape)
    except ValueError:
        return False
    return 0 not in shape and fits(p, shape)


def _expect_faces(p: Projection, shape: tuple[int, ...], axes: int, name: str) -> None:
    """Raise the core's error with what the caller may have meant."""
    if len(shape) not in (axes, axes + 1):
        return
    try:
        _Core.shape(p, shape[:axes])
    except ValueError as error:
        text = str(error).rstrip(".")
        if len(shape) == axes + 1 and _takes(p, (*shape[:-3], *shape[-2:])):
            text += (
                f"; {shape} looks like channels first: pass `channels_first=True` where the "
                "verb takes it, or move the axis, np.moveaxis(image, -3, -1)"
            )
        raise ValueError(f"{text}.") from None
