"""What runs where there are no kernels: values, gradients, and what is compiled of it.

It runs on the CPU, whose kernels are kept away, and on a graphics card where there is one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES, random_directions
from smooth import WHOLE

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402
from spheremap.torch import _operators, _verbs  # noqa: E402

pytestmark = pytest.mark.programs

# Sums of some hundred products of order 1, in float64, in two orders.
EXACT = {"rtol": 1e-12, "atol": 1e-12}
SIZE = 12


@pytest.fixture(params=["cpu", "cuda"])
def device(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    if name == "cuda" and not torch.cuda.is_available():
        pytest.skip("there is no graphics card")
    return name


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_operators, "_KERNELS_ON", "no device")


def made(case: str) -> sm.Projection:
    name, _, layout = case.partition("/")
    return sm.projection(name, layout=layout) if layout else sm.projection(name)


def batch(p: sm.Projection) -> Any:
    """Return two images of three channels, as torch has them."""
    x = torch.from_numpy(np.random.default_rng(1).random((2, 3, *p.shape(SIZE))))
    return (x.movedim(1, 2) if x.ndim == 5 else x).contiguous().requires_grad_()


def with_gradient(verb: Any, x: Any) -> list[Any]:
    found = verb(x)
    weights = torch.linspace(0, 1, found.numel(), dtype=found.dtype).reshape(found.shape)
    weights = weights.to(found.device)
    (back,) = torch.autograd.grad((found * weights).sum(), x)
    return [found.detach().cpu(), back.cpu()]


def assert_alike(verb: Any, x: Any, device: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = with_gradient(verb, x)
    with monkeypatch.context() as patched:
        patched.setattr(_operators, "_KERNELS_ON", "no device")
        found = with_gradient(verb, x.detach().to(device).requires_grad_())
    torch.testing.assert_close(found, wanted, **EXACT)


@pytest.mark.parametrize("case", [*NAMES, "cube/cross"])
def test_images_and_their_gradients_are_those_of_the_kernels(
    case: str, device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    p = made(case)
    d = torch.from_numpy(random_directions(600, 1))
    # What no map covers.
    d[0], d[1] = 0.0, torch.nan
    x = batch(p)
    verbs = [
        lambda x: smt.convert(x, p, "octahedral", size=8, antialias=False, fill=0.5),
        lambda x: smt.convert(x, p, "cube", size=4),
        lambda x: smt.pad(x, p, 1),
        lambda x: smt.integrate(x, p),
    ]
    if not case.startswith("cube"):
        verbs.append(lambda x: smt.sample(x, d.to(x.device), p, fill=-1.0))
    for verb in verbs:
        assert_alike(verb, x, device, monkeypatch)


@pytest.mark.parametrize("case", ["cube", "cube/cross", "cube:unreal"])
def test_lookups_in_cubes_are_those_of_graphics_hardware_beside_edges(
    case: str, device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    p = sm.projection(case) if ":" in case else made(case)
    d = torch.from_numpy(random_directions(600, 1))
    x = batch(p)
    # A cross is four faces wide.
    side = x.shape[-1] if p.layout == "faces" else x.shape[-1] // 4
    inside = np.abs(sm.encode(d.numpy(), "cube")[..., :2] - 0.5).max(axis=-1) < 0.5 - 0.5 / side
    assert 0 < inside.sum() < len(d)
    assert_alike(lambda x: smt.sample(x, d[inside].to(x.device), p), x, device, monkeypatch)
    monkeypatch.setattr(_operators, "_KERNELS_ON", "no device")
    same = smt.sample(torch.ones_like(x, device=device), d.to(device), p)
    # Four weights, whose sum is 1.
    torch.testing.assert_close(same, torch.ones_like(same), **EXACT)


@pytest.mark.parametrize("case", [*WHOLE, "cube"])
def test_directions_have_the_gradient_of_a_lookup(case: str, elsewhere: None) -> None:
    p = sm.projection(case)
    d = torch.from_numpy(random_directions(200, 5))
    uv = p.encode(d.numpy())
    at = uv[..., :2] * p.shape(SIZE)[-1]
    # Differences step over a line between centers.
    near = np.abs(at - 0.5 - np.rint(at - 0.5)) < 1e-3
    middle = (np.abs(uv[..., :2] - 0.5) < 0.4).all(axis=-1) & (p.density(uv) > 1)
    d = d[middle & ~near.any(axis=-1)][:6].requires_grad_()
    x = batch(p).detach()
    assert len(d) == 6
    assert torch.autograd.gradcheck(lambda d: smt.sample(x, d, p), d)


@pytest.mark.parametrize("case", ["latlong", "cube", "cube/cross", "octahedral"])
def test_the_compiler_sees_operations_and_no_operator(case: str, elsewhere: None) -> None:
    from functorch.compile import make_boxed_func
    from torch._dynamo.backends.common import aot_autograd
    from torch._inductor.decomposition import select_decomp_table

    seen: list[str] = []

    def backend(graph: Any, example: Any) -> Any:
        def keep(inner: Any, _: Any) -> Any:
            seen.extend(str(node.target) for node in inner.graph.nodes)
            return make_boxed_func(inner)

        # The table as it is when the graph has been traced.
        table = select_decomp_table()
        return aot_autograd(fw_compiler=keep, bw_compiler=keep, decompositions=table)(
            graph, example
        )

    d = torch.from_numpy(random_directions(50, 2)).requires_grad_()
    p = made(case)
    x = batch(p)

    def total(d: Any, x: Any) -> Any:
        uv = smt.encode(d, p)
        back = smt.decode(uv, p)
        seen = smt.convert(x, p, "cube", size=8, antialias=False)
        return (back * smt.density(uv.detach(), p)[..., None]).sum() + (
            smt.sample(x, smt.reflect(d, d.detach().flip(-1)), p).sum() + (seen**2).sum()
        )

    wanted = torch.autograd.grad(total(d, x), (d, x))
    compiled = torch.compile(total, fullgraph=True, backend=backend)
    found = torch.autograd.grad(compiled(d, x), (d, x))
    torch.testing.assert_close(found, wanted, **EXACT)
    assert any("index_select" in name or "aten" in name for name in seen)
    assert not [name for name in seen if "spheremap" in name]


@pytest.mark.parametrize("case", NAMES)
def test_printed_code_agrees(case: str, device: str, elsewhere: None) -> None:
    d = torch.from_numpy(random_directions(200, 3))
    uv = smt.encode(d, case)
    for verb, data in (("encode", 1e-3 * d), ("decode", uv), ("density", uv), ("jacobian", uv)):
        found = getattr(_verbs, verb)(data.to(device), case).cpu()
        wanted = torch.from_numpy(np.asarray(getattr(sm, verb)(data.numpy(), case)))
        # A few units in the last place, of what is as large.
        scale = wanted.abs().nan_to_num(0.0).max()
        close = {"rtol": 1e-9, "atol": float(1e-12 * scale), "equal_nan": True}
        torch.testing.assert_close(found, wanted, **close)
