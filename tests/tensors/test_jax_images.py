"""Verbs of images on arrays of JAX: values of NumPy, exact adjoints, directions, transforms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import FILTERS, LOOKUPS, NAMES, random_directions
from smooth import WHOLE, inside

jax = pytest.importorskip("jax")
import jax.numpy as jnp  # noqa: E402
import spheremap.jax as smj  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

# Two of them, so that `pmap` has something to do; said before the first array is made.
jax.config.update("jax_num_cpu_devices", 2)

pytestmark = pytest.mark.programs

# Two sums of some hundred products of order 1, in float64, in two orders: the issue's own bound.
EXACT = 1e-12
MEANS = [name for name in FILTERS if name != "mode"]


@pytest.fixture(autouse=True)
def _doubles() -> Iterator[None]:
    # For all threads: a call from a compiled program may come from another.
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


def same(found: Any, wanted: Any) -> None:
    # What the kernels made, called from a program.
    np.testing.assert_allclose(found, wanted, rtol=0, atol=0)


def close(found: Any, wanted: Any) -> None:
    # Sums in another order.
    np.testing.assert_allclose(found, wanted, rtol=EXACT, atol=EXACT)


def made(case: str) -> sm.Projection:
    name, _, layout = case.partition("/")
    return sm.projection(name, layout=layout) if layout else sm.projection(name)


def covered(p: sm.Projection, count: int) -> Any:
    d = random_directions(200, 7)
    return d[~np.isnan(p.encode(d)[:, 0])][:count]


def random(shape: tuple[int, ...], seed: int) -> Any:
    return np.random.default_rng(seed).random(shape)


def assert_adjoint(verb: Any, shape: tuple[int, ...]) -> None:
    """Hold ⟨A x, y⟩ to ⟨x, Aᵀ y⟩, the forward derivative to A, and the second one to A again."""
    x, other = random(shape, 1), random(shape, 2)
    result, pull = jax.vjp(verb, x)
    y = random(result.shape, 3)
    (back,) = pull(y)
    product = verb(other)
    left = float((product * y).sum())
    assert abs(left - float((other * back).sum())) < EXACT * (1 + abs(left))
    close(jax.jvp(verb, (x,), (other,))[1], product)
    _, again = jax.vjp(lambda y: pull(y)[0], y)
    close(again(other)[0], product)


@pytest.mark.parametrize("case", [*NAMES, "cube/cross"])
def test_lookups_have_exact_adjoints(case: str) -> None:
    p, d = made(case), random_directions(400, 1)
    x = random(p.shape(6), 4)
    for filter in LOOKUPS:
        assert_adjoint(lambda x, f=filter: smj.sample(x, d, p, filter=f), p.shape(6))
        found = smj.sample(x, d, p, filter=filter, fill=-1.0)
        # Some products of numbers of up to 1, of places within the bound of printed code.
        close(found, sm.sample(x, d, p, filter=filter, fill=-1.0))


@pytest.mark.parametrize("filter", MEANS)
@pytest.mark.parametrize("src, dst", [("latlong", "cube"), ("cube", "latlong")])
def test_conversions_have_exact_adjoints(src: str, dst: str, filter: str) -> None:
    shape = sm.projection(src).shape(8)

    def verb(x: Any) -> Any:
        return smj.convert(x, src, dst, size=4, filter=filter)

    assert_adjoint(verb, shape)
    x = random(shape, 4)
    same(verb(x), sm.convert(x, src, dst, size=4, filter=filter))


@pytest.mark.parametrize("case", [*NAMES, "cube/cross"])
def test_plain_lookups_borders_and_sums_have_exact_adjoints(case: str) -> None:
    p = made(case)
    shape = p.shape(6)
    assert_adjoint(lambda x: smj.convert(x, p, "latlong:blender", size=5, antialias=False), shape)
    assert_adjoint(lambda x: smj.pad(x, p, 2), shape)
    x = random(shape, 4)
    same(smj.pad(x, p, 2), sm.pad(x, p, 2))
    total = smj.integrate(x, p)
    wanted = sm.light.integrate(x, p)
    # A sum of some hundred numbers in another order.
    assert abs(float(total) - wanted) < EXACT * wanted
    slope = jax.grad(lambda x: smj.integrate(x, p))(x)
    same(slope, sm.light.weights(p, shape))


def test_other_devices_add_up_alike() -> None:
    """What runs where there is no kernel, run here."""
    from spheremap.jax._images import Conversion
    from spheremap.resample.linear import conversion

    x = random((4, 8, 3), 1)
    for filter, fill in (("bilinear", 0.0), ("area", -2.0)):
        options = (None, filter, fill, True, "match", False)
        _, key, _ = conversion((4, 8), "latlong", "perspective", 3, *options)
        rule = Conversion(key)
        close(rule.traced(jnp.asarray(x)), rule.run(x))
        y = random((*rule.shape(), 3), 2)
        back = rule.adjoint
        close(back.traced(jnp.asarray(y)), back.run(y))


# A rim that another place lies beyond, one where the image ends, edges of faces apart and joined.
OTHERS = ["angular", "angular(fov=200)", "cube", "cube/cross", "healpix", "mollweide"]


@pytest.mark.parametrize("case", [*WHOLE, *OTHERS])
def test_directions_have_the_gradient_of_a_lookup(case: str) -> None:
    p = made(case)
    # Rims and edges of faces among them; of a rectangle, cuts and poles are left out.
    at = inside(case, 8) if case in WHOLE else covered(p, 20)
    *faces, height, width = p.shape(8)
    x = random((*faces, 2, height, width), 6)

    def verb(image: Any, where: Any) -> Any:
        return smj.sample(image, where, p)

    # Central differences of what is a polynomial of places: some of the eighth digit.
    close = {"atol": 1e-6, "rtol": 1e-6, "eps": 1e-7}
    check_grads(verb, (x, at), 1, ("fwd", "rev"), **close)
    turn = jnp.asarray(sm.rotation(1, 2, 3))
    check_grads(lambda r: smj.sample(x, at, p, rotation=jnp.asarray(r)), (turn,), 1, **close)


def test_rotation_of_a_conversion_has_a_gradient() -> None:
    x = random((2, 3, 8, 16), 1)
    turn = sm.rotation(10, 20, 30)
    options: dict[str, Any] = {"size": 3, "antialias": False}

    def verb(r: Any) -> Any:
        return smj.convert(x, "latlong", "cube", rotation=r, **options)

    wanted = sm.convert(x, "latlong", "cube", rotation=turn, channels_first=True, **options)
    same(verb(turn), wanted)
    # Directions are turned once more than by the kernel; 16 columns of slopes up to 1.
    np.testing.assert_allclose(verb(jnp.asarray(turn)), wanted, rtol=0, atol=1e-13)
    # Central differences of what is a polynomial of places: some of the eighth digit.
    check_grads(
        lambda r: verb(jnp.asarray(r)), (jnp.asarray(turn),), 1, atol=1e-6, rtol=1e-6, eps=1e-7
    )
    with pytest.raises(ValueError, match="wants filter='bilinear' and antialias=False"):
        smj.convert(x, "latlong", "cube", rotation=jnp.asarray(turn), size=3)


def test_no_gradient_is_silently_wrong() -> None:
    d = random_directions(3, 5)
    x = random((4, 8), 1)
    for way in (jax.jacfwd, jax.jacrev):
        with pytest.raises(NotImplementedError, match="`sample` has a derivative by direction"):
            way(lambda d: smj.sample(x, d, "latlong", filter="nearest"))(d)
    cube = random((6, 4, 4), 1)
    with pytest.raises(NotImplementedError, match="no second derivative"):
        jax.hessian(lambda d: smj.sample(cube, d, "cube").sum())(d)
    with pytest.raises(Exception, match="has no gradient"):
        wrong = jax.grad(lambda x: smj.convert(x, "latlong", "cube", size=2, filter="mode").sum())
        wrong(x).block_until_ready()


@pytest.mark.parametrize("src, dst", [("latlong", "cube"), ("cube", "latlong"), ("cube", "cube")])
def test_shapes_are_those_of_channels_first(src: str, dst: str) -> None:
    p, d = sm.projection(src), random_directions(6, 1).reshape(2, 3, 3)
    shape = p.shape(4)
    rows = len(shape) - 2
    for lead, channels in (((), ()), ((), (3,)), ((2,), (3,))):
        x = random((*lead, *shape[:rows], *channels, *shape[rows:]), 1)
        first = {"channels_first": bool(channels)}
        wanted = sm.convert(x, src, dst, size=4, **first)
        same(smj.convert(x, src, dst, size=4), wanted)
        close(smj.sample(x, d, src), sm.sample(x, d, src, **first))
        same(smj.pad(x, src, 1), sm.pad(x, src, 1, **first))
        wanted = sm.light.integrate(x, src, **first)
        close(smj.integrate(x, src), wanted)


def test_transforms() -> None:
    x, d = random((4, 3, 8, 16), 1), random_directions(20, 1)

    def total(image: Any, d: Any = d) -> Any:
        cube = smj.convert(image, "latlong", "cube", size=4)
        border = smj.pad(image, "latlong", 1)
        near = smj.sample(image, d, "latlong", filter="nearest")
        seen = smj.sample(cube, d, "cube")
        lookups = (smj.sample(image, d, "latlong") ** 2).sum() + (seen**2).sum()
        return lookups + (cube**2).sum() + (border**2).sum() + (near**2).sum()

    slope = jax.grad(total)
    wanted = np.stack([slope(one) for one in x])
    close(jax.vmap(slope)(x), wanted)
    close(jax.jit(slope)(x[0]), wanted[0])
    close(jax.jit(jax.vmap(slope))(x), wanted)
    count = jax.local_device_count()
    assert count == 2
    close(jax.pmap(slope)(x[:count]), wanted[:count])
    # Directions of each image its own.
    many = np.stack([random_directions(20, k) for k in range(4)])
    each = np.stack([slope(one, where) for one, where in zip(x, many, strict=True)])
    close(jax.vmap(slope)(x, many), each)
    curved = jax.jvp(slope, (x[0],), (x[1],))[1]
    back = jax.grad(lambda image: (slope(image) * x[1]).sum())(x[0])
    # A matrix that is its own transposed, forward and in reverse.
    np.testing.assert_allclose(curved, back, rtol=1e-11, atol=1e-11)


def test_large_images_go_through_compiled_programs() -> None:
    """A call back from a program is given more than fits into what is passed along with it."""
    x = random((3, 256, 512), 1).astype(np.float32)
    found = jax.jit(lambda x: smj.convert(x, "latlong", "cube", size=128))(x)
    wanted = sm.convert(x, "latlong", "cube", size=128, channels_first=True)
    same(found, wanted)


def test_half_is_computed_in_float32() -> None:
    x = jnp.asarray(random((3, 8, 16), 1)).astype(jnp.float16)
    found = smj.convert(x, "latlong", "octahedral", size=8)
    assert found.dtype == jnp.float16
    wide = smj.convert(x.astype(jnp.float32), "latlong", "octahedral", size=8)
    assert (found == wide.astype(jnp.float16)).all()


def test_nothing_makes_nothing_and_holes_do_not_count() -> None:
    x = random((3, 8, 16), 1)
    for filter in ("bilinear", "nearest"):
        found = smj.sample(x, jnp.zeros((2, 0, 3)), "latlong", filter=filter)
        assert found.shape == (3, 2, 0)
    hole = np.isnan(sm.directions("sphere", 16)[..., 0])

    def total(x: Any) -> Any:
        return smj.integrate(x, "sphere")

    value, slope = jax.value_and_grad(total)(jnp.where(hole, jnp.nan, 1.0))
    # A sum of some hundred numbers in another order.
    assert hole.any() and abs(value - 4 * np.pi) < 1e-12 * 4 * np.pi
    assert (slope[hole] == 0).all()


def test_errors_say_what_was_expected() -> None:
    x, turns = jnp.zeros((4, 8)), jnp.stack([jnp.eye(3)] * 2)
    with pytest.raises(ValueError, match=r"shape \(3, 3\), got \(2, 3, 3\)"):
        smj.convert(x, "latlong", "cube", size=2, antialias=False, rotation=turns)
    with pytest.raises(NotImplementedError, match="'mode' has no gradient"):
        jax.jvp(lambda x: smj.convert(x, "latlong", "cube", size=2, filter="mode"), (x,), (x,))
    with pytest.raises(ValueError, match="2 to 4 axes"):
        smj.sample(jnp.zeros(4), jnp.zeros(3), "latlong")
    with pytest.raises(ValueError, match="each side within a texel"):
        smj.convert(jnp.zeros((3, 8, 8)), "latlong", "cube")
    with pytest.raises(TypeError, match="to be of floats"):
        smj.convert(jnp.zeros((3, 4, 8), jnp.uint8), "latlong", "cube")
    with pytest.raises(ValueError, match="bilinaer"):
        smj.sample(jnp.zeros((4, 8)), jnp.zeros(3), "latlong", filter="bilinaer")
