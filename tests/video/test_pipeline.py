"""The three works of a video: in order, at the same time, and ended by any of them."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from spheremap.video.pipeline import overlap


def test_all_in_order() -> None:
    taken: list[int] = []
    overlap(range(100), lambda x: 2 * x, taken.append)
    assert taken == list(range(0, 200, 2))


def test_they_overlap() -> None:
    """Each waits for the two others, who are at other items."""
    together = threading.Barrier(3)

    def items() -> Iterator[int]:
        for k in range(6):
            if k >= 2:
                together.wait()
            yield k

    def work(k: int) -> int:
        if 1 <= k < 5:
            together.wait()
        return k

    taken: list[int] = []

    def take(k: int) -> None:
        if k < 4:
            together.wait()
        taken.append(k)

    overlap(items(), work, take)
    assert taken == list(range(6))


class Made:
    """Numbers without end, and how many were asked for."""

    count = 0

    def __iter__(self) -> Iterator[int]:
        while True:
            self.count += 1
            yield self.count


def fail(k: int) -> int:
    if k == 10:
        raise ValueError("ten")
    return k


def test_an_error_ends_all() -> None:
    for work, take in ((fail, lambda k: None), (lambda k: k, fail)):
        made = Made()
        with pytest.raises(ValueError, match="ten"):
            overlap(made, work, take)  # type: ignore[arg-type]
        # Those on the way, and one in the hands of each.
        assert made.count <= 10 + 2 * 3 + 3
    taken: list[int] = []
    with pytest.raises(ValueError, match="ten"):
        overlap(map(fail, range(1, 20)), lambda k: k, taken.append)
    assert taken == list(range(1, len(taken) + 1))
    assert threading.active_count() < 10


def test_ctrl_c_takes_what_was_worked_on() -> None:
    taken: list[int] = []

    def work(k: int) -> int:
        if k == 10:
            raise KeyboardInterrupt
        return k

    with pytest.raises(KeyboardInterrupt):
        overlap(Made(), work, taken.append)
    assert taken == list(range(1, 10))
