"""What a name stands for: a projection, alone or as a program has it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

from .. import _core
from .._core import Projection

if TYPE_CHECKING:
    from .._names import LayoutName, ProjectionName, QualifiedName

    # `str` is there for names that arrive in variables; the literals are what editors complete.
    ProjectionLike: TypeAlias = Projection | ProjectionName | QualifiedName | str

__all__ = ["conventions", "projection"]

# Only names that resolved get in, so it cannot grow beyond the registry.
_named: dict[str, Projection] = {}


def resolve(projection: ProjectionLike, axes: str | None = None) -> Projection:
    """Return the projection that a name stands for, with other axes if they are given."""
    if axes is not None:
        return _with_axes(resolve(projection), axes)
    if type(projection) is Projection:
        return projection
    try:
        return _named[projection]
    except (KeyError, TypeError):
        return _first_time(projection)


def _first_time(projection: object) -> Projection:
    if not isinstance(projection, str):
        raise TypeError(
            f"Expected a Projection or the name of one, got {type(projection).__name__}."
        )
    name, colon, convention = projection.partition(":")
    found = _core.projection(name, convention=convention if colon else None)
    _named[projection] = found
    return found


@lru_cache(maxsize=256)
def _with_axes(base: Projection, axes: str) -> Projection:
    return _core.projection(
        base.name,
        convention=base.convention,
        axes=axes,
        grid=base.grid,
        layout=base.layout,
        parameters=base.parameters,
    )


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
    if convention is None and ":" in name:
        name, _, convention = name.partition(":")
    return _core.projection(
        name,
        convention=convention,
        axes=axes,
        grid=grid,
        layout=layout,
        parameters=parameters or None,
    )


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
