"""Harmonics, light and packing on arrays of JAX: values of NumPy, exact adjoints, derivatives."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES, random_directions

jax = pytest.importorskip("jax")
import jax.numpy as jnp  # noqa: E402
import spheremap.jax as smj  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

# Two of them, so that `pmap` has something to do; said before the first array is made.
jax.config.update("jax_num_cpu_devices", 2)

pytestmark = pytest.mark.programs


@pytest.fixture(autouse=True)
def _doubles() -> Iterator[None]:
    # For all threads: a call from a compiled program may come from another.
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


def close(found: Any, wanted: Any) -> None:
    # Sums of some hundred products of order 1, and a fit of a residual of 1e-13.
    np.testing.assert_allclose(found, wanted, rtol=1e-11, atol=1e-11)


def random(shape: tuple[int, ...], seed: int) -> Any:
    return np.random.default_rng(seed).random(shape)


def as_jax(p: sm.Projection, size: int) -> Any:
    """Return two images of three channels, channels before the rows."""
    x = random((2, 3, *p.shape(size)), 1)
    return np.moveaxis(x, 1, 2) if x.ndim == 5 else x


@pytest.mark.parametrize("texels", ["means", "points"])
@pytest.mark.parametrize("case", NAMES)
def test_projecting_is_numpys_and_has_an_exact_adjoint(case: str, texels: str) -> None:
    p = sm.projection(case)
    x = as_jax(p, 16)
    found, pull = jax.vjp(lambda x: smj.sh.project(x, p, order=2, texels=texels), x)
    last = np.moveaxis(x, 2 if x.ndim == 5 else 1, -1)
    close(found, np.stack([sm.sh.project(one, p, order=2, texels=texels).T for one in last]))
    y = random(found.shape, 2)
    (back,) = pull(y)
    # The product is linear in the image, so that it is what flows back times the image.
    close((back * x).sum(), (found * y).sum())
    other = random(x.shape, 3)
    _, again = jax.vjp(lambda y: pull(y)[0], y)
    close(again(other)[0], smj.sh.project(other, p, order=2, texels=texels))


def test_other_devices_project_alike() -> None:
    """What runs where there is no kernel, run here."""
    from spheremap.jax._harmonics import Projected

    for case in ("latlong", "cube", "perspective"):
        shape = sm.projection(case).shape(8)
        rule = Projected.of(case, shape, 3, "means")
        x, y = random((*shape, 2), 1), random((16, 2), 2)
        close(rule.traced(jnp.asarray(x)), rule.run(x))
        close(rule.adjoint.traced(jnp.asarray(y)), rule.adjoint.run(y))


@pytest.mark.parametrize("order", [0, 1, 3, 8])
def test_evaluating_and_turning_have_derivatives(order: int) -> None:
    c, d = random((2, (order + 1) ** 2), 4), 2 * random_directions(5, 3)
    close(smj.sh.evaluate(c, d), sm.sh.evaluate(c.T, d).T)
    # Central differences of first derivatives of polynomials whose slopes are up to a hundred.
    check_grads(smj.sh.evaluate, (c, d), 2, atol=1e-4, rtol=1e-4, eps=1e-6)
    turn = sm.rotation(30, 20, 10)
    wanted = sm.sh.rotate(c.T, turn).T
    close(smj.sh.rotate(c, turn), wanted)
    close(smj.sh.rotate(c, jnp.asarray(turn)), wanted)
    if order < 8:
        rotate = jax.jit(lambda c, r: smj.sh.rotate(c, r))
        # Central differences of smooth functions whose slopes are up to ten.
        check_grads(rotate, (c, jnp.asarray(turn)), 1, atol=1e-6, rtol=1e-6, eps=1e-6)
    factors = np.linspace(1, 2, order + 1)
    close(smj.sh.convolve(c, lobe=factors), sm.sh.convolve(c.T, lobe=factors).T)


def test_high_orders_have_values() -> None:
    c, d = random((100,), 1), random_directions(20, 1)
    close(smj.sh.evaluate(c, d), sm.sh.evaluate(c, d))
    close(jax.jit(jax.vmap(smj.sh.evaluate, (None, 0)))(c, d), sm.sh.evaluate(c, d))
    slope = jax.grad(lambda c: smj.sh.evaluate(c, d).sum())(c)
    close((slope * c).sum(), sm.sh.evaluate(c, d).sum())
    with pytest.raises(NotImplementedError, match="Above order 8"):
        jax.grad(lambda d: smj.sh.evaluate(c, d).sum())(d)


def test_what_has_no_direction_spoils_nothing() -> None:
    c, d = random((9,), 1), np.array([[0.0, 0.0, 0.0], [np.inf, 0.0, 0.0], [1.0, 2.0, 3.0]])
    found = smj.sh.evaluate(c, d)
    assert np.isnan(found[:2]).all() and np.isfinite(found[2])
    slope = jax.grad(lambda d: jnp.nan_to_num(smj.sh.evaluate(c, d)).sum())(d)
    assert (slope[:2] == 0).all() and (slope[2] != 0).all()
    unit = smj.packing.quantize(d, "oct16")
    assert np.isnan(unit[:2]).all() and np.isfinite(unit[2]).all()


@pytest.mark.parametrize("src, dst", [("latlong", "cube"), ("cube", "octahedral")])
def test_irradiance_is_that_of_harmonics(src: str, dst: str) -> None:
    x, turn = as_jax(sm.projection(src), 16), sm.rotation(30)

    def verb(x: Any, turn: Any) -> Any:
        return smj.light.irradiance(x, src, dst, size=4, order=4, rotation=turn)

    options: dict[str, Any] = {"size": 4, "method": "sh", "order": 4, "rotation": turn}
    wanted = sm.light.irradiance(x, src, dst, channels_first=True, **options)
    close(verb(x, turn), wanted)
    close(verb(x, jnp.asarray(turn)), wanted)
    back = jax.grad(lambda x: verb(x, turn).sum())(x)
    close((back * x).sum(), wanted.sum())


@pytest.mark.parametrize("name", ["oct16", "oct8x2", "oct32", "hemioct16", "rgb10a2"])
def test_packing_is_numpys_and_passes_gradients_through(name: str) -> None:
    d = random_directions(50, 1)
    d[:, 2] = np.abs(d[:, 2])
    weights = np.linspace(0, 1, 3)

    def total(d: Any) -> Any:
        return (smj.packing.quantize(d, name) * weights).sum()

    found = smj.packing.quantize(d, name)
    # A direction and its length of 1 may round to two codes.
    assert np.linalg.norm(found - d, axis=-1).max() <= sm.packing.packing(name).bound + 1e-12
    unit = jax.grad(lambda d: (d / jnp.linalg.norm(d, axis=-1, keepdims=True) * weights).sum())
    close(jax.grad(total)(2 * d), unit(2 * d))
    close(jax.jit(jax.vmap(jax.grad(total)))(2 * d), unit(2 * d))


@pytest.mark.parametrize("name", ["oct16", "oct8x2", "oct32", "hemioct16", "rgb10a2", "oct64"])
def test_codes_are_numpys(name: str) -> None:
    d = random_directions(12, 1).reshape(4, 3, 3)
    d[..., 2] = np.abs(d[..., 2])
    wanted = sm.packing.pack(d, name)
    back = sm.packing.unpack(wanted, name, dtype=np.float64)

    def pack(d: Any) -> Any:
        return smj.packing.pack(d, name)

    def unpack(codes: Any) -> Any:
        return smj.packing.unpack(codes, name, dtype=jnp.float64)

    for way in (pack, jax.jit(pack), jax.vmap(pack), jax.jit(jax.vmap(jax.vmap(pack)))):
        codes = way(d)
        assert codes.dtype == wanted.dtype and np.array_equal(codes, wanted)
    for way in (unpack, jax.jit(unpack), jax.vmap(unpack), jax.jit(jax.vmap(jax.vmap(unpack)))):
        assert np.array_equal(way(wanted), back)
    # Integers pass nothing on.
    assert (jax.grad(lambda d: unpack(pack(d)).sum())(d) == 0).all()


def test_what_is_wrong_with_codes_is_said_where_it_can_be() -> None:
    with pytest.raises(ValueError, match="zero or not finite"):
        smj.packing.pack(jnp.zeros(3), "oct16")
    with pytest.raises(jax.errors.JaxRuntimeError, match="zero or not finite"):
        jax.block_until_ready(jax.jit(lambda d: smj.packing.pack(d, "oct16"))(jnp.zeros(3)))
    with pytest.raises(ValueError, match="`invalid` to be 'raise'"):
        jax.jit(lambda d: smj.packing.pack(d, "oct16", invalid="x"))(jnp.ones(3))
    with pytest.raises(ValueError, match=r"shape \(\.\.\., 2\), got \(3,\)"):
        jax.jit(lambda c: smj.packing.unpack(c, "oct8x2"))(jnp.ones(3, jnp.uint8))
    with pytest.raises(TypeError, match="`codes` to be integers"):
        smj.packing.unpack(jnp.ones(3), "oct16")
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(ValueError, match="'oct64' are uint64, which wants jax_enable_x64"):
        smj.packing.pack(jnp.ones(3), "oct64")


@pytest.mark.parametrize("case", ["latlong", "cube", "octahedral", "sphere"])
def test_a_distribution_is_numpys(case: str) -> None:
    p = sm.projection(case)
    x = as_jax(p, 8)[0]
    theirs = sm.light.Distribution(np.moveaxis(x, 1 if x.ndim == 4 else 0, -1), p)
    xi = random((6, 2), 5)
    d, pdf = theirs.sample(xi)
    ours = smj.light.Distribution(x, p)
    assert ours.integral == theirs.integral and "Distribution(" in repr(ours)

    def drawn(x: Any, xi: Any) -> Any:
        return smj.light.Distribution(x, p).sample(xi)

    ways = [
        ours.sample,
        jax.jit(ours.sample),
        jax.vmap(ours.sample),
        jax.jit(jax.vmap(ours.sample)),
    ]
    ways += [lambda xi: jax.jit(drawn)(x, xi), lambda xi: jax.vmap(drawn, (None, 0))(x, xi)]
    for way in ways:
        found = way(xi)
        assert np.array_equal(found[0], d) and np.array_equal(found[1], pdf)
    assert np.array_equal(ours.pdf(d), theirs.pdf(d))
    assert np.array_equal(jax.jit(jax.vmap(ours.pdf))(d), theirs.pdf(d))
    assert np.isnan(ours.pdf(jnp.array([[0.0, 0.0, 0.0], [jnp.nan, 0.0, 1.0]]))).all()


def test_distributions_of_images_that_a_program_is_given() -> None:
    x, xi = as_jax(sm.projection("latlong"), 8), random((6, 2), 5)

    def drawn(x: Any, xi: Any) -> Any:
        return smj.light.Distribution(x, "latlong").sample(xi)

    each = [drawn(one, xi) for one in x]
    several = jax.jit(jax.vmap(drawn, (0, None)))(x, xi)
    crossed = jax.vmap(jax.vmap(drawn, (None, 0)), (0, None))(x, xi)
    for k, one in enumerate(each):
        for part, found, again in zip(one, several, crossed, strict=True):
            assert np.array_equal(found[k], part) and np.array_equal(again[k], part)

    def estimate(x: Any) -> Any:
        d, pdf = drawn(x, xi)
        return (smj.sample(x, d, "latlong") / pdf).mean()

    d, pdf = each[0]
    wanted = jax.grad(lambda x: (smj.sample(x, d, "latlong") / pdf).mean())(x[0])
    # What is drawn is a constant to the gradient.
    for way in (jax.grad(estimate), jax.jit(jax.grad(estimate))):
        close(way(x[0]), wanted)
    with pytest.raises(ValueError, match="of one image"):
        smj.light.Distribution(x, "latlong")
    with pytest.raises(ValueError, match="the image is black"):
        smj.light.Distribution(0 * x[0], "latlong")
    with pytest.raises(TypeError, match="`integral` is of an image that is known"):
        jax.jit(lambda x: smj.light.Distribution(x, "latlong").integral)(x[0])


def test_transforms() -> None:
    x, d = as_jax(sm.projection("cube"), 8), random_directions(20, 1)

    def total(x: Any, d: Any) -> Any:
        c = smj.sh.convolve(smj.sh.project(x, "cube", order=3), lobe="cosine")
        return (smj.sh.evaluate(c, smj.packing.quantize(d, "oct32")) ** 2).sum()

    slope = jax.grad(total, (0, 1))
    wanted = slope(x, d)
    for a, b in zip(jax.jit(slope)(x, d), wanted, strict=True):
        close(a, b)
    several = np.stack([x, x[::-1]])
    each = jax.vmap(slope, (0, None))(several, d)
    spread = jax.pmap(slope, in_axes=(0, None))(several, d)
    for k, one in enumerate(several):
        for a, b, c in zip(each, spread, slope(one, d), strict=True):
            close(a[k], c)
            close(b[k], c)
    close(jax.jvp(total, (x, d), (x, 0 * d))[1], (wanted[0] * x).sum())


def test_half_is_computed_in_float32() -> None:
    for dtype in (jnp.float16, jnp.bfloat16):
        x = jnp.asarray(random((3, 32, 64), 1)).astype(dtype)
        found = smj.light.irradiance(x, "latlong", "cube", size=2)
        wide = smj.light.irradiance(x.astype(jnp.float32), "latlong", "cube", size=2)
        assert found.dtype == dtype and (found == wide.astype(dtype)).all()


def test_errors_say_what_was_expected() -> None:
    with pytest.raises(ValueError, match=r"\(order \+ 1\)² numbers in the last axis, got \(5,\)"):
        smj.sh.evaluate(jnp.zeros(5), jnp.ones(3))
    with pytest.raises(ValueError, match="order"):
        smj.sh.project(jnp.zeros((8, 16)), "latlong", order=-1)
    with pytest.raises(ValueError, match="texels"):
        smj.sh.project(jnp.zeros((8, 16)), "latlong", order=1, texels="mean")
    with pytest.raises(ValueError, match=r"`lobe` to have shape \(2,\), got \(3,\)"):
        smj.sh.convolve(jnp.zeros(4), lobe=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="take no `roughness`"):
        smj.sh.convolve(jnp.zeros(4), lobe=[1.0, 2.0], roughness=0.5)
    with pytest.raises(ValueError, match="oct61"):
        smj.packing.quantize(jnp.ones(3), "oct61")


def test_what_is_no_number_flows_through() -> None:
    x = random((3, 16, 32), 1)

    def irradiance(x: Any) -> Any:
        # Its corners have no normal.
        return smj.light.irradiance(x, "latlong", "matcap", size=8, order=2).sum()

    close((jax.grad(irradiance)(x) * x).sum(), irradiance(x))
    gradient = jnp.ones((3, 9)).at[1, 2].set(jnp.nan)
    (back,) = jax.vjp(lambda x: smj.sh.project(x, "latlong", order=2), jnp.asarray(x))[1](gradient)
    assert jnp.isnan(back[1]).all() and jnp.isfinite(back[jnp.array([0, 2])]).all()
    d = jnp.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    slope = jax.grad(lambda c: jnp.nansum(smj.sh.evaluate(c, d)))(jnp.ones(9))
    assert jnp.isfinite(slope).all() and (slope != 0).all()


def test_a_distribution_pickles() -> None:
    drawn = smj.light.Distribution(random((8, 16), 1), "latlong")
    xi = jnp.asarray(random((5, 2), 2))
    again = pickle.loads(pickle.dumps(drawn))
    assert all((a == b).all() for a, b in zip(again.sample(xi), drawn.sample(xi), strict=True))
