"""Environments for renderers: rough reflections in mip chains, and their table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .._arrays import checked_image, has_channels, result_dtype, spatial_axes
from .._progress import part
from .._scalars import as_flag, as_items, as_number, as_text, as_whole
from ..map.images import images, target_shape
from ..map.named import resolve, resolve_pair
from ..resample import convert
from .lobes import lobe_image

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative, Size
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["dfg", "prefilter", "prefilter_chain"]

Distribution = Literal["ggx", "charlie"]

# Pairs of texels up to which the exact sum is taken by default: about a second on two cores.
_EXACT_PAIRS = 1 << 30


def prefilter(
    image: ArrayLike,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    roughness: float,
    size: Size = 64,
    rotation: Any | None = None,
    distribution: Distribution = "ggx",
    method: Literal["auto", "exact", "sampled"] = "auto",
    samples: int = 1024,
    skipna: bool = False,
    world: Worlds = "match",
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> NDArray[np.floating[Any]]:
    """Return an environment as a rough mirror shows it, for every direction of reflection.

    Parameters
    ----------
    image, src, dst, size, rotation, skipna, world, negative, any_aspect, channels_first
        As for `irradiance`.
    roughness : float
        Perceptual, in [0, 1]: α = roughness². 0 is a mirror: an image of the whole sphere is
        resampled by `convert`, by area where texels become larger.
    distribution : {"ggx", "charlie"}
        Of the normals; Charlie is that of cloth, and needs a roughness above 0.
    method : {"auto", "exact", "sampled"}
        The sum over all texels, or one of a mip chain: over a level whose texels are small beside
        the lobe, or of `samples` lookups (filtered importance sampling) where the lobe is narrow.
        "auto" sums over all where there are at most 2³⁰ pairs of texels and the lobe is wider than
        the source's texels.
    samples : int
        For the sampled method: what a texel may take, so many lookups or the sum over 24 times as
        many texels. At 1024 within 0.5 % (root mean square) of the exact sum from roughness 0.5 on.

    Returns
    -------
    prefiltered : ndarray, shape of `dst` (+ channels)
        Normalized: a constant L gives L. dtypes as for `irradiance`; "sampled" computes in float32.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`, and for a roughness out of range.

    Notes
    -----
    The first factor of the split sum of Karis 2013, with n = v = r: the mean of L(l) weighted by
    D(h) (n·l). `dfg` is the second.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> white = np.ones((32, 64, 3), np.float32)
    >>> rough = sm.light.prefilter(white, "latlong", "cube", roughness=0.5, size=4)
    >>> rough.shape, bool(np.allclose(rough, 1))
    ((6, 4, 4, 3), True)
    """
    _check(distribution, roughness, samples)
    if as_text(method, "method") not in ("auto", "exact", "sampled"):
        raise ValueError(f"Expected `method` to be 'auto', 'exact' or 'sampled', got {method!r}.")
    several = images(
        image,
        resolve(src),
        any_aspect=any_aspect,
        channels_first=channels_first,
        rotation=rotation,
    )
    if several is not None:
        target_shape(resolve(dst), size, any_aspect)
        return several.each(prefilter, locals())
    source, target = resolve_pair(src, dst, rotation, world)
    pixels = checked_image(image, source, skipna=skipna, negative=negative)
    shape = target_shape(target, size, any_aspect)
    alpha = as_number(roughness, "roughness") ** 2
    if method == "exact" and alpha == 0:
        raise ValueError("a mirror, `roughness` 0, has no exact sum; use 'sampled' or `convert`.")
    if method == "auto":
        texels = _texels(pixels, source)
        # Half of a GGX lobe's weight lies within a cone of radius 2α or so.
        resolved = alpha > 4 * np.sqrt(source.covered_solid_angle / max(texels, 1))
        few = texels * int(np.prod(shape)) <= _EXACT_PAIRS
        method = "exact" if resolved and few else "sampled"
    if method == "exact":
        return lobe_image(pixels, source, target, shape, distribution, alpha)
    return _sampled(pixels, source, target, [shape], [alpha], distribution, samples)[0]


def prefilter_chain(
    image: ArrayLike,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: int = 256,
    levels: int | None = None,
    rotation: Any | None = None,
    roughness: Sequence[float] | None = None,
    distribution: Distribution = "ggx",
    samples: int = 1024,
    skipna: bool = False,
    world: Worlds = "match",
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> list[NDArray[np.floating[Any]]]:
    """Return a mip chain of rough reflections: level k for roughness k/(levels - 1).

    Parameters
    ----------
    image, src, dst, rotation, distribution, samples, skipna, world, negative
        As for `prefilter`, by its method "sampled".
    any_aspect, channels_first : bool
        As for `convert`.
    size : int
        Of level 0; each further level has half of it.
    levels : int, optional
        How many there are: by default one for each `roughness`, or 6, or as many as `size` can be
        halved.
    roughness : sequence of float, optional
        One number a level, in place of k/(levels - 1).

    Returns
    -------
    chain : list of ndarray
        Level 0 first. With the default roughness it is a mirror: the image itself, resampled.
        (With Charlie, which has no mirror, level 0 has roughness 1/(2 levels - 2).)

    Raises
    ------
    ValueError, TypeError
        As for `prefilter`, and for more levels than the size can be halved.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.ones((32, 64, 3), np.float32)
    >>> chain = sm.light.prefilter_chain(sky, "latlong", "cube", size=16, levels=3, samples=64)
    >>> [level.shape for level in chain]
    [(6, 16, 16, 3), (6, 8, 8, 3), (6, 4, 4, 3)]
    """
    size = as_whole(size, "size")
    if size < 1:
        raise ValueError(f"Expected a `size` of at least 1, got {size}.")
    if roughness is not None:
        roughness = list(as_items(roughness, "roughness", "numbers"))
    if levels is None:
        levels = min(6, size.bit_length()) if roughness is None else len(roughness)
        if not 1 <= levels <= size.bit_length():
            raise ValueError(
                f"Expected `roughness` to have 1 to {size.bit_length()} numbers, one a level of "
                f"`size` {size}, got {levels}."
            )
    if not 1 <= as_whole(levels, "levels") <= size.bit_length():
        raise ValueError(f"Expected `levels` from 1 to {size.bit_length()}, got {levels}.")
    if roughness is None:
        values = [k / max(levels - 1, 1) for k in range(levels)]
        if as_text(distribution, "distribution") == "charlie":
            values[0] = 0.5 / max(levels - 1, 1)
    else:
        values = [as_number(x, "roughness") for x in roughness]
    if len(values) != levels:
        raise ValueError(f"Expected `roughness` to have {levels} numbers, got {len(values)}.")
    for value in values:
        _check(distribution, value, samples)
    several = images(
        image,
        resolve(src),
        any_aspect=any_aspect,
        channels_first=channels_first,
        rotation=rotation,
    )
    if several is not None:
        return several.each(prefilter_chain, locals(), "levels")
    source, target = resolve_pair(src, dst, rotation, world)
    pixels = checked_image(image, source, skipna=skipna, negative=negative)
    shapes = [target.shape(size >> k) for k in range(levels)]
    alphas = [value**2 for value in values]
    return _sampled(pixels, source, target, shapes, alphas, distribution, samples)


def dfg(
    size: int = 128, *, distribution: Distribution = "ggx", multiscatter: bool = True
) -> NDArray[np.float32]:
    """Return the table of the split sum: what a surface reflects of a white environment.

    Parameters
    ----------
    size : int
        Entries along each side.
    distribution : {"ggx", "charlie"}
        GGX with the height-correlated Smith term, or Charlie with Neubelt and Pettineo's.
    multiscatter : bool
        Which pair of numbers to store; both describe the same surface.

    Returns
    -------
    table : ndarray of float32, shape (size, size, 2)
        Entry (j, i) is for roughness (j + 1/2)/size (α = roughness²) and n·v = (i + 1/2)/size.
        With E the reflectance at F0 = 1 and B the part of it that Schlick's (1 - v·h)⁵ takes:
        ``(B, E)`` if `multiscatter`, for F0 E + (1 - F0) B, where 1 + F0 (1/E - 1) gives back
        what single scattering loses; else ``(E - B, B)``, for F0 x + y as Karis has it.

    Raises
    ------
    ValueError
        For a size below 1 or an unknown distribution.

    Notes
    -----
    Karis 2013; Heitz 2014; Turquin 2019 for the energy. Entries are within 1e-4 of the integrals.

    Examples
    --------
    A smooth metal seen from the front reflects all:

    >>> import spheremap as sm
    >>> B, E = sm.light.dfg(32)[0, -1]
    >>> bool(abs(E - 1) < 1e-4)
    True
    """
    if as_text(distribution, "distribution") not in ("ggx", "charlie"):
        raise ValueError(f"unknown distribution {distribution!r}; there are ggx, charlie")
    if not 1 <= as_whole(size, "size") <= 4096:
        raise ValueError(f"Expected a size from 1 to 4096, got {size}.")
    both = _core.dfg(distribution, size)
    whole, fresnel = both[..., 0], both[..., 1]
    pair = (fresnel, whole) if as_flag(multiscatter, "multiscatter") else (whole - fresnel, fresnel)
    return np.stack(pair, axis=-1).astype(np.float32)


def _sampled(
    pixels: NDArray[Any],
    source: Projection,
    target: Projection,
    shapes: list[tuple[int, ...]],
    alphas: list[float],
    distribution: str,
    samples: int,
) -> list[NDArray[np.floating[Any]]]:
    # Texels in which a part of the sphere ends are as bright as what is seen of them: the core
    # knows how much that is.
    mirrors = [k for k, alpha in enumerate(alphas) if alpha == 0 and source.coverage == "sphere"]
    rough = [k for k in range(len(alphas)) if k not in mirrors]
    dtype, whole = result_dtype(pixels), len(alphas)
    levels: dict[int, NDArray[np.floating[Any]]] = {}
    if rough:
        sizes, widths = [shapes[k] for k in rough], [alphas[k] for k in rough]
        with part(0.0, len(rough) / whole):
            found = _core.prefilter(pixels, source, target, sizes, widths, distribution, samples)
        channels = has_channels(pixels, source)
        for k, level in zip(rough, found, strict=True):
            levels[k] = (level if channels else level[..., 0]).astype(dtype, copy=False)
    for done, k in enumerate(mirrors, len(rough)):
        with part(done / whole, (done + 1) / whole):
            levels[k] = _mirror(pixels.astype(dtype, copy=False), source, target, shapes[k])
    return [levels[k] for k in range(whole)]


def _mirror(
    pixels: NDArray[np.floating[Any]],
    source: Projection,
    target: Projection,
    shape: tuple[int, ...],
) -> NDArray[np.floating[Any]]:
    """Return the image, resampled: by area where texels become larger, which keeps suns."""
    own = source.covered_solid_angle / max(_texels(pixels, source), 1)
    is_finer = target.covered_solid_angle / math.prod(shape) < own
    return convert(
        pixels,
        source,
        target,
        size=shape,
        filter="bilinear" if is_finer else "area",
        world="literal",
        any_aspect=True,
    )


def _texels(pixels: NDArray[Any], source: Projection) -> int:
    return math.prod(pixels.shape[: spatial_axes(source)])


def _check(distribution: str, roughness: float, samples: int) -> None:
    if as_text(distribution, "distribution") not in ("ggx", "charlie"):
        raise ValueError(f"unknown distribution {distribution!r}; there are ggx, charlie")
    if not 0 <= as_number(roughness, "roughness") <= 1:
        raise ValueError(f"`roughness` must be in [0, 1], got {roughness}.")
    if distribution == "charlie" and roughness == 0:
        raise ValueError("`roughness` must be above 0 for 'charlie'.")
    if not 1 <= as_whole(samples, "samples") <= 1 << 20:
        raise ValueError(f"`samples` must be from 1 to {1 << 20}, got {samples}.")
