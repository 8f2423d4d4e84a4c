"""Rotations that change over time, from keyframes."""

from __future__ import annotations

import csv
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._arrays import as_array
from .._scalars import as_number
from ..cameras.quaternions import from_matrix, to_matrix
from ..io.whole import as_path
from ..map.verbs import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Keyframes", "read_keyframes"]

COLUMNS = ("time", "yaw", "pitch", "roll")


@dataclass(frozen=True)
class Keyframes:
    """A rotation that changes over time: ``rotation=`` of `video.convert` takes it.

    Called with a time in seconds it gives the rotation there. Between two keyframes it turns about
    one axis at an even speed, the shorter way (Shoemake 1985); before the first and after the last
    it stays.

    Attributes
    ----------
    times : tuple of float
        Seconds from the first frame, each later than the one before.
    angles : tuple of (float, float, float)
        Yaw, pitch and roll at each, in degrees, as for `spheremap.rotation`.

    Raises
    ------
    ValueError
        For no keyframes, times that do not rise, or numbers that are not finite.

    Notes
    -----
    Half a turn or more from one keyframe to the next has no shorter way: for full turns give a
    keyframe every 120° or so.

    References
    ----------
    .. [1] Shoemake, K., Animating Rotation with Quaternion Curves, SIGGRAPH 1985.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> turning = sm.video.Keyframes((0, 2), ((0, 0, 0), (90, 0, 0)))
    >>> bool(np.allclose(turning(1), sm.rotation(45)))
    True
    """

    times: tuple[float, ...]
    angles: tuple[tuple[float, float, float], ...]

    def __post_init__(self) -> None:
        times, angles = as_array(self.times, "times"), as_array(self.angles, "angles")
        try:
            if "c" in (times.dtype.kind, angles.dtype.kind):
                raise TypeError
            times, angles = np.asarray(times, np.float64), np.asarray(angles, np.float64)
        except (TypeError, ValueError, OverflowError):
            raise ValueError("Expected `times` and `angles` to be real numbers.") from None
        if times.ndim != 1 or not len(times) or angles.shape != (len(times), 3):
            raise ValueError(
                f"Expected `times` of shape (N,) and `angles` of shape (N, 3), got {times.shape} "
                f"and {angles.shape}."
            )
        if not (np.isfinite(times).all() and np.isfinite(angles).all()):
            raise ValueError("Expected `times` and `angles` to be finite.")
        if (np.diff(times) <= 0).any():
            k = int(np.argmax(np.diff(times) <= 0))
            raise ValueError(f"Expected `times` to rise, got {times[k + 1]:g} after {times[k]:g}.")
        object.__setattr__(self, "times", tuple(times.tolist()))
        object.__setattr__(self, "angles", tuple(map(tuple, angles.tolist())))

    def __call__(self, seconds: float, /) -> NDArray[np.float64]:
        """Return the rotation at a time.

        Parameters
        ----------
        seconds : float
            From the first frame.

        Returns
        -------
        matrix : ndarray of float64, shape (3, 3)

        Raises
        ------
        ValueError, TypeError
            For what is no finite number.
        """
        seconds = as_number(seconds, "seconds")
        if not math.isfinite(seconds):
            raise ValueError(f"Expected `seconds` to be finite, got {seconds:g}.")
        last = len(self.times) - 1
        k = int(np.searchsorted(self.times, seconds, side="right")) - 1
        if k < 0 or k >= last:
            return rotation(*self.angles[min(max(k, 0), last)])
        share = (seconds - self.times[k]) / (self.times[k + 1] - self.times[k])
        return _between(rotation(*self.angles[k]), rotation(*self.angles[k + 1]), share)


def _between(a: NDArray[np.float64], b: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return the rotation that is so much of the way from one to another."""
    w, *axis = from_matrix(b @ a.T)
    sine = math.hypot(*axis)
    if sine == 0:
        return a
    half = share * math.atan2(sine, w)
    turn = to_matrix([math.cos(half), *(math.sin(half) * x / sine for x in axis)])
    return turn @ a


def read_keyframes(path: str | os.PathLike[str], /) -> Keyframes:
    r"""Read keyframes from a CSV file of times, yaws, pitches and rolls.

    Parameters
    ----------
    path : str or path
        Of a file whose lines hold a time in seconds and three angles in degrees. A first line of
        words names the columns ``time``, ``yaw``, ``pitch`` and ``roll``, in any order; those that
        are not there are 0. Without it they lie in this order. Lines that begin with ``#`` are
        left out.

    Returns
    -------
    keyframes : Keyframes

    Raises
    ------
    OSError
        Where the file cannot be read.
    ValueError
        For a line that holds something else; the message says which.

    Examples
    --------
    >>> import tempfile, pathlib, spheremap as sm
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "turn.csv"
    >>> _ = path.write_text("time,yaw\n0,0\n2.5,90\n")
    >>> sm.video.read_keyframes(path).angles
    ((0.0, 0.0, 0.0), (90.0, 0.0, 0.0))
    """
    name = as_path(path)
    if not Path(name).exists():
        raise FileNotFoundError(f"no such file: {name!r}")
    try:
        text = Path(name).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{name!r} holds no text") from None
    except OSError as error:
        raise OSError(f"cannot read {name!r}: {error.strerror}") from None
    lines = [
        (k, line)
        for k, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    columns: tuple[str, ...] = COLUMNS
    if lines and not any(_is_number(field) for field in _fields(lines[0][1])):
        columns = _header(name, lines.pop(0)[1])
    rows = [_row(name, k, line, columns) for k, line in lines]
    try:
        return Keyframes(tuple(r[0] for r in rows), tuple((r[1], r[2], r[3]) for r in rows))
    except ValueError as error:
        raise ValueError(f"{name!r}: {error if rows else 'there are no keyframes'}") from None


def _fields(line: str) -> list[str]:
    return [field.strip() for field in next(csv.reader([line]))]


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _header(name: str, line: str) -> tuple[str, ...]:
    columns = tuple(field.lower() for field in _fields(line))
    unknown = [field for field in columns if field not in COLUMNS]
    if unknown or "time" not in columns or len(set(columns)) < len(columns):
        raise ValueError(f"{name!r}: expected columns time, yaw, pitch, roll, got {line.strip()!r}")
    return columns


def _row(name: str, number: int, line: str, columns: tuple[str, ...]) -> list[float]:
    """Return the time, yaw, pitch and roll of a line."""
    fields = _fields(line)
    try:
        values = dict(zip(columns, map(float, fields), strict=True))
    except ValueError:
        raise ValueError(
            f"{name!r}, line {number}: expected {', '.join(columns)}, got {line.strip()!r:.60}"
        ) from None
    return [values.get(column, 0.0) for column in COLUMNS]
