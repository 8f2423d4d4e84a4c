"""Verbs of one map on arrays of JAX: the values of NumPy, derivatives, and JAX's own transforms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from printed import CASES as PRINTED
from printed import assert_alike, made
from smooth import CASES, smooth

jax = pytest.importorskip("jax")
import jax.numpy as jnp  # noqa: E402
import spheremap.jax as smj  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

pytestmark = pytest.mark.programs


@pytest.fixture(autouse=True)
def _doubles() -> Iterator[None]:
    # For all threads: a call from a compiled program may come from another.
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


def fused(found: Any, wanted: Any) -> None:
    # The same operations, fused otherwise: some roundings of numbers of order 1.
    np.testing.assert_allclose(found, wanted, rtol=1e-13, atol=1e-13)


def whole(uv: Any, face: Any) -> Any:
    return jnp.concatenate([uv, face], -1)


@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", PRINTED)
def test_values_are_within_the_bounds(case: str, dtype: type) -> None:
    p = made(case)

    def verb(name: str, data: np.ndarray) -> np.ndarray:
        if name == "valid":
            return np.asarray(p.valid(data))
        found = np.asarray(getattr(smj, name)(data, p))
        assert found.dtype == dtype
        return np.swapaxes(found, -1, -2).reshape(-1, 6) if name == "jacobian" else found

    assert_alike(p, dtype, verb, exact=False)


def test_directions_of_any_length_and_none() -> None:
    d = random_directions(50, 1)
    for dtype, scales in ((np.float32, (1e-30, 1e30)), (np.float64, (1e-300, 1e300))):
        unit = smj.encode(d.astype(dtype), "octahedral")
        for scale in scales:
            found = smj.encode((scale * d).astype(dtype), "octahedral")
            # Normalizing again, and rounding after scaling: a few roundings of up to 1.
            few = 8 * np.finfo(dtype).eps
            np.testing.assert_allclose(found, unit, rtol=0, atol=few)
    none = np.array([[np.nan, 0, 1], [0, 0, 0], [np.inf, 0, 0]])
    assert np.isnan(smj.encode(none, "cube")).all()
    assert np.isnan(smj.decode(np.array([2.0, 0.5]), "latlong")).all()


@pytest.mark.parametrize("case", CASES)
def test_first_and_second_derivatives_are_those_of_differences(case: str) -> None:
    d, uv, face = smooth(case, 2)
    verbs: list[tuple[Callable[[Any], Any], Any]] = [
        (lambda x: smj.encode(x, case)[..., :2], 1.5 * d),
        (lambda x: smj.decode(whole(x, face), case), uv),
    ]
    for verb, at in verbs:
        # Central differences of a step of 1e-6 of what changes by order 1 in a thousandth: 1e-8
        # of slopes of up to some thousand, and of second ones.
        check_grads(verb, (at,), 2, ("fwd", "rev"), atol=1e-5, rtol=1e-5, eps=1e-6)
    for name in ("jacobian", "density"):

        def slope(x: Any, name: str = name) -> Any:
            return getattr(smj, name)(whole(x, face), case)

        # As above.
        check_grads(slope, (uv,), 1, ("fwd", "rev"), atol=1e-5, rtol=1e-5, eps=1e-6)


@pytest.mark.parametrize("case", CASES)
def test_the_derivative_of_decode_is_that_of_the_kernels(case: str) -> None:
    _, uv, face = smooth(case, 4)
    at = np.concatenate([uv, face], -1)
    found = jax.vmap(jax.jacfwd(lambda x: smj.decode(x, case)))(at)
    wanted = sm.jacobian(at, case)
    # A hundred roundings of derivatives in float64, whose largest are some thousand.
    np.testing.assert_allclose(found[..., :2], wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
    assert not np.any(found[..., 2:])
    back = jax.vmap(jax.jacrev(lambda x: smj.decode(x, case)))(at)
    fused(back, found)


def test_rotation_and_reflection_have_gradients() -> None:
    d = random_directions(5, 1)
    turn = sm.rotation(30, 20, 10)
    found = smj.encode(d, "octahedral", rotation=jnp.asarray(turn))
    fused(found, sm.encode(d, "octahedral", rotation=turn))
    for verb in (
        lambda r: smj.encode(d, "octahedral", rotation=r),
        lambda r: smj.decode(found, "octahedral", rotation=r),
        lambda r: smj.jacobian(found, "octahedral", rotation=r),
        lambda r: smj.directions("cube", 2, rotation=r, dtype=jnp.float64),
    ):
        # Central differences of smooth functions of order 1.
        check_grads(verb, (jnp.asarray(turn),), 1, atol=1e-7, rtol=1e-7, eps=1e-6)
    view, normal = (random_directions(3, k) for k in (4, 5))
    fused(smj.reflect(view, normal), sm.reflect(view, normal))
    # Central differences of first derivatives of order 1.
    check_grads(smj.reflect, (view, normal), 2, atol=1e-5, rtol=1e-5, eps=1e-6)


def test_what_is_left_out_spoils_nothing() -> None:
    d = jnp.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])

    def total(d: Any) -> Any:
        uv = smj.encode(d, "perspective")
        return jnp.where(jnp.isnan(uv), 0.0, uv).sum()

    assert jnp.isnan(smj.encode(d, "perspective")[1]).all()
    slope = jax.grad(total)(d)
    assert jnp.isfinite(slope).all() and (slope[0] != 0).any() and (slope[1] == 0).all()
    outside = jax.grad(lambda uv: jnp.nan_to_num(smj.decode(uv, "sphere")).sum())
    assert (outside(jnp.zeros(2)) == 0).all()


def test_transforms() -> None:
    d = random_directions(6, 2).reshape(2, 3, 3)
    turned = sm.projection("octahedral").turned(sm.rotation(20))
    for p in ("cube", "latlong", turned):

        def total(x: Any, p: Any = p) -> Any:
            return (smj.decode(smj.encode(x, p), p) ** 3).sum()

        wanted = jax.grad(total)(d)
        fused(jax.vmap(jax.grad(total))(d), wanted)
        fused(jax.jit(jax.grad(total))(d), wanted)
        along = jax.jvp(total, (d,), (np.ones_like(d),))[1]
        # A sum in another order, of numbers of order 1.
        np.testing.assert_allclose(along, wanted.sum(), rtol=1e-12, atol=1e-12)
        count = jax.local_device_count()
        spread = jax.pmap(jax.grad(total))(np.stack([d] * count))
        fused(spread, np.stack([wanted] * count))


@pytest.mark.parametrize("dtype", ["float16", "bfloat16"])
def test_half_is_computed_in_float32(dtype: str) -> None:
    d = jnp.asarray(random_directions(50, 2)).astype(dtype)
    found = smj.encode(d, "octahedral")
    assert found.dtype == d.dtype
    assert (found == smj.encode(d.astype(jnp.float32), "octahedral").astype(dtype)).all()


def test_errors_say_what_was_expected() -> None:
    with pytest.raises(TypeError, match="to be of floats, got int64"):
        smj.encode(jnp.zeros(3, dtype=jnp.int64), "latlong")
    with pytest.raises(ValueError, match=r"`directions` to be \(\.\.\., 3\)"):
        smj.encode(jnp.zeros(2), "latlong")
    with pytest.raises(ValueError, match=r"`uv` to be \(\.\.\., 3\)"):
        smj.decode(jnp.zeros(2), "cube")
    with pytest.raises(ValueError, match=r"`rotation` to be \(\.\.\., 3, 3\)"):
        smj.encode(jnp.zeros(3), "latlong", rotation=jnp.zeros(3))
    with pytest.raises(ValueError, match="latlang"):
        smj.encode(jnp.zeros(3), "latlang")


@pytest.mark.parametrize("size", [1e20, 1e-30])
def test_lengths_have_no_say(size: float) -> None:
    """In float32 the squares of these are infinite or zero."""
    v, n = jnp.array([1.0, 2.0, 3.0], jnp.float32), jnp.array([0.5, -1.0, 2.0], jnp.float32)

    def slopes(factor: float) -> list[Any]:
        one, two = v * jnp.float32(factor), n * jnp.float32(factor)
        found = [
            jax.grad(lambda d: smj.encode(d, "latlong")[0])(one) * factor,
            jax.grad(lambda n: smj.reflect(v, n)[0])(two) * factor,
            jax.grad(lambda d: smj.packing.quantize(d, "oct32")[0])(one) * factor,
            smj.reflect(one, two) / factor,
        ]
        return found

    for found, wanted in zip(slopes(size), slopes(1.0), strict=True):
        # Some roundings in float32 of numbers of order 1.
        np.testing.assert_allclose(found, wanted, rtol=1e-5, atol=1e-6)


def test_no_normal_spoils_nothing() -> None:
    n = jnp.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    assert jnp.isnan(smj.reflect(jnp.ones(3), n)[0]).all()
    slope = jax.grad(lambda n: jnp.nansum(smj.reflect(jnp.ones(3), n)))(n)
    assert (slope[0] == 0).all() and (slope[1] != 0).all()
