"""What runs printed code, by name and version."""

from __future__ import annotations

import os
import platform
import re
import subprocess
from collections.abc import Callable
from functools import cache
from importlib.metadata import version as of_package
from pathlib import Path
from typing import Any

import browser

from . import cuda_oracle, opengl_oracle, slang_oracle


def _compiler(command: str, language: str) -> str:
    said = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    word = said.stdout.split()
    number = subprocess.run([command, "-dumpfullversion"], capture_output=True, text=True)
    name = "gcc" if "gcc" in said.stdout or "Free Software" in said.stdout else word[0]
    return f"{name} {number.stdout.strip()} ({platform.machine()}), as {language}"


def _opengl() -> str:
    info = opengl_oracle.context().info
    return f"OpenGL {info['GL_VERSION']}, {info['GL_RENDERER']}"


def _webgl() -> str:
    with browser.launched() as chromium:
        script = """() => {
            const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
            gl.getExtension("WEBGL_debug_renderer_info");
            return gl.getParameter(0x9246);
        }"""
        renderer = chromium.new_page().evaluate(script)
        drawn = "SwiftShader" if "SwiftShader" in renderer else renderer
        return f"WebGL 2, Chromium {chromium.version}, {drawn}"


def _webgpu() -> str:
    import wgpu.utils

    info = wgpu.utils.get_default_device().adapter.info
    card = f"{info['device']}, {info['description']}"
    return f"wgpu {wgpu.__version__}, {info['backend_type']} on {card}"


def _vulkan() -> str:
    import compushady

    package = of_package("compushady-lrtu")
    return f"Vulkan (compushady {package}) on {compushady.get_best_device().name}"


def _dxc() -> str:
    import compushady

    # Nothing asks the library for its version; it is one of its strings.
    folder = Path(compushady.__file__).parent / "backends"
    strings = next(folder.glob("libdxcompiler*")).read_bytes()
    number = re.search(rb"(?<![\d.])(1\.\d+\.\d+\.\d+)(?![\d.])", strings)
    return f"DXC {number[1].decode() if number else 'of compushady'}, {_vulkan()}"


def _slangc() -> str:
    said = subprocess.run([slang_oracle.compiler(), "-v"], capture_output=True, text=True)
    return f"slangc {(said.stdout + said.stderr).strip()}"


def _opencl() -> str:
    import pyopencl as cl

    device = cl.create_some_context(interactive=False).devices[0]
    card = "CPU" if device.type & cl.device_type.CPU else device.name
    return f"{device.platform.version.split(' Linux')[0].strip()}, {card}"


def _torch() -> str:
    import torch

    return f"PyTorch {torch.__version__.partition('+')[0]}, CPU"


def _jax() -> str:
    import jax

    return f"JAX {jax.__version__}, {jax.devices()[0].device_kind}"


def _nvrtc() -> str:
    from cuda.bindings import nvrtc

    _, major, minor = nvrtc.nvrtcVersion()
    return f"NVRTC {major}.{minor}, compiled to PTX and not run"


def _cuda() -> str:
    driver: Any = cuda_oracle._driver()
    name = driver.cuDeviceGetName(128, driver.cuDeviceGet(0)[1])[1]
    return f"{_nvrtc().partition(',')[0]} on {name.partition(bytes(1))[0].decode()}"


def _cycles() -> str:
    script = "import bpy; print('Blender', bpy.app.version_string)"
    command = [os.environ["SPHEREMAP_BLENDER"], "-c", script]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return f"Cycles, {next(line for line in said.splitlines() if line.startswith('Blender'))}"


_VERSIONS: dict[str, Callable[[], str]] = {
    "cc": lambda: _compiler("cc", "C"),
    "c++": lambda: _compiler("c++", "C++"),
    "numpy": lambda: f"NumPy {of_package('numpy')}",
    "array_api": lambda: f"array-api-strict {of_package('array-api-strict')}",
    "opengl": _opengl,
    "webgl": _webgl,
    "webgpu": _webgpu,
    "dxc": _dxc,
    "slangc, vulkan": lambda: f"{_slangc()}, {_vulkan()}",
    "slangc, c++": lambda: f"{_slangc()}, {_compiler('c++', 'C++')}",
    "opencl": _opencl,
    "torch": _torch,
    "jax": _jax,
    "nvrtc": _nvrtc,
    "cuda": _cuda,
    "cycles": _cycles,
}


@cache
def version(by: str) -> str:
    """Return what a runtime is, with the versions and the card or driver below it."""
    return _VERSIONS[by]()
