"""MatCaps from environments, and shading with one or the other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._arrays import as_doubles, as_image, common_shape, expect_vectors, spatial_shape
from .._scalars import as_flag, as_number, as_text, as_whole
from ..map.images import images
from ..map.named import resolve
from ..map.variants import pose_matrix
from ..map.verbs import reflect
from ..resample.verbs import convert, sample
from .image import as_light
from .lobes import irradiance
from .specular import prefilter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .._names import SampleFilter
    from ..map.named import ProjectionLike

__all__ = ["bake_matcap", "shade_environment", "shade_matcap"]

# Lookups along a side of a texel of a mirror.
_DETAIL = 4
# The longest axis that an empty array of vectors may have.
_LONGEST = 1 << 24


def bake_matcap(
    image: ArrayLike,
    /,
    projection: ProjectionLike = "latlong",
    *,
    material: Literal["mirror", "diffuse", "rough"] = "mirror",
    size: int = 256,
    roughness: float = 0.3,
    color: ArrayLike = 1.0,
    pose: Any | None = None,
    fill: float | Sequence[float] = 0.0,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return the picture of a ball of some material in an environment: a MatCap.

    Parameters
    ----------
    image : array_like, shape (H, W, C) or with faces
        Linear radiance of the environment. With one more axis in front it is a batch, as for
        `convert`.
    projection : Projection or str
        How it maps the sphere.
    material : {"mirror", "diffuse", "rough"}
        A mirror, Lambert's diffuse reflection, or GGX's rough mirror.
    size : int
        The side of the result.
    roughness : float
        Of "rough": perceptual, in [0, 1].
    color : float or one for each channel
        What the result is multiplied by: the albedo or the reflectance.
    pose : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        The camera's orientation in the world. Without it, the camera looks along -z.
    fill : float or sequence of float
        The value beside the ball, or one for each channel.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    matcap : ndarray of float32 or float64, shape (size, size, C), or (N, size, size, C) of a batch
        In the projection `matcap`, linear.

    Raises
    ------
    ValueError, TypeError
        As for `convert`, `irradiance` and `prefilter`; for values that are not finite, but with
        "mirror", which shows them.

    Notes
    -----
    The ball is seen from infinitely far away, and so must be what is shaded with it: a MatCap has
    one color for each normal, whatever the place.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> white = np.ones((32, 64, 3), np.float32)
    >>> matcap = sm.light.bake_matcap(
    ...     white, "latlong", material="diffuse", size=16, color=[0.8, 0.4, 0.2]
    ... )
    >>> (100 * matcap[8, 8]).round().tolist()
    [80.0, 40.0, 20.0]
    """
    if as_text(material, "material") not in ("mirror", "diffuse", "rough"):
        raise ValueError(
            f"Expected `material` to be 'mirror', 'diffuse' or 'rough', got {material!r}."
        )
    size = as_whole(size, "size")
    if size < 1:
        raise ValueError(f"`size` must be a whole number above 0, got {size}.")
    source = resolve(projection)
    several = images(image, source, any_aspect=any_aspect, channels_first=channels_first)
    if several is not None:
        return several.each(bake_matcap, locals())
    light = as_image(image, None)
    held = spatial_shape(light, source, "image")
    if light.dtype not in (np.float32, np.float64):
        light = light.astype(np.float32)
    # In the camera's frame; the mirror's ball has the normals of the MatCap where it shows the
    # directions of the sphere map. A mirror's pixels are means of what is known, all other light
    # that is not known is none.
    turn = pose_matrix(pose)
    normals, mirror = resolve("matcap").turned(turn), resolve("sphere").turned(turn)
    is_rough = material == "rough" and as_number(roughness, "roughness") > 0
    if is_rough or material == "diffuse":
        light = as_light(light, source, skipping=None)
    if material == "diffuse":
        diffuse = irradiance(light, source, normals, size=size, world="literal", any_aspect=True)
        baked = np.asarray(diffuse) / math.pi
    elif is_rough:
        baked = np.asarray(
            prefilter(
                light,
                source,
                mirror,
                size=size,
                roughness=roughness,
                world="literal",
                any_aspect=True,
            )
        )
    else:
        fine = convert(
            light,
            source,
            mirror,
            size=size * _DETAIL,
            fill=math.nan,
            world="literal",
            any_aspect=True,
        )
        blocks = fine.reshape(size, _DETAIL, size, _DETAIL, -1).astype(np.float64)
        known = ~np.isnan(blocks)
        # What no number holds becomes infinite.
        with np.errstate(invalid="ignore", over="ignore"):
            mean = np.where(known, blocks, 0).sum(axis=(1, 3)) / known.sum(axis=(1, 3))
        baked = mean.reshape(size, size, *light.shape[len(held) :])
    outside = ~np.isfinite(resolve("matcap").directions(size)[..., 0])
    tint = as_doubles(color, "color")
    channels = light.shape[len(held) :]
    if tint.shape not in ((), (1,), channels):
        raise ValueError(
            f"Expected `color` to be one number or {channels}, got shape {tint.shape}."
        )
    result = np.asarray(baked * tint, light.dtype)
    # What float32 does not hold becomes infinite.
    with np.errstate(over="ignore", invalid="ignore"):
        result[outside] = _filling(fill, channels)
    return result


def shade_matcap(
    normals: ArrayLike,
    matcap: ArrayLike,
    /,
    *,
    positions: ArrayLike | None = None,
    eye: ArrayLike | None = None,
    pose: Any | None = None,
    filter: SampleFilter | str | None = None,
    lod: ArrayLike | None = None,
    mipmaps: bool = False,
    channels_first: bool = False,
) -> NDArray[Any]:
    """Shade a surface with a MatCap: the color is that of the normal, as the viewer sees it.

    Parameters
    ----------
    normals : array_like, shape (..., 3)
        In the world, of any length.
    matcap : array_like, shape (N, N) or (N, N, C)
        In the projection `matcap`. With one more axis in front it is a batch, as for `convert`.
    positions : array_like, shape (..., 3), optional
        Of the surface. With `eye`, each point has its own frame, so that a ball looks the same
        anywhere in the picture; without, all have that of the camera.
    eye : array_like, shape (3,), optional
        Where the camera is.
    pose : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        The camera's orientation in the world.
    filter : str, optional
        As for `sample`.
    lod : array_like, shape (...), optional
        As for `sample`: the level of detail of each point.
    mipmaps : bool
        Whether each point is a pixel that shows all that it sees of the MatCap, by the differences
        to its neighbors; `normals` then has shape (H, W, 3). By default each is one lookup, and
        pixels that see many texels flicker.
    channels_first : bool
        As for `sample`.

    Returns
    -------
    color : ndarray, shape (...) or (..., C), or (N, ..., C) of a batch
        Normals that point away from the viewer get the color of the rim.

    Raises
    ------
    ValueError
        For shapes that do not fit, only one of `positions` and `eye`, both `lod` and `mipmaps`, and
        a filter that does not go with them.
    TypeError
        For unsupported dtypes.

    Notes
    -----
    With positions, x = normalize(V.z, 0, -V.x) and y = V × x, for V from the surface to the eye in
    the camera's frame (three.js). A MatCap turns with the camera: lights baked into it stay where
    they were in the picture. `shade_environment` has lights that stay where they are in the world.

    With `mipmaps` a pixel's derivatives are the differences to its neighbors, as on a graphics
    card, but of each pair of neighbors to the nearer one, so that an outline blurs nothing.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> matcap = sm.directions("matcap", 64)                    # the color is the normal
    >>> sm.light.shade_matcap([[0, 0, 1], [0, 2, 2]], matcap).round(2).tolist()
    [[0.0, 0.0, 1.0], [0.0, 0.71, 0.71]]
    """
    if (positions is None) != (eye is None):
        raise ValueError("Give both `positions` and `eye`, or neither.")
    _expect_one_level(lod, mipmaps)
    several = images(matcap, None, any_aspect=True, channels_first=channels_first, name="matcap")
    if several is not None:
        return several.each(shade_matcap, locals(), "values")
    # Infinity times 0 is no number, and a normal that is none shows nothing.
    with np.errstate(invalid="ignore"):
        n = _unit(_vectors(normals, "normals") @ pose_matrix(pose))
    if positions is not None and eye is not None:
        v = _to_eye(positions, eye) @ pose_matrix(pose)
        common_shape(("normals", n.shape), ("positions", v.shape))
        x = np.stack([v[..., 2], np.zeros_like(v[..., 0]), -v[..., 0]], axis=-1)
        length = np.linalg.norm(x, axis=-1, keepdims=True)
        # Straight above or below, any frame is as good.
        x = np.where(length > 1e-12, x / np.where(length > 1e-12, length, 1), [1.0, 0.0, 0.0])
        y = np.cross(v, x)
        n = np.stack([np.sum(a * n, axis=-1) for a in np.broadcast_arrays(x, y, v)], axis=-1)
    image = as_image(matcap, None, "matcap")
    if image.ndim not in (2, 3) or image.shape[0] != image.shape[1]:
        raise ValueError(f"Expected `matcap` to have shape (N, N) or (N, N, C), got {image.shape}.")
    # The outermost texels' centers are half a texel inside the rim.
    most = 1 - 1 / image.shape[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        radius = np.linalg.norm(n[..., :2], axis=-1)
        shrink = np.where((n[..., 2] < 0) | (radius > most), most / radius, 1)
        xy = n[..., :2] * np.where(np.isfinite(shrink), shrink, 1)[..., None]
        z = np.sqrt(np.maximum(1 - np.sum(xy * xy, axis=-1), 0))
    toward = np.concatenate([xy, z[..., None]], axis=-1)
    return sample(
        image,
        toward,
        resolve("matcap"),
        filter=filter,
        lod=lod,
        derivatives=_derivatives(toward) if mipmaps else None,
    )


def shade_environment(
    positions: ArrayLike,
    normals: ArrayLike,
    eye: ArrayLike,
    image: ArrayLike,
    /,
    projection: ProjectionLike = "latlong",
    *,
    rotation: Any | None = None,
    filter: SampleFilter | str | None = None,
    lod: ArrayLike | None = None,
    mipmaps: bool = False,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[Any]:
    """Shade a surface as a mirror of an environment: reflect, then look up.

    Parameters
    ----------
    positions, normals : array_like, shape (..., 3)
        Of the surface, in the world.
    eye : array_like, shape (3,)
        Where the camera is.
    image : array_like
        The environment, in `projection`; prefiltered, it makes a rough mirror. With `lod` it may be
        a list of levels, as from `prefilter_chain`. With one more axis in front it is a batch, as
        for `convert`.
    projection : Projection or str
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        Turns the environment in the world: what is at d goes to ``rotation @ d``. Of shape
        (N, 3, 3) as for `convert`.
    filter, lod, mipmaps
        As for `shade_matcap`.
    any_aspect : bool
        As for `convert`.
    channels_first : bool
        As for `sample`.

    Returns
    -------
    color : ndarray, shape (...) or (..., C), or (N, ..., C) of a batch

    Raises
    ------
    ValueError, TypeError
        As for `reflect` and `sample`, and for `mipmaps` without a picture of normals.

    Notes
    -----
    Blinn and Newell, Texture and Reflection in Computer Generated Images, 1976. With `mipmaps` the
    differences, taken as in `shade_matcap`, are those of what is reflected: curved mirrors blur
    what they make small.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.maximum(sm.directions("latlong", 64)[..., 1], 0)
    >>> float(sm.light.shade_environment([0, 0, 0], [0, 1, 1], [0, 0, 9], sky).round(1))
    1.0

    A ball of 5 × 5 pixels that each see many stripes of one texel:

    >>> y, x = np.mgrid[0.5:-0.5:5j, -0.5:0.5:5j]
    >>> ball = np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1)
    >>> stripes = np.tile([0.0, 1.0], (64, 64))
    >>> color = sm.light.shade_environment(ball, ball, [0, 0, 9], stripes, mipmaps=True)
    >>> bool(np.abs(color - 0.5).max() < 0.01)
    True
    """
    directions = np.asarray(reflect(_to_eye(positions, eye), _vectors(normals, "normals")))
    _expect_one_level(lod, mipmaps)
    return sample(
        image,
        directions,
        projection,
        rotation=rotation,
        filter=filter,
        lod=lod,
        derivatives=_derivatives(directions) if mipmaps else None,
        any_aspect=any_aspect,
        channels_first=channels_first,
    )


def _expect_one_level(lod: ArrayLike | None, mipmaps: object) -> None:
    """Raise where a level is given and to be found."""
    if as_flag(mipmaps, "mipmaps") and lod is not None:
        raise ValueError("Give `lod` or `mipmaps`, which finds a level of each pixel, not both.")


def _derivatives(directions: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return how the directions of a picture change to the next pixel right and down."""
    if directions.ndim != 3:
        raise ValueError(
            "Expected `normals` to be a picture of shape (H, W, 3), whose pixels have neighbors, "
            f"for `mipmaps`; got {directions.shape}."
        )
    unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    return _differences(unit, 1), _differences(unit, 0)


def _differences(unit: NDArray[Any], axis: int) -> NDArray[Any]:
    """Return differences along an axis to the nearer of both neighbors, 0 where there is none."""
    if not unit.size:
        return unit
    unknown = np.full_like(np.take(unit, [0], axis), np.nan)
    steps = np.diff(unit, axis=axis)
    ahead = np.concatenate([steps, unknown], axis)
    behind = np.concatenate([unknown, steps], axis)
    far = np.linalg.norm(ahead, axis=-1, keepdims=True)
    is_far = np.isnan(far) | (far > np.linalg.norm(behind, axis=-1, keepdims=True))
    return np.nan_to_num(np.where(is_far, behind, ahead))


def _filling(fill: float | Sequence[float], channels: tuple[int, ...]) -> NDArray[np.float64]:
    """Return what is outside: one number, or one a channel."""
    array = as_doubles(fill, "fill")
    if array.shape not in ((), channels):
        raise ValueError(
            f"Expected `fill` to be one number or {channels}, got shape {array.shape}."
        )
    return array


def _vectors(value: ArrayLike, name: str) -> NDArray[np.float64]:
    array = as_doubles(value, name)
    expect_vectors(array.shape, name)
    # Loops over nothing are long where an empty array has a long axis.
    if not array.size and max(array.shape) > _LONGEST:
        raise ValueError(f"Expected `{name}` to have fewer points, got shape {array.shape}.")
    return array


def _to_eye(positions: ArrayLike, eye: ArrayLike) -> NDArray[np.float64]:
    """Return unit vectors from a surface to the eye."""
    place = _vectors(eye, "eye")
    if place.shape != (3,):
        raise ValueError(f"Expected `eye` to have shape (3,), got {place.shape}.")
    v = place - _vectors(positions, "positions")
    return _unit(v)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors at length 1, and NaN for those that have none."""
    with np.errstate(all="ignore"):
        return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
