"""No memory, odd arrays, Ctrl-C: never an abort, a panic or a wait."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory and signals")

# Each verb on an image of 96 MiB, with less room left than it takes.
VERBS = {
    "convert": 'sm.convert(im, "latlong", "cube", size=512)',
    "area": 'sm.convert(im, "latlong", "cube", size=128, filter="area")',
    "trilinear": 'sm.convert(im, "latlong", "cube", size=128, filter="trilinear")',
    "skipna": 'sm.convert(im, "latlong", "cube", size=512, skipna=True)',
    "alpha": 'sm.convert(im, "latlong", "cube", size=512, alpha=2)',
    "sample": 'sm.sample(im, d, "latlong", skipna=True)',
    "sample lod": 'sm.sample(im, d, "latlong", lod=1.5)',
    "sample_uv": "sm.sample_uv(im, d[:, :2], lod=1.5)",
    "mipmaps": 'sm.mipmaps(im, "latlong")',
    "pad": 'sm.pad(im, "latlong", 16)',
    "integrate": 'sm.light.integrate(im, "latlong")',
    "mean": 'sm.light.mean(im, "latlong", skipna=True)',
    "energy": 'sm.light.energy(im, "latlong", luminance=[1, 1, 1])',
    "sun": 'sm.light.sun(im, "latlong")',
    "remove_sun": 'sm.light.remove_sun(im, "latlong")',
    "lights": 'sm.light.lights(im, "latlong", count=4)',
    "Distribution": 'sm.light.Distribution(im, "latlong")',
    "irradiance": 'sm.light.irradiance(im, "latlong", "cube", size=2)',
    "prefilter": 'sm.light.prefilter(im, "latlong", "cube", size=8, roughness=0.5)',
    "sh": 'sm.sh.project(im.reshape(-1)[: 6 * 768**2].reshape(6, 768, 768), "cube", order=2)',
    "weights": 'sm.light.weights("hammer", 2048)',
    "pack": 'sm.packing.pack(d, "oct32")',
}
LIMITED = """
    import resource
    import numpy as np
    import spheremap as sm

    im = np.ones((2048, 4096, 3), np.float32)
    im[3, 3] = np.nan if {nan} else 2
    d = np.ones((1_000_000, 3), np.float32)
    small = np.ones((64, 128, 3), np.float32)
    # Threads, imports and code come first: their memory is not the call's.
    sm.convert(np.ones((512, 1024), np.float32), "latlong", "cube", size=256)
    sm.light.energy(small, "latlong"), sm.sh.project(small, "latlong", order=1)
    with open("/proc/self/status") as f:
        size = int(next(l for l in f if l.startswith("VmSize")).split()[1]) * 1024
    limit = size + {room} * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    try:
        {call}
        print("works")
    except MemoryError as error:
        print("MemoryError", error)
"""


# One of each module, and of each way to look up.
TYPICAL = (
    "convert",
    "area",
    "trilinear",
    "sample",
    "mipmaps",
    "pad",
    "energy",
    "sun",
    "sh",
    "pack",
)


@some_fast("room", [8, 100], fast=(8,))
@some_fast("verb", VERBS, fast=TYPICAL)
def test_without_memory_a_call_works_or_raises(verb, room):
    call = VERBS[verb]
    code = textwrap.dedent(LIMITED).format(call=call, room=room, nan="skipna" in call)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-500:]
    assert done.stdout.startswith(("works", "MemoryError")), done.stdout


ODD = {
    "more axes than numpy had": np.ones((1,) * 33 + (3,)),
    "forty axes": np.ones((1,) * 40 + (3,)),
    "swapped bytes": np.ones((4, 3), ">f8"),
    "unaligned": np.frombuffer(bytes(8 * 12 + 1), np.uint8)[1:].view(np.float64).reshape(4, 3),
    "backward": np.ones((4, 3))[::-1, ::-1],
    "one number": np.broadcast_to(np.float64(1), (5, 3)),
    "overlapping": np.lib.stride_tricks.as_strided(np.ones(100), (4, 3), (8, 8)),
    "nothing, wide": np.empty((0, 2**40, 3), np.float32),
    "nothing, long": np.empty((2**40, 0, 3), np.float32),
    "nothing, deep": np.empty((0, 3, 2**50), np.uint8),
    "no numbers": np.empty((0, 2**59), np.int64),
    "structured": np.zeros(4, [("a", "f8"), ("b", "f8")]),
    "objects": np.array([[1, 2, "x"]], object),
    "dates": np.zeros((4, 3), "M8[s]"),
    "text": np.array(["a", "b"]),
    "complex": np.ones((4, 3), complex),
    "masked": np.ma.masked_array(np.ones((4, 3)), mask=True),
    "void": np.zeros((4, 3), "V8"),
    "huge": np.full((4, 3), 1e308),
    "integers": np.full((4, 3), 2**64 - 1, np.uint64),
}
CALLS = {
    "encode": lambda a: sm.encode(a, "cube"),
    "decode": lambda a: sm.decode(a, "cube"),
    "jacobian": lambda a: sm.jacobian(a, "cube"),
    "density": lambda a: sm.density(a, "cube"),
    "covers": lambda a: sm.covers(a, "matcap"),
    "sample": lambda a: sm.sample(a, [[0, 0, 1]], "latlong"),
    "sample at": lambda a: sm.sample(np.ones((4, 8)), a, "latlong"),
    "convert": lambda a: sm.convert(a, "sphere", "latlong", size=2, filter="bicubic"),
    "convert alpha": lambda a: sm.convert(a, "sphere", "latlong", size=2, alpha=0, skipna=True),
    "mipmaps": lambda a: sm.mipmaps(a, "sphere"),
    "sample lod": lambda a: sm.sample(np.ones((4, 8)), [[0, 0, 1]], "latlong", lod=a),
    "derivatives": lambda a: sm.sample(np.ones((4, 8)), a, "latlong", derivatives=(a, a)),
    "sample_uv": lambda a: sm.sample_uv(a, [[0.5, 0.5]]),
    "sample_uv lod": lambda a: sm.sample_uv(a, [[0.5, 0.5]], lod=[1, 2]),
    "pad": lambda a: sm.pad(a, "sphere", 1),
    "integrate": lambda a: sm.light.integrate(a, "sphere"),
    "energy": lambda a: sm.light.energy(a, "sphere"),
    "sun": lambda a: sm.light.sun(a, "sphere"),
    "Distribution": lambda a: sm.light.Distribution(a, "sphere"),
    "sh": lambda a: sm.sh.project(a, "sphere", order=0),
    "pack": lambda a: sm.packing.pack(a, "oct32"),
    "unpack": lambda a: sm.packing.unpack(a, "oct32"),
    "unpack_frame": lambda a: sm.packing.unpack_frame(a),
    "vec2pix": lambda a: sm.healpix.vec2pix(4, a),
    "pix2vec": lambda a: sm.healpix.pix2vec(4, a),
    "pix2ang": lambda a: sm.healpix.pix2ang(4, a),
    "ang2pix": lambda a: sm.healpix.ang2pix(4, a, a),
    "reflect": lambda a: sm.reflect(a, a),
    "size": lambda a: sm.solid_angle("latlong", a),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("array", ODD)
def test_odd_arrays_work_or_raise(call, array):
    # A panic is a BaseException, and passes.
    try:
        CALLS[call](ODD[array])
    except (TypeError, ValueError, MemoryError) as error:
        assert len(str(error)) > 10


STOPPED = """
    import signal, sys, time
    import numpy as np
    import spheremap as sm

    # A job in the background inherits that it is ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)

    im = np.ones((1024, 2048, 3), np.float32)
    sm.set_num_threads({threads})
    sm.convert(im, "latlong", "cube", size=64)
    print("ready", flush=True)
    try:
        {call}
        print("done", flush=True)
    except KeyboardInterrupt:
        print("stopped", flush=True)
    # The pool and the caches are as they were.
    assert abs(sm.light.integrate(im, "latlong")[0] / (4 * np.pi) - 1) < 1e-12
    assert (sm.convert(im, "latlong", "cube", size=64) == 1).all()
    print("works", flush=True)
"""
LONG = {
    "area": 'sm.convert(im, "latlong", "hammer", size=3000, filter="area", rotation=np.eye(3))',
    "lanczos": '[sm.convert(im, "latlong", "cube", size=4096, filter="lanczos3")]',
    "irradiance": 'sm.light.irradiance(im, "latlong", "cube", size=128)',
    "derivatives": 'sm.sample(im, np.ones((9_000_000, 3)), "latlong", derivatives=np.eye(3)[:2])',
    "solid angles": 'sm.solid_angle("sinusoidal", 8000)',
    "integrate": '[sm.light.integrate(np.ones((n, 2 * n)), "latlong") for n in range(2000, 2100)]',
}


@some_fast("threads", [1, 2], fast=(2,))
@some_fast("call", LONG, fast=("irradiance", "lanczos", "integrate"))
def test_ctrl_c_stops_a_call(call, threads):
    code = textwrap.dedent(STOPPED).format(call=LONG[call], threads=threads)
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(0.4)
    start = time.perf_counter()
    os.kill(process.pid, signal.SIGINT)
    answer = process.stdout.readline()
    waited = time.perf_counter() - start
    out, err = process.communicate(timeout=60)
    assert answer == "stopped\n", (answer, err[-500:])
    assert out == "works\n", err[-500:]
    # Half a second is what is promised of an idle machine; this one may be busy.
    assert waited < 5


@pytest.mark.parametrize("seconds", [0.01, 0.1])
def test_a_handler_of_signals_may_raise_what_it_likes(seconds):
    """Also before the call has asked for the first time, which it does after 50 ms."""

    class TimeIsUp(Exception):
        pass

    def handler(*_):
        raise TimeIsUp

    image = np.ones((512, 1024), np.uint8)
    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds)
        with pytest.raises(TimeIsUp):
            # Seconds on any machine.
            sm.convert(
                image,
                "latlong",
                "hammer",
                size=8000,
                filter="area",
                rotation=sm.rotation(30, 20, 10),
            )
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_threads_are_never_more_than_four_a_core():
    before, cores = sm.get_num_threads(), len(os.sched_getaffinity(0))
    try:
        sm.set_num_threads(4096)
        assert sm.get_num_threads() <= 4 * max(cores, os.cpu_count() or 1)
    finally:
        sm.set_num_threads(before)
    code = "import spheremap as sm; print(sm.get_num_threads())"
    environment = {**os.environ, "SPHEREMAP_NUM_THREADS": "99999999"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert int(done.stdout) <= 4 * (os.cpu_count() or 1)


HUGE = {
    "canonical": lambda: sm.packing.canonical(np.broadcast_to(np.int64(1), 2**40), "oct32"),
    "unpack": lambda: sm.packing.unpack(np.broadcast_to(np.int64(1), 2**40), "sphere12"),
    "as many as addresses": lambda: sm.packing.unpack(
        np.broadcast_to(np.uint8(1), (2**31, 2**31)), "oct32"
    ),
    "pad": lambda: sm.pad(np.ones((2, 4)), "latlong", 2**31 - 1),
    "image": lambda: sm.light.integrate(np.broadcast_to(np.uint8(1), (2**31, 2**30)), "latlong"),
    "coefficients": lambda: sm.sh.evaluate(np.broadcast_to(np.float32(1), 2**40), [0, 0, 1]),
    "matcap": lambda: sm.light.shade_matcap(np.empty((2**40, 0, 3)), np.ones((4, 4))),
    "step": lambda: sm.healpix.boundaries(4, 0, step=2**62),
}


@pytest.mark.parametrize("call", HUGE)
def test_what_no_memory_holds_is_refused_before_it_is_read(call):
    with pytest.raises((MemoryError, ValueError)):
        HUGE[call]()


def test_a_disk_in_a_narrow_image_is_weighed_at_once():
    # Owners of texels across the rim were looked for far beyond the image.
    weights = sm.light.weights("stereographic", (2, 2**12), any_aspect=True)
    # A sum of 8192 roundings.
    assert abs(weights.sum() / sm.projection("stereographic").covered_solid_angle - 1) < 1e-9


def test_energy_of_an_image_whose_texels_see_no_sphere():
    # The four corners around a disk: a panic, before.
    energy = sm.light.energy(np.zeros((2, 2)), sm.projection("matcap", grid="corners"))
    assert energy.sun is None and energy.luminance == 0
