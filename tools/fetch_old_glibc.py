"""Build, with Debian's sources and Zig, a Python that runs on the C library of an old Debian.

python tools/fetch_old_glibc.py FOLDER ZIG

FOLDER/python    Python on glibc 2.31 (Debian 11), whatever this machine's own is

No old system carries a Python that is new enough. So Debian's source of Python is compiled here by
Zig, against glibc 2.17, and is started by the loader of the old system's C library, which brings
its own libc, libm and libpthread: nothing of this machine's is mapped. Packages are unpacked, not
installed, and root is not needed. What is needed are apt-get, dpkg, make, and sources of Debian,
whose mirror also has the old system.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from debian import Apt, script, unpack

OLD_SUITE = "bullseye"
# numpy is linked to the library of C++, which wants that of its compiler.
OLD_PACKAGES = ["libc6", "libgcc-s1", "libstdc++6"]
PYTHON_SUITE, PYTHON_PACKAGE = "bookworm", "python3.11"
GLIBC = "2.17"
SOURCES = Path("/etc/apt/sources.list.d/debian.sources"), Path("/etc/apt/sources.list")


def mirror() -> str:
    """Return where this machine's packages of Debian come from."""
    for sources in SOURCES:
        text = sources.read_text(encoding="utf-8") if sources.exists() else ""
        found = re.search(r"^(?:URIs:|deb(?: \[.*?\])?)\s+(\S+)", text, re.MULTILINE)
        if found:
            return found[1]
    raise SystemExit("no source of Debian's packages was found in " + str(SOURCES[0].parent))


def run(command: list[str], folder: Path) -> None:
    """Run a command, and show the end of what it said where it fails."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{command[0]} failed:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")


def build_python(source: Path, zig: str, home: Path, zlib: Path) -> None:
    """Compile one program that holds all modules which want no other library but zlib."""
    # Zig refuses __DATE__, which Python tells of itself.
    compiler = f"{zig} cc -target x86_64-linux-gnu.{GLIBC} -Wno-date-time"
    configure = [
        "./configure",
        f"--prefix={home}",
        f"CC={compiler}",
        f"AR={zig} ar",
        f"RANLIB={zig} ranlib",
        "LINKFORSHARED=-rdynamic",
        "MODULE_BUILDTYPE=static",
        # It would find this machine's libraries, which are linked to a newer C library.
        "PKG_CONFIG=false",
        f"ZLIB_CFLAGS=-I{zlib / 'include'}",
        f"ZLIB_LIBS={zlib / 'lib/x86_64-linux-gnu/libz.a'}",
    ]
    run(configure, source)
    # Modules apart would be compiled with the headers of this machine's C library. Those for
    # Python's own tests do not link.
    modules = (source / "Modules" / "Setup.stdlib").read_text(encoding="utf-8").splitlines()
    kept = [line for line in modules if not line.startswith(("_test", "_xxtest"))]
    (source / "Modules" / "Setup.local").write_text("\n".join(kept) + "\n", encoding="utf-8")
    run(["make", "-j2", "python"], source)
    shutil.rmtree(home, ignore_errors=True)
    library = home / "lib" / "python3.11"
    shutil.copytree(source / "Lib", library, ignore=shutil.ignore_patterns("test", "idlelib"))
    (library / "lib-dynload").mkdir()
    (home / "bin").mkdir()
    shutil.copy(source / "python", home / "bin" / "python3.11")


def main() -> int:
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    folder, zig = Path(sys.argv[1]).resolve(), sys.argv[2]
    where = mirror()
    old = Apt(folder / "apt-old", f"deb {where} {OLD_SUITE} main\n")
    system = folder / "system"
    unpack(old.fetch(OLD_PACKAGES), system)
    unpack(old.fetch(["zlib1g-dev"]), folder / "zlib")

    new = Apt(folder / "apt", f"deb-src {where} {PYTHON_SUITE} main\n")
    source, home = folder / "source", folder / "home"
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    new.get("--download-only", "source", PYTHON_PACKAGE, folder=source)
    (archive,) = source.glob("*.orig.tar.*")
    subprocess.run(["tar", "-xf", archive, "--strip-components=1"], cwd=source, check=True)
    build_python(source, zig, home, folder / "zlib" / "usr")

    libraries = ":".join(
        shlex.quote(str(system / place))
        for place in ("lib/x86_64-linux-gnu", "usr/lib/x86_64-linux-gnu")
    )
    loader = shlex.quote(str(system / "lib/x86_64-linux-gnu/ld-2.31.so"))
    program = shlex.quote(str(home / "bin/python3.11"))
    script(folder / "python", f'exec {loader} --library-path {libraries} {program} "$@"')
    version = "import os, sys; print(sys.version, os.confstr('CS_GNU_LIBC_VERSION'))"
    subprocess.run([folder / "python", "-c", version], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
