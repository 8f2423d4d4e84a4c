"""Views out of a panorama, and back into it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_array, as_image, keeps_dtype, spatial_shape
from .._scalars import as_number
from ..map.images import Several, images
from ..map.named import resolve
from .verbs import convert, sample

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["embed"]

# Options of lookups; and those that texels have and their shares, which are one number, have not.
_OF_SHARES = {"filter", "antialias", "world"}
_OF_TEXELS = {"skipna", "alpha"}


@keeps_dtype
def embed(
    view: ArrayLike,
    /,
    src: ProjectionLike,
    image: ArrayLike,
    dst: ProjectionLike,
    *,
    rotation: Any | None = None,
    mask: ArrayLike | None = None,
    feather: float = 0.0,
    out: NDArray[Any] | None = None,
    any_aspect: bool = False,
    channels_first: bool = False,
    **options: Any,
) -> NDArray[Any]:
    """Put a view, such as an edited crop, back into a panorama.

    Parameters
    ----------
    view : array_like, shape (H, W) or (H, W, C)
        The image to put in. With one more axis in front it is a batch, as for `convert`.
    src : Projection or str
        Its projection, as ``sm.projection("perspective", fov=90).turned(pose)``.
    image : array_like
        The image that it is put into, of any projection, with as many channels and the same
        dtype; or a batch. Of two batches each view is put into its own image; else each into the
        one, or the one into each.
    dst : Projection or str
        That image's projection.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the view in the world: what it shows at d goes to ``rotation @ d``. Of shape
        (N, 3, 3) as for `convert`.
    mask : array_like, shape (H, W), optional
        How much of each texel of the view counts: bool, numbers from 0 to 1, or uint8 from 0 to
        255.
    feather : float
        Over how many texels of the view, from its edge inward, it fades in. With 0 its edge is
        hard.
    out : ndarray, optional
        Where to put the result; it may be `image` itself.
    any_aspect, channels_first : bool
        As for `convert`, for both images.
    **options
        ``filter``, ``antialias``, ``skipna``, ``alpha`` and ``world``, by which `convert` looks the
        view up. What has no weight by ``skipna`` leaves the number of `image`.

    Returns
    -------
    image : ndarray, of the shape and dtype of `image`; a batch if there is one
        Texels that the view does not cover are those of `image`, to the bit.

    Raises
    ------
    ValueError
        For images whose shapes do not fit, a mask of another shape or with numbers outside 0 to 1,
        or a negative `feather`.
    TypeError
        For images of different dtypes, of labels, and for another option.

    Notes
    -----
    Each texel is ``(1 - w) image + w view``, w the mask times the fade, looked up like the view
    itself; it is rounded once. The fade is 3t² - 2t³ of the distance to the nearest edge. A view
    that has no edge (a whole sphere) does not fade. Where the view is finer than the panorama,
    `convert`'s own filtering keeps it from aliasing. The call needs one more image like `image`, in
    float.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> panorama = np.zeros((64, 128), np.uint8)
    >>> camera = sm.projection("perspective", fov=60).turned(sm.rotation(40, 10, 0))
    >>> crop = sm.convert(panorama, "latlong", camera, size=64)
    >>> crop[:] = 200
    >>> edited = sm.embed(crop, camera, panorama, "latlong", feather=4)
    >>> edited.max(), (edited > 0).mean().round(2)
    (np.uint8(200), np.float64(0.05))
    """
    known = _OF_SHARES | _OF_TEXELS
    for name in options.keys() - known:
        raise TypeError(
            f"`{name}` is no option of `embed`; it takes {', '.join(sorted(known))} of `convert`'s."
        )
    small, large = resolve(src), resolve(dst)
    views = images(
        view,
        small,
        any_aspect=any_aspect,
        channels_first=channels_first,
        rotation=rotation,
        name="view",
    )
    wholes = images(image, large, any_aspect=any_aspect, channels_first=channels_first)
    if views is not None or wholes is not None:
        views = views or Several(as_array(view, "view"), None, False, False, "view")
        if wholes is None or not wholes.is_batch:
            image = image if wholes is None else wholes.array
            return views.each(embed, locals())
        return views.repeated(wholes.count).each(embed, locals(), image=wholes.array)
    small = resolve(small, rotation=rotation)
    crop, whole = as_image(view, out, "view"), as_image(image, None)
    shape = spatial_shape(crop, small, "view")
    target = spatial_shape(whole, large, "image")
    channels = crop.shape[len(shape) :]
    if channels != whole.shape[len(target) :]:
        raise ValueError(
            f"Expected `view` and `image` to have the same channels, got shapes {crop.shape} and "
            f"{whole.shape}."
        )
    if crop.dtype != whole.dtype:
        raise TypeError(
            f"Expected `view` to have the dtype of `image`, {whole.dtype}, got {crop.dtype}."
        )
    feather = as_number(feather, "feather")
    if not feather >= 0 or not np.isfinite(feather):
        raise ValueError(
            f"Expected `feather` to be a number of texels of at least 0, got {feather}."
        )
    if out is None:
        out = np.array(whole)
    else:
        if not isinstance(out, np.ndarray) or out.dtype != whole.dtype:
            got = getattr(out, "dtype", type(out).__name__)
            raise TypeError(f"Expected `out` to have dtype {whole.dtype}, got {got}.")
        if out.shape != whole.shape:
            raise ValueError(f"Expected `out` to have shape {whole.shape}, got {out.shape}.")
        np.copyto(out, whole)
    # Filtering in float, so that the blend is what is rounded.
    exact = np.float64 if crop.dtype == np.float64 else np.float32

    def seen_from_there(texels: NDArray[Any], options: dict[str, Any]) -> NDArray[Any]:
        return convert(texels, small, large, size=target, fill=0.0, any_aspect=True, **options)

    shares = _fade(small, shape, feather) * mask_weights(mask, shape)
    weight = seen_from_there(shares, {k: v for k, v in options.items() if k in _OF_SHARES})
    value = seen_from_there(crop.astype(exact, copy=False), options)
    # Row by row, or face by face.
    for old, new, w in zip(out, value, weight, strict=True):
        seen = w > 0
        if not seen.any():
            continue
        share = np.minimum(w[seen], 1).astype(exact)
        share = share.reshape(share.shape + (1,) * len(channels))
        under = old[seen].astype(exact)
        # Two products and not a difference: whole weights give the view's own numbers.
        # No share of infinity is no number.
        with np.errstate(invalid="ignore"):
            blend = np.where(share == 1, new[seen], (1 - share) * under + share * new[seen])
        if options.get("skipna"):
            blend = np.where(np.isnan(new[seen]), under, blend)
        if old.dtype.kind == "u":
            blend = np.clip(np.floor(blend + 0.5), 0, np.iinfo(old.dtype).max)
        old[seen] = blend
    return out


def mask_weights(mask: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.float32]:
    if mask is None:
        return np.ones(shape, np.float32)
    array = as_array(mask, "mask")
    if array.shape != shape:
        raise ValueError(f"Expected `mask` to have shape {shape}, got {array.shape}.")
    if array.dtype == np.uint8:
        return array.astype(np.float32) / np.float32(255)
    if array.dtype.kind not in "bfiu":
        raise TypeError(f"Expected `mask` to be bool or real numbers, got dtype {array.dtype}.")
    if not np.all((array >= 0) & (array <= 1)):
        raise ValueError("Expected `mask` to have numbers from 0 to 1.")
    return array.astype(np.float32)


def unseen(fill: float | Sequence[float], dtype: np.dtype[Any], channels: int) -> NDArray[Any]:
    """Return what a lookup has that sees nothing, shape (channels,), or raise for no such fill."""
    nowhere = np.full(3, np.nan)
    return sample(np.zeros((1, 2, channels), dtype), nowhere, "latlong", fill=fill)


def _fade(p: Projection, shape: tuple[int, ...], feather: float) -> NDArray[np.float32]:
    """Return how much each texel of a view counts: less within `feather` texels of its edge."""
    if feather == 0 or p.faces > 1 or p.seam not in ("ends", "periodic"):
        return np.ones(shape, np.float32)
    height, width = shape[-2:]
    v = (np.arange(height, dtype=np.float32) + np.float32(0.5))[:, None]
    u = np.arange(width, dtype=np.float32) + np.float32(0.5)
    distance = np.minimum(v, height - v) + 0 * u
    if p.seam == "ends":
        distance = np.minimum(distance, np.minimum(u, width - u))
        if not p.valid([0.0, 0.0]):
            # A disk: the rim is nearer than the sides of the square.
            radius = np.hypot(2 * u / width - 1, 2 * v / height - 1)
            distance = (1 - radius) * min(height, width) / 2
    t = np.clip(distance / np.float32(feather), 0, 1)
    fade: NDArray[np.float32] = (t * t * (3 - 2 * t)).astype(np.float32)
    return fade
