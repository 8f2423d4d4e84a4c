"""Progress: on a terminal alone, of all that takes long, and no bit of a result depends on it."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from spheremap.cli import filling
from spheremap.cli.steps import Step
from terminals import needs_terminal, on_terminal
from test_cli import good, process, smooth


class Told(Step):
    """A step that remembers what it was told."""

    is_shown = True

    def __init__(self) -> None:
        self.parts: list[float] = []

    def part(self, fraction: float) -> None:
        self.parts.append(fraction)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32"])
@pytest.mark.parametrize("filter", ["bilinear", "area", "ewa"])
def test_a_watched_result_is_the_same(
    dtype: str, filter: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(filling, "_EVERY", 0.0)
    image = (smooth(sm.directions("latlong", 64)) * 30 + 60).astype(dtype)
    wanted = sm.convert(image, "latlong", "angular", size=48, filter=filter)
    out, step = np.empty_like(wanted), Told()
    with filling.watched(out, step):
        sm.convert(image, "latlong", "angular", size=48, filter=filter, out=out)
    assert out.tobytes() == wanted.tobytes()
    assert all(0 <= part <= 1 for part in step.parts)


def test_a_half_written_array_is_half_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filling, "_EVERY", 0.0)
    out, step = np.empty((100, 40, 3), np.float32), Told()
    with filling.watched(out, step):
        out[:50] = 1.0
        seen = len(step.parts)
        while len(step.parts) < seen + 2:
            time.sleep(0)
        half = step.parts[-1]
        out[50:] = 1.0
    # A thousand marks of 4000 texels, evenly; one may lie on the border.
    assert half == pytest.approx(0.5, abs=1e-3)


def test_nobody_looks_where_nothing_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filling, "Thread", None)
    out = np.zeros((4, 4, 3))
    with filling.watched(out, Step()):
        assert not out.any()


WORKS = {
    "convert": ["reading sky.exr", "converting sky.exr", "writing o.exr"],
    "info": ["reading sky.exr", "looking at its numbers", "adding up its light", "its sun"],
    "bake": ["reading sky.exr", "the diffuse cube", "reflections", "harmonics", "writing out"],
    "ball": ["reading", "joining", "writing o.exr"],
    "identify": ["reading sky.exr", "comparing"],
}


@needs_terminal
@pytest.mark.parametrize("command", WORKS)
def test_each_work_is_named_on_a_terminal_alone(command: str, tmp_path: Path) -> None:
    sky, out = tmp_path / "sky.exr", tmp_path / "o.exr"
    # More texels than `info` sums directly.
    io.write(sky, np.abs(smooth(sm.directions("latlong", 600))))
    arguments = {
        "convert": (sky, out, "--from", "latlong", "--to", "octahedral", "--size", 1024),
        "info": (sky,),
        "bake": (sky, tmp_path / "out", "--size", 16, "--samples", 16),
        "ball": (sky, "-o", out, "--rim", "600,300,290", "--distance", "inf", "--size", 64),
        "identify": (sky, sky),
    }[command]
    shown, said = on_terminal(command, *arguments, stream="stderr", columns=200)
    shown = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown)
    found = [shown.find(work) for work in WORKS[command]]
    assert -1 not in found and found == sorted(found), shown
    assert re.search(r"\d:\d\d:\d\d", shown)
    done = process(command, *arguments)
    assert (done.returncode, done.stderr) == (0, "")
    numbers = re.compile(r"[\d.]+ (m?s\b|\(\d+ Mtexel/s\))|\d+ Mtexel/s")
    assert numbers.sub("", done.stdout) == numbers.sub("", said.replace("\r", ""))


@needs_terminal
def test_a_failure_has_a_line_of_its_own_above_the_progress(tmp_path: Path) -> None:
    for name, shape in (("a.exr", (16, 32, 3)), ("b.exr", (30, 50, 3)), ("c.exr", (16, 32, 3))):
        io.write(tmp_path / name, np.ones(shape, np.float32))
    names = [tmp_path / f"{name}.exr" for name in "abc"]
    arguments = (*names, "--from", "latlong", "--to", "cube", "-o", tmp_path / "{stem}_o.exr")
    shown, said = on_terminal("convert", *arguments, stream="stderr", columns=300, code=1)
    lines = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown).replace("\r", "\n").splitlines()
    (line,) = (line for line in lines if "error: " in line)
    assert line.startswith("error: ") and line.endswith("takes it as it is")
    assert [line.split(":")[0] for line in said.splitlines()] == [
        str(tmp_path / "a_o.exr"), str(tmp_path / "c_o.exr")
    ]  # fmt: skip


def test_bake_makes_the_same_one_by_one(tmp_path: Path) -> None:
    image = np.abs(smooth(sm.directions("latlong", 32)))
    io.write(tmp_path / "a.exr", image)
    good("bake", tmp_path / "a.exr", tmp_path / "out", "--size", 8, "--samples", 8)
    sm.light.bake(image, "latlong", size=8, samples=8).write(tmp_path / "all")
    for place in sorted((tmp_path / "all").iterdir()):
        assert place.read_bytes() == (tmp_path / "out" / place.name).read_bytes(), place.name
