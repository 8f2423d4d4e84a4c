"""Every command that README.md and the pages of docs show works as it is typed."""

from __future__ import annotations

import itertools
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import filming
import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import io
from spheremap.cli.app import parser_of
from test_cli import smooth

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    ROOT / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "start").glob("*.md")),
)
# A line of a block, or words within a sentence: with something to do.
SHOWN = re.compile(r"^(?: {4})?(spheremap [^\s`]+ .+)$|`(spheremap [^\s`]+ [^`\n]+)`", re.MULTILINE)
# Each once, with the first page that has it.
LINES = {
    (line[1] or line[2]).strip(): page.name
    for page in reversed(PAGES)
    for line in SHOWN.finditer(page.read_text(encoding="utf-8"))
    if "COMMAND" not in line[0] and "..." not in line[0]
}
# Each command once, as short as it is shown; those that take seconds have other tests.
SHORT = [
    min((line for line in LINES if line.split()[1] == command), key=len)
    for command in dict.fromkeys(line.split()[1] for line in LINES)
    if command not in ("ball", "demo")
]


def test_the_lines_are_found() -> None:
    assert LINES["spheremap explain latlong:mitsuba"] == "README.md"
    assert LINES["spheremap conventions unity"] == "README.md"
    assert sum(page == "files.md" for page in LINES.values()) >= 7
    assert sum(page == "artist.md" for page in LINES.values()) >= 7


@pytest.mark.parametrize("line", LINES)
def test_it_parses(line: str) -> None:
    """Options are those of the command, with as many words as they take; names are known."""
    command, *words = itertools.takewhile(lambda word: word != "|", shlex.split(line)[1:])
    parser_of([command]).commands[command].make_context(command, words)
    for option, name in itertools.pairwise(words):
        if option in ("--from", "--to"):
            sm.projection(name)


def prepare(folder: Path, line: str) -> None:
    """Write the files that a line reads, small."""
    sky = np.abs(smooth(sm.directions("latlong", 64)))
    # A line of *.hdr means probes.
    for name in ("sky.exr", "panorama.exr", "env.exr", *["sky.hdr"] * ("sky.hdr" in line)):
        io.write(folder / name, sky)
    for name in ("panorama.png", "huge.tif"):
        io.write(folder / name, np.full((64, 128, 3), 99, np.uint8))
    io.write(folder / "probe.hdr", sm.convert(sky, "latlong", "angular", size=64))
    # Two photos of a ball, from two sides, or two maps of a scene that say what they are.
    for k, name in enumerate(re.findall(r"\b(?:a|b|left|right|theirs|mine)\.exr\b", line)):
        if " ball " in line:
            turn = sm.rotation(90 * k, 0, 0)
            photo = sm.ball.render(sky, "latlong", size=128, fov=24, distance=8, pose=turn)
            io.write(folder / name, photo.astype(np.float32))
        else:
            p = ("latlong", "octahedral")[k]
            io.write(folder / name, sm.convert(sky, "latlong", p, size=64), projection=p)
    if " views " in line or " stitch " in line:
        (folder / "panoramas").mkdir()
        for k in range(2):
            io.write(folder / "panoramas" / f"{k}.jpg", np.full((64, 128, 3), 99, np.uint8))
        io.write(folder / "raw.jpg", np.full((64, 128, 3), 99, np.uint8))
        rig = sm.cameras.rig(16, n=6)
        sm.cameras.write(rig, folder / "scene", format="colmap")
        for view in rig:
            place = folder / "scene" / "images" / view.name / "0001.png"
            place.parent.mkdir(parents=True)
            io.write(place, np.full((16, 16, 3), 99, np.uint8))
    if " batch " in line:
        (folder / "in" / "day").mkdir(parents=True)
        io.write(folder / "in" / "day" / "sky.exr", sky)
    for face in ("px", "nx", "py", "ny", "pz", "nz"):
        io.write(folder / f"sky_{face}.png", np.full((8, 8, 3), 99, np.uint8))
    if " video " in line:
        frames = [filming.rendered("latlong", (64, 128), k, "yuv420p") for k in range(3)]
        filming.film(folder / "in.mp4", frames, codec="libx264")
        sm.video.convert(folder / "in.mp4", folder / "sky.mp4", "latlong", "latlong", size=64)
        (folder / "turn.csv").write_text("0,0,0,0\n1,90,0,0\n")


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@some_fast("line", LINES, fast=SHORT)
def test_it_works_as_typed(line: str, tmp_path: Path) -> None:
    if " demo " in line:
        pytest.importorskip("matplotlib", reason="the demonstration draws with matplotlib")
    prepare(tmp_path, line)
    script = (
        f'set -e -o pipefail\nspheremap() {{ {shlex.quote(sys.executable)} -m spheremap "$@"; }}\n'
        f"display() {{ cat > displayed.png; }}\n{line}\n"
    )
    before = {place.name for place in tmp_path.iterdir()}
    # What opens a page finds a browser that shows nothing.
    surroundings = {**os.environ, "BROWSER": "true %s", "TMPDIR": str(tmp_path)}
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=tmp_path,
        env=surroundings,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    # It says or writes something.
    assert done.stdout or {place.name for place in tmp_path.iterdir()} > before
