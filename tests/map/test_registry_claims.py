"""Each claim that a registered projection makes about itself, tested over the registry."""

from __future__ import annotations

import math

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import (
    CASES,
    GRIDS,
    LAYOUTS,
    NAMES,
    PARAMETERS,
    REGISTRY,
    each,
    random_directions,
    together,
)
from conftest import valid_uv as pick_uv
from spheremap import _core

EXPECTED = {
    "sphere",
    "matcap",
    "dual_paraboloid",
    "cube",
    "angular",
    "octahedral",
    "hemioctahedral",
    "latlong",
}
each_entry = pytest.mark.parametrize("entry", REGISTRY, ids=NAMES)


def test_projections_that_others_build_on_are_registered():
    assert set(NAMES) >= EXPECTED
    assert len(set(NAMES)) == len(NAMES)
    assert tuple(sm.projections()) == tuple(NAMES)


@each_entry
def test_texts_are_there(entry):
    for key in ("title", "source", "summary", "singular"):
        assert isinstance(entry[key], str) and len(entry[key]) > 5, key
        assert "\n" not in entry[key], key
    p = sm.projection(entry["name"])
    assert (p.title, p.source, p.summary, p.singular) == tuple(
        entry[k] for k in ("title", "source", "summary", "singular")
    )


@each_entry
def test_entry_agrees_with_the_object(entry):
    p = sm.projection(entry["name"])
    for key in ("name", "coverage", "axes", "equal_area", "conformal"):
        assert getattr(p, key) == entry[key], key
    assert p.convention is None and p.grid == "centers"
    # One claim by two ways out of Rust: they could differ by a mistake only.
    assert tuple(p.density_range) == pytest.approx(tuple(entry["density_range"]))
    assert p.parameters == {x["name"]: x["default"] for x in entry["parameters"]}
    assert (p.layout is None) == (not entry["layouts"])
    if entry["layouts"]:
        assert p.layout in entry["layouts"]


@each_entry
def test_default_axes_are_the_standard_ones(entry):
    assert entry["axes"] == reference.DEFAULT_AXES[entry["name"]]


@each_entry
def test_layouts_are_the_ones_the_reference_knows(entry):
    name = entry["name"]
    want = {"faces", *reference.LAYOUTS[name]} if name in reference.FACES else set()
    assert set(entry["layouts"]) == want
    if want:
        assert sm.projection(name).layout == "faces"
        assert sm.projection(name).faces == reference.FACES[name]


@each_entry
def test_parameter_ranges_are_enforced(entry):
    name = entry["name"]
    for x in entry["parameters"]:
        assert x["minimum"] < x["maximum"] and x["minimum"] <= x["default"] <= x["maximum"]
        assert x["doc"] and isinstance(x["unit"], str)  # a pure number has no unit
        inside = x["minimum"] + (x["maximum"] - x["minimum"]) / 3
        for value in (inside, x["maximum"]):
            options = {x["name"]: value}
            if together(name, options):
                assert sm.projection(name, **options).parameters[x["name"]] == value
        span = x["maximum"] - x["minimum"]
        for outside in (x["minimum"] - span / 10, x["maximum"] + span / 10, math.nan, math.inf):
            with pytest.raises(ValueError, match=x["name"]):
                sm.projection(name, **{x["name"]: outside})


def test_fov_zero_is_excluded():
    with pytest.raises(ValueError, match=r"`fov` must be in \(0, 360\], got 400"):
        sm.projection("angular", fov=400)
    with pytest.raises(ValueError, match="fov"):
        sm.projection("angular", fov=0)


@each(CASES)
def test_coverage(case):
    p, r = case.make(), case.reference()
    kind = p.coverage
    # 45 ε: closed forms in other letters, whose differences keep a tenth of their terms.
    assert p.covered_solid_angle == pytest.approx(r.covered_solid_angle, rel=1e-14)
    d = random_directions(20_000, 20)
    covered = p.covers(d)
    assert covered.dtype == bool and covered.shape == d.shape[:-1]
    assert np.array_equal(covered, r.covers(d))
    assert np.array_equal(covered, ~np.isnan(p.encode(d)[..., 0]))
    share = covered.mean()
    if kind == "sphere":
        # The whole sphere is 4π to a rounding; pytest's 1e-6 tells it from any part.
        assert share == 1 and p.covered_solid_angle == pytest.approx(4 * math.pi)
    elif kind == "hemisphere":
        # Half of the sphere, likewise.
        assert p.covered_solid_angle == pytest.approx(2 * math.pi)
        center = r.decode(np.array([0.5, 0.5]))
        assert np.array_equal(covered, d @ center >= 0)
    else:
        assert kind in ("cap", "part")
        # Five standard deviations of a count of 20,000.
        assert share == pytest.approx(p.covered_solid_angle / (4 * math.pi), abs=0.018)


@each(CASES)
def test_valid_agrees_with_decode_and_reference(case):
    p, r = case.make(), case.reference()
    rng = np.random.default_rng(21)
    uv = rng.uniform(-0.2, 1.2, (20_000, 2))
    if p.faces > 1:
        uv = np.concatenate([uv, rng.integers(-1, p.faces + 1, (len(uv), 1)).astype(float)], -1)
    valid = p.valid(uv)
    assert valid.dtype == bool and valid.shape == uv.shape[:-1]
    assert np.array_equal(valid, r.valid(uv))
    d = p.decode(uv)
    assert np.array_equal(valid, ~np.isnan(d).any(-1)) and np.array_equal(
        valid, ~np.isnan(d).all(-1)
    )
    assert np.array_equal(valid, ~np.isnan(p.density(uv)))


@pytest.mark.parametrize("name", sorted(reference.FACES))
def test_face_must_be_an_exact_integer_in_range(name):
    p = sm.projection(name)
    for face in (-1.0, -0.5, 0.5, 1.0000001, p.faces - 0.5, float(p.faces), math.nan, math.inf):
        uv = np.array([0.5, 0.5, face])
        assert not p.valid(uv)
        assert np.isnan(p.decode(uv)).all()
        assert np.isnan(p.jacobian(uv)).all()
        assert np.isnan(p.density(uv))
    for face in range(p.faces):
        assert p.valid(np.array([0.5, 0.5, face]))
    assert p.valid(np.array([0.5, 0.5, -0.0]))


@each(CASES, slow=PARAMETERS)
def test_density_range_holds_and_is_reached(case):
    p, r = case.make(), case.reference()
    lo, hi = p.density_range
    uv = pick_uv(r, 16_000, 22)
    density = p.density(uv)
    # Near its extreme a closed form may round past it: a few ε of it, or of 1 where it is 0.
    assert density.min() >= lo * (1 - 1e-12) - 1e-12
    assert density.max() <= hi * (1 + 1e-12)
    # 16,000 points come within a percent or so of a finite extreme; near a pole or a rim where
    # the density is unbounded they pass any modest multiple of the median.
    middle = np.median(density)
    # 1e-12 for rounding, where an equal-area map's middle and extremes are one.
    assert density.min() <= lo + 0.05 * (middle - lo) + 1e-12
    if math.isfinite(hi):
        # As below the middle.
        assert density.max() >= hi - 0.05 * (hi - middle) - 1e-12
    else:
        assert density.max() > 20 * middle


def is_stereographic(p: sm.Projection) -> bool:
    """Tell cameras that are stereographic at their defaults: claims are of all parameters."""
    names = ("xi", "k1", "k2", "p1", "p2", "alpha", "beta")
    entry = next(e for e in REGISTRY if e["name"] == p.name)
    defaults = {x["name"]: x["default"] for x in entry["parameters"]}
    same = all(p.parameters.get(n) == defaults.get(n) for n in names)
    return p.name in ("camera_unified", "camera_eucm") and same


@each(CASES)
def test_equal_area_and_conformal_claims(case):
    p, r = case.make(), case.reference()
    uv = pick_uv(r, 5000, 23, margin=1e-3)
    density = p.density(uv)
    # A constant is the same to a few ε; densities that vary do so by percents.
    assert (np.ptp(density) <= 1e-12 * density.max()) == p.equal_area
    j = p.jacobian(uv)
    if p.layout in (None, "faces"):
        # Conformal means: lengths in one ratio, that of the image's sides, and right angles.
        a, b = j[..., 0], j[..., 1]
        la, lb = (np.linalg.norm(x, axis=-1) for x in (a, b))
        ratio = la / lb
        off = np.maximum(
            np.abs(ratio / np.median(ratio) - 1), np.abs(np.sum(a * b, -1) / (la * lb))
        )
        # Where meridians meet, ε over the margin of 1e-3: 2e-13; maps that shear do so by percents.
        assert (off.max() < 1e-9) == (p.conformal or is_stereographic(p))


@each(LAYOUTS)
def test_mean_density_is_the_covered_solid_angle(case):
    # A Monte Carlo integral of the claim against the claim: 10 standard errors.
    p = case.make()
    rng = np.random.default_rng(24)
    n = 200_000
    uv = rng.random((n, 2))
    if p.faces > 1:
        uv = np.concatenate([uv, rng.integers(0, p.faces, (n, 1)).astype(float)], -1)
    density = np.nan_to_num(p.density(uv), nan=0.0) * p.faces
    error = density.std() / math.sqrt(n)
    tail = 0.02 if not math.isfinite(p.density_range[1]) else 0.0
    # A constant has no error but rounding.
    assert abs(density.mean() - p.covered_solid_angle) < 10 * error + tail + 1e-12


@each(CASES)
def test_mirrored_is_the_determinant(case):
    p = case.make()
    # (x + y, x - y) turns the sense of the hemi-octahedral square around in its own frame.
    reversed_formula = case.name == "hemioctahedral"
    left_handed = np.linalg.det(reference.axes_matrix(p.axes)) < 0
    assert p.mirrored == (left_handed != reversed_formula)


def test_every_one_of_the_48_axes_is_accepted():
    from itertools import permutations, product

    d = random_directions(20, 25)
    count = 0
    for order in permutations("xyz"):
        for signs in product("+-", repeat=3):
            axes = " ".join(s + a for s, a in zip(signs, order, strict=True))
            p = sm.projection("octahedral", axes=axes)
            assert p.axes == axes
            # uv is at most 1: a length and a quotient, ε/2 each, in the library and the reference.
            assert np.abs(p.encode(d) - reference.of(p).encode(d)).max() < 1e-15
            count += 1
    assert count == 48


@each(LAYOUTS)
def test_shape_of_a_size(case):
    p, r = case.make(), case.reference()
    for n in (1, 2, 7, 64):
        assert p.shape(n) == r.shape(n)
        assert p.shape(p.shape(n)) == r.shape(n)
    for wrong in (0, -3):
        with pytest.raises(ValueError, match=r"size|shape"):
            p.shape(wrong)


@each_entry
def test_aspect_is_the_shape(entry):
    p = sm.projection(entry["name"])
    w, h = entry["aspect"]
    shape = p.shape(60)
    # Sides are whole numbers, and a ratio without fractions is stated by one nearby.
    assert abs(shape[-1] * h - shape[-2] * w) <= max(w, h)


@each(LAYOUTS)
@pytest.mark.parametrize("grid", GRIDS)
def test_directions_of_texels(case, grid):
    p = case.make(grid=grid)
    r = reference.of(p)
    for size in (2, 5, 8):
        d = p.directions(size)
        assert d.dtype == np.float64 and d.shape == (*r.shape(size), 3)
        if grid != "centers" and p.layout not in (None, "faces"):
            continue  # texels of an atlas on corners: only shape and unit length are promised
        want = r.directions(size)
        # The cube's axis through a disk's rim may round to either side of it.
        uv = r.texel_uv(r.shape(size))
        p_, q_, _ = r.local(uv)
        # Coordinates are fractions of 15 and 7 at the finest: what is off the rim is so by 1e-5.
        off_rim = (not r.is_disk) | (np.abs(p_ * p_ + q_ * q_ - 1) > 1e-9)
        assert np.array_equal(np.isnan(d)[off_rim], np.isnan(want)[off_rim])
        both = off_rim & ~np.isnan(want[..., 0])
        if not both.any():
            continue  # 2 × 2 on corners: a disk holds none of them
        # 18 ε: uv of six cells in a row costs 6, either formula a few more.
        assert reference.angle(d[both], want[both]).max() < 4e-15
        d32 = p.directions(size, dtype=np.float32)
        assert d32.dtype == np.float32
        ok = both & ~np.isnan(d32[..., 0])
        # sphere and matcap degrade as the square root of eps toward the rim.
        assert reference.angle(d32[ok], want[ok]).max() < (1.2e-3 if r.is_disk else 9.5e-7)


def test_levels_and_threads_are_reported():
    levels = _core.simd_levels()
    assert levels and set(levels) <= {"baseline", "sse2", "sse4.2", "avx2", "avx512", "neon"}
    assert sm.simd_level() == levels[-1]
    assert isinstance(sm.get_num_threads(), int) and sm.get_num_threads() >= 1
    assert isinstance(sm.__version__, str) and sm.__version__ == _core.__version__
