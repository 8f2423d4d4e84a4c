"""Hold the crates that the wheel is built from to a list of licenses and to crates.io.

python tools/lint_licenses.py

What `cargo metadata` resolves for the `python` feature, without what tests and benchmarks alone
need. Advisories are not looked up: that takes a database that changes daily.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SOURCE = "registry+https://github.com/rust-lang/crates.io-index"
# Licenses that ask for no more than that their text is kept.
ALLOWED = {
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}


def allows(expression: str | None) -> bool:
    """Tell whether one way of reading an SPDX expression has allowed licenses alone."""
    if not expression:
        return False
    # Crates of old write MIT/Apache-2.0.
    text = expression.replace("/", " OR ").strip()
    while (inner := re.search(r"\(([^()]*)\)", text)) is not None:
        text = text.replace(inner[0], "MIT" if allows(inner[1]) else "none")
    return any(
        all(name.strip() in ALLOWED for name in choice.split(" AND "))
        for choice in text.split(" OR ")
    )


def complaints(packages: list[dict[str, Any]]) -> list[str]:
    """Return what is wrong with packages, as `cargo metadata` describes them."""
    said = []
    for package in packages:
        name = f"{package['name']} {package['version']}"
        if package["source"] not in (None, SOURCE):
            said.append(f"{name} comes from {package['source']}, not from crates.io")
        if not allows(package["license"]):
            said.append(f"{name} has the license {package['license']}, which is not on the list")
    return said


def shipped(metadata: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the packages that the library is built from, itself included."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    seen: set[str] = set()
    left = [metadata["resolve"]["root"]]
    while left:
        name = left.pop()
        if name not in seen:
            seen.add(name)
            for dependency in nodes[name]["deps"]:
                if any(kind["kind"] != "dev" for kind in dependency["dep_kinds"]):
                    left.append(dependency["pkg"])
    return [package for package in metadata["packages"] if package["id"] in seen]


def main() -> int:
    command = ["cargo", "metadata", "--format-version", "1", "--features", "python"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    packages = shipped(json.loads(run.stdout))
    said = complaints(packages)
    print(*said, sep="\n", end="\n" if said else "")
    print(f"{len(packages)} crates")
    return bool(said)


if __name__ == "__main__":
    sys.exit(main())
