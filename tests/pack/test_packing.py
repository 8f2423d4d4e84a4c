"""Packing of unit vectors: every code, the bounds, the roundings, arrays of fields, bad input."""

from __future__ import annotations

import pickle

import hard_directions
import numpy as np
import pytest
import spheremap as sm
from conftest import assert_same_bits, random_directions
from hypothesis import given
from hypothesis import strategies as st
from reference import packing as reference
from spheremap import _core

pytestmark = pytest.mark.filterwarnings("ignore::spheremap.packing.UnboundedPackingWarning")

NAMES = sm.packing.packings()
ABOUT = {name: sm.packing.packing(name) for name in NAMES}
# One name of each family, grid and way of splitting, at its first size from 16 bits on.
EACH = list(
    {
        (a.family, a.variant, a.shape): name
        for name, a in reversed(ABOUT.items())
        if a.bits >= 16 or a.bits == max(b.bits for b in ABOUT.values() if b.family == a.family)
    }.values()
)
SIXTEEN = [n for n in NAMES if ABOUT[n].bits == 16]
GRIDDED = ("oct", "woct", "equal_area", "hemioct")
BOUNDED = [n for n in NAMES if np.isfinite(ABOUT[n].bound)]
EPS = float(np.finfo(np.float32).eps)
# What float32 arithmetic adds to a bound: a coordinate is off by two or three roundings, and so is
# the direction that is decoded.
SINGLE = 4 * EPS
# Draco's decoder, float32 for coordinates of up to 30 bits: four roundings of numbers up to 2, and
# three times as far on the sphere.
DRACO = 1e-6
AXES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)


def some_directions(name: str, n: int, seed: int = 0) -> np.ndarray:
    d = np.concatenate([AXES, random_directions(n, seed)])
    if ABOUT[name].hemisphere:
        d[:, 2] = np.abs(d[:, 2])
    return d


def all_codes(name: str) -> np.ndarray:
    a = ABOUT[name]
    words = np.arange(a.codes, dtype=np.uint64)
    if not a.shape:
        return words.astype(a.dtype)
    bits = a.bits // a.shape[0]
    mask = np.uint64((1 << bits) - 1)
    fields = [(words >> np.uint64(k * bits)) & mask for k in range(a.shape[0])]
    unsigned = np.dtype(f"u{a.dtype.itemsize}")
    return np.stack(fields, -1).astype(unsigned).view(a.dtype)


# --- every code


@pytest.mark.parametrize("name", SIXTEEN)
def test_every_16_bit_code_comes_back_as_itself_or_its_twin(name):
    codes = all_codes(name)
    canonical = sm.packing.canonical(codes, name)
    assert canonical.dtype == codes.dtype and canonical.shape == codes.shape
    assert_same_bits(sm.packing.canonical(canonical, name), canonical, "idempotent")
    for dtype in (np.float32, np.float64):
        d = sm.packing.unpack(codes, name, dtype=dtype)
        assert d.dtype == dtype and d.shape == (len(codes), 3)
        # Three roundings and a reciprocal square root, below one; programs compute in float32.
        exact = ABOUT[name].exact is not None
        eps = np.finfo(np.float32 if exact else dtype).eps
        if ABOUT[name].family != "draco":  # whose grid has no line 255
            assert np.abs(np.linalg.norm(d.astype(float), axis=-1) - 1).max() < 4 * eps
        twin = sm.packing.unpack(canonical, name, dtype=dtype)
        if exact or ABOUT[name].family == "matcap":
            # Sums of two twins, and points along one ray, round apart there.
            assert np.abs(d - twin).max() < 4 * eps
        else:
            # -0 and 0 are one number here.
            assert np.array_equal(d, twin)
        back = sm.packing.pack(
            d, name, "nearest" if "nearest" in ABOUT[name].roundings else "precise"
        )
        held = is_held(name, canonical)
        assert_same_bits(back[held], canonical[held], f"{dtype}")


def is_held(name: str, codes: np.ndarray) -> np.ndarray:
    """Return whether there are directions that `pack` gives these codes of 16 bits."""
    if ABOUT[name].family == "draco":  # whose grid has no line 255
        return codes.max(-1) < 255
    if ABOUT[name].family == "matcap":
        place = codes.view("i1") if ABOUT[name].shape else reference.unpack_word(codes, 8, True)
        return np.square(place, dtype=np.int64).sum(-1) <= 127**2
    return np.ones(codes.shape[: codes.ndim - len(ABOUT[name].shape)], bool)


# --- one code for each direction


# Schemes that write several codes of one direction: components in proportion, and programs that
# fold by the sign of a component just below 0.
SEVERAL = ("snorm", "rgb", "rgb10a2", "meshoptimizer", "pbrt", "unreal", "cesium")


def hard_codes(name: str, n: int = 60) -> np.ndarray:
    """Codes of which many have a field at an end, in the middle, or next to them."""
    a = ABOUT[name]
    rng = np.random.default_rng(a.bits)
    if a.family in ("cube", "fibonacci", "rings"):
        ends = [0, 1, 2, a.codes // 2, a.codes - 2, a.codes - 1]
        return np.concatenate([ends, rng.integers(0, a.codes, n * n)]).astype(a.dtype)
    fields = a.shape[0] if a.shape else 3 if a.family in ("snorm", "rgb10a2") else 2
    bits = 10 if a.family == "rgb10a2" else a.bits // fields
    middle, last = 1 << bits - 1, (1 << bits) - 1
    ends = np.array([0, 1, 2, middle - 2, middle - 1, middle, middle + 1, last - 2, last - 1, last])
    choice = np.where(
        rng.random((n * n, fields)) < 0.7,
        ends[rng.integers(0, len(ends), (n * n, fields))],
        rng.integers(0, last, (n * n, fields), endpoint=True),
    ).astype(np.uint64)
    if a.shape:
        return choice.astype(f"u{a.dtype.itemsize}").view(a.dtype)
    shifts = np.arange(fields, dtype=np.uint64) * np.uint64(bits)
    return np.bitwise_or.reduce(choice << shifts, -1).astype(a.dtype)


def close_pairs(d: np.ndarray, tolerance: float) -> int:
    """Count pairs of vectors that are closer than this."""
    along = d @ [0.48, 0.64, 0.6]
    order = np.argsort(along)
    d, along = d[order], along[order]
    found = 0
    for k in range(1, len(d)):
        near = along[k:] - along[:-k] < tolerance
        if not near.any():
            break
        found += int((np.linalg.norm(d[k:] - d[:-k], axis=-1) < tolerance)[near].sum())
    return found


def turned(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between vectors; 0 where neither is one."""
    none = np.isnan(a).any(-1) & np.isnan(b).any(-1)
    angle = reference.angle(a, b)
    return np.where(none, 0, angle)


@pytest.mark.parametrize("name", NAMES)
def test_canonical_codes_are_the_same_direction_and_stay(name):
    codes = hard_codes(name)
    canonical = sm.packing.canonical(codes, name)
    assert canonical.dtype == codes.dtype and canonical.shape == codes.shape
    assert_same_bits(sm.packing.canonical(canonical, name), canonical, "idempotent")
    for dtype in (np.float32, np.float64):
        d = sm.packing.unpack(codes, name, dtype=dtype).astype(float)
        twin = sm.packing.unpack(canonical, name, dtype=dtype).astype(float)
        limit = 2 * DRACO if ABOUT[name].family == "draco" else SINGLE
        assert turned(d, twin).max() <= limit


@pytest.mark.parametrize("name", [n for n in NAMES if ABOUT[n].family not in SEVERAL])
def test_canonical_leaves_what_pack_wrote(name):
    d = directions_beside_edges(name)
    for dtype in (np.float32, np.float64):
        for rounding in ABOUT[name].roundings:
            codes = sm.packing.pack(d.astype(dtype), name, rounding)
            assert_same_bits(sm.packing.canonical(codes, name), codes, rounding)


def directions_beside_edges(name: str) -> np.ndarray:
    """Random directions, diagonals, -z, and directions with components of 0 and next to it."""
    d = some_directions(name, 600, 21)
    rng = np.random.default_rng(22)
    small = rng.choice([0.0, -0.0, 1e-9, -1e-9, 1e-3, -1e-3], d.shape)
    beside = np.where(rng.random(d.shape) < 0.5, small, d)
    beside[np.abs(beside).max(-1) < 0.1] = [0, 0, 1]
    down = [0, 0, -1] + rng.normal(size=(600, 3)) * 10.0 ** rng.uniform(-9, -1, (600, 1))
    diagonal = 1 + rng.normal(size=(600, 3)) * 1e-6
    all_of_them = np.concatenate([d, beside, down, diagonal])
    if ABOUT[name].hemisphere:
        all_of_them[:, 2] = np.abs(all_of_them[:, 2])
    return all_of_them


@pytest.mark.parametrize("family", SEVERAL)
def test_families_said_to_write_several_codes_do(family):
    for name in sm.packing.packings(family=family):
        codes = sm.packing.pack(directions_beside_edges(name), name)
        assert not np.array_equal(sm.packing.canonical(codes, name), codes), name


@pytest.mark.parametrize("name", [n for n in NAMES if ABOUT[n].bits <= 16])
def test_different_canonical_codes_are_different_directions(name):
    canonical = np.unique(sm.packing.canonical(all_codes(name), name), axis=0)
    if ABOUT[name].family == "draco":  # the last row and column lie beyond its grid, and stay
        canonical = canonical[canonical.max(-1) < (1 << ABOUT[name].bits // 2) - 1]
    d = sm.packing.unpack(canonical, name, dtype=np.float64)
    # The nearest are those of the ring of `spherical` next to a pole, and rays of `matcap`: 6e-5.
    assert close_pairs(d, 1e-5) == 0


@pytest.mark.parametrize("name", ["snorm8x3", "rgb8x3", "rgb10a2", "snorm10x3", "snorm16x3"])
def test_components_in_proportion_have_one_code(name):
    low = -12 if ABOUT[name].dtype.kind == "i" else 0
    place = np.stack(np.meshgrid(*[np.arange(25)] * 3, indexing="ij"), -1).reshape(-1, 3)
    if ABOUT[name].shape:
        middle = 0 if low else 116
        codes = (place + low + middle).astype(ABOUT[name].dtype)
    else:
        # Fields of ten bits about their middle: 0 in two's complement.
        middle = -12 if name == "snorm10x3" else 500
        codes = ((place + middle) % 1024 << np.array([0, 10, 20])).sum(-1).astype(np.uint32)
    codes = codes[np.isfinite(sm.packing.unpack(codes, name)).all(-1)]
    canonical = np.unique(sm.packing.canonical(codes, name), axis=0)
    assert len(canonical) < len(codes)
    d = sm.packing.unpack(canonical, name, dtype=np.float64)
    # Rays of numbers up to 25 are at least 1/25²/3 apart.
    assert close_pairs(d, 1e-5) == 0


def test_which_code_stands_for_all():
    for name, given_code, want in (
        ("snorm8x3", [1, 0, 0], [127, 0, 0]),
        ("snorm8x3", [2, -2, 2], [73, -73, 73]),  # 73√3 = 126.4, 74√3 = 128.2
        ("snorm8x3", [0, 0, 0], [0, 0, 0]),
        ("snorm16x3", [0, -7, 0], [0, -32767, 0]),
        ("rgb8x3", [255, 255, 255], [201, 201, 201]),  # 2·201 - 255 = 147, 147√3 = 254.6
        ("matcap8x2", [127, 127], [90, 90]),  # 90√2 = 127.3
        ("matcap8x2", [126, 1], [126, 1]),
        ("sphere8x2", [129, 5], [127, 0]),  # fields are unsigned: -127
        ("meshoptimizer8x4", [-3, 127, 127, 9], [3, 127, 127, 0]),
        ("draco8x2", [0, 200], [0, 54]),
        ("draco8x2", [255, 7], [255, 7]),
        ("pbrt16x2", [0, 0], [65535, 65535]),
        ("unreal10x2", [1023, 100], [1023, 923]),
        ("cesium8x2", [200, 0], [200, 0]),
        ("cesium8x2", [55, 0], [200, 0]),
    ):
        assert sm.packing.canonical(given_code, name).tolist() == want, name
    # Two bits of alpha.
    assert sm.packing.canonical(0xC0000001, "rgb10a2") == sm.packing.canonical(1, "rgb10a2")


def test_sphere_writes_one_code_of_its_rim():
    turn = np.linspace(0, 2 * np.pi, 1000)
    d = np.stack([np.cos(turn) * 1e-3, np.sin(turn) * 1e-3, -np.ones(1000)], -1)
    codes = sm.packing.pack(d, "sphere8x2")
    back = sm.packing.unpack(codes, "sphere8x2")
    down = back[:, 2] == -1
    assert down.any()
    assert (codes[down] == [127, 0]).all()


@pytest.mark.parametrize("rounding", ["precise", "hex"])
@pytest.mark.parametrize("name", [n for n in SIXTEEN if ABOUT[n].family in GRIDDED])
def test_every_rounding_finds_the_code_that_is_exactly_there(name, rounding):
    if rounding not in ABOUT[name].roundings:
        pytest.skip("has no such rounding")
    codes = all_codes(name)
    d = sm.packing.unpack(codes, name, dtype=np.float64)
    assert_same_bits(sm.packing.pack(d, name, rounding), sm.packing.canonical(codes, name))


def test_snorm_oct16_has_64518_directions():
    codes = sm.packing.canonical(all_codes("oct16"), "oct16")
    assert len(np.unique(codes)) == 64518
    d = sm.packing.unpack(np.unique(codes), "oct16", dtype=np.float64)
    assert len(np.unique(np.round(d, 12) + 0.0, axis=0)) == 64518


@pytest.mark.parametrize("name", ["oct16-centers", "woct16-centers", "cube16-s2", "fibonacci16"])
def test_grids_without_folds_have_a_direction_for_each_code(name):
    codes = all_codes(name)
    assert_same_bits(sm.packing.canonical(codes, name), codes)
    d = sm.packing.unpack(codes, name, dtype=np.float64)
    assert len(np.unique(np.round(d, 9) + 0.0, axis=0)) == len(codes)


def test_the_least_snorm_number_reads_as_minus_one():
    for name, fields in (("oct8x2", [-128, 5]), ("snorm8x3", [-128, 3, -128])):
        clamped = np.maximum(fields, -127)
        assert_same_bits(sm.packing.unpack(fields, name), sm.packing.unpack(clamped, name))
        assert sm.packing.canonical(fields, name).tolist() == clamped.tolist()
    assert_same_bits(
        sm.packing.unpack([-32768, 5], "oct16x2"), sm.packing.unpack([-32767, 5], "oct16x2")
    )


@pytest.mark.parametrize("name", EACH)
def test_axes_and_signs_of_zero(name):
    a = ABOUT[name]
    for axis in AXES:
        if a.hemisphere and axis[2] < 0:
            continue
        zero = axis == 0
        signs = [np.copysign(0.0, np.array(s) - 0.5) for s in np.ndindex(2, 2, 2)]
        signed = [np.where(zero, s, axis) for s in signs]
        if a.exact == "pbrt-v4":
            continue  # there the sign of a zero counts
        for dtype in (np.float32, np.float64):
            codes = {sm.packing.pack(d.astype(dtype), name).tobytes() for d in signed}
            assert len(codes) == 1, axis


# --- bounds


@pytest.mark.parametrize(
    "name", [n for n in BOUNDED if ABOUT[n].bits <= 32 or n in EACH or ABOUT[n].exact]
)
def test_bounds_hold(name):
    a = ABOUT[name]
    d = some_directions(name, 4000, a.bits)
    for rounding, bound in a.bounds.items():
        codes = sm.packing.pack(d, name, rounding)
        e = reference.angle(sm.packing.unpack(codes, name, dtype=np.float64), d)
        # Programs that compute in float32 add its roundings.
        single_slack = DRACO if a.family == "draco" else SINGLE
        # Others in float64: a few roundings of numbers up to pi.
        slack = single_slack if a.exact else 4e-15
        assert e.max() <= bound + slack, (rounding, e.max() / bound)
        single = d.astype(np.float32)
        codes = sm.packing.pack(single, name, rounding)
        e = reference.angle(sm.packing.unpack(codes, name).astype(float), reference.unit(single))
        assert e.max() <= bound + single_slack, rounding


def near_grid_points(grid: str, bits: int, n: int) -> np.ndarray:
    """Directions at the middles of cells, edges and triangles of the octahedral grid: the worst."""
    rng = np.random.default_rng(9)
    scale, _, _ = reference.steps(grid, bits)
    offset = 0.0 if grid == "snorm" else 0.5
    low = rng.integers(-int(scale), int(scale), (n, 2)) + offset
    # Where density is least, at the middle of the faces, and at the axes, too.
    low[: n // 4] = rng.integers(-3, 3, (n // 4, 2)) + offset
    low[n // 4 : n // 2] = np.round(scale / 3) + rng.integers(-3, 3, (n // 4, 2)) + offset
    inside = np.array([[0.5, 0.5], [0.5, 0], [1 / 3, 1 / 3], [2 / 3, 2 / 3], [0.5, 1]])
    place = (low + inside[rng.integers(0, 5, n)] + rng.normal(size=(n, 2)) * 1e-3) / scale
    return reference.oct_direction(np.clip(place, -1, 1))


@pytest.mark.parametrize("bits", [8, 12, 16, 24, 32, 40, 64])
def test_octahedral_closed_forms_on_the_worst_directions(bits):
    d = near_grid_points("snorm", bits // 2, 40_000)
    step = 1 / (2.0 ** (bits // 2 - 1) - 1)
    worst = {}
    for rounding in ("nearest", "precise", "hex"):
        q = sm.packing.unpack(
            sm.packing.pack(d, f"oct{bits}", rounding), f"oct{bits}", dtype=np.float64
        )
        worst[rounding] = reference.angle(q, d).max()
    # Both directions and the angle between them round by some 2e-16.
    slack = 4e-15
    assert 0.9 * 3 / np.sqrt(2) * step < worst["nearest"] <= 3 / np.sqrt(2) * step + slack
    assert 0.95 * np.sqrt(2) * step < worst["precise"] <= np.sqrt(2) * step + slack
    assert worst["hex"] <= 1.001 * np.sqrt(2) * step + slack
    # The closed form once more; `approx`'s own 1e-6 is ample.
    assert sm.packing.packing(f"oct{bits}").bounds["precise"] == pytest.approx(np.sqrt(2) * step)


def test_warped_16_bits_stay_below_054_degrees():
    assert np.degrees(sm.packing.packing("woct16").bound) <= 0.5401
    d = random_directions(400_000, 3)
    e = reference.angle(
        sm.packing.unpack(sm.packing.pack(d, "woct16"), "woct16", dtype=np.float64), d
    )
    assert np.degrees(e.max()) <= 0.54


# Measured over 10⁷ directions with a refined maximum: mean and max in degrees.
KNOWN = {
    ("oct16", "nearest"): (0.33693, 0.95666),
    ("oct16", "precise"): (0.31479, 0.63790),
    ("oct16", "hex"): (0.31554, 0.63795),
    ("oct8", "precise"): (5.668, 11.42),
    ("oct24", "precise"): (0.01953, 0.03957),
    ("equal_area16", "precise"): (0.30603, 0.58386),
    ("woct16", "precise"): (0.30495, 0.53837),
    ("woct16-centers", "precise"): (0.30261, 0.53529),
    ("woct8-centers", "precise"): (4.847, 8.738),
    ("fibonacci16", "precise"): (0.30303, 0.61055),
    ("rings16", "nearest"): (0.30354, 0.56250),
    ("hemioct16", "nearest"): (0.23998, 0.55241),
    ("spherical16", "nearest"): (0.35403, 0.78671),
    ("cube16", "nearest"): (0.32368, 0.77895),
    ("cube16-equiangular", "nearest"): (0.30879, 0.70297),
    ("cube16-s2", "nearest"): (0.31072, 0.67130),
    ("snorm8x3", "nearest"): (0.17015, 0.39075),
    ("snorm10x3", "nearest"): (0.04228, 0.09720),
}


@pytest.mark.parametrize(("name", "rounding"), KNOWN)
def test_means_and_maxima_agree_with_what_was_measured(name, rounding):
    mean, worst = KNOWN[name, rounding]
    d = some_directions(name, 150_000, 77)[6:]
    q = sm.packing.unpack(sm.packing.pack(d, name, rounding), name, dtype=np.float64)
    e = np.degrees(reference.angle(q, d))
    # The mean of so many errors spreads by mean/2/√150000 = 0.13 %: four of those.
    assert e.mean() == pytest.approx(mean, rel=0.0055)
    assert 0.85 * worst < e.max() <= worst * 1.003


# --- against the independent formulas


@pytest.mark.parametrize("grid", reference.GRIDS)
@pytest.mark.parametrize("family", GRIDDED)
@pytest.mark.parametrize("bits", [8, 16, 32, 48])
def test_decoding_and_precise_against_brute_force(family, grid, bits):
    name = f"{family}{bits}" + ("" if grid == "snorm" else f"-{grid}")
    d = some_directions(name, 5000, 5)
    for rounding in ("precise", "nearest"):
        words = sm.packing.pack(d, name, rounding)
        fields = reference.unpack_word(words, bits // 2, grid == "snorm")
        place = reference.fields_to_place(fields, grid, bits // 2)
        want = reference.MAPS[family][1](place)
        got = sm.packing.unpack(words, name, dtype=np.float64)
        # The equal-area map's slope is infinite at ±z: there the reference's own sum is off.
        assert reference.angle(got, want).max() < (3e-8 if family == "equal_area" else 4e-15)
    error = reference.angle(sm.packing.unpack(sm.packing.pack(d, name), name, dtype=np.float64), d)
    best = reference.best_error(d, family, grid, bits // 2)
    step = 2.0 ** (1 - bits // 2)
    # Where two corners are as near as makes no difference, either may win.
    assert (error - best).max() < 1e-6 * step + (3e-8 if family == "equal_area" else 4e-15)


def test_fibonacci_finds_the_nearest_of_all_points():
    n = 1 << 10
    points = reference.fibonacci_point(np.arange(n), n)
    # The reference's i/Φ of up to 632 turns rounds by 6e-14 turns: 4e-13 rad.
    assert (
        np.abs(sm.packing.unpack(np.arange(n), "fibonacci10", dtype=np.float64) - points).max()
        < 1e-12
    )
    d = np.concatenate([AXES, random_directions(20_000, 6)])
    best = reference.angle(points[(d @ points.T).argmax(1)], d)
    got = reference.angle(
        sm.packing.unpack(sm.packing.pack(d, "fibonacci10"), "fibonacci10", dtype=float), d
    )
    # The reference's points are off by 4e-13, and of two as near as that it may take either.
    assert (got - best).max() < 1e-9


# --- types, shapes, levels, threads


@pytest.mark.parametrize("name", EACH)
def test_levels_and_threads_give_the_same_bits(name):
    n = 1 << 17
    d = some_directions(name, n, 8)
    slow = ABOUT[name].family in ("fibonacci", "rings")
    for dtype in (np.float32, np.float64):
        hard = hard_directions.hard(dtype)[::8]
        x = np.concatenate([np.abs(hard) if ABOUT[name].hemisphere else hard, d.astype(dtype)])
        for rounding in ABOUT[name].roundings:
            results = []
            for level in [_core.simd_levels()[0]] if slow else _core.simd_levels():
                _core.set_simd_level(level)
                codes = sm.packing.pack(
                    x[: 9000 if not slow else 500], name, rounding, invalid="zero"
                )
                results.append((codes, sm.packing.unpack(codes, name, dtype=x.dtype)))
            for codes, back in results[1:]:
                assert_same_bits(codes, results[0][0])
                assert_same_bits(back, results[0][1])
    if slow:
        return
    _core.set_simd_level(None)
    sm.set_num_threads(1)
    want = (
        sm.packing.pack(d, name, "nearest", invalid="zero")
        if "nearest" in ABOUT[name].roundings
        else None
    )
    for threads in (2, 3):
        sm.set_num_threads(threads)
        if want is not None:
            assert_same_bits(sm.packing.pack(d, name, "nearest", invalid="zero"), want)


@pytest.mark.parametrize("name", EACH)
def test_shapes_dtypes_out_and_strides(name):
    a = ABOUT[name]
    d = some_directions(name, 18, 2).reshape(4, 6, 3)
    codes = sm.packing.pack(d, name)
    assert codes.dtype == a.dtype and codes.shape == (4, 6, *a.shape)
    out = np.empty_like(codes)
    assert sm.packing.pack(d, name, out=out) is out
    assert_same_bits(out, codes)
    assert_same_bits(sm.packing.pack(np.asfortranarray(d)[::-1], name), codes[::-1])
    assert_same_bits(sm.packing.pack(d.tolist(), name), codes)
    assert_same_bits(np.asarray(sm.packing.pack(d[1, 2], name)), codes[1, 2])
    assert sm.packing.pack(np.empty((0, 3)), name).shape == (0, *a.shape)
    back = sm.packing.unpack(codes, name)
    assert back.dtype == np.float32 and back.shape == (4, 6, 3)
    into = np.empty((4, 6, 3))
    assert sm.packing.unpack(codes, name, dtype=float, out=into) is into
    assert_same_bits(into, sm.packing.unpack(codes, name, dtype=float))
    assert_same_bits(sm.packing.unpack(codes[::-1], name), back[::-1])
    assert_same_bits(sm.packing.unpack(codes[1, 2].tolist(), name), back[1, 2])
    assert sm.packing.unpack(np.empty((0, *a.shape), a.dtype), name).shape == (0, 3)
    if a.bits < 64:
        assert_same_bits(sm.packing.unpack(codes.astype(np.int64), name), back)
    assert_same_bits(
        np.asarray(sm.packing.canonical(codes[0, 0], name)), sm.packing.canonical(codes, name)[0, 0]
    )
    # float16 is computed in float32.
    assert_same_bits(
        sm.packing.pack(d.astype("f2"), name), sm.packing.pack(d.astype("f2").astype("f4"), name)
    )


@pytest.mark.parametrize("bits", [16, 32, 64])
def test_words_and_arrays_of_fields_are_the_same_bits(bits):
    d = random_directions(1000, 4)
    for grid in ("", "-unorm", "-centers"):
        words = sm.packing.pack(d, f"oct{bits}{grid}")
        fields = sm.packing.pack(d, f"oct{bits // 2}x2{grid}")
        want = reference.unpack_word(words, bits // 2, grid == "")
        assert np.array_equal(fields, want)
    # An `out` that words cannot be laid over.
    raw = np.empty(2000 * bits // 16 + 1, np.uint8)[1:]
    odd = raw.view(f"i{bits // 16}").reshape(1000, 2)
    assert sm.packing.pack(d, f"oct{bits // 2}x2", out=odd) is odd
    assert np.array_equal(odd, sm.packing.pack(d, f"oct{bits // 2}x2"))


@given(st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=3, max_size=3))
def test_any_direction_of_any_length(d):
    d = np.array(d, np.float32)
    if not d.any():
        return
    for name in ("oct16", "oct32", "woct32", "equal_area32", "spherical32", "cube32", "snorm16x3"):
        a = ABOUT[name]
        code = sm.packing.pack(d, name)
        back = sm.packing.unpack(code, name, dtype=np.float64)
        e = reference.angle(back, reference.unit(d))
        assert e <= a.bound + SINGLE, name
        assert np.array_equal(
            sm.packing.pack(d.astype(float) * 2.0**300, name),
            sm.packing.pack(d.astype(float), name),
        )


@pytest.mark.parametrize("scale", [1e-3, 1e-6, 1e-7, 1e-20, 1e-37, 1e-300])
def test_draco_takes_any_length(scale):
    """Draco itself has +x for all that is shorter than 1e-6."""
    d = np.array([[1, -1, 2], [-3, 0.5, 0.25], [0, 0, -1]])
    want = sm.packing.pack(d, "draco16x2").astype(int)
    # What is scaled rounds to float anew: the code next to it is as near.
    assert np.abs(sm.packing.pack(d * scale, "draco16x2") - want).max() <= 1


# --- bad input


@pytest.mark.parametrize("scale", [1e300, 1e39, 1e-39, 1e-300])
def test_programs_that_compute_in_float_take_any_length(scale):
    """Beyond float they had infinity over infinity, and a code of the sign of NaN."""
    d = np.array([[1, -1, 2], [-3, 0.5, 0.25], [0, 0, -1]])
    want = sm.packing.pack(d, "pbrt16x2")
    # What is scaled rounds to float anew: the code next to it is as near.
    assert np.abs(sm.packing.pack(d * scale, "pbrt16x2").astype(int) - want).max() <= 1


@pytest.mark.parametrize("name", EACH)
def test_invalid_directions(name):
    a = ABOUT[name]
    good = np.array([0.0, 0.0, 1.0])
    for wrong in ([0, 0, 0], [-0.0, 0, 0], [np.nan, 0, 1], [0, np.inf, 0], [1, 2, -np.inf]):
        for n, k in ((1, 0), (5, 3), (200, 130), (150_000, 140_001)):
            d = np.tile(good, (n, 1)) if n < 1000 or name == "oct16" else None
            if d is None:
                continue
            d[k] = wrong
            d[-1] = wrong
            for dtype in (np.float32, np.float64):
                with pytest.raises(
                    ValueError,
                    match=rf"`directions`\[{k}\] is zero(, not| or not) finite",
                ):
                    sm.packing.pack(d.astype(dtype), name)
                codes = sm.packing.pack(d.astype(dtype), name, invalid="zero")
                assert not codes[k].any()
                valid = np.setdiff1d(np.arange(n), [k, n - 1])
                assert np.array_equal(
                    codes[valid],
                    np.broadcast_to(sm.packing.pack(good, name), (len(valid), *a.shape)),
                )
                assert_same_bits(sm.packing.pack(d.astype(dtype), name, invalid="ignore"), codes)
    with pytest.raises(ValueError, match=r"`directions`\[2, 1\]"):
        d = np.ones((3, 4, 3))
        d[2, 1] = 0
        sm.packing.pack(d, name)
    with pytest.raises(ValueError, match="`directions` is zero"):
        sm.packing.pack([0, 0, 0], name)
    strided = np.ones((1 << 15, 6), ">f4")[:, ::2]
    strided[20_000] = 0
    with pytest.raises(ValueError, match=r"`directions`\[20000\]"):
        sm.packing.pack(strided, name)


def test_below_the_horizon():
    down = [[0, 0, 1], [1.0, 0, -0.1]]
    with pytest.raises(ValueError, match=r"`directions`\[1\] is .* below the hemisphere"):
        sm.packing.pack(down, "hemioct16")
    assert sm.packing.pack(down, "hemioct16", invalid="zero").tolist() == [0, 0]
    codes = sm.packing.pack(down, "hemioct16", invalid="ignore")
    # +x is a point of the grid: exact.
    assert np.allclose(sm.packing.unpack(codes[1], "hemioct16"), [1, 0, 0])


@pytest.mark.parametrize(
    "name", [n for n in EACH if ABOUT[n].codes != 1 << (8 * ABOUT[n].dtype.itemsize)]
)
def test_codes_out_of_range_name_the_range(name):
    a = ABOUT[name]
    if a.shape:
        pytest.skip("fields have their own range")
    codes = np.zeros((3, 4), np.uint64)
    codes[1, 2] = a.codes
    for call in (sm.packing.unpack, sm.packing.canonical):
        with pytest.raises(
            ValueError, match=rf"\[0, {a.codes - 1}\], got {a.codes} at `codes`\[1, 2\]"
        ):
            call(codes, name)
        with pytest.raises(ValueError, match=r"got -1 at `codes`\[0\]"):
            call([-1, 5], name)


def test_wrong_arguments():
    d = [0.0, 0.0, 1.0]
    for call, error, match in (
        (
            lambda: sm.packing.pack(d, "okt16"),
            ValueError,
            "unknown packing 'okt16'; did you mean 'oct16'",
        ),
        (lambda: sm.packing.pack(d, "oct17"), ValueError, "did you mean 'oct1"),
        (lambda: sm.packing.packing("mercator"), ValueError, "the families are oct, hemioct"),
        (lambda: sm.packing.pack(d, 16), TypeError, "Packing or the name of one"),
        (
            lambda: sm.packing.pack(d, "cube16", "hex"),
            ValueError,
            "'nearest' or 'precise', got 'hex'",
        ),
        (lambda: sm.packing.pack(d, "oct16", "best"), ValueError, "`rounding` of 'oct16'"),
        (lambda: sm.packing.pack(d, "draco8x2", "hex"), ValueError, "got 'hex'"),
        (lambda: sm.packing.pack(d, "oct16", invalid="skip"), ValueError, "`invalid`"),
        (lambda: sm.packing.pack([1.0, 2.0], "oct16"), ValueError, r"shape \(..., 3\), got \(2,\)"),
        (lambda: sm.packing.pack([1j, 0, 0], "oct16"), TypeError, "real"),
        (lambda: sm.packing.pack(d, "oct16", out=np.empty((), np.int16)), TypeError, "uint16"),
        (
            lambda: sm.packing.pack([d], "oct8x2", out=np.empty((2, 2), np.int8)),
            ValueError,
            "shape",
        ),
        (
            lambda: sm.packing.pack([d], "snorm8x3", out=np.empty((2, 3), np.int8)),
            ValueError,
            "shape",
        ),
        (lambda: sm.packing.pack([d], "oct8x2", out=np.empty((1, 2), np.uint8)), TypeError, "int8"),
        (lambda: sm.packing.pack([d], "oct8x2", out=[0, 0]), TypeError, "list"),
        (
            lambda: sm.packing.pack([d] * 2, "oct8x2", out=np.empty((4, 2), np.int8)[::2]),
            ValueError,
            "contig",
        ),
        (lambda: sm.packing.unpack([0.5], "oct16"), TypeError, "integers"),
        (lambda: sm.packing.unpack([True], "oct16"), TypeError, "integers"),
        (
            lambda: sm.packing.unpack([1, 2, 3], "oct8x2"),
            ValueError,
            r"shape \(..., 2\), got \(3,\)",
        ),
        (lambda: sm.packing.unpack([1, 200], "oct8x2"), ValueError, r"\[-128, 127\], got 200"),
        (lambda: sm.packing.unpack([1], "oct16", dtype="f2"), TypeError, "float16"),
        (lambda: sm.packing.packings(family="okt"), ValueError, "there are oct"),
        (lambda: sm.packing.best_packing(7), ValueError, "between 8 and 64"),
        (lambda: sm.packing.best_packing(16.0), TypeError, "integer"),
        (lambda: sm.packing.pack_frame(d, d), ValueError, "along its normal"),
        (lambda: sm.packing.pack_frame(d, [1, 0]), ValueError, "tangents"),
        (lambda: sm.packing.pack_frame(d, [1, 0, 0], "frame16"), ValueError, "frame32"),
        (lambda: sm.packing.unpack_frame(1 << 40), ValueError, "frame32"),
    ):
        with pytest.raises(error, match=match):
            call()


def test_read_only_and_overlapping_out():
    d = random_directions(8, 1)
    for name in ("oct64", "oct32x2"):
        a = ABOUT[name]
        out = np.empty((8, *a.shape), a.dtype)
        out.flags.writeable = False
        with pytest.raises(ValueError, match="read-only"):
            sm.packing.pack(d, name, out=out)
    with pytest.raises(ValueError, match="overlaps"):
        sm.packing.pack(d, "oct64", out=d.view(np.uint64).reshape(-1)[:8])
    codes = np.zeros(12, np.uint64)
    with pytest.raises(ValueError, match="overlaps"):
        sm.packing.unpack(codes[:4], "oct64", dtype=float, out=codes.view(float).reshape(4, 3))
    read_only = sm.packing.pack(d, "oct16")
    read_only.flags.writeable = False
    assert sm.packing.unpack(read_only, "oct16").shape == (8, 3)


# --- descriptions


def test_packing_objects():
    p = sm.packing.packing("oct16-snorm")
    assert (
        p == sm.packing.packing("oct16")
        and p.name == "oct16"
        and hash(p) == hash(sm.packing.packing(p))
    )
    assert pickle.loads(pickle.dumps(p)) == p
    with pytest.raises(AttributeError):
        p.bits = 8
    assert_same_bits(sm.packing.pack([1, 2, 3], p), sm.packing.pack([1, 2, 3], "oct16"))
    assert set(sm.packing.packings(bits=16)) == {n for n in NAMES if ABOUT[n].bits == 16}
    assert all(ABOUT[n].shape for n in sm.packing.packings(words=False))
    for a in ABOUT.values():
        assert a.source and a.summary and a.title and a.bounds.keys() == set(a.roundings)
        assert a.codes <= 1 << a.bits
        if a.family in GRIDDED:
            assert a.bounds["precise"] <= a.bounds["nearest"]


def test_the_best_packing_is_the_best():
    for bits in (8, 11, 16, 24, 32, 64):
        for hemisphere in (False, True):
            best = sm.packing.best_packing(bits, hemisphere=hemisphere)
            assert best.bits <= bits
            d = some_directions("hemioct16" if hemisphere else "oct16", 20_000, 3)
            if bits <= 32:
                e = reference.angle(
                    sm.packing.unpack(sm.packing.pack(d, best), best, dtype=float), d
                ).max()
                for family in ("oct", "spherical", "cube"):
                    other = f"{family}{bits // 2 * 2}"
                    q = sm.packing.unpack(sm.packing.pack(d, other), other, dtype=float)
                    assert e < reference.angle(q, d).max()
    assert sm.packing.best_packing(16, standard=True).family == "oct"


@pytest.mark.filterwarnings("default::spheremap.packing.UnboundedPackingWarning")
@pytest.mark.parametrize("name", ["sphere16", "matcap16", "z_phi8x2"])
def test_unbounded_schemes_warn(name):
    with pytest.warns(sm.packing.UnboundedPackingWarning, match="has as many bits"):
        sm.packing.pack([0, 0, 1], name)


# --- frames


@pytest.mark.parametrize(
    ("name", "normal", "steps"), [("frame32", "oct20", 11), ("frame64", "oct40", 23)]
)
def test_frames(name, normal, steps):
    n = np.concatenate([AXES, random_directions(20_000, 1)])
    t = np.roll(np.concatenate([AXES, random_directions(20_000, 2)]), 2, 0)
    t -= n * (n * t).sum(-1, keepdims=True)
    t /= np.linalg.norm(t, axis=-1, keepdims=True)
    w = np.where(np.arange(len(n)) % 3 == 0, -1.0, 1.0)
    codes = sm.packing.pack_frame(n * 3, np.concatenate([t * 0.1, w[:, None]], -1), name)
    assert codes.dtype == (np.uint32 if name == "frame32" else np.uint64)
    n2, t2 = sm.packing.unpack_frame(codes, name, dtype=np.float64)
    assert np.array_equal(t2[:, 3], w)
    # Two products of three numbers up to 1: some 2e-16 each.
    assert np.abs((n2 * t2[:, :3]).sum(-1)).max() < 1e-15
    bound = sm.packing.packing(normal).bound
    assert reference.angle(n2, n).max() <= bound
    # Half a step of the angle, and the tilt of the normal.
    assert reference.angle(t2[:, :3], t).max() <= np.pi / 2**steps + bound
    assert_same_bits(sm.packing.pack_frame(n2, t2, name), codes, "canonical")
    assert_same_bits(sm.packing.pack_frame(n.tolist(), t.tolist(), name)[w > 0], codes[w > 0])
    single = sm.packing.unpack_frame(codes[0], name)
    assert single[0].shape == (3,) and single[1].dtype == np.float32


@pytest.mark.parametrize("lean", [0, 0.3, 5, -20, 1e3])
@pytest.mark.parametrize("length", [1, 1e-200, 1e200])
@pytest.mark.parametrize(
    ("name", "normal", "steps"), [("frame32", "oct20", 11), ("frame64", "oct40", 23)]
)
def test_what_leans_along_the_normal_does_not_turn_a_tangent(name, normal, steps, lean, length):
    n = np.concatenate([AXES, random_directions(20_000, 3)])
    t = np.cross(n, np.roll(n, 2, 0))
    t /= np.linalg.norm(t, axis=-1, keepdims=True)
    codes = sm.packing.pack_frame(n / length, (t + lean * n) * length, name)
    _, back = sm.packing.unpack_frame(codes, name, dtype=np.float64)
    # Half a step of the angle, the tilt of the normal, and what the sum has lost.
    limit = np.pi / 2**steps + sm.packing.packing(normal).bound + 4e-16 * (1 + abs(lean))
    assert reference.angle(back[:, :3], t).max() <= limit


def test_a_tangent_along_a_normal_that_is_no_point_of_the_grid_is_none():
    for scale in (1, -2, 1e-30):
        with pytest.raises(ValueError, match="along its normal"):
            sm.packing.pack_frame([1, 2, 3], np.array([1, 2, 3]) * scale)


def test_invalid_frames():
    n = np.tile([0.0, 0.0, 1.0], (3, 1))
    for wrong in ([0, 0, 0], [0, 0, 5], [np.nan, 0, 1]):
        t = np.array([[1.0, 0, 0], wrong, [0, 1, 0]])
        with pytest.raises(ValueError, match=r"the frame\[1\]"):
            sm.packing.pack_frame(n, t)
        codes = sm.packing.pack_frame(n, t, invalid="zero")
        assert codes[1] == 0
        assert codes[0] == sm.packing.pack_frame(n[0], t[0]) and codes[2] == sm.packing.pack_frame(
            n[0], t[2]
        )
    masked = np.ma.masked_array(n, [[False] * 3, [True] * 3, [False] * 3])
    with pytest.raises(ValueError, match=r"the frame\[1\]"):
        sm.packing.pack_frame(masked, [1.0, 0, 0])
    with pytest.raises(ValueError, match=r"the frame\[1\]"):
        sm.packing.pack_frame([1.0, 0, 0], masked)
