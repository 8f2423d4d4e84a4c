"""Spherical harmonics of images in chunks: `spheremap.sh` on arrays that no memory holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import _core
from .. import sh as of_arrays
from .._arrays import spatial_axes
from .._scalars import as_text
from ..map.named import resolve
from ..sh import as_order
from .sheets import expect_image, summed

if TYPE_CHECKING:
    from collections.abc import Sequence

    import dask.array as da
    from numpy.typing import NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = ["project"]


def __dir__() -> list[str]:
    return __all__


def project(
    image: da.Array,
    /,
    projection: ProjectionLike,
    *,
    order: int,
    texels: Literal["means", "points"] = "means",
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
    any_aspect: bool = False,
) -> da.Array:
    """Return the spherical harmonic coefficients of an image in chunks.

    Parameters
    ----------
    image : dask.array.Array, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        In chunks of any sizes. Chunks of channels are put together.
    projection, order, texels, axes, rotation, skipna, any_aspect
        As for `spheremap.sh.project`; one rotation.

    Returns
    -------
    coefficients : dask.array.Array of float64, shape ((order + 1)²,) or ((order + 1)², C)
        Computed, they have the bits of `spheremap.sh.project`, in any chunks and by any scheduler.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.sh.project`: at once, but for values, which are looked at when they are
        there, and only where the image holds sphere.

    Notes
    -----
    A task takes a square of 512² texels of a face. Where texels lie on rings it gives the Fourier
    sums of its part of each, 2 (order + 3) numbers a row and channel, and elsewhere sums with the
    basis.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap.dask
    >>> white = da.ones((1024, 2048), chunks=256, dtype=np.float32)
    >>> found = spheremap.dask.sh.project(white, "latlong", order=1).compute()
    >>> (np.round(found, 6) + 0.0).tolist()
    [3.544908, 0.0, 0.0, 0.0]
    """
    p = resolve(resolve(projection, axes), rotation=rotation)
    pixels = expect_image(image, p, any_aspect)
    work = Coefficients.of(pixels, p, order, texels)
    shape = ((work.order + 1) ** 2, *pixels.shape[spatial_axes(p) :])
    return summed(pixels, p, work, shape, np.float64, skipna=skipna)


@dataclass(frozen=True, slots=True, eq=False)
class Coefficients:
    """The coefficients of an image, as a sum over its sheets."""

    projection: Projection
    order: int
    texels: Literal["means", "points"]
    # Of the image, with channels.
    shape: tuple[int, ...]

    @classmethod
    def of(cls, image: da.Array, projection: Projection, order: int, texels: Any) -> Coefficients:
        """Return those of an image, or raise for an order or a word that there is not."""
        if as_text(texels, "texels") not in ("means", "points"):
            raise ValueError(f"Expected `texels` to be 'means' or 'points', got {texels!r}.")
        return cls(projection, as_order(order), texels, image.shape)

    def whole(self, image: NDArray[Any]) -> NDArray[Any]:
        found: NDArray[Any] = of_arrays.project(
            image, self.projection, order=self.order, texels=self.texels, any_aspect=True
        )
        return found

    def part(self, image: NDArray[Any], number: int) -> NDArray[np.float64]:
        points = self.texels == "points"
        return _core.sh_of(image, self.projection, number, self.order, points)

    def result(self, parts: Sequence[NDArray[np.float64]]) -> NDArray[Any]:
        axes = spatial_axes(self.projection)
        channels = self.shape[axes:]
        found = _core.sh_from(
            np.concatenate(parts),
            self.projection,
            self.shape[:axes],
            channels[0] if channels else 1,
            self.order,
            self.texels == "points",
        )
        return found if channels else found[:, 0]
