"""Who converts the files of a batch: processes of this machine, or those of a cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait

from spheremap.cli.jobs import Failed, Job, Made, convert_job

Outcome = tuple[Job, Made | Failed]
_KILLED = Failed("the worker that had it was killed")


def on_processes(jobs: Sequence[Job], count: int, threads: int) -> Iterator[Outcome]:
    """Yield what becomes of each job, by so many processes of so many threads."""
    # One pool for each process: so it is known whose file a killed one had, and no other waits.
    own = threading.local()
    pools: list[ProcessPoolExecutor] = []

    def pool() -> ProcessPoolExecutor:
        if getattr(own, "pool", None) is None:
            # A fork would copy locks that threads of this process hold.
            context = multiprocessing.get_context("spawn")
            own.pool = ProcessPoolExecutor(1, mp_context=context, initializer=_begin)
            pools.append(own.pool)
        made: ProcessPoolExecutor = own.pool
        return made

    def work(job: Job) -> Made | Failed:
        for _ in range(job.retries + 1):
            try:
                return pool().submit(_interruptible, job, threads).result()
            except BrokenProcessPool:
                own.pool = None
        return _KILLED

    slots = ThreadPoolExecutor(count)
    try:
        futures = {slots.submit(work, job): job for job in jobs}
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        # What has begun is finished, unless Ctrl-C has reached it as well.
        slots.shutdown(cancel_futures=True)
        for each in pools:
            each.shutdown()


def _begin() -> None:
    # Ctrl-C ends a file, and not a process that waits for one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _interruptible(job: Job, threads: int) -> Made | Failed:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return convert_job(job, threads)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def on_cluster(jobs: Sequence[Job], address: str) -> Iterator[Outcome]:
    """Yield what becomes of each job, by the workers of a scheduler of `distributed`."""
    try:
        import distributed
    except ImportError:
        raise ImportError(
            "clusters need distributed: pip install spheremap[dask]", name="distributed"
        ) from None
    with distributed.Client(address) as client:
        futures = client.map(_on_worker, jobs, pure=False)
        given = {future.key: job for future, job in zip(futures, jobs, strict=True)}
        try:
            for future in distributed.as_completed(futures):
                try:
                    yield given[future.key], future.result()
                except distributed.scheduler.KilledWorker:
                    yield given[future.key], _KILLED
        finally:
            client.cancel(futures)


def _on_worker(job: Job) -> Made | Failed:
    import distributed

    return convert_job(job, distributed.get_worker().state.nthreads)
