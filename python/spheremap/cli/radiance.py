"""The light of a file's image, in little more memory than the image has.

`light.energy` lists every texel with its direction and solid angle, some 200 bytes each. A large
image is therefore summed by way of a smaller one that holds the same light, its extremes are
looked for row by row, and its sun in a view toward the brightest texel.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import spheremap as sm
from spheremap.cli import files
from spheremap.cli.bands import bands
from spheremap.cli.steps import Step
from spheremap.light.image import coefficients

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Texels of which `light.energy` is quick and takes some 100 MB.
FEW = 1 << 20
# In degrees: a sun is compared to what lies within 20 of its peak. At most as many pixels a side.
_VIEW = 50.0
_MOST_PIXELS = 600


class _Extremes(NamedTuple):
    peak: float
    where: tuple[int, int]
    darkest: float
    negative: int


def energy(
    image: NDArray[Any], projection: sm.Projection, step: Step | None = None
) -> sm.light.Energy:
    """Return the energy of linear light, as `light.energy` does; NaN and infinity count as 0.

    Any aspect is taken: what was read has been held to it. Of a large image the sums are those of
    its reduction by area, which keeps light to some 1e-6, and the sun is the one that a view of 50
    degrees shows.
    """
    step = step or Step()
    step("adding up its light")
    height, width = image.shape[:2]
    if height * width <= FEW:
        return sm.light.energy(image, projection, skipna=True, any_aspect=True)
    image = _finite(image)
    size = files.size_of_height(projection, height)
    factor = int(np.ceil(np.sqrt(height * width / FEW)))
    size = max(1, size // factor)
    with step.listening():
        small = sm.convert(image, projection, projection, size=size, filter="area", any_aspect=True)
    report = sm.light.energy(small, projection)
    step("looking for its brightest texel")
    found = _extremes(image, projection, step)
    with np.errstate(divide="ignore", invalid="ignore"):
        stops = float(np.log2(found.peak / found.darkest))
    row, column = found.where
    toward = np.asarray(
        projection.pixels_to_directions(
            [column, row], (height, width), centers="integer", any_aspect=True
        ),
        np.float64,
    )
    step("looking for its sun")
    return replace(
        report,
        peak=found.peak,
        peak_direction=toward,
        darkest=found.darkest,
        dynamic_range=stops,
        negative=found.negative,
        sun=_sun(image, projection, toward),
    )


def _finite(image: NDArray[Any]) -> NDArray[Any]:
    """Return the image with 0 for what is not finite: a copy only where something is not."""
    if image.dtype.kind != "f" or all(np.isfinite(image[rows]).all() for rows in bands(image)):
        return image
    return np.asarray(np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0))


def _extremes(image: NDArray[Any], projection: sm.Projection, step: Step) -> _Extremes:
    """Return the brightest and darkest texels that hold sphere."""
    weights = coefficients(image, 2, None)
    held = None
    if projection.used_part < 1:
        held = sm.solid_angle(projection, image.shape[:2], any_aspect=True) > 0
    found = _Extremes(-np.inf, (0, 0), np.nan, 0)
    for rows in bands(image, step.part):
        values = image[rows].astype(np.float64)
        luminance = values @ weights
        below = (values < 0).any(axis=-1)
        if held is not None:
            luminance[~held[rows]] = -np.inf
            below &= held[rows]
        k = int(luminance.argmax())
        peak, where = float(luminance.flat[k]), np.unravel_index(k, luminance.shape)
        least = float(luminance.min(where=luminance > 0, initial=np.inf))
        found = _Extremes(
            max(peak, found.peak),
            (int(where[0]) + rows.start, int(where[1])) if peak > found.peak else found.where,
            float(np.fmin(found.darkest, least)) if np.isfinite(least) else found.darkest,
            found.negative + int(np.count_nonzero(below)),
        )
    return found


def _sun(
    image: NDArray[Any], projection: sm.Projection, toward: NDArray[np.float64]
) -> sm.light.Sun | None:
    """Return the sun about the brightest direction, seen with texels as small as the image's."""
    x, y, z = toward
    turn = sm.rotation(float(np.degrees(np.arctan2(-x, -z))), float(np.degrees(np.arcsin(y))), 0)
    camera = sm.projection("perspective", fov=_VIEW).turned(turn)
    # The texel at the brightest place, on a plane that is as long as the view at distance 1.
    angle = np.sqrt(projection.covered_solid_angle / (image.shape[0] * image.shape[1]))
    pixels = 2 * np.tan(np.radians(_VIEW / 2)) / angle
    side = int(np.clip(pixels, 64, _MOST_PIXELS))
    view = sm.convert(
        image, projection, camera, size=side, filter="area", world="literal", any_aspect=True
    )
    return sm.light.sun(view, camera)
