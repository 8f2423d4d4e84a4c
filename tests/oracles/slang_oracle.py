"""Slang by its compiler, `slangc` of the wheel `slangtorch`: as C++, and as SPIR-V by Vulkan."""

from __future__ import annotations

import ctypes
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from . import need, vulkan_oracle

KERNEL = """
[shader("compute")]
[numthreads(64, 1, 1)]
void {name}(uint3 id : SV_DispatchThreadID) {{
    uint i = id.x;
    if (i >= {count}u) return;
    {call}
}}
"""
BUFFERS = """
StructuredBuffer<{takes}> given;
RWStructuredBuffer<{gives}> made;
"""
TYPED = """
[[vk::binding(1024, 0)]] Buffer<{takes}> given;
[[vk::binding(2048, 0)]] RWBuffer<{gives}> made;
"""
NAMES = {
    np.dtype(np.float32): "float",
    np.dtype(np.float64): "double",
    np.dtype(np.uint32): "uint",
    np.dtype(np.uint64): "uint64_t",
}


def compiler() -> str:
    """Return the path of slangc; the package around it imports PyTorch, which it does not need."""
    found = find_spec("slangtorch")
    if found is None or found.origin is None:
        need("slangtorch")
        raise AssertionError("slangtorch is no package")
    return str(Path(found.origin).parent / "bin" / "slangc")


def compiled(text: str, folder: Path, target: str, *options: str) -> Path:
    """Return the file that the compiler makes of a text."""
    source, made = folder / "printed.slang", folder / f"printed.{target}"
    source.write_text(text)
    command = [compiler(), source, "-target", target, *options, "-o", made]
    said = subprocess.run(command, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    return made


def as_cpp(
    text: str,
    calls: dict[str, tuple[str, np.ndarray]],
    folder: Path,
    dtype: type,
) -> dict[str, np.ndarray]:
    """Return what calls make of their rows, each as many numbers as it stores, by C++."""
    (taken,) = {rows.dtype for _, rows in calls.values()}
    whole = text + BUFFERS.format(takes=NAMES[taken], gives=NAMES[np.dtype(dtype)])
    for name, (call, rows) in calls.items():
        whole += KERNEL.format(name=f"run_{name}", count=len(rows), call=call)
    # A library of its own name: one that is loaded is not loaded again.
    source = compiled(whole, folder, "cpp")
    library = folder / f"printed{len(list(folder.glob('*.so')))}.so"
    # It leaves `precise` in its C++.
    flags = ("-w", "-O1", "-ffp-contract=off", "-Dprecise=", "-shared", "-fPIC")
    subprocess.run(["c++", *flags, source, "-o", library], check=True)
    functions = ctypes.CDLL(str(library))
    made = {}
    for name, (call, rows) in calls.items():
        out = np.empty((len(rows), call.count("made[")), dtype)
        # Its way to pass buffers: the address and the length of each.
        buffers = (ctypes.c_size_t * 4)(rows.ctypes.data, rows.size, out.ctypes.data, out.size)
        # From the first group to behind the last, in three dimensions.
        groups = (ctypes.c_uint32 * 6)(0, 0, 0, -(-len(rows) // 64), 1, 1)
        functions[f"run_{name}"](groups, None, buffers)
        made[name] = out
    return made


def as_spirv(
    text: str, call: str, rows: np.ndarray, folder: Path, dtype: type = np.float32
) -> np.ndarray:
    """Return what a call makes of each row, as many numbers as it stores, by Vulkan.

    Optimizers are other programs, and are not asked.
    """
    need("compushady")
    whole = text + TYPED.format(takes=NAMES[rows.dtype], gives=NAMES[np.dtype(dtype)])
    whole += KERNEL.format(name="main", count=len(rows), call=call)
    options = ("-O0", "-fp-mode", "precise", "-entry", "main", "-stage", "compute")
    made = compiled(whole, folder, "spirv", *options)
    each = call.count("made[")
    return vulkan_oracle.run(made.read_bytes(), rows, each, dtype).reshape(-1, each)
