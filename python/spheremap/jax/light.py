"""Light of arrays of JAX: irradiance, and directions drawn as often as an image is bright there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from .. import light
from ..map.spec import map_of, spec_of
from ..resample import linear
from . import sh
from ._given import in_float, is_known, vectors
from .images import channels_last

if TYPE_CHECKING:
    from .._arrays import Size
    from ..map.named import ProjectionLike

__all__ = ["Distribution", "irradiance"]


def irradiance(
    image: Any,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size = 32,
    rotation: Any | None = None,
    order: int = 8,
    world: str = "match",
    any_aspect: bool = False,
) -> jax.Array:
    """Return the irradiance of a surface for every normal, by spherical harmonics.

    Parameters
    ----------
    image : Array
        Radiance, as for `spheremap.jax.sample`.
    src, dst, size, world, any_aspect
        As for `spheremap.light.irradiance`.
    rotation : Array, array_like or an object with ``.as_matrix()``, optional
        Turns the content in the world. Gradients flow to an array of JAX.
    order : int
        The highest degree. The bound of the error is that of ``method="sh"`` there.

    Returns
    -------
    irradiance : Array
        With the batch, channels and dtype of the image. 0 outside the valid image of `dst`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.light.irradiance`.

    Examples
    --------
    >>> import jax.numpy as jnp, spheremap.jax as smj
    >>> e = smj.light.irradiance(jnp.ones((3, 32, 64)), "latlong", "cube", size=8)
    >>> e.shape, round(float(e.mean() / jnp.pi), 5)
    ((6, 3, 8, 8), 1.0)
    """
    data = in_float(image, "image")
    source, grid = linear.turned_grid(src, dst, size, data.shape, world, any_aspect)
    found = sh.project(data, map_of(source), order=order, rotation=rotation, any_aspect=any_aspect)
    d = jnp.asarray(grid, data.dtype)
    values = sh.evaluate(sh.convolve(found, lobe="cosine"), d)
    # Normals that there are none of.
    kept = jnp.where(jnp.isnan(d).any(-1), 0.0, values)
    extra = kept.ndim - grid.ndim + 1
    made = jnp.moveaxis(kept, extra - 1, -3) if extra and grid.ndim == 4 else kept
    return made.astype(jnp.asarray(image).dtype)


class Distribution:
    """A density on the sphere, proportional to the luminance of an image.

    Parameters
    ----------
    image : Array, shape (H, W) or (C, H, W), or with faces (F, S, S) or (F, C, S, S)
        Linear radiance.
    projection, axes, luminance, any_aspect
        As for `spheremap.light.Distribution`.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.light.Distribution`. Of an image that a program is given, what is wrong
        with its numbers is said when it runs, as an error of JAX.

    Notes
    -----
    Neither what is drawn nor its density has a gradient: in an estimator they are what is divided
    by, and a step in the image moves no sample. To JAX they are constants.

    The kernels are called from the program. Of an image that the program is given, an argument of
    what `jit`, `grad` or `vmap` take, each call of `sample` and `pdf` prepares it anew: make it
    outside where that can be.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, spheremap.jax as smj
    >>> sky = jnp.maximum(smj.directions("latlong", 32)[..., 1], 0)
    >>> drawn = smj.light.Distribution(sky, "latlong")
    >>> d, pdf = jax.jit(drawn.sample)(jax.random.uniform(jax.random.key(0), (100, 2)))
    >>> bool((d[:, 1] > 0).all()), bool(jnp.allclose(drawn.pdf(d), pdf, rtol=1e-4))
    (True, True)
    """

    def __init__(
        self,
        image: Any,
        /,
        projection: ProjectionLike,
        *,
        axes: str | None = None,
        luminance: Any | None = None,
        any_aspect: bool = False,
    ) -> None:
        data = in_float(image, "image")
        p = map_of(spec_of(projection, axes, None))
        count = linear.image_axes(spec_of(p), data.shape, any_aspect)
        if data.ndim > count + 1:
            raise ValueError("One Distribution is of one image: make one of each.")
        last, _ = channels_last(data, count)
        # Where only a gradient is asked for, it is known again.
        self._image = jax.lax.stop_gradient(last)

        self._map, self._luminance, self._any_aspect = p, luminance, any_aspect
        # What is wrong with the rest is said now, and not by a running program.
        image = self._image
        self._held = self._made(image if is_known(image) else np.ones(last.shape, last.dtype))

    def _made(self, image: Any) -> light.Distribution:
        return light.Distribution(
            np.asarray(image), self._map, luminance=self._luminance, any_aspect=self._any_aspect
        )

    def sample(self, xi: Any, /) -> tuple[jax.Array, jax.Array]:
        """Return directions and their density for numbers in [0, 1].

        Parameters
        ----------
        xi : Array, shape (..., 2)
            Random or low-discrepancy numbers.

        Returns
        -------
        directions : Array, shape (..., 3)
            Unit world directions, of the dtype of `xi`.
        pdf : Array, shape (...)
            Per steradian.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.Distribution.sample`. What is wrong with a number is said when a
            program runs, as an error of JAX.
        """
        data = vectors(xi, 2, "xi")
        lead = data.shape[:-1]
        shapes = [(*lead, 3), lead]
        d, pdf = self._asked(lambda held, xi: held.sample(xi), data, shapes)
        dtype = jnp.asarray(xi).dtype
        return d.astype(dtype), pdf.astype(dtype)

    def pdf(self, directions: Any, /) -> jax.Array:
        """Return the density per steradian in directions.

        Parameters
        ----------
        directions : Array, shape (..., 3)
            World directions of any length.

        Returns
        -------
        pdf : Array, shape (...)
            0 outside the coverage; NaN for a direction that is zero or not finite.

        Raises
        ------
        ValueError, TypeError
            As for `spheremap.light.Distribution.pdf`.
        """
        data = vectors(directions, 3, "directions")
        (found,) = self._asked(lambda held, d: (held.pdf(d),), data, [data.shape[:-1]])
        return found.astype(jnp.asarray(directions).dtype)

    def _asked(
        self, verb: Callable[[light.Distribution, Any], Any], data: jax.Array, shapes: Any
    ) -> tuple[jax.Array, ...]:
        """Return what a verb makes of numbers: of these shapes, and of their dtype."""
        axes = self._image.ndim
        results = tuple(jax.ShapeDtypeStruct(shape, data.dtype) for shape in shapes)

        def of_one(given: Any) -> Any:
            return tuple(
                np.asarray(part, data.dtype) for part in verb(self._held, np.asarray(given))
            )

        def of_each(image: Any, given: Any) -> Any:
            """Of an image that `vmap` may have put axes before, as before the numbers."""
            images, numbers = np.asarray(image), np.asarray(given)
            lead = images.shape[: images.ndim - axes]
            if all(n == 1 for n in lead):
                held = self._made(images.reshape(images.shape[len(lead) :]))
                return tuple(np.asarray(part, data.dtype) for part in verb(held, numbers))
            shape = np.broadcast_shapes(lead, numbers.shape[: len(lead)])
            several = np.broadcast_to(images, (*shape, *images.shape[len(lead) :]))
            each = np.broadcast_to(numbers, (*shape, *numbers.shape[len(lead) :]))
            found = [verb(self._made(several[k]), each[k]) for k in np.ndindex(shape)]
            parts = zip(*found, strict=True)
            stacked = (np.stack(part) for part in parts)
            return tuple(one.reshape(*shape, *one.shape[1:]).astype(data.dtype) for one in stacked)

        numbers = jax.lax.stop_gradient(data)
        if not is_known(self._image):
            both = (self._image, numbers)
            return tuple(jax.pure_callback(of_each, results, *both, vmap_method="expand_dims"))
        if is_known(numbers):
            return tuple(jnp.asarray(part) for part in of_one(numbers))
        return tuple(jax.pure_callback(of_one, results, numbers, vmap_method="expand_dims"))

    @property
    def integral(self) -> float:
        """∫ L dω of the luminance."""
        if not is_known(self._image):
            raise TypeError("`integral` is of an image that is known when a program is traced.")
        return self._held.integral

    def __repr__(self) -> str:
        return repr(self._held) if is_known(self._image) else "Distribution(of a traced image)"
