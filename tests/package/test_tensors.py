"""Torch and JAX are never imported unasked; where they are missing an error says so."""

from __future__ import annotations

import subprocess
import sys

import pytest


def python(code: str) -> str:
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("name", ["torch", "jax"])
def test_it_is_imported_by_its_own_module_alone(name: str) -> None:
    everything = (
        f"import sys; sys.modules[{name!r}] = None; import spheremap as sm\n"
        "for name in sm.__all__: getattr(sm, name)\n"
        f"try: import spheremap.{name}\n"
        "except ImportError as error: print(error.name, error)"
    )
    assert python(everything) == (
        f"{name} `spheremap.{name}` needs {name}: pip install spheremap[{name}]"
    )
