"""One gain a view, so that neighbors are as bright where both see.

Source: Brown & Lowe 2007, Automatic Panoramic Image Stitching using Invariant Features, section 6,
with the logarithm of each overlap's ratio, which needs no prior to keep gains from zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from .._progress import counted, part
from .._scalars import as_text
from .._srgb import decoded, encoded
from .._threads import on_all_threads
from ..map.named import resolve
from ..resample import convert
from .pictures import blocks, exact, pictures_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .pictures import Cameras, Picture

    Array = NDArray[np.float64]
    Curve: TypeAlias = Literal["srgb", "linear"]

__all__ = ["Curve", "coded", "gains", "gains_of", "light_of_codes"]

# Rows of the panorama in which overlaps are compared.
COMPARED = 256
# Below this part of the sphere two views see nothing in common that would say anything.
LEAST_OVERLAP = 1e-5


def gains(
    images: Sequence[ArrayLike] | NDArray[Any],
    cameras: Cameras,
    /,
    *,
    curve: Curve = "srgb",
    masks: Sequence[ArrayLike | None] | None = None,
    fov: float | Sequence[float] | None = None,
    any_aspect: bool = False,
) -> NDArray[np.float64]:
    """Return what makes each picture as bright as its neighbors where both see.

    Parameters
    ----------
    images, cameras, curve, masks, fov, any_aspect
        As for `stitch`.

    Returns
    -------
    gains : ndarray, shape (n,)
        By which the light of each picture is to be multiplied. Their geometric mean is 1, of all
        and of each group of views that is joined by overlaps.

    Raises
    ------
    ValueError, TypeError
        As for `stitch`.

    Notes
    -----
    Two views' light is summed where both see, in a latlong of 256 rows, by solid angle and by the
    smaller of their weights; integers at the end of their range are left out. Least are the
    squares of what the logarithms of the gains leave of the logarithms of the sums' ratios, each
    counted by its overlap. It is what [1]_ makes least, in logarithms.

    .. [1] Brown and Lowe 2007, Automatic Panoramic Image Stitching using Invariant Features, 6.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> rig = sm.cameras.rig(64, n=8)
    >>> views = rig.convert(np.ones((64, 128)), "latlong")
    >>> views[2] *= 2
    >>> found = sm.cameras.gains(views, rig)
    >>> bool(np.allclose(found[0] / found[2], 2))
    True
    """
    with part(0, 0.2):
        pictures, _ = pictures_of(images, cameras, masks, fov, any_aspect)
    with part(0.2, 1):
        return gains_of(pictures, expect_curve(curve))


def expect_curve(curve: object) -> str:
    """Return the name of a curve, or raise."""
    if as_text(curve, "curve") not in ("srgb", "linear"):
        raise ValueError(f"Expected `curve` to be 'srgb' or 'linear', got {curve!r}.")
    return str(curve)


def gains_of(pictures: list[Picture], curve: str) -> Array:
    """Return the gains of pictures whose integers are coded so."""
    latlong = resolve("latlong")
    area = np.asarray(latlong.solid_angle(COMPARED))
    lights, weights = [], []
    for picture in counted(pictures):
        small = convert(
            _seen_light(picture, curve), picture.camera, latlong, size=COMPARED, any_aspect=True
        )
        light, seen, weight = np.moveaxis(small.astype(np.float64), -1, 0)
        lights.append(np.divide(light, seen, out=np.zeros_like(light), where=seen > 0))
        weights.append(weight)
    count = len(pictures)
    parts, ratios = np.zeros((count, count)), np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            parts[i, j], ratios[i, j] = _overlap(lights[i], lights[j], weights[i], weights[j], area)
    return _least_squares(parts, ratios)


def _seen_light(picture: Picture, curve: str) -> NDArray[Any]:
    """Return the light of a picture where it says something, whether it does, and its weights.

    Light is not weighted: of a texel where weights rise it would be that of their side.
    """
    pixels = picture.pixels
    height, width = pixels.shape[:2]
    found = np.empty((height, width, 3), exact(pixels.dtype))
    codes = light_of_codes(pixels.dtype, curve) if pixels.dtype.kind == "u" else None

    def work(rows: slice) -> None:
        weight = picture.weights.rows(rows.start, rows.stop)
        part = pixels[rows]
        if codes is None:
            known = np.isfinite(part).all(axis=-1)
            part = np.where(known[..., None], part, 0)
        else:
            # What is as bright as can be may be brighter.
            known = (part != np.iinfo(part.dtype).max).all(axis=-1)
            part = codes[part]
        known &= weight > 0
        found[rows, :, 0] = part.sum(axis=-1, dtype=found.dtype) * known
        found[rows, :, 1] = known
        found[rows, :, 2] = weight * known

    on_all_threads(work, blocks(height, pixels[0].size))
    return found


def light_of_codes(dtype: np.dtype[Any], curve: str) -> NDArray[np.float32]:
    """Return the light of each integer, from 0 to 1."""
    most = np.iinfo(dtype).max
    values = np.arange(most + 1) / most
    return np.asarray(decoded(values) if curve == "srgb" else values, np.float32)


def coded(dtype: np.dtype[Any], curve: str, gain: float) -> NDArray[np.float32]:
    """Return what each integer becomes where its light is multiplied; it may be beyond the last."""
    most = np.iinfo(dtype).max
    values = np.arange(most + 1) / most
    found = encoded(gain * decoded(values)) if curve == "srgb" else gain * values
    return np.asarray(found * most, np.float32)


def _overlap(a: Array, b: Array, wa: Array, wb: Array, area: Array) -> tuple[float, float]:
    """Return which part of the sphere two views share, and the logarithm of a's light to b's."""
    shared = np.where((wa > 0) & (wb > 0), area, 0)
    part = float(shared.sum() / area.sum())
    if part < LEAST_OVERLAP:
        return 0.0, 0.0
    # Where one of them is about to end, little of a texel is seen.
    trust = shared * np.minimum(wa, wb)
    light_a, light_b = float((trust * a).sum()), float((trust * b).sum())
    if not (light_a > 0 and light_b > 0):
        return 0.0, 0.0
    return part, float(np.log(light_a / light_b))


def _least_squares(parts: Array, ratios: Array) -> Array:
    """Return the gains g that make Σ part (ln gᵢ − ln gⱼ + ratioᵢⱼ)² least.

    Of those that do, the ones whose geometric mean is 1, of all views and of each group that is
    joined by overlaps: the solution of least norm.
    """
    count = len(parts)
    rows, values = [], []
    for i in range(count):
        for j in range(i):
            if parts[i, j] > 0:
                root = np.sqrt(parts[i, j])
                row = np.zeros(count)
                row[i], row[j] = root, -root
                rows.append(row)
                values.append(-root * ratios[i, j])
    if not rows:
        return np.ones(count)
    logs = np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)[0]
    return np.asarray(np.exp(logs - logs.mean()))
