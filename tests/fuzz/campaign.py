"""Many calls in processes that may end: whatever ends one is a finding, and the next goes on."""

from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from .calls import call

TESTS = Path(__file__).resolve().parents[1]
# What the limits of a worker end it with.
ENDS = {signal.SIGPROF: "more than 10 s of CPU time", signal.SIGALRM: "waits without end"}


@dataclass(frozen=True)
class Finding:
    """A call that ended as no call may."""

    seed: int
    index: int
    what: str
    said: str

    def __str__(self) -> str:
        return (
            f"{self.what}: {self.said}\n"
            f"    {call(self.seed, self.index)}\n"
            f"    python -m fuzz --seed {self.seed} --only {self.index}"
        )


def run(seed: int, first: int, last: int) -> list[Finding]:
    """Make the calls of a seed from one number to another; return what was found."""
    findings = []
    with tempfile.TemporaryDirectory(prefix="fuzz") as folder:
        place = Path(folder) / "begun"
        while first < last:
            place.write_bytes(bytes(8))
            arguments = [str(n) for n in (seed, first, last)]
            done = subprocess.run(
                [sys.executable, "-m", "fuzz.worker", *arguments, str(place)],
                env={**os.environ, "PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])},
                capture_output=True,
                text=True,
                errors="replace",
            )
            rows = [json.loads(line) for line in done.stdout.splitlines() if line[:1] == "["]
            findings += [Finding(seed, *row) for row in rows]
            begun: int = struct.unpack("q", place.read_bytes())[0]
            if begun < last:
                findings.append(Finding(seed, begun, *_end(done)))
            first = begun + 1
    return findings


def _end(done: subprocess.CompletedProcess[str]) -> tuple[str, str]:
    if done.returncode < 0:
        number = signal.Signals(-done.returncode)
        return ENDS.get(number, "the process died"), f"{number.name} {done.stderr[-300:]}"
    return "the worker failed", done.stderr[-1000:]
