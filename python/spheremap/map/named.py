"""What a name stands for: a projection, alone or as a program has it."""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np

from .. import _core
from .._scalars import as_text
from .._show import Rows

if TYPE_CHECKING:
    from .._names import LayoutName, ProjectionName, QualifiedName
    from .._projection import Projection

    # `str` is there for names that arrive in variables; the literals are what editors complete.
    ProjectionLike: TypeAlias = Projection | ProjectionName | QualifiedName | str

__all__ = ["conventions", "projection"]

# What is done where the worlds of two maps differ.
Worlds: TypeAlias = Literal["match", "literal"]

# What people who have a camera in pixels say of it.
PIXELS = frozenset({"K", "fx", "fy", "f", "focal", "focal_length", "width", "height"})

# Only names that resolved get in, so it cannot grow beyond the registry.
_named: dict[str, Projection] = {}

# What projections are made of. The class that people see has verbs of all rooms and stands above
# them; the package hands it down, so that no room imports from above.
_class: type[Projection]
_made = _core.Projection.__new__


@cache
def registered() -> tuple[dict[str, Any], ...]:
    """Return what every projection claims. Ranges of densities are searched for: only once."""
    return tuple(_core.registry())


def use_class(made: type[Projection]) -> None:
    """Make projections of this class."""
    global _class
    _class = made


def made(name: str, **options: Any) -> Projection:
    """Return a projection by its name, its parameters and what else `projection` takes."""
    for parameter, value in options.items():
        if value is np.ma.masked:
            raise TypeError(f"`{parameter}` must be a number, got one that is masked.")
    try:
        return _made(_class, name, **options)
    except ValueError:
        word = re.split("[(:]", name, maxsplit=1)[0]
        known = word.casefold()
        if known == word or all(entry["name"] != known for entry in registered()):
            raise
    raise ValueError(f"unknown projection {word!r}; did you mean {known!r}?")


def resolve(
    projection: ProjectionLike, axes: str | None = None, rotation: Any | None = None
) -> Projection:
    """Return the projection that a name stands for, with other axes and its world turned.

    This is all that `rotation` does, in every function that takes it.
    """
    if axes is not None or rotation is not None:
        return resolve(projection)._seen(axes, rotation)
    if type(projection) is _class:
        return projection
    try:
        found = _named.get(projection)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        # Nothing that has a hash.
        found = None
    return _first_time(projection) if found is None else found


def resolve_pair(
    src: ProjectionLike, dst: ProjectionLike, rotation: Any | None, world: Worlds
) -> tuple[Projection, Projection]:
    """Return two maps with their directions in the first one's world, which is turned.

    This is all that `world` does, but in `convert`, whose core does it.
    """
    if as_text(world, "world") not in ("match", "literal"):
        raise ValueError(f"Expected `world` to be 'match' or 'literal', got {world!r}.")
    source, target = resolve(src, rotation=rotation), resolve(dst)
    return source, target.in_world_of(source) if world == "match" else target


def _first_time(projection: object) -> Projection:
    if isinstance(projection, _class):
        return projection
    if not isinstance(projection, str):
        raise TypeError(
            f"Expected a Projection or the name of one, got {type(projection).__name__}."
        )
    found = made(projection)
    # With parameters there is no end of names.
    if "(" not in projection:
        _named[projection] = found
    return found


# The first is for parameters in a dict, `**{"fov": 90.0}`, which might otherwise be an option; a
# number in the place of an option is an error when it comes.
@overload
def projection(
    name: ProjectionName | QualifiedName | str, /, **parameters: float
) -> Projection: ...
@overload
def projection(
    name: ProjectionName | QualifiedName | str,
    /,
    *,
    convention: str | None = None,
    axes: str | None = None,
    grid: str | None = None,
    layout: LayoutName | str | None = None,
    world: str | None = None,
    **parameters: float,
) -> Projection: ...
def projection(  # type: ignore[misc]
    name: ProjectionName | QualifiedName | str,
    /,
    *,
    convention: str | None = None,
    axes: str | None = None,
    grid: str | None = None,
    layout: LayoutName | str | None = None,
    world: str | None = None,
    **parameters: float,
) -> Projection:
    """Return a projection: a frozen, hashable, picklable value with verbs as methods.

    Parameters
    ----------
    name : str
        ``"latlong"``, with parameters ``"perspective(fov=60)"``, with a convention
        ``"latlong:mitsuba"``, or with both ``"angular(fov=180):openimageio"``. `projections` lists
        the names. The same strings serve wherever a projection is asked for.
    convention : str, optional
        The program whose axes, grid, layout and parameters to use, as in ``"mitsuba"``.
        `conventions` lists them.
    axes : str, optional
        Which signed world axes point right, down and forward (into the image center), as in
        ``"+x -y -z"``.
    grid : {"centers", "corners", "corners-v"}, optional
        Where the texels lie: at (i + 1/2)/n, at i/(n - 1), or the latter in v alone.
    layout : str, optional
        How several faces lie in an image: ``"faces"`` (an array of faces), ``"strip"`` or
        ``"column"``; of cubes also ``"cross"``, ``"vertical_cross"``, ``"vertical_cross_upright"``,
        ``"dice"``, ``"tee"`` or ``"3x2"``. ``"healpix"`` has ``"faces"`` and ``"4x3"``,
        ``"icosahedral"`` has ``"faces"`` and ``"5x2"``.
    world : str, optional
        Which axes of its world point to the right, up and ahead of a person who stands in it, as
        in ``"+x +z +y"``; by default those of the convention's program, else ``"+x +y -z"``. It
        changes no axis of the map: `convert` matches worlds by it.
    **parameters : float
        The projection's own parameters, as ``fov`` (degrees) of ``"angular"``.

    Returns
    -------
    Projection

    Raises
    ------
    ValueError
        For an unknown name, convention or parameter, or a value out of range.

    Examples
    --------
    >>> import spheremap as sm
    >>> p = sm.projection("angular", fov=180)
    >>> p.coverage
    'cap'
    >>> p.encode([0.0, 0.0, -1.0]).tolist()
    [0.5, 0.5]
    """
    if not isinstance(name, str):
        raise TypeError(f"Expected the name of a projection, got {type(name).__name__}.")
    try:
        return made(
            name,
            convention=convention,
            axes=axes,
            grid=grid,
            layout=layout,
            world=world,
            **parameters,
        )
    except (TypeError, ValueError) as error:
        if PIXELS.isdisjoint(parameters):
            raise
        said = str(error).rstrip(".")
        raise type(error)(
            f"{said}; `sm.camera(K, size)` makes the projection of a camera from pixels"
        ) from None


class Conventions(Rows):
    """Rows of the table of conventions: a list of dicts that prints as a table."""

    HEAD = ("name", "axes", "grid", "layout", "parameters", "up", "ahead", "hand", "verified")

    @classmethod
    def cells(cls, row: dict[str, Any]) -> tuple[str, ...]:
        """Return what the table shows of a row: the hand and the direction ahead by one word."""
        given = row.get("parameters") or {}
        shown = {
            **row,
            "name": f"{row.get('kind')}:{row.get('name')}",
            "layout": row.get("layout") or "",
            "parameters": ", ".join(f"{key}={value:g}" for key, value in given.items()),
            "ahead": row.get("forward", ""),
            "hand": "left" if row.get("left_handed") else "right",
        }
        return super().cells(shown)


def conventions(name: ProjectionName | str | None = None) -> Conventions:
    """Return what named programs use: one row for each program and projection.

    Parameters
    ----------
    name : str, optional
        Of a projection, or of a program such as ``"unity"``, to get its rows alone.

    Returns
    -------
    rows : list of dict
        Prints as a table. With ``kind``, ``name``, ``axes``, ``grid``, ``layout``, ``parameters``,
        ``note``, ``source``, ``version`` and ``verified``; and of the program's world ``up``,
        ``forward``, ``left_handed``, and why that is ahead, ``ahead``.

    Raises
    ------
    ValueError
        For an unknown name.

    Examples
    --------
    >>> import spheremap as sm
    >>> [row["axes"] for row in sm.conventions("latlong") if row["name"] == "mitsuba"]
    ['-x -y +z']
    >>> [f"{row['kind']}:{row['name']}" for row in sm.conventions("unity")]
    ['cube:unity', 'latlong:unity']
    """
    rows = Conventions(_core.convention_table())
    if name is None:
        return rows
    if isinstance(name, str):
        program = name.lower()
        # A program that lays a kind out in several ways has a row for each: ffmpeg-c3x2.
        found = Conventions(row for row in rows if f"{row['name']}-".startswith(f"{program}-"))
        if found:
            return found
    try:
        kind = resolve(name).name
    except ValueError as error:
        # It may know what others call a projection, but no programs.
        if "; there are " not in str(error):
            raise
        known = {row["name"].split("-")[0] for row in rows}
        known |= {entry["name"] for entry in registered()}
        _core.check_word("projection or program", name, sorted(known))
        raise
    return Conventions(row for row in rows if row["kind"] == kind)
