"""Sums over images in chunks: the bits of the whole, each chunk's part by itself."""

import pickle
from collections import Counter

import dask
import dask.array as da
import numpy as np
import pytest
import spheremap as sm
import spheremap.dask as smd
from conftest import some_fast

rng = np.random.default_rng(8)

# More than a sheet of 512² texels a face, in chunks that end anywhere.
LARGE = {
    "latlong": 530,
    "cube": 520,
    "cube:filament": 524,
    "angular": 610,
    "dual_paraboloid": 530,
    "perspective(fov=70)": 540,
}


@pytest.fixture(autouse=True)
def in_this_thread():
    with dask.config.set(scheduler="synchronous"):
        yield


def texels(projection, size, channels=(), dtype=np.float32):
    shape = (*sm.projection(projection).shape(size), *channels)
    if np.dtype(dtype).kind in "iu":
        return rng.integers(0, 200, shape, dtype)
    return rng.random(shape).astype(dtype)


def check(image, chunks, whole, of_chunks, *args, **options):
    """Assert that a sum over an image in chunks is that over the image."""
    expected = whole(image, *args, **options)
    lazy = of_chunks(da.from_array(image, chunks=chunks), *args, **options)
    assert lazy.shape == expected.shape and lazy.dtype == expected.dtype
    found = lazy.compute()
    assert np.asarray(found).dtype == expected.dtype
    np.testing.assert_array_equal(found, expected)
    return lazy


@pytest.mark.parametrize(("projection", "size"), LARGE.items())
@some_fast("channels", [(), (2,)], fast=((2,),))
def test_integrals_have_the_bits_of_the_whole(projection, size, channels):
    image = texels(projection, size, channels)
    for verb in ("integrate", "mean", "average_direction"):
        check(image, 190, getattr(sm.light, verb), getattr(smd.light, verb), projection)


@pytest.mark.parametrize(("projection", "size"), LARGE.items())
@some_fast("kind", ["means", "points"], fast=("means",))
def test_coefficients_have_the_bits_of_the_whole(projection, size, kind):
    image = texels(projection, size, (4,) if kind == "means" else ())
    options = {"order": 3, "texels": kind, "rotation": sm.rotation(20, 10)}
    check(image, 300, sm.sh.project, smd.sh.project, projection, **options)


@pytest.mark.parametrize(("projection", "size"), LARGE.items())
@some_fast("method", ["exact", "sh"], fast=("sh",))
def test_irradiance_has_the_bits_of_the_whole(projection, size, method):
    image = texels(projection, size, (3,), np.uint8 if projection == "cube" else np.float32)
    options = {"size": 3, "method": method, "order": 2}
    check(image, 300, sm.light.irradiance, smd.light.irradiance, projection, "angular", **options)


def with_sun(p, size, channels=()):
    """Return a dim image with a bright square."""
    image = rng.random((*p.shape(size), *channels)).astype(np.float32)
    shape = p.shape(size)
    toward = sm.projection("latlong").in_world_of(p).decode([0.53, 0.48])
    column, row, *face = p.directions_to_pixels(toward, shape).astype(int)
    square = slice(row - 2, row + 3), slice(column - 3, column + 2)
    image[(*face, *square)] = 90 + 10 * image[(*face, *square)]
    # Two of the largest luminance, of which the first is the peak.
    image[(*face, row, column)] = image[(*face, row + 1, column - 1)] = 900
    image[(*face, row + 9, column)] = -1
    return image


def assert_same_energy(found, whole):
    assert (found.sun is None) == (whole.sun is None)
    for name in ("solid_angle", "luminance", "peak", "darkest", "negative", "dynamic_range"):
        assert getattr(found, name) == getattr(whole, name), name
    for name in ("integral", "mean", "peak_direction"):
        np.testing.assert_array_equal(getattr(found, name), getattr(whole, name))
    for name in ("direction", "irradiance", "solid_angle", "surround") if whole.sun else ():
        np.testing.assert_array_equal(getattr(found.sun, name), getattr(whole.sun, name))


@pytest.mark.parametrize(("projection", "size"), [*LARGE.items(), ("latlong:blender", 80)])
@pytest.mark.parametrize("channels", [(), (3,)])
def test_energy_is_that_of_the_whole(projection, size, channels):
    p = sm.projection(projection)
    image = with_sun(p, size, channels)
    whole = sm.light.energy(image, p)
    assert whole.sun is not None and whole.negative == 1
    # What makes luminance of three channels sums to 1 within rounding.
    assert whole.peak == pytest.approx(900, rel=1e-12)
    assert_same_energy(smd.light.energy(da.from_array(image, chunks=200), p), whole)


def test_energy_of_what_is_no_sky():
    image = texels("angular", 600, (2,))
    options = {"luminance": (0.0, 2.0), "rotation": sm.rotation(9, 8, 7)}
    whole = sm.light.energy(image, "angular", **options)
    chunks = da.from_array(image, chunks=(600, 77, 1))
    assert_same_energy(smd.light.energy(chunks, "angular", **options), whole)
    image[300, 300] = np.nan
    whole = sm.light.energy(image, "angular", skipna=True, **options)
    chunks = da.from_array(image, chunks=256)
    assert_same_energy(smd.light.energy(chunks, "angular", skipna=True, **options), whole)
    with pytest.raises(ValueError, match=r"1 NaN or infinite value, at \(300, 300, 0\)|2 NaN"):
        smd.light.energy(chunks, "angular", **options)
    with pytest.raises(ValueError, match="`luminance` must say"):
        smd.light.energy(chunks, "angular")


def test_a_sun_is_looked_for_in_few_chunks():
    image = with_sun(sm.projection("latlong"), 2048)
    times = Counter()

    def made(part, block_info=None):
        times[tuple(block_info[0]["chunk-location"])] += 1
        return part

    held = da.from_array(image, chunks=512)
    smd.light.energy(da.map_blocks(made, held, dtype=held.dtype, meta=held._meta), "latlong")
    assert set(times) == {(j, i) for j in range(4) for i in range(8)}
    # Of 32 chunks those that hold what is within 20 degrees of it, and some of their neighbors.
    assert 2 <= sum(n > 1 for n in times.values()) <= 12


@pytest.mark.parametrize("projection", ["latlong", "cube", "mollweide"])
def test_small_images_as_well(projection):
    image = texels(projection, 21, (3,))
    for verb in ("integrate", "mean", "average_direction"):
        check(image, 10, getattr(sm.light, verb), getattr(smd.light, verb), projection)
    check(image, 10, sm.sh.project, smd.sh.project, projection, order=2)
    check(image, 10, sm.light.irradiance, smd.light.irradiance, projection, "cube", size=2)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float64, ">f4"])
def test_dtypes(dtype):
    image = texels("octahedral", 530).astype(dtype)
    check(image, 300, sm.light.integrate, smd.light.integrate, "octahedral")


def test_no_chunks_change_a_bit():
    image = texels("latlong", 540, (3,))
    found = {
        smd.light.integrate(da.from_array(image, chunks=chunks), "latlong").compute().tobytes()
        for chunks in [100, 512, -1, (540, 7, 1), ((500, 40), (1000, 80), 3)]
    }
    assert found == {sm.light.integrate(image, "latlong").tobytes()}


@pytest.mark.parametrize("size", [40, 530])
def test_holes_count_as_nothing(size):
    image = texels("latlong", size, (2,))
    image[3:9, 5:17] = np.nan
    image[-1, -1, 1] = np.inf
    for verb in ("integrate", "mean", "average_direction"):
        whole, parts = getattr(sm.light, verb), getattr(smd.light, verb)
        check(image, 170, whole, parts, "latlong", skipna=True)
    check(image, 170, sm.sh.project, smd.sh.project, "latlong", order=1, skipna=True)
    with pytest.raises(ValueError, match=r"(145|144|1) NaN or infinite"):
        smd.light.integrate(da.from_array(image, chunks=-1), "latlong").compute()


@pytest.mark.parametrize("size", [40, 530])
def test_masks_are_holes(size):
    image = np.ma.masked_greater(texels("latlong", size, (2,)), 0.75)
    for verb in ("integrate", "mean", "average_direction"):
        whole, parts = getattr(sm.light, verb), getattr(smd.light, verb)
        # Chunks of single channels are put together, masks and all.
        check(image, (170, 170, 1), whole, parts, "latlong", skipna=True)
    check(image, 170, sm.sh.project, smd.sh.project, "latlong", order=1, skipna=True)
    whole = sm.light.energy(image, "latlong", luminance=(0.0, 1.0), skipna=True)
    chunks = da.from_array(image, chunks=170)
    options = {"luminance": (0.0, 1.0), "skipna": True}
    assert_same_energy(smd.light.energy(chunks, "latlong", **options), whole)
    with pytest.raises(ValueError, match="NaN or infinite"):
        smd.light.mean(chunks, "latlong").compute()
    whole = da.from_array((image * 99).astype(np.uint8), chunks=170)
    with pytest.raises(TypeError, match="masked"):
        smd.light.mean(whole, "latlong", skipna=True).compute()


def test_a_value_that_is_none_is_named_by_its_place_in_the_whole():
    image = texels("latlong", 540)
    image[533, 1011] = np.nan
    with pytest.raises(ValueError, match=r"at \(533, 1011\)"):
        smd.light.mean(da.from_array(image, chunks=99), "latlong").compute()


def test_numbers_below_zero():
    image = texels("cube", 520) - 0.25
    check(image, 300, sm.light.integrate, smd.light.integrate, "cube", negative="clip")
    with pytest.raises(ValueError, match="negative"):
        smd.light.integrate(da.from_array(image, chunks=300), "cube", negative="raise").compute()


def test_no_chunk_is_made_twice():
    times = Counter()

    def made(part, block_info=None):
        times[tuple(block_info[0]["chunk-location"])] += 1
        return part

    held = da.from_array(texels("latlong", 600), chunks=128)
    image = da.map_blocks(made, held, dtype=held.dtype, meta=held._meta)
    total = smd.light.integrate(image, "latlong")
    assert not times
    total.compute()
    assert set(times.values()) == {1} and len(times) == image.npartitions


def test_an_image_that_no_memory_holds_is_no_more_than_a_graph():
    image = da.ones((65_536, 131_072, 3), chunks=4096, dtype=np.float32)
    total = smd.light.integrate(image, "latlong")
    assert total.shape == (3,)
    # A task a sheet, and the last; each of them small.
    parts = [layer for name, layer in total.dask.layers.items() if "sheets" in name]
    assert [len(layer) for layer in parts] == [128 * 256]
    assert len(pickle.dumps(next(iter(parts[0].values())))) < 4096


def test_names_are_those_of_what_is_made():
    image = da.from_array(texels("latlong", 16), chunks=8)
    assert smd.light.mean(image, "latlong").name == smd.light.mean(image, "latlong").name
    others = [
        smd.light.mean(image, "latlong", negative="clip"),
        smd.light.integrate(image, "latlong"),
        smd.light.mean(image, "lambert_cylindrical", any_aspect=True),
        smd.sh.project(image, "latlong", order=1),
        smd.sh.project(image, "latlong", order=2),
    ]
    assert len({smd.light.mean(image, "latlong").name, *(a.name for a in others)}) == 6


@pytest.mark.parametrize(
    ("verb", "image", "options", "error", "said"),
    [
        ("integrate", np.ones((8, 16)), {}, TypeError, "from_array"),
        ("integrate", da.ones((8, 9)), {}, ValueError, "twice as wide"),
        ("integrate", da.ones((5, 8, 16, 3)), {}, ValueError, "one by one"),
        ("integrate", da.ones((8, 16), dtype=complex), {}, TypeError, "complex"),
        ("integrate", da.ones((8, 16)), {"negative": "drop"}, ValueError, "negative"),
        ("mean", da.ones((8, 16)), {"skipna": 1}, TypeError, "skipna"),
        ("mean", da.ones((8, 16, 0)), {}, ValueError, "channel"),
        ("irradiance", da.ones((8, 16)), {"dst": "cube", "method": "fast"}, ValueError, "method"),
        ("irradiance", da.ones((8, 16)), {"dst": "cube", "size": -1}, ValueError, "size"),
        ("irradiance", da.ones((8, 16)), {"dst": "cube", "order": "x"}, TypeError, "order"),
        ("irradiance", da.ones((8, 16)), {"dst": "cube", "order": 99}, ValueError, "order"),
    ],
)
def test_errors_come_before_anything_is_computed(verb, image, options, error, said):
    places = [options.pop("dst")] if "dst" in options else []
    with pytest.raises(error, match=said):
        getattr(smd.light, verb)(image, "latlong", *places, **options)


@pytest.mark.parametrize("order", [65, -1, 0.5])
def test_orders_that_there_are_not(order):
    error = TypeError if isinstance(order, float) else ValueError
    with pytest.raises(error, match="order"):
        smd.sh.project(da.ones((8, 16)), "latlong", order=order)
