"""What a batch has made, a line of JSON each: so that another run knows what is left to do."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import spheremap as sm
from spheremap.cli.jobs import Failed, Job, Made, noted
from spheremap.io.whole import write_bytes


class Manifest:
    """A file of lines, the last of which counts for each target.

    A line is written when its result is whole. Paths are relative to the file's folder: both may be
    moved together.
    """

    def __init__(self, path: Path, arguments: Mapping[str, Any]) -> None:
        self.path = path
        # As they come back.
        self._arguments = json.loads(json.dumps(arguments))
        self._entries = dict[str, dict[str, Any]]()
        if path.exists():
            self._read(path.read_text(encoding="utf-8", errors="replace"))

    def _read(self, text: str) -> None:
        lines = text.splitlines()
        for number, line in enumerate(lines, 1):
            try:
                entry = json.loads(line)
                self._entries[entry["target"]] = entry
            except (ValueError, TypeError, KeyError):
                # A run that was killed may leave half a line, which ends nothing.
                if number < len(lines) or text.endswith("\n"):
                    where = f"line {number} of {str(self.path)!r}"
                    raise ValueError(f"{where} is none of a batch's manifest") from None
        if len(self._entries) < len(lines):
            whole = "".join(json.dumps(entry) + "\n" for entry in self._entries.values())
            write_bytes(self.path, whole.encode())

    def made(self) -> set[str]:
        """Return the absolute paths of all results."""
        folder = self.path.absolute().parent
        return {
            os.path.normpath(folder / found["file"])
            for entry in self._entries.values()
            for found in entry.get("results", ())
        }

    def is_done(self, job: Job) -> bool:
        """Tell whether a job's results are there, of this source and of these arguments."""
        entry = self._entries.get(self._relative(job.out), {})
        results = entry.get("results", [])
        return (
            bool(results)
            and entry["arguments"] == self._arguments
            and entry["source"]["file"] == self._relative(job.source)
            and [found["file"] for found in results] == [*map(self._relative, job.places)]
            and _is_same(job.source, entry["source"])
            and all(map(_is_same, job.places, results))
        )

    def note(self, job: Job, outcome: Made | Failed) -> None:
        """Add a line for what became of a job."""
        entry: dict[str, Any] = {
            "target": self._relative(job.out),
            "source": {"file": self._relative(job.source)},
            "arguments": self._arguments,
            "version": sm.__version__,
        }
        if isinstance(outcome, Failed):
            entry["error"] = outcome.why
        else:
            entry["source"] |= asdict(outcome.source)
            entry["results"] = [
                {"file": self._relative(place)} | asdict(found)
                for place, found in zip(job.places, outcome.results, strict=True)
            ]
            entry["said"] = outcome.said
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with open(self.path, "ab") as file:
            file.write(f"{json.dumps(entry)}\n".encode())
            file.flush()
            os.fsync(file.fileno())

    def _relative(self, path: Path) -> str:
        return Path(os.path.relpath(path, self.path.parent)).as_posix()


def _is_same(path: Path, entry: Mapping[str, Any]) -> bool:
    """Tell whether a file is as it was noted; one that is as old as then is not read for it."""
    try:
        found = path.stat()
        if found.st_size != entry["size"]:
            return False
        as_old: bool = found.st_mtime_ns == entry["modified"]
        return as_old or noted(path).sha256 == entry["sha256"]
    except OSError:
        return False
