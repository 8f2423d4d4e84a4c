"""A border of the right texels around each face, for convolutions that know nothing of spheres."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _core
from .._arrays import keeps_dtype, spatial_axes
from .._scalars import as_whole
from ..map.images import images
from ..map.named import resolve
from .labels import labeled

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._names import Filter
    from ..map.named import ProjectionLike

__all__ = ["pad"]

# Texels of a border that no image has room for anyway.
_WIDEST = (1 << 31) - 1


@keeps_dtype
def pad(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    n: int,
    *,
    filter: Filter | str = "bilinear",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[Any]:
    """Put a border of `n` texels around each face that continues the image over its seams.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Of dtype uint8, uint16, float16, float32 or float64; with the filter ``"nearest"``, of any
        integers or bool. Faces that lie in one image (a strip, a
        cross) are taken apart first. With one more axis in front it is a batch, as for `convert`.
    projection : Projection or str
        The projection of the image.
    n : int
        How wide the border is, in texels, at least 0. It may be wider than the image.
    filter : str
        How texels between others are looked up, as for `sample`, where the border is no
        permutation of the image.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    padded : ndarray, shape (H + 2n, W + 2n), (F, N + 2n, N + 2n), or either with channels
        Of the image's dtype; the texels inside the border are the image's own.

    Raises
    ------
    ValueError
        For a negative `n`, an unknown name, or an image of an unfit shape.
    TypeError
        For an `n` that is no integer, or an image of an unfit dtype.

    Notes
    -----
    What a border holds is the rule of the projection's `seam`:

    - ``latlong``: the other end of the row; beyond a pole the same row, half a turn around.
    - ``octahedral``: each edge continues at itself, mirrored about its middle.
    - ``periodic``: the other end of the row; the first and last row are repeated.
    - ``faces``, ``rim-other-face``: what lies in the direction that the face's own formula gives
      beyond its edge. A cube's border texel is what the face would show if its picture were
      larger; texels of neighbors do not lie there, so it is looked up.
    - ``rim-opposite``: across the rim of the disk, the other side of it.
    - ``rim-other-face-flipped``: across the rim of a disk, the other one, left and right exchanged.
    - ``rim-mirrored``: across the rim, where it is as high on the other side.
    - ``cuts``: across an edge of the net, the edge that it was cut from.
    - ``ends``: nothing lies there, so the texels at the edge (or the rim of the disk) are repeated.

    The first three are exact permutations of texels (on a latlong with an odd number of columns,
    half a turn falls between two, and their mean is taken). Around a disk the whole border is
    filled, and the corners of the image itself stay what they are.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> image = np.arange(8.0).reshape(2, 4)
    >>> sm.pad(image, "latlong", 1)[1].tolist()
    [3.0, 0.0, 1.0, 2.0, 3.0, 0.0]
    >>> sm.pad(image, "latlong", 1)[0].tolist()
    [1.0, 2.0, 3.0, 0.0, 1.0, 2.0]
    >>> sm.pad(np.zeros((6, 16, 16, 3), np.uint8), "cube", 2).shape
    (6, 20, 20, 3)
    """
    resolved = resolve(projection)
    n = as_whole(n, "n")
    if not 0 <= n <= _WIDEST:
        raise ValueError(f"Expected a border of 0 to {_WIDEST} texels, got {n}.")
    several = images(image, resolved, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        return several.each(pad, locals())

    def padded(image: Any, *_: Any) -> NDArray[Any]:
        return _core.pad(image, resolved, n, filter)

    found = labeled(image, spatial_axes(resolved), filter, 0, None, None, padded)
    return padded(image) if found is None else found
