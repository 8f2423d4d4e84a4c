"""Importance sampling: directions drawn as often as an image is bright there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from .. import _core
from .._arrays import as_real, spatial_axes
from .._scalars import as_flag, as_text
from ..map.images import images
from ..map.named import resolve
from .image import as_light, coefficients, luminance_of, texel_weights

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
    from ..map.named import ProjectionLike

    Floats = NDArray[np.floating[Any]]

__all__ = ["Distribution"]


class Distribution:
    """A density on the sphere, proportional to the luminance of an image.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Linear radiance of dtype uint8, uint16, float16, float32 or float64. It is copied.
    projection : Projection or str
        As for `projection`.
    axes, rotation
        As for `encode`.
    luminance : array_like, shape (C,), optional
        How channels make luminance. By default BT.709's (0.2126, 0.7152, 0.0722) for RGB, the same
        for RGBA, and 1 for a single channel.
    compensate : bool
        Subtract the mean luminance before (and keep nothing below 0), for multiple importance
        sampling with a second technique that covers the sphere evenly [1]_. Then there are
        directions that are never drawn. A constant image stays as it is.
    skipna : bool
        Take NaN and infinite numbers for 0, where they would be an error.
    negative : {"clip", "raise"}
        What numbers below 0 count as: 0, or an error. No density is below 0, so that they cannot be
        kept here.
    any_aspect, channels_first : bool
        As for `convert`. What is drawn has its channels last.

    Raises
    ------
    ValueError
        For an image that is black, or holds NaN or infinite numbers (the message counts them and
        names the first positions), or has a shape that the projection cannot have; and for a batch,
        or many rotations: one distribution is of one image.
    TypeError
        For an unfit dtype.

    See Also
    --------
    lights : A fixed number of directional lights.

    Notes
    -----
    The density is constant per steradian within a texel: L / ∫ L dω, the solid angles exact. So
    ``pdf(d)`` is a ratio of sums and its integral over the sphere is 1; and where the integrand is
    the image itself, L/pdf is the same number for every sample. Texels across the rim of a disk
    count with the part that is covered.

    Samples come from inverting the marginal distribution of rows and that of columns within the
    row, so that a stratified or low-discrepancy `xi` gives stratified directions. Within a texel
    they are even by solid angle; that, the one approximation, is exact to 1e-5 of the density.
    Beside a rim or a crease samples are found by bisection, at some 1 to 10 µs each.

    References
    ----------
    .. [1] O. Karlík, M. Šik, P. Vévoda, T. Skřivan, J. Křivánek, "MIS Compensation: Optimizing
       Sampling Techniques in Multiple Importance Sampling", ACM Trans. Graph. 38(6), 2019.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.maximum(sm.directions("latlong", 64)[..., 1], 0)
    >>> dist = sm.light.Distribution(sky, "latlong")
    >>> d, pdf = dist.sample(np.random.default_rng(0).random((1000, 2)))
    >>> bool((d[:, 1] > 0).all()), bool(np.allclose(dist.pdf(d), pdf))
    (True, True)

    The estimate of ∫ max(y, 0) dω = π:

    >>> bool(abs((d[:, 1] / pdf).mean() - np.pi) < 0.01)
    True
    """

    __slots__ = ("_arguments", "_core")

    def __init__(
        self,
        image: ArrayLike,
        /,
        projection: ProjectionLike,
        *,
        axes: str | None = None,
        rotation: Any | None = None,
        luminance: ArrayLike | None = None,
        compensate: bool = False,
        skipna: bool = False,
        negative: Literal["clip", "raise"] = "clip",
        any_aspect: bool = False,
        channels_first: bool = False,
    ) -> None:
        p = resolve(projection, axes)
        several = images(
            image, p, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
        )
        if several is not None:
            if several.is_many:
                raise ValueError(
                    "One Distribution is of one image: [sm.light.Distribution(one, ...) for one in "
                    "images]."
                )
            image = several.array
        p = resolve(p, rotation=rotation)
        if as_text(negative, "negative") not in ("clip", "raise"):
            raise ValueError(f"Expected `negative` to be 'clip' or 'raise', got {negative!r}.")
        light = as_light(image, p, skipna=skipna, negative=negative)
        n = spatial_axes(p)
        weights = coefficients(light, n, luminance)
        density = luminance_of(light, n, weights)
        if as_flag(compensate, "compensate"):
            density = _compensated(density, texel_weights(p, density.shape))
        self._core = _core.Distribution(p, density, light)
        # What makes it again from a pickle.
        self._arguments = (_core_image(light, image), p, weights, compensate)

    @overload
    def sample(
        self,
        xi: ArrayLike,
        /,
        *,
        weights: Literal[False] = False,
        out: tuple[Floats | None, Floats | None] | None = None,
    ) -> tuple[Floats, Floats]: ...
    @overload
    def sample(
        self,
        xi: ArrayLike,
        /,
        *,
        weights: Literal[True],
        out: tuple[Floats | None, Floats | None, Floats | None] | None = None,
    ) -> tuple[Floats, Floats, Floats]: ...
    def sample(self, xi: Any, /, *, weights: bool = False, out: Any = None) -> Any:
        """Return directions and their density for numbers in [0, 1].

        Parameters
        ----------
        xi : array_like, shape (..., 2)
            Random or low-discrepancy numbers: the first decides on u, the second on v.
        weights : bool
            Return radiance / pdf as well.
        out : tuple of ndarray or None, optional
            Where to put the results, one for each.

        Returns
        -------
        directions : ndarray, shape (..., 3)
            Unit world directions; float32 for float16 and float32 input, else float64.
        pdf : ndarray, shape (...)
            Per steradian.
        weights : ndarray, shape (...) or (..., C)
            The image's channels in that texel over `pdf`; only if asked for.

        Raises
        ------
        ValueError, TypeError
            As for `encode`.

        Notes
        -----
        Pairs outside [0, 1] and NaN give NaN in all results. 0 and 1 themselves are fine.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> dist = sm.light.Distribution(np.ones((4, 8, 3), np.float32), "latlong")
        >>> d, pdf, w = dist.sample([0.5, 0.5], weights=True)
        >>> bool(np.isclose(pdf, 1 / (4 * np.pi))), np.round(w / (4 * np.pi), 6).tolist()
        (True, [1.0, 1.0, 1.0])
        """
        numbers = as_real(xi, "xi")
        wanted = 3 if as_flag(weights, "weights") else 2
        given: tuple[Any, ...] = (None,) * wanted if out is None else out
        if not isinstance(given, tuple) or len(given) != wanted:
            raise TypeError(f"Expected `out` to be a tuple of {wanted} arrays or None.")
        return self._core.sample(numbers, weights=weights, out=(*given, None)[:3])

    def pdf(self, directions: ArrayLike, /, *, out: Floats | None = None) -> Floats:
        """Return the density per steradian in directions.

        Parameters
        ----------
        directions : array_like, shape (..., 3)
            World directions of any length.
        out : ndarray, optional
            Where to put the result.

        Returns
        -------
        pdf : ndarray, shape (...)
            0 outside the coverage; NaN for a direction that is zero or not finite.

        Raises
        ------
        ValueError, TypeError
            As for `encode`.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> dist = sm.light.Distribution(np.ones((8, 8)), "matcap")
        >>> dist.pdf([[0, 0, 1], [0, 0, -1]]).round(6).tolist()
        [0.159155, 0.0]
        """
        return self._core.pdf(directions, out=out)

    @property
    def integral(self) -> float:
        """∫ L dω of the luminance (after compensation): what pdf × integral gives back."""
        return self._core.integral

    @property
    def projection(self) -> Projection:
        """The projection of the image, with its axes, turned by the rotation."""
        return self._arguments[1]

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the image, with its channels."""
        return self._arguments[0].shape

    def __repr__(self) -> str:
        return f"Distribution({self.shape}, {self.projection!r}, integral={self.integral:.6g})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, self._arguments


def _rebuild(
    image: NDArray[Any],
    projection: Projection,
    luminance: NDArray[np.float64],
    compensate: bool,
) -> Distribution:
    return Distribution(
        image, projection, luminance=luminance, compensate=compensate, any_aspect=True
    )


def _core_image(light: NDArray[Any], image: object) -> NDArray[Any]:
    """Return the array to keep: a copy where it is the caller's own."""
    return light.copy() if np.may_share_memory(light, np.asarray(image)) else light


def _compensated(
    luminance: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    mean = float(np.vdot(luminance, weights)) / float(weights.sum())
    above = np.maximum(luminance - mean, 0)
    # What rounding leaves above the mean of a constant image is no light.
    return above if float(np.vdot(above, weights)) > 1e-9 * mean else luminance
