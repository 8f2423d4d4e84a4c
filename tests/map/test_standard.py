"""Verbs of maps on arrays that keep the array API standard, held to it by array-api-strict, and on
those of dask."""

from __future__ import annotations

from typing import Any

import array_api_strict as xp
import dask.array as da
import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from printed import CASES, VERBS, Array, assert_alike, made

DTYPES = pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])


def as_numpy(array: Any) -> Array:
    return np.from_dlpack(array)


@pytest.mark.runs("array_api", language="array_api")
@DTYPES
@pytest.mark.parametrize("case", CASES)
def test_printed_code_has_the_bits_of_the_library(case: str, dtype: type) -> None:
    """NumPy is below: operations are rounded one by one, and powers of two are exact."""
    p = made(case)
    names: dict[str, Any] = {}
    exec(sm.code(p, "array_api", verbs=VERBS, name="m", dtype=dtype.__name__), names)

    def verb(name: str, data: Array) -> Array:
        with np.errstate(all="ignore"):
            out = as_numpy(names[f"m_{name}"](xp.asarray(data)))
        assert out.dtype == (bool if name == "valid" else dtype)
        return np.swapaxes(out, -1, -2).reshape(-1, 6) if name == "jacobian" else out

    assert_alike(p, dtype, verb)


@DTYPES
@pytest.mark.parametrize("case", CASES)
def test_verbs_are_within_the_bounds(case: str, dtype: type) -> None:
    p = made(case)

    def verb(name: str, data: Array) -> Array:
        if name == "valid":
            return p.valid(data)
        if name == "jacobian":
            return np.swapaxes(p.jacobian(data), -1, -2).reshape(-1, 6)
        with np.errstate(all="ignore"):
            found = getattr(sm, name)(xp.asarray(data), p)
        assert isinstance(found, type(xp.asarray(data))) and found.dtype == xp.asarray(data).dtype
        return as_numpy(found)

    assert_alike(p, dtype, verb, exact=False)


def test_directions_of_any_length_and_none() -> None:
    d = random_directions(50, 1)
    wanted = sm.encode(d, "octahedral")
    for scale in (1e-300, 1.0, 1e300):
        found = as_numpy(sm.encode(xp.asarray(scale * d), "octahedral"))
        # Normalizing again, after rounding: a few roundings of up to 1.
        np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-15)
    none = xp.asarray([[np.nan, 0.0, 1.0], [0.0, 0.0, 0.0], [np.inf, 0.0, 0.0]])
    assert np.isnan(as_numpy(sm.encode(none, "cube"))).all()
    outside = xp.asarray([[2.0, 0.5], [0.5, 0.5]])
    assert np.isnan(as_numpy(sm.decode(outside, "latlong")))[:, 0].tolist() == [True, False]
    assert np.isnan(as_numpy(sm.density(outside, "latlong"))).tolist() == [True, False]


def test_axes_rotations_and_integers() -> None:
    turn = sm.rotation(10, 20, 30)
    d = xp.asarray([[[0, 0, -1], [1, 2, 3]]])
    for options in ({"axes": "+x +y -z"}, {"rotation": turn}):
        found = sm.encode(d, "latlong", **options)
        assert found.dtype == xp.float64 and found.shape == (1, 2, 2)
        wanted = sm.encode(as_numpy(d), "latlong", **options)
        # One normalization more: a few roundings of up to 1.
        np.testing.assert_allclose(as_numpy(found), wanted, rtol=0, atol=2e-15)
    # NumPy's own arrays keep the standard, too, and stay with the kernels.
    assert type(sm.encode(as_numpy(d), "octahedral")) is np.ndarray


def test_errors_say_what_was_expected() -> None:
    with pytest.raises(ValueError, match=r"`directions` to have shape \(\.\.\., 3\), got \(4, 2\)"):
        sm.encode(xp.zeros((4, 2)), "latlong")
    with pytest.raises(ValueError, match=r"`uv` to have shape \(\.\.\., 3\), got \(2,\)"):
        sm.decode(xp.zeros(2), "cube")
    with pytest.raises(ValueError, match=r"`uv` to have shape \(\.\.\., 2\), got \(\)"):
        sm.density(xp.asarray(1.0), "latlong")
    with pytest.raises(TypeError, match="`directions` to hold real numbers"):
        sm.encode(xp.zeros(3, dtype=xp.complex128), "latlong")
    with pytest.raises(TypeError, match="`out` is for arrays of NumPy"):
        sm.encode(xp.zeros(3), "latlong", out=np.zeros(2))


@DTYPES
@pytest.mark.parametrize("case", ["latlong", "cube", "octahedral"])
def test_arrays_of_dask_stay_so_with_the_bits_of_the_kernels(case: str, dtype: type) -> None:
    d = random_directions(40, 1).reshape(10, 4, 3).astype(dtype)
    turn = sm.rotation(10, 20, 30)
    uv = sm.encode(d, case, rotation=turn)
    found = sm.encode(da.from_array(d, chunks=(3, 2, 2)), case, rotation=turn)
    assert isinstance(found, da.Array) and found.chunks[:2] == ((3, 3, 3, 1), (2, 2))
    assert found.shape == uv.shape and found.dtype == uv.dtype
    np.testing.assert_array_equal(found.compute(), uv)
    places = da.from_array(uv, chunks=(4, 4, 1))
    for verb in (sm.decode, sm.density):
        wanted, found = verb(uv, case), verb(places, case)  # type: ignore[arg-type]
        assert isinstance(found, da.Array) and found.shape == wanted.shape
        assert found.dtype == wanted.dtype
        np.testing.assert_array_equal(found.compute(), wanted)


def test_arrays_of_dask_are_computed_when_they_are_asked_for() -> None:
    def never(block: Array) -> Array:
        raise AssertionError

    later = da.zeros((6, 3), chunks=(2, 3)).map_blocks(never, dtype=np.float64)
    found = sm.encode(later, "latlong")
    assert found.shape == (6, 2) and found.dtype == np.float64
    with pytest.raises(AssertionError):
        found.compute()
    # Chunks may be of any library.
    ones = da.ones((4, 3), chunks=(2, 3))
    of_strict = ones.map_blocks(xp.asarray, meta=np.empty((0, 0)))
    parts = [part.compute() for part in sm.encode(of_strict, "latlong").to_delayed().ravel()]
    assert [type(part) for part in parts] == 2 * [type(xp.asarray(0.0))]
    with pytest.raises(ValueError, match=r"`directions` to have shape \(\.\.\., 3\), got \(4, 2\)"):
        sm.encode(da.zeros((4, 2)), "latlong")
    with pytest.raises(TypeError, match="`directions` to be real numbers, got dtype complex128"):
        sm.encode(da.zeros((4, 3), dtype=complex), "latlong")
    with pytest.raises(TypeError, match="`out` is for arrays of NumPy"):
        sm.encode(da.zeros((4, 3)), "latlong", out=np.zeros((4, 2)))
