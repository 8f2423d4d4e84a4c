"""Derivatives of the verbs of one map: against differences, and under all that torch does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from smooth import CASES, smooth

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402

pytestmark = [
    pytest.mark.programs,
    # What torch's own forward rules are made of, it has deprecated.
    pytest.mark.filterwarnings("ignore:.*torch.jit.script:FutureWarning"),
]

# Kernels in float64 against themselves at the dtype's rounding: a few roundings each.
SAME = {"rtol": 0.0, "atol": 0.0}


def some(case: str, count: int = 4) -> tuple[Any, Any, Any]:
    d, uv, face = smooth(case, count)
    return torch.from_numpy(d), torch.from_numpy(uv), torch.from_numpy(face)


def whole(uv: Any, face: Any) -> Any:
    return torch.cat([uv, face], -1)


@pytest.mark.parametrize("case", CASES)
def test_values_are_those_of_numpy(case: str) -> None:
    d, uv, face = some(case)
    at = whole(uv, face)
    p = sm.projection(case)
    for dtype in (torch.float32, torch.float64):
        for name, data in (("encode", d), ("decode", at), ("jacobian", at), ("density", at)):
            given = data.to(dtype)
            found = getattr(smt, name)(given, p)
            assert found.dtype == dtype
            wanted = torch.from_numpy(getattr(sm, name)(given.numpy(), p))
            torch.testing.assert_close(found, wanted, **SAME)


@pytest.mark.parametrize("case", CASES)
def test_first_and_second_derivatives_are_those_of_differences(case: str) -> None:
    d, uv, face = some(case, 2)
    verbs: list[tuple[Callable[[Any], Any], Any]] = [
        (lambda x: smt.encode(x, case)[..., :2], 1.5 * d),
        (lambda x: smt.decode(whole(x, face), case), uv),
    ]
    for verb, at in verbs:
        at = at.clone().requires_grad_()
        # Forward, in batches and reverse, at gradcheck's own bounds for float64.
        assert torch.autograd.gradcheck(verb, at, check_forward_ad=True, check_batched_grad=True)
        assert torch.autograd.gradgradcheck(verb, at)


@pytest.mark.parametrize("case", CASES)
def test_derivatives_of_derivatives_are_those_of_differences(case: str) -> None:
    _, uv, face = some(case, 2)
    for name in ("jacobian", "density"):

        def verb(x: Any, name: str = name) -> Any:
            return getattr(smt, name)(whole(x, face), case)

        at = uv.clone().requires_grad_()
        assert torch.autograd.gradcheck(verb, at)
        tangent = torch.ones_like(uv)
        forward = torch.func.jvp(verb, (uv,), (tangent,))[1]
        columns = torch.autograd.functional.jacobian(verb, uv)
        reverse = torch.tensordot(columns, tangent, 2)
        # Both are sums of the same two columns.
        torch.testing.assert_close(forward, reverse, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_printed_code_of_other_devices_agrees(case: str) -> None:
    from spheremap.torch import _printed, _verbs

    d, uv, face = some(case, 40)
    for name, data in (("encode", 1e-3 * d), ("decode", whole(uv, face))):
        found = _printed.run(name, data, case)
        # A few units in the last place, and the turn of a latlong from 1 to 0.
        torch.testing.assert_close(found, getattr(_verbs, name)(data, case), rtol=0, atol=1e-13)
    outside = torch.tensor([[np.nan, 0.0, 1.0], [0.0, 0.0, 0.0]], dtype=torch.float64)
    assert _printed.run("encode", outside, case).isnan().all()


def test_rotation_and_reflection_have_gradients() -> None:
    d = torch.from_numpy(random_directions(5, 1))
    turn = torch.from_numpy(sm.rotation(30, 20, 10)).requires_grad_()
    # One product more than the kernel that turns, of components up to 1.
    close = {"rtol": 0.0, "atol": 1e-15}
    found = smt.encode(d, "octahedral", rotation=turn)
    wanted = smt.encode(d, "octahedral", rotation=turn.detach().numpy())
    torch.testing.assert_close(found, wanted, **close)
    assert torch.autograd.gradcheck(lambda r: smt.encode(d, "octahedral", rotation=r), turn)
    assert torch.autograd.gradcheck(
        lambda r: smt.decode(found.detach(), "octahedral", rotation=r), turn
    )
    view, normal = (torch.from_numpy(random_directions(3, k)).requires_grad_() for k in (4, 5))
    assert torch.autograd.gradcheck(smt.reflect, (view, normal))
    wanted = torch.from_numpy(sm.reflect(view.detach().numpy(), normal.detach().numpy()))
    torch.testing.assert_close(smt.reflect(view, normal).detach(), wanted, **close)


def test_what_is_left_out_spoils_nothing() -> None:
    d = torch.tensor([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], requires_grad=True)
    uv = smt.encode(d, "perspective")
    assert uv[1].isnan().all()
    torch.where(uv.isnan(), 0.0, uv).sum().backward()
    assert d.grad is not None and d.grad.isfinite().all()
    assert (d.grad[1] == 0).all() and (d.grad[0] != 0).any()


@pytest.mark.parametrize("size", [1e20, 1e-30])
def test_lengths_have_no_say(size: float) -> None:
    """In float32 the squares of these are infinite or zero."""
    v, n = torch.tensor([1.0, 2.0, 3.0]), torch.tensor([0.5, -1.0, 2.0])

    def slopes(factor: float) -> list[Any]:
        one, two = ((factor * x).requires_grad_() for x in (v, n))
        mirrored = smt.reflect(one.detach() / factor, two)
        found = [smt.encode(one, "latlong")[0], smt.packing.quantize(one, "oct32")[0], mirrored[0]]
        back = [
            torch.autograd.grad(value, x)[0]
            for value, x in zip(found, (one, one, two), strict=True)
        ]
        along = torch.func.jvp(lambda d: smt.encode(d, "latlong"), (factor * v,), (factor * n,))[1]
        scaled = smt.reflect(factor * v, factor * n) / factor
        return [*(factor * one for one in back), along, scaled, *(x.detach() for x in found)]

    # Some roundings in float32 of numbers of order 1.
    torch.testing.assert_close(slopes(size), slopes(1.0), rtol=1e-5, atol=1e-6)


def test_what_has_no_direction_spoils_nothing() -> None:
    n = torch.tensor([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [torch.nan, 0.0, 1.0]], requires_grad=True)
    for found in (smt.reflect(torch.ones(3), n), smt.packing.quantize(n, "oct32")):
        assert found[[0, 2]].isnan().all() and found[1].isfinite().all()
        (back,) = torch.autograd.grad(found.nan_to_num()[:, 0].sum(), n)
        assert (back[[0, 2]] == 0).all() and (back[1] != 0).all()


def test_autocast_changes_no_number() -> None:
    d, uv = torch.from_numpy(random_directions(5, 1)).float(), torch.rand(5, 2)
    turn = torch.from_numpy(sm.rotation(30, 20, 10)).float()

    def all_of() -> list[Any]:
        c = smt.sh.rotate(torch.linspace(0, 1, 9), turn.clone().requires_grad_()).detach()
        return [
            smt.encode(d, "latlong", rotation=turn),
            smt.decode(uv, "latlong", rotation=turn),
            smt.jacobian(uv, "latlong", rotation=turn),
            smt.directions("cube", 4, rotation=turn),
            smt.sh.evaluate(c, d),
        ]

    with torch.autocast("cpu", torch.bfloat16):
        found = all_of()
    torch.testing.assert_close(found, all_of(), **SAME)


def test_the_default_compiler_takes_it() -> None:
    """It writes out what runs where there are no kernels, and calls what runs here."""
    d = torch.from_numpy(random_directions(6, 2))

    def again(d: Any) -> Any:
        return smt.decode(smt.encode(d, "latlong"), "latlong")

    torch.testing.assert_close(torch.compile(again, fullgraph=True)(d), again(d), **SAME)


def test_transforms_compile_and_export() -> None:
    d = torch.from_numpy(random_directions(6, 2)).reshape(2, 3, 3)
    turned = sm.projection("octahedral").turned(sm.rotation(20))
    for p in ("cube", "latlong", turned):

        def total(x: Any, p: Any = p) -> Any:
            return (smt.decode(smt.encode(x, p), p) ** 3).sum()

        wanted = torch.func.grad(total)(d)
        each = torch.func.vmap(torch.func.grad(total))(d)
        # The same operations on the same numbers.
        torch.testing.assert_close(each, wanted, **SAME)
        compiled = torch.compile(total, fullgraph=True, backend="aot_eager")
        x = d.clone().requires_grad_()
        compiled(x).backward()
        torch.testing.assert_close(x.grad, wanted, **SAME)
        along = torch.func.jvp(total, (d,), (torch.ones_like(d),))[1]
        # A sum in another order, of numbers of order 1.
        torch.testing.assert_close(along, wanted.sum(), rtol=1e-12, atol=1e-12)

    mirrored = torch.compile(smt.reflect, fullgraph=True, backend="aot_eager")
    torch.testing.assert_close(mirrored(d, d + 1), smt.reflect(d, d + 1), **SAME)

    class Net(torch.nn.Module):
        def forward(self, x: Any) -> Any:
            return smt.encode(x, "latlong")

    exported = torch.export.export(Net(), (d,))
    torch.testing.assert_close(exported.module()(d), smt.encode(d, "latlong"), **SAME)


@pytest.mark.parametrize("dtype", ["float16", "bfloat16"])
def test_half_is_computed_in_float32(dtype: str) -> None:
    d = torch.from_numpy(random_directions(50, 2)).to(getattr(torch, dtype))
    found = smt.encode(d, "octahedral")
    assert found.dtype == d.dtype
    wanted = smt.encode(d.float(), "octahedral").to(d.dtype)
    torch.testing.assert_close(found, wanted, **SAME)


def test_errors_say_what_was_expected() -> None:
    with pytest.raises(TypeError, match=r"to be of floats, got torch\.int64"):
        smt.encode(torch.zeros(3, dtype=torch.int64), "latlong")
    with pytest.raises(TypeError, match="to be a tensor, got ndarray"):
        smt.encode(np.zeros(3), "latlong")
    with pytest.raises(ValueError, match=r"to be \(\.\.\., 3\)"):
        smt.encode(torch.zeros(2), "latlong")
    with pytest.raises(ValueError, match=r"to be \(\.\.\., 3\)"):
        smt.decode(torch.zeros(2), "cube")
    with pytest.raises(ValueError, match="latlang"):
        smt.encode(torch.zeros(3), "latlang")
    with pytest.raises(ValueError, match=r"`view` to be \(\.\.\., 3\)"):
        smt.reflect(torch.zeros(2), torch.zeros(2))
    with pytest.raises(TypeError, match="`view` to be a tensor, got ndarray"):
        smt.reflect(np.zeros(3), torch.zeros(3))
    with pytest.raises(NotImplementedError, match="`density` has no second derivative"):
        uv = torch.tensor([0.4, 0.6], requires_grad=True)
        (first,) = torch.autograd.grad(smt.density(uv, "sphere"), uv, create_graph=True)
        first.sum().backward()
