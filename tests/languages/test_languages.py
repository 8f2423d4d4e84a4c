"""Printed code, run by what is long to install: PyTorch, OpenCL (`make test-languages`)."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from oracles import need
from printed import (
    CASES,
    VERBS,
    Array,
    assert_alike,
    assert_native,
    assert_none_of_none,
    made,
)

pytestmark = pytest.mark.programs


def arrays_of(language: str, p: sm.Projection, dtype: type) -> dict[str, Any]:
    """Return the functions of a language of Python."""
    names: dict[str, Any] = {}
    exec(sm.code(p, language, verbs=VERBS, name="m", dtype=dtype.__name__), names)
    return names


@pytest.mark.runs("torch", language="torch")
@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", CASES)
def test_torch_is_within_the_bounds(case: str, dtype: type) -> None:
    torch = need("torch")
    p = made(case)
    names = arrays_of("torch", p, dtype)

    def verb(name: str, data: Array) -> Array:
        out: Array = names[f"m_{name}"](torch.from_numpy(data)).numpy()
        return np.swapaxes(out, -1, -2).reshape(-1, 6) if name == "jacobian" else out

    assert_alike(p, dtype, verb, exact=False)


@pytest.mark.runs("torch", language="torch")
@pytest.mark.parametrize("case", CASES)
def test_torch_has_functions_of_its_own(case: str) -> None:
    torch = need("torch")
    p = made(case)
    names: dict[str, Any] = {}
    exec(sm.code(p, "torch", name="m", precision="native"), names)

    def there_and_back(d: Array) -> Array:
        out: Array = names["m_decode"](names["m_encode"](torch.from_numpy(d))).numpy()
        return out

    # Its vectors of functions, those of SLEEF, state 3.5 units at most.
    assert_native(p, there_and_back, ulps=4)


KERNEL = """{text}
__kernel void run(__global const {number}* given, __global {number}* made) {{
    size_t i = get_global_id(0);
    {call}
}}
"""


# NVIDIA's compiler gives functions the attribute itself, and then says so of the kernel.
OWN_WORDS = (
    "(): Warning: Function run is a kernel, so overriding noinline attribute. "
    "The function may be inlined when called."
)


def opencl_kernel(context: Any, source: str) -> Any:
    """Return the kernel of a source, which must compile without a word of the compiler's on it."""
    cl = need("pyopencl")
    program = cl.Program(context, source)
    with warnings.catch_warnings():
        # It tells that something was said and not what, which is looked at here.
        warnings.simplefilter("ignore", cl.CompilerWarning)
        program.build(["-cl-fp32-correctly-rounded-divide-sqrt"])
    for device in context.devices:
        said = program.get_build_info(device, cl.program_build_info.LOG).strip(" \n\0")
        assert said in ("", OWN_WORDS)
    return program.run


def by_opencl(source: str, data: Array, width: int) -> Array:
    """Return what a kernel makes of each row, so many numbers."""
    cl = need("pyopencl")
    context = cl.create_some_context(interactive=False)
    queue = cl.CommandQueue(context)
    kernel = opencl_kernel(context, source)
    out = np.empty((len(data), width), data.dtype)
    flags = cl.mem_flags
    given = cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=data)
    target = cl.Buffer(context, flags.WRITE_ONLY, out.nbytes)
    kernel(queue, (len(data),), None, given, target)
    cl.enqueue_copy(queue, out, target)
    return out


@pytest.mark.runs("opencl", language="opencl")
@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", CASES)
def test_opencl_has_the_bits_of_the_library(case: str, dtype: type) -> None:
    p = made(case)
    width = p.encode(np.zeros(3)).shape[-1]
    number = "float" if dtype is np.float32 else "double"
    text = sm.code(p, "opencl", verbs=VERBS, name="m", dtype=dtype.__name__)
    d = f"({number}3)(given[3 * i], given[3 * i + 1], given[3 * i + 2])"
    parts = ", ".join(f"given[{width} * i + {k}]" for k in range(width))
    place = f"({number}{width})({parts})"

    def stores(n: int, at: int = 0, name: str = "r", total: int | None = None) -> str:
        return " ".join(f"made[{total or n} * i + {at + k}] = {name}.{'xyz'[k]};" for k in range(n))

    columns = f"{stores(3, 0, 'r', 6)} {stores(3, 3, 's', 6)}"
    of = {
        "encode": (f"{number}{width} r = m_encode({d}); {stores(width)}", width),
        "decode": (f"{number}3 r = m_decode({place}); {stores(3)}", 3),
        "density": (f"made[i] = m_density({place});", 1),
        "valid": (f"made[i] = m_valid({place}) ? 1 : 0;", 1),
        "jacobian": (f"{number}3 r, s; m_jacobian({place}, &r, &s); {columns}", 6),
    }

    def verb(name: str, data: Array) -> Array:
        call, n = of[name]
        out = by_opencl(KERNEL.format(text=text, number=number, call=call), data, n)
        return out[:, 0] if n == 1 else out

    assert_alike(p, dtype, verb)
    assert_none_of_none(verb, dtype)


@pytest.mark.runs("opencl", language="opencl")
@pytest.mark.parametrize("case", CASES)
def test_opencl_has_functions_of_its_own(case: str) -> None:
    p = made(case)
    text = sm.code(p, "opencl", name="m", precision="native")
    call = (
        "float3 r = m_decode(m_encode((float3)(given[3 * i], given[3 * i + 1], given[3 * i + 2])));"
    )
    call += " made[3 * i] = r.x; made[3 * i + 1] = r.y; made[3 * i + 2] = r.z;"
    source = KERNEL.format(text=text, number="float", call=call)
    # The standard allows an arctangent 6 units.
    assert_native(p, lambda d: by_opencl(source, d, 3), ulps=6)
