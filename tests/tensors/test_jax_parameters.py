"""Parameters of maps as arrays of JAX: against differences and torch, and under transforms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from moving_cases import CASES, maximum
from smooth import smooth

jax = pytest.importorskip("jax")
import jax.numpy as jnp  # noqa: E402
import spheremap.jax as smj  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

# Two of them, so that `pmap` has something to do; said before the first array is made.
jax.config.update("jax_num_cpu_devices", 2)

pytestmark = pytest.mark.programs

# Central differences of a step of 1e-6 of what changes by order 1 in a thousandth: 1e-8 of slopes
# of up to some thousand.
DIFFERENCES = {"atol": 1e-5, "rtol": 1e-5, "eps": 1e-6}


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
    # Sums of some hundred numbers of order 1 in another order.
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12)


def near(found: Any, wanted: Any) -> None:
    # Directions are decoded once more: a few roundings, 32 columns of slopes up to 1.
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


def random(shape: tuple[int, ...], seed: int) -> Any:
    return np.random.default_rng(seed).random(shape)


def at(name: str, names: tuple[str, ...], numbers: Any) -> Any:
    return smj.projection(name, **dict(zip(names, numbers, strict=True)))


@pytest.mark.parametrize("name, given", CASES)
def test_values_and_first_derivatives(name: str, given: dict[str, float]) -> None:
    p = sm.projection(name, **given)
    names, numbers = tuple(p.parameters), list(p.parameters.values())
    d, uv, face = smooth(p, 3)
    where = np.concatenate([uv, face], -1)
    moving = at(name, names, [jnp.asarray(number) for number in numbers])
    same(smj.encode(d, moving), sm.encode(d, p))
    same(smj.decode(where, moving), sm.decode(where, p))
    # Differences step over the end of a range.
    free = [k for k, key in enumerate(names) if p.parameters[key] < maximum(name, key)]

    def with_free(some: Any) -> Any:
        mixed = list(numbers)
        for k, one in zip(free, some, strict=True):
            mixed[k] = one
        return at(name, names, mixed)

    def encode(x: Any, *some: Any) -> Any:
        return smj.encode(x, with_free(some))[..., :2]

    def decode(x: Any, *some: Any) -> Any:
        return smj.decode(jnp.concatenate([x, face], -1), with_free(some))

    if free:
        some = [jnp.asarray(numbers[k]) for k in free]
        check_grads(encode, (1.5 * d, *some), 1, ("fwd", "rev"), **DIFFERENCES)
        check_grads(decode, (uv, *some), 1, ("fwd", "rev"), **DIFFERENCES)


@pytest.mark.parametrize("name, given", CASES)
def test_derivatives_are_those_of_torch(name: str, given: dict[str, float]) -> None:
    torch = pytest.importorskip("torch")
    import spheremap.torch as smt

    p = sm.projection(name, **given)
    names, numbers = tuple(p.parameters), tuple(p.parameters.values())
    d, uv, face = smooth(p, 3)
    where = np.concatenate([uv, face], -1)
    for verb, data in (("encode", d), ("decode", where)):

        def ours(x: Any, some: Any, verb: str = verb) -> Any:
            return (getattr(smj, verb)(x, at(name, names, some)) ** 2).sum()

        found = jax.grad(ours, (0, 1))(data, tuple(jnp.asarray(number) for number in numbers))
        leaves = [torch.tensor(number, dtype=torch.float64) for number in numbers]
        x = torch.from_numpy(data)
        for leaf in (x, *leaves):
            leaf.requires_grad_()
        theirs = smt.projection(name, **dict(zip(names, leaves, strict=True)))
        wanted = torch.autograd.grad((getattr(smt, verb)(x, theirs) ** 2).sum(), (x, *leaves))
        scale = max(float(np.abs(found[0]).max()), 1.0)
        for a, b in zip((found[0], *found[1]), wanted, strict=True):
            # The same derivatives, added up in another order.
            np.testing.assert_allclose(a, b.numpy(), rtol=1e-12, atol=1e-12 * scale)


def test_images_move_with_parameters() -> None:
    """`sample` and `convert` of maps that move, against what they are of maps that stand."""
    x, y = random((2, 32, 32), 0), random((3, 8, 16), 1)
    d, view = random_directions(400, 1), sm.directions("perspective(fov=60)", 8)
    fov, still = jnp.asarray(80.0), "perspective(fov=80.0)"
    moving = smj.projection("perspective", fov=fov)
    wanted = sm.sample(x, d, still, channels_first=True)
    near(smj.sample(x, d, moving), wanted)
    turn = sm.rotation(20, 10)
    options: dict[str, Any] = {"size": 5, "antialias": False, "rotation": turn}

    def camera(fov: Any) -> Any:
        return smj.projection("perspective", fov=fov)

    def into(fov: Any) -> Any:
        return smj.convert(y, "latlong:blender", camera(fov), **options)

    def out_of(x: Any, fov: Any) -> Any:
        return smj.convert(x, camera(fov), "latlong", size=8, antialias=False, rotation=turn)

    wanted = sm.convert(y, "latlong:blender", still, channels_first=True, **options)
    near(jax.jit(into)(fov), wanted)
    wanted = sm.convert(x, still, "latlong", channels_first=True, **{**options, "size": 8})
    near(jax.jit(out_of)(x, fov), wanted)
    # Central differences of what is a polynomial of places: some of the eighth digit.
    few = {"atol": 1e-6, "rtol": 1e-6, "eps": 1e-7}
    check_grads(jax.jit(into), (fov,), 1, ("fwd", "rev"), **few)
    check_grads(lambda x, fov: smj.sample(x, view, camera(fov)), (x, fov), 1, ("fwd", "rev"), **few)
    other = random(x.shape, 2)
    result, pull = jax.vjp(lambda x: out_of(x, fov), x)
    weights = random(result.shape, 3)
    # ⟨A x, y⟩ = ⟨x, Aᵀ y⟩.
    close((out_of(other, fov) * weights).sum(), (other * pull(weights)[0]).sum())
    with pytest.raises(ValueError, match="wants filter='bilinear' and antialias=False"):
        smj.convert(y, "latlong", moving, size=4)
    with pytest.raises(ValueError, match="Expected `size`"):
        jax.jit(lambda fov: smj.convert(y, "latlong", camera(fov), antialias=False))(fov)
    cubes = smj.convert(
        y,
        "latlong",
        smj.projection("dual_fisheye", fov=jnp.asarray(190.0)),
        antialias=False,
        size=4,
    )
    wanted = sm.convert(
        y, "latlong", "dual_fisheye(fov=190)", antialias=False, size=4, channels_first=True
    )
    near(cubes, wanted)


@pytest.mark.parametrize(
    "name, key, value",
    [
        ("angular", "fov", 200.0),
        ("cylindrical", "fov", 200.0),
        ("camera_brown_conrady", "k1", -0.3),
    ],
)
def test_seams_and_outlines_are_those_of_the_numbers(name: str, key: str, value: float) -> None:
    """Other numbers make other seams, or another outline, unknown when a program is compiled."""
    p = sm.projection(name, **{key: value})
    d, x = random_directions(300, 4), random(p.shape(8), 1)
    found = jax.jit(lambda one: smj.sample(x, d, smj.projection(name, **{key: one})))(value)
    near(found, sm.sample(x, d, p))


def test_transforms() -> None:
    d = sm.decode(random((6, 2), 0), "perspective(fov=60)")
    x = random((3, 8, 8), 1)

    def total(fov: Any, d: Any) -> Any:
        p = smj.projection("perspective", fov=fov, aspect=1.2)
        seen = smj.sample(x, d, p, any_aspect=True)
        return (smj.decode(0.9 * smj.encode(d, p), p, axes="+x +y +z") ** 3).sum() + seen.sum()

    slope = jax.grad(total, (0, 1))
    fov = jnp.asarray(75.0)
    wanted = slope(fov, d)
    for a, b in zip(jax.jit(slope)(fov, d), wanted, strict=True):
        close(a, b)
    close(jax.jvp(total, (fov, d), (jnp.ones(()), np.zeros_like(d)))[1], wanted[0])
    several, many = jnp.stack([fov, fov + 10]), np.stack([d, d[::-1]])
    each = [slope(one, d) for one in several]
    pairs = [slope(one, two) for one, two in zip(several, many, strict=True)]
    alike = [slope(fov, one) for one in many]
    for axes, given, alone in (
        ((0, None), (several, d), each),
        ((0, 0), (several, many), pairs),
        ((None, 0), (fov, many), alike),
    ):
        found = jax.jit(jax.vmap(slope, axes))(*given)
        for k in range(2):
            close(found[k], np.stack([one[k] for one in alone]))
    grid = jax.vmap(jax.vmap(slope, (None, 0)), (0, None))(several, many)
    close(grid[0][1, 0], pairs[0][0] * 0 + slope(several[1], many[0])[0])
    assert jax.local_device_count() == 2
    spread = jax.pmap(slope)(several, many)
    for k in range(2):
        close(spread[k], np.stack([one[k] for one in pairs]))


def test_a_camera_comes_back_from_its_picture() -> None:
    """Its field of view and where it looks, from a picture of smooth light, by a compiled step."""
    world = sm.directions("latlong", 64)
    environment = np.exp(world @ [0.5, 0.3, -0.8]) + np.sin(3 * world[..., 0])
    pose = sm.rotation(8, 4, -2)
    truth = sm.projection("perspective", fov=70.0).turned(pose)
    photo = sm.convert(environment, "latlong", truth, size=24, antialias=False)

    def residual(numbers: Any) -> Any:
        a, b, c = numbers[:3]
        turn = jax.scipy.linalg.expm(jnp.array([[0, -c, b], [c, 0, -a], [-b, a, 0]]))
        camera = smj.projection("perspective", fov=numbers[3] * 60)
        d = smj.directions(camera, 24, rotation=turn, dtype=jnp.float64)
        return (smj.sample(environment, d, "latlong") - photo).ravel()

    both = jax.jit(lambda numbers: (residual(numbers), jax.jacfwd(residual)(numbers)))
    numbers = jnp.array([0.0, 0.0, 0.0, 0.9])
    for _ in range(12):
        # Gauss and Newton.
        error, slopes = both(numbers)
        numbers = numbers - jnp.linalg.lstsq(slopes, error)[0]
    # Lookups bend at texels; where they do not, the step ends at rounding.
    assert abs(numbers[3] * 60 - 70) < 1e-3


def test_no_gradient_is_silently_wrong() -> None:
    def u(fov: Any) -> Any:
        return smj.encode(jnp.array([0.1, 0.2, -1.0]), smj.projection("perspective", fov=fov))[0]

    with pytest.raises(NotImplementedError, match="no second derivative"):
        jax.hessian(u)(60.0)
    x, d = random((6, 6), 1), random_directions(3, 5)

    def seen(fov: Any, filter: str) -> Any:
        return smj.sample(x, d, smj.projection("perspective", fov=fov), filter=filter).sum()

    with pytest.raises(NotImplementedError, match="`sample` has a derivative by direction"):
        jax.grad(seen)(60.0, "nearest")
    with pytest.raises(NotImplementedError, match="no second derivative"):
        jax.hessian(seen)(60.0, "bilinear")


def test_kinds_of_numbers() -> None:
    assert smj.projection("perspective", fov=60.0) == sm.projection("perspective", fov=60.0)
    assert smj.projection("perspective", fov=np.float32(60)) == sm.projection("perspective", fov=60)
    base = sm.projection("perspective", aspect=2.0, axes="+x +y +z").turned(sm.rotation(10))
    d = jnp.asarray(sm.decode([[0.3, 0.4]], base)).astype(jnp.bfloat16)

    def u(fov: Any) -> Any:
        uv = smj.encode(d, smj.projection(base, fov=fov))
        assert uv.dtype == jnp.bfloat16
        return uv[0, 0].astype(jnp.float32)

    slope = jax.grad(u)(jnp.float32(60.0))
    assert slope.dtype == jnp.float32 and slope != 0
    assert "fov=Array(60." in repr(smj.projection("perspective", fov=jnp.float32(60)))


def test_what_is_left_out_spoils_nothing() -> None:
    d = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])

    def total(fov: Any, d: Any) -> Any:
        uv = smj.encode(d, smj.projection("perspective", fov=fov))
        return jnp.where(jnp.isnan(uv), 0.0, uv).sum()

    for slope in jax.grad(total, (0, 1))(60.0, d):
        assert np.isfinite(slope).all()


def test_errors_say_what_was_expected() -> None:
    fov = jnp.asarray(60.0)
    with pytest.raises(ValueError, match="did you mean 'fov'"):
        smj.projection("perspective", fovv=fov)
    with pytest.raises(ValueError, match="did you mean 'fov'"):
        jax.jit(lambda one: smj.encode(jnp.ones(3), smj.projection("perspective", fovv=one)))(fov)
    with pytest.raises(ValueError, match="fov"):
        smj.projection("perspective", fov=jnp.asarray(400.0))
    with pytest.raises(ValueError, match=r"Expected `fov` to be one float.*shape \(2,\)"):
        smj.projection("perspective", fov=jnp.zeros(2))
    with pytest.raises(ValueError, match=r"Expected `fov` to be one float.*int64"):
        smj.projection("perspective", fov=jnp.asarray(60))
    with pytest.raises(TypeError, match="parameters alone beside a Projection"):
        smj.projection(sm.projection("perspective"), fov=fov, axes="+x +y +z")
    moving = smj.projection("perspective", fov=fov)
    for verb in (smj.jacobian, smj.density):
        with pytest.raises(TypeError, match="no derivative by parameters"):
            verb(jnp.zeros(2), moving)
    with pytest.raises(Exception, match="fov"):
        wrong = jax.jit(lambda one: smj.encode(jnp.ones(3), smj.projection("perspective", fov=one)))
        wrong(400.0).block_until_ready()
