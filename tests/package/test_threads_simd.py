"""The same bits from every SIMD level and every number of threads; forks; Python threads."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
import threading
import time

import hard_directions
import numpy as np
import pytest
import spheremap as sm
from conftest import DEFAULTS, LAYOUTS, assert_same_bits, each, random_directions, some_fast
from spheremap import _core

LEVELS = _core.simd_levels()


def everything(p: sm.Projection, dtype: type, n: int) -> dict[str, np.ndarray]:
    """Results of every numeric call, over hard inputs and n random ones."""
    d = np.concatenate([hard_directions.hard(dtype)[::4], hard_directions.bad(dtype)])
    d = np.concatenate([d, random_directions(n, 140).astype(dtype)])
    turn = sm.rotation(12, 34, 56)
    uv = p.encode(d)
    rng = np.random.default_rng(141)
    image = rng.random((*p.shape(13), 3)).astype(dtype)
    small = rng.integers(0, 255, (*p.shape(13), 2)).astype(np.uint8)
    return {
        "encode": uv,
        "encode turned": p.encode(d, rotation=turn),
        "decode": p.decode(uv),
        "decode turned": p.decode(uv, rotation=turn),
        "jacobian": p.jacobian(uv[:20_000]),
        "density": p.density(uv),
        "valid": p.valid(uv),
        "covers": p.covers(d),
        "solid_angle": p.solid_angle(33),
        "directions": p.directions(33, dtype=dtype),
        "bilinear": p.sample(image, d),
        "nearest": p.sample(image, d, filter="nearest"),
        "u8": p.sample(small, d),
        "convert": sm.convert(image, p, "octahedral", size=40, rotation=turn),
        "reflect": sm.reflect(d, d[::-1].copy()),
    }


@each(LAYOUTS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_levels_are_bit_equal(case, dtype):
    p = case.make()
    _core.set_simd_level(LEVELS[0])
    assert sm.simd_level() == LEVELS[0]
    want = everything(p, dtype, 3000)
    for level in LEVELS[1:]:
        _core.set_simd_level(level)
        assert sm.simd_level() == level
        for what, value in everything(p, dtype, 3000).items():
            assert_same_bits(value, want[what], f"{what} at {level}")


# Whose directions take longest to be found.
HEAVY = ("camera_thin_prism_fisheye", "camera_rad_tan_thin_prism_fisheye", "mollweide")


@each(DEFAULTS, slow=[c for c in DEFAULTS if c.name in HEAVY])
@some_fast("dtype", [np.float32, np.float64], fast=(np.float32,))
def test_thread_counts_are_bit_equal(case, dtype):
    p = case.make()
    sm.set_num_threads(1)
    n = 1 << 17
    want = everything(p, dtype, n)
    for threads in (2, 3, 5):
        sm.set_num_threads(threads)
        assert sm.get_num_threads() == threads
        for what, value in everything(p, dtype, n).items():
            assert_same_bits(value, want[what], f"{what} with {threads} threads")


def test_large_images_are_bit_equal_over_threads():
    rng = np.random.default_rng(142)
    image = rng.random((256, 512, 3)).astype(np.float32)
    results = []
    for threads in (1, 2, 4):
        sm.set_num_threads(threads)
        results.append(
            (
                sm.convert(image, "latlong", "cube", size=160),
                sm.solid_angle("angular", 700),
                sm.directions("octahedral", 600),
            )
        )
    for other in results[1:]:
        for a, b in zip(results[0], other, strict=True):
            assert_same_bits(a, b)


def test_wrong_levels_and_counts():
    with pytest.raises(ValueError, match="level"):
        _core.set_simd_level("avx3")
    for n in (0, -1):
        with pytest.raises((ValueError, OverflowError)):
            sm.set_num_threads(n)
    with pytest.raises(TypeError):
        sm.set_num_threads("two")


def run(script: str, **env: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(script)],
        env={**os.environ, **env},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_environment_variable_sets_the_count():
    script = "import spheremap as sm; print(sm.get_num_threads())"
    assert run(script, SPHEREMAP_NUM_THREADS="3") == "3"
    assert run(script, SPHEREMAP_NUM_THREADS="1") == "1"


@pytest.mark.parametrize("value", ["zero", "0", "-2", ""])
def test_a_senseless_environment_variable_does_no_harm(value):
    script = """
        import warnings
        import numpy as np
        warnings.simplefilter("ignore")
        import spheremap as sm
        print(sm.encode(np.ones((300_000, 3)), "latlong").shape[0], sm.get_num_threads() >= 1)
    """
    assert run(script, SPHEREMAP_NUM_THREADS=value) == "300000 True"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this platform")
def test_fork_after_threads_were_used():
    # The child gets no threads of its parent; a pool that thinks it has them waits for ever.
    script = """
        import os, warnings
        warnings.simplefilter("ignore")  # newer Pythons warn of forking with threads: the point
        import numpy as np
        import spheremap as sm
        sm.set_num_threads(2)
        d = np.random.default_rng(0).normal(size=(600_000, 3))
        want = sm.encode(d, "latlong")
        for _ in range(3):
            pid = os.fork()
            if pid == 0:
                ok = np.array_equal(sm.encode(d, "latlong"), want)
                image = np.ones((256, 512, 3), np.float32)
                ok &= bool(np.all(sm.convert(image, "latlong", "octahedral", size=700) == 1))
                inner = os.fork()
                if inner == 0:
                    os._exit(0 if np.array_equal(sm.encode(d, "latlong"), want) else 7)
                ok &= os.waitpid(inner, 0)[1] == 0
                os._exit(0 if ok else 9)
            assert os.waitpid(pid, 0)[1] == 0
            assert np.array_equal(sm.encode(d, "latlong"), want)
        print("ok")
    """
    assert run(script) == "ok"


def test_multiprocessing_with_fork():
    if "fork" not in __import__("multiprocessing").get_all_start_methods():
        pytest.skip("no fork on this platform")
    script = """
        import multiprocessing as mp, warnings
        warnings.simplefilter("ignore")
        import numpy as np
        import spheremap as sm
        d = np.random.default_rng(0).normal(size=(300_000, 3))
        want = sm.encode(d, "cube")
        def work(seed):
            return bool(np.array_equal(sm.encode(d, "cube"), want))
        if __name__ == "__main__":
            with mp.get_context("fork").Pool(2) as pool:
                print(all(pool.map(work, range(4))))
    """
    assert run(script) == "True"


def test_python_threads_at_the_same_time():
    d = random_directions(200_000, 143).astype(np.float32)
    want = {name: sm.encode(d, name) for name in sm.projections()}
    failures: list[str] = []
    start = threading.Barrier(4)

    def work(k: int) -> None:
        start.wait()
        names = sm.projections()
        for i in range(8):
            name = names[(i + k) % len(names)]
            if not np.array_equal(sm.encode(d, name), want[name], equal_nan=True):
                failures.append(name)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join(timeout=60)
        assert not t.is_alive()
    assert not failures


def test_changing_the_count_while_others_work():
    d = random_directions(300_000, 144)
    want = sm.encode(d, "octahedral")
    stop = threading.Event()
    failures: list[int] = []

    def work() -> None:
        while not stop.is_set():
            if not np.array_equal(sm.encode(d, "octahedral"), want):
                failures.append(1)

    t = threading.Thread(target=work)
    t.start()
    try:
        for n in (1, 3, 2, 4, 1, 2):
            sm.set_num_threads(n)
            assert np.array_equal(sm.encode(d, "octahedral"), want)
    finally:
        stop.set()
        t.join(timeout=60)
    assert not t.is_alive() and not failures


def test_other_python_threads_run_during_a_long_call():
    # The lock is let go. A thread that naps half a millisecond at a time gets through dozens of
    # naps during each call; if the call kept the lock it would get one or two around each.
    sm.set_num_threads(1)
    d = random_directions(3_000_000, 145)
    out = np.empty((len(d), 2))
    naps = [0]
    stop = threading.Event()

    def nap() -> None:
        while not stop.is_set():
            time.sleep(0.0005)
            naps[0] += 1

    t = threading.Thread(target=nap)
    t.start()
    try:
        before = naps[0]
        for _ in range(3):
            sm.encode(d, "latlong", out=out)
        during = naps[0] - before
    finally:
        stop.set()
        t.join(timeout=60)
    assert during >= 12


@pytest.mark.parametrize("count", [True, 2.0, "2", None])
def test_a_count_of_threads_is_a_whole_number(count):
    with pytest.raises(TypeError, match="Expected `n` to be a whole number"):
        sm.set_num_threads(count)
