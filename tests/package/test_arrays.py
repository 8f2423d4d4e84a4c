"""Arrays as numpy has them: dtypes, shapes, strides, out, overlap, empty, large."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, LAYOUTS, each, random_directions, some_fast, valid_uv
from spheremap import _arrays, _core

VERBS = ("encode", "decode", "jacobian", "density")


def inputs(case, verb: str, n: int, seed: int, dtype=np.float64) -> np.ndarray:
    r = case.reference()
    if verb == "encode":
        d = random_directions(12 * n + 100, seed)
        return d[r.covers(d)][:n].astype(dtype)
    return valid_uv(r, n, seed, margin=1e-3).astype(dtype)


def tail(p: sm.Projection, verb: str) -> tuple[int, ...]:
    return {
        "encode": (3 if p.faces > 1 else 2,),
        "decode": (3,),
        "jacobian": (3, 2),
        "density": (),
    }[verb]


@each(DEFAULTS)
@pytest.mark.parametrize("verb", VERBS)
def test_leading_axes_are_free(case, verb):
    p = case.make()
    x = inputs(case, verb, 24, 120)
    f = getattr(p, verb)
    want = f(x)
    t = tail(p, verb)
    assert want.shape == (24, *t)
    for shape in ((24,), (4, 6), (2, 3, 4), (1, 24, 1), (2, 1, 3, 4)):
        assert np.array_equal(f(x.reshape(*shape, -1)), want.reshape(*shape, *t)), shape
    one = f(x[3])
    assert np.shape(one) == t and np.array_equal(one, want[3])
    assert np.array_equal(f(x[3].tolist()), want[3])
    assert np.array_equal(f(tuple(x[3].tolist())), want[3])
    for shape in ((0,), (0, 5), (3, 0)):
        empty = f(np.empty((*shape, x.shape[-1])))
        assert empty.shape == (*shape, *t) and empty.dtype == np.float64


@each(DEFAULTS)
@pytest.mark.parametrize("verb", VERBS)
@some_fast("n", [1, 2, 7, 63, 64, 65, 129, 1000], fast=(1, 7, 64, 65))
def test_block_sizes(case, verb, n):
    # Results are the same however the input is cut: no remainder loop of its own.
    p = case.make()
    for dtype in (np.float32, np.float64):
        x = inputs(case, verb, n, 121, dtype)
        f = getattr(p, verb)
        whole = f(x)
        single = np.array([f(row) for row in x[:: max(1, n // 20)]])
        assert np.array_equal(whole[:: max(1, n // 20)], single)


@each(DEFAULTS)
@pytest.mark.parametrize("verb", VERBS)
def test_dtypes(case, verb):
    p = case.make()
    f = getattr(p, verb)
    x = inputs(case, verb, 50, 122)
    assert f(x).dtype == np.float64
    x32 = x.astype(np.float32)
    assert f(x32).dtype == np.float32
    x16 = x.astype(np.float16)
    half = f(x16)
    assert half.dtype == np.float32
    assert np.array_equal(half, f(x16.astype(np.float32)), equal_nan=True)
    big = x32.astype(">f4")
    assert np.array_equal(f(big), f(x32), equal_nan=True)
    wide = f(x.astype(np.longdouble))
    assert wide.dtype == np.float64 and np.array_equal(wide, f(x), equal_nan=True)


@pytest.mark.parametrize("kind", ["?", "b", "B", "h", "H", "i", "I", "q", "Q"])
def test_integers_become_float64(kind):
    d = np.array([[1, 0, 1], [0, 1, 1], [1, 1, 1]]).astype(kind)
    for name in sm.projections():
        got = sm.encode(d, name)
        assert got.dtype == np.float64
        assert np.array_equal(got, sm.encode(d.astype(np.float64), name), equal_nan=True)


def test_lists_and_integers_of_python():
    assert sm.encode([0, 0, 1], "octahedral").dtype == np.float64
    assert sm.encode([[0, 1, 1], [1, 0, 0]], "octahedral").shape == (2, 2)


@pytest.mark.parametrize(
    "wrong",
    [
        np.ones((2, 3), complex),
        np.array([["a", "b", "c"]]),
        np.array([[Fraction(1), Fraction(1), Fraction(1)]], object),
        np.array([["2020-01-01"] * 3], "datetime64[D]"),
        "abc",
        None,
    ],
    ids=["complex", "str", "object", "datetime", "text", "None"],
)
def test_other_dtypes_raise_type_error(wrong):
    with pytest.raises(TypeError, match=r"directions|dtype"):
        sm.encode(wrong, "octahedral")


@each(DEFAULTS)
@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_strides(case, verb, dtype):
    p = case.make()
    f = getattr(p, verb)
    x = inputs(case, verb, 60, 123, dtype)
    k = x.shape[-1]
    want = f(x)
    wide = np.zeros((60, 2 * k + 1), dtype)
    wide[:, 1 : 2 * k + 1 : 2] = x
    tall = np.zeros((180, k), dtype)
    tall[::3] = x
    views = {
        "every other column": wide[:, 1 : 2 * k + 1 : 2],
        "every third row": tall[::3],
        "fortran": np.asfortranarray(x),
        "reversed rows": np.ascontiguousarray(x[::-1])[::-1],
        "reversed columns": np.ascontiguousarray(x[:, ::-1])[:, ::-1],
    }
    for what, view in views.items():
        assert np.array_equal(f(view), want), what
    cube = x.reshape(3, 4, 5, k)
    moved = np.ascontiguousarray(cube.transpose(2, 0, 3, 1)).transpose(1, 3, 0, 2)
    assert np.array_equal(f(moved), want.reshape(3, 4, 5, *want.shape[1:]))
    same = np.broadcast_to(x[0], (7, k))
    assert np.array_equal(f(same), np.broadcast_to(want[0], (7, *want.shape[1:])))
    locked = x.copy()
    locked.flags.writeable = False
    assert np.array_equal(f(locked), want)
    assert np.array_equal(locked, x)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_unaligned(verb, dtype):
    p = sm.projection("octahedral")
    k = 3 if verb == "encode" else 2
    x = (np.random.default_rng(132).random((60, k)) * 0.4 + 0.1).astype(dtype)
    want = getattr(p, verb)(x)
    raw = np.zeros(60 * k * x.itemsize + 1, np.uint8)
    raw[1:] = x.view(np.uint8).ravel()
    assert np.array_equal(getattr(p, verb)(raw[1:].view(dtype).reshape(60, k)), want)
    record = np.zeros(60, [("pad", "u1"), ("d", dtype, k)])
    record["d"] = x
    assert np.array_equal(getattr(p, verb)(record["d"]), want)


def test_subclasses_are_taken_as_arrays():
    m = np.matrix if hasattr(np, "matrix") else None
    d = random_directions(5, 124)
    masked = np.ma.masked_array(d, mask=False)
    assert np.array_equal(sm.encode(masked, "cube"), sm.encode(d, "cube"))
    assert m is not None

    class Holder:
        def __array__(self, dtype=None, copy=None):
            return d if dtype is None else d.astype(dtype)

    assert np.array_equal(sm.encode(Holder(), "cube"), sm.encode(d, "cube"))


# Each way into the core: points, images, light.
MASKED = {
    "encode": lambda x: sm.encode(x[:, :3], "cube"),
    "sample": lambda x: sm.sample(x, random_directions(50, 126), "latlong", skipna=True),
    "convert": lambda x: sm.convert(x, "latlong", "cube", size=3, skipna=True),
    "area": lambda x: sm.convert(x, "latlong", "cube", size=3, filter="area", skipna=True),
    "batch": lambda x: sm.convert(
        np.ma.stack([x[..., None]] * 2) if np.ma.isMaskedArray(x) else np.stack([x[..., None]] * 2),
        "latlong",
        "cube",
        size=3,
    ),
    "mean": lambda x: sm.light.mean(x, "latlong", skipna=True),
    "irradiance": lambda x: sm.light.irradiance(x, "latlong", "cube", size=2, skipna=True),
}


@pytest.mark.parametrize("name", MASKED)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_what_is_masked_is_missing(name, dtype):
    work = MASKED[name]
    image = np.random.default_rng(125).random((12, 24)).astype(dtype)
    missing = image > 0.9
    masked = np.ma.masked_array(np.where(missing, dtype(-9999), image), missing)
    want = work(np.where(missing, dtype(np.nan), image))
    assert np.array_equal(work(masked), want, equal_nan=True)
    assert masked.data.min() == -9999


def test_labels_that_are_masked_are_refused():
    labels = np.ma.masked_equal(np.arange(12 * 24).reshape(12, 24), 7)
    for dtype in (np.uint8, np.int64):
        with pytest.raises(TypeError, match=r"masked elements, and .*`image.filled\(0\)`"):
            sm.convert(labels.astype(dtype), "latlong", "cube", size=3, filter="nearest")


@each(DEFAULTS)
@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_out(case, verb, dtype):
    p = case.make()
    f = getattr(p, verb)
    x = inputs(case, verb, 30, 125, dtype)
    want = f(x)
    out = np.full(want.shape, 7, dtype)
    assert f(x, out=out) is out
    assert np.array_equal(out, want)
    free = getattr(sm, verb)
    out[...] = 7
    assert free(x, p, out=out) is out and np.array_equal(out, want)
    other = np.float64 if dtype == np.float32 else np.float32
    with pytest.raises(TypeError, match="out"):
        f(x, out=np.empty(want.shape, other))
    with pytest.raises(TypeError, match="out"):
        f(x, out=[0.0])
    with pytest.raises(ValueError, match="out"):
        f(x, out=np.empty((31, *want.shape[1:]), dtype))
    with pytest.raises(ValueError, match="out"):
        f(x, out=np.empty((*want.shape, 1), dtype))
    with pytest.raises(ValueError, match="out"):
        f(x, out=np.empty((60, *want.shape[1:]), dtype)[::2])
    locked = np.empty(want.shape, dtype)
    locked.flags.writeable = False
    with pytest.raises(ValueError, match="out"):
        f(x, out=locked)


@pytest.mark.parametrize("verb", VERBS)
def test_out_must_not_overlap_the_input(verb):
    p = sm.projection("octahedral")
    memory = np.random.default_rng(126).random(4000) * 0.5 + 0.2
    k = 3 if verb == "encode" else 2
    x = memory[: 100 * k].reshape(100, k)
    shape = getattr(p, verb)(x).shape
    n = int(np.prod(shape))
    before = memory.copy()
    for start in (0, 1, 50, 100 * k - 1):
        out = memory[start : start + n].reshape(shape)
        with pytest.raises(ValueError, match="overlap"):
            getattr(p, verb)(x, out=out)
        assert np.array_equal(memory, before)
    out = memory[100 * k : 100 * k + n].reshape(shape)
    assert getattr(p, verb)(x, out=out) is out  # neighbors are no overlap


def test_out_that_interleaves_with_a_strided_input_is_refused():
    memory = np.random.default_rng(127).random((100, 8))
    x = memory[:, :3]
    out = memory.reshape(-1)[3 : 3 + 200].reshape(100, 2)
    with pytest.raises(ValueError, match="overlap"):
        sm.encode(x, "octahedral", out=out)


@pytest.mark.parametrize("n", [100, 100_000])
def test_out_that_overlaps_what_is_converted_is_refused(n):
    memory = np.random.default_rng(133).random(20 * n)
    image = np.random.default_rng(134).random((8, 16, 6))
    d = random_directions(n, 135)
    rows = memory.reshape(-1, 8)[:n]
    kept = memory.copy(), image.copy()
    flat = lambda start, *shape: memory[start:][: int(np.prod(shape))].reshape(shape)  # noqa: E731
    message = "`out` overlaps an input or an array that another call is using"
    p = sm.projection("octahedral")
    for call in (
        lambda: p.encode(rows[:, :3], out=flat(3, n, 2)),
        lambda: p.decode(rows[:, :2], out=flat(n, n, 3)),
        lambda: p.jacobian(rows[::-1, :2], out=flat(5, n, 3, 2)),
        lambda: p.density(rows[:, 2:4], out=flat(5, n)),
        lambda: p.encode(memory.view(np.int64)[: 3 * n].reshape(n, 3), out=flat(0, n, 2)),
        lambda: p.encode(memory.view(np.float32)[: 3 * n].reshape(n, 3)[::-1], out=flat(0, n, 2)),
        lambda: sm.reflect(rows[:, :3], d, out=flat(1, n, 3)),
        lambda: sm.reflect(d, rows[:, 3:6], out=flat(1, n, 3)),
        lambda: sm.reflect(d.astype(np.float32), flat(0, n, 3), out=flat(2 * n, n, 3)),
        lambda: p.sample(np.ones((4, 4)), rows[:, :3], out=flat(1, n)),
        lambda: sm.sample(
            image[..., ::2], d[:20], "latlong", out=image.ravel()[:60].reshape(20, 3)
        ),
        lambda: sm.convert(
            image[::-1], "latlong", "sphere", size=2, out=image[0, :4].reshape(2, 2, 6)
        ),
    ):
        with pytest.raises(ValueError, match=message):
            call()
    assert np.array_equal(memory, kept[0]) and np.array_equal(image, kept[1])
    # Apart: a strided input in the one half, the output in the other.
    got = p.encode(rows[:, :3], out=flat(8 * n, n, 2))
    assert np.array_equal(got, p.encode(rows[:, :3].copy()))


# Larger than a block of conversion: cut along the first axes, and within an index of them.
LARGE = [(100_003,), (3, 33_000), (40_000, 2), (2, 3, 1, 11_000), (2, 2, 40_000), (1, 70_000, 1)]


@pytest.mark.parametrize("shape", LARGE, ids=str)
def test_large_arrays_that_are_converted_block_by_block(shape):
    p = sm.projection("cube")
    rng = np.random.default_rng(136)
    memory = rng.normal(size=(*shape, 8))
    image = rng.random((6, 5, 5, 2))
    flipped = tuple(slice(None, None, -1) for _ in shape)
    for x in (
        memory[..., 2:5],
        memory[..., 5:2:-1],
        memory[..., :3][flipped],
        np.asfortranarray(memory[..., :3]),
        memory[..., :3].astype(np.float16),
        memory[..., :3].astype(">f8"),
        (memory[..., :3] * 100).astype(np.int16),
        memory[..., :3].astype(np.longdouble),
        memory[..., :3].astype(np.float32)[..., ::-1],
        np.broadcast_to(memory[0, ..., :3], (*shape, 3)),
    ):
        plain = x.astype(np.float32 if x.dtype.itemsize <= 4 and x.dtype.kind == "f" else float)
        plain = np.ascontiguousarray(plain)
        uv = p.encode(plain)
        assert uv.dtype == plain.dtype
        got = p.encode(x)
        assert got.dtype == uv.dtype and np.array_equal(got, uv, equal_nan=True)
        out = np.empty_like(uv)
        assert p.encode(x, out=out) is out and np.array_equal(out, uv, equal_nan=True)
        assert np.array_equal(p.covers(x), p.covers(plain))
        got = p.sample(image, x, fill=7)
        assert np.array_equal(got, p.sample(image, plain, fill=7))
        one = np.array([1.0, 2.0, 3.0])
        want = sm.reflect(plain.astype(float), one)
        assert np.array_equal(sm.reflect(x, one), want, equal_nan=True)
        want = sm.reflect(np.broadcast_to(one, x.shape).copy(), plain.astype(float))
        assert np.array_equal(sm.reflect(one, x), want, equal_nan=True)
        want = sm.reflect(plain, plain)
        assert np.array_equal(sm.reflect(x, x), want, equal_nan=True)
        turned = np.asfortranarray(uv)
        for verb in ("decode", "jacobian", "density", "valid"):
            want = getattr(p, verb)(uv)
            assert np.array_equal(getattr(p, verb)(turned), want, equal_nan=True), verb


def test_large_arrays_of_wrong_shape_or_dtype():
    for wrong in (np.ones((50_000, 8))[:, :4], np.ones((50_000, 8))[:, :2], np.ones(400_000)[::2]):
        with pytest.raises(ValueError, match=r"Expected `directions` to have shape \(\.\.\., 3\)"):
            sm.encode(wrong, "octahedral")
    with pytest.raises(
        TypeError, match="Expected `directions` to be real numbers, got dtype compl"
    ):
        sm.encode(np.ones((50_000, 3), complex), "octahedral")
    with pytest.raises(ValueError, match="out"):
        sm.encode(np.ones((50_000, 6))[:, ::2], "octahedral", out=np.empty((50_001, 2)))
    with pytest.raises(TypeError, match="out"):
        sm.encode(np.ones((50_000, 6))[:, ::2], "octahedral", out=np.empty((50_000, 2), "f4"))


SKY, NORMALS = np.ones((8, 16, 3)), np.ones((5, 3))


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("points", lambda x: sm.points_to_depth(x, "latlong", 8)),
        ("matcap", lambda x: sm.light.shade_matcap(NORMALS, x)),
        ("reference", lambda x: sm.light.ws_psnr(SKY, x, "latlong")),
        ("view", lambda x: sm.embed(x, "perspective", SKY, "latlong")),
        ("photo", sm.ball.find),
        ("photos", lambda x: sm.ball.merge([x, x])),
        ("image", lambda x: sm.light.integrate(x, "latlong")),
    ],
)
@pytest.mark.parametrize("wrong", [np.ones((8, 16, 3), complex), np.array("sky.exr")])
def test_an_error_names_the_argument(name, call, wrong):
    with pytest.raises((TypeError, ValueError), match=f"`{name}`"):
        call(wrong)


def test_points_have_three_numbers():
    for wrong in (np.ones(7), np.ones((0,)), np.ones((3, 2)), 1.0):
        with pytest.raises(ValueError, match=r"Expected `points` to have shape \(\.\.\., 3\)"):
            sm.points_to_depth(wrong, "latlong", 8)


def test_parameters_are_numbers():
    with pytest.raises(TypeError, match=r"^`fov` must be a number, got str\.$"):
        sm.projection("angular", fov="wide")
    with pytest.raises(TypeError, match=r"^`fov` must be a number, got NoneType\.$"):
        sm.projection("angular", fov=None)
    assert sm.projection("angular", fov=np.float32(180)) == sm.projection("angular", fov=180)


@each(DEFAULTS)
def test_wrong_shapes(case):
    p = case.make()
    with pytest.raises(ValueError, match=r"Expected `directions` to have shape \(\.\.\., 3\), got"):
        p.encode(np.ones((4, 2)))
    with pytest.raises(ValueError, match="directions"):
        p.encode(1.0)
    k = 3 if p.faces > 1 else 2
    for verb in ("decode", "jacobian", "density", "valid"):
        with pytest.raises(ValueError, match=rf"Expected `uv` to have shape \(\.\.\., {k}\), got"):
            getattr(p, verb)(np.ones((4, 5 - k)))


@each(LAYOUTS)
def test_inputs_are_not_changed(case):
    p = case.make()
    d = random_directions(500, 128)
    kept = d.copy()
    uv = p.encode(d)
    p.sample(np.ones((*p.shape(4), 3)), d)
    assert np.array_equal(d, kept)
    kept = uv.copy()
    p.decode(uv), p.jacobian(uv), p.density(uv), p.valid(uv)
    assert np.array_equal(uv, kept, equal_nan=True)


@each(DEFAULTS)
@some_fast("dtype", [np.float32, np.float64], fast=(np.float32,))
def test_huge_arrays_are_the_same_as_small_ones(case, dtype):
    # Past the size where work is split over threads, and not a multiple of any block.
    p = case.make()
    n = (1 << 18) + 4099
    d = random_directions(n, 129).astype(dtype)
    uv = p.encode(d)
    parts = np.concatenate([p.encode(d[i : i + 10_001]) for i in range(0, n, 10_001)])
    assert np.array_equal(uv, parts, equal_nan=True)
    back = p.decode(uv)
    parts = np.concatenate([p.decode(uv[i : i + 10_001]) for i in range(0, n, 10_001)])
    assert np.array_equal(back, parts, equal_nan=True)
    turned = p.encode(d[::-1])
    assert np.array_equal(turned[::-1], uv, equal_nan=True)


@pytest.mark.parametrize("name", ["octahedral", "cube", "matcap"])
@pytest.mark.parametrize("first", [0, 1])
def test_what_caches_do_not_hold_is_the_same_in_used_memory(name, first):
    # From 48 MiB on, results in memory of the caller go past the caches where the place allows it:
    # the first does, the second does not.
    p = sm.projection(name)
    n = 1_350_007
    d = np.resize(random_directions(10_007, 131), (n, 3))
    uv = p.encode(d)
    room = np.full(uv.size + 8, 7.0)
    out = room[first : first + uv.size].reshape(uv.shape)
    assert np.array_equal(p.encode(d, out=out), uv, equal_nan=True)
    assert (room[:first] == 7).all() and (room[first + uv.size :] == 7).all()
    room = np.full(d.size + 8, 7.0)
    out = room[first : first + d.size].reshape(d.shape)
    assert np.array_equal(p.decode(uv, out=out), p.decode(uv), equal_nan=True)
    assert (room[:first] == 7).all() and (room[first + d.size :] == 7).all()


@each(DEFAULTS)
def test_rotation_of_encode_and_decode(case):
    p = case.make()
    turn = sm.rotation(25, 60, -40)
    d = random_directions(2000, 130)
    a, b = p.encode(d, rotation=turn), p.encode(d @ turn)
    assert np.array_equal(np.isnan(a), np.isnan(b))
    # Directions turned to within 2 ε; an azimuth by that over 1e-2, the nearest to a pole: 4e-14.
    assert np.nanmax(np.abs(a - b)) < 1e-12
    uv = valid_uv(case.reference(), 1000, 131, margin=1e-3)
    # 18 ε: three products and two sums of numbers up to 1, in NumPy and in ours.
    assert np.abs(p.decode(uv, rotation=turn) - p.decode(uv) @ turn.T).max() < 1e-15 * 4
    got = p.jacobian(uv, rotation=turn)
    want = np.einsum("ij,njk->nik", turn, p.jacobian(uv))
    # The same sums of a column's numbers, of which the largest is the measure: 450 ε.
    assert np.abs(got - want).max() < 1e-13 * np.abs(want).max()
    assert np.array_equal(p.covers(d, rotation=turn), ~np.isnan(a).any(-1))
    c = p.directions(5, rotation=turn)
    # As of decode, above.
    assert np.nanmax(np.abs(c - p.directions(5) @ turn.T)) < 1e-15 * 4
    d32 = d.astype(np.float32)
    assert p.encode(d32, rotation=turn).dtype == np.float32
    e32 = reference.angle(p.decode(p.encode(d32, rotation=turn), rotation=turn), d32)
    ok = p.covers(d32, rotation=turn) & ~np.isnan(np.asarray(e32, float))
    # The bounds of the round trip plus the rounding of two turns.
    assert e32[ok].max() < {"sphere": 1.3e-3, "matcap": 5e-4, "orthographic": 5e-4}.get(
        case.name, 1.5e-6
    )


@each(LAYOUTS)
def test_directions_dtype_and_solid_angle_dtype(case):
    p = case.make()
    assert p.directions(3).dtype == np.float64
    assert p.directions(3, dtype=np.float32).dtype == np.float32
    assert p.directions(3, dtype="float32").dtype == np.float32
    assert p.solid_angle(3).dtype == np.float64
    with pytest.raises((TypeError, ValueError), match="dtype"):
        p.directions(3, dtype=np.int32)


@pytest.mark.parametrize("leading", [31, 32, 40, 62, 63])
def test_as_many_axes_as_numpy_allows(leading):
    d = np.ones((1,) * leading + (3,), np.float32)
    assert sm.encode(d, "latlong").shape == (1,) * leading + (2,)
    assert sm.encode(d[..., ::-1], "latlong").shape == (1,) * leading + (2,)
    uv = sm.encode(d, "latlong")
    if leading < 63:
        assert sm.jacobian(uv, "latlong").shape == (1,) * leading + (3, 2)
    else:
        with pytest.raises(ValueError, match="dimension"):
            sm.jacobian(uv, "latlong")


def test_the_core_calls_helpers_that_there_are():
    names = _core.helpers()
    assert names == sorted(names)
    assert all(callable(getattr(_arrays, name)) for name in names)
