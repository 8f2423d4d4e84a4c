"""The calls of `python -m bits`, at every level of instructions of this machine."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from spheremap import _core

from . import calls, inputs
from .__main__ import digest, read

# A math library of an older CPU, where the C library has several: it takes other ways to its sines.
OLDER = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2"}


@pytest.mark.slow
def test_every_call_has_the_same_bits_at_every_level(tmp_path):
    given = inputs.make()
    np.savez(tmp_path / "inputs.npz", **given)
    lowest, *others = _core.simd_levels()
    job = ["run", "inputs.npz", "results.npz", "--level", lowest]
    subprocess.run(
        [sys.executable, "-m", "bits", *job],
        cwd=tmp_path,
        env=os.environ | OLDER | {"PYTHONPATH": os.pathsep.join(map(str, searched()))},
        check=True,
    )
    _, results = read(tmp_path / "results.npz")
    want = {name: digest(a) for name, a in results.items()}
    for level in others:
        _core.set_simd_level(level)
        got = {name: digest(a) for name, a in calls.results(given)}
        assert list(got) == list(want)
        assert [name for name in got if got[name] != want[name]] == [], level


def searched() -> list[Path | str]:
    """Return where modules are looked for: beside this one first."""
    return [Path(__file__).parents[1], *filter(None, sys.path)]
