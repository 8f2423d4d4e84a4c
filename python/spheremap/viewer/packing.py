"""Words of a picture as text: differences, by planes, deflated."""

from __future__ import annotations

import base64
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from .._threads import on_all_threads

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["packed"]


def packed(array: NDArray[Any]) -> str:
    """Return words (..., C) of 8 or 16 bits: each channel's low bytes, then its high bytes.

    They are differences to the word before: of smooth images these are small, and high bytes mostly
    0. Planes are deflated apart, by all threads, and make one stream, without a header.
    """
    words = array.reshape(-1, array.shape[-1])
    wide, channels = array.dtype == np.uint16, words.shape[1]
    planes = channels * (2 if wide else 1)
    parts = [b""] * planes

    def work(place: int) -> None:
        own = np.ascontiguousarray(words[:, place % channels])
        steps = own.copy()
        steps[1:] -= own[:-1]
        if wide:
            # The bytes of a word, the low one first.
            steps = steps.astype("<u2", copy=False).view(np.uint8)[place // channels :: 2]
        # The fastest level: the others gain a few percent.
        stream = zlib.compressobj(1, wbits=-15)
        end = zlib.Z_FINISH if place == planes - 1 else zlib.Z_SYNC_FLUSH
        parts[place] = stream.compress(steps.tobytes()) + stream.flush(end)

    # Low bytes first, which take longer than high ones.
    on_all_threads(work, range(planes))
    return base64.b64encode(b"".join(parts)).decode("ascii")
