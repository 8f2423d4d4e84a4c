"""Verbs of images: values of NumPy, exact adjoints, gradients of directions, shapes, transforms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import FILTERS, LOOKUPS, NAMES, assert_same_bits, random_directions
from smooth import WHOLE, inside

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402

pytestmark = [
    pytest.mark.programs,
    # What torch's own forward rules are made of, it has deprecated.
    pytest.mark.filterwarnings("ignore:.*torch.jit.script:FutureWarning"),
]

SAME = {"rtol": 0.0, "atol": 0.0}
# Two sums of some hundred products of order 1, in float64, in two orders: the issue's own bound.
EXACT = 1e-12
MEANS = [name for name in FILTERS if name != "mode"]


def made(case: str) -> sm.Projection:
    name, _, layout = case.partition("/")
    return sm.projection(name, layout=layout) if layout else sm.projection(name)


def covered(p: sm.Projection, count: int) -> Any:
    d = random_directions(200, 7)
    return d[~np.isnan(p.encode(d)[:, 0])][:count]


def random(shape: tuple[int, ...], seed: int) -> Any:
    return torch.from_numpy(np.random.default_rng(seed).random(shape))


def assert_adjoint(verb: Any, shape: tuple[int, ...]) -> None:
    """Hold ⟨A x, y⟩ to ⟨x, Aᵀ y⟩, and the second derivative to A again."""
    x, other = random(shape, 1).requires_grad_(), random(shape, 2)
    result = verb(x)
    y = random(tuple(result.shape), 3).requires_grad_()
    (back,) = torch.autograd.grad((result * y).sum(), x, create_graph=True)
    left, right = (verb(other) * y).sum(), (other * back).sum()
    assert abs(left - right) < EXACT * (1 + abs(left))
    (again,) = torch.autograd.grad((back * other).sum(), y)
    torch.testing.assert_close(again, verb(other).detach(), rtol=EXACT, atol=EXACT)
    tangent = torch.func.jvp(verb, (x.detach(),), (other,))[1]
    torch.testing.assert_close(tangent, verb(other).detach(), **SAME)


@pytest.mark.parametrize("case", [*NAMES, "cube/cross", "cube/strip"])
def test_lookups_have_exact_adjoints(case: str) -> None:
    p = made(case)
    d = torch.from_numpy(random_directions(400, 1))
    for filter in LOOKUPS:
        assert_adjoint(lambda x, f=filter: smt.sample(x, d, p, filter=f), p.shape(6))
    x = random(p.shape(6), 4)
    wanted = torch.from_numpy(sm.sample(x.numpy(), d.numpy(), p))
    torch.testing.assert_close(smt.sample(x, d, p), wanted, **SAME)


@pytest.mark.parametrize("filter", MEANS)
@pytest.mark.parametrize(
    "src, dst", [("latlong", "cube"), ("cube", "latlong"), ("angular", "cube")]
)
def test_conversions_have_exact_adjoints(src: str, dst: str, filter: str) -> None:
    shape = sm.projection(src).shape(8)

    def verb(x: Any) -> Any:
        return smt.convert(x, src, dst, size=4, filter=filter)

    assert_adjoint(verb, shape)
    x = random(shape, 4)
    wanted = torch.from_numpy(sm.convert(x.numpy(), src, dst, size=4, filter=filter))
    torch.testing.assert_close(verb(x), wanted, **SAME)


@pytest.mark.parametrize("case", [*NAMES, "cube/cross"])
def test_plain_lookups_borders_and_sums_have_exact_adjoints(case: str) -> None:
    p = made(case)
    shape = p.shape(6)
    assert_adjoint(lambda x: smt.convert(x, p, "latlong:blender", size=5, antialias=False), shape)
    assert_adjoint(lambda x: smt.pad(x, p, 2), shape)
    x = random(shape, 4).requires_grad_()
    total = smt.integrate(x, p)
    wanted = sm.light.integrate(x.detach().numpy(), p)
    # A sum of some hundred numbers in another order.
    assert abs(total.item() - wanted) < EXACT * wanted
    total.backward()
    torch.testing.assert_close(x.grad, torch.from_numpy(sm.light.weights(p, shape)), **SAME)


def test_large_conversions_by_polynomials_have_the_adjoint_of_what_they_do() -> None:
    """A block of a large image is converted by polynomials of its coordinates."""
    key_of = {"size": 64, "antialias": False}
    x, other = random((3, 128, 256), 1).requires_grad_(), random((3, 128, 256), 2)
    result = smt.convert(x, "latlong", "cube", **key_of)
    y = random(tuple(result.shape), 3)
    (back,) = torch.autograd.grad((result * y).sum(), x)
    left = (smt.convert(other, "latlong", "cube", **key_of) * y).sum()
    assert abs(left - (other * back).sum()) < EXACT * left


@pytest.mark.parametrize("case", [*NAMES, "cube/cross", "angular(fov=200)"])
def test_directions_have_the_gradient_of_a_lookup(case: str) -> None:
    p = made(case)
    # Rims and edges of faces among them; of a rectangle, cuts and poles are left out.
    some = inside(case, 8) if case in WHOLE else covered(p, 20)
    at = torch.from_numpy(some).requires_grad_()
    *faces, height, width = p.shape(8)
    x = random((*faces, 2, height, width), 6).requires_grad_()
    assert torch.autograd.gradcheck(
        lambda image, where: smt.sample(image, where, p), (x, at), check_forward_ad=True
    )
    turn = torch.from_numpy(sm.rotation(1, 2, 3)).requires_grad_()
    where = at.detach()
    assert torch.autograd.gradcheck(lambda r: smt.sample(x.detach(), where, p, rotation=r), turn)


def test_rotation_of_a_conversion_has_a_gradient_where_it_says_so() -> None:
    x = random((2, 3, 8, 16), 1)
    turn = torch.from_numpy(sm.rotation(10, 20, 30)).requires_grad_()
    options: dict[str, Any] = {"size": 3, "antialias": False}

    def verb(r: Any) -> Any:
        return smt.convert(x, "latlong", "cube", rotation=r, **options)

    fixed = turn.detach().numpy()
    wanted = sm.convert(
        x.numpy(), "latlong", "cube", rotation=fixed, channels_first=True, **options
    )
    # Directions are turned once more than by the kernel; 16 columns of slopes up to 1.
    torch.testing.assert_close(verb(turn).detach(), torch.from_numpy(wanted), rtol=0, atol=1e-13)
    torch.testing.assert_close(verb(turn.detach()), torch.from_numpy(wanted), **SAME)
    assert torch.autograd.gradcheck(verb, turn)
    forward = torch.func.jvp(verb, (turn.detach(),), (torch.ones_like(turn),))[1].sum()
    (reverse,) = torch.autograd.grad(verb(turn).sum(), turn)
    # The same products in another order.
    torch.testing.assert_close(forward, reverse.sum(), rtol=1e-10, atol=1e-10)
    both = torch.stack([turn.detach(), turn.detach().mT])
    alone = torch.stack([verb(one) for one in both])
    # As above: one product more.
    torch.testing.assert_close(torch.func.vmap(verb)(both), alone, rtol=0, atol=1e-13)
    compiled = torch.compile(verb, fullgraph=True, backend="aot_eager")
    followed = torch.stack([compiled(one) for one in both])
    # As above.
    torch.testing.assert_close(followed, alone, rtol=0, atol=1e-13)
    # No rotation, which a tensor need not be, with a gradient or without.
    off = turn.detach() + 1e-4
    torch.testing.assert_close(verb(off), verb(off.clone().requires_grad_()).detach(), **SAME)
    with pytest.raises(ValueError, match=r"shape \(3, 3\), got \(2, 3, 3\)"):
        verb(both.clone().requires_grad_())
    for more in ({"filter": "area"}, {"antialias": True}):
        with pytest.raises(ValueError, match="Gradients flow to `rotation`"):
            smt.convert(x, "latlong", "cube", rotation=turn, size=3, **more)


def test_no_gradient_is_silently_wrong() -> None:
    d = torch.from_numpy(random_directions(3, 5)).requires_grad_()
    found = smt.sample(random((4, 8), 1), d, "latlong", filter="nearest")
    with pytest.raises(NotImplementedError, match="filter='nearest' has no derivative by direct"):
        found.sum().backward()
    x = random((4, 8), 1).requires_grad_()
    found = smt.convert(x, "latlong", "cube", size=2, filter="mode")
    with pytest.raises(NotImplementedError, match="'mode' has no gradient"):
        found.sum().backward()
    with pytest.raises(NotImplementedError, match="'mode' has no gradient"):
        torch.func.jvp(
            lambda x: smt.convert(x, "latlong", "cube", size=2, filter="mode"),
            (x.detach(),),
            (x.detach(),),
        )


@pytest.mark.parametrize("case", ["perspective", "matcap", "cube", "latlong"])
def test_nothing_changes_outside_the_coverage(case: str) -> None:
    d = torch.tensor(
        [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.3, 0.2, -0.9]]
    ).double()
    x = random((6, 8, 8) if case == "cube" else (8, 16) if case == "latlong" else (8, 8), 1)
    along = torch.func.jvp(lambda d: smt.sample(x, d, case), (d,), (d.flip(-1) + 1,))[1]
    outside = smt.encode(d, case)[:, 0].isnan()
    assert outside[2] and (along[outside] == 0).all() and along[~outside][-1].isfinite()


def test_what_holds_no_value_does_not_count() -> None:
    hole = smt.directions("sphere", 16, dtype=torch.float64)[..., 0].isnan()
    x = torch.where(hole, torch.nan, 1.0).double().requires_grad_()
    total = smt.integrate(x, "sphere")
    # A sum of some hundred numbers in another order.
    assert hole.any() and abs(total.item() - 4 * np.pi) < 1e-12 * 4 * np.pi
    total.backward()
    assert x.grad is not None and (x.grad[hole] == 0).all()


@pytest.mark.parametrize("lead", [(0,), (0, 3), (2, 0)])
def test_nothing_makes_nothing(lead: tuple[int, ...]) -> None:
    d = torch.ones(4, 3)
    x = torch.zeros(*lead, 8, 16, requires_grad=True)
    batch, channels = lead[:-1], lead[-1:]
    turn = torch.eye(3, requires_grad=True)
    options: dict[str, Any] = {"size": 4, "antialias": False}
    for found, tail in (
        (smt.convert(x, "latlong", "octahedral", size=4), (4, 4)),
        (smt.convert(x, "latlong", "octahedral", rotation=turn, **options), (4, 4)),
        (smt.pad(x, "latlong", 1), (10, 18)),
        (smt.sample(x, d, "latlong"), (4,)),
        (smt.sh.project(x, "latlong", order=1), (4,)),
        (smt.light.irradiance(x, "latlong", "octahedral", size=4, order=1), (4, 4)),
    ):
        assert found.shape == (*batch, *channels, *tail)
        (back,) = torch.autograd.grad(found.sum(), x)
        assert back.shape == x.shape


@pytest.mark.parametrize("src, dst", [("latlong", "cube"), ("cube", "latlong"), ("cube", "cube")])
def test_shapes_are_those_of_channels_first(src: str, dst: str) -> None:
    p, d = sm.projection(src), torch.from_numpy(random_directions(6, 1)).reshape(2, 3, 3)
    shape = p.shape(4)
    rows = len(shape) - 2
    for lead, channels in (((), ()), ((), (3,)), ((2,), (3,))):
        x = random((*lead, *shape[:rows], *channels, *shape[rows:]), 1)
        first = bool(channels)
        wanted = sm.convert(x.numpy(), src, dst, size=4, channels_first=first)
        torch.testing.assert_close(
            smt.convert(x, src, dst, size=4), torch.from_numpy(wanted), **SAME
        )
        wanted = sm.sample(x.numpy(), d.numpy(), src, channels_first=first)
        torch.testing.assert_close(smt.sample(x, d, src), torch.from_numpy(wanted), **SAME)
        wanted = sm.pad(x.numpy(), src, 1, channels_first=first)
        torch.testing.assert_close(smt.pad(x, src, 1), torch.from_numpy(wanted), **SAME)
        wanted = sm.light.integrate(x.numpy(), src, channels_first=first)
        # Sums in another order.
        torch.testing.assert_close(
            smt.integrate(x, src), torch.from_numpy(wanted), rtol=EXACT, atol=EXACT
        )


def kept(x: Any) -> list[Any]:
    """Return what four verbs make of an image."""
    d = torch.from_numpy(random_directions(9, 1)).float()
    return [
        smt.convert(x, "latlong", "octahedral", size=8),
        smt.pad(x, "latlong", 1),
        smt.sample(x, d, "latlong"),
        smt.integrate(x, "latlong"),
    ]


def test_memory_formats_are_kept() -> None:
    x = random((2, 3, 8, 16), 1).float().requires_grad_()
    last = x.detach().to(memory_format=torch.channels_last).requires_grad_()
    found, wanted = kept(last), kept(x)
    torch.testing.assert_close(found, wanted, **SAME)
    for image in found[:2]:
        assert image.is_contiguous(memory_format=torch.channels_last)
        assert not image.is_contiguous()
    for a, b in zip(found, wanted, strict=True):
        gradients = (torch.autograd.grad((one**2).sum(), y) for one, y in ((a, last), (b, x)))
        # Sums of some dozens of products in float32, in another order.
        torch.testing.assert_close(*gradients, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("dtype", ["float16", "bfloat16"])
def test_half_is_computed_in_float32(dtype: str) -> None:
    x = random((2, 3, 8, 16), 1).to(getattr(torch, dtype)).requires_grad_()
    wide = x.detach().float().requires_grad_()
    for found, wanted in zip(kept(x), kept(wide), strict=True):
        assert found.dtype == x.dtype
        torch.testing.assert_close(found, wanted.to(x.dtype), **SAME)
        (back,) = torch.autograd.grad(found.sum(), x)
        (there,) = torch.autograd.grad(wanted.sum(), wide)
        assert back.dtype == x.dtype
        torch.testing.assert_close(back, there.to(x.dtype), **SAME)


@pytest.mark.parametrize("case", ["latlong", "cube", "sphere"])
def test_any_number_of_threads_gives_the_same_bits(case: str) -> None:
    p = sm.projection(case)
    height = p.shape(32)
    x = random((3, *height) if len(height) == 2 else (6, 3, *height[1:]), 1).float()
    x.requires_grad_()
    # So many that there is more than one thread, which meet in the same texels.
    d = torch.from_numpy(random_directions(200_000, 1)).float().requires_grad_()
    found = []
    for threads in (1, 2, 3):
        sm.set_num_threads(threads)
        torch.set_num_threads(threads)
        y = smt.sample(x, d, p)
        z = smt.convert(x, p, "cube", size=16)
        w = smt.convert(x, p, "latlong", size=256, antialias=False)
        total = (y**2).sum() + (z**2).sum() + (w**2).sum()
        found.append(torch.autograd.grad(total, (x, d)))
    for other in found[1:]:
        for a, b in zip(found[0], other, strict=True):
            assert_same_bits(a.numpy(), b.numpy())


def test_transforms_and_compilation() -> None:
    x = random((4, 3, 8, 16), 1)
    d = torch.from_numpy(random_directions(20, 1))

    def total(image: Any) -> Any:
        cube = smt.convert(image, "latlong", "cube", size=4)
        border = smt.pad(image, "latlong", 1)
        return (smt.sample(image, d, "latlong") ** 2).sum() + (cube**2).sum() + border.sum()

    wanted = torch.stack([torch.func.grad(total)(one) for one in x])
    # Of each texel three gradients are added, in another order.
    close = {"rtol": 1e-15, "atol": 1e-15}
    torch.testing.assert_close(torch.func.vmap(torch.func.grad(total))(x), wanted, **close)
    compiled = torch.compile(total, fullgraph=True, backend="aot_eager")
    one = x[0].clone().requires_grad_()
    compiled(one).backward()
    torch.testing.assert_close(one.grad, wanted[0], **close)


class Cubes(torch.utils.data.Dataset[Any]):
    """Panoramas that workers turn into cubes."""

    def __len__(self) -> int:
        return 4

    def __getitem__(self, number: int) -> Any:
        x = random((3, 64, 128), number).float()
        d = torch.from_numpy(random_directions(200_000, number)).float()
        cube = smt.convert(x, "latlong", "cube", size=32, antialias=False)
        return cube, smt.sample(x, d, "latlong"), smt.encode(d, "octahedral")


# Where JAX runs in the same process it warns of forks, which it cannot bear.
@pytest.mark.filterwarnings("ignore:os.fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork")
def test_workers_of_data_loaders_give_the_same_bits() -> None:
    """They are forked, after threads have run here."""
    wanted = [Cubes()[k] for k in range(len(Cubes()))]
    found = torch.utils.data.DataLoader(Cubes(), batch_size=None, num_workers=2)
    torch.testing.assert_close(list(map(tuple, found)), wanted, **SAME)


def test_images_export() -> None:
    class Net(torch.nn.Module):
        def forward(self, x: Any, d: Any) -> Any:
            cube = smt.convert(x, "latlong", "cube", size=4)
            return smt.sample(smt.pad(x, "latlong", 1)[..., 1:-1, 1:-1], d, "latlong"), cube

    given = random((2, 3, 8, 16), 1), torch.from_numpy(random_directions(5, 1))
    exported = torch.export.export(Net(), given)
    torch.testing.assert_close(exported.module()(*given), Net()(*given), **SAME)


def test_errors_say_what_was_expected() -> None:
    with pytest.raises(ValueError, match="2 to 4 axes"):
        smt.sample(torch.zeros(4), torch.zeros(3), "latlong")
    with pytest.raises(ValueError, match="each side within a texel"):
        smt.convert(torch.zeros(3, 8, 8), "latlong", "cube")
    with pytest.raises(TypeError, match="to be of floats"):
        smt.convert(torch.zeros(3, 4, 8, dtype=torch.uint8), "latlong", "cube")
    with pytest.raises(ValueError, match="bilinaer"):
        smt.sample(torch.zeros(4, 8), torch.zeros(3), "latlong", filter="bilinaer")
