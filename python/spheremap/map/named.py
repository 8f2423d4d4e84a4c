"""What a name stands for: a projection, alone or as a program has it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from .. import _core

if TYPE_CHECKING:
    from .._names import LayoutName, ProjectionName, QualifiedName
    from .._projection import Projection

    # `str` is there for names that arrive in variables; the literals are what editors complete.
    ProjectionLike: TypeAlias = Projection | ProjectionName | QualifiedName | str

__all__ = ["conventions", "projection"]

# Only names that resolved get in, so it cannot grow beyond the registry.
_named: dict[str, Projection] = {}

# What projections are made of. The class that people see has verbs of all rooms and stands above
# them; the package hands it down, so that no room imports from above.
_class: type[Projection]


def use_class(made: type[Projection]) -> None:
    """Make projections of this class."""
    global _class
    _class = made


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
        return _named[projection]  # type: ignore[index]
    except (KeyError, TypeError):
        return _first_time(projection)


def _first_time(projection: object) -> Projection:
    if isinstance(projection, _class):
        return projection
    if not isinstance(projection, str):
        raise TypeError(
            f"Expected a Projection or the name of one, got {type(projection).__name__}."
        )
    found = _named[projection] = _class(projection)
    return found


def projection(
    name: ProjectionName | QualifiedName | str,
    /,
    *,
    convention: str | None = None,
    axes: str | None = None,
    grid: str | None = None,
    layout: LayoutName | str | None = None,
    **parameters: float,
) -> Projection:
    """Return a projection: a frozen, hashable, picklable value with the verbs as methods.

    Parameters
    ----------
    name : str
        ``"latlong"``, or with a convention ``"latlong:mitsuba"``. `projections` lists the names.
    convention : str, optional
        The program whose axes, grid, layout and parameters to use, as in ``"mitsuba"``.
        `conventions` lists them.
    axes : str, optional
        Which signed world axes point right, down and forward (into the image center), as in
        ``"+x -y -z"``.
    grid : {"centers", "corners", "corners-v"}, optional
        Where the texels lie: at (i + 1/2)/n, at i/(n - 1), or the latter in v alone.
    layout : str, optional
        How several faces lie in an image: ``"faces"`` (an array of faces), ``"strip"``,
        ``"column"``, ``"cross"``, ``"vertical_cross"`` or ``"dice"``.
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
    return _class(name, convention=convention, axes=axes, grid=grid, layout=layout, **parameters)


def conventions(kind: ProjectionName | str | None = None) -> list[dict[str, Any]]:
    """Return what named programs use: one row for each program and projection.

    Parameters
    ----------
    kind : str, optional
        The name of a projection, to get its rows alone.

    Returns
    -------
    rows : list of dict
        With ``kind``, ``name``, ``axes``, ``grid``, ``layout``, ``parameters``, ``note``,
        ``source``, ``version`` and ``verified``.

    Raises
    ------
    ValueError
        For an unknown name.

    Examples
    --------
    >>> import spheremap as sm
    >>> [row["axes"] for row in sm.conventions("latlong") if row["name"] == "mitsuba"]
    ['-x -y +z']
    """
    rows = _core.convention_table()
    if kind is None:
        return rows
    name = resolve(kind).name
    return [row for row in rows if row["kind"] == name]
