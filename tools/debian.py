"""Packages of Debian, unpacked and not installed.

The system's own are not touched, nor is its list of what is installed, and root is not needed.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

CONFIGURATION = """
APT::Architectures {{ "amd64"; "arm64"; }};
APT::Install-Recommends "false";
APT::Sandbox::User "";
Dir::State "{state}";
Dir::State::status "{state}/status";
Dir::Cache "{state}/cache";
"""
SOURCES = """
Dir::Etc::sourcelist "{state}/sources.list";
Dir::Etc::sourceparts "-";
"""


class Apt:
    """Apt with lists, caches and installed packages (none) of its own.

    `sources` are lines of a sources.list, in place of those of this machine.
    """

    def __init__(self, state: Path, sources: str | None = None) -> None:
        for folder in ("lists/partial", "cache/archives/partial"):
            (state / folder).mkdir(parents=True, exist_ok=True)
        (state / "status").touch()
        self.archives = state / "cache" / "archives"
        configuration = state / "apt.conf"
        text = CONFIGURATION.format(state=state)
        if sources is not None:
            (state / "sources.list").write_text(sources, encoding="utf-8")
            text += SOURCES.format(state=state)
        configuration.write_text(text, encoding="utf-8")
        self.environment = {**os.environ, "APT_CONFIG": str(configuration)}
        self.get("update")

    def get(self, *arguments: str, folder: Path | None = None) -> None:
        command = ["apt-get", "-qq", "-o", "Debug::NoLocking=1", *arguments]
        subprocess.run(command, env=self.environment, cwd=folder, check=True)

    def fetch(self, packages: list[str]) -> list[Path]:
        """Return the archives of these packages alone."""
        before = set(self.archives.glob("*.deb"))
        self.get("download", *packages, folder=self.archives)
        return sorted(set(self.archives.glob("*.deb")) - before)

    def fetch_whole(self, packages: list[str], architecture: str) -> list[Path]:
        """Return the archives of these packages and of all that they depend on."""
        for archive in self.archives.glob("*.deb"):
            archive.unlink()
        option = f"APT::Architecture={architecture}"
        self.get("-o", option, "--download-only", "--yes", "install", *packages)
        return sorted(self.archives.glob("*.deb"))


def unpack(archives: list[Path], root: Path) -> None:
    root.mkdir(parents=True, exist_ok=True)
    for archive in archives:
        subprocess.run(["dpkg", "-x", archive, root], check=True)


def script(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(0o755)
