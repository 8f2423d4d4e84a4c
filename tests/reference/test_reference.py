"""The reference against itself: it must be right before it may judge."""

from __future__ import annotations

import math

import hard_directions
import numpy as np
import pytest
from conftest import NAMES, random_directions, some_fast, valid_uv

import reference

ALL = [
    reference.make(name, **({"layout": layout} if layout else {}))
    for name in reference.FORMULAS
    for layout in (["faces", *reference.LAYOUTS[name]] if name in reference.FACES else [None])
]
each_reference = pytest.mark.parametrize(
    "r", ALL, ids=[f"{r.name}-{r.layout}" if r.layout else r.name for r in ALL]
)


def test_every_registered_projection_has_a_reference():
    missing = [name for name in NAMES if name not in reference.FORMULAS]
    assert not missing, f"registered, but tests/reference/maps.py has no formula for {missing}"


@each_reference
def test_decode_inverts_encode_everywhere(r):
    d = np.concatenate([hard_directions.hard(np.float64)[::5], random_directions(5000, 1)])
    d = d[r.covers(d.astype(np.longdouble))]
    back = r.decode(r.encode(d.astype(np.longdouble)))
    # longdouble eps is 1e-19. At the blind spot of the sphere map an error e of uv is an angle of
    # √(8e) or so; at the rim of the matcap √(2e).
    exact = {"sphere": 2e-9, "matcap": 1e-9, "orthographic": 1e-9, "lambert_cylindrical": 1e-9}
    exact["mollweide"] = 1e-14  # ε^¾ at the poles
    # Miller's series of hyperbolic functions are good to float64 beyond their last term.
    bound = exact.get(r.name, 1e-17 * max(20.0 if r.name == "miller" else 1.0, r.stretch / 6))
    if np.finfo(np.longdouble).eps > 1e-18:  # longdouble is no wider than float64
        exact = {
            "sphere": 6e-8,
            "matcap": 2.5e-8,
            "orthographic": 2.5e-8,
            "lambert_cylindrical": 2.5e-8,
            "mollweide": 5e-12,
        }
        bound = exact.get(r.name, 2e-15 * max(1.0, r.stretch / 6))
    assert reference.angle(back, d).max() < bound


@each_reference
def test_density_is_the_area_of_the_jacobian(r):
    uv = valid_uv(r, 2000, 2, margin=1e-3)
    j = r.jacobian(uv, step=1e-4).astype(float)
    area = np.linalg.norm(np.cross(j[..., 0], j[..., 1]), axis=-1)
    relative = np.abs(area / r.density(uv) - 1)
    # A few stencils straddle a crease or come near a rim; the others are good to step⁴.
    assert np.quantile(relative, 0.9) < 1e-6


@each_reference
@some_fast("n", [1, 2, 3, 6, 7], fast=(1, 2, 7))
def test_texel_solid_angles_sum_to_the_coverage(r, n):
    w = r.solid_angle(r.shape(n))
    assert w.min() >= 0
    # 450 ε: parts that Gauss rules of 12 or 48 points hold to ε, summed by the hundred.
    assert w.sum() == pytest.approx(r.covered_solid_angle, rel=1e-13)


@pytest.mark.parametrize("name", ["sphere", "matcap", "dual_paraboloid", "angular"])
def test_disk_cells_against_a_brute_count_of_density(name):
    r = reference.make(name, **({"layout": "strip"} if name in reference.FACES else {}))
    w = r.solid_angle(r.shape(4))
    h, width = w.shape
    k = 400
    v, u = np.meshgrid(
        (np.arange(h * k) + 0.5) / (h * k),
        (np.arange(width * k) + 0.5) / (width * k),
        indexing="ij",
    )
    density = np.nan_to_num(r.density(np.stack([u, v], -1)), nan=0.0)
    brute = density.reshape(h, k, width, k).mean(axis=(1, 3)) / (h * width)
    # Half a subcell along the rim, and the root singularity of the matcap there.
    assert np.allclose(w, brute, rtol=0, atol=4 * math.pi * (2e-3 if name == "matcap" else 1e-4))


def test_axes_matrix_agrees_with_permutation():
    d = random_directions(50, 3)
    for axes in ("+x -y -z", "-z +x -y", "+y +z +x"):
        view = reference.permute(axes, d, back=False)
        assert np.array_equal(view, d @ reference.axes_matrix(axes).T)
        assert np.array_equal(reference.permute(axes, view, back=True), d)


def test_angle_is_exact_at_both_ends():
    x = np.array([1.0, 0.0, 0.0])
    # π to its rounding; and arctan x is x but for x³/3, where an arccosine would give 0.
    assert reference.angle(x, x * 1e300) == 0
    assert reference.angle(x, -x) == pytest.approx(math.pi, rel=1e-15)
    assert reference.angle(x, [1.0, 1e-12, 0.0]) == pytest.approx(1e-12, rel=1e-12)


def test_gradient_of_the_smooth_function_is_as_stated():
    d = random_directions(20_000, 4)
    t = np.cross(d, random_directions(20_000, 5))
    t /= np.linalg.norm(t, axis=-1, keepdims=True)
    step = 1e-6
    f = reference.smooth_function
    slope = np.abs(f(reference.unit(d + step * t)) - f(reference.unit(d - step * t))) / (2 * step)
    assert slope.max() < 2.9
