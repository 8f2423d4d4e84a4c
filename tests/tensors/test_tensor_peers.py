"""Values and gradients of other programs beside ours, in float64 where they have it.

nvdiffrast may not be run here: its formula is written down.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

torch = pytest.importorskip("torch")
import spheremap.torch as smt  # noqa: E402

pytestmark = [
    pytest.mark.programs,
    # What other programs use of torch, it has deprecated.
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
    pytest.mark.filterwarnings("ignore::UserWarning"),
]

# The same formula in float64, written otherwise: some roundings of numbers up to 100.
CLOSE = {"rtol": 1e-11, "atol": 1e-11}


def random(shape: tuple[int, ...], seed: int) -> Any:
    return torch.from_numpy(np.random.default_rng(seed).random(shape))


def gradients(found: Any, *leaves: Any) -> list[Any]:
    weights = torch.linspace(0, 1, found.numel(), dtype=found.dtype).reshape(found.shape)
    return [found.detach(), *torch.autograd.grad((found * weights).sum(), leaves)]


def test_a_cube_is_looked_up_as_nvdiffrast_does() -> None:
    """Its table of faces, linear between centers, and both gradients by hand, away from edges."""
    size = 8
    x = random((6, 3, size, size), 1).requires_grad_()
    d = random_directions(400, 2)
    major = np.abs(d).argmax(axis=-1)
    each = np.arange(len(d))
    face = 2 * major + (d[each, major] < 0)
    # Rows of the OpenGL specification: which component s and t are, and with which sign.
    s_axis, t_axis = np.array([2, 2, 0, 0, 0, 0])[face], np.array([1, 1, 2, 2, 1, 1])[face]
    s_sign = np.array([-1, 1, 1, 1, 1, -1])[face]
    t_sign = np.array([-1, -1, 1, -1, -1, -1])[face]
    m = np.abs(d[each, major])
    at = [
        (sign * d[each, axis] / m / 2 + 0.5) * size - 0.5
        for sign, axis in ((s_sign, s_axis), (t_sign, t_axis))
    ]
    inside = np.logical_and.reduce([(a > 0) & (a < size - 1) for a in at])
    each, d, face, m = np.arange(inside.sum()), d[inside], face[inside], m[inside]
    assert len(d) > 200
    at = [a[inside] for a in at]
    (column, row), (fx, fy) = ([np.floor(a).astype(int) for a in at], [a % 1 for a in at])
    texels = x.detach().numpy()
    corners = [texels[face, :, row + j, column + i] for j in (0, 1) for i in (0, 1)]
    shares = [(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy]
    value = sum(share[:, None] * corner for share, corner in zip(shares, corners, strict=True))
    weights = np.linspace(0, 1, value.size).reshape(3, len(d)).T
    of_image = np.zeros_like(texels)
    places = [(row + j, column + i) for j in (0, 1) for i in (0, 1)]
    for share, (j, i) in zip(shares, places, strict=True):
        np.add.at(of_image, (face, slice(None), j, i), share[:, None] * weights)
    a, b, c, e = corners
    slopes = [
        (b - a) * (1 - fy)[:, None] + (e - c) * fy[:, None],
        (c - a) * (1 - fx)[:, None] + (e - b) * fx[:, None],
    ]
    of_directions = np.zeros_like(d)
    pairs = ((s_sign, s_axis), (t_sign, t_axis))
    for slope, (signs, axes) in zip(slopes, pairs, strict=True):
        sign, axis, along = signs[inside], axes[inside], major[inside]
        scale = (slope * weights).sum(-1) * size / 2
        of_directions[each, axis] += scale * sign / m
        of_directions[each, along] -= scale * sign * d[each, axis] / (m * d[each, along])
    at = torch.from_numpy(d).requires_grad_()
    found = gradients(smt.sample(x, at, "cube"), x, at)
    wanted = [torch.from_numpy(part) for part in (value.T, of_image, of_directions)]
    torch.testing.assert_close(found, wanted, **CLOSE)


def test_a_latlong_is_looked_up_as_by_grid_sample() -> None:
    """The usual way, with its border, away from the seam and the poles."""
    height = 16
    x = random((1, 3, height, 2 * height), 1).requires_grad_()
    d = random_directions(2000, 3)
    uv = sm.encode(d, "latlong")
    margin = np.array([0.5 / (2 * height), 0.5 / height])
    d = torch.from_numpy(d[((uv > margin) & (uv < 1 - margin)).all(axis=-1)]).requires_grad_()
    right, up, back = (d / torch.linalg.vector_norm(d, dim=-1, keepdim=True)).unbind(-1)
    grid = torch.stack([torch.atan2(right, -back) / torch.pi, -2 * torch.asin(up) / torch.pi], -1)
    usual = torch.nn.functional.grid_sample(x, grid[None, None], align_corners=False)[:, :, 0]
    torch.testing.assert_close(
        gradients(smt.sample(x, d, "latlong"), x, d), gradients(usual, x, d), **CLOSE
    )


def test_a_fisheye_has_the_gradients_of_kornia() -> None:
    """Its Kannala-Brandt camera, by points and by all eight numbers of a calibration."""
    camera = pytest.importorskip("kornia").geometry.camera
    given = {"fx": 0.42, "fy": 0.45, "cx": 0.01, "cy": -0.02}
    given |= {"k1": 0.02, "k2": -0.004, "k3": 0.001, "k4": -2e-4}
    numbers = torch.tensor(list(given.values()), dtype=torch.float64, requires_grad=True)
    view = np.random.default_rng(1).uniform([-0.8, -0.8, 1], [0.8, 0.8, 1], (40, 3))
    d = torch.from_numpy(view * [1, -1, -1]).requires_grad_()
    assert not smt.encode(d, sm.projection("camera_kannala_brandt", **given)).isnan().any()
    points = torch.stack([d[:, 0], -d[:, 1]], -1) / -d[:, 2:]
    theirs = camera.distort_points_kannala_brandt(points, numbers)
    moving = dict(zip(given, numbers.unbind(), strict=True))
    ours = smt.encode(d, smt.projection("camera_kannala_brandt", **moving)) - 0.5
    # Ours by the numbers are differences of fourth order: 1e-12 times fifth derivatives.
    close = {"rtol": 1e-8, "atol": 1e-9}
    torch.testing.assert_close(gradients(ours, d, numbers), gradients(theirs, d, numbers), **close)


def test_harmonics_have_the_gradients_of_e3nn() -> None:
    """e3nn's axis is y: it has (x, y, z) where others have (z, x, y)."""
    o3 = pytest.importorskip("e3nn.o3")
    order = 6
    d = (1.5 * torch.from_numpy(random_directions(50, 1))).requires_grad_()
    c = random(((order + 1) ** 2,), 2).requires_grad_()
    turned = d[:, [1, 2, 0]]
    theirs = o3.spherical_harmonics(
        list(range(order + 1)), turned, normalize=True, normalization="integral"
    )
    torch.testing.assert_close(
        gradients(smt.sh.evaluate(c, d), c, d), gradients(theirs @ c, c, d), **CLOSE
    )


def test_harmonics_are_projected_as_by_torch_harmonics() -> None:
    """Its quadrature is exact: coefficients come back, and gradients are the identity."""
    harmonics = pytest.importorskip("torch_harmonics")
    order, height = 5, 24
    transform = harmonics.RealSHT(
        height, 2 * height, lmax=order + 1, mmax=order + 1, grid="legendre-gauss", csphase=False
    )
    cosines, _ = np.polynomial.legendre.leggauss(height)
    # Rows from the north pole down; the axis of harmonics is z.
    cos = torch.from_numpy(cosines[::-1].copy())[:, None]
    sin, phi = (
        torch.sqrt(1 - cos**2),
        torch.arange(2 * height, dtype=cos.dtype) * (torch.pi / height),
    )
    d = torch.stack(torch.broadcast_tensors(sin * phi.cos(), sin * phi.sin(), cos), -1)
    c = random(((order + 1) ** 2,), 2)

    def coefficients(c: Any) -> Any:
        found = transform.double()(smt.sh.evaluate(c, d))
        rows = []
        for degree in range(order + 1):
            # Of a real function: Y with cos mφ is √2 of the real part, with sin mφ minus the other.
            for m in range(-degree, degree + 1):
                one = found[degree, abs(m)]
                rows.append(
                    one.real if m == 0 else 2**0.5 * one.real if m > 0 else -(2**0.5) * one.imag
                )
        return torch.stack(rows)

    torch.testing.assert_close(coefficients(c), c, **CLOSE)
    slope = torch.autograd.functional.jacobian(coefficients, c)
    torch.testing.assert_close(slope, torch.eye(len(c), dtype=c.dtype), **CLOSE)


def libraries_of_llvm() -> list[str | None]:
    """Return what mitsuba finds by itself, and that of Rust, which is newer."""
    found: list[str | None] = [None]
    if rustc := shutil.which("rustc"):
        done = subprocess.run([rustc, "--print", "sysroot"], capture_output=True, text=True)
        found += [str(path) for path in Path(done.stdout.strip(), "lib").glob("libLLVM*.so*")]
    return found


def test_an_environment_has_the_gradient_of_mitsuba(tmp_path: Path) -> None:
    """Its envmap emitter, which LLVM differentiates, in float32."""
    pytest.importorskip("mitsuba")
    height, p = 8, sm.projection("latlong:mitsuba")
    x = random((3, height, 2 * height), 1).float().requires_grad_()
    d = random_directions(500, 3).astype(np.float32)
    weights = np.linspace(0, 1, 3 * len(d), dtype=np.float32).reshape(3, -1)
    image = np.ascontiguousarray(x.detach().movedim(0, -1).numpy())
    given, out = tmp_path / "given.npz", tmp_path / "found.npz"
    np.savez(given, image=image, directions=d, weights=weights)
    # Apart: LLVM ends the process where it does not know the processor.
    script = Path(__file__).with_name("mitsuba_gradient.py")
    for library in libraries_of_llvm():
        environment = os.environ | ({"DRJIT_LIBLLVM_PATH": library} if library else {})
        command = [sys.executable, str(script), str(given), str(out)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        if done.returncode == 0:
            break
    else:
        pytest.skip(f"mitsuba's LLVM variant does not run: {done.stderr[-200:]}")
    with np.load(out) as arrays:
        values, theirs = arrays["values"], arrays["gradient"]
    # Its rows have their last texel before the first, and their first one behind the last.
    theirs[:, 1] += theirs[:, -1]
    theirs[:, -2] += theirs[:, 0]
    found = smt.sample(x, torch.from_numpy(d), p)
    (ours,) = torch.autograd.grad((found * torch.from_numpy(weights)).sum(), x)
    # float32, of places that are rounded by 1e-7 of 16 columns of slopes up to 1; ten lookups see a
    # texel.
    np.testing.assert_allclose(found.detach().numpy(), values, rtol=0, atol=1e-5)
    # The same.
    np.testing.assert_allclose(ours.movedim(0, -1).numpy(), theirs[:, 1:-1], rtol=0, atol=1e-5)
