"""How many threads OpenImageIO has for what it reads and writes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytest.importorskip("OpenImageIO")

SAID = """
import OpenImageIO as oiio
oiio.attribute("threads", {threads})
from spheremap.io.opened import library
print(library().get_int_attribute("threads"))
"""


@pytest.mark.parametrize(
    ("threads", "environment", "wanted"),
    [
        # Of two it makes no use: it hands work out to two others beside the one that asks.
        (2, {}, 3),
        (1, {}, 1),
        (8, {}, 8),
        (2, {"OPENIMAGEIO_THREADS": "2"}, 2),
    ],
)
def test_two_cores_are_used_unless_the_caller_said_how_many(
    threads: int, environment: dict[str, str], wanted: int
) -> None:
    others = {k: v for k, v in os.environ.items() if k != "OPENIMAGEIO_THREADS"}
    command = [sys.executable, "-c", SAID.format(threads=threads)]
    said = subprocess.run(command, env=others | environment, capture_output=True, check=True)
    assert int(said.stdout) == wanted
