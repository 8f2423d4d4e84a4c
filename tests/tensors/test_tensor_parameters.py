"""Parameters of maps as tensors: against differences, closed forms and OpenCV's derivatives."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES, REGISTRY, random_directions
from moving_cases import CASES, maximum
from smooth import smooth

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402

pytestmark = [
    pytest.mark.programs,
    # What torch's own forward rules are made of, it has deprecated.
    pytest.mark.filterwarnings("ignore:.*torch.jit.script:FutureWarning"),
]

SAME = {"rtol": 0.0, "atol": 0.0}
# Differences of fourth order at a step h = 3e-4: h⁴ and what kernels round over h are near 1e-12,
# times fifth derivatives of some hundreds.
SLOPE = {"rtol": 1e-9, "atol": 1e-9}


def test_every_map_that_has_parameters_is_here() -> None:
    with_parameters = {entry["name"] for entry in REGISTRY if entry["parameters"]}
    assert with_parameters == {name for name, _ in CASES}


def tensors(p: sm.Projection) -> list[Any]:
    return [torch.tensor(value, dtype=torch.float64) for value in p.parameters.values()]


def at(name: str, given: list[Any], names: tuple[str, ...]) -> Any:
    return smt.projection(name, **dict(zip(names, given, strict=True)))


@pytest.mark.parametrize("name, given", CASES)
def test_values_and_first_derivatives(name: str, given: dict[str, float]) -> None:
    p = sm.projection(name, **given)
    names, moving = tuple(p.parameters), [t.requires_grad_() for t in tensors(p)]
    d, uv, face = (torch.from_numpy(part) for part in smooth(p, 3))
    where = torch.cat([uv, face], -1)
    q = at(name, moving, names)
    torch.testing.assert_close(
        smt.encode(d, q).detach(), torch.from_numpy(sm.encode(d.numpy(), p)), **SAME
    )
    torch.testing.assert_close(
        smt.decode(where, q).detach(), torch.from_numpy(sm.decode(where.numpy(), p)), **SAME
    )
    # gradcheck's differences step over the end of a range.
    free = [k for k, key in enumerate(names) if p.parameters[key] < maximum(name, key)]

    def encode(x: Any, *some: Any) -> Any:
        return smt.encode(x, at(name, all_of(moving, free, some), names))[..., :2]

    def decode(x: Any, *some: Any) -> Any:
        return smt.decode(torch.cat([x, face], -1), at(name, all_of(moving, free, some), names))

    some = [moving[k] for k in free]
    for verb, x in ((encode, 1.5 * d), (decode, uv)):
        x.requires_grad_()
        assert torch.autograd.gradcheck(
            verb, (x, *some), check_forward_ad=True, check_batched_grad=True
        )


def all_of(moving: list[Any], free: list[int], some: tuple[Any, ...]) -> list[Any]:
    found = [t.detach() for t in moving]
    for k, tensor in zip(free, some, strict=True):
        found[k] = tensor
    return found


@pytest.mark.parametrize("fov", [0.5, 30.0, 90.0, 178.9, 179.0])
def test_a_field_of_view_has_the_closed_form(fov: float) -> None:
    """tan(fov/2) scales (u, v) about the middle, to the end of the range."""
    moving = torch.tensor(fov, dtype=torch.float64, requires_grad=True)
    d = torch.from_numpy(
        sm.decode(np.random.default_rng(0).random((50, 2)), f"perspective({fov=})")
    )
    uv = smt.encode(d, smt.projection("perspective", fov=moving))
    (found,) = torch.autograd.grad(uv[:, 0].sum(), moving)
    half = math.radians(fov) / 2
    slope = -(uv[:, 0] - 0.5).sum() * math.radians(1) / math.sin(2 * half)
    # sin fov comes from tan: near 179° the step of 3e-4 of it is 0.05°, of the 1° that is left.
    close = {"rtol": 1e-4 if fov > 178 else 1e-9, "atol": 1e-12}
    torch.testing.assert_close(found, slope.detach(), **close)


@pytest.mark.parametrize("model", ["camera_brown_conrady", "camera_kannala_brandt"])
def test_calibrations_have_the_derivatives_of_opencv(model: str) -> None:
    """cv2 gives ∂(x, y) by focal lengths, principal point and coefficients, in closed form."""
    given = {"fx": 0.7, "fy": 0.6, "cx": 0.02, "cy": -0.01, "k1": 0.05, "k2": -0.01}
    given |= {"p1": 1e-3, "p2": -2e-3} if model == "camera_brown_conrady" else {}
    given |= {"k3": 2e-3, "k4": 1e-3}
    moving = {
        key: torch.tensor(value, dtype=torch.float64, requires_grad=True)
        for key, value in given.items()
    }
    p = sm.projection(model, **given)
    # OpenCV's z looks ahead, y down.
    view = np.random.default_rng(1).uniform([-0.4, -0.4, 1], [0.4, 0.4, 1], (20, 3))
    d = torch.from_numpy(view * [1, -1, -1])
    assert np.isfinite(sm.encode(d.numpy(), p)).all()
    # In widths and heights: an image of one pixel, whose center has a whole number.
    K = np.array([[given["fx"], 0, given["cx"]], [0, given["fy"], given["cy"]], [0, 0, 1.0]])
    none, points = np.zeros(3), view[:, None]
    if model == "camera_brown_conrady":
        order = ("k1", "k2", "p1", "p2", "k3", "k4")
        D = np.array([given[key] for key in order] + [0.0, 0.0])
        places, slopes = cv2.projectPoints(points, none, none, K, D)
        columns = dict(zip(("fx", "fy", "cx", "cy", *order), slopes[:, 6:].T, strict=False))
    else:
        order = ("k1", "k2", "k3", "k4")
        D = np.array([given[key] for key in order])
        places, slopes = cv2.fisheye.projectPoints(points, none, none, K, D)
        columns = dict(zip(("fx", "fy", "cx", "cy", *order), slopes[:, :8].T, strict=True))
    uv = smt.encode(d, smt.projection(model, **moving))
    # The two solve the same equations; a fisheye's angle is an arctangent.
    np.testing.assert_allclose(uv.detach().numpy() - 0.5, places[:, 0], rtol=0, atol=1e-12)
    for axis in range(2):
        weights = torch.linspace(1, 2, len(d), dtype=torch.float64)
        found = torch.autograd.grad(
            (uv[:, axis] * weights).sum(), list(moving.values()), retain_graph=True
        )
        for key, slope in zip(moving, found, strict=True):
            wanted = (columns[key].reshape(-1, 2)[:, axis] * weights.numpy()).sum()
            torch.testing.assert_close(slope.item(), float(wanted), **SLOPE)


def test_images_move_with_parameters() -> None:
    """`sample` and `convert` of maps that move, against what they are of maps that stand."""
    x = torch.from_numpy(np.random.default_rng(0).random((2, 32, 32)))
    fov = torch.tensor(80.0, dtype=torch.float64, requires_grad=True)
    d = torch.from_numpy(random_directions(400, 1))
    view = torch.from_numpy(sm.directions("perspective(fov=60)", 8))
    moving, still = smt.projection("perspective", fov=fov), "perspective(fov=80.0)"
    # Directions are decoded once more: a few roundings, 32 columns of slopes up to 1.
    close = {"rtol": 0.0, "atol": 1e-12}
    torch.testing.assert_close(smt.sample(x, d, moving).detach(), smt.sample(x, d, still), **close)
    assert torch.autograd.gradcheck(
        lambda fov: smt.sample(x, view, smt.projection("perspective", fov=fov)), fov
    )
    y = torch.from_numpy(np.random.default_rng(0).random((3, 8, 16)))
    turn = sm.rotation(20, 10)
    options: dict[str, Any] = {"size": 5, "antialias": False, "rotation": turn}

    def convert(fov: Any) -> Any:
        return smt.convert(y, "latlong:blender", smt.projection("perspective", fov=fov), **options)

    wanted = smt.convert(y, "latlong:blender", still, **options)
    torch.testing.assert_close(convert(fov).detach(), wanted, **close)
    torch.testing.assert_close(convert(fov.detach()), wanted, **SAME)
    assert torch.autograd.gradcheck(convert, fov)
    found = smt.convert(x, moving, "latlong", size=8, antialias=False, rotation=turn)
    wanted = smt.convert(x, still, "latlong", size=8, antialias=False, rotation=turn)
    torch.testing.assert_close(found.detach(), wanted, **close)
    assert torch.autograd.grad(found.sum(), fov)[0] != 0
    with pytest.raises(ValueError, match="parameters of maps with filter='bilinear'"):
        smt.convert(y, "latlong", moving, size=5)
    grid = smt.directions(moving, 6, rotation=turn, dtype=torch.float64)
    wanted = torch.from_numpy(sm.directions(still, 6, rotation=turn))
    torch.testing.assert_close(grid.detach(), wanted, **close)
    assert torch.autograd.gradcheck(
        lambda fov: smt.directions(smt.projection("perspective", fov=fov), 3, dtype=torch.float64),
        fov,
    )


def test_what_is_left_out_spoils_nothing() -> None:
    """What one end of a lens cuts off when it moves still has a derivative; the rest has none."""
    fov = torch.tensor(100.0, dtype=torch.float64, requires_grad=True)
    edge = sm.decode([[0.5, 1.0], [1.0, 0.5], [0.5, 0.5]], "perspective(fov=100)")
    d = torch.from_numpy(np.concatenate([edge, [[0.0, 0.0, 1.0]]]))
    uv = smt.encode(d, smt.projection("perspective", fov=fov))
    assert uv[3].isnan().all()
    (slope,) = torch.autograd.grad(torch.where(uv.isnan(), 0.0, uv)[:, 0].sum(), fov)
    # Of u = 1 alone: -½ · 1° / sin 100°.
    assert abs(slope.item() + 0.5 * math.radians(1) / math.sin(math.radians(100))) < 1e-9
    # A polynomial that ends inside the picture, and ends elsewhere when its coefficient moves.
    given = {"fx": 0.3, "fy": 0.3, "k1": -0.05}
    p = sm.projection("camera_brown_conrady", **given)
    uv = np.random.default_rng(0).random((20_000, 2))
    uv = torch.from_numpy(uv[sm.valid(uv, p)])
    k1 = torch.tensor(given["k1"], dtype=torch.float64, requires_grad=True)
    q = smt.projection("camera_brown_conrady", fx=0.3, fy=0.3, k1=k1)
    assert 1000 < len(uv) < 19_000
    (slope,) = torch.autograd.grad(smt.decode(uv, q).sum(), k1)
    assert slope.isfinite()


def test_transforms_and_compilation() -> None:
    d = torch.from_numpy(sm.decode(np.random.default_rng(0).random((6, 2)), "perspective(fov=60)"))

    def total(fov: Any, d: Any) -> Any:
        p = smt.projection("perspective", fov=fov, aspect=1.2)
        return (smt.decode(0.9 * smt.encode(d, p), p, axes="+x +y +z") ** 3).sum()

    fov = torch.tensor(75.0, dtype=torch.float64)
    wanted = torch.func.grad(total, argnums=(0, 1))(fov, d)
    compiled = torch.compile(total, fullgraph=True, backend="aot_eager")
    leaves = fov.clone().requires_grad_(), d.clone().requires_grad_()
    torch.testing.assert_close(torch.autograd.grad(compiled(*leaves), leaves), wanted, **SAME)
    along = torch.func.jvp(total, (fov, d), (torch.ones_like(fov), torch.zeros_like(d)))[1]
    # The same products in another order.
    torch.testing.assert_close(along, wanted[0], rtol=1e-12, atol=1e-12)
    several = torch.stack([fov, fov + 10])
    each = torch.func.vmap(torch.func.grad(total), in_dims=(0, None))(several, d)
    alone = torch.stack([torch.func.grad(total)(one, d) for one in several])
    torch.testing.assert_close(each, alone, **SAME)


def test_hidden_numbers_are_followed() -> None:
    """Under `vmap`, forward and in compiled programs, in maps whose seam the number decides."""
    x = torch.from_numpy(np.random.default_rng(0).random((2, 8, 16)))
    d = torch.from_numpy(random_directions(20, 2))

    def seen(fov: Any) -> Any:
        return smt.sample(x, d, smt.projection("cylindrical", fov=fov), any_aspect=True)

    def pictured(fov: Any) -> Any:
        p = smt.projection("perspective", fov=fov)
        return smt.convert(x, "latlong", p, size=4, antialias=False)

    several = torch.tensor([200.0, 360.0], dtype=torch.float64), torch.tensor([30.0, 60.0]).double()
    for verb, values in zip((seen, pictured), several, strict=True):
        alone = torch.stack([verb(one) for one in values])
        assert (alone[0] != alone[1]).any()
        # Directions are decoded and encoded once more: 16 columns of slopes up to 1.
        close = {"rtol": 0.0, "atol": 1e-12}
        torch.testing.assert_close(torch.func.vmap(verb)(values), alone, **close)
        compiled = torch.compile(verb, fullgraph=True, backend="aot_eager")
        torch.testing.assert_close(torch.stack([compiled(one) for one in values]), alone, **close)
        fov = values[0].clone().requires_grad_()
        (reverse,) = torch.autograd.grad(verb(fov).sum(), fov)
        forward = torch.func.jvp(verb, (values[0],), (torch.ones_like(values[0]),))[1].sum()
        # The same products in another order.
        torch.testing.assert_close(forward, reverse, rtol=1e-10, atol=1e-10)
        assert reverse != 0
    with pytest.raises(ValueError, match="Expected `size` as all sides"):
        torch.func.vmap(lambda a: smt.directions(smt.projection("perspective", aspect=a), 4))(
            several[1]
        )
    with pytest.raises(ValueError, match="numbers that `vmap` or the compiler hides"):
        torch.func.vmap(
            lambda a: smt.convert(x, "latlong", smt.projection("perspective", fov=a), size=4)
        )(several[1])


def test_kinds_of_numbers() -> None:
    assert smt.projection("perspective", fov=60.0) == sm.projection("perspective", fov=60.0)
    fov = torch.tensor(60.0, requires_grad=True)
    base = sm.projection("perspective", aspect=2.0, axes="+x +y +z").turned(sm.rotation(10))
    moving = smt.projection(base, fov=fov)
    d = torch.from_numpy(sm.decode([[0.3, 0.4]], base)).half()
    uv = smt.encode(d, moving)
    assert uv.dtype == torch.float16
    uv[0, 0].backward()
    assert fov.grad is not None and fov.grad.dtype == torch.float32
    assert "fov=tensor(60." in repr(moving)
    for name in NAMES:
        p = sm.projection(name)
        if not p.parameters:
            with pytest.raises(ValueError, match="fov"):
                smt.projection(name, fov=fov)


def test_errors_say_what_was_expected() -> None:
    fov = torch.tensor(60.0, requires_grad=True)
    with pytest.raises(ValueError, match="did you mean 'fov'"):
        smt.projection("perspective", fovv=fov)
    with pytest.raises(ValueError, match="fov"):
        smt.projection("perspective", fov=torch.tensor(400.0))
    with pytest.raises(ValueError, match=r"Expected `fov` to be one float.*shape \(2,\)"):
        smt.projection("perspective", fov=torch.zeros(2))
    with pytest.raises(ValueError, match=r"Expected `fov` to be one float.*int64"):
        smt.projection("perspective", fov=torch.tensor(60))
    with pytest.raises(TypeError, match="parameters alone beside a Projection"):
        smt.projection(sm.projection("perspective"), fov=fov, axes="+x +y +z")
    moving = smt.projection("perspective", fov=fov)
    for verb in (smt.jacobian, smt.density):
        with pytest.raises(TypeError, match="no derivative by parameters"):
            verb(torch.zeros(2), moving)
    with pytest.raises(NotImplementedError, match="tensors have no second derivative"):
        uv = smt.encode(torch.tensor([0.1, 0.2, -1.0]), moving)
        (first,) = torch.autograd.grad(uv.sum(), fov, create_graph=True)
        first.backward()
