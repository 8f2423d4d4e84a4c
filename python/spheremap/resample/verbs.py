"""One image into another, lookups in an image, and its smaller versions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, overload

import numpy as np

from .. import _core
from .._arrays import IMAGE_DTYPES, keeps_dtype, spatial_axes
from .._scalars import as_flag, as_text, as_whole
from ..map.images import images, is_chain, target_shape
from ..map.named import resolve
from ..map.size import matching_size
from .labels import labeled
from .windows import stored_part

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Scalar, Size
    from .._names import ConvertFilter, SampleFilter
    from ..map.named import ProjectionLike, Worlds
    from .windows import Window

__all__ = ["convert", "mipmaps", "sample"]

_TEXELS = frozenset(map(np.dtype, IMAGE_DTYPES))


@keeps_dtype
def sample(
    image: ArrayLike,
    directions: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    filter: SampleFilter | str | None = None,
    axes: str | None = None,
    rotation: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    out: NDArray[Any] | None = None,
    alpha: int | None = None,
    skipna: bool = False,
    lod: ArrayLike | None = None,
    derivatives: tuple[ArrayLike, ArrayLike] | None = None,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[Any]:
    """Look directions up in an image.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Of dtype uint8, uint16, float16, float32 or float64; with the filter ``"nearest"``, of any
        integers or bool. For `lod` and `derivatives` it may be a list of levels, as from `mipmaps`
        or `light.prefilter_chain`; others are made. With one more axis in front it is a batch, as
        for `convert`; the same directions are looked up in each.
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection, axes, rotation
        As for `encode`: how the image maps the sphere.
    filter : str, optional
        ``"bilinear"``, the default, ``"nearest"``, ``"catmull-rom"`` (also called ``"bicubic"``),
        which interpolates, ``"mitchell"``, which is softer and rings less [1]_, ... With `lod` or
        `derivatives` ``"trilinear"``, the default there, or ``"ewa"``. The documentation's
        table has all. All know what lies beyond an edge: seams do not show. The exception are seams
        along a curved rim (``mollweide``, ``hammer``, ``sinusoidal``), where texels of the one side
        do not lie beside those of the other: the two sides differ by what lies a texel or two away.
    fill : float or sequence of float
        The value for directions that the image does not hold, or one for each channel. Black by
        default; NaN marks what is missing in an image of floats.
    out : ndarray, optional
        Where to put the result.
    alpha : int, optional
        The number of the channel, -1 for the last, that says how opaque a texel is. The others are
        then means by opacity: colors of transparent texels do not bleed. They are straight (not
        premultiplied) before and after; where nothing is opaque they are 0.
    skipna : bool
        Whether NaN and infinite values have no weight. By default they spread to every
        value that they touch.
    lod : array_like, shape (...), optional
        The level of detail of each lookup, broadcast against `directions`: 0 is the image, k level
        k of its `mipmaps`, 1.25 three parts of level 1 and one of level 2. Below 0 it is 0, and
        beyond the last level that one. Where it is NaN, the result is `fill`.
    derivatives : pair of array_like, shape (..., 3), optional
        How the direction changes to the next pixel of your picture, to the right and down: then
        the level follows from what the pixel sees. Of the units of `directions`, whose length does
        not matter. Where one is NaN, the result is `fill`; where one is infinite, the last level.
    any_aspect : bool
        As for `convert`: whether an image of another aspect is taken as it is.
    channels_first : bool
        Whether channels lie right before the rows of `image`, and first in the result: (C, ...).

    Returns
    -------
    values : ndarray, shape (...) or (..., C), of the image's dtype
        Of a batch, or with `rotation` of shape (N, 3, 3), (N, ...) or (N, ..., C).

    Raises
    ------
    ValueError, TypeError
        As for `encode`, and for an image of an unfit shape or dtype; for both `lod` and
        `derivatives`, or one of them with a filter that knows no levels; for levels without either,
        or with `alpha` or `skipna`.

    Notes
    -----
    Levels go by the rules of graphics APIs [2]_ [3]_. By the projection's Jacobian, `derivatives`
    become the two sides of a pixel in texels of the image; the longer one's length ρ gives the
    level log₂ ρ, and between two levels the mix is linear in it (`convert` mixes linearly in ρ).
    ``"ewa"`` goes by the shorter axis of the pixel's ellipse, of at least a 16th of the longer one,
    and averages over the ellipse in both levels. Where the map is singular, at a pole of a latlong,
    ρ is infinite. Each call makes the levels of the image once, as `mipmaps` does, but without
    rounding them to its dtype: one call of many lookups is faster than many calls.

    An image that is not C-contiguous (``rgba[..., :3]``, ``image[::-1]``, Fortran order) or not of
    native byte order is copied for the call. It is the one array that costs memory beside itself
    and the result.

    References
    ----------
    .. [1] Mitchell, D. P. and Netravali, A. N., Reconstruction Filters in Computer Graphics,
       SIGGRAPH 1988.
    .. [2] Direct3D 11.3 Functional Specification, 7.18.11, Texture Mipmap Selection.
    .. [3] The OpenGL Graphics System, Version 4.6, 8.14, Texture Minification.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> height = sm.directions("latlong", 64)[..., 1]
    >>> np.round(sm.sample(height, [[0, 1, 1], [0, -1, 1]], "latlong"), 2).tolist()
    [0.71, -0.71]

    Stripes of one texel, from level to level:

    >>> stripes = np.tile([0.0, 1.0], (64, 64))
    >>> d = sm.directions("latlong", 64)[32, 1]
    >>> sm.sample(stripes, d, "latlong", lod=[0, 0.5, 1]).tolist()
    [1.0, 0.75, 0.5]

    A rough mirror's reflections, for a roughness at each place:

    >>> chain = sm.light.prefilter_chain(height, "latlong", "cube", size=8, levels=4, samples=64)
    >>> roughness = np.array([0.0, 0.3, 0.9])
    >>> sm.sample(chain, [0, 1, 0], "cube", lod=roughness * 3).round(1).tolist()
    [1.0, 0.9, 0.4]
    """
    p = resolve(projection)
    several = images(
        image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(sample, locals(), "values")
    p = resolve(p, axes, rotation)
    if filter is not None:
        filter = as_text(filter, "filter")
    if alpha is not None:
        alpha = as_whole(alpha, "alpha")
    skipna = as_flag(skipna, "skipna")

    def looked_up(image: Any, fill: Any, out: Any) -> NDArray[Any]:
        return _core.Projection.sample(
            p,
            image,
            directions,
            filter=filter,
            fill=fill,
            out=out,
            alpha=alpha,
            skipna=skipna,
            lod=lod,
            derivatives=derivatives,
        )

    if lod is None and derivatives is None and not _has_texels(image):
        found = labeled(image, spatial_axes(p), filter, fill, out, alpha, looked_up)
        if found is not None:
            return found
    return looked_up(image, fill, out)


@keeps_dtype
def convert(
    image: ArrayLike,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    rotation: Any | None = None,
    filter: ConvertFilter | str = "bilinear",
    fill: float | Sequence[float] = 0.0,
    out: NDArray[Any] | None = None,
    skipna: bool = False,
    antialias: bool = True,
    alpha: int | None = None,
    world: Worlds = "match",
    any_aspect: bool = False,
    channels_first: bool = False,
    window: Window | None = None,
) -> NDArray[Any]:
    """Turn an image from one projection into another.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Of dtype uint8, uint16, float16, float32 or float64; with the filters ``"nearest"`` and
        ``"mode"``, of any integers or bool. With one more axis in front it is a batch:
        (N, H, W, C) or (N, F, S, S, C), whose channels are spelled out, with C = 1 for gray.
    src, dst : Projection or str
        The projection of `image`, and that of the result.
    size : int or tuple of int, optional
        As for `solid_angle`. By default the size that holds about as many texels per covered
        steradian as the source.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the world of `src`: what is at d goes to ``rotation @ d``. For the
        view of a camera, see `Projection.turned`. Of shape (N, 3, 3) there is one for each image of
        a batch, or N results of one image.
    filter : str
        Those of `sample` look texels up, and are averaged where `antialias` says so.
        ``"area"`` is conservative: each texel is the mean of the source over its own solid angle,
        so that no light is lost or made. ``"mode"`` is the value that covers most of it, for
        labels. ``"trilinear"`` and ``"ewa"`` look up in `mipmaps`, as renderers do.
    fill : float or sequence of float
        The value where the result has no sphere, or the source does not hold the direction; or one
        for each channel.
    out : ndarray, optional
        Where to put the result.
    skipna : bool
        Whether NaN and infinite values have no weight. By default they spread to every
        texel that they touch.
    antialias : bool
        Whether a texel that sees more than one texel of the source is the mean of what it sees,
        and not one lookup. Texels that see less are not changed by it. It does not concern
        ``"nearest"`` (a mean of labels is no label), ``"area"``, ``"mode"``, ``"trilinear"`` and
        ``"ewa"``.
    alpha : int, optional
        The number of the channel, -1 for the last, that says how opaque a texel is. The others are
        then means by opacity: colors of transparent texels do not bleed. They are straight (not
        premultiplied) before and after; where nothing is opaque they are 0.
    world : {"match", "literal"}
        What is done where the programs of `src` and `dst` live in different worlds (z up, +x
        ahead, left-handed; `conventions` says which). ``"match"``: what is up stays up, what is
        ahead stays ahead, and nothing is mirrored. ``"literal"``: (x, y, z) stays (x, y, z).
    any_aspect : bool
        Whether an image, or a `size` with all its sides, is taken as it is where it is wider or
        higher for its projection than it should be: it is stretched then. By default each side has
        to be within a texel of the projection's aspect, and faces have to be squares.
    channels_first : bool
        Whether channels lie right before the rows, in `image` and in the result: (C, H, W), or with
        faces (F, C, N, N). Both are copied.
    window : tuple of slice, (rows, columns) or, with faces, (rows, columns, face), optional
        The part of the result that is made, where all of it is too much at once. It has the bits of
        the whole: windows side by side are the image.

    Returns
    -------
    image : ndarray of the same dtype and channels
        Of a batch as many, each with the bits that it has alone. Of a `window`, its rows and
        columns: (H, W) or (H, W, C).

    Raises
    ------
    ValueError, TypeError
        As for `sample`, and for a size that the projection of the result cannot have.

    Notes
    -----
    An image that is not C-contiguous, or not of native byte order, is copied for the call.

    With ``"area"``, Σ L·dω is kept to 1e-6 for any pair of projections, sizes and rotations, but
    where both lenses of a ``dual_fisheye`` of more than 180° see the same, and no
    texel is darker or brighter than the source. A texel that the source covers in part is the mean
    over that part. Texels cut by a disk's rim hold a value even where their center lies outside;
    in a source, such texels hold none (credits are printed there), and what they cover is given
    to the nearest texel inside. It is first-order conservative remapping (Jones 1999, SCRIP).
    A texel inside a face of the source costs about a microsecond on one core, where a bilinear
    lookup costs ten nanoseconds; one at a rim or on a crease 20 to 250 µs.

    Antialiased texels cost about 10 ns and as much for each source texel that they see, beside a
    pole or a rim 0.3 µs; those that need one lookup cost what they do without.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> probe = np.ones((64, 64, 3), np.float32)
    >>> sm.convert(probe, "angular", "cube", size=16).shape
    (6, 16, 16, 3)
    >>> sm.convert(probe, "angular", "latlong").shape
    (40, 80, 3)

    Blender has +z up, Unity +y; the sky stays above, and nothing is mirrored:

    >>> height = sm.directions("latlong:blender", 64)[..., 2]
    >>> there = sm.convert(height, "latlong:blender", "latlong:unity", size=64)
    >>> bool(np.allclose(there, sm.directions("latlong:unity", 64)[..., 1], atol=1e-12))
    True

    A sun of one texel keeps its energy:

    >>> sky = np.zeros((256, 512))
    >>> sky[100, 200] = 1e5
    >>> cube = sm.convert(sky, "latlong", "cube", size=16, filter="area")
    >>> before = (sky * sm.solid_angle("latlong", 256)).sum()
    >>> bool(np.isclose((cube * sm.solid_angle("cube", 16)).sum(), before, rtol=1e-6))
    True

    The upper left quarter of the face +z, of a cube too large for memory:

    >>> corner = sm.convert(
    ...     probe, "angular", "cube", size=40_000, window=(slice(0, 64), slice(0, 64), 4)
    ... )
    >>> corner.shape
    (64, 64, 3)

    A batch as networks have it, each image turned by its own rotation:

    >>> batch = np.zeros((4, 3, 32, 64), np.float32)
    >>> turns = np.stack([sm.rotation(yaw) for yaw in (0, 90, 180, 270)])
    >>> sm.convert(
    ...     batch, "latlong", "cube", size=16, rotation=turns, channels_first=True
    ... ).shape
    (4, 6, 3, 16, 16)
    """
    source, target = resolve(src), resolve(dst)
    if size is not None:
        size = target_shape(target, size, any_aspect)
    several = images(
        image, source, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(convert, locals())
    if size is None:
        size = matching_size(np.shape(image), source, target)
    shape = target.shape(size)
    source = resolve(source, rotation=rotation)
    part = None if window is None else stored_part(window, shape)
    filter = as_text(filter, "filter")
    if alpha is not None:
        alpha = as_whole(alpha, "alpha")
    skipna, antialias = as_flag(skipna, "skipna"), as_flag(antialias, "antialias")

    def converted(image: Any, fill: Any, out: Any) -> NDArray[Any]:
        return _core.convert(
            image,
            source,
            target,
            shape,
            filter=filter,
            fill=fill,
            out=out,
            skipna=skipna,
            antialias=antialias,
            alpha=alpha,
            world=world,
            window=part,
        )

    if not _has_texels(image):
        found = labeled(image, spatial_axes(source), filter, fill, out, alpha, converted)
        if found is not None:
            return found
    return converted(image, fill, out)


def _has_texels(image: object) -> bool:
    """Tell at once of what the core takes that it is no labels."""
    return image.dtype in _TEXELS if isinstance(image, np.ndarray) else is_chain(image)


@overload
def mipmaps(
    image: NDArray[Scalar],
    /,
    projection: ProjectionLike,
    *,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> list[NDArray[Scalar]]: ...
@overload
def mipmaps(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> list[NDArray[Any]]: ...
def mipmaps(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> list[NDArray[Any]]:
    """Return an image and its smaller versions, each half as wide and high.

    Parameters
    ----------
    image : array_like
        As for `sample`; a batch makes batches.
    projection : Projection or str
        How it maps the sphere; that of every level.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    levels : list of ndarray, of the image's dtype
        The image itself, and its levels down to faces of one texel along a side (two on a grid of
        corners), or to the last in which a texel has its center in the valid image. Sides that are
        odd are rounded down.

    Raises
    ------
    ValueError, TypeError
        As for `sample`.

    Notes
    -----
    A texel is the mean, by solid angle, of the texels that its rectangle covers, whole or in part:
    light is kept, to the rounding of the dtype. Levels are computed from each other in floating
    point, and each is an image of the projection, so that lookups know its seams. Texels that hold
    no value, outside a rim or a layout's cells, are 0.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> levels = sm.mipmaps(np.ones((6, 16, 16, 3), np.float32), "cube")
    >>> [level.shape for level in levels]
    [(6, 16, 16, 3), (6, 8, 8, 3), (6, 4, 4, 3), (6, 2, 2, 3), (6, 1, 1, 3)]
    """
    p = resolve(projection)
    several = images(image, p, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        return several.each(mipmaps, locals(), "levels")
    return [np.asanyarray(image), *_core.mipmaps(image, p)]
