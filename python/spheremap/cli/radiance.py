"""The light of a file's image, in little more memory than the image has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import spheremap as sm
from spheremap.cli.steps import Step
from spheremap.light.files import energy_of_parts

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from spheremap.resample.seen import Rectangle

# What a command takes that was given no memory.
MEMORY = 1 << 29


def energy(
    image: NDArray[Any], projection: sm.Projection, step: Step | None = None
) -> sm.light.Energy:
    """Return the energy of linear light, as `light.energy` does; NaN and infinity count as 0.

    Any aspect is taken: what was read has been held to it.
    """
    return energy_of(lambda part: image[part.index], projection, image.shape, step)


def energy_of(
    read: Callable[[Rectangle], NDArray[Any]],
    projection: sm.Projection,
    shape: tuple[int, ...],
    step: Step | None = None,
    memory: int = MEMORY,
) -> sm.light.Energy:
    """Return the same of an image that is read part by part."""
    step = step or Step()
    step("adding up its light")
    with step.listening():
        return energy_of_parts(read, projection, shape, None, memory, skipna=True)
