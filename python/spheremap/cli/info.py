"""The subcommand `spheremap info`: what an image holds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from spheremap import io
from spheremap.cli import files, picture, radiance, report
from spheremap.cli.bands import bands
from spheremap.cli.options import ColorSpace, FromGuess, Part
from spheremap.cli.report import Channel, Found, Light
from spheremap.cli.steps import Step
from spheremap.cli.terminal import check_projection, progress, read

if TYPE_CHECKING:
    from numpy.typing import NDArray


def info(
    file: Annotated[Path, typer.Argument(metavar="IN", help="An image file.")],
    from_: FromGuess = None,
    colorspace: ColorSpace = None,
    part: Part = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print it as JSON.")] = False,
) -> None:
    """Tell what an image holds, which projections it may be, and its light.

    Light is summed as light: sRGB is decoded before.
    """
    if from_ is not None:
        check_projection(from_)
    with progress() as step:
        step(f"reading {file.name}")
        head = io.header(file, part=part)
        image = read(file, part=part)
        step("looking at its numbers")
        channels = _channels(image, head.channels, step)
        space = colorspace or head.color_space
        light = _light(image, head, from_, space, step)
    found = Found(file, head, space, channels, light)
    if as_json:
        print(json.dumps(report.as_json(found), indent=1, allow_nan=False))
    else:
        report.print_text(found)


def _channels(image: NDArray[Any], names: tuple[str, ...], step: Step) -> list[Channel]:
    count = image.shape[-1]
    least, largest = np.full(count, np.inf), np.full(count, -np.inf)
    total, nan, infinite, negative = (np.zeros(count) for _ in range(4))
    for rows in bands(image, step.part):
        # A channel after the other, in a type that processors compare: much faster.
        values: NDArray[np.float32] = np.ascontiguousarray(
            image[rows].reshape(-1, count).T, dtype=np.float32
        )
        negative += (values < 0).sum(axis=1)
        finite = np.isfinite(values)
        if not finite.all():
            nan += np.isnan(values).sum(axis=1)
            infinite += np.isinf(values).sum(axis=1)
        least = np.minimum(least, values.min(axis=1, where=finite, initial=np.inf))
        largest = np.maximum(largest, values.max(axis=1, where=finite, initial=-np.inf))
        # It looks at the others as well.
        with np.errstate(invalid="ignore"):
            total += values.sum(axis=1, where=finite, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        mean = total / (image.shape[0] * image.shape[1] - nan - infinite)
    columns = zip(least, largest, mean, nan, infinite, negative, strict=True)
    return [
        Channel(name, float(a), float(b), float(m), int(n), int(i), int(k))
        for name, (a, b, m, n, i, k) in zip(names, columns, strict=True)
    ]


def _light(
    image: NDArray[Any], head: io.Header, name: str | None, space: str, step: Step
) -> Light | None:
    """Return the light of an image, unless there is no saying what it is."""
    height, width, count = image.shape
    alpha = head.alpha_channel
    colors = count if alpha is None else count - 1
    name = name or files.claimed(head.projection, height, width)
    if name is None and (colors not in (1, 3, 4) or not files.fitting(height, width)):
        return None
    p = files.taken(name, None, height, width)
    light = image
    if not (head.linear and space == head.color_space and image.dtype.kind == "f"):
        step("decoding its colors")
        light = _decoded(image, head, space, step)
    if alpha is not None:
        light = _without_alpha(light, alpha, head.alpha == "straight" or image.dtype.kind == "u")
    return Light(p, radiance.energy(light, p, step))


def _without_alpha(light: NDArray[Any], alpha: int, straight: bool) -> NDArray[Any]:
    """Return what `bake` and a conversion to floats take for light: colors, premultiplied."""
    colors = np.delete(light, alpha, axis=-1)
    if straight:
        for rows in bands(colors):
            colors[rows] *= light[rows][..., alpha : alpha + 1]
    return colors


def _decoded(image: NDArray[Any], head: io.Header, space: str, step: Step) -> NDArray[np.float16]:
    """Return light a few rows at a time, in half floats: fine enough for what 16 bits encode."""
    light, alpha = np.empty(image.shape, np.float16), head.alpha_channel
    for rows in bands(image, step.part):
        part = image[rows]
        if head.alpha == "premultiplied" and alpha is not None and image.dtype.kind == "u":
            part = picture.straightened(part, alpha)
        light[rows] = io.to_linear(part, color_space=space, alpha=alpha)
    return light
