"""Print the oldest versions of dependencies that pyproject.toml allows, as pip wants to be told.

python tools/minimal_versions.py    numpy==2.0.0 scikit-image==0.24.0 ...

Those of the package and of all its extras: the oldest that has a wheel for the Python that runs
this, of those that satisfy a lower bound. pip resolves to the newest, and has no way to be asked
for the oldest.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
REQUIREMENT = re.compile(r"(?P<name>[\w.-]+)(?P<extra>\[\w+\])?>=(?P<least>[\d.]+)")


def key(version: str) -> tuple[int, ...]:
    """Return what released versions are ordered by: 2 and 2.0.0 are one."""
    numbers = [int(n) for n in re.findall(r"\d+", version)]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def released(name: str) -> list[str]:
    """Return the versions with a wheel for this Python; no previews."""
    command = [sys.executable, "-m", "pip", "index", "versions", "--only-binary=:all:", name]
    shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    found = re.search(r"Available versions: (.*)", shown)
    if found is None:
        raise ValueError(f"pip names no versions of {name}")
    return found[1].split(", ")


def main() -> int:
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"].values()
    pins = []
    for requirement in [*project["dependencies"], *(r for extra in extras for r in extra)]:
        found = REQUIREMENT.fullmatch(requirement)
        if found is None:
            raise ValueError(f"expected name>=version, got {requirement!r}")
        name, least = found["name"], key(found["least"])
        fitting = [version for version in released(name) if key(version) >= least]
        pins.append(f"{name}{found['extra'] or ''}=={min(fitting, key=key)}")
    print(*pins)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
