"""A calibrated camera as a projection: K in pixels, coefficients as other programs write them."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from .._arrays import as_doubles
from .._scalars import as_text, as_whole
from .named import made, registered

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from .._projection import Projection

__all__ = ["COEFFICIENTS", "PIXEL_CENTER", "CameraModel", "camera", "matrix"]

CameraModel: TypeAlias = Literal[
    "pinhole",
    "brown_conrady",
    "kannala_brandt",
    "unified",
    "omnidirectional",
    "double_sphere",
    "eucm",
    "fov",
    "thin_prism_fisheye",
    "rad_tan_thin_prism_fisheye",
]

# In the order of `distortion`, and how many of them may be left out at the end.
COEFFICIENTS: dict[str, tuple[tuple[str, ...], tuple[int, ...]]] = {
    "pinhole": ((), (0,)),
    "brown_conrady": (
        (
            *("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
            *("s1", "s2", "s3", "s4", "tau_x", "tau_y"),
        ),
        (0, 4, 5, 8, 12, 14),
    ),
    "kannala_brandt": (("k1", "k2", "k3", "k4"), (0, 4)),
    "unified": (("xi", "k1", "k2", "p1", "p2"), (1, 5)),
    "omnidirectional": (("xi", "k1", "k2", "p1", "p2"), (1, 5)),
    "double_sphere": (("xi", "alpha"), (2,)),
    "eucm": (("alpha", "beta"), (2,)),
    "fov": (("omega",), (1,)),
    "thin_prism_fisheye": (("k1", "k2", "p1", "p2", "k3", "k4", "s1", "s2"), (8,)),
    "rad_tan_thin_prism_fisheye": (
        ("k0", "k1", "k2", "k3", "k4", "k5", "p0", "p1", "s0", "s1", "s2", "s3"),
        (12,),
    ),
}
# OpenCV's name of what the paper calls unified.
FORMULAS = {"omnidirectional": "unified"}
# What other programs call these models.
ELSEWHERE = {
    "perspective": "pinhole",
    "opencv": "brown_conrady",
    "radtan": "brown_conrady",
    "plumb_bob": "brown_conrady",
    "rational_polynomial": "brown_conrady",
    "fisheye": "kannala_brandt",
    "opencv_fisheye": "kannala_brandt",
    "equidistant": "kannala_brandt",
    "equi": "kannala_brandt",
    "kb": "kannala_brandt",
    "kb4": "kannala_brandt",
    "mei": "unified",
    "omni": "unified",
    "omnidir": "omnidirectional",
    "ds": "double_sphere",
    "fisheye624": "rad_tan_thin_prism_fisheye",
}

# Where the center of the first pixel is counted: whole numbers are centers.
PIXEL_CENTER = 0.5
# What is left of no skew, of fx, where K is a product or was solved for: rounding times the
# condition. It moves what is as far from the middle as fx by a billionth of that.
SKEW = 1e-9


def camera(
    K: ArrayLike,
    /,
    size: Sequence[int],
    *,
    distortion: ArrayLike | None = None,
    model: CameraModel = "pinhole",
) -> Projection:
    """Return the projection of a calibrated camera.

    Its image is the sensor's whole rectangle, and pixels count as OpenCV counts them: **the center
    of a pixel has whole numbers**, the first (0, 0), so that u = (x + 1/2)/W. Its directions are
    in OpenCV's axes, +x right, +y down, +z forward; `convert` matches them with other worlds, and
    `Projection.turned` gives the camera a pose. Where the model turns back, or has no inverse,
    coordinates are NaN.

    Parameters
    ----------
    K : array_like, shape (3, 3) or (4,)
        The camera matrix, or fx, fy, cx, cy, in pixels. A skew is not known, but as rounding. fx
        is at most 20 widths of the image and fy 20 heights: a field of 2.86°. Narrower ones without
        distortion, those of telescopes, are ``sm.projection("perspective", fov=0.57)``. The
        principal point is at most two widths and heights from the middle.
    size : tuple of int
        Height and width of the images that K is for, in pixels, at most 20 times as wide as high.
        The projection holds at every size.
    distortion : array_like, optional
        The model's coefficients in the order of OpenCV or of the model's paper:

        - ``"pinhole"``: none.
        - ``"brown_conrady"``: k1, k2, p1, p2[, k3[, k4, k5, k6[, s1, s2, s3, s4[, tau_x,
          tau_y]]]]], `distCoeffs` of OpenCV's ``calibrateCamera``; the tilt of the sensor is in
          radians.
        - ``"kannala_brandt"``: k1, k2, k3, k4, D of ``cv2.fisheye``.
        - ``"unified"``, OpenCV's ``"omnidirectional"``: xi[, k1, k2, p1, p2], xi and D of
          ``cv2.omnidir``.
        - ``"double_sphere"``: xi, alpha.
        - ``"eucm"``: alpha, beta.
        - ``"fov"``: omega, in radians.
        - ``"thin_prism_fisheye"``: k1, k2, p1, p2, k3, k4, sx1, sy1 of COLMAP.
        - ``"rad_tan_thin_prism_fisheye"``: k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3 of
          COLMAP.
    model : str, optional
        One of these.

    Returns
    -------
    Projection
        One of ``"camera_pinhole"``, ``"camera_brown_conrady"`` ..., whose parameters are K in
        image widths and heights, with the principal point from the image's middle.

    Raises
    ------
    ValueError, TypeError
        For an unknown model, another count of coefficients, a skew, or numbers out of range.

    Warns
    -----
    UserWarning
        Where the principal point is near the middle of the image only if `size` is width and
        height.

    Notes
    -----
    Formulas: [1]_, [2]_, [3]_, [4]_, [5]_, [6]_, [7]_, [8]_, [9]_, [10]_.

    .. [1] Hartley and Zisserman 2004, Multiple View Geometry, section 6.1.
    .. [2] Brown 1966, Decentering Distortion of Lenses, in OpenCV's letters.
    .. [3] Kannala and Brandt 2006, A Generic Camera Model and Calibration Method, eq. 6.
    .. [4] Mei and Rives 2007, Single View Point Omnidirectional Camera Calibration.
    .. [5] Usenko, Demmel and Cremers 2018, The Double Sphere Camera Model.
    .. [6] Khomutenko, Garcia and Martinet 2016, An Enhanced Unified Camera Model.
    .. [7] Devernay and Faugeras 2001, Straight Lines Have to Be Straight, eq. 13 and 14.
    .. [8] Weng, Cohen and Herniou 1992, Camera Calibration with Distortion Models and Accuracy
       Evaluation: thin prisms; COLMAP's THIN_PRISM_FISHEYE.
    .. [9] Louhichi, Fournel, Lavest and Ben Aissia 2007, Self-calibration of Scheimpflug Cameras:
       the tilt, as OpenCV's CALIB_TILTED_MODEL has it.
    .. [10] Project Aria, Camera Intrinsic Models, Fisheye624: COLMAP's
       RAD_TAN_THIN_PRISM_FISHEYE.

    Examples
    --------
    >>> import spheremap as sm
    >>> K = [[900, 0, 639.5], [0, 900, 359.5], [0, 0, 1]]
    >>> camera = sm.camera(K, (720, 1280), distortion=[-0.2, 0.05, 0, 0], model="brown_conrady")
    >>> camera.encode([0.0, 0.0, 1.0]).tolist()
    [0.5, 0.5]

    The pixel of a direction, in OpenCV's count:

    >>> d = [0.3, 0.1, 1.0]
    >>> sm.directions_to_pixels(d, camera, (720, 1280), centers="integer").round(3).tolist()
    [904.235, 447.745]
    """
    if as_text(model, "model") not in COEFFICIENTS:
        here = ELSEWHERE.get(model.lower())
        raise ValueError(
            f"Expected `model` to be one of {', '.join(COEFFICIENTS)}, got {model!r}"
            + (f"; here it is {here!r}." if here else ".")
        )
    fx, fy, cx, cy = _pixels(K)
    height, width = _shape(size)
    if _is_middle(cx, height, cy, width) and not _is_middle(cx, width, cy, height):
        warnings.warn(
            f"`size` is height and width, got {(height, width)}, and the principal point "
            f"({cx:g}, {cy:g}) is near the middle of {height} x {width} pixels; did you mean "
            f"{(width, height)}?",
            stacklevel=2,
        )
    names, counts = COEFFICIENTS[model]
    given = np.zeros(0) if distortion is None else as_doubles(distortion, "distortion").ravel()
    if len(given) not in counts:
        wanted = " or ".join(map(str, counts))
        listed = f" ({', '.join(names)})" if names else ""
        hint = (
            "; those of OpenCV's `calibrateCamera` are of `model` 'brown_conrady', those of its "
            "`fisheye` of 'kannala_brandt'."
            if model == "pinhole"
            else "."
        )
        raise ValueError(
            f"Expected `distortion` of {model!r} to have {wanted} numbers{listed}, "
            f"got {len(given)}{hint}"
        )
    coefficients: dict[str, Any] = {name: float(c) for name, c in zip(names, given, strict=False)}
    name = f"camera_{FORMULAS.get(model, model)}"
    try:
        return made(
            name,
            axes="+x +y +z",
            world="+x -y +z",
            fx=fx / width,
            fy=fy / height,
            cx=(cx + PIXEL_CENTER) / width - 0.5,
            cy=(cy + PIXEL_CENTER) / height - 0.5,
            aspect=width / height,
            **coefficients,
        )
    except ValueError as error:
        told = _out_of_range(name, (fx, fy, cx, cy), height, width)
        raise error if told is None else ValueError(told) from None


def matrix(camera: Projection, size: tuple[int, int]) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy in pixels of a camera's images of this height and width."""
    height, width = size
    p = camera.parameters
    return (
        p["fx"] * width,
        p["fy"] * height,
        (p["cx"] + 0.5) * width - PIXEL_CENTER,
        (p["cy"] + 0.5) * height - PIXEL_CENTER,
    )


def _is_middle(cx: float, width: int, cy: float, height: int) -> bool:
    """Tell whether a principal point is as near to the middle as most lenses have it."""
    return abs(cx / width - 0.5) < 0.1 and abs(cy / height - 0.5) < 0.1


def _out_of_range(name: str, k: tuple[float, ...], height: int, width: int) -> str | None:
    """Say in pixels what is out of range in K or the size; None where these are not to blame."""
    row = next(row for row in registered() if row["name"] == name)
    most = {parameter["name"]: parameter["maximum"] for parameter in row["parameters"]}
    fx, fy, cx, cy = k
    across, down = (width, "width"), (height, "height")
    told = (
        _focal_out_of_range("fx", fx, most["fx"], *across)
        or _focal_out_of_range("fy", fy, most["fy"], *down)
        or _center_out_of_range("cx", cx, most["cx"], *across)
        or _center_out_of_range("cy", cy, most["cy"], *down)
    )
    if told is None and width > most["aspect"] * height:
        wide = f"{most['aspect']:g} times as wide as high"
        return f"Expected `size` to be at most {wide}, got {(height, width)}."
    return told


def _focal_out_of_range(
    name: str, focal: float, times: float, pixels: int, side: str
) -> str | None:
    if not focal > 0:
        return f"Expected `{name}` of `K` to be a positive number of pixels, got {focal:g}."
    if focal <= times * pixels:
        return None
    narrowest = math.degrees(2 * math.atan(1 / (2 * times)))
    return (
        f"Expected `{name}` of `K` to be at most {times * pixels:.12g} pixels, {times:g} times the "
        f"image's {side} of {pixels}, where a pinhole's field is {narrowest:.2f}°, "
        f"got {focal:.12g}; narrower fields are of 'perspective(fov=...)'."
    )


def _center_out_of_range(
    name: str, center: float, times: float, pixels: int, side: str
) -> str | None:
    middle = pixels / 2 - PIXEL_CENTER
    if abs(center - middle) <= times * pixels:
        return None
    return (
        f"Expected `{name}` of `K` to be at most {times * pixels:.12g} pixels, {times:g} times the "
        f"image's {side}, from its middle at {middle:.12g}, got {center:.12g}."
    )


def _pixels(given: Any) -> tuple[float, ...]:
    k = as_doubles(given, "K")
    if k.shape == (4,):
        return tuple(k.tolist())
    if k.shape != (3, 3):
        raise ValueError(f"Expected `K` to have shape (3, 3) or (4,), got {k.shape}.")
    if not abs(k[0, 1]) <= SKEW * abs(k[0, 0]):
        raise ValueError(f"Expected `K` to have no skew, got {k[0, 1]:g} in its first row.")
    if k[1, 0] != 0 or k[2].tolist() != [0, 0, 1]:
        raise ValueError(
            "Expected `K` to be fx, 0, cx; 0, fy, cy; 0, 0, 1, got other numbers in its lower rows."
        )
    return float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2])


def _shape(size: Any) -> tuple[int, int]:
    try:
        height, width = (as_whole(n, "size") for n in size)
    except (TypeError, ValueError):
        raise TypeError("Expected `size` to be a height and a width, two whole numbers.") from None
    if min(height, width) < 1:
        raise ValueError(f"Expected `size` to be positive, got {(height, width)}.")
    return height, width
