"""Type checkers pass programs as users write them, and see what is wrong."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import spheremap as sm

PROGRAM = Path(__file__).parent / "typed_program.py"
LIBRARY = Path(sm.__file__).parents[1]


def mypy(path: Path, cache: Path) -> str:
    pytest.importorskip("mypy")
    options = ["--strict", "--config-file=", "--warn-unused-ignores", "--cache-dir", str(cache)]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, str(path)],
        capture_output=True,
        text=True,
        env={**os.environ, "MYPYPATH": str(LIBRARY)},
        cwd=path.parent,
        check=False,
    )
    return done.stdout + done.stderr


@pytest.mark.slow
def test_mypy_passes_a_program(tmp_path):
    assert "Success: no issues found in 1 source file" in mypy(PROGRAM, tmp_path)
    # And it does look: an image of bytes is none of floats.
    wrong = tmp_path / "wrong.py"
    text = PROGRAM.read_text()
    assert text.count("filter=filter), Bytes)\n    assert_type(sm.convert(light") == 1
    wrong.write_text(
        text.replace(
            "filter=filter), Bytes)\n    assert_type(sm.convert(light",
            "filter=filter), Floats)\n    assert_type(sm.convert(light",
        ).replace('negative="clip"', 'negative="zero"')
    )
    said = mypy(wrong, tmp_path)
    assert re.search(r"Expression is of type .*_8Bit|Expression is of type .*uint8", said), said
    assert re.search(r'"negative" to "integrate" has incompatible type', said), said
    assert "Found 2 errors" in said
