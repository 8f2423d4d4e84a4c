"""Harmonics, light and packing: values of NumPy, exact adjoints, gradients, transforms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES, random_directions

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402
from spheremap.torch import _operators  # noqa: E402

pytestmark = [
    pytest.mark.programs,
    # What torch's own forward rules are made of, it has deprecated.
    pytest.mark.filterwarnings("ignore:.*torch.jit.script:FutureWarning"),
]

# Sums of some hundred products of order 1, and a fit of a residual of 1e-13.
EXACT = {"rtol": 1e-11, "atol": 1e-11}


def random(shape: tuple[int, ...], seed: int) -> Any:
    return torch.from_numpy(np.random.default_rng(seed).random(shape))


def as_torch(p: sm.Projection, size: int) -> Any:
    """Return two images of three channels, as torch has them."""
    x = random((2, 3, *p.shape(size)), 1)
    return (x.movedim(1, 2) if x.ndim == 5 else x).contiguous()


@pytest.mark.parametrize("texels", ["means", "points"])
@pytest.mark.parametrize("case", NAMES)
def test_projecting_is_numpys_and_has_an_exact_adjoint(case: str, texels: str) -> None:
    p = sm.projection(case)
    x = as_torch(p, 16).requires_grad_()
    found = smt.sh.project(x, p, order=2, texels=texels)
    last = x.detach().movedim(2 if x.ndim == 5 else 1, -1).numpy()
    wanted = np.stack([sm.sh.project(one, p, order=2, texels=texels).T for one in last])
    torch.testing.assert_close(found.detach(), torch.from_numpy(wanted), **EXACT)
    y = random(tuple(found.shape), 2).requires_grad_()
    (back,) = torch.autograd.grad((found * y).sum(), x, create_graph=True)
    # The product is linear in the image, so that it is what flows back times the image.
    torch.testing.assert_close((back * x).sum(), (found * y).sum(), **EXACT)
    other = random(tuple(x.shape), 3)
    (again,) = torch.autograd.grad((back * other).sum(), y)
    torch.testing.assert_close(again, smt.sh.project(other, p, order=2, texels=texels), **EXACT)


@pytest.mark.parametrize("case", ["latlong", "cube", "octahedral", "perspective"])
def test_other_devices_project_alike(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    p = sm.projection(case)
    x, d = as_torch(p, 16), torch.from_numpy(random_directions(30, 1))
    wanted = smt.sh.project(x, p, order=3)
    values = smt.sh.evaluate(wanted, d)
    monkeypatch.setattr(_operators, "_KERNELS_ON", "no device")
    torch.testing.assert_close(smt.sh.project(x, p, order=3), wanted, **EXACT)
    torch.testing.assert_close(smt.sh.evaluate(wanted, d), values, **EXACT)


@pytest.mark.parametrize("order", [0, 1, 3, 8])
def test_evaluating_and_turning_have_gradients(order: int) -> None:
    c = random((2, (order + 1) ** 2), 4).requires_grad_()
    d = (2 * torch.from_numpy(random_directions(5, 3))).requires_grad_()
    wanted = sm.sh.evaluate(c.detach().numpy().T, d.detach().numpy()).T
    torch.testing.assert_close(smt.sh.evaluate(c, d).detach(), torch.from_numpy(wanted), **EXACT)
    assert torch.autograd.gradcheck(smt.sh.evaluate, (c, d))
    assert torch.autograd.gradgradcheck(smt.sh.evaluate, (c, d))
    along = torch.func.jvp(lambda d: smt.sh.evaluate(c.detach(), d), (d,), (torch.ones_like(d),))[1]
    (reverse,) = torch.autograd.grad(smt.sh.evaluate(c, d).sum(), d)
    torch.testing.assert_close(along.sum(), reverse.sum(), **EXACT)
    turn = torch.from_numpy(sm.rotation(30, 20, 10))
    wanted = torch.from_numpy(sm.sh.rotate(c.detach().numpy().T, turn.numpy()).T)
    torch.testing.assert_close(smt.sh.rotate(c, turn.numpy()).detach(), wanted, **EXACT)
    moving = turn.requires_grad_()
    torch.testing.assert_close(smt.sh.rotate(c, moving).detach(), wanted, **EXACT)
    if order < 8:
        assert torch.autograd.gradcheck(smt.sh.rotate, (c, moving))
    factors = torch.linspace(1, 2, order + 1, dtype=c.dtype)
    wanted = torch.from_numpy(sm.sh.convolve(c.detach().numpy().T, lobe=factors.numpy()).T)
    torch.testing.assert_close(smt.sh.convolve(c, lobe=factors).detach(), wanted, **EXACT)


def test_what_has_no_direction_spoils_nothing() -> None:
    c = random((9,), 1)
    d = torch.tensor([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]], dtype=c.dtype, requires_grad=True)
    found = smt.sh.evaluate(c, d)
    assert found[0].isnan() and found[1].isfinite()
    found[1].backward()
    assert d.grad is not None and d.grad.isfinite().all() and (d.grad[1] != 0).any()
    with pytest.raises(NotImplementedError, match="Above order 8"):
        smt.sh.evaluate(random((100,), 1), d).sum().backward()


@pytest.mark.parametrize("src, dst", [("latlong", "cube"), ("cube", "octahedral")])
def test_irradiance_is_that_of_harmonics(src: str, dst: str) -> None:
    x = as_torch(sm.projection(src), 16).requires_grad_()
    found = smt.light.irradiance(x, src, dst, size=4, order=4, rotation=sm.rotation(30))
    options: dict[str, Any] = {"size": 4, "method": "sh", "order": 4, "rotation": sm.rotation(30)}
    wanted = sm.light.irradiance(x.detach().numpy(), src, dst, channels_first=True, **options)
    torch.testing.assert_close(found.detach(), torch.from_numpy(wanted), **EXACT)
    (back,) = torch.autograd.grad(found.sum(), x)
    torch.testing.assert_close((back * x).sum(), found.sum(), **EXACT)


def test_what_is_no_number_flows_through() -> None:
    x = random((3, 16, 32), 1).requires_grad_()
    # Its corners have no normal.
    found = smt.light.irradiance(x, "latlong", "matcap", size=8, order=2)
    (back,) = torch.autograd.grad(found.sum(), x)
    torch.testing.assert_close((back * x).sum(), found.sum(), **EXACT)
    gradient = torch.ones(3, 9, dtype=x.dtype)
    gradient[1, 2] = torch.nan
    (back,) = torch.autograd.grad(smt.sh.project(x, "latlong", order=2), x, gradient)
    assert back[1].isnan().all() and back[[0, 2]].isfinite().all()
    c = random((9,), 1).requires_grad_()
    values = smt.sh.evaluate(c, torch.tensor([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]], dtype=c.dtype))
    (back,) = torch.autograd.grad(values.nan_to_num().sum(), c)
    assert back.isfinite().all() and (back != 0).all()


def test_turning_and_evaluating_have_forward_derivatives() -> None:
    x, c = random((16, 32), 1), random((9,), 2)
    turn = torch.from_numpy(sm.rotation(30, 20, 10))
    d = torch.from_numpy(random_directions(5, 3))
    verbs = [
        lambda r: smt.sh.rotate(c, r),
        lambda r: smt.sh.project(x, "latlong", order=2, rotation=r),
        lambda r: smt.light.irradiance(x, "latlong", "cube", size=2, order=2, rotation=r),
        lambda d: smt.sh.evaluate(c, d),
    ]
    for verb, at in zip(verbs, (turn, turn, turn, d), strict=True):
        forward = torch.func.jacfwd(verb)(at)
        torch.testing.assert_close(forward, torch.func.jacrev(verb)(at), **EXACT)
        with torch.autograd.forward_ad.dual_level():
            dual = verb(torch.autograd.forward_ad.make_dual(at, torch.ones_like(at)))
            tangent = torch.autograd.forward_ad.unpack_dual(dual).tangent
            torch.testing.assert_close(tangent.sum(), forward.sum(), **EXACT)


@pytest.mark.parametrize("case", ["latlong", "cube", "octahedral", "sphere"])
def test_a_distribution_is_numpys(case: str) -> None:
    p = sm.projection(case)
    x = as_torch(p, 8)[0].requires_grad_()
    ours = smt.light.Distribution(x, p)
    last = x.detach().movedim(1 if x.ndim == 4 else 0, -1).numpy()
    theirs = sm.light.Distribution(last, p)
    xi = random((200, 2), 5)
    d, pdf = ours.sample(xi)
    assert np.array_equal(d.numpy(), theirs.sample(xi.numpy())[0])
    assert np.array_equal(pdf.numpy(), theirs.sample(xi.numpy())[1])
    assert np.array_equal(ours.pdf(d).numpy(), theirs.pdf(d.numpy()))
    assert ours.integral == theirs.integral
    none = torch.tensor([[0.0, 0.0, 0.0], [torch.nan, 0.0, 1.0]])
    assert ours.pdf(none).isnan().all()
    with pytest.raises(ValueError, match="of one image"):
        smt.light.Distribution(as_torch(p, 8), p)


@pytest.mark.parametrize("name", ["oct16", "oct8x2", "oct32", "hemioct16", "rgb10a2"])
def test_packing_is_numpys_and_passes_gradients_through(name: str) -> None:
    d = torch.from_numpy(random_directions(50, 1)).float()
    d[:, 2] = d[:, 2].abs()
    d.requires_grad_()
    codes = smt.packing.pack(d, name)
    assert np.array_equal(codes.numpy(), sm.packing.pack(d.detach().numpy(), name))
    back = smt.packing.unpack(codes, name)
    assert np.array_equal(back.numpy(), sm.packing.unpack(codes.numpy(), name))
    weights = torch.linspace(0, 1, 3)
    found = smt.packing.quantize(d, name)
    (got,) = torch.autograd.grad((found * weights).sum(), d)
    unit = torch.nn.functional.normalize(d, dim=-1)
    (wanted,) = torch.autograd.grad((unit * weights).sum(), d)
    torch.testing.assert_close(got, wanted, rtol=0.0, atol=0.0)
    # A direction and its length of 1 may round to two codes.
    assert (found.detach() - unit).norm(dim=-1).max() <= sm.packing.packing(name).bound + 5e-7
    compiled = torch.compile(smt.packing.quantize, fullgraph=True, backend="aot_eager")
    torch.testing.assert_close(compiled(d, name), found, rtol=0.0, atol=0.0)
    one = torch.func.vmap(lambda one: smt.packing.quantize(one, name))(d)
    torch.testing.assert_close(one, found, rtol=0.0, atol=0.0)
    assert smt.packing.quantize(torch.zeros(3), name).isnan().all()


def test_harmonics_compile() -> None:
    x = as_torch(sm.projection("cube"), 8)
    d = torch.from_numpy(random_directions(20, 1))

    def total(x: Any, d: Any) -> Any:
        c = smt.sh.convolve(smt.sh.project(x, "cube", order=3), lobe="cosine")
        return (smt.sh.evaluate(c, d) ** 2).sum()

    x.requires_grad_(), d.requires_grad_()
    wanted = torch.autograd.grad(total(x, d), (x, d))
    compiled = torch.compile(total, fullgraph=True, backend="aot_eager")
    torch.testing.assert_close(torch.autograd.grad(compiled(x, d), (x, d)), wanted, **EXACT)
