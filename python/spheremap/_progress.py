"""How far a call is, for those who want to be told: the command line.

The core tells how much of one of its calls is done. What takes several, or loops in Python, says
which part of the whole each is. Nothing is counted while nobody listens, nor on other threads than
the one that listens: those that share a work are waited for, and counted, there.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from . import _core

T = TypeVar("T")


class _Listener(threading.local):
    """Who listens on this thread, and which part of the whole is in hand."""

    tell: Callable[[float], None] | None = None
    first = 0.0
    last = 1.0


_listener = _Listener()


@contextmanager
def told(tell: Callable[[float], None]) -> Iterator[None]:
    """Call `tell` now and then with how much of what is done in here is done, from 0 to 1."""
    _listener.tell, _listener.first, _listener.last = tell, 0.0, 1.0
    _core.tell_progress(done)
    tell(0.0)
    try:
        yield
    finally:
        _core.tell_progress(None)
        _listener.tell = None


def done(fraction: float) -> None:
    """Say how much of the part in hand is done."""
    if _listener.tell is not None:
        _listener.tell(_listener.first + (_listener.last - _listener.first) * fraction)


@contextmanager
def part(first: float, last: float) -> Iterator[None]:
    """Do a part of the work in hand, which as a whole goes from 0 to 1."""
    if _listener.tell is None:
        yield
        return
    whole = _listener.first, _listener.last
    start, length = whole[0], whole[1] - whole[0]
    _listener.first, _listener.last = start + first * length, start + last * length
    done(0)
    try:
        yield
    finally:
        _listener.first, _listener.last = whole


def counted(items: Sequence[T], count: int | None = None) -> Iterator[T]:
    """Yield items, each of which is as large a part of the work in hand; `count` are expected."""
    count = count or len(items)
    for k, item in enumerate(items):
        with part(k / count, (k + 1) / count):
            yield item
