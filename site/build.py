"""Build the site: put its pages together, then have Sphinx make HTML of them. Needs no network.

python site/build.py build/site    the result is build/site/html

Pages of docs/, the notebooks and the files at the top are taken as they are. What is known of maps,
conventions, functions and times is made into pages from where it is known, by `maker`.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from maker import api, benchmarks, conventions, gallery, pages, projections, viewers
from maker.source import ROOT, Source


def main() -> int:
    """Build it, and say how long that took."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, help="where to build; html/ in it is the site")
    parser.add_argument("--quick", action="store_true", help="without running the notebooks")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    started = time.monotonic()

    source = Source(folder / "source")
    pages.copy(source)
    for maker in (viewers, projections, conventions, api, benchmarks, gallery):
        maker.make(source)
    source.forget_others()

    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q"]
    command += ["-j", "2", "-c", str(ROOT / "site"), "-d", str(folder / "doctrees")]
    command += ["-D", f"nb_execution_cache_path={folder / 'notebooks'}"]
    if arguments.quick:
        command += ["-D", "nb_execution_mode=off"]
    done = subprocess.run([*command, str(source.folder), str(folder / "html")], check=False)
    if done.returncode:
        return done.returncode
    files = sorted((folder / "html").rglob("*.html"), key=lambda path: path.stat().st_size)
    largest = files[-1]
    print(
        f"{len(files)} pages in {time.monotonic() - started:.0f} s; the largest is "
        f"{largest.relative_to(folder / 'html')}, {largest.stat().st_size / 1000:.0f} kB"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
