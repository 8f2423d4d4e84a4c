"""The record of what ran printed code is whole: docs/languages.md prints its table from it."""

from __future__ import annotations

from typing import Any

import pytest
import ran
from printed import CASES, LANGUAGES, VERBS

RECORD = ran.read()


@pytest.mark.parametrize("language", [entry["name"] for entry in LANGUAGES])
def test_every_language_ran(language: str) -> None:
    """Every verb of every map, on 20,000 directions: by something that runs, not only compiles."""
    ran_maps: list[dict[str, Any]] = [
        row["maps"]
        for row in RECORD
        if row["language"] == language and row["precision"] == "exact"
        if "directions" in row.get("maps", {})
    ]
    assert ran_maps, f"{language}: run its tests with --record-languages"
    for maps in ran_maps:
        assert set(maps["verbs"]) == set(VERBS)
        assert maps["directions"] > 20_000
        # One that was added since is in the next record; a run of a part would not be.
        assert maps["run"] >= 0.9 * len(CASES)


def test_rows_are_of_languages_and_of_runtimes_with_versions() -> None:
    assert {row["language"] for row in RECORD} <= {entry["name"] for entry in LANGUAGES}
    keys = [tuple(row[key] for key in ran.KEY) for row in RECORD]
    assert keys == sorted(set(keys))
    for row in RECORD:
        assert any(digit.isdigit() for digit in row["runtime"]), row["runtime"]
