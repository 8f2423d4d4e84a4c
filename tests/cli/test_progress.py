"""Progress: on a terminal alone, of all that takes long, and no bit of a result depends on it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import _progress, io
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


def test_parts_of_parts_are_parts_of_the_whole() -> None:
    step = Told()
    with step.listening():
        with _progress.part(0, 0.5):
            _progress.done(0.5)
        with _progress.part(0.5, 1):
            for item in _progress.counted("abcd"):
                if item == "c":
                    break
            _progress.done(0.9)
        _progress.done(1)
    wanted = [0, 0, 0.25, 0.5, 0.5, 0.625, 0.75, 0.95, 1]
    assert step.parts == pytest.approx(wanted)  # to rounding
    # Nobody listens any more.
    _progress.done(0.3)
    assert len(step.parts) == 9


@pytest.mark.parametrize(
    "work",
    [
        pytest.param(
            lambda sky, k: sm.convert(sky, "latlong", "octahedral", size=750 * k, filter="area"),
            marks=pytest.mark.slow,
        ),
        lambda sky, k: sm.light.irradiance(sky, "latlong", "cube", size=24 * k),
        pytest.param(
            lambda sky, k: sm.light.prefilter_chain(sky, "latlong", "cube", size=64 * k),
            marks=pytest.mark.slow,
        ),
        pytest.param(lambda sky, k: sm.ball.render(sky, size=200 * k), marks=pytest.mark.slow),
    ],
    ids=["convert", "irradiance", "prefilter_chain", "render"],
)
def test_the_library_tells_how_far_it_is(work: Callable[[np.ndarray, int], object]) -> None:
    sky = np.abs(smooth(sm.directions("latlong", 600)))
    # Of one call of the core it is asked every 50 ms: as much work as this machine
    # cannot do in three of those.
    for larger in (2, 4, 8, 16):
        step = Told()
        with step.listening():
            told = work(sky, larger)
        if len(step.parts) > 3:
            break
    assert len(step.parts) > 3
    assert step.parts == sorted(step.parts) and step.parts[0] == 0 and step.parts[-1] <= 1
    plain = work(sky, larger)
    for a, b in zip(*(x if isinstance(x, list) else [x] for x in (told, plain)), strict=True):
        assert np.array_equal(a, b)


def test_who_is_told_may_end_a_call() -> None:
    class Enough(Exception):
        pass

    def tell(fraction: float) -> None:
        if fraction > 0:
            raise Enough

    sky = np.abs(smooth(sm.directions("latlong", 600)))
    with pytest.raises(Enough), _progress.told(tell):
        sm.light.irradiance(sky, "latlong", "cube", size=48)
    assert sm.light.mean(np.ones((4, 8)), "latlong") == pytest.approx(1)  # to rounding


WORKS = {
    "convert": ["reading sky.exr", "converting sky.exr", "writing o.exr"],
    "info": ["reading sky.exr", "looking at its numbers", "adding up its light"],
    "bake": ["reading sky.exr", "the diffuse cube", "reflections", "harmonics", "writing out"],
    "ball": ["reading", "joining", "writing o.exr"],
    "identify": ["reading sky.exr", "comparing"],
}


@needs_terminal
@some_fast("command", WORKS, fast=("convert",))
def test_each_work_is_named_on_a_terminal_alone(command: str, tmp_path: Path) -> None:
    sky, out = tmp_path / "sky.exr", tmp_path / "o.exr"
    # More texels than `info` sums directly.
    io.write(sky, np.abs(smooth(sm.directions("latlong", 750))))
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


# A work of each command that takes a while, and what it is called.
LONG = {
    "convert": (["sky.exr", "o.exr", "--from", "latlong", "--to", "octahedral", "--filter", "area"],
                "converting sky.exr"),
    "info": (["sky.exr"], ""),
    "bake": (["sky.exr", "out", "--diffuse", "--diffuse-size", 64], "the diffuse cube"),
    "ball": (["a.exr", "b.exr", "-o", "o.exr", "--size", 64, "--rim", "100,100,98",
              "--rim", "100,100,98", "--fov", 25], "joining"),
    "identify": (["sky.exr", "small.exr", "--b", "angular"], "comparing"),
}  # fmt: skip


@needs_terminal
@some_fast("command", LONG, fast=("identify",))
def test_how_much_is_done_and_how_long_it_takes_yet_is_shown(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    sky = np.abs(smooth(sm.directions("latlong", 1200)))
    # Sums are quick: a larger one, for a display that is drawn ten times a second, and any of them.
    io.write("sky.exr", sky.repeat(2, 0).repeat(2, 1) if command == "info" else sky)
    if command == "ball":
        for name, yaw in (("a.exr", 0), ("b.exr", 170)):
            pose = sm.rotation(yaw, 0, 0)
            io.write(name, sm.ball.render(sky, size=200, fov=25, distance=6, pose=pose))
    if command == "identify":
        io.write("small.exr", sm.convert(sky, "latlong", "angular", size=400))
    arguments, work = LONG[command]
    shown, _ = on_terminal(command, *arguments, stream="stderr", columns=200)
    lines = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown).replace("\r", "\n").splitlines()
    found = [re.search(r"(\d+)% (\d:\d\d:\d\d)", line) for line in lines if work in line]
    parts = [int(match[1]) for match in found if match]
    assert any(0 < part < 100 for part in parts), shown


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
