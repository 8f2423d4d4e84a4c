"""Lookups in pictures that map no sphere."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from .. import _core
from .._arrays import keeps_dtype
from .._scalars import as_items, as_text
from ..map.images import images, is_chain
from .labels import labeled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._names import SampleFilter

    Address: TypeAlias = Literal["clamp", "wrap", "mirror", "border"]

__all__ = ["sample_uv"]


@keeps_dtype
def sample_uv(
    image: ArrayLike,
    uv: ArrayLike,
    /,
    *,
    filter: SampleFilter | str | None = None,
    address: Address | tuple[Address, Address] = "clamp",
    fill: float | Sequence[float] = 0.0,
    lod: ArrayLike | None = None,
    derivatives: tuple[ArrayLike, ArrayLike] | None = None,
    out: NDArray[Any] | None = None,
    channels_first: bool = False,
) -> NDArray[Any]:
    """Look (u, v) up in a picture, as a sampler of a graphics API does.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C)
        Of dtype uint8, uint16, float16, float32 or float64; with the filter ``"nearest"``, of any
        integers or bool. It need not map a sphere. With one more axis in front it is a batch, as
        for `convert`; the same places are looked up in each.
    uv : array_like, shape (..., 2)
        u runs to the right and v down, each from 0 to 1: the centers of n texels lie at (i + ½)/n.
    filter : str, optional
        As for `sample`: ``"bilinear"``, or ``"trilinear"`` with `lod` or `derivatives`.
    address : str or pair of str
        What lies beyond the edges, or beyond those of u and of v: ``"clamp"``, the texel at the
        edge; ``"wrap"``, the picture again; ``"mirror"``, the picture mirrored; ``"border"``, a
        texel of `fill`.
    fill : float or sequence of float
        The color of the border, and the value where a (u, v), level or derivative is NaN or a
        (u, v) infinite.
    lod : array_like, shape (...), optional
        The level of detail of each lookup, as for `sample`.
    derivatives : pair of array_like, shape (..., 2), optional
        How (u, v) changes to the next pixel of your picture, to the right and down; as for
        `sample`.
    out : ndarray, optional
        Where to put the result.
    channels_first : bool
        As for `sample`.

    Returns
    -------
    values : ndarray, shape (...) or (..., C), or (N, ..., C) of a batch, of the image's dtype

    Raises
    ------
    ValueError, TypeError
        For arrays of unfit shapes or dtypes, unknown names, both `lod` and `derivatives`, or one of
        them with a filter that knows no levels.

    Notes
    -----
    The rules are those of Direct3D [1]_ and OpenGL [2]_, in double precision and rounded once;
    hardware has 8 bits for the place between two texels and for that between two levels. OpenGL
    uploads the lowest row of a picture first: its v is 1 - v here.

    Each level is half as wide and high as the one before, rounded down and at least 1, the last
    one texel; its texels are means of what they cover. For an image that maps a sphere, `sample`
    knows what lies beyond its edges, and makes levels that keep the light.

    References
    ----------
    .. [1] Direct3D 11.3 Functional Specification, 7.18, Texture Sampling.
    .. [2] The OpenGL Graphics System, Version 4.6, 8.14, Texture Minification.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> row = np.array([[0.0, 10.0, 20.0, 30.0]])
    >>> u = np.array([0.125, 0.25, 1.0])
    >>> uv = np.stack([u, np.full(3, 0.5)], axis=-1)
    >>> sm.sample_uv(row, uv).tolist()
    [0.0, 5.0, 30.0]
    >>> sm.sample_uv(row, uv, address="wrap").tolist()
    [0.0, 5.0, 15.0]
    >>> sm.sample_uv(row, uv, lod=[0, 1, 7]).tolist()
    [0.0, 5.0, 15.0]
    """
    one = isinstance(address, str)
    modes = (address, address) if one else as_items(address, "address", "modes")
    along = tuple(as_text(mode, "address") for mode in modes)
    if len(along) != 2:
        raise ValueError(f"Expected `address` to be one mode or a pair, got {address!r}.")

    if is_chain(image):
        raise TypeError("Expected `image` to be one picture: `sample_uv` makes its levels.")
    several = images(image, None, any_aspect=True, channels_first=channels_first)
    if several is not None:
        return several.each(sample_uv, locals(), "values")

    def looked_up(image: Any, fill: Any, out: Any) -> NDArray[Any]:
        return _core.sample_uv(
            image,
            uv,
            filter=filter,
            address=along,
            fill=fill,
            lod=lod,
            derivatives=derivatives,
            out=out,
        )

    if lod is None and derivatives is None:
        found = labeled(image, 2, filter, fill, out, None, looked_up)
        if found is not None:
            return found
    return looked_up(image, fill, out)
