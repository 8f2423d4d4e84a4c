"""The public functions: each resolves a name and calls one method of the core."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from . import _core
from ._core import (
    Projection,
    __version__,
    get_num_threads,
    set_num_threads,
    simd_level,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, DTypeLike, NDArray

    from ._names import ConvertFilter, Filter, LayoutName, ProjectionName, QualifiedName

    # `str` is there for names that arrive in variables; the literals are what editors complete.
    ProjectionLike: TypeAlias = Projection | ProjectionName | QualifiedName | str
    Size: TypeAlias = int | tuple[int, ...]

__all__ = [
    "Projection",
    "__version__",
    "conventions",
    "convert",
    "covers",
    "decode",
    "density",
    "directions",
    "encode",
    "explain",
    "get_num_threads",
    "jacobian",
    "mipmaps",
    "projection",
    "reflect",
    "rotation",
    "sample",
    "set_num_threads",
    "simd_level",
    "solid_angle",
    "valid",
]

# Only names that resolved get in, so it cannot grow beyond the registry.
_named: dict[str, Projection] = {}


def _resolve(projection: ProjectionLike, axes: str | None = None) -> Projection:
    if axes is not None:
        return _with_axes(_resolve(projection), axes)
    if type(projection) is Projection:
        return projection
    try:
        return _named[projection]
    except (KeyError, TypeError):
        return _first_time(projection)


def _first_time(projection: object) -> Projection:
    if not isinstance(projection, str):
        raise TypeError(
            f"Expected a Projection or the name of one, got {type(projection).__name__}."
        )
    name, colon, convention = projection.partition(":")
    found = _core.projection(name, convention=convention if colon else None)
    _named[projection] = found
    return found


@lru_cache(maxsize=256)
def _with_axes(base: Projection, axes: str) -> Projection:
    return _core.projection(
        base.name,
        convention=base.convention,
        axes=axes,
        grid=base.grid,
        layout=base.layout,
        parameters=base.parameters,
    )


def projection(
    name: ProjectionName | QualifiedName | str,
    /,
    *,
    convention: str | None = None,
    axes: str | None = None,
    grid: str | None = None,
    layout: LayoutName | str | None = None,
    **parameters: float,
) -> Projection:
    """Return a projection: a frozen, hashable, picklable value with the verbs as methods.

    Parameters
    ----------
    name : str
        ``"latlong"``, or with a convention ``"latlong:mitsuba"``. `projections` lists the names.
    convention : str, optional
        The program whose axes, grid, layout and parameters to use, as in ``"mitsuba"``.
        `conventions` lists them.
    axes : str, optional
        Which signed world axes point right, down and forward (into the image center), as in
        ``"+x -y -z"``.
    grid : {"centers", "corners", "corners-v"}, optional
        Where the texels lie: at (i + 1/2)/n, at i/(n - 1), or the latter in v alone.
    layout : str, optional
        How several faces lie in an image: ``"faces"`` (an array of faces), ``"strip"``,
        ``"column"``, ``"cross"``, ``"vertical_cross"`` or ``"dice"``.
    **parameters : float
        The projection's own parameters, as ``fov`` (degrees) of ``"angular"``.

    Returns
    -------
    Projection

    Raises
    ------
    ValueError
        For an unknown name, convention or parameter, or a value out of range.

    Examples
    --------
    >>> import spheremap as sm
    >>> p = sm.projection("angular", fov=180)
    >>> p.coverage
    'cap'
    >>> p.encode([0.0, 0.0, -1.0]).tolist()
    [0.5, 0.5]
    """
    if not isinstance(name, str):
        raise TypeError(f"Expected the name of a projection, got {type(name).__name__}.")
    if convention is None and ":" in name:
        name, _, convention = name.partition(":")
    return _core.projection(
        name,
        convention=convention,
        axes=axes,
        grid=grid,
        layout=layout,
        parameters=parameters or None,
    )


def encode(
    directions: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Map directions to image coordinates.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection : Projection or str
        As for `projection`.
    axes : str, optional
        Replaces the axes of the projection.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the map, with its content, in the world.
    out : ndarray, optional
        Where to put the result: C-contiguous, of the result's shape and dtype.

    Returns
    -------
    uv : ndarray, shape (..., 2), or (..., 3) for a projection of several faces
        u in [0, 1] runs right, v in [0, 1] runs down from row 0; the third is the face.
        float32 for float16 and float32 input, else float64. NaN for a direction outside the
        coverage, zero, or not finite.

    Raises
    ------
    ValueError
        For a wrong shape, an unknown name, a matrix that is no rotation, or an unfit `out`.
    TypeError
        For complex numbers and objects, or an `out` of another dtype.

    Notes
    -----
    The formula of each projection and where it comes from: ``Projection.source``.

    Examples
    --------
    The default latlong looks along -z:

    >>> import spheremap as sm
    >>> sm.encode([[0, 0, -1], [1, 0, 0]], "latlong").tolist()
    [[0.5, 0.5], [0.75, 0.5]]
    """
    return _resolve(projection, axes).encode(directions, rotation=rotation, out=out)


def decode(
    uv: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Map image coordinates to directions: the inverse of `encode`.

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        As `encode` returns.
    projection, axes, rotation, out
        As for `encode`.

    Returns
    -------
    directions : ndarray, shape (..., 3)
        World directions of unit length; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The formula of each projection and where it comes from: ``Projection.source``.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.decode([[0.0, 0.0], [0.5, 0.5]], "sphere").round(6).tolist()
    [[nan, nan, nan], [0.0, -0.0, 1.0]]
    """
    return _resolve(projection, axes).decode(uv, rotation=rotation, out=out)


def jacobian(
    uv: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Return the derivative of the direction by the image coordinates.

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection, axes, rotation, out
        As for `encode`.

    Returns
    -------
    jacobian : ndarray, shape (..., 3, 2)
        Column 0 is the derivative of `decode` by u, column 1 by v (radians per unit of uv).
        NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    It is computed from the formula of `decode` itself by dual numbers.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.jacobian([0.5, 0.5], "latlong") + 0.0, 6).tolist()
    [[6.283185, 0.0], [0.0, -3.141593], [0.0, 0.0]]
    """
    return _resolve(projection, axes).jacobian(uv, rotation=rotation, out=out)


def density(
    uv: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Return the solid angle per unit of image area, dω/(du dv).

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection, out
        As for `encode`.

    Returns
    -------
    density : ndarray, shape (...)
        Steradians per unit of uv area; NaN outside the valid image.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    It is the length of the cross product of the two columns of `jacobian`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.density([[0.5, 0.5], [0.3, 0.4]], "sphere"), 6).tolist()
    [16.0, 16.0]
    """
    return _resolve(projection).density(uv, out=out)


def valid(uv: ArrayLike, projection: ProjectionLike, /) -> NDArray[np.bool_]:
    """Tell which image coordinates hold a part of the sphere.

    Parameters
    ----------
    uv : array_like, shape (..., 2), or (..., 3) for a projection of several faces
        Image coordinates.
    projection : Projection or str
        As for `projection`.

    Returns
    -------
    valid : ndarray of bool, shape (...)

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.valid([[0.5, 0.5], [0.0, 0.0]], "angular").tolist()
    [True, False]
    """
    return _resolve(projection).valid(uv)


def covers(
    directions: ArrayLike, projection: ProjectionLike, /, *, rotation: Any | None = None
) -> NDArray[np.bool_]:
    """Tell which directions the image holds.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection, rotation
        As for `encode`.

    Returns
    -------
    covered : ndarray of bool, shape (...)

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.covers([[0, 0, 1], [0, 0, -1]], "matcap").tolist()
    [True, False]
    """
    return _resolve(projection).covers(directions, rotation=rotation)


def solid_angle(projection: ProjectionLike, shape: Size, /) -> NDArray[np.float64]:
    """Return the solid angle of each texel.

    Parameters
    ----------
    projection : Projection or str
        As for `projection`.
    shape : int or tuple of int
        One number (the height of a latlong, the side of a square, the face of a cube) or the
        whole shape without channels.

    Returns
    -------
    solid_angle : ndarray of float64, shape (H, W), or (F, N, N) for an array of faces
        In steradians. A texel across the rim counts with its covered part; the sum is the
        covered solid angle, 4π for the whole sphere.

    Raises
    ------
    ValueError, TypeError
        For a shape that the projection cannot have.

    Examples
    --------
    >>> import math, spheremap as sm
    >>> w = sm.solid_angle("latlong", (4, 8))
    >>> w.shape, math.isclose(w.sum(), 4 * math.pi, rel_tol=1e-12)
    ((4, 8), True)
    """
    return _resolve(projection).solid_angle(shape)


def directions(
    projection: ProjectionLike,
    size: Size,
    /,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    dtype: DTypeLike = np.float64,
) -> NDArray[np.floating[Any]]:
    """Return the direction of every texel.

    Parameters
    ----------
    projection, axes, rotation
        As for `encode`.
    size : int or tuple of int
        As for `solid_angle`.
    dtype : float32 or float64
        Of the result.

    Returns
    -------
    directions : ndarray, the image's shape + (3,)
        Unit length; NaN for texels whose center lies outside the valid image.

    Raises
    ------
    ValueError, TypeError
        For a size that the projection cannot have, or another dtype.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.directions("octahedral", 1).tolist()
    [[[0.0, 0.0, 1.0]]]
    >>> sm.directions("latlong", 256).shape
    (256, 512, 3)
    """
    return _resolve(projection, axes).directions(size, rotation=rotation, dtype=dtype)


def sample(
    image: ArrayLike,
    directions: ArrayLike,
    projection: ProjectionLike,
    /,
    *,
    filter: Filter = "bilinear",
    axes: str | None = None,
    rotation: Any | None = None,
    fill: float | None = None,
    out: NDArray[Any] | None = None,
    alpha: int | None = None,
    skipna: bool = False,
) -> NDArray[Any]:
    """Look directions up in an image.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Of dtype uint8, uint16, float16, float32 or float64.
    directions : array_like, shape (..., 3)
        World directions of any length.
    projection, axes, rotation
        As for `encode`: how the image maps the sphere.
    filter : str
        ``"bilinear"``, ``"nearest"``, ``"catmull-rom"`` (also called ``"bicubic"``), which
        interpolates, ``"mitchell"``, which is softer and rings less [1]_, ... The documentation's
        table has all. All know what lies beyond an edge: seams do not show.
    fill : float, optional
        The value for directions that the image does not hold. By default NaN, or 0 for integer
        images.
    out : ndarray, optional
        Where to put the result.
    alpha : int, optional
        The number of the channel, -1 for the last, that says how opaque a texel is. The others are
        then means by opacity: colors of transparent texels do not bleed. They are straight (not
        premultiplied) before and after; where nothing is opaque they are 0.
    skipna : bool
        Whether NaN texels have no weight. By default they spread to every value that they touch.

    Returns
    -------
    values : ndarray, shape (...) or (..., C), of the image's dtype

    Raises
    ------
    ValueError, TypeError
        As for `encode`, and for an image of an unfit shape or dtype.

    Notes
    -----
    An image that is not C-contiguous (``rgba[..., :3]``, ``image[::-1]``, Fortran order) or not of
    native byte order is copied for the call. It is the one array that costs memory beside itself
    and the result.

    References
    ----------
    .. [1] Mitchell, D. P. and Netravali, A. N., Reconstruction Filters in Computer Graphics,
       SIGGRAPH 1988.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> height = sm.directions("latlong", 64)[..., 1]
    >>> np.round(sm.sample(height, [[0, 1, 1], [0, -1, 1]], "latlong"), 2).tolist()
    [0.71, -0.71]
    """
    return _resolve(projection, axes).sample(
        image,
        directions,
        filter=filter,
        rotation=rotation,
        fill=fill,
        out=out,
        alpha=alpha,
        skipna=skipna,
    )


def convert(
    image: ArrayLike,
    src: ProjectionLike,
    dst: ProjectionLike,
    /,
    *,
    size: Size | None = None,
    rotation: Any | None = None,
    filter: ConvertFilter = "bilinear",
    fill: float = 0.0,
    out: NDArray[Any] | None = None,
    skipna: bool = False,
    antialias: bool = True,
    alpha: int | None = None,
) -> NDArray[Any]:
    """Turn an image from one projection into another.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Of dtype uint8, uint16, float16, float32 or float64.
    src, dst : Projection or str
        The projection of `image`, and that of the result.
    size : int or tuple of int, optional
        As for `solid_angle`. By default the size that holds about as many texels per covered
        steradian as the source.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the content in the world.
    filter : str
        Those of `sample` look texels up, and are averaged where `antialias` says so.
        ``"area"`` is conservative: each texel is the mean of the source over its own solid angle,
        so that no light is lost or made. ``"mode"`` is the value that covers most of it, for
        labels. ``"trilinear"`` and ``"ewa"`` look up in `mipmaps`, as renderers do.
    fill : float
        The value where the result has no sphere, or the source does not hold the direction.
    out : ndarray, optional
        Where to put the result.
    skipna : bool
        Whether NaN texels have no weight. By default they spread to every texel that they touch.
    antialias : bool
        Whether a texel that sees more than one texel of the source is the mean of what it sees,
        and not one lookup. Texels that see less are not changed by it. It does not concern
        ``"nearest"`` (a mean of labels is no label), ``"area"``, ``"mode"``, ``"trilinear"`` and
        ``"ewa"``.
    alpha : int, optional
        The number of the channel, -1 for the last, that says how opaque a texel is. The others are
        then means by opacity: colors of transparent texels do not bleed. They are straight (not
        premultiplied) before and after; where nothing is opaque they are 0.

    Returns
    -------
    image : ndarray of the same dtype and channels

    Raises
    ------
    ValueError, TypeError
        As for `sample`.

    Notes
    -----
    An image that is not C-contiguous, or not of native byte order, is copied for the call.

    With ``"area"``, Σ L·dω is kept to 1e-6 for any pair of projections, sizes and rotations, and no
    texel is darker or brighter than the source. A texel that the source covers in part is the mean
    over that part. Texels cut by a disk's rim hold a value even where their center lies outside;
    in a source, such texels hold none (credits are printed there), and what they cover is given
    to the nearest texel inside. It is first-order conservative remapping (Jones 1999, SCRIP).
    A texel inside a face of the source costs about a microsecond on one core, where a bilinear
    lookup costs ten nanoseconds; one at a rim or on a crease 20 to 250 µs.

    Antialiased texels cost about 0.3 µs and 15 ns for each source texel that they see; those that
    need one lookup cost what they do without.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> probe = np.ones((64, 64, 3), np.float32)
    >>> sm.convert(probe, "angular", "cube", size=16).shape
    (6, 16, 16, 3)
    >>> sm.convert(probe, "angular", "latlong").shape
    (40, 80, 3)

    A sun of one texel keeps its energy:

    >>> sky = np.zeros((256, 512))
    >>> sky[100, 200] = 1e5
    >>> cube = sm.convert(sky, "latlong", "cube", size=16, filter="area")
    >>> before = (sky * sm.solid_angle("latlong", 256)).sum()
    >>> bool(np.isclose((cube * sm.solid_angle("cube", 16)).sum(), before, rtol=1e-6))
    True
    """
    source, target = _resolve(src), _resolve(dst)
    if size is None:
        size = _matching_size(np.shape(image), source, target)
    return _core.convert(
        image,
        source,
        target,
        target.shape(size),
        rotation=rotation,
        filter=filter,
        fill=fill,
        out=out,
        skipna=skipna,
        antialias=antialias,
        alpha=alpha,
    )


def mipmaps(image: ArrayLike, projection: ProjectionLike, /) -> list[NDArray[Any]]:
    """Return an image and its smaller versions, each half as wide and high.

    Parameters
    ----------
    image : array_like
        As for `sample`.
    projection : Projection or str
        How it maps the sphere; that of every level.

    Returns
    -------
    levels : list of ndarray, of the image's dtype
        The image itself, and its levels down to faces of one texel along a side (two on a grid of
        corners). Sides that are odd are rounded down.

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
    p = _resolve(projection)
    return [np.asanyarray(image), *_core.mipmaps(image, p)]


def _matching_size(image_shape: tuple[int, ...], src: Projection, dst: Projection) -> int:
    return _core.matching_size(image_shape[: 2 if src.faces == 1 else 3], src, dst)


def reflect(
    view: ArrayLike, normal: ArrayLike, /, *, out: NDArray[Any] | None = None
) -> NDArray[np.floating[Any]]:
    """Reflect view vectors about normals: r = 2(v·n)n/(n·n) - v.

    Parameters
    ----------
    view : array_like, shape (..., 3)
        From the surface toward the eye; the result keeps its length.
    normal : array_like, shape (..., 3)
        Of any length. The two broadcast.
    out : ndarray, optional
        Where to put the result.

    Returns
    -------
    reflected : ndarray, shape (..., 3)
        The direction to look up in an environment map.

    Raises
    ------
    ValueError, TypeError
        As for `encode`.

    Notes
    -----
    The law of reflection: what GLSL calls ``reflect(-v, n)``, for a normal of any length.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.reflect([1.0, 1.0, 0.0], [0.0, 2.0, 0.0]).tolist()
    [-1.0, 1.0, 0.0]
    """
    return _core.reflect(view, normal, out=out)


def rotation(yaw: float, pitch: float, roll: float) -> NDArray[np.float64]:
    """Return the matrix Ry(yaw) Rx(pitch) Rz(roll), for `rotation=`.

    Parameters
    ----------
    yaw, pitch, roll : float
        Right-handed turns about +y, +x and +z, in degrees. The roll comes first.

    Returns
    -------
    matrix : ndarray of float64, shape (3, 3)

    Raises
    ------
    ValueError
        For an angle that is not finite.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> np.round(sm.rotation(90, 0, 0) @ [0, 0, 1] + 0.0, 12).tolist()
    [1.0, 0.0, 0.0]
    """
    return _core.rotation(yaw, pitch, roll)


def explain(projection: ProjectionLike, /) -> None:
    """Print where ±x, ±y and ±z land, which way is up, the grid, the coverage and the density.

    Parameters
    ----------
    projection : Projection or str
        As for `projection`.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.explain("latlong")  # doctest: +ELLIPSIS, +NORMALIZE_WHITESPACE
    projection latlong: ...
    """
    _resolve(projection).explain()


def conventions(kind: ProjectionName | str | None = None) -> list[dict[str, Any]]:
    """Return what named programs use: one row for each program and projection.

    Parameters
    ----------
    kind : str, optional
        The name of a projection, to get its rows alone.

    Returns
    -------
    rows : list of dict
        With ``kind``, ``name``, ``axes``, ``grid``, ``layout``, ``parameters``, ``note``,
        ``source``, ``version`` and ``verified``.

    Raises
    ------
    ValueError
        For an unknown name.

    Examples
    --------
    >>> import spheremap as sm
    >>> [row["axes"] for row in sm.conventions("latlong") if row["name"] == "mitsuba"]
    ['-x -y +z']
    """
    rows = _core.convention_table()
    if kind is None:
        return rows
    name = _resolve(kind).name
    return [row for row in rows if row["kind"] == name]
