"""Three works on the same items that overlap: one makes them, one changes them, one takes them.

The works on both sides release the interpreter's lock most of the time (PyAV decodes and encodes
without it), and so does the one between them. Channels between two works are bounded: of a video a
few frames are in memory, whichever work is the slowest.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Generic, TypeVar

__all__ = ["overlap"]

T = TypeVar("T")
U = TypeVar("U")

# How many items wait between two works: enough that one may be late once, and no more, for a frame
# of 8192×4096 takes 50 MB.
DEPTH = 3


class Channel(Generic[T]):
    """Items on the way from one thread to another, a few at most."""

    def __init__(self, depth: int) -> None:
        self._items: deque[T] = deque()
        self._depth = depth
        self._changed = threading.Condition()
        # Nothing more will be put; nothing more will be taken.
        self._ended = self._left = False
        self._error: BaseException | None = None

    def put(self, item: T) -> bool:
        """Wait until there is room; tell whether anybody is still there to take it."""
        with self._changed:
            while len(self._items) >= self._depth and not self._left:
                self._changed.wait()
            if not self._left:
                self._items.append(item)
                self._changed.notify_all()
            return not self._left

    def end(self, error: BaseException | None = None) -> None:
        """Say that nothing more comes, and why."""
        with self._changed:
            self._ended, self._error = True, error
            self._changed.notify_all()

    def leave(self) -> None:
        """Say that nothing more is taken."""
        with self._changed:
            self._left = True
            self._items.clear()
            self._changed.notify_all()

    def __iter__(self) -> Iterator[T]:
        while True:
            with self._changed:
                while not self._items and not self._ended:
                    self._changed.wait()
                if not self._items:
                    if self._error is not None:
                        raise self._error
                    return
                item = self._items.popleft()
                self._changed.notify_all()
            yield item


def overlap(
    items: Iterable[T], work: Callable[[T], U], take: Callable[[U], None], depth: int = DEPTH
) -> None:
    """Give `work` of each item to `take`, in order: the three run at the same time.

    `items` is iterated and `take` called in threads of their own, `work` in this one. After an
    error in one of them the others stop, and it is raised. After Ctrl-C no further item is made,
    and what was worked on is taken before the KeyboardInterrupt goes on.
    """
    made: Channel[T] = Channel(depth)
    done: Channel[U] = Channel(depth)
    failed: list[BaseException] = []

    def make() -> None:
        error = None
        try:
            for item in items:
                if not made.put(item):
                    break
        except BaseException as caught:
            error = caught
        made.end(error)

    def drain() -> None:
        try:
            for item in done:
                take(item)
        except BaseException as caught:
            failed.append(caught)
            done.leave()

    threads = [threading.Thread(target=make), threading.Thread(target=drain)]
    for thread in threads:
        thread.start()
    try:
        for item in made:
            if not done.put(work(item)):
                break
    except KeyboardInterrupt:
        raise
    except BaseException:
        done.leave()
        raise
    finally:
        made.leave()
        done.end()
        try:
            _wait(threads)
        except KeyboardInterrupt:
            # A second Ctrl-C: what waits is not taken, but nobody is at it when this returns.
            done.leave()
            _wait(threads)
            raise
    if failed:
        raise failed[0]


def _wait(threads: list[threading.Thread]) -> None:
    for thread in threads:
        thread.join()
