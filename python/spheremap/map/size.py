"""How large an image must be to hold as much as another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import _core

if TYPE_CHECKING:
    from .._projection import Projection


def matching_size(image_shape: tuple[int, ...], src: Projection, dst: Projection) -> int:
    """Return the size at which `dst` has about as many texels a steradian as an image of `src`.

    Channels in the shape do not count.
    """
    return _core.matching_size(image_shape[: 2 if src.faces == 1 else 3], src, dst)
