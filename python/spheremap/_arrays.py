"""What the core calls for input that it cannot read as it stands.

The core reads C-contiguous native arrays itself. Everything else (lists, float16, other byte
orders, views with strides ...) comes here, once a call.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

IMAGE_DTYPES = ("uint8", "uint16", "float16", "float32", "float64")


def as_real(obj: object, name: str) -> NDArray[np.floating[Any]]:
    """Return `obj` as a C-contiguous, aligned, native float32 or float64 array."""
    array = _as_array(obj, name)
    dtype = array.dtype
    if dtype.kind == "f":
        target = np.float32 if dtype.itemsize <= 4 else np.float64
    elif dtype.kind in "iub":
        target = np.float64
    else:
        raise TypeError(f"Expected `{name}` to be real numbers, got dtype {dtype}.")
    # A long double beyond float64 becomes infinity, which the core answers with NaN; a warning
    # would be the only difference between it and any other infinite input.
    with np.errstate(over="ignore"):
        return np.require(array, dtype=target, requirements=["C", "A"])


def as_image(obj: object) -> NDArray[Any]:
    """Return `obj` as a C-contiguous, aligned, native image of a supported dtype."""
    array = _as_array(obj, "image")
    if array.dtype.name not in IMAGE_DTYPES:
        *most, last = IMAGE_DTYPES
        raise TypeError(
            f"Expected `image` to have dtype {', '.join(most)} or {last}, got {array.dtype}."
        )
    native = array.dtype.newbyteorder("=")
    return np.require(array, dtype=native, requirements=["C", "A"])


def as_rotation(obj: object) -> NDArray[np.float64]:
    """Return a matrix, or what `obj.as_matrix()` gives, as a float64 array of shape (3, 3).

    The core checks that it is a rotation.
    """
    as_matrix = getattr(obj, "as_matrix", None)
    matrix = as_real(obj if as_matrix is None else as_matrix(), "rotation")
    if matrix.shape != (3, 3):
        raise ValueError(f"Expected `rotation` to have shape (3, 3), got {matrix.shape}.")
    return np.require(matrix, dtype=np.float64, requirements=["C", "A"])


def _as_array(obj: object, name: str) -> NDArray[Any]:
    try:
        return np.asarray(obj)
    except ValueError as error:
        raise ValueError(f"Expected `{name}` to be an array of numbers: {error}") from None


def as_pair(
    view: object, normal: object
) -> tuple[NDArray[np.floating[Any]], NDArray[np.floating[Any]]]:
    """Return both as arrays of one real dtype and one shape, by numpy's broadcasting."""
    a, b = as_real(view, "view"), as_real(normal, "normal")
    for array, name in ((a, "view"), (b, "normal")):
        if array.shape[-1:] != (3,):
            raise ValueError(f"Expected `{name}` to have shape (..., 3), got {array.shape}.")
    dtype = np.result_type(a, b)
    shape = np.broadcast_shapes(a.shape, b.shape)
    if a.shape not in (shape, (3,)):
        a = np.broadcast_to(a, shape)
    if b.shape not in (shape, (3,)):
        b = np.broadcast_to(b, shape)
    return (
        np.require(a, dtype=dtype, requirements=["C", "A"]),
        np.require(b, dtype=dtype, requirements=["C", "A"]),
    )
