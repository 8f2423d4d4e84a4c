"""Views of a rig as one panorama."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np

from .._arrays import as_doubles
from .._progress import part
from .._scalars import as_flag, as_text
from ..map.images import target_shape
from ..map.named import resolve
from ..map.size import matching_size
from ..resample import convert
from ..resample.views import unseen
from .bands import banded
from .exposure import coded, expect_curve, gains_of
from .mixing import by_rows, divided, mixed
from .pictures import exact, pictures_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Size
    from ..map.named import ProjectionLike, Worlds
    from ..resample.windows import Window
    from .exposure import Curve
    from .pictures import Cameras, Picture

    Blend: TypeAlias = Literal["feather", "bands", "nearest"]

__all__ = ["stitch"]


@overload
def stitch(
    images: Sequence[ArrayLike] | NDArray[Any],
    cameras: Cameras,
    /,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    blend: Blend = "feather",
    exposure: Literal["match"] | ArrayLike | None = None,
    curve: Curve = "srgb",
    masks: Sequence[ArrayLike | None] | None = None,
    fov: float | Sequence[float] | None = None,
    rotation: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    world: Worlds = "match",
    any_aspect: bool = False,
    return_weight: Literal[False] = False,
) -> NDArray[Any]: ...
@overload
def stitch(
    images: Sequence[ArrayLike] | NDArray[Any],
    cameras: Cameras,
    /,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    blend: Blend = "feather",
    exposure: Literal["match"] | ArrayLike | None = None,
    curve: Curve = "srgb",
    masks: Sequence[ArrayLike | None] | None = None,
    fov: float | Sequence[float] | None = None,
    rotation: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    world: Worlds = "match",
    any_aspect: bool = False,
    return_weight: Literal[True],
) -> tuple[NDArray[Any], NDArray[np.float32]]: ...
def stitch(
    images: Sequence[ArrayLike] | NDArray[Any],
    cameras: Cameras,
    /,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    blend: Blend = "feather",
    exposure: Literal["match"] | ArrayLike | None = None,
    curve: Curve = "srgb",
    masks: Sequence[ArrayLike | None] | None = None,
    fov: float | Sequence[float] | None = None,
    rotation: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    world: Worlds = "match",
    any_aspect: bool = False,
    return_weight: bool = False,
) -> NDArray[Any] | tuple[NDArray[Any], NDArray[np.float32]]:
    """Return one panorama of several views, such as both pictures of a 360 camera.

    Parameters
    ----------
    images : sequence of array_like, shape (H, W) or (H, W, C)
        A picture of each camera, of any sizes, one dtype and as many channels: uint8, uint16,
        float16, float32 or float64. One array (H, n·W, C) is n pictures side by side. A pixel of
        floats that is not finite is not seen.
    cameras : Rig or sequence of View, Projection or str
        Where they look: a `rig`, what `read` gives, `back_to_back`, or projections with their
        poses. A ``"dual_fisheye(fov=200)"`` alone is both lenses of a raw picture, side by side,
        or in its layout and as its program has them. Positions do not count: everything is far
        away.
    dst : Projection or str
        The projection of the result.
    size : int or tuple of int, optional
        As for `spheremap.convert`. By default the largest that it would choose for a view.
    blend : {"feather", "bands", "nearest"}
        Views are mixed by their weights, or the one with the largest is taken; "bands" takes that
        one, too, and mixes around its border what is coarse over many pixels and what is fine over
        few: detail that does not quite fit stays sharp.
    exposure : "match", array_like of shape (n,), or None
        Whether each picture's light is multiplied by its `gains`, or by these numbers.
    curve : {"srgb", "linear"}
        What integers are, where there are gains. Floats are light as they are.
    masks : sequence of array_like of bool, shape (H, W), or None, optional
        True for the pixels of each picture that count.
    fov : float or sequence of float, optional
        How wide the lens sees, in degrees across: what is farther from the camera's axis does not
        count. For calibrations, which say nothing of the dark around a fisheye.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the cameras' world, to level a horizon.
    fill : float or sequence of float
        The value for what no view sees, or one for each channel. Black by default; NaN marks what
        is missing in an image of floats.
    world, any_aspect
        As for `spheremap.convert`.
    return_weight : bool
        Whether to return the weights' sum as well.

    Returns
    -------
    image : ndarray
        Of the pictures' dtype and channels, `fill` where no view sees.
    weight : ndarray of float32, shape of the image without channels
        With `return_weight`: 0 where no view sees.

    Raises
    ------
    ValueError, TypeError
        For another number of pictures than of cameras, pictures of unfit or different shapes or
        dtypes, cameras of several faces, and as `spheremap.convert`.

    See Also
    --------
    gains : What ``exposure="match"`` multiplies by.
    masks : Of nearest cameras, and of the photographer.

    Notes
    -----
    A pixel's weight is how many there are in a steradian, times the square of its angle to where
    the view ends: the picture's edge, the lens's rim, `fov`, a mask. That is the square of its
    distance to the end in pixels, `weight` in units of 1024. So no seam shows: weights begin at 0,
    with slope 0. Weighted pixels and weights go through `convert`, antialiased, and are divided at
    the end. As there, values are mixed as they are: decode colors for exact light.

    Bands are those of Burt and Adelson [1]_, five and what is left, in the panorama's `mipmaps`.

    Memory: the result, and all pictures in float32 with one channel more; or, where that is less,
    two images of the result's size so and the largest picture; with "bands" seven of them.

    References
    ----------
    .. [1] Burt, P. J. and Adelson, E. H., A Multiresolution Spline with Application to Image
       Mosaics, ACM Transactions on Graphics 2(4), 1983.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> rig = sm.cameras.rig(64, n=8)
    >>> height = sm.directions("latlong", 64)[..., 1]
    >>> views = rig.convert(height, "latlong")
    >>> panorama = sm.cameras.stitch(views, rig, "latlong", size=64)
    >>> bool(np.abs(panorama - height).max() < 0.01)
    True

    The raw picture of a 360 camera, whose lenses see 200 degrees each:

    >>> raw = np.full((64, 128, 3), 200, np.uint8)
    >>> panorama = sm.cameras.stitch(raw, "dual_fisheye(fov=200)", "latlong", size=32)
    >>> panorama.shape, panorama.min()
    ((32, 64, 3), np.uint8(200))
    """
    target = resolve(dst)
    if as_text(blend, "blend") not in ("feather", "bands", "nearest"):
        raise ValueError(f"Expected `blend` to be 'feather', 'bands' or 'nearest', got {blend!r}.")
    with_weight = as_flag(return_weight, "return_weight")
    curve_of = expect_curve(curve)
    shape = None if size is None else target_shape(target, size, any_aspect)
    with part(0, 0.1):
        pictures, is_gray = pictures_of(images, cameras, masks, fov, any_aspect)
    with part(0.1, 0.3):
        factors = _factors(exposure, pictures, curve_of)
    if shape is None:
        sizes = [matching_size(p.pixels.shape, p.camera, target) for p in pictures]
        shape = target_shape(target, max(sizes), any_aspect)
    first = pictures[0].pixels
    channels = first.shape[-1]
    nothing = unseen(fill, first.dtype, channels)
    parts = blend != "bands" and by_rows([p.pixels.shape[:2] for p in pictures], shape)
    # What is not held is written over by the next one.
    held: dict[int, NDArray[Any]] = {}

    def weighted(k: int, into: NDArray[Any] | None) -> NDArray[Any]:
        return pictures[k].weighted(_values(first.dtype, curve_of, factors[k]), into)

    def layer(k: int, into: NDArray[Any], window: Window | None = None) -> NDArray[Any]:
        if k not in held:
            before = None if parts or not held else held.popitem()[1]
            held[k] = weighted(k, before)
        return convert(
            held[k],
            pictures[k].camera,
            target,
            size=shape,
            rotation=rotation,
            world=world,
            any_aspect=True,
            out=into,
            window=window,
        )

    with part(0.3, 0.95):
        if blend == "bands":
            # With one more channel, the weight.
            total: NDArray[Any] = np.empty((*shape, channels + 1), exact(first.dtype))
            banded(target, total, len(pictures), layer)
            held.clear()
            image = divided(total, nothing)
            weight: NDArray[np.float32] | None = total[..., -1].astype(np.float32)
        else:
            image, weight = mixed(
                shape,
                nothing,
                len(pictures),
                layer,
                nearest=blend == "nearest",
                parts=parts,
                with_weight=with_weight,
            )
    if is_gray:
        image = image[..., 0]
    return (image, weight) if weight is not None and with_weight else image


def _factors(exposure: Any, pictures: list[Picture], curve: str) -> NDArray[np.float64]:
    """Return by what each picture's light is multiplied."""
    if exposure is None:
        return np.ones(len(pictures))
    if isinstance(exposure, str):
        if exposure != "match":
            raise ValueError(f"Expected `exposure` to be 'match' or gains, got {exposure!r}.")
        return gains_of(pictures, curve)
    found = as_doubles(exposure, "exposure")
    if found.shape != (len(pictures),):
        raise ValueError(
            f"Expected `exposure` to have shape ({len(pictures)},), one gain a picture, "
            f"got {found.shape}."
        )
    if not (np.isfinite(found).all() and (found > 0).all()):
        raise ValueError("Expected the gains in `exposure` to be positive and finite.")
    return found


def _values(dtype: np.dtype[Any], curve: str, gain: float) -> NDArray[np.float32] | float:
    """Return what pixels are multiplied by, or what each integer stands for."""
    if gain == 1:
        return 1.0
    return coded(dtype, curve, gain) if dtype.kind == "u" else float(gain)
