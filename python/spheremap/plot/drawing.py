"""What every figure is drawn with: axes, pictures of light, names of directions, frames."""

from __future__ import annotations

from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from .._scalars import kind_of
from ..io.tonemap import tonemap
from ..map.images import expect_aspect, target_shape

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from numpy.typing import NDArray

    from .._arrays import Size
    from .._projection import Projection

__all__ = [
    "AXES",
    "OUTSIDE",
    "axis",
    "bare",
    "drawn_shape",
    "expect_image",
    "imported",
    "label",
    "mark_valid",
    "new_axes",
    "new_figure",
    "pieces",
    "places",
    "rgb",
]

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
OUTSIDE = (0.85, 0.85, 0.85)


def new_axes(ax: Axes | None) -> Axes:
    """Return axes, or new ones of pyplot."""
    if ax is not None:
        if not hasattr(ax, "add_collection"):
            raise TypeError(f"Expected `ax` to be matplotlib axes, got {kind_of(ax)}.")
        return ax
    made: Axes = new_figure(None).subplots()
    return made


def new_figure(
    figure: Figure | SubFigure | None, size: tuple[float, float] | None = None
) -> Figure | SubFigure:
    """Return a figure, or a new one of pyplot, so many inches wide and high."""
    if figure is not None:
        if not hasattr(figure, "subplots"):
            raise TypeError(f"Expected `figure` to be a matplotlib figure, got {kind_of(figure)}.")
        return figure
    made: Figure = imported("matplotlib.pyplot").figure(figsize=size, layout="constrained")
    return made


def imported(module: str) -> Any:
    """Return matplotlib, or a module of it; where it is missing, say how it is installed."""
    try:
        return import_module(module)
    except ImportError:
        raise ImportError(
            "plots need matplotlib: pip install spheremap[plot]", name="matplotlib"
        ) from None


def rgb(image: NDArray[Any], exposure: float | None) -> NDArray[np.uint8]:
    """Return light, or a picture of any integers, as a picture of three channels."""
    if image.dtype.kind == "f":
        picture = tonemap(image, exposure=exposure)
    elif image.dtype == np.uint16:
        picture = ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)
    elif image.dtype == np.uint8:
        picture = image
    else:
        raise TypeError(f"Expected `image` to be uint8, uint16 or floats, got {image.dtype}.")
    if picture.ndim == 2:
        picture = picture[..., np.newaxis]
    if picture.shape[-1] < 3:
        picture = np.repeat(picture[..., :1], 3, axis=-1)
    return picture[..., :3].copy()


def axis(name: str) -> NDArray[np.float64]:
    """Return the unit vector that is called "+x" and so on."""
    vector = np.zeros(3)
    vector["xyz".index(name[1])] = 1 if name[0] == "+" else -1
    return vector


def places(
    p: Projection, directions: NDArray[np.float64], width: float, height: float
) -> NDArray[np.float64]:
    """Return where directions lie in a figure `width` wide, faces in a row: x, y and the face."""
    uv = p.encode(directions)
    face = uv[..., 2] if p.faces > 1 else np.zeros(uv.shape[:-1])
    return np.stack([(face + uv[..., 0]) / p.faces * width, uv[..., 1] * height, face], axis=-1)


def pieces(line: NDArray[np.float64], width: float, height: float) -> list[NDArray[np.float64]]:
    """Return a line of `places` in pieces, none of which jumps over a seam of a face so large."""
    jump = np.abs(np.diff(line[:, :2], axis=0)) > 0.05 * np.array([width, height])
    broken = jump.any(-1) | (np.diff(line[:, 2]) != 0) | ~np.isfinite(line[1:, 0])
    parts = np.split(line[:, :2], np.flatnonzero(broken) + 1)
    return [part for part in parts if len(part) > 1 and np.isfinite(part).all()]


def expect_image(p: Projection, shape: tuple[int, ...]) -> None:
    """Raise for the shape of an image, channels and all, whose aspect is not its map's."""
    with _not_stretched():
        expect_aspect(p, shape, False)


def drawn_shape(p: Projection, size: Size) -> tuple[int, ...]:
    """Return the shape that a size stands for, or raise."""
    with _not_stretched():
        return target_shape(p, size, False)


@contextmanager
def _not_stretched() -> Iterator[None]:
    """Take the way out from errors about aspects: no figure has `any_aspect`."""
    try:
        yield
    except ValueError as error:
        raise ValueError(str(error).partition(" `any_aspect=True` takes")[0]) from None


def label(ax: Axes, p: Projection, width: float, height: float) -> None:
    """Name the directions ±x, ±y and ±z where they land."""
    from matplotlib.patheffects import withStroke

    for name in AXES:
        x, y, _ = places(p, axis(name), width, height)
        if not np.isfinite([x, y]).all():
            continue
        # At the very edge a label would hang half outside.
        ax.text(
            float(np.clip(x, 0.03 * width, 0.97 * width)),
            float(np.clip(y, 0.03 * height, 0.97 * height)),
            name,
            color="white",
            fontsize=9,
            fontweight="bold",
            horizontalalignment="center",
            verticalalignment="center",
            path_effects=[withStroke(linewidth=2.5, foreground="black")],
        )


def mark_valid(ax: Axes, p: Projection, height: int, width: int) -> None:
    """Draw white what holds sphere and gray what does not, below everything."""
    shape = (height, width) if p.faces == 1 else (p.faces, height, width)
    held = np.isfinite(p.directions(shape, dtype=np.float32)[..., 0])
    if p.faces > 1:
        held = np.concatenate(list(held), axis=1)
    ax.imshow(
        np.where(held[..., np.newaxis], 1.0, OUTSIDE),
        extent=(0, held.shape[1], held.shape[0], 0),
        zorder=0,
    )


def bare(ax: Axes, p: Projection, face_width: float, height: float) -> None:
    """Set the limits to those of an image, with lines between its faces and without ticks."""
    for face in range(1, p.faces):
        ax.axvline(face * face_width, color="gray", linewidth=0.8)
    ax.set(xlim=(0, face_width * p.faces), ylim=(height, 0), xticks=[], yticks=[])
    ax.set_aspect("equal")
    for spine in ax.spines.values():
        spine.set(color="gray", linewidth=0.5)
