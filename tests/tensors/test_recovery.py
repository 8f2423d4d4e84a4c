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


@pytest.mark.parametrize(
    "name, known, given",
    [
        ("perspective", {}, {"fov": (70.0, 55.0)}),
        # The coefficient starts as that of no distortion.
        ("camera_kannala_brandt", {"fy": 0.45}, {"fx": (0.45, 0.6), "k1": (0.08, 0.0)}),
    ],
)
def test_a_camera_comes_back_from_its_picture(
    name: str, known: dict[str, float], given: dict[str, tuple[float, float]]
) -> None:
    """Where it looks, and what its lens does: of each parameter the truth and the first guess."""
    environment = reference.smooth_function(sm.directions("latlong", 64))[..., 0]
    truth = {key: value for key, (value, _) in given.items()}
    pose, options = sm.rotation(25, 10, -5), {"size": 32, "antialias": False}
    camera = sm.projection(name, **known, **truth)
    wanted = torch.from_numpy(sm.convert(environment, "latlong", camera.turned(pose), **options))
    image = torch.from_numpy(environment)

    turn = torch.tensor([0.12, 0.35, 0.0], dtype=torch.float64, requires_grad=True)
    # In steps that change a picture about as much as a radian does.
    step = {key: max(first, 0.5) for key, (_, first) in given.items()}
    lens = {
        key: torch.tensor(first / step[key], dtype=torch.float64, requires_grad=True)
        for key, (_, first) in given.items()
    }
    none = torch.zeros((), dtype=torch.float64)

    def matrix() -> torch.Tensor:
        a, b, c = turn
        rows = [torch.stack(row) for row in ((none, -c, b), (c, none, -a), (-b, a, none))]
        return torch.linalg.matrix_exp(torch.stack(rows))

    def picture() -> torch.Tensor:
        moving = smt.projection(name, **known, **{key: lens[key] * step[key] for key in lens})
        directions = smt.directions(moving, 32, rotation=matrix(), dtype=torch.float64)
        return smt.sample(image, directions, "latlong")

    optimizer = torch.optim.LBFGS(
        [turn, *lens.values()], max_iter=200, line_search_fn="strong_wolfe"
    )

    def loss() -> torch.Tensor:
        optimizer.zero_grad()
        error = ((picture() - wanted) ** 2).sum()
        error.backward()
        return error

    optimizer.step(loss)
    for key, value in truth.items():
        # Lookups bend at texels, and are no smooth function: a thousandth of a field of view of 70°
        # is two hundredths of a texel of the picture.
        assert abs(lens[key].item() * step[key] - value) < 1e-3 * max(value, 1.0), key
    off = matrix().detach().numpy() @ pose.T
    # Two hundredths of a texel.
    assert math.degrees(math.acos(min(1.0, (np.trace(off) - 1) / 2))) < 0.05
