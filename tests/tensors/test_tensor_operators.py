"""Every operator is as torch wants it: schema, fake, derivatives, what its compiler makes of it."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402
from spheremap.map.moving import spec_without  # noqa: E402
from spheremap.resample.linear import conversion  # noqa: E402

pytestmark = pytest.mark.programs


def random(*shape: int) -> Any:
    return torch.from_numpy(np.random.default_rng(0).random(shape))


def calls() -> dict[str, tuple[Any, ...]]:
    """Return for each operator what it may be given; tensors that have derivatives want one."""
    d = torch.from_numpy(random_directions(3, 1))
    uv = smt.encode(d, "cube")
    x, g, cube, two = random(4, 8, 2), random(3, 2), random(6, 4, 4, 2), random(2, 4, 4, 2)
    given = ((4, 8), "latlong", "cube", 2, None, "bilinear", 0.0, True, "match", False)
    key = conversion(*given)[1]
    fov = torch.tensor([190.0], dtype=torch.float64)
    spec = spec_without(sm.projection("dual_fisheye"), ["fov"])
    moving = smt.encode(d, "dual_fisheye(fov=190)")
    return {
        "encode": (wants(d), "cube"),
        "decode": (wants(uv), "cube"),
        "jacobian": (wants(uv), "cube"),
        "density": (wants(uv), "cube"),
        "encode_gradient": (wants(d), wants(g), "cube"),
        "jacobian_slope": (uv, "cube"),
        "density_slope": (uv, "cube"),
        "sample": (wants(x), wants(d), "latlong", "bilinear", 0.0),
        "sample_adjoint": (wants(g), d, "latlong", "bilinear", [4, 8]),
        "sample_places": (cube, d, g, "cube", "bilinear"),
        "sample_slopes": (cube, d, "cube", "bilinear"),
        "linear": (wants(x), key),
        "linear_adjoint": (wants(random(6, 2, 2, 2)), key),
        "linear_planes": (wants(random(2, 3, 4, 8)), key),
        "linear_planes_adjoint": (wants(random(2, 6, 3, 2, 2)), key),
        "moving_encode": (wants(d), wants(fov), spec, "fov", 3),
        "moving_decode": (wants(moving), wants(fov), spec, "fov"),
        "moving_encode_slopes": (d, fov, spec, "fov"),
        "moving_decode_slopes": (moving, fov, spec, "fov"),
        "moving_sample": (wants(two), wants(d), wants(fov), spec, "fov", "bilinear", 0.0),
        "moving_sample_adjoint": (wants(g), d, fov, spec, "fov", "bilinear", [2, 4, 4]),
        "moving_sample_places": (two, d, g, fov, spec, "fov", "bilinear"),
        "moving_sample_slopes": (two, d, fov, spec, "fov", "bilinear"),
        "sh_project": (wants(cube), "cube", 2, "means"),
        "sh_spread": (wants(random(9, 2)), "cube", [6, 4, 4], "means"),
        "sh_basis": (wants(d), 2),
        "sh_basis_tangent": (d, random(3, 3), 2),
        "quantized": (d, "oct16", "nearest"),
    }


def wants(tensor: Any) -> Any:
    return tensor.detach().clone().requires_grad_()


def operators() -> set[str]:
    found = torch._C._dispatch_get_all_op_names()
    return {name.partition("::")[2] for name in found if name.startswith("spheremap::")}


def test_every_operator_is_here() -> None:
    assert set(calls()) == operators()


@pytest.mark.parametrize("name", sorted(calls()))
def test_it_is_as_torch_wants_it(name: str) -> None:
    operator = getattr(torch.ops.spheremap, name).default
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = torch.library.opcheck(operator, calls()[name])
    assert set(found.values()) == {"SUCCESS"}
