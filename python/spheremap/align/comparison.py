"""What turns one convention into another, in words and as a matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..map.named import resolve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["Comparison", "compare"]


@dataclass(frozen=True, eq=False)
class Comparison:
    """How an image read in one way differs from the same image read in another.

    Attributes
    ----------
    a, b : Projection
        The two ways.
    matrix : ndarray of float64, shape (3, 3), or None
        Takes the direction that `a` sees at a place of the image to the one that `b` sees there,
        the order of faces and the layout aside: a signed permutation. None where no single one
        does: another kind of map, or faces that turn each in its own way.
    mirrored : bool or None
        Whether that is a mirror image, whose determinant is -1.
    differences : tuple of str
        Everything that differs, one phrase each; empty where nothing does.
    worlds : str
        What `convert` does with directions to match the worlds of the two programs; empty where
        both have one world.
    """

    a: Projection
    b: Projection
    matrix: NDArray[np.float64] | None
    mirrored: bool | None
    differences: tuple[str, ...]
    worlds: str = ""

    @property
    def same(self) -> bool:
        """Whether every texel sees the same direction in both."""
        return not self.differences

    def __repr__(self) -> str:
        said = "; ".join(self.differences) or "the same, texel by texel"
        return f"Comparison({_title(self.a)} -> {_title(self.b)}: {said})"

    def __str__(self) -> str:
        lines = [f"{_title(self.a)} -> {_title(self.b)}"]
        lines.append("; ".join(self.differences) or "the same, texel by texel")
        if self.matrix is not None and not np.array_equal(self.matrix, np.eye(3)):
            lines.append("direction in b = M @ direction in a, M =")
            lines += ["  " + " ".join(f"{x:+.0f}" for x in row) for row in self.matrix]
        if self.worlds:
            programs, _, done = self.worlds.partition(": ")
            lines += [f"convert matches worlds: {programs}", f"  {done}"]
        return "\n".join(lines)


def compare(a: ProjectionLike, b: ProjectionLike) -> Comparison:
    """Tell what turns one convention into another.

    Parameters
    ----------
    a, b : Projection or str
        As for `projection`: ``"latlong:blender"``, ``"cube:opengl"``.

    Returns
    -------
    Comparison
        Prints as words and a 3×3 matrix. Its ``matrix`` takes the direction that `a` sees at a
        place of the image to the direction that `b` sees at the same place.

    Raises
    ------
    ValueError, TypeError
        As for `projection`.

    Notes
    -----
    The words say what happens to the scene if an image made for `a` is read as `b`: first the
    mirror, then turns about the world's axes, yaw about the axis that is up in `a`. Angles are in
    degrees and right-handed. Whether programs disagree about their worlds (z up, left-handed) or
    about their images cannot be told from an image: only both together make the matrix. What the
    table says about their worlds is told beside it.
    To turn an image made for `a` into one for `b`, use ``convert(image, a, b)``, which matches the
    worlds: a person sees the same in both. With ``world="literal"`` both images show the same at
    each (x, y, z).

    Examples
    --------
    >>> import spheremap as sm
    >>> print(sm.align.compare("latlong:mitsuba", "latlong:openimageio"))
    latlong:mitsuba -> latlong:openimageio
    grid differs: corners-v and centers, by up to half a texel
    >>> print(sm.align.compare("latlong:skylibs", "latlong:cmft"))
    latlong:skylibs -> latlong:cmft
    mirrored (z changes sign)
    direction in b = M @ direction in a, M =
      +1 +0 +0
      +0 +1 +0
      +0 +0 -1
    convert matches worlds: skylibs (+y up, -z ahead) → cmft (+y up, +z ahead, left-handed)
      (x, y, z) becomes (x, y, -z), another hand, so that nothing is mirrored
    """
    p, q = resolve(a), resolve(b)
    matrix, mirrored, differences = _core.compare(p, q)
    rows = None if matrix is None else np.array(matrix, np.float64)
    worlds = _core.worlds(p, q) or ""
    return Comparison(p, q, rows, mirrored, tuple(differences), worlds)


def _title(p: Projection) -> str:
    return f"{p.name}:{p.convention}" if p.convention else p.name
