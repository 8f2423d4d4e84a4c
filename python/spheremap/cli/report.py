"""What `spheremap info` found, as text and as JSON."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import spheremap as sm
from spheremap import io
from spheremap.cli import files, sunward
from spheremap.cli.tables import print_table

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Channel(NamedTuple):
    """The numbers of a channel; least, largest and mean are of the finite ones."""

    name: str
    min: float
    max: float
    mean: float
    nan: int
    infinite: int
    negative: int


class Light(NamedTuple):
    """What an image holds as light, and the projection that it is taken for."""

    projection: sm.Projection
    energy: sm.light.Energy


class Found(NamedTuple):
    """All that there is to say of a file."""

    file: Path
    header: io.Header
    color_space: str
    channels: list[Channel]
    light: Light | None


class SunPlace(NamedTuple):
    """Where the sun is: degrees right of -z and above the horizon, its pixel, the turn to it."""

    azimuth: float
    elevation: float
    pixel: tuple[float, ...]
    rotate: tuple[float, float, float]


def print_text(found: Found) -> None:
    """Print it for people."""
    head = found.header
    print(found.file)
    print(f"  size      {head.width} x {head.height}")
    print(f"  channels  {len(head.channels)} ({', '.join(head.channels)})")
    print(f"  dtype     {head.dtype}")
    print(f"  colors    {found.color_space}")
    if head.alpha != "none":
        print(f"  alpha     {head.alpha}")
    if head.window != (0, 0, head.height, head.width) and head.orientation < 5:
        top, left, bottom, right = head.window
        print(f"  holds     rows {top} to {bottom} and columns {left} to {right} of these")
    if head.orientation != 1:
        print(f"  turned    upright, by EXIF orientation {head.orientation}")
    if head.projection:
        print(f"  says      {head.projection}")
    leveled = files.leveled(head.tilt)
    if leveled:
        print(f"  tilted    {leveled}")
    fits = files.fitting(head.height, head.width)
    print(f"  fits      {', '.join(fits) or 'no projection as it is'}")
    heads = "channel", "min", "max", "mean", "NaN", "infinite", "negative"
    print_table(heads, [_row(channel) for channel in found.channels], numbers=True)
    if found.light is None:
        if head.projection:
            print(f"  light     unknown: the size is not that of {head.projection}; give --from")
        return
    lines = str(found.light.energy).splitlines()
    print("\n  ".join([f"  light     as {files.described(found.light.projection)}", *lines]))
    place = _sun_place(found)
    if place is not None:
        where = ", ".join(f"{x:.1f}" for x in place.pixel)
        turn = " ".join(f"{angle:.2f}" for angle in place.rotate)
        print(f"            azimuth {place.azimuth:.2f}°, elevation {place.elevation:.2f}°")
        print(f"            at pixel {where}; to the center by convert --rotation {turn}")


def as_json(found: Found) -> dict[str, Any]:
    """Return it for programs: what JSON holds alone; null for what is not finite."""
    head = found.header
    said: dict[str, Any] = {
        "file": str(found.file),
        "width": head.width,
        "height": head.height,
        "dtype": head.dtype,
        "color_space": found.color_space,
        "alpha": head.alpha,
        "orientation": head.orientation,
        "data_window": dict(zip(("top", "left", "bottom", "right"), head.window, strict=True)),
        "parts": list(head.parts),
        "projection": head.projection,
        "tilt": dict(zip(("pitch", "roll"), head.tilt, strict=True)),
        "fits": files.fitting(head.height, head.width),
        "channels": [
            {name: _number(value) for name, value in channel._asdict().items()}
            for channel in found.channels
        ],
        "light": None,
    }
    if found.light is not None:
        energy, sun = found.light.energy, None
        place = _sun_place(found)
        if energy.sun is not None and place is not None:
            sun = {
                "direction": _numbers(energy.sun.direction),
                "azimuth": place.azimuth,
                "elevation": place.elevation,
                "pixel": list(place.pixel),
                "rotate": list(place.rotate),
                "angular_diameter": energy.sun.angular_diameter,
                "solid_angle": energy.sun.solid_angle,
                "irradiance": _numbers(energy.sun.irradiance),
            }
        said["light"] = {
            "as": files.described(found.light.projection),
            "solid_angle": energy.solid_angle,
            "integral": _numbers(energy.integral),
            "mean": _numbers(energy.mean),
            "luminance": _number(energy.luminance),
            "peak": _number(energy.peak),
            "peak_direction": _numbers(energy.peak_direction),
            "darkest": _number(energy.darkest),
            "stops": _number(energy.dynamic_range),
            "negative": energy.negative,
            "sun": sun,
        }
    return said


def _row(c: Channel) -> tuple[str, ...]:
    numbers = ("-",) * 3 if np.isnan(c.mean) else (f"{c.min:g}", f"{c.max:g}", f"{c.mean:.6g}")
    return (c.name, *numbers, str(c.nan), str(c.infinite), str(c.negative))


def _sun_place(found: Found) -> SunPlace | None:
    if found.light is None or found.light.energy.sun is None:
        return None
    p, direction = found.light.projection, found.light.energy.sun.direction
    shape = found.header.height, found.header.width
    return SunPlace(
        *sunward.azimuth_elevation(direction, p),
        tuple(p.directions_to_pixels(direction, shape).tolist()),
        sunward.angles(direction, p, p),
    )


def _number(value: Any) -> Any:
    """Return a number as JSON has it, which knows no NaN and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _numbers(values: NDArray[np.float64]) -> list[Any]:
    return [_number(float(x)) for x in values]
