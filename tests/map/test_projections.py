"""The list of projections: filters by claims, the table, and what rare projections compute in."""

from __future__ import annotations

import math

import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES, REGISTRY, assert_same_bits, random_directions


def test_it_is_a_tuple_of_names():
    names = sm.projections()
    assert isinstance(names, tuple) and list(names) == NAMES
    assert names[0] == NAMES[0] and "cube" in names and len(names) == len(NAMES)


def test_claims_filter():
    for entry in REGISTRY:
        for claim in ("coverage", "equal_area", "conformal", "faces", "seam"):
            of_claim = sm.projections(**{claim: entry[claim]})
            assert entry["name"] in of_claim
            assert of_claim == tuple(e["name"] for e in REGISTRY if e[claim] == entry[claim])
    both = sm.projections(equal_area=True, coverage="sphere")
    assert {"sphere", "equal_area", "cube_equal_area"} <= set(both)
    assert "concentric" not in both and "cube" not in both
    assert set(sm.projections(density_ratio=1)) == set(sm.projections(equal_area=True))
    assert "cube_equiangular" in sm.projections(density_ratio=1.5)
    assert sm.projections(faces=5) == ()


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"coverage": "sphre"}, ValueError, "did you mean 'sphere'"),
        ({"seam": "nothing at all"}, ValueError, "unknown seam"),
        ({"coverage": 3}, TypeError, "`coverage`"),
        ({"equal_area": "yes"}, TypeError, "`equal_area`"),
    ],
)
def test_what_is_no_claim(options, error, words):
    with pytest.raises(error, match=words):
        sm.projections(**options)


def test_the_figures_of_the_literature():
    # Worst and rms samples per steradian of what even texels would give.
    known = {
        "sphere": (0.785, 0.785),
        "angular": (0.318, 0.522),
        "dual_paraboloid": (0.393, 0.673),
        "latlong": (0.637, 0.811),
        "octahedral": (0.605, 0.903),
        "hemioctahedral": (0.605, 0.903),
        "cube": (0.524, 0.874),
        "cube_equiangular": (0.849, 0.992),
        "cube_quadratic": (0.795, 0.977),
        "equal_area": (1, 1),
        "concentric": (1, 1),
        "matcap": (0, 0),
    }
    for row in sm.projections().figures:
        if row.name in known:
            worst, rms = known[row.name]
            # The literature's three decimals.
            assert row.efficiency_worst == pytest.approx(worst, abs=1e-3), row.name
            assert row.efficiency_rms == pytest.approx(rms, abs=1e-3), row.name
        if row.equal_area:
            assert row.efficiency_rms == row.efficiency_worst
        assert row.aspect >= 1 and row.density_ratio >= 1 and min(row.steps) > 0
        # Equal-area maps state one constant for both ends.
        assert (row.density_ratio == pytest.approx(1, abs=1e-12)) == row.equal_area
        # Conformal texels are square, but for the ones that default sizes stretch.
        assert not row.conformal or row.aspect < 1.02


def test_aspects_are_quantiles_by_solid_angle():
    """Of these the ratio at the height h, beyond which a hundredth lies, has a closed form."""
    h = 0.99
    pole = math.sqrt(1 - h * h)
    known = {
        "sphere": 2 / (2 - 2 * h),
        "matcap": 1 / (1 - h),
        "orthographic": 1 / (1 - h),
        "latlong": 1 / pole,
        "hemi_latlong": 1 / pole,
        "lambert_cylindrical": 1 / pole**2,
        # θ/sin θ.
        "angular": math.acos(1 - 2 * h) / math.sin(math.acos(1 - 2 * h)),
        "stereographic": 1,
        "mercator": 1,
    }
    for row in sm.projections().figures:
        if row.name in known:
            # 131072 directions, of which 1310 lie beyond: three of these more or less are 0.2 %.
            assert row.aspect == pytest.approx(known[row.name], rel=3e-3), row.name
    assert [row.cells[6] for row in sm.projections().figures[:3]] == ["100", "100", "1.00"]


def test_the_table_prints_every_row():
    chosen = sm.projections(coverage="sphere")
    lines = repr(chosen).splitlines()
    assert lines[0].split()[0] == "name" and len(lines) == len(chosen) + 1
    assert [line.split()[0] for line in lines[1:]] == list(chosen)
    page = chosen._repr_html_()
    assert page.count("<tr>") == len(chosen) + 1 and "<td>latlong</td>" in page
    assert math.isinf(next(r for r in chosen.figures if r.name == "latlong").density_ratio)


@pytest.mark.parametrize("name", ["camera_brown_conrady", "camera_kannala_brandt"])
def test_cameras_compute_float32_in_float64(name):
    d = random_directions(3001, 310, np.float32)
    for rotation in (None, sm.rotation(10, 20, 30)):
        wide = sm.encode(d.astype(np.float64), name, rotation=rotation)
        uv = sm.encode(d, name, rotation=rotation)
        assert_same_bits(uv, wide.astype(np.float32))
        back = sm.decode(uv.astype(np.float64), name, rotation=rotation).astype(np.float32)
        assert_same_bits(sm.decode(uv, name, rotation=rotation), back)
