"""CUDA C++ by NVRTC, which needs no graphics card to compile; a driver runs what it made."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from . import need

# Where the oldest card that NVRTC 13 compiles for runs, newer ones do.
OPTIONS = [b"--gpu-architecture=compute_75", b"-fmad=false", b"--std=c++17"]


def _done(answer: tuple[Any, ...]) -> Any:
    code, *rest = answer
    if int(code):
        raise RuntimeError(str(code))
    return rest[0] if rest else None


def _room(size: int) -> bytes:
    """Return bytes that NVRTC writes into.

    One more than it asks for: of one byte, as an empty log is, Python has a single object for all
    who ask, and a NUL in it would be everyone's.
    """
    return b" " * (size + 1)


def compiled(text: str) -> str:
    """Return the PTX of a source, which must compile without a word."""
    need("cuda.bindings.nvrtc")
    from cuda.bindings import nvrtc

    program = _done(nvrtc.nvrtcCreateProgram(text.encode(), b"printed.cu", 0, [], []))
    answer = nvrtc.nvrtcCompileProgram(program, len(OPTIONS), OPTIONS)
    log = _room(_done(nvrtc.nvrtcGetProgramLogSize(program)))
    _done(nvrtc.nvrtcGetProgramLog(program, log))
    said = log.decode().strip(" \n\0")
    if said:
        raise RuntimeError(said)
    _done(answer)
    ptx = _room(_done(nvrtc.nvrtcGetPTXSize(program)))
    _done(nvrtc.nvrtcGetPTX(program, ptx))
    _done(nvrtc.nvrtcDestroyProgram(program))
    return ptx.decode().rstrip(" \0")


@cache
def _driver() -> Any:
    """Return the driver with a context of the first card; skip where there is none."""
    need("cuda.bindings.driver")
    from cuda.bindings import driver

    try:
        found = int(driver.cuInit(0)[0]) == 0 and _done(driver.cuDeviceGetCount()) > 0
    except RuntimeError:
        # There is no libcuda to load.
        found = False
    if not found:
        pytest.skip("no CUDA device: the code was compiled to PTX and not run")
    device = _done(driver.cuDeviceGet(0))
    _done(driver.cuCtxSetCurrent(_done(driver.cuDevicePrimaryCtxRetain(device))))
    return driver


def run(ptx: str, kernel: str, rows: np.ndarray, width: int) -> np.ndarray:
    """Return (n, width): what a kernel (given, made, n) makes of rows of numbers."""
    driver = _driver()
    module = _done(driver.cuModuleLoadData(ptx.encode() + b"\0"))
    function = _done(driver.cuModuleGetFunction(module, kernel.encode()))
    made = np.empty((len(rows), width), rows.dtype)
    source, target = (_done(driver.cuMemAlloc(array.nbytes)) for array in (rows, made))
    _done(driver.cuMemcpyHtoD(source, rows.ctypes.data, rows.nbytes))
    values = [np.array([x], np.uint64) for x in (int(source), int(target), len(rows))]
    pointers = np.array([value.ctypes.data for value in values], np.uint64)
    blocks = -(-len(rows) // 128)
    _done(driver.cuLaunchKernel(function, blocks, 1, 1, 128, 1, 1, 0, 0, pointers.ctypes.data, 0))
    _done(driver.cuMemcpyDtoH(made.ctypes.data, target, made.nbytes))
    for memory in (source, target):
        _done(driver.cuMemFree(memory))
    _done(driver.cuModuleUnload(module))
    return made
