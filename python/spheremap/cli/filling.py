"""How much of an array is written, seen by looking at it while the core is at work.

The core converts an image in one call that tells nothing on its way, but it writes the texels of
`out` one after the other. A thousand of them get marks before; those without theirs are done.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

import numpy as np

from spheremap.cli.steps import Step

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MARKS = 1000
# Seconds between two looks.
_EVERY = 0.1


@contextmanager
def watched(out: NDArray[Any], step: Step) -> Iterator[None]:
    """Show every now and then which fraction of a contiguous array of texels has been written."""
    if not step.is_shown:
        yield
        return
    texels = out.reshape(-1, out.shape[-1]).view(np.uint8)
    places = np.linspace(0, len(texels) - 1, min(len(texels), _MARKS)).astype(np.intp)
    # At random, so that no image is made of them.
    marks = np.random.default_rng(0).integers(0, 256, (len(places), texels.shape[1]), np.uint8)
    texels[places] = marks
    over = Event()

    def look() -> None:
        while not over.wait(_EVERY):
            step.part(float((texels[places] != marks).any(axis=1).mean()))

    watcher = Thread(target=look, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()
