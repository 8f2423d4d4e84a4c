"""Verbs of maps on arrays of other libraries: what comes out is of the same kind as what comes in.

An array that knows its namespace, as those of JAX and ndonnx, is computed by that namespace, where
it is, by the array API standard and printed code. One of dask's is computed chunk by chunk when it
is asked for, each as what it holds is: those of NumPy by the kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .compiled import compiled
from .spec import HELD, map_of, spec_of

if TYPE_CHECKING:
    from .._projection import Projection


def is_foreign(array: object) -> bool:
    """Tell whether an array is of a library that keeps the standard, or of dask, not NumPy's."""
    # A class has the attribute even where an object answers to every name.
    return not isinstance(array, (np.ndarray, np.generic)) and (
        hasattr(type(array), "__array_namespace__") or _is_chunked(array)
    )


def _is_chunked(array: object) -> bool:
    """Tell whether an array is one of dask's, which has no namespace of its own."""
    return all(hasattr(type(array), name) for name in ("map_blocks", "rechunk", "__dask_graph__"))


def run(verb: str, p: Projection, data: Any, name: str, out: object) -> Any:
    """Return what a verb makes of such an array."""
    if out is not None:
        raise TypeError("`out` is for arrays of NumPy.")
    spec = spec_of(p)
    width = 3 if verb == "encode" or p.layout == "faces" else 2
    if data.ndim == 0 or data.shape[-1] != width:
        raise ValueError(f"Expected `{name}` to have shape (..., {width}), got {data.shape}.")
    if _is_chunked(data):
        return _by_chunks(verb, p, data, name)
    xp = data.__array_namespace__()
    if not xp.isdtype(data.dtype, ("bool", "real floating", "integral")):
        raise TypeError(f"Expected `{name}` to hold real numbers, got {data.dtype}.")
    # Halves, which the standard has no name for, have less than three decimal digits.
    is_float = xp.isdtype(data.dtype, "real floating")
    double = not is_float or xp.finfo(data.dtype).bits == 64
    numbers = xp.astype(data, xp.float64 if double else xp.float32, copy=False)
    return _functions(spec, double)[verb](xp, numbers)


def _by_chunks(verb: str, p: Projection, data: Any, name: str) -> Any:
    """Return what a verb makes of an array of dask, which is computed when it is asked for."""
    # What the kernels say of this dtype, they say now.
    empty = np.empty((0, data.shape[-1]), data.dtype)
    like = getattr(_core.Projection, verb)(p, empty)
    whole = data.rechunk({data.ndim - 1: -1})
    tail = like.shape[1:]
    return whole.map_blocks(
        _of_chunk,
        verb,
        spec_of(p),
        name,
        dtype=like.dtype,
        chunks=(*whole.chunks[:-1], *((n,) for n in tail)),
        drop_axis=[] if tail else [data.ndim - 1],
        meta=np.empty((0,) * (data.ndim - 1 + len(tail)), like.dtype),
    )


def _of_chunk(chunk: Any, verb: str, spec: str, name: str) -> Any:
    p = map_of(spec)
    if is_foreign(chunk):
        return run(verb, p, chunk, name, None)
    return getattr(_core.Projection, verb)(p, chunk)


@lru_cache(HELD)
def _functions(spec: str, double: bool) -> dict[str, Callable[[Any, Any], Any]]:
    printed = compiled(spec, "array_api", double)

    def encode(xp: Any, directions: Any) -> Any:
        # What is printed takes unit vectors, and squares of the largest and smallest are none.
        largest = xp.max(xp.abs(directions), axis=-1, keepdims=True)
        known = xp.isfinite(largest) & (largest > 0)
        scaled = xp.where(known, directions, xp.ones_like(directions))
        scaled = scaled / xp.where(known, largest, xp.ones_like(largest))
        unit = scaled / xp.sqrt(xp.sum(scaled * scaled, axis=-1, keepdims=True))
        found = printed["encode"](unit)
        return xp.where(known, found, xp.full_like(found, xp.nan))

    def of_place(verb: str) -> Callable[[Any, Any], Any]:
        def verb_of(xp: Any, uv: Any) -> Any:
            found, valid = printed[verb](uv), printed["valid"](uv)
            if found.ndim > valid.ndim:
                valid = xp.expand_dims(valid, axis=-1)
            return xp.where(valid, found, xp.full_like(found, xp.nan))

        return verb_of

    return {"encode": encode, "decode": of_place("decode"), "density": of_place("density")}
