"""The subcommand `spheremap info`: what an image holds."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from spheremap import io
from spheremap.cli import files, picture, radiance, report
from spheremap.cli.lengths import as_bytes
from spheremap.cli.options import ColorSpace, FromGuess, Memory, Part
from spheremap.cli.report import Channel, Found, Light
from spheremap.cli.steps import Step
from spheremap.cli.terminal import check_projection, progress, read
from spheremap.light.files import reader_of
from spheremap.resample.seen import tiles

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from spheremap.resample.seen import Rectangle

    Read = Callable[[Rectangle], NDArray[Any]]

# Rows and columns of what is looked at together: so much stays in a processor's cache.
_TILE = (128, 512)


def info(
    file: Annotated[Path, typer.Argument(metavar="IN", help="An image file.")],
    from_: FromGuess = None,
    colorspace: ColorSpace = None,
    part: Part = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print it as JSON.")] = False,
    memory: Memory = None,
) -> None:
    """Tell what an image holds, which projections it may be, and its light.

    Light is summed as light: sRGB is decoded before.
    """
    if from_ is not None:
        check_projection(from_)
    with progress() as step, ExitStack() as held:
        step(f"reading {file.name}")
        head = io.header(file, part=part)
        most = radiance.MEMORY if memory is None else as_bytes("--memory", memory)
        if memory is None:
            image = read(file, part=part)
            shape, of_part = image.shape, lambda part: image[part.index]
        else:
            of_part, shape = held.enter_context(reader_of(file, part, most))
        step("looking at its numbers")
        channels = _channels(of_part, shape, head.channels, step)
        space = colorspace or head.color_space
        light = _light(of_part, shape, head, from_, space, step, most)
    found = Found(file, head, space, channels, light)
    if as_json:
        print(json.dumps(report.as_json(found), indent=1, allow_nan=False))
    else:
        report.print_text(found)


def _channels(
    read: Read, shape: tuple[int, ...], names: tuple[str, ...], step: Step
) -> list[Channel]:
    height, width, count = shape
    least, largest = np.full(count, np.inf), np.full(count, -np.inf)
    total, nan, infinite, negative = (np.zeros(count) for _ in range(4))
    parts = tiles((height, width), _TILE)
    for k, part in enumerate(parts):
        # A channel after the other, in a type that processors compare: much faster.
        values: NDArray[np.float32] = np.ascontiguousarray(
            read(part).reshape(-1, count).T, dtype=np.float32
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
        step.part((k + 1) / len(parts))
    with np.errstate(invalid="ignore"):
        mean = total / (height * width - nan - infinite)
    columns = zip(least, largest, mean, nan, infinite, negative, strict=True)
    return [
        Channel(name, float(a), float(b), float(m), int(n), int(i), int(k))
        for name, (a, b, m, n, i, k) in zip(names, columns, strict=True)
    ]


def _light(
    read: Read,
    shape: tuple[int, ...],
    head: io.Header,
    name: str | None,
    space: str,
    step: Step,
    memory: int,
) -> Light | None:
    """Return the light of an image, unless there is no saying what it is."""
    height, width, count = shape
    alpha = head.alpha_channel
    colors = count if alpha is None else count - 1
    said = head.projection
    if not name and not said and (colors not in (1, 3, 4) or not files.fitting(height, width)):
        return None
    try:
        p = files.taken(name, said, height, width)
    except ValueError:
        if name:
            raise
        # The light of another map would be of none that there is.
        return None

    def light(part: Rectangle) -> NDArray[Any]:
        texels = read(part)
        decodes = texels.dtype.kind != "f" or not head.linear or space != head.color_space
        found = _decoded(texels, head, space) if decodes else texels
        if alpha is None:
            return found
        # What `bake` and a conversion to floats take for light: colors, premultiplied.
        straight = head.alpha == "straight" or texels.dtype.kind == "u"
        light = np.delete(found, alpha, axis=-1)
        return light * found[..., alpha : alpha + 1] if straight else light

    return Light(p, radiance.energy_of(light, p, (height, width, colors), step, memory))


def _decoded(texels: NDArray[Any], head: io.Header, space: str) -> NDArray[Any]:
    alpha = head.alpha_channel
    if head.alpha == "premultiplied" and alpha is not None and texels.dtype.kind == "u":
        texels = picture.straightened(texels, alpha)
    return io.to_linear(texels, color_space=space, alpha=alpha)
