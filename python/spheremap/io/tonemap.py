"""The way from light to a picture on a screen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np

from .. import _core
from .._arrays import as_array, as_real
from .._scalars import as_number, as_text
from .._srgb import encoded
from .._threads import on_all_threads

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["tonemap"]

Curve: TypeAlias = Literal["none", "reinhard"]
CURVES: tuple[str, ...] = get_args(Curve)
# Light that Reinhard's curve shows as white.
WHITE = 4.0
# Values in hand at once: what lies between the steps stays in the cache.
_BLOCK = 1 << 18


def tonemap(
    image: ArrayLike, *, exposure: float | None = 0.0, curve: Curve | str = "reinhard"
) -> NDArray[np.uint8]:
    """Turn linear light into an 8-bit picture for a screen.

    The curve is Reinhard's with a white point: y = x (1 + x/w²)/(1 + x) with w = 4, of each
    channel, then the sRGB transfer function.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C)
        Linear light. Of two channels the first is taken, of more than three the first three.
    exposure : float or None
        In stops: the light is multiplied by 2^exposure. None puts the geometric mean of the
        luminance at 0.18.
    curve : {"reinhard", "none"}
        With ``"none"`` light is clipped at 1.

    Returns
    -------
    picture : ndarray of uint8, shape (H, W), (H, W, 1) or (H, W, 3)
        NaN and negative values are black, infinity is white.

    Raises
    ------
    ValueError, TypeError
        For a curve that there is not, and an exposure that is no number. For uint8 and uint16,
        which are pictures: `to_linear` makes light of them.

    Examples
    --------
    >>> import numpy as np
    >>> from spheremap.io import tonemap
    >>> tonemap(np.array([[0.0, 0.18, 4.0, np.inf]])).tolist()
    [[0, 109, 255, 255]]
    >>> tonemap(np.array([[0.0, 0.18, 4.0, np.inf]]), curve="none").tolist()
    [[0, 118, 255, 255]]
    """
    _core.check_word("curve", as_text(curve, "curve"), list(CURVES))
    given = as_array(image, "image")
    if given.dtype.kind == "u" and given.dtype.itemsize <= 2:
        raise TypeError(
            f"Expected `image` to be linear light, got {given.dtype}: `io.to_linear` makes it."
        )
    values = as_real(given, "image")
    if values.ndim == 3 and values.shape[-1] != 1:
        values = values[..., : 3 if values.shape[-1] >= 3 else 1]
    if exposure is None:
        stops = _automatic_exposure(_light(values))
    else:
        stops = as_number(exposure, "exposure")
    if math.isnan(stops):
        raise ValueError("Expected `exposure` to be a number of stops, got NaN.")
    # Beyond these all light is white, or black.
    factor = np.float32(2.0 ** min(max(stops, -126.0), 126.0))

    picture = np.empty(values.shape, np.uint8)
    rows, shown = np.atleast_1d(values), np.atleast_1d(picture)
    count = max(1, _BLOCK // max(1, rows[:1].size))

    def show(first: int) -> None:
        block = slice(first, first + count)
        shown[block] = _shown(_light(rows[block]), factor, curve)

    on_all_threads(show, range(0, len(rows), count))
    return picture


def _light(values: NDArray[Any]) -> NDArray[np.float32]:
    # What float32 does not hold is white.
    with np.errstate(over="ignore"):
        light = np.asarray(values, np.float32)
    # Beyond this the curve is white whatever the exposure; it keeps infinity out of inf/inf.
    return np.clip(np.nan_to_num(light, nan=0.0, posinf=1e12, neginf=0.0), 0.0, 1e12)


def _shown(light: NDArray[np.float32], factor: np.float32, curve: str) -> NDArray[np.uint8]:
    with np.errstate(over="ignore"):
        light = np.minimum(light * factor, 1e12)
    if curve == "reinhard":
        light = light * (1.0 + light / WHITE**2) / (1.0 + light)
    return np.asarray(np.rint(encoded(np.minimum(light, 1.0)) * 255.0), np.uint8)


def _automatic_exposure(light: NDArray[np.float32]) -> float:
    brightness = light if light.ndim == 2 else light.mean(axis=-1)
    lit = brightness[brightness > 0]
    if lit.size == 0:
        return 0.0
    return float(np.log2(0.18) - np.mean(np.log2(lit), dtype=np.float64))
