"""One file of a batch, as a worker converts it: in a process of this machine or of another."""

from __future__ import annotations

import hashlib
import threading
import time
from contextlib import redirect_stderr
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import spheremap as sm
from spheremap.cli import targets
from spheremap.cli.conversion import Options
from spheremap.cli.large import convert_any
from spheremap.cli.steps import Step
from spheremap.cli.terminal import UsageError

# Errors that another try does not mend.
_LASTING = (FileNotFoundError, FileExistsError, PermissionError, IsADirectoryError)
# Seconds before the second try, and twice as many before each other.
_PAUSE = 0.5
# What libraries print is caught for a whole process, so a process works on one file at a time.
_ALONE = threading.Lock()


@dataclass(frozen=True)
class Job:
    """A file to convert, how its command line calls it, where to, and how often it is tried."""

    name: str
    source: Path
    out: Path
    options: Options
    retries: int

    @property
    def places(self) -> list[Path]:
        """The files that will be there."""
        return targets.places(self.out, self.options.dst, self.options.face_names)


@dataclass(frozen=True)
class Noted:
    """What tells a file from what it was before."""

    size: int
    modified: int
    sha256: str


@dataclass(frozen=True)
class Made:
    """What a job has made, what there was to say of it, and what it is warned of."""

    source: Noted
    results: list[Noted]
    said: list[str]
    warned: list[str]


@dataclass(frozen=True)
class Failed:
    """Why a job has made nothing."""

    why: str


def convert_job(job: Job, threads: int) -> Made | Failed:
    """Convert a file; what fails by its disk or its network is tried again."""
    with _ALONE:
        sm.set_num_threads(threads)
        for count in range(job.retries + 1):
            try:
                return _converted(job)
            except (OSError, ValueError, TypeError, MemoryError, ArithmeticError, UsageError) as e:
                why = " ".join(str(e).split()) or type(e).__name__
                if not isinstance(e, OSError) or isinstance(e, _LASTING) or count == job.retries:
                    break
            time.sleep(_PAUSE * 2**count)
    return Failed(why)


def _converted(job: Job) -> Made:
    before = noted(job.source)
    job.out.parent.mkdir(parents=True, exist_ok=True)
    with redirect_stderr(StringIO()) as warned:
        said = convert_any(job.source, job.out, job.options, Step(), None)
    results = [noted(place) for place in job.places]
    return Made(before, results, said, warned.getvalue().splitlines())


def noted(path: Path) -> Noted:
    """Return what tells a file from others."""
    found = path.stat()
    with open(path, "rb") as file:
        return Noted(
            found.st_size, found.st_mtime_ns, hashlib.file_digest(file, "sha256").hexdigest()
        )
