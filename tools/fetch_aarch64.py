"""Fetch from Debian what builds and runs an aarch64 wheel on an x86-64 machine.

python tools/fetch_aarch64.py FOLDER

FOLDER/rustc     a Rust compiler with the standard libraries of both (Debian's rustc-web)
FOLDER/python    Python for aarch64, run by qemu-user-static

Packages are unpacked, not installed: the system's own are not touched, nor is its list of what is
installed, and root is not needed. What is needed are apt-get, dpkg, and sources that have these
packages, as those of Debian 12 do.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

# A library of the machine's own C library would not fit its loader.
OF_THE_MACHINE = ("libc6_", "libcrypt1_", "gcc-12-base_")
CONFIGURATION = """
APT::Architectures {{ "amd64"; "arm64"; }};
APT::Install-Recommends "false";
APT::Sandbox::User "";
Dir::State "{state}";
Dir::State::status "{state}/status";
Dir::Cache "{state}/cache";
"""


class Apt:
    """Apt with lists, caches and installed packages (none) of its own."""

    def __init__(self, state: Path) -> None:
        for folder in ("lists/partial", "cache/archives/partial"):
            (state / folder).mkdir(parents=True, exist_ok=True)
        (state / "status").touch()
        self.archives = state / "cache" / "archives"
        configuration = state / "apt.conf"
        configuration.write_text(CONFIGURATION.format(state=state), encoding="utf-8")
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


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1]).resolve()
    apt = Apt(folder / "apt")
    host, guest = folder / "x86-64", folder / "aarch64"

    # The compiler asks for a C compiler, which zig is here: so not the whole of what it wants.
    libraries = apt.fetch_whole(["libstd-rust-web-dev"], "amd64")
    unpack([x for x in libraries if not x.name.startswith(OF_THE_MACHINE)], host)
    unpack(apt.fetch(["rustc-web", "libstd-rust-web-dev:arm64", "qemu-user-static"]), host)
    places = f"{host}/usr/lib/x86_64-linux-gnu:{host}/lib/x86_64-linux-gnu"
    script(
        folder / "rustc",
        f'LD_LIBRARY_PATH={shlex.quote(places)} exec {shlex.quote(f"{host}/usr/bin/rustc")} "$@"',
    )

    # NumPy's wheel wants the library of C++.
    unpack(
        apt.fetch_whole(["python3.11-minimal", "libpython3.11-stdlib", "libstdc++6"], "arm64"),
        guest,
    )
    emulator = shlex.quote(f"{host}/usr/bin/qemu-aarch64-static")
    system = shlex.quote(str(guest))
    script(folder / "python", f'exec {emulator} -L {system} {system}/usr/bin/python3.11 "$@"')

    for program in ("rustc", "python"):
        subprocess.run([folder / program, "--version"], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
