"""The list of projections: filtered by what they claim, printed as a table to choose from."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from .._scalars import as_number, as_text, as_whole
from .._show import html_table, text_table
from .evenly import points
from .named import registered, resolve

# Directions of the sphere at which figures are taken that have no closed form: they are right to
# 0.2 %. The longest texels lie at a rim or a pole, where places even in the image may be few.
_PLACES = 1 << 17
# The columns of the table, and what they mean.
HEAD = (
    "name",
    "coverage",
    "keeps",
    "faces",
    "density",
    "efficiency",
    "aspect",
    "seam",
    "cost",
)
NOTE = (
    "density: largest over smallest solid angle of a texel. efficiency: samples per steradian at "
    "the worst place, and in rms, of what as many even texels would give. aspect: length over "
    "width of a texel, less than this on 99 % of the coverage. cost: steps to encode and to decode."
)


class Figures(NamedTuple):
    """What there is to choose a projection by, at its default parameters."""

    name: str
    coverage: str
    equal_area: bool
    conformal: bool
    faces: int
    density_ratio: float
    efficiency_worst: float
    efficiency_rms: float
    aspect: float
    seam: str
    steps: tuple[int, int]

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of a table."""
        keeps = [
            word for word, kept in (("area", self.equal_area), ("angles", self.conformal)) if kept
        ]
        return (
            self.name,
            self.coverage,
            ", ".join(keeps),
            str(self.faces),
            _ratio(self.density_ratio),
            f"{self.efficiency_worst:.2f}, {self.efficiency_rms:.2f}",
            _three_digits(self.aspect),
            self.seam,
            f"{self.steps[0]} + {self.steps[1]}",
        )


class Projections(tuple[str, ...]):
    """Names of projections; prints as a table."""

    __slots__ = ()

    @property
    def figures(self) -> list[Figures]:
        """The rows of the table."""
        return [figures(name) for name in self]

    def __repr__(self) -> str:
        return text_table(HEAD, (row.cells for row in self.figures))

    def _repr_html_(self) -> str:
        return html_table(HEAD, (row.cells for row in self.figures), NOTE)


def projections(
    *,
    coverage: str | None = None,
    equal_area: bool | None = None,
    conformal: bool | None = None,
    faces: int | None = None,
    seam: str | None = None,
    density_ratio: float | None = None,
) -> Projections:
    """Return the names of all projections, or of those with certain claims.

    What is returned is a tuple of names that prints as a table to choose from: coverage, the
    ratio of the largest to the smallest solid angle of a texel, the efficiency (samples per
    steradian at the worst place and in rms, of what as many even texels would give), the aspect of
    a texel that 99 % of the coverage stays below, what lies beyond the edges, and the cost
    (arithmetic steps to encode and to decode, a division or a root counted as 8). All of it is at
    the default parameters.

    Parameters
    ----------
    coverage : {'sphere', 'hemisphere', 'cap', 'part'}, optional
        Which part of the sphere an image holds.
    equal_area : bool, optional
        Whether every texel sees the same solid angle.
    conformal : bool, optional
        Whether small circles stay circles.
    faces : int, optional
        How many faces.
    seam : str, optional
        What lies beyond the edges, such as ``'ends'``, ``'latlong'`` or ``'faces'``.
    density_ratio : float, optional
        The largest that the ratio of densities may be.

    Returns
    -------
    names : tuple of str
        In the order of the registry. ``names.figures`` are the rows of the table.

    Raises
    ------
    ValueError
        For a coverage or a seam that no projection has.
    TypeError
        For a claim that is not a bool.

    Examples
    --------
    >>> import spheremap as sm
    >>> "octahedral" in sm.projections()
    True
    >>> list(sm.projections(equal_area=True, coverage="sphere", faces=1, seam="rim-mirrored"))
    ['mollweide', 'hammer', 'sinusoidal']
    """
    entries = registered()
    for what, value in (("coverage", coverage), ("seam", seam)):
        _check_word(what, value, [entry[what] for entry in entries])
    wanted: dict[str, Any] = {
        "coverage": coverage,
        "equal_area": equal_area,
        "conformal": conformal,
    }
    for what in ("equal_area", "conformal"):
        if not isinstance(wanted[what], bool | None):
            raise TypeError(f"Expected `{what}` to be a bool, got {wanted[what]!r}.")
    wanted |= {"faces": None if faces is None else as_whole(faces, "faces"), "seam": seam}
    if density_ratio is not None:
        density_ratio = as_number(density_ratio, "density_ratio")

    def fits(entry: dict[str, Any]) -> bool:
        low, high = entry["density_range"]
        even = density_ratio is None or (low > 0 and high <= density_ratio * low * (1 + 1e-12))
        return even and all(x is None or entry[what] == x for what, x in wanted.items())

    return Projections(entry["name"] for entry in entries if fits(entry))


def _check_word(what: str, value: str | None, known: list[str]) -> None:
    if value is None or as_text(value, what) in known:
        return
    _core.check_word(what, value, sorted(set(known)))


@cache
def figures(name: str) -> Figures:
    """Return the figures of a projection."""
    entry = next(entry for entry in registered() if entry["name"] == name)
    covered, number = entry["coverage_solid_angle"], entry["faces"]
    low, high = entry["density_range"]
    p = resolve(name)
    # About the axis of most maps, along which their figures change.
    spread = np.roll(points(_PLACES), 1, axis=-1)
    uv = p.encode(spread[p.covers(spread)])
    # The mean of the density over the coverage: that of an equal-area map is the density itself.
    density = high if low == high else float(np.nanmean(p.density(uv)))
    height, width = p.shape(64)[-2:]
    aspects = _aspects(p.jacobian(uv), height / width)
    return Figures(
        name=name,
        coverage=entry["coverage"],
        equal_area=entry["equal_area"],
        conformal=entry["conformal"],
        faces=number,
        density_ratio=high / low if low > 0 else math.inf,
        efficiency_worst=covered / (number * high),
        efficiency_rms=covered / (number * density) if math.isfinite(high) else 0.0,
        aspect=float(np.nanquantile(aspects, 0.99, method="hazen")),
        seam=entry["seam"],
        steps=tuple(entry["steps"]),
    )


def _aspects(jacobian: np.ndarray[Any, Any], stretch: float) -> np.ndarray[Any, Any]:
    """Return the ratios of the singular values of (..., 3, 2) matrices, columns 0 stretched."""
    aa, ab, bb = (
        np.einsum("...i,...i", jacobian[..., i], jacobian[..., j])
        for i, j in ((0, 0), (0, 1), (1, 1))
    )
    aa, ab = aa * stretch**2, ab * stretch
    spread = np.hypot(aa - bb, 2 * ab)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios: np.ndarray[Any, Any] = np.sqrt((aa + bb + spread) / np.maximum(aa + bb - spread, 0))
    return ratios


def _ratio(x: float) -> str:
    return f"{x:.2f}" if x < 1000 else "inf"


def _three_digits(x: float) -> str:
    return f"{x:.{max(2 - math.floor(math.log10(x)), 0)}f}" if x < 1000 else "inf"
