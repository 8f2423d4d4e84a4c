"""How projections and the images of files fit: layouts, sizes, aspects."""

from __future__ import annotations

from typing import Literal

import spheremap as sm
from spheremap.map import images
from spheremap.map.flat import flat, layouts

# Where to look from, and large enough that faces in their layouts come out whole.
_UNIT = 64
# Large enough to tell an aspect by.
_LARGE = 1 << 20


def of_faces(name: str) -> sm.Projection:
    """Return the named projection as an array of its faces, a flat one as it is."""
    plain = sm.projection(name)
    return plain if plain.faces == 1 else sm.projection(name, layout="faces")


def size_of_height(projection: sm.Projection, height: int) -> int:
    """Return the size at which a flat image has that many rows."""
    return _size_of(projection, "height", height)


def size_of_width(projection: sm.Projection, width: int) -> int:
    """Return the size at which an image has that many columns."""
    return _size_of(projection, "width", width)


def _size_of(projection: sm.Projection, side: Literal["height", "width"], texels: int) -> int:
    axis = -2 if side == "height" else -1
    size = _UNIT
    # Sides are rounded: those of an image that is much larger say the aspect well enough.
    for _ in range(3):
        large = max(size, min(16 * size, _LARGE))
        size = max(1, round(large * texels / projection.shape(large)[axis]))
    near = {projection.shape(n)[axis]: n for n in (size + 1, max(1, size - 1), size)}
    if texels not in near:
        nearest = sorted(sorted(near, key=lambda n: abs(n - texels))[:2])
        having = " or ".join(map(str, nearest))
        raise ValueError(
            f"Expected a {side} that {described(projection)} can have, as {having}, got {texels}."
        )
    return near[texels]


def fits(projection: sm.Projection, height: int, width: int) -> bool:
    """Tell whether an image of this size has the aspect of the projection, as functions ask it."""
    try:
        projection.shape((height, width))
    except ValueError:
        return False
    return images.fits(projection, (height, width))


def _is_exact(projection: sm.Projection, height: int, width: int) -> bool:
    rows, columns = projection.shape(_UNIT)
    return height * columns == width * rows and height * _UNIT % rows == 0


def of_file(
    name: str,
    layout: str | None,
    height: int,
    width: int,
    *,
    any_aspect: bool = False,
    advice: str = "",
) -> sm.Projection:
    """Return the projection of an image that has been read, of a layout that fits it.

    An image of another aspect is an error, which ends with the command's advice.
    """
    plain = sm.projection(name, layout=layout)
    if plain.faces == 1:
        candidates = [plain]
    else:
        candidates = [flat(name, found) for found in ([layout] if layout else layouts(plain.name))]
    for candidate in candidates:
        if fits(candidate, height, width) or any_aspect:
            return candidate
    wanted = " or ".join(
        f"{columns} x {rows} ({described(candidate)})"
        for candidate in candidates
        for rows, columns in [_nearest_shape(candidate, height)]
    )
    raise ValueError(
        f"the image is {width} x {height} (width x height), expected for example {wanted}"
        + (f"; {advice}" if advice else "")
    )


def fitting(height: int, width: int) -> list[str]:
    """Return what an image of this size may be, as ``"cube (cross, dice)"``."""
    found = []
    for name in sm.projections():
        if layouts(name):
            fit = [n for n in layouts(name) if fits(sm.projection(name, layout=n), height, width)]
            if fit:
                found.append(f"{name} ({', '.join(fit)})")
        elif fits(sm.projection(name), height, width):
            found.append(name)
    return found


def taken(
    name: str | None,
    said: str | None,
    height: int,
    width: int,
    *,
    any_aspect: bool = False,
    advice: str = "",
) -> sm.Projection:
    """Return the projection of an image: as named, as the file says, or what is likely.

    Where it says what does not fit, nothing else is likely: that is an error.
    """
    name = name or said or likely(height, width)
    return of_file(name, None, height, width, any_aspect=any_aspect, advice=advice)


def leveled(tilt: tuple[float, float]) -> str | None:
    """Return how a camera was tilted and what makes its panorama level, or None if it is."""
    pitch, roll = tilt
    if not pitch and not roll:
        return None
    # Up, and the other way round: with the roll of the camera the horizon turns left.
    turn = f"convert --rotation 0 {pitch:g} {0.0 - roll:g}"
    return f"the camera was tilted, pitch {pitch:g}°, roll {roll:g}°: {turn} makes it level"


def noted(name: str, projection: sm.Projection) -> str | None:
    """Return what an image of the named projection may say of itself."""
    own = sm.projection(name).layout
    if own == "faces" and projection.layout != "faces":
        # A reader takes the first layout of the image's aspect.
        own = of_file(name, None, *projection.shape(_UNIT)).layout
    # Another layout than the convention's own is not what its name says.
    return name if own in (None, "faces", projection.layout) else None


def likely(height: int, width: int) -> str:
    """Return what a panorama of this size most often is: a square one is a light probe."""
    # Within a texel, a tiny image is of every aspect.
    for right in (_is_exact, fits):
        for name in ("latlong", "angular", "cube"):
            options = layouts(name) or (None,)
            if any(right(sm.projection(name, layout=x), height, width) for x in options):
                return name
    return "latlong"


def described(projection: sm.Projection) -> str:
    """Return the name with the layout, as ``"cube cross"``."""
    return f"{projection.name} {projection.layout}" if projection.layout else projection.name


def _nearest_shape(projection: sm.Projection, height: int) -> tuple[int, ...]:
    rows = projection.shape(_UNIT)[0]
    return projection.shape(max(1, round(height * _UNIT / rows)))
