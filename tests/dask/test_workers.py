"""A cluster: workers in processes of their own, one of which is killed."""

import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm

pytestmark = [
    pytest.mark.slow,
    # Connections to a worker that was killed are closed when they are collected.
    pytest.mark.filterwarnings("ignore"),
]


def test_a_worker_that_is_killed_changes_no_bit():
    distributed = pytest.importorskip("distributed")
    import dask.array as da
    import spheremap.dask as smd

    rng = np.random.default_rng(3)
    image = rng.random((512, 1024, 3)).astype(np.float32)
    whole = sm.convert(image, "latlong", "cube", size=256, filter="lanczos3")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        workers = client.run(os.getpid)
        parts = smd.convert(
            da.from_array(image, chunks=128),
            "latlong",
            "cube",
            size=256,
            chunks=32,
            filter="lanczos3",
        )
        future = client.compute(parts)
        done = client.compute(parts[0, :32, :32])
        done.result(timeout=60)
        os.kill(next(iter(workers.values())), signal.SIGKILL)
        found = future.result(timeout=120)
    np.testing.assert_array_equal(found, whole)


def test_a_worker_that_is_killed_changes_no_bit_of_a_sum():
    distributed = pytest.importorskip("distributed")
    import dask.array as da
    import spheremap.dask as smd

    rng = np.random.default_rng(4)
    image = rng.random((2048, 4096, 3)).astype(np.float32)
    whole = [
        sm.light.integrate(image, "latlong"),
        sm.sh.project(image, "latlong", order=2),
    ]
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        workers = client.run(os.getpid)
        chunks = da.from_array(image, chunks=300)
        sums = [
            smd.light.integrate(chunks, "latlong"),
            smd.sh.project(chunks, "latlong", order=2),
        ]
        futures = client.compute(sums)
        client.compute(chunks[:300, :300].sum()).result(timeout=60)
        os.kill(next(iter(workers.values())), signal.SIGKILL)
        found = [future.result(timeout=120) for future in futures]
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one, other)


LIMIT = 400 << 20


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is Linux's")
def test_workers_keep_within_their_memory():
    """Of a source that is larger than what a worker may hold, each holds a few chunks."""
    distributed = pytest.importorskip("distributed")
    import dask.array as da
    import spheremap.dask as smd

    rows, columns = 8192, 16384
    source = da.ones((rows, columns, 3), chunks=(512, 512, 3), dtype=np.float32)
    assert source.nbytes > 3 * LIMIT
    with (
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            memory_limit=LIMIT,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        cube = smd.convert(source, "latlong", "cube", size=2048, chunks=256, filter="area")
        total = client.compute(cube.sum(dtype=np.float64)).result(timeout=400)
        taken = client.run(_most_memory)
    assert total == 6 * 2048**2 * 3
    assert max(taken.values()) < LIMIT, taken


def _most_memory():
    # The most that `getrusage` tells of a process may be its parent's.
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) << 10
