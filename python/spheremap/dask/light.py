"""Light of images in chunks: `spheremap.light` on arrays that no memory holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from dask.array import map_blocks

from .. import _core
from .. import light as of_arrays
from .._arrays import as_array, result_dtype, spatial_axes
from .._scalars import as_flag, as_text
from ..light.image import coefficients
from ..light.lobes import lobe_image, normals_of, placed, seen_by
from ..light.sheets import energy_of_sheets
from ..map.images import target_shape
from ..map.named import resolve, resolve_pair
from ..sh import as_order
from .sh import Coefficients
from .sheets import computed, expect_image, summed

if TYPE_CHECKING:
    from collections.abc import Sequence

    import dask.array as da
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative, Size
    from .._projection import Projection
    from ..light.report import Energy
    from ..map.named import ProjectionLike, Worlds

__all__ = ["average_direction", "energy", "integrate", "irradiance", "mean"]


def __dir__() -> list[str]:
    return __all__


def integrate(
    image: da.Array,
    /,
    projection: ProjectionLike,
    *,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
) -> da.Array:
    """Integrate an image in chunks over the sphere: ∫ L dω.

    Parameters
    ----------
    image : dask.array.Array, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        In chunks of any sizes. Chunks of channels are put together.
    projection, skipna, negative, any_aspect
        As for `spheremap.light.integrate`.

    Returns
    -------
    integral : dask.array.Array of float64, shape () or (C,)
        Computed, it has the bits of `spheremap.light.integrate`, in any chunks and by any
        scheduler.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.light.integrate`: at once, but for values, which are looked at when they
        are there, and only where the image holds sphere.

    Notes
    -----
    A task sums a square of 512² texels of a face, from the chunks that hold it: no chunk whose
    sides are multiples of 512 is split. These sums are added in the order in which those of a
    whole image are.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap as sm, spheremap.dask
    >>> panorama = np.random.default_rng(0).random((600, 1200, 3))
    >>> chunks = da.from_array(panorama, chunks=(256, 256, 3))
    >>> total = spheremap.dask.light.integrate(chunks, "latlong")
    >>> bool((total.compute() == sm.light.integrate(panorama, "latlong")).all())
    True
    """
    checks = {"skipna": skipna, "negative": negative}
    return _moments(image, resolve(projection), "integrate", checks, any_aspect)


def mean(
    image: da.Array,
    /,
    projection: ProjectionLike,
    *,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
) -> da.Array:
    """Average an image in chunks over the part of the sphere that it covers.

    Parameters
    ----------
    image, projection, negative, any_aspect
        As for `integrate`.
    skipna : bool
        Average over the finite values alone, channel by channel.

    Returns
    -------
    mean : dask.array.Array of float64, shape () or (C,)
        Of the bits of `spheremap.light.mean`.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap.dask
    >>> white = da.ones((4096, 8192), chunks=1024, dtype=np.float32)
    >>> float(spheremap.dask.light.mean(white, "latlong"))
    1.0
    """
    checks = {"skipna": skipna, "negative": negative}
    return _moments(image, resolve(projection), "mean", checks, any_aspect)


def average_direction(
    image: da.Array,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
) -> da.Array:
    """Return where the light of an image in chunks comes from on average: ∫ L ω dω / ∫ L dω.

    Parameters
    ----------
    image, projection, skipna, negative, any_aspect
        As for `integrate`.
    axes, rotation
        As for `encode`.

    Returns
    -------
    direction : dask.array.Array of float64, shape (3,) or (C, 3)
        Of the bits of `spheremap.light.average_direction`.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap as sm, spheremap.dask
    >>> sky = da.from_array(np.maximum(sm.directions("latlong", 64)[..., 1], 0), chunks=32)
    >>> np.round(spheremap.dask.light.average_direction(sky, "latlong").compute() + 0.0, 3).tolist()
    [0.0, 0.667, 0.0]
    """
    p = resolve(resolve(projection, axes), rotation=rotation)
    checks = {"skipna": skipna, "negative": negative}
    return _moments(image, p, "average_direction", checks, any_aspect)


def energy(
    image: da.Array,
    /,
    projection: ProjectionLike,
    *,
    axes: str | None = None,
    rotation: Any | None = None,
    luminance: ArrayLike | None = None,
    skipna: bool = False,
    negative: Negative = "keep",
    any_aspect: bool = False,
) -> Energy:
    """Report the light that an image in chunks holds, at once: energy, peak, dynamic range, sun.

    Parameters
    ----------
    image, projection, skipna, any_aspect
        As for `integrate`.
    axes, rotation
        As for `encode`.
    luminance, negative
        As for `spheremap.light.energy`.

    Returns
    -------
    report : Energy
        That of `spheremap.light.energy`, to the bit. It is computed by the call: first a pass over
        all chunks, and then one over those around the brightest texel, where a sun would be.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`, and for a `luminance` that is none of the channels.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap.dask
    >>> sky = np.full((600, 1200), 0.5, np.float32)
    >>> sky[200, 400] = 4096
    >>> report = spheremap.dask.light.energy(da.from_array(sky, chunks=300), "latlong")
    >>> report.peak, report.sun is not None
    (4096.0, True)
    """
    p = resolve(resolve(projection, axes), rotation=rotation)
    pixels = expect_image(image, p, any_aspect)
    spatial = spatial_axes(p)
    weights = coefficients(np.empty((0,) * spatial + pixels.shape[spatial:]), spatial, luminance)
    checks: dict[str, Any] = {"skipna": skipna, "negative": negative}

    def of_each(sum: Any, numbers: Sequence[int]) -> list[NDArray[np.float64]]:
        return computed(pixels, p, sum, numbers, **checks)

    return energy_of_sheets(p, pixels.shape, weights, of_each)


def irradiance(
    image: da.Array,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size = 32,
    rotation: Any | None = None,
    method: Literal["exact", "sh"] = "exact",
    order: int = 8,
    skipna: bool = False,
    world: Worlds = "match",
    negative: Negative = "keep",
    any_aspect: bool = False,
) -> da.Array:
    """Return the irradiance of a surface for every normal, of an image in chunks.

    Parameters
    ----------
    image
        As for `integrate`.
    src, dst, size, rotation, method, order, skipna, world, negative, any_aspect
        As for `spheremap.light.irradiance`. The exact sum takes time for each texel and each normal
        that sees it near its horizon; "sh" does not.

    Returns
    -------
    irradiance : dask.array.Array, shape of `dst` (+ channels)
        In one chunk, of the bits of `spheremap.light.irradiance`.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap.dask
    >>> white = da.ones((1024, 2048, 3), chunks=512, dtype=np.float32)
    >>> E = spheremap.dask.light.irradiance(white, "latlong", "cube", size=4, method="sh")
    >>> E.shape, bool(np.abs(E.compute() - np.pi).max() < 1e-6)
    ((6, 4, 4, 3), True)
    """
    if as_text(method, "method") not in ("exact", "sh"):
        raise ValueError(f"Expected `method` to be 'exact' or 'sh', got {method!r}.")
    order = as_order(order)
    source, target = resolve_pair(src, dst, rotation, world)
    pixels = expect_image(image, resolve(src), any_aspect)
    shape = target_shape(target, size, any_aspect)
    axes = spatial_axes(source)
    channels = pixels.shape[axes:]
    dtype = result_dtype(np.empty(0, pixels.dtype))
    inner = Coefficients.of(pixels, source, order, "means") if method == "sh" else None
    work = _Irradiance(source, target, shape, channels, np.dtype(dtype), inner)
    return summed(
        pixels,
        source,
        work,
        (*shape, *channels),
        dtype,
        skipna=skipna,
        negative=negative,
    )


def _moments(
    image: da.Array, p: Projection, verb: str, checks: dict[str, Any], any_aspect: object
) -> da.Array:
    """Return an integral or what is made of it, by the name of the verb."""
    pixels = expect_image(image, p, any_aspect)
    shape = pixels.shape[spatial_axes(p) :]
    if verb == "average_direction":
        shape = (*shape, 3)
    skips = as_flag(checks["skipna"], "skipna") and pixels.dtype.kind == "f"
    if verb != "mean" or not skips:
        return summed(pixels, p, _Moments(p, verb), shape, np.float64, **checks)
    held = summed(pixels, p, _Moments(p, "integrate"), shape, np.float64, **checks)
    finite = map_blocks(_finite, pixels, dtype=np.float32)
    area = summed(finite, p, _Moments(p, "integrate"), shape, np.float64)
    mean: da.Array = map_blocks(_divided, held, area, dtype=np.float64)
    return mean


def _finite(texels: Any) -> NDArray[np.float32]:
    """Return 1 where texels have a value, and 0 where they have none."""
    finite: NDArray[np.float32] = np.isfinite(as_array(texels, "image")).astype(np.float32)
    return finite


def _divided(a: Any, b: Any) -> Any:
    with np.errstate(invalid="ignore", divide="ignore"):
        return a / b


@dataclass(frozen=True, slots=True, eq=False)
class _Moments:
    """∫ L dω and ∫ L ω dω, and what a verb makes of them."""

    projection: Projection
    verb: str

    def whole(self, image: NDArray[Any]) -> NDArray[Any]:
        verb = getattr(of_arrays, self.verb)
        found: NDArray[Any] = verb(image, self.projection, any_aspect=True)
        return found

    def part(self, image: NDArray[Any], number: int) -> NDArray[np.float64]:
        p, verb = self.projection, self.verb
        found = _core.moments_of(image, p, number, verb == "average_direction")
        # Without an axis of channels there is a row for the only one.
        return found if image.ndim > spatial_axes(p) else found[None]

    def result(self, parts: Sequence[NDArray[np.float64]]) -> NDArray[Any]:
        flat = np.stack([part.ravel() for part in parts])
        *leading, rows, columns = parts[0].shape
        moments: NDArray[np.float64] = _core.add_sheets(flat).reshape(rows, columns)
        found: NDArray[np.float64]
        if self.verb == "average_direction":
            found = _divided(moments[:-1, 1:], moments[:-1, :1])
        elif self.verb == "mean":
            found = _divided(moments[:-1, 0], moments[-1, 0])
        else:
            found = moments[:-1, 0]
        return found[0] if leading else found


@dataclass(frozen=True, slots=True, eq=False)
class _Irradiance:
    """Irradiance for every normal of an image, by all texels or by harmonics."""

    source: Projection
    target: Projection
    shape: tuple[int, ...]
    channels: tuple[int, ...]
    dtype: np.dtype[Any]
    harmonics: Coefficients | None

    def whole(self, image: NDArray[Any]) -> NDArray[Any]:
        if self.harmonics is not None:
            return self._of(self.harmonics.whole(image))
        return lobe_image(image, self.source, self.target, self.shape, "cosine", 0.0)

    def part(self, image: NDArray[Any], number: int) -> NDArray[np.float64]:
        if self.harmonics is not None:
            return self.harmonics.part(image, number)
        normals, _ = normals_of(self.target, self.shape)
        return _core.lobe_of(image, self.source, number, normals, "cosine", 0.0)

    def result(self, parts: Sequence[NDArray[np.float64]]) -> NDArray[Any]:
        if self.harmonics is not None:
            return self._of(self.harmonics.result(parts))
        flat = np.stack([part.ravel() for part in parts])
        sums = _core.add_sheets(flat).reshape(parts[0].shape)
        found = _core.lobe_from(sums, self.source, "cosine", 0.0)
        _, inside = normals_of(self.target, self.shape)
        whole = placed(found, inside).reshape(*self.shape, *self.channels)
        return whole.astype(self.dtype, copy=False)

    def _of(self, coefficients: NDArray[np.float64]) -> NDArray[Any]:
        return seen_by(coefficients, self.target, self.shape).astype(self.dtype)
