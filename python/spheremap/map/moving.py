"""Maps whose parameters move, for gradients: what places and directions change by.

A kernel takes its parameters as plain numbers, and what it makes of them beforehand (where a lens
ends, where a search begins) has no derivative to follow. So these are differences of the kernel in
float64, of fourth order: within some 1e-10 of a derivative, for every map. A direction leaves the
image when a parameter moves and a place does not; so differences are of `decode`, and the
derivatives of `encode` follow from them and from `jacobian`.
"""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .named import projection, registered, resolve
from .spec import spec_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .._projection import Projection
    from .named import ProjectionLike

    Floats = NDArray[np.floating[Any]]

__all__ = ["at_rest", "decode_slopes", "encode_slopes", "made", "moved", "now", "spec_without"]

# How far a parameter moves, over its size or 1: its fourth power is 1e-14, and what a kernel rounds
# over it 1e-12.
_STEP = 3e-4

# Multiples of the step, and the weights of what is found there: about a number, and to one side.
_CENTRAL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
_FORWARD = ((0, -25 / 12), (1, 4.0), (2, -3.0), (3, 4 / 3), (4, -1 / 4))
_BACKWARD = tuple((-k, -weight) for k, weight in _FORWARD)

# Maps that differ in parameters alone are held, for the calls of one step of a search.
_HELD = 64


def spec_without(p: Projection, names: Sequence[str]) -> str:
    """Return the text that stands for a map but for some of its parameters."""
    _, (_, name, options) = p.__reduce__()
    kept = {key: value for key, value in options.items() if key not in names}
    return json.dumps([name, kept])


def made(name: ProjectionLike, numbers: dict[str, Any]) -> Projection:
    """Return a projection with other parameters; of a name also with other options."""
    if isinstance(name, str):
        return projection(name, **numbers)
    given = resolve(name)
    if numbers.keys() - given.parameters.keys():
        raise TypeError("Expected parameters alone beside a Projection, which has all the rest.")
    return moved(spec_without(given, tuple(numbers)), tuple(numbers), tuple(numbers.values()))


def now(name: ProjectionLike, numbers: dict[str, Any], values: dict[str, float | None]) -> str:
    """Return the text of a map as it is now; a number that is not known is what it is by itself."""
    known = {key: value for key, value in values.items() if value is not None}
    found = made(name, {**numbers, **known})
    for key in values.keys() - found.parameters.keys():
        # It says which there are.
        projection(found.name, **{key: 1.0})
    return spec_of(found)


def at_rest(p: Projection, names: Sequence[str]) -> Projection:
    """Return a map whose images are looked up in as those of `p`, the same while `p` moves.

    It is `p` itself where other parameters make another image: of other seams or another outline.
    """
    try:
        found = moved(spec_without(p, names), (), ())
    except ValueError:
        # What goes together with other values, and not with these.
        return p
    return found if (found.seam, found.used_part) == (p.seam, p.used_part) else p


@lru_cache(_HELD)
def moved(spec: str, names: tuple[str, ...], values: tuple[float, ...]) -> Projection:
    """Return the map of a text of `spec_without`, with these parameters."""
    name, options = json.loads(spec)
    options |= dict(zip(names, values, strict=True))
    made: Projection = _core._rebuild(type(resolve("latlong")), name, options)
    return made


@lru_cache(_HELD)
def _stencils(
    spec: str, names: tuple[str, ...], values: tuple[float, ...], name: str
) -> tuple[float, list[tuple[tuple[int, float], ...]]]:
    """Return the step of a parameter, and the differences that its range allows."""
    made = moved(spec, names, values)
    (range_,) = (
        one
        for entry in registered()
        if entry["name"] == made.name
        for one in entry["parameters"]
        if one["name"] == name
    )
    value = values[names.index(name)]
    step = min(_STEP * max(abs(value), 1.0), (value - range_["minimum"]) / 4.5)
    found = [_BACKWARD]
    if value + 4 * step <= range_["maximum"]:
        found = [_FORWARD, _BACKWARD]
    if value + 2 * step <= range_["maximum"]:
        found.insert(0, _CENTRAL)
    return step, found


def _by_one(
    spec: str, names: tuple[str, ...], values: tuple[float, ...], name: str, uv: Floats
) -> Floats:
    """Return the derivatives of the directions of places by one parameter."""
    step, stencils = _stencils(spec, names, values, name)
    at = names.index(name)

    def difference(stencil: tuple[tuple[int, float], ...], where: Floats) -> Floats:
        found = np.zeros((*where.shape[:-1], 3))
        for steps, weight in stencil:
            given = list(values)
            given[at] += steps * step
            try:
                p = moved(spec, names, tuple(given))
            except ValueError:
                # Parameters that do not go together.
                return np.full_like(found, np.nan)
            found += (weight / step) * type(p).decode(p, where)
        return found

    flat = np.asarray(uv, np.float64).reshape(-1, uv.shape[-1])
    found = difference(stencils[0], flat)
    # Where a lens ends sooner on one side, the other side tells.
    for stencil in stencils[1:]:
        missing = np.flatnonzero(np.isnan(found[:, 0]) & ~np.isnan(flat).any(axis=-1))
        if len(missing):
            found[missing] = difference(stencil, flat[missing])
    return found.reshape(*uv.shape[:-1], 3)


def decode_slopes(
    spec: str, names: tuple[str, ...], values: tuple[float, ...], uv: Floats
) -> NDArray[np.float64]:
    """Return the derivatives (..., 3, 2 + n) of directions by u, v and n parameters."""
    p = moved(spec, names, values)
    places = np.asarray(uv, np.float64)
    moving = [_by_one(spec, names, values, name, places)[..., None] for name in names]
    columns: NDArray[np.float64] = np.concatenate([type(p).jacobian(p, places), *moving], axis=-1)
    return columns


def encode_slopes(
    spec: str, names: tuple[str, ...], values: tuple[float, ...], directions: Floats
) -> NDArray[np.float64]:
    """Return the derivatives (..., 2, 3 + n) of u and v by a direction and n parameters."""
    p = moved(spec, names, values)
    d = np.asarray(directions, np.float64)
    columns = decode_slopes(spec, names, values, type(p).encode(p, d))
    of_place, of_parameters = columns[..., :2], columns[..., 2:]
    rows = of_place.swapaxes(-1, -2)
    (a, b), (_, c) = np.moveaxis(rows @ of_place, (-2, -1), (0, 1))
    # The inverse, tangent to the sphere: of the products of the two columns.
    solved = np.stack([np.stack([c, -b], -1), np.stack([-b, a], -1)], -2)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = solved / (a * c - b * b)[..., None, None] @ rows
        length = np.linalg.norm(d, axis=-1)[..., None, None]
        found: NDArray[np.float64] = np.concatenate(
            # A place that stays where a direction is moves against what the parameter makes of it.
            [inverse / length, -(inverse @ of_parameters)],
            axis=-1,
        )
    return found
