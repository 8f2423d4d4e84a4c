"""Images in chunks: the bits of the whole, from the chunks that a chunk sees."""

import pickle
import subprocess
import sys
from collections import Counter

import dask
import dask.array as da
import numpy as np
import pytest
import spheremap as sm
import spheremap.dask as smd
from conftest import some_fast
from dask.core import get_dependencies
from spheremap.dask import chains

rng = np.random.default_rng(5)


@pytest.fixture(autouse=True)
def in_this_thread():
    with dask.config.set(scheduler="synchronous"):
        yield


def texels(projection, size, channels=(), dtype=np.float32):
    shape = (*sm.projection(projection).shape(size), *channels)
    if np.dtype(dtype).kind in "iu":
        return rng.integers(0, 100, shape, dtype)
    return rng.random(shape).astype(dtype)


def check(image, chunks, src, dst, *, divided="auto", **options):
    """Assert that an image in chunks becomes what it becomes as a whole; return the result."""
    whole = sm.convert(image, src, dst, **options)
    parts = smd.convert(da.from_array(image, chunks=chunks), src, dst, chunks=divided, **options)
    assert parts.shape == whole.shape and parts.dtype == whole.dtype
    found = parts.compute()
    assert found.dtype == whole.dtype
    np.testing.assert_array_equal(found, whole)
    return parts


@pytest.mark.parametrize(
    ("src", "dst", "size", "divided"),
    [
        ("latlong", "cube", 40, 17),
        ("latlong", "angular", 61, (20, 61)),
        ("latlong:mitsuba", "latlong:blender", 48, 31),
        ("cube", "latlong", 60, (45, 45)),
        ("cube", "cube:filament", 24, "1 KiB"),
        ("angular", "cube", 33, ((2, 4), (33,), (11, 22))),
        ("octahedral", "healpix", 16, 7),
        ("dual_paraboloid", "sphere", 50, 23),
    ],
)
def test_parts_have_the_bits_of_the_whole(src, dst, size, divided):
    image = texels(src, 48)
    options = {"rotation": sm.rotation(30, -20, 10), "fill": -1.0}
    parts = check(image, 19, src, dst, size=size, divided=divided, **options)
    assert parts.npartitions > 2


DIVIDED = [
    ("latlong", "cube", 200, 17, 20),
    ("cube", "latlong", 190, 45, 100),
    ("dual_paraboloid", "latlong", 290, 30, 60),
]


@pytest.mark.parametrize("filter", ["trilinear", "ewa"])
@some_fast(
    ("src", "dst", "size", "divided", "to"),
    [
        ("latlong", "cube", 200, 17, 20),
        ("latlong", "angular", 400, 31, 300),
        ("latlong:cmft", "octahedral", 300, 16, 90),
        ("cube", "latlong", 190, 45, 100),
        ("cube:filament", "latlong", 160, 50, 200),
        ("angular", "cube", 500, 20, 100),
        ("sinusoidal", "angular", 300, 40, 140),
        ("dual_paraboloid", "latlong", 290, 30, 60),
    ],
    fast=DIVIDED,
)
def test_filters_that_look_a_mip_chain_up(monkeypatch, src, dst, size, divided, to, filter):
    monkeypatch.setattr(chains, "_LEAST", 16)
    image = texels(src, size, (2,))
    options = {"rotation": sm.rotation(30, -20, 10), "filter": filter, "size": to}
    check(image, 40, src, dst, divided=divided, **options)


@pytest.mark.parametrize(
    "options",
    [
        {"skipna": True},
        {"alpha": 1},
        {"alpha": -1, "skipna": True, "fill": 3.0},
        {"world": "literal"},
    ],
    ids=str,
)
def test_the_chain_is_that_of_weighed_texels(monkeypatch, options):
    monkeypatch.setattr(chains, "_LEAST", 16)
    image = texels("latlong", 100, (2,))
    image[30:60, 50:90] = np.nan
    image[20, 40, 1] = np.inf
    for channels in (image, image[..., 0], image.astype(np.float16)):
        if channels.ndim == 2 and "alpha" in options:
            continue
        check(channels, 37, "latlong", "cube:unreal", size=16, divided=6, filter="ewa", **options)


@pytest.mark.parametrize("filter", ["bilinear", "mode", "area", "trilinear", "ewa"])
def test_masks_are_nan(monkeypatch, filter):
    monkeypatch.setattr(chains, "_LEAST", 16)
    image = np.ma.masked_greater(texels("latlong", 60, (2,)), 0.9)
    for skipna in (False, True) if filter != "mode" else (False,):
        options = {"size": 16, "divided": 9, "filter": filter, "skipna": skipna}
        check(image, (37, 37, 1), "latlong", "cube", **options)
    labels = da.from_array((image * 99).astype(np.uint8), chunks=37)
    with pytest.raises(TypeError, match="masked"):
        smd.convert(labels, "latlong", "cube", size=16, filter=filter).compute()


def test_lookups_in_a_chain_see_a_few_chunks_of_the_image():
    image = da.from_array(texels("latlong", 1600), chunks=200)
    options = {"size": 32, "filter": "ewa"}
    seen = smd.convert(image, "latlong", "perspective(fov=20)", **options)
    (task, wanted), *rest = dict(seen.__dask_graph__().layers[seen.name]).values()
    assert not rest
    # Also as a worker gets it.
    task = pickle.loads(pickle.dumps(task))
    assert 0 < len(wanted[0]) < 32 and [len(few) for few in task.chunks] == list(map(len, wanted))
    whole = sm.convert(image.compute(), "latlong", "perspective(fov=20)", **options)
    np.testing.assert_array_equal(seen.compute(), whole)


@pytest.mark.parametrize(
    "options",
    [
        {"filter": "nearest"},
        {"filter": "lanczos3"},
        {"filter": "catmull-rom", "antialias": False},
        {"filter": "area"},
        {"filter": "mode"},
        {"alpha": -1, "fill": (1, 2, 3, 4)},
        {"world": "literal"},
    ],
    ids=str,
)
def test_options_mean_what_they_mean_for_the_whole(options):
    image = texels("latlong", 24, (4,))
    check(image, (13, 48, 3), "latlong", "cube:unreal", size=8, divided=5, **options)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float64, ">f4"])
def test_dtypes_stay(dtype):
    check(texels("latlong", 30, (2,)).astype(dtype), 11, "latlong", "angular", size=30, divided=8)


@pytest.mark.parametrize("dtype", [np.int8, np.uint32, np.int64, bool])
@pytest.mark.parametrize("filter", ["nearest", "mode"])
def test_labels_stay(dtype, filter):
    labels = (texels("latlong", 16, dtype=np.int64) - 50).astype(dtype)
    check(labels, 7, "latlong", "angular(fov=300)", size=9, divided=5, filter=filter, fill=1)


@pytest.mark.parametrize("filter", ["bilinear", "lanczos3", "area"])
def test_holes_have_no_weight_where_they_are_seen_and_where_not(filter):
    image = texels("latlong", 24, (2,))
    image[3:6, 5:9] = np.nan
    image[20, 40, 1] = np.inf
    check(image, 9, "latlong", "cube", size=10, divided=6, filter=filter, skipna=True)


def test_weighed_sources_that_no_memory_holds():
    image = da.ones((20_000, 40_000, 4), chunks=(500, 500, 4), dtype=np.float32)
    image = da.where(da.arange(40_000, chunks=500)[:, None] % 1000 == 0, np.float32(np.nan), image)
    options = {"size": 32, "skipna": True, "alpha": 3}
    seen = smd.convert(image, "latlong", "perspective(fov=1)", **options).compute()
    assert (seen == 1).all()


@pytest.mark.parametrize(("src", "dst"), [("latlong", "cube"), ("cube", "angular")])
def test_batches_and_channels_first(src, dst):
    batch = np.stack([texels(src, 24, (3,)) for _ in range(2)])
    options = {"size": 10, "filter": "lanczos3"}
    check(batch, 9, src, dst, divided=7, **options)
    first = np.moveaxis(batch, -1, -3)
    check(first, 9, src, dst, divided=7, channels_first=True, **options)
    check(first[0], 9, src, dst, divided=7, channels_first=True, **options)


def test_chunks_of_one_texel():
    check(texels("latlong", 6), 1, "latlong", "cube", size=3, divided=1)


def test_an_image_in_one_chunk_and_a_stretched_one():
    check(texels("latlong", 16), -1, "latlong", "cube", size=8, divided=-1)
    check(rng.random((20, 20)), 7, "latlong", "angular", divided=9, any_aspect=True)


def test_the_default_size_is_that_of_the_whole():
    assert check(texels("angular", 64), 20, "angular", "latlong").chunks == ((40,), (80,))


def counted(image, chunks):
    """Return an image in chunks, and how often each was made."""
    times = Counter()

    def made(part, block_info=None):
        times[tuple(block_info[0]["chunk-location"])] += 1
        return part

    held = da.from_array(image, chunks=chunks)
    return da.map_blocks(made, held, dtype=image.dtype, meta=held._meta), times


def test_a_chunk_is_made_from_the_few_that_it_sees():
    image, times = counted(texels("latlong", 512), 64)
    cube = smd.convert(image, "latlong", "cube", size=256, chunks=64)
    assert not times
    cube[5, 64:128, 64:128].compute()
    assert len(times) < image.npartitions / 10
    dependencies = [
        len(get_dependencies(cube.dask, key) if isinstance(task, tuple) else task.dependencies)
        for key, task in cube.dask.layers[cube.name].items()
    ]
    assert len(dependencies) == cube.npartitions
    # A pole is seen by the chunks around it, and its row has 16 chunks.
    assert np.median(dependencies) < 12


def test_a_task_takes_what_it_sees_of_a_chunk():
    """One number of chunks, as one types it, has all faces in each."""
    image = texels("cube", 512)
    parts = check(image, 512, "cube", "latlong", size=512, divided=128)
    tasks = parts.__dask_graph__().layers[parts.name].values()
    taken = [sum(image[piece.inner].size for piece in part.pieces) for part, _ in tasks]
    # An eighth of the rows and of the columns is a 64th of the texels; about a pole it is more.
    assert max(taken) < image.size / 4 and sum(taken) < len(taken) * image.size / 8


def test_no_chunk_is_made_twice():
    image, times = counted(texels("latlong", 64), 16)
    smd.convert(image, "latlong", "cube", size=32, chunks=8).compute()
    assert set(times.values()) == {1} and len(times) == image.npartitions


def test_names_are_those_of_what_is_made():
    image = da.from_array(texels("latlong", 16), chunks=8)
    same = [smd.convert(image, "latlong", "cube", size=8, fill=1.0).name for _ in range(2)]
    assert same[0] == same[1]
    assert smd.convert(image, "latlong", "cube", size=8, fill=2.0).name != same[0]
    assert smd.convert(image, "latlong", "cube", size=8, fill=1.0, chunks=4).name != same[0]
    turned = smd.convert(image, "latlong", "cube", size=8, fill=1.0, rotation=sm.rotation(9))
    assert turned.name != same[0]


def test_a_source_that_no_memory_holds():
    image = da.ones((200_000, 400_000), chunks=4000, dtype=np.float32)
    cube = smd.convert(image, "latlong", "cube", size=100_000, chunks=50_000)
    assert cube.npartitions == 24
    assert (smd.convert(image, "latlong", "perspective(fov=1)", size=32).compute() == 1).all()


def test_threads_make_the_same():
    image = texels("latlong", 64)
    parts = smd.convert(da.from_array(image, chunks=16), "latlong", "cube", size=32, chunks=8)
    found = parts.compute(scheduler="threads", num_workers=4)
    np.testing.assert_array_equal(found, sm.convert(image, "latlong", "cube", size=32))


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"image": np.zeros((8, 16))}, TypeError, "from_array"),
        ({"image": da.zeros((8, 9))}, ValueError, "twice as wide"),
        ({"image": da.zeros((2, 5, 8, 16, 3))}, ValueError, "2 axes, or 3"),
        ({"image": da.zeros((0, 8, 16, 3))}, ValueError, "at least one"),
        ({"image": da.zeros((8, 16)), "channels_first": True}, ValueError, "before its rows"),
        ({"image": da.zeros((8, 16), dtype=complex)}, TypeError, "complex"),
        ({"image": da.zeros((8, 16), dtype=int)}, TypeError, "labels"),
        ({"filter": "linear"}, ValueError, "linear"),
        ({"alpha": 7}, ValueError, "alpha"),
        ({"world": "mine"}, ValueError, "world"),
        ({"size": -1}, ValueError, "size"),
        ({"chunks": (4, 4)}, ValueError, "chunks"),
        ({"chunks": 0}, ValueError, "`chunks` of at least 1 texel, .*, got 0"),
        ({"chunks": (1, 4, -2)}, ValueError, r"`chunks` of at least 1 texel, .*, got \(1, 4, -2\)"),
        ({"dst": "cubes"}, ValueError, "cube"),
        ({"rotation": np.stack([np.eye(3)] * 2)}, ValueError, "rotation"),
    ],
)
def test_errors_come_before_anything_is_computed(change, error, said):
    given = {"image": da.zeros((8, 16, 3)), "src": "latlong", "dst": "cube", "size": 4} | change
    with pytest.raises(error, match=said):
        smd.convert(given.pop("image"), given.pop("src"), given.pop("dst"), **given)


def test_chunks_of_unknown_sizes_are_an_error():
    image = da.ones((8, 16), chunks=4)
    with pytest.raises(ValueError, match="known sizes"):
        smd.convert(image[image[:, 0] > 0], "latlong", "cube")


def test_dask_is_imported_by_its_own_module_alone():
    everything = (
        "import sys; sys.modules['dask'] = None; import spheremap as sm\n"
        "for name in sm.__all__: getattr(sm, name)\n"
        "try: import spheremap.dask\n"
        "except ImportError as error: print(error.name, error)"
    )
    command = [sys.executable, "-c", everything]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "dask `spheremap.dask` needs dask: pip install spheremap[dask]"
