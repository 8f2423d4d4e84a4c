"""Keyframes: rotations over time, and their files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from scipy.spatial.transform import Rotation, Slerp
from spheremap.video import Keyframes, read_keyframes

ANGLES = ((0, 0, 0), (100, 20, -30), (-50, 80, 10), (-50, 80, 10))
TIMES = (-1.0, 0.5, 2.0, 3.0)


def test_it_turns_as_scipy_does() -> None:
    keys = Keyframes(TIMES, ANGLES)
    slerp = Slerp(TIMES, Rotation.from_matrix([sm.rotation(*a) for a in ANGLES]))
    for t in np.linspace(-1, 3, 41):
        # Some products of numbers up to 1, and a division by a sine above 0.1.
        assert np.abs(keys(t) - slerp(t).as_matrix()).max() < 1e-14
    assert np.array_equal(keys(-9), sm.rotation(*ANGLES[0]))
    assert np.array_equal(keys(9), sm.rotation(*ANGLES[-1]))


def test_keyframes_are_values() -> None:
    keys = Keyframes(TIMES, ANGLES)
    assert keys == Keyframes(list(TIMES), np.array(ANGLES)) and len({keys, keys}) == 1  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("times", "angles", "says"),
    [
        ((), (), "shape"),
        ((0, 1), ((0, 0, 0),), "shape"),
        ((1, 1), ((0, 0, 0),) * 2, "rise, got 1 after 1"),
        ((0, np.nan), ((0, 0, 0),) * 2, "finite"),
        ((0,), (("x", 0, 0),), "numbers"),
        (np.ma.masked_array([0.0, 1.0], [0, 1]), ((0, 0, 0),) * 2, "finite"),
        ((0, 1j), ((0, 0, 0), (1, 0, 0)), "to be real numbers"),
    ],
)
def test_what_is_none_is_an_error(times: tuple, angles: tuple, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        Keyframes(times, angles)


@pytest.mark.parametrize(
    "text",
    [
        "0,10,20,30\n1.5,-1e1,0,0\n",
        "time,yaw,pitch,roll\n0,10,20,30\n1.5,-10,0,0",
        "\ufeff# of a drone\n\nRoll, Time, Yaw, Pitch\r\n30,0,10,20\r\n0, 1.5, -10, 0\r\n",
    ],
)
def test_files(text: str, tmp_path: Path) -> None:
    path = tmp_path / "turn.csv"
    path.write_text(text, encoding="utf-8")
    assert read_keyframes(path) == Keyframes((0, 1.5), ((10, 20, 30), (-10, 0, 0)))


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "no keyframes"),
        (b"time,yaw\n", "no keyframes"),
        (b"time,tilt\n0,1\n", "expected columns"),
        (b"yaw,pitch\n0,1\n", "expected columns"),
        (b"0,1,2,3\n1,2,3\n", "line 2"),
        (b"time,yaw\n0,1\n1,x\n", "line 3"),
        (b"0,0,0,0\n0,0,0,0\n", "rise"),
        (b"0,nan,0,0\n", "finite"),
        (b"\xff\xfe", "no text"),
    ],
)
def test_bad_files_are_named(data: bytes, says: str, tmp_path: Path) -> None:
    path = tmp_path / "turn.csv"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=rf"turn\.csv.*{says}"):
        read_keyframes(path)


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="none"):
        read_keyframes(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("seconds", "error", "says"),
    [
        ("a", TypeError, "`seconds` to be a number, got str"),
        (None, TypeError, "`seconds` to be a number, got NoneType"),
        (math.nan, ValueError, "`seconds` to be finite, got nan"),
        (-math.inf, ValueError, "`seconds` to be finite, got -inf"),
    ],
)
def test_a_time_is_a_finite_number(seconds, error, says: str) -> None:
    with pytest.raises(error, match=says):
        Keyframes((0, 1), ((0, 0, 0), (90, 0, 0)))(seconds)
