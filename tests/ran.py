"""What ran printed code: tests say what they compared, and docs/languages.md prints the record.

`pytest --record-languages` brings tests/languages/ran.json up to date. What a run compared replaces
what the same runtimes had there, so it is to be of whole files; what did not run, or failed, is
left as it was. Without the option nothing is measured or written.
"""

from __future__ import annotations

import json
from collections.abc import Generator
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from oracles import runtimes

PATH = Path(__file__).parent / "languages" / "ran.json"
Array = np.ndarray


@dataclass(frozen=True)
class Seen:
    """One map, packing or image that a test compared with the library."""

    subject: str
    name: str
    bits: int
    precision: str = "exact"
    verbs: tuple[str, ...] = ()
    directions: int | None = None
    # Whether every number was the same; nothing where that was not looked at.
    same: bool | None = None
    # How far the farthest direction lay from the library's.
    apart: float | None = None


_seen: list[Seen] | None = None


def note(subject: str, name: str, bits: int, **more: Any) -> None:
    """Keep what was compared, where a record is made; see `Seen`."""
    if _seen is not None:
        _seen.append(Seen(subject, name, bits, **more))


def chord(a: Array, b: Array) -> float:
    """Return how far the farthest directions are apart; what is none in either is not counted."""
    far = np.linalg.norm(a.astype(np.float64) - b.astype(np.float64), axis=-1)
    far = far[~np.isnan(far)]
    return float(far.max()) if len(far) else 0.0


def note_map(
    p: sm.Projection, dtype: type, given: dict[str, Array], found: dict[str, Array]
) -> None:
    """Note the verbs of a map: whether all numbers are the library's, and how far directions are.

    Of coordinates it is the directions that they mean: at a seam two far ones mean the same.
    """
    if _seen is None:
        return
    wanted = {verb: getattr(p, verb)(data) for verb, data in given.items()}
    outside = np.isnan(wanted["encode"]).any(axis=-1)
    with np.errstate(all="ignore"):
        uv = found["encode"].astype(np.float64), wanted["encode"].astype(np.float64)
        apart = max(chord(*map(p.decode, uv)), chord(found["decode"], wanted["decode"]))
    # Outside the coverage the first coordinate is none, and there is nothing to compare.
    wanted["encode"], found = wanted["encode"][~outside], dict(found)
    found["encode"] = found["encode"][~outside]
    same = all(
        np.array_equal(wanted[verb], found[verb], equal_nan=verb != "valid") for verb in given
    )
    bits = 8 * np.dtype(dtype).itemsize
    directions = len(given["encode"])
    note("maps", repr(p), bits, verbs=tuple(given), directions=directions, same=same, apart=apart)


@dataclass
class Row:
    """What one runtime did with one language, in one width and precision."""

    seen: list[Seen] = field(default_factory=list)

    def summed(self) -> dict[str, Any]:
        """Return the row of the record but for its key."""
        out: dict[str, Any] = {}
        for subject in sorted({s.subject for s in self.seen}):
            of_subject = [s for s in self.seen if s.subject == subject]
            counts: dict[str, Any] = {"run": len({s.name for s in of_subject})}
            if any(s.same is not None for s in of_subject):
                differing = {s.name for s in of_subject if not s.same}
                counts["same"] = counts["run"] - len(differing)
            if verbs := sorted({verb for s in of_subject for verb in s.verbs}):
                counts["verbs"] = verbs
            if tried := [s.directions for s in of_subject if s.directions is not None]:
                counts["directions"] = min(tried)
            if apart := [s.apart for s in of_subject if s.apart is not None]:
                counts["apart"] = float(f"{max(apart):.1e}")
            out[subject] = counts
        return out


class Recorder:
    """The plugin of a run that makes a record."""

    def __init__(self) -> None:
        self.rows: dict[tuple[str, str, str, int], Row] = {}
        self.failed: set[tuple[str, str]] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, None, None]:
        """Gather what a test compares, if it says which language it runs."""
        global _seen
        mark = item.get_closest_marker("runs")
        if mark is None:
            yield
            return
        by, language = mark.args[0], mark.kwargs.get("language")
        if language is None:
            language = item.callspec.params["language"]  # type: ignore[attr-defined]
        _seen = []
        try:
            yield
            for seen in _seen:
                key = (language, by, seen.precision, seen.bits)
                self.rows.setdefault(key, Row()).seen.append(seen)
        except pytest.skip.Exception:
            raise
        except BaseException:
            self.failed.add((language, by))
            raise
        finally:
            _seen = None

    def pytest_sessionfinish(self) -> None:
        """Write what passed into the record."""
        rows = {tuple(row[k] for k in KEY): row for row in read()}
        for key, row in self.rows.items():
            by = key[1]
            if key[:2] in self.failed:
                continue
            kept = rows.get(key, {})
            kept.update(zip(KEY, key, strict=True))
            kept.update(row.summed())
            kept.update(runtime=runtimes.version(by), date=date.today().isoformat())
            rows[key] = kept
        lines = [json.dumps(rows[key]) for key in sorted(rows)]
        PATH.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


KEY = ("language", "by", "precision", "bits")


def read() -> list[dict[str, Any]]:
    """Return the record."""
    if not PATH.exists():
        return []
    rows: list[dict[str, Any]] = json.loads(PATH.read_text(encoding="utf-8"))
    return rows
