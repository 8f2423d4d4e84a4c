"""Fetch from Debian what builds and runs an aarch64 wheel on an x86-64 machine.

python tools/fetch_aarch64.py FOLDER

FOLDER/rustc     a Rust compiler with the standard libraries of both (Debian's rustc-web)
FOLDER/python    Python for aarch64, run by qemu-user-static

Packages are unpacked, not installed, and root is not needed. What is needed are apt-get, dpkg, and
sources that have these packages, as those of Debian 12 do.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

from debian import Apt, script, unpack

# A library of the machine's own C library would not fit its loader.
OF_THE_MACHINE = ("libc6_", "libcrypt1_", "gcc-12-base_")


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
