"""From renderings back to what they show: an environment, and apart from it a camera."""

from __future__ import annotations

import math

import numpy as np
import pytest
import reference
import spheremap as sm

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402

pytestmark = pytest.mark.programs


def test_an_environment_comes_back_from_a_glossy_ball() -> None:
    """Three photos of a ball whose pixels each see eight directions about the mirrored one."""
    rng = np.random.default_rng(0)
    truth = torch.from_numpy(rng.random((3, 12, 24)))
    t = (torch.arange(48, dtype=torch.float64) + 0.5) / 24 - 1
    y, x = torch.meshgrid(-t, t, indexing="ij")
    z = torch.sqrt(1 - x**2 - y**2)
    normals = torch.stack([x, y, z], -1)[z.isfinite()]
    rough = normals + 0.03 * torch.from_numpy(rng.normal(size=(8, *normals.shape)))
    view = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)
    mirrored = smt.reflect(view, rough)
    turns = [torch.from_numpy(sm.rotation(yaw, 30)) for yaw in (0, 120, 240)]

    def photos(environment: torch.Tensor) -> torch.Tensor:
        seen = [smt.sample(environment, mirrored, "latlong", rotation=turn) for turn in turns]
        return torch.stack(seen).mean(2)

    wanted = photos(truth)
    found = torch.full_like(truth, 0.5).requires_grad_()
    optimizer = torch.optim.LBFGS([found], max_iter=150, line_search_fn="strong_wolfe")

    def loss() -> torch.Tensor:
        optimizer.zero_grad()
        error = ((photos(found) - wanted) ** 2).sum()
        error.backward()
        return error

    before = math.sqrt(smt.integrate((found - truth).detach() ** 2, "latlong").mean())
    optimizer.step(loss)
    after = math.sqrt(smt.integrate((found - truth).detach() ** 2, "latlong").mean())
    # A hundredth of what was not known, of an environment of noise, which is the hardest.
    assert after < 0.01 * before


def test_a_camera_comes_back_from_its_picture() -> None:
    """A field of view is a scale about the middle of the picture of another."""
    environment = reference.smooth_function(sm.directions("latlong", 64))[..., 0]
    pose, fov = sm.rotation(25, 10, -5), 70.0
    camera = sm.projection("perspective", fov=fov).turned(pose)
    wanted = torch.from_numpy(sm.convert(environment, "latlong", camera, size=32, antialias=False))
    image = torch.from_numpy(environment)
    place = sm.encode(sm.directions("perspective", 32), "perspective")
    middle = torch.from_numpy(place) - 0.5
    base = sm.projection("perspective").parameters["fov"]

    turn = torch.tensor([0.12, 0.35, 0.0], dtype=torch.float64, requires_grad=True)
    scale = torch.tensor(0.8, dtype=torch.float64, requires_grad=True)
    none = torch.zeros((), dtype=torch.float64)

    def picture() -> torch.Tensor:
        a, b, c = turn
        rows = [torch.stack(row) for row in ((none, -c, b), (c, none, -a), (-b, a, none))]
        matrix = torch.linalg.matrix_exp(torch.stack(rows))
        directions = smt.decode(0.5 + middle * scale, "perspective", rotation=matrix)
        return smt.sample(image, directions, "latlong")

    optimizer = torch.optim.LBFGS([turn, scale], max_iter=100, line_search_fn="strong_wolfe")

    def loss() -> torch.Tensor:
        optimizer.zero_grad()
        error = ((picture() - wanted) ** 2).sum()
        error.backward()
        return error

    optimizer.step(loss)
    half = math.tan(math.radians(base / 2)) * scale.item()
    # Two hundredths of a texel of the picture, whose 32 span 70°: lookups bend at texels.
    assert abs(2 * math.degrees(math.atan(half)) - fov) < 0.05
    a, b, c = turn.detach().tolist()
    skew = torch.tensor([[0, -c, b], [c, 0, -a], [-b, a, 0]], dtype=torch.float64)
    off = torch.linalg.matrix_exp(skew).numpy() @ pose.T
    assert math.degrees(math.acos(min(1.0, (np.trace(off) - 1) / 2))) < 0.05
