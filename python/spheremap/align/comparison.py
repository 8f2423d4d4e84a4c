"""What turns one convention into another, in words and as a matrix."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..map.named import resolve
from ..map.variants import axes_matrix, changed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._core import Projection
    from ..map.named import ProjectionLike

__all__ = ["Comparison", "compare"]

# Inside a face, in no symmetric position, and enough of them for outlines that leave some out.
_PLACES = np.array(
    [[0.3, 0.4], [0.7, 0.35], [0.45, 0.8], [0.62, 0.58], [0.47, 0.44], [0.41, 0.63], [0.55, 0.27]]
)


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
    """

    a: Projection
    b: Projection
    matrix: NDArray[np.float64] | None
    mirrored: bool | None
    differences: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether every texel sees the same direction in both."""
        return not self.differences

    def __str__(self) -> str:
        lines = [f"{_title(self.a)} -> {_title(self.b)}"]
        lines.append("; ".join(self.differences) or "the same, texel by texel")
        if self.matrix is not None and not np.array_equal(self.matrix, np.eye(3)):
            lines.append("direction in b = M @ direction in a, M =")
            lines += ["  " + " ".join(f"{x:+.0f}" for x in row) for row in self.matrix]
        return "\n".join(lines)


def compare(a: ProjectionLike, b: ProjectionLike, /) -> Comparison:
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
    about their images cannot be told from an image: only both together make the matrix.
    To turn an image made for `a` into one for `b` that shows the same directions, use
    ``convert(image, a, b)``.

    Examples
    --------
    >>> import spheremap as sm
    >>> print(sm.align.compare("latlong:mitsuba", "latlong:openimageio"))
    latlong:mitsuba -> latlong:openimageio
    grid differs: corners-v and centers, by up to half a texel
    >>> print(sm.align.compare("latlong:skylibs", "latlong:filament"))
    latlong:skylibs -> latlong:filament
    mirrored (z changes sign); grid differs: centers and corners, by up to half a texel
    direction in b = M @ direction in a, M =
      +1 +0 +0
      +0 +1 +0
      +0 +0 -1
    """
    p, q = resolve(a), resolve(b)
    if p.name != q.name or p.parameters != q.parameters:
        return _of_kinds(p, q)
    differences: list[str] = []
    matrix: NDArray[np.float64] | None = None
    if p.layout != q.layout:
        differences.append(f"layout differs: {p.layout} and {q.layout}")
        p, q = changed(p, layout="faces"), changed(q, layout="faces")
    faces, moved = _faces(p, q)
    order = None if _same(faces) else _order(p, q)
    if _same(faces) or order is not None:
        matrix = faces[0] if order is None else axes_matrix(q.axes).T @ axes_matrix(p.axes)
        words = _words(matrix, _up(p))
        if words:
            differences.insert(0, words)
        if order is not None:
            differences.append(
                f"face order differs: 0 1 2 ... of the first are {order} of the second"
            )
    else:
        differences += moved
    if p.grid != q.grid:
        differences.append(f"grid differs: {p.grid} and {q.grid}, by up to half a texel")
    mirrored = None if matrix is None else bool(np.linalg.det(matrix) < 0)
    return Comparison(resolve(a), resolve(b), matrix, mirrored, tuple(differences))


def _of_kinds(p: Projection, q: Projection) -> Comparison:
    what = [f"{r.name}{''.join(f', {k} {v:g}' for k, v in r.parameters.items())}" for r in (p, q)]
    differences = [
        f"another kind of image: {what[0]} and {what[1]}; convert turns one into the other"
    ]
    centers = [r.axes.split()[2] for r in (p, q)]
    if centers[0] != centers[1]:
        differences.append(f"what lies ahead differs: {centers[0]} and {centers[1]}")
    if p.mirrored != q.mirrored and max(p.faces, q.faces) == 1:
        differences.append("one is mirrored")
    if p.grid != q.grid:
        differences.append(f"grid differs: {p.grid} and {q.grid}")
    return Comparison(p, q, None, None, tuple(differences))


def _faces(p: Projection, q: Projection) -> tuple[list[NDArray[np.float64]], list[str]]:
    """For each face, or cell, the signed permutation between what both see, and words for it."""
    matrices, words = [], []
    for name, uv in _cells(p):
        d, e = p.decode(uv), q.decode(uv)
        matrix = _between(d, e)
        matrices.append(matrix)
        if not np.array_equal(matrix, np.eye(3)):
            words.append(f"{name}: {_words(matrix, _up(p))}")
    return matrices, words


def _same(matrices: list[NDArray[np.float64]]) -> bool:
    return all(np.array_equal(m, matrices[0]) for m in matrices)


def _order(p: Projection, q: Projection) -> str | None:
    """Return which faces of `q` show what the faces of `p` show, as their axes say it."""
    if not p.faces == q.faces > 1:
        return None
    matrix = axes_matrix(q.axes).T @ axes_matrix(p.axes)
    wanted = [p.decode(uv) @ matrix.T for _, uv in _cells(p)]
    shown = [q.decode(uv) for _, uv in _cells(q)]
    order = [[k for k, e in enumerate(shown) if np.allclose(d, e)] for d in wanted]
    return " ".join(str(k[0]) for k in order) if all(order) else None


def _cells(p: Projection) -> list[tuple[str, NDArray[np.float64]]]:
    """Return places inside each face that is stored, with its name."""
    if p.faces > 1:
        column = np.ones((len(_PLACES), 1))
        stack = [(f"face {k}", np.hstack([_PLACES, k * column])) for k in range(p.faces)]
        return [(name, uv[p.valid(uv)]) for name, uv in stack]
    if p.layout is None:
        # Around the middle, where every map holds sphere.
        return [("the image", 0.5 + 0.4 * (_PLACES - 0.5))]
    rows, columns = (n // 2 for n in p.shape(2))
    cells = [
        (f"cell ({i}, {j})", (_PLACES + np.array([i, j])) / np.array([columns, rows]))
        for j, i in itertools.product(range(rows), range(columns))
    ]
    return [(name, uv[p.valid(uv)]) for name, uv in cells if p.valid(uv).any()]


def _between(d: NDArray[Any], e: NDArray[Any]) -> NDArray[np.float64]:
    """Return the signed permutation M with e = M d."""
    matrix = np.zeros((3, 3))
    for i in range(3):
        # Component i of e is a component of d, but for its sign.
        far = np.abs(np.abs(d) - np.abs(e[:, i : i + 1])).max(axis=0)
        k = int(np.argmin(far))
        matrix[i, k] = 1.0 if np.sum(d[:, k] * e[:, i]) > 0 else -1.0
    return matrix


def _up(p: Projection) -> str:
    """Return the axis that is up in the world of a map: of its convention, else +y."""
    for row in _core.convention_table():
        if (row["kind"], row["name"]) == (p.name, p.convention):
            return str(row["up"])
    return "+y"


def _words(matrix: NDArray[np.float64], up: str) -> str:
    """Return a signed permutation as a mirror, if need be, and turns."""
    if np.array_equal(matrix, np.eye(3)):
        return ""
    parts = []
    whole = matrix
    if np.linalg.det(matrix) < 0:
        # The mirror that leaves the shortest turn; among equals one that keeps up where it is.
        order = sorted(range(3), key=lambda k: "xyz"[k] == up[1])
        mirrors = [np.diag([-1.0 if i == k else 1.0 for i in range(3)]) for k in order]
        best = max(mirrors, key=lambda m: float(np.trace(matrix @ m)))
        axis = "xyz"[int(np.argmin(np.diag(best)))]
        parts.append(f"mirrored ({axis} changes sign)")
        matrix = matrix @ best
    turn = _turn(matrix, up)
    text = ", then ".join([*parts, *([turn] if turn else [])])
    rises = whole[:, "xyz".index(up[1])] * (1 if up[0] == "+" else -1)
    k = int(np.flatnonzero(rises)[0])
    goes = f"{'+' if rises[k] > 0 else '-'}{'xyz'[k]}"
    return text if goes == up else f"{text}: {up}, which is up, becomes {goes}"


def _turn(r: NDArray[np.float64], up: str) -> str:
    """Return a rotation of the cube in words: yaw about up, or a turn about its own axis."""
    angle = round(math.degrees(math.acos(max(-1.0, min(1.0, (float(np.trace(r)) - 1) / 2)))))
    if angle == 0:
        return ""
    if angle == 180:
        values, vectors = np.linalg.eigh((r + r.T) / 2)
        axis = vectors[:, int(np.argmax(values))]
    else:
        axis = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    axis = np.rint(axis / np.abs(axis).max()) + 0.0
    if angle == 180 and axis[np.flatnonzero(axis)[0]] < 0:
        axis = 0.0 - axis
    if np.count_nonzero(axis) > 1:
        names = " ".join(f"{x:+.0f}" for x in axis)
        return f"turned by {angle}° about ({names})"
    k = int(np.flatnonzero(axis)[0])
    if "xyz"[k] == up[1]:
        sign = axis[k] * (1 if up[0] == "+" else -1)
        return f"yaw {angle if angle == 180 else round(sign * angle)}°"
    sign_of_axis = "+" if axis[k] > 0 else "-"
    return f"turned by {angle}° about {sign_of_axis}{'xyz'[k]}"


def _title(p: Projection) -> str:
    return f"{p.name}:{p.convention}" if p.convention else p.name
