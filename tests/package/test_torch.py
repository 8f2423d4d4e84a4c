"""Torch is never imported unasked; where it is missing an error says what to install."""

from __future__ import annotations

import subprocess
import sys


def python(code: str) -> str:
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_torch_is_imported_by_its_own_module_alone() -> None:
    everything = (
        "import sys; sys.modules['torch'] = None; import spheremap as sm\n"
        "for name in sm.__all__: getattr(sm, name)\n"
        "try: import spheremap.torch\n"
        "except ImportError as error: print(error.name, error)"
    )
    assert python(everything) == (
        "torch `spheremap.torch` needs torch: pip install spheremap[torch]"
    )
