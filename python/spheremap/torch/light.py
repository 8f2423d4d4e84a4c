"""Light of tensors: irradiance, and directions drawn as often as an image is bright there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .. import light
from . import sh
from ._operators import in_float
from ._specs import map_of, spec_of, split_rotation, whole
from .images import channels_first, turned_grid, with_channels

if TYPE_CHECKING:
    from torch import Tensor

    from .._arrays import Size
    from ..map.named import ProjectionLike

__all__ = ["Distribution", "irradiance"]


def irradiance(
    image: Tensor,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size = 32,
    rotation: Any | None = None,
    order: int = 8,
    world: str = "match",
    any_aspect: bool = False,
) -> Tensor:
    """Return the irradiance of a surface for every normal, by spherical harmonics.

    Parameters
    ----------
    image : Tensor
        Radiance, as for `spheremap.torch.sample`.
    src, dst, size, world, any_aspect
        As for `spheremap.light.irradiance`.
    rotation : Tensor, array_like or an object with ``.as_matrix()``, optional
        Turns the content in the world. Gradients flow to a tensor.
    order : int
        The highest degree. The bound of the error is that of ``method="sh"`` there.

    Returns
    -------
    irradiance : Tensor
        With the batch, channels and dtype of the image. 0 outside the valid image of `dst`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.light.irradiance`.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> white = torch.ones(3, 32, 64, requires_grad=True)
    >>> e = smt.light.irradiance(white, "latlong", "cube", size=8)
    >>> e.mean().backward()
    >>> e.shape, round((e.mean() / torch.pi).item(), 5)
    (torch.Size([6, 3, 8, 8]), 1.0)
    """
    data = in_float(image, "image")
    seen, target = spec_of(src), spec_of(dst)
    _, grid = turned_grid(seen, target, size, whole(image.shape), world, any_aspect)
    turn, fixed = split_rotation(rotation)
    if fixed is not None:
        seen = spec_of(src, None, fixed)
    found = sh.projected(data, seen, turn, order, "means", any_aspect)
    d = grid.to(device=data.device, dtype=data.dtype)
    values = sh.evaluate(sh.convolve(found, lobe="cosine"), d)
    # Normals that there are none of.
    kept = torch.where(d.isnan().any(-1), 0.0, values)
    return with_channels(kept, d.ndim - 1).to(image.dtype).contiguous()


class Distribution:
    """A density on the sphere, proportional to the luminance of an image.

    Parameters
    ----------
    image : Tensor, shape (H, W) or (C, H, W), or with faces (F, S, S) or (F, C, S, S)
        Linear radiance.
    projection, axes, luminance, any_aspect
        As for `spheremap.light.Distribution`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.light.Distribution`.

    Notes
    -----
    Neither what is drawn nor its density has a gradient: in an estimator they are what is divided
    by, and a step in the image moves no sample. The kernels of the CPU do it.

    Examples
    --------
    >>> import torch, spheremap.torch as smt
    >>> sky = smt.directions("latlong", 32)[..., 1].clamp(min=0).requires_grad_()
    >>> drawn = smt.light.Distribution(sky, "latlong")
    >>> d, pdf = drawn.sample(torch.rand(100, 2))
    >>> bool((d[:, 1] > 0).all()), bool(torch.allclose(drawn.pdf(d), pdf, rtol=1e-4))
    (True, True)
    """

    def __init__(
        self,
        image: Tensor,
        /,
        projection: ProjectionLike,
        *,
        axes: str | None = None,
        luminance: Any | None = None,
        any_aspect: bool = False,
    ) -> None:
        data = in_float(image, "image")
        spec = spec_of(projection, axes, None)
        several, _ = channels_first(data, spec, any_aspect)
        if data.ndim > several.ndim:
            raise ValueError("One Distribution is of one image: make one of each.")
        last = several.movedim(0, -1)
        given = last.detach().cpu().numpy()
        p = map_of(spec)
        self._held = light.Distribution(given, p, luminance=luminance, any_aspect=any_aspect)

    def sample(self, xi: Tensor, /) -> tuple[Tensor, Tensor]:
        """Return directions and their density for numbers in [0, 1].

        Parameters
        ----------
        xi : Tensor, shape (..., 2)
            Random or low-discrepancy numbers.

        Returns
        -------
        directions : Tensor, shape (..., 3)
            Unit world directions, of the dtype and on the device of `xi`.
        pdf : Tensor, shape (...)
            Per steradian.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.Distribution.sample`.
        """
        given = in_float(xi, "xi").detach().cpu().numpy()
        d, pdf = (torch.from_numpy(part) for part in self._held.sample(given))
        return d.to(xi.device, xi.dtype), pdf.to(xi.device, xi.dtype)

    def pdf(self, directions: Tensor, /) -> Tensor:
        """Return the density per steradian in directions.

        Parameters
        ----------
        directions : Tensor, shape (..., 3)
            World directions of any length.

        Returns
        -------
        pdf : Tensor, shape (...)
            0 outside the coverage; NaN for a direction that is zero or not finite.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.Distribution.pdf`.
        """
        given = in_float(directions, "directions").detach().cpu().numpy()
        found = torch.from_numpy(np.asarray(self._held.pdf(given)))
        return found.to(directions.device, directions.dtype)

    @property
    def integral(self) -> float:
        """∫ L dω of the luminance."""
        return self._held.integral

    def __repr__(self) -> str:
        return repr(self._held)
