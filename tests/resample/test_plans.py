"""Plans: the same bits as convert, batches, pickles, maps for other programs, huge sources."""

from __future__ import annotations

import pickle
import subprocess
import sys
import textwrap

import cv2
import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import GRIDS, LAYOUTS, each

TURN = sm.rotation(30, 20, 10)


@each(LAYOUTS)
def test_a_plan_is_convert_to_the_bit(case):
    p = case.make()
    rng = np.random.default_rng(200)
    image = rng.random((*p.shape(9), 3)).astype(np.float32)
    plan = sm.remap_plan(p, "octahedral", size=12, rotation=TURN, fill=0.25)
    want = sm.convert(image, p, "octahedral", size=12, rotation=TURN, fill=0.25)
    assert np.array_equal(plan(image), want)
    out = np.empty_like(want)
    assert plan(image, out=out) is out and np.array_equal(out, want)
    batch = rng.random((3, *p.shape(9), 3)).astype(np.float32)
    got = plan(batch)
    assert got.shape == (3, *plan.shape, 3)
    for one, converted in zip(batch, got, strict=True):
        assert np.array_equal(converted, plan(one))
    into = np.empty_like(got)
    assert plan(batch, out=into) is into and np.array_equal(into, got)
    assert plan(batch[:0]).shape == (0, *plan.shape, 3)


def test_batches_of_faces_go_out_as_faces():
    rng = np.random.default_rng(201)
    batch = rng.integers(0, 255, (2, 6, 8, 8, 3), np.uint8)
    plan = sm.remap_plan("cube", "dual_paraboloid", size=10)
    got = plan(batch)
    assert got.dtype == np.uint8 and got.shape == (2, 2, 10, 10, 3)
    assert np.array_equal(got[1], sm.convert(batch[1], "cube", "dual_paraboloid", size=10))


@pytest.mark.parametrize("alpha", [5, -6])
def test_any_channel_may_be_the_opacity(alpha):
    image = np.random.default_rng(6).random((8, 16, 6))
    plan = sm.remap_plan("latlong", "cube", size=4, alpha=alpha)
    assert np.array_equal(plan(image), sm.convert(image, "latlong", "cube", size=4, alpha=alpha))


def test_plans_are_values():
    plan = sm.remap_plan("latlong", "cube", size=8, rotation=TURN, fill=[0, 1, 2])
    again = pickle.loads(pickle.dumps(plan))
    assert again == plan and hash(again) == hash(plan) and len({plan, again}) == 1
    image = np.random.default_rng(202).random((16, 32, 3))
    assert np.array_equal(plan(image), again(image))
    with pytest.raises(AttributeError):
        plan.shape = (1, 1)
    assert plan != sm.remap_plan("latlong", "cube", size=8)


def test_plans_are_equal_by_what_they_do():
    def plan(**options):
        return sm.remap_plan("latlong", "octahedral", size=8, **options)

    assert plan(fill=1.0, filter="area") == plan(filter="area", fill=1)
    assert plan(filter="bilinear", fill=0, antialias=True, window=None) == plan()
    assert plan().options == () and plan() != plan(antialias=False)
    for fill in (np.nan, np.array(np.nan), np.float32(np.nan), [np.nan, 1]):
        some = plan(fill=fill)
        again = pickle.loads(pickle.dumps(some))
        assert again == some == plan(fill=fill) and hash(again) == hash(some)
    window = plan(window=(slice(0, 2), slice(1, None)))
    assert hash(window) == hash(plan(window=(slice(0, 2), slice(1, None)))) and window != plan()
    assert window(np.zeros((4, 8))).shape == (2, 7)
    # 0 says what False does, and is none.
    with pytest.raises(TypeError, match="any_aspect"):
        plan(any_aspect=0)


def test_the_source_gives_the_size_and_is_held_to():
    plan = sm.remap_plan("latlong", "cube", source_shape=(64, 128))
    image = np.zeros((64, 128, 3), np.float32)
    assert plan(image).shape == sm.convert(image, "latlong", "cube").shape
    with pytest.raises(ValueError, match=r"shape \(64, 128\).*got \(32, 64, 3\)"):
        plan(np.zeros((32, 64, 3)))


def test_bad_plans_are_refused_at_once():
    with pytest.raises(TypeError, match="source_shape"):
        sm.remap_plan("latlong", "cube")
    with pytest.raises(ValueError, match="filter"):
        sm.remap_plan("latlong", "cube", size=4, filter="bilinaer")
    with pytest.raises(TypeError, match="blur"):
        sm.remap_plan("latlong", "cube", size=4, blur=3)
    with pytest.raises(TypeError, match="out"):
        sm.remap_plan("latlong", "cube", size=4, out=np.zeros(3))
    with pytest.raises(ValueError, match="rotation"):
        sm.remap_plan("latlong", "cube", size=4, rotation=np.ones((3, 3)))
    with pytest.raises(ValueError, match="alpha"):
        sm.remap_plan("latlong", "cube", size=4, alpha=4, fill=[0, 0, 0])
    plan = sm.remap_plan("latlong", "octahedral", size=4)
    with pytest.raises(ValueError, match="out"):
        plan(np.zeros((2, 4, 8, 3)), out=np.zeros((2, 4, 4, 4)))
    with pytest.raises(ValueError, match="shape"):
        plan(np.zeros(3))
    with pytest.raises(ValueError, match="source"):
        plan.maps()
    with pytest.raises(TypeError, match="dtype"):
        plan.maps((4, 8), dtype=np.float16)


@each(LAYOUTS)
@pytest.mark.parametrize("grid", GRIDS)
def test_maps_are_places_in_the_source(case, grid):
    p = case.make(grid=grid)
    shape = p.shape(12)
    plan = sm.remap_plan(p, p, size=shape, source_shape=shape)
    maps = plan.maps(dtype=np.float64)
    assert len(maps) == (3 if p.faces > 1 else 2)
    # A map to itself is the identity: column and row of every texel.
    d = p.directions(shape)
    ok = ~np.isnan(d[..., 0])
    want = np.indices(shape)[::-1]
    for got, index in zip(maps, want, strict=True):
        assert got.dtype == np.float64 and got.shape == shape
        away = np.abs(got - index)[ok]
        # A texel on an edge, a pole or a face's border lies at another one just as well, texels
        # away. All others only round, by far less than 1e-6 of a texel.
        assert np.mean(away > 1e-6) < (0.01 if grid == "centers" else 0.6)
    again = plan.maps()
    assert all(m.dtype == np.float32 for m in again)
    back = sm.remap_plan(p, "latlong", size=8, source_shape=shape).maps(dtype=np.float64)
    seen = ~np.isnan(back[0])
    assert np.array_equal(seen, p.covers(sm.directions("latlong", 8)))
    assert back[0][seen].min() >= -0.5 and back[0][seen].max() <= shape[-1] - 0.5


def test_opencv_looks_up_where_maps_say():
    image = reference.smooth_function(sm.directions("latlong", 64)).astype(np.float32)
    view = sm.projection("perspective", fov=80, aspect=1.5)
    plan = sm.remap_plan("latlong", view, size=40, source_shape=(64, 128), rotation=TURN)
    x, y = plan.maps()
    theirs = cv2.remap(image, x, y, cv2.INTER_LINEAR, None, cv2.BORDER_WRAP)
    # OpenCV rounds weights to 1/32 of a texel; a texel of this function changes by 0.15 at most.
    assert np.abs(theirs - plan(image)).max() < 0.15 * 2 / 64
    nearest = sm.remap_plan("latlong", view, size=40, rotation=TURN, filter="nearest")
    theirs = cv2.remap(image, x, y, cv2.INTER_NEAREST, None, cv2.BORDER_WRAP)
    assert np.mean(np.any(theirs != nearest(image), -1)) < 0.01


HUGE = """
import resource, sys
import numpy as np
import spheremap as sm
sm.set_num_threads(2)
path = sys.argv[1]
shape = (32768, 65536)
with open(path, "wb") as f:
    f.truncate(shape[0] * shape[1])
    f.seek(20000 * shape[1] + 50000)
    f.write(b"\\xc8")
image = np.memmap(path, np.uint8, "r", shape=shape)
plan = sm.remap_plan("latlong", "octahedral", size=16, source_shape=shape, **OPTIONS)
uv = np.array([[(50000 + 0.5) / 65536, (20000 + 0.5) / 32768]])
view = sm.projection("perspective", fov=0.02)
z = sm.decode(uv, "latlong")[0]
x = np.cross([0, 1, 0], z); x /= np.linalg.norm(x)
camera = np.stack([x, np.cross(z, x), z], -1) @ np.diag([-1, 1, -1])
small = np.zeros((64, 128), np.uint8)
sm.convert(small, "latlong", "octahedral", size=64)  # threads and imports
close = sm.remap_plan("latlong", view.turned(camera), size=9, **OPTIONS)
status = open("/proc/self/status").read()
held = int(status.split("VmData:")[1].split()[0]) << 10
# Beyond 64 MiB of memory of its own, the process gets none. Pages of the file are the system's.
resource.setrlimit(resource.RLIMIT_DATA, (held + (64 << 20), resource.RLIM_INFINITY))
first, second = plan(image), close(image)
assert first.shape == (16, 16) and second.max() > 0, second
try:
    np.ones(80 << 20, np.uint8)
except MemoryError:
    print("fine")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_DATA counts mappings on Linux alone")
def test_a_huge_source_stays_on_disk(tmp_path):
    # A mean of so many texels would read all 2 GB of them.
    options = "{'filter': 'bilinear', 'antialias': False}"
    script = textwrap.dedent(HUGE).replace("OPTIONS", options)
    command = [sys.executable, "-W", "error", "-c", script, str(tmp_path / "huge.raw")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "fine"


@pytest.mark.parametrize("options", ["cosine", 4, [("filter",)], [(1, "nearest")]])
def test_options_of_a_plan_are_pairs(options):
    p = sm.projection("latlong")
    with pytest.raises(TypeError, match=r"`options` to be .*pairs of a name and a value"):
        sm.RemapPlan(p, p, (4, 8), options=options)
