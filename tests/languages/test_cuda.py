"""Printed CUDA C++: compiled to PTX, and run where there is a card (`make test-languages`)."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
import ran
import spheremap as sm
from oracles import cuda_oracle
from printed import (
    CASES,
    PACKINGS_DOUBLE,
    VERBS,
    Array,
    assert_alike,
    assert_none_of_none,
    assert_packs_alike,
    made,
    roundings,
)

pytestmark = pytest.mark.programs

KERNEL = """
extern "C" __global__ void run_{name}(const {takes}* given, {gives}* made, size_t n) {{
    size_t i = blockIdx.x * (size_t)blockDim.x + threadIdx.x;
    if (i >= n) return;
    {call}
}}
"""
# What rounds otherwise than IEEE 754: contraction, quotients and roots that are near, flushing.
LOOSE = re.compile(r"\b(?:fma|mad|mul|add|sub|div|sqrt|rcp|rsqrt)\.\S*(?:approx|full|ftz)|\bfma\.")


def stores(n: int, name: str = "r", at: int = 0, total: int = 0) -> str:
    """Return what stores a vector among the numbers of a row."""
    total = total or n
    return " ".join(f"made[{total} * i + {at + k}] = {name}.{'xyz'[k]};" for k in range(n))


def vector(number: str, width: int) -> str:
    """Return the vector that a row is."""
    parts = ", ".join(f"given[{width} * i + {k}]" for k in range(width))
    return f"make_{number}{width}({parts})"


WIDTHS = {"decode": 3, "density": 1, "valid": 1, "jacobian": 6}


@cache
def ptx_of(case: str, number: str) -> str:
    """Return every verb of a map, a kernel each."""
    p = made(case)
    width = p.encode(np.zeros(3)).shape[-1]
    dtype = "float32" if number == "float" else "float64"
    place = vector(number, width)
    columns = f"{stores(3, 'r', 0, 6)} {stores(3, 's', 3, 6)}"
    of = {
        "encode": f"{number}{width} r = m_encode({vector(number, 3)}); {stores(width)}",
        "decode": f"{number}3 r = m_decode({place}); {stores(3)}",
        "density": f"made[i] = m_density({place});",
        "valid": f"made[i] = m_valid({place}) ? 1 : 0;",
        "jacobian": f"{number}3 r, s; m_jacobian({place}, &r, &s); {columns}",
    }
    kernels = [KERNEL.format(name=v, call=of[v], takes=number, gives=number) for v in VERBS]
    text = sm.code(p, "cuda", verbs=VERBS, name="m", dtype=dtype)
    return cuda_oracle.compiled(text + "".join(kernels))


NUMBERS = {"float": np.float32, "double": np.float64}


@pytest.mark.runs("nvrtc", language="cuda")
@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("case", CASES)
def test_nvrtc_compiles_every_map_and_rounds_as_written(case: str, number: str) -> None:
    ptx = ptx_of(case, number)
    assert all(f".entry run_{verb}(" in ptx for verb in VERBS)
    assert not LOOSE.findall(ptx)
    ran.note("maps", case, 8 * np.dtype(NUMBERS[number]).itemsize, verbs=VERBS)


@pytest.mark.runs("cuda", language="cuda")
@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("case", CASES)
def test_a_card_has_the_bits_of_the_library(case: str, number: str) -> None:
    p = made(case)

    def verb(name: str, data: Array) -> Array:
        width = p.encode(np.zeros(3)).shape[-1] if name == "encode" else WIDTHS[name]
        out = cuda_oracle.run(ptx_of(case, number), f"run_{name}", data, width)
        return out[:, 0] if width == 1 else out

    assert_alike(p, NUMBERS[number], verb)
    assert_none_of_none(verb, NUMBERS[number])


@cache
def packing_ptx(name: str, rounding: str) -> str:
    """Return both verbs of a packing in double numbers, a kernel each."""
    text = sm.packing.code(name, "cuda", rounding=rounding, name="m", dtype="float64")
    pack = f"made[i] = m_pack({vector('double', 3)});"
    unpack = f"double3 r = m_unpack(given[i]); {stores(3)}"
    word = "unsigned long long"
    return cuda_oracle.compiled(
        text
        + KERNEL.format(name="pack", call=pack, takes="double", gives=word)
        + KERNEL.format(name="unpack", call=unpack, takes=word, gives="double")
    )


@pytest.mark.runs("nvrtc", language="cuda")
@pytest.mark.parametrize("name", PACKINGS_DOUBLE)
def test_nvrtc_compiles_every_packing(name: str) -> None:
    for rounding in roundings(name):
        assert not LOOSE.findall(packing_ptx(name, rounding))
    ran.note("packings", name, 64)


@pytest.mark.runs("cuda", language="cuda")
@pytest.mark.parametrize("name", PACKINGS_DOUBLE)
def test_a_card_has_the_integers_of_packings(name: str) -> None:
    for rounding in roundings(name):
        ptx = packing_ptx(name, rounding)

        def pack(d: Array, ptx: str = ptx) -> Array:
            return cuda_oracle.run(ptx, "run_pack", d, 1)[:, 0].view(np.uint64)

        def unpack(words: Array, ptx: str = ptx) -> Array:
            return cuda_oracle.run(ptx, "run_unpack", words.view(np.float64)[:, None], 3)

        assert_packs_alike(name, rounding, np.float64, pack, unpack)
