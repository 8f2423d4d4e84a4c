"""How much light a metal reflects, by its name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .._arrays import as_array
from .._scalars import as_text

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

# Complex indices n + ik for red, green and blue, as Intel's OSPRay prints them in its documentation
# of the metal material, from the measurements that refractiveindex.info collects.
METALS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "Ag": ((0.051, 0.043, 0.041), (5.3, 3.6, 2.3)),
    "Al": ((1.5, 0.98, 0.6), (7.6, 6.6, 5.4)),
    "Au": ((0.07, 0.37, 1.5), (3.7, 2.3, 1.7)),
    "Cr": ((3.2, 3.1, 2.3), (3.3, 3.3, 3.1)),
    "Cu": ((0.1, 0.8, 1.1), (3.5, 2.5, 2.4)),
}


def fresnel(cosine: NDArray[np.float64], metal: str) -> NDArray[np.float64]:
    """Return the reflectance of unpolarized light for red, green and blue, shape (..., 3).

    Fresnel's equations for a conductor: Born and Wolf, Principles of Optics, section 14.2.
    """
    try:
        n, k = (np.array(x) for x in METALS[as_text(metal, "metal")])
    except KeyError:
        raise ValueError(f"unknown metal {metal!r}; there are {', '.join(METALS)}") from None
    c = np.clip(cosine, 0, 1)[..., None]
    index = n + 1j * k
    # The cosine inside, times the index.
    inside = np.sqrt(index**2 - (1 - c * c))
    with np.errstate(invalid="ignore"):  # of what is beside the ball
        s = np.abs((c - inside) / (c + inside)) ** 2
        p = np.abs((index**2 * c - inside) / (index**2 * c + inside)) ** 2
    return np.asarray((s + p) / 2, np.float64)


def reflectance_of(
    reflectance: ArrayLike, metal: str | None, channels: int
) -> tuple[NDArray[np.float64], str | None]:
    """Return the reflectance of each channel, checked, and the metal."""
    array = as_array(reflectance, "reflectance")
    if array.dtype.kind not in "fiu":
        raise TypeError(f"Expected `reflectance` to be real numbers, got dtype {array.dtype}.")
    if array.shape not in ((), (1,), (channels,)):
        raise ValueError(
            f"Expected `reflectance` to be one number or {channels}, got shape {array.shape}."
        )
    if not (np.all(array > 0) and np.all(np.isfinite(array))):
        raise ValueError(f"`reflectance` must be finite and above 0, got {array.tolist()}.")
    if metal is not None:
        fresnel(np.ones(1), metal)
        if channels != 3:
            raise ValueError(f"`metal` is known for red, green and blue; got {channels} channels.")
    return np.broadcast_to(array, (channels,)).astype(np.float64), metal
